"""What a reduced body is made of: table of modes, mode shapes and recovered displacement and stress as VTU files."""

import numpy as np

from .finite_element import nodal_stress, von_mises


def mode_table(body):
    """One row a mode: number, frequency, modal mass, share in film thickness, symmetry class.

    Eq. (T1):  modal mass = 1/max(phi)^2 over the film surface;   share_k ~ rms(phi_k) |phi_k . p|/omega_k^2, mean over patches
               p, sum 1

    The share weighs what the mode adds to the film thickness, statically, under film-like patches on the thrust and the other
    side.

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
    share = np.sqrt((field**2).mean(axis=(0, 1))) * force / body["omega"] ** 2                                  # Eq. (T1)
    mass = 1.0 / np.abs(field).max(axis=(0, 1)) ** 2
    return [dict(mode=n + 1, frequency=float(body["omega"][n] / (2 * np.pi)), modal_mass=float(mass[n]),
                 film_share=float(share[n] / share.sum()),
                 kind=int(body["kind"][n])) for n in range(k)]


def film_patches(angles, rows):
    """Smooth pressure patches on both thrust faces at three heights, (6, angles, rows)."""
    theta = (np.arange(angles) + 0.5) * 2 * np.pi / angles
    height = (np.arange(rows) + 0.5) / rows
    around = [np.maximum(0.0, np.sin(sign * theta)) ** 4 for sign in (1, -1)]
    along = [np.exp(-(((height - middle) / 0.2) ** 2)) for middle in (0.25, 0.5, 0.75)]
    return np.array([np.outer(a, b) for a in around for b in along])


def write_modes(shapes, path):
    """All mode shapes of a body as point data `mode 1`, `mode 2`, ... of one VTU file.

    Parameters
    ----------
    shapes : mapping
        points, tets, shapes of the file beside the reduced body (`reduction.shapes_file`).
    path : Path
    """
    modes = shapes["shapes"]
    _write(path, shapes, {f"mode {k + 1}": modes[:, :, k] for k in range(modes.shape[2])})


def recover(shapes, modal_coordinate, young, poisson, path):
    """Displacement and stress of a body at an instant, on its mesh, as a VTU file.

    Eq. (T2):  u = Phi q

    Parameters
    ----------
    shapes : mapping
        As for `write_modes`.
    modal_coordinate : ndarray, shape (k,)
        Of this body at the instant [kg^1/2 m].
    young, poisson : float
        [Pa], [-]
    path : Path or None
        None: only return.

    Returns
    -------
    displacement, stress : ndarray, shapes (n, 3), (n, 6)
        [m]; xx, yy, zz, xy, yz, zx [Pa].
    """
    displacement = shapes["shapes"] @ modal_coordinate                                                          # Eq. (T2)
    stress = nodal_stress(shapes["points"], shapes["tets"], displacement, young, poisson)
    if path is not None:
        _write(path, shapes, {"displacement": displacement, "stress": stress, "von_mises": von_mises(stress)})
    return displacement, stress


def _write(path, shapes, point_data):
    import meshio

    meshio.write(path, meshio.Mesh(shapes["points"], [("tetra10", shapes["tets"])], point_data=point_data), file_format="vtu")
