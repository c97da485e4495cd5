"""Table of modes, mode shapes, and recovered displacement and stress as VTU files."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..finite_elements.element import CORNERS, corner_stress, nodal_stress, von_mises
from ..geometry.grid import cell_centres
from .reduced_body import Anatomy, ReducedBody


class ModeRow(NamedTuple):
    """Mode of a reduced body.

    Parameters
    ----------
    number : int
        Number from 1, by ascending frequency.
    frequency : float
        [Hz]
    modal_mass : float
        [kg]
    film_share : float
        Part of the effect of all modes on the film thickness [-].
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
        """Name of the symmetry class."""
        return CLASSES[self.kind]


CLASSES = {-1: "", 0: "even in x and z", 1: "odd in z", 2: "odd in x", 3: "odd in x and z"}
"""Names of the symmetry classes of modes (`symmetry`)."""


class StressPeak(NamedTuple):
    """Largest equivalent stress of a body.

    Parameters
    ----------
    value : float
        Equivalent of the mean stress of the elements at a corner [Pa].
    position : ndarray, shape (3,)
        Position from the body's origin [m].
    jump : float
        Range of the elements' values at the corner [Pa], which decreases with the element size.
    """

    value: float
    position: np.ndarray
    jump: float


class RecoveredFields(NamedTuple):
    """Fields on a body's mesh.

    Parameters
    ----------
    displacement : ndarray, shape (n, 3)
        [m]
    stress : ndarray, shape (n, 6), or None
        xx, yy, zz, xy, yz, zx [Pa]; None for a body of matrices, which has no material.
    peak : StressPeak or None
    """

    displacement: np.ndarray
    stress: np.ndarray | None
    peak: StressPeak | None


def mode_table(body: ReducedBody, angles: int) -> list[ModeRow]:
    """Return a row for each mode.

    Eq. (J10):  modal mass = 1/max(phi)^2 over the film surface
    Eq. (J11):  share_k ~ rms(phi_k) |phi_k . p|/omega_k^2, mean over patches p, sum over k is 1

    The share is the static effect of the mode on film thickness under pressure patches on the
    thrust and anti-thrust side.

    Parameters
    ----------
    body : ReducedPiston or ReducedBlock
    angles : int
        Number of angles of the film grid.
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
    """Return smooth pressure patches on both thrust faces at three heights, (6, angles, rows)."""
    theta, height = cell_centres(angles, rows, 0.0, 1.0)
    around = [np.maximum(0.0, np.sin(sign * theta)) ** 4 for sign in (1, -1)]
    along = [np.exp(-(((height - middle) / 0.2) ** 2)) for middle in (0.25, 0.5, 0.75)]
    return np.array([np.outer(a, b) for a in around for b in along])


def write_modes(anatomy: Anatomy, path: Path | str) -> None:
    """Write all mode shapes as point data `mode 1`, `mode 2`, ... of one VTU file."""
    shapes = np.moveaxis(anatomy.shapes, -1, 0)
    _write(path, anatomy, {f"mode {k}": shape for k, shape in enumerate(shapes, 1)})


def recover(
    anatomy: Anatomy, modal_coordinate: np.ndarray, path: Path | str | None = None
) -> RecoveredFields:
    """Return displacement and stress of a body at an instant, and write them to a VTU file.

    Eq. (J12):  u = Phi q

    Parameters
    ----------
    anatomy : Anatomy
    modal_coordinate : ndarray, shape (k,)
        Modal coordinates of this body at the instant [kg^1/2 m].
    path : Path, optional
        Path of the file; default: no file.
    """
    displacement = anatomy.shapes @ modal_coordinate  # Eq. (J12)
    fields = {"displacement": displacement}
    stress = peak = None
    if len(anatomy.tets) and np.isfinite(anatomy.young).all():
        in_elements = corner_stress(
            anatomy.points, anatomy.tets, displacement, anatomy.young, anatomy.poisson
        )
        stress = nodal_stress(anatomy.tets, in_elements, anatomy.young)
        peak = stress_peak(anatomy, in_elements, stress)
        fields |= {"stress": stress, "von_mises": von_mises(stress)}
    if path is not None:
        _write(path, anatomy, fields)
    return RecoveredFields(displacement, stress, peak)


def stress_peak(anatomy: Anatomy, in_elements: np.ndarray, stress: np.ndarray) -> StressPeak:
    """Return the largest equivalent stress from `corner_stress` and `nodal_stress`."""
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
