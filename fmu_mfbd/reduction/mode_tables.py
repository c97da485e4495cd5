"""What a reduced body is made of: table of modes, mode shapes and recovered displacement and stress
as VTU files.
"""

import numpy as np

from ..finite_elements.element import nodal_stress, von_mises


def mode_table(body):
    """One row a mode: number, frequency, modal mass, share in film thickness, symmetry class.

    Eq. (T1):  modal mass = 1/max(phi)^2 over the film surface;   share_k ~ rms(phi_k) |phi_k . p|/omega_k^2, mean over patches
               p, sum 1

    The share weighs what the mode adds to the film thickness, statically, under film-like patches
    on the thrust and the other side.

    Parameters
    ----------
    body : mapping of ndarray
        A reduced piston or block (`reduction`).

    Returns
    -------
    list of dict
        mode (from 1), frequency [Hz], modal_mass [kg], film_share [-], kind.
    """
    k = len(body["omega"])
    field = body["radial"].reshape(int(body["angles"]), -1, k)
    patches = film_patches(*field.shape[:2])
    force = np.abs(np.einsum("pij,ijk->pk", patches, field, optimize=True)).mean(axis=0)
    share = np.sqrt((field**2).mean(axis=(0, 1))) * force / body["omega"] ** 2  # Eq. (T1)
    mass = 1.0 / np.abs(field).max(axis=(0, 1)) ** 2
    return [
        dict(
            mode=n + 1,
            frequency=float(body["omega"][n] / (2 * np.pi)),
            modal_mass=float(mass[n]),
            film_share=float(share[n] / share.sum()),
            kind=int(body["kind"][n]),
        )
        for n in range(k)
    ]


def film_patches(angles, rows):
    """Smooth pressure patches on both thrust faces at three heights, (6, angles, rows)."""
    theta = (np.arange(angles) + 0.5) * 2 * np.pi / angles
    height = (np.arange(rows) + 0.5) / rows
    around = [np.maximum(0.0, np.sin(sign * theta)) ** 4 for sign in (1, -1)]
    along = [np.exp(-(((height - middle) / 0.2) ** 2)) for middle in (0.25, 0.5, 0.75)]
    return np.array([np.outer(a, b) for a in around for b in along])


def write_modes(body, path):
    """All mode shapes of a reduced body as point data `mode 1`, `mode 2`, ... of one VTU file."""
    modes = body["shapes"]
    _write(path, body, {f"mode {k + 1}": modes[:, :, k] for k in range(modes.shape[2])})


def recover(body, modal_coordinate, path=None):
    """Displacement and stress of a body at an instant, on its mesh, as a VTU file.

    Eq. (T2):  u = Phi q

    Parameters
    ----------
    body : mapping of ndarray
        A reduced piston or block (`reduction`).
    modal_coordinate : ndarray, shape (k,)
        Of this body at the instant [kg^1/2 m].
    path : Path, optional
        Of the file.

    Returns
    -------
    displacement : ndarray, shape (n, 3)
        [m]
    stress : ndarray, shape (n, 6), or None
        xx, yy, zz, xy, yz, zx [Pa]; none for a body of matrices, whose material is not known.
    """
    displacement, fields = body["shapes"] @ modal_coordinate, {}  # Eq. (T2)
    stress = None
    if len(body["tets"]) and np.isfinite(body["young"]):
        stress = nodal_stress(
            body["points"], body["tets"], displacement, float(body["young"]), float(body["poisson"])
        )
        fields = {"stress": stress, "von_mises": von_mises(stress)}
    if path is not None:
        _write(path, body, {"displacement": displacement} | fields)
    return displacement, stress


def _write(path, body, point_data):
    import meshio

    cells = ("tetra10", body["tets"]) if len(body["tets"]) else ("triangle", body["skin"])
    meshio.write(
        path, meshio.Mesh(body["points"], [cells], point_data=point_data), file_format="vtu"
    )


CLASSES = {-1: "", 0: "even in x and z", 1: "odd in z", 2: "odd in x", 3: "odd in x and z"}
"""Words for the symmetry classes of modes (`symmetry`)."""


def mass_properties(body):
    """Mass, centre of mass and inertia of a reduced body.

    Eq. (T3):  rigid_mass = [m 1, -m [c]x; m [c]x, I_0],   I = I_0 + m [c]x [c]x

    Parameters
    ----------
    body : mapping of ndarray
        A reduced piston (origin A) or block (origin on the crank axis).

    Returns
    -------
    mass : float
        [kg]
    centre : ndarray, shape (3,)
        From the origin [m].
    inertia : ndarray, shape (3, 3)
        About the centre of mass [kg m2].
    """
    matrix = body["rigid_mass"]
    mass, moment = matrix[0, 0], matrix[3:, :3]
    centre = np.array([moment[2, 1], moment[0, 2], moment[1, 0]]) / mass
    cross = np.array(
        [[0, -centre[2], centre[1]], [centre[2], 0, -centre[0]], [-centre[1], centre[0], 0]]
    )
    return float(mass), centre, matrix[3:, 3:] + mass * cross @ cross  # Eq. (T3)
