"""What a reduced body is made of: table of modes, mode shapes and recovered displacement and stress
as VTU files.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..finite_elements.element import CORNERS, corner_stress, nodal_stress, von_mises
from ..geometry.grid import cell_centres
from .reduced_body import Anatomy, MeshProperties, ReducedBody


class ModeRow(NamedTuple):
    """One mode of a reduced body.

    Parameters
    ----------
    number : int
        From 1, by rising frequency.
    frequency : float
        [Hz]
    modal_mass : float
        [kg]
    film_share : float
        Of what all modes add to the film thickness [-].
    kind : int
        Symmetry class.
    """

    number: int
    frequency: float
    modal_mass: float
    film_share: float
    kind: int

    @property
    def kind_in_words(self) -> str:
        """The symmetry class in words."""
        return CLASSES[self.kind]


CLASSES = {-1: "", 0: "even in x and z", 1: "odd in z", 2: "odd in x", 3: "odd in x and z"}
"""Words for the symmetry classes of modes (`symmetry`)."""


class MassProperties(NamedTuple):
    """Mass of a body [kg], its centre of mass from the body's origin, (3,) [m], and its inertia
    about that centre, (3, 3) [kg m2].
    """

    mass: float
    centre: np.ndarray
    inertia: np.ndarray


class StressPeak(NamedTuple):
    """Largest equivalent stress of a body.

    Parameters
    ----------
    value : float
        Of the mean stress of the elements that meet at a corner [Pa].
    position : ndarray, shape (3,)
        From the body's origin [m].
    jump : float
        Range of the elements' own values there [Pa]; it decreases with the size of the elements.
    """

    value: float
    position: np.ndarray
    jump: float


class Recovered(NamedTuple):
    """Fields on a body's mesh.

    Parameters
    ----------
    displacement : ndarray, shape (n, 3)
        [m]
    stress : ndarray, shape (n, 6), or None
        xx, yy, zz, xy, yz, zx [Pa]; none for a body of matrices, whose material is not known.
    peak : StressPeak or None
    """

    displacement: np.ndarray
    stress: np.ndarray | None
    peak: StressPeak | None


def mode_table(body: ReducedBody, angles: int) -> list[ModeRow]:
    """One row a mode.

    Eq. (J10):  modal mass = 1/max(phi)^2 over the film surface
    Eq. (J11):  share_k ~ rms(phi_k) |phi_k . p|/omega_k^2, mean over patches p, sum over k is 1

    The share weighs what the mode adds to the film thickness, statically, under film-like patches
    on the thrust and the other side.

    Parameters
    ----------
    body : ReducedPiston or ReducedBlock
    angles : int
        Of the film grid.
    """
    count = len(body.omega)
    field = body.radial.reshape(angles, -1, count)
    patches = film_patches(field.shape[0], field.shape[1])
    force = np.abs(np.einsum("pij,ijk->pk", patches, field, optimize=True)).mean(axis=0)
    share = np.sqrt((field**2).mean(axis=(0, 1))) * force / body.omega**2  # Eq. (J11)
    mass = 1.0 / np.abs(field).max(axis=(0, 1)) ** 2  # Eq. (J10)
    return [
        ModeRow(
            number=k + 1,
            frequency=float(body.omega[k] / (2 * np.pi)),
            modal_mass=float(mass[k]),
            film_share=float(share[k] / share.sum()),
            kind=int(body.kind[k]),
        )
        for k in range(count)
    ]


def film_patches(angles: int, rows: int) -> np.ndarray:
    """Smooth pressure patches on both thrust faces at three heights, (6, angles, rows)."""
    theta, height = cell_centres(angles, rows, 0.0, 1.0)
    around = [np.maximum(0.0, np.sin(sign * theta)) ** 4 for sign in (1, -1)]
    along = [np.exp(-(((height - middle) / 0.2) ** 2)) for middle in (0.25, 0.5, 0.75)]
    return np.array([np.outer(a, b) for a in around for b in along])


def write_modes(anatomy: Anatomy, path: Path | str) -> None:
    """All mode shapes of a reduced body as point data `mode 1`, `mode 2`, ... of one VTU file."""
    shapes = np.moveaxis(anatomy.shapes, -1, 0)
    _write(path, anatomy, {f"mode {k}": shape for k, shape in enumerate(shapes, 1)})


def recover(
    anatomy: Anatomy, modal_coordinate: np.ndarray, path: Path | str | None = None
) -> Recovered:
    """Displacement and stress of a body at an instant, on its mesh, as a VTU file.

    Eq. (J12):  u = Phi q

    Parameters
    ----------
    anatomy : Anatomy
    modal_coordinate : ndarray, shape (k,)
        Of this body at the instant [kg^1/2 m].
    path : Path, optional
        Of the file.
    """
    displacement = anatomy.shapes @ modal_coordinate  # Eq. (J12)
    fields = {"displacement": displacement}
    stress = peak = None
    if len(anatomy.tets) and np.isfinite(anatomy.young):
        in_elements = corner_stress(
            anatomy.points, anatomy.tets, displacement, anatomy.young, anatomy.poisson
        )
        stress = nodal_stress(anatomy.tets, in_elements)
        peak = stress_peak(anatomy, in_elements, stress)
        fields |= {"stress": stress, "von_mises": von_mises(stress)}
    if path is not None:
        _write(path, anatomy, fields)
    return Recovered(displacement, stress, peak)


def stress_peak(anatomy: Anatomy, in_elements: np.ndarray, stress: np.ndarray) -> StressPeak:
    """Largest equivalent stress of a body, from `corner_stress` and `nodal_stress`."""
    equivalent = von_mises(stress)
    corners = anatomy.tets[:, :CORNERS]
    node = corners.ravel()[np.argmax(equivalent[corners])]
    own = von_mises(in_elements[corners == node])
    return StressPeak(float(equivalent[node]), anatomy.points[node], float(np.ptp(own)))


def _write(path, anatomy, point_data):
    import meshio

    solid = len(anatomy.tets) > 0
    cells = ("tetra10", anatomy.tets) if solid else ("triangle", anatomy.skin)
    mesh = meshio.Mesh(anatomy.points, [cells], point_data=point_data)
    meshio.write(path, mesh, file_format="vtu")


def mass_properties(properties: MeshProperties) -> MassProperties:
    """Mass, centre of mass and inertia of a reduced piston (origin A) or block (origin on the crank
    axis).

    Eq. (J13):  rigid_mass = [m 1, -m [c]x; m [c]x, I_0],   I = I_0 + m [c]x [c]x
    """
    matrix = properties.rigid_mass
    mass = matrix[0, 0]
    moment = matrix[3:, :3]
    x, y, z = np.array([moment[2, 1], moment[0, 2], moment[1, 0]]) / mass
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    inertia = matrix[3:, 3:] + mass * cross @ cross  # Eq. (J13)
    return MassProperties(float(mass), np.array([x, y, z]), inertia)
