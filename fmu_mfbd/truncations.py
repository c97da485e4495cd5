"""Truncation errors of the reduced bodies of a build table at the film forces of a run.

They come from what the reduction saved, so that no finite elements are loaded after a run.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.symmetry import odd_part
from .build import Say, reduced_bodies
from .geometry.grid import film_rows
from .options import read_options
from .reduction.film_loads import on_rows, on_stations, recorded_film_thickness, recorded_loads
from .reduction.reduced_body import MissingShapes, ReducedBlock, ReducedPiston, load
from .reduction.truncation import Truncation, share_of_film, static_modes, truncation
from .thrust_symmetry import claims


class Truncations(NamedTuple):
    """Truncation errors of a run.

    Parameters
    ----------
    bodies : dict of str to Truncation
        Truncations of piston and block. A rigid body has none.
    share_of_film : float or None
        Eq. (J34) for all of them [-]; None if the run has not recorded the film thickness.
    odd_share : float or None
        Eq. (J49) [-]; None also if no body assumes a symmetric film.
    edge_error : float or None
        Largest missing share of the skirt's deflection under a narrow patch at its edges, Eq. (J47)
        [-]; None for a rigid piston.
    """

    bodies: dict[str, Truncation]
    share_of_film: float | None
    odd_share: float | None = None
    edge_error: float | None = None


def truncations(
    options: dict[str, Any], folder: Path, results: Path, progress: Say = print
) -> Truncations:
    """Return what the flexible bodies omit at the film forces of a run's last period.

    These are Eqs. (J17), (J34), and the odd part of the film with the missing deflection:

    Eq. (J49):  s = max |odd(h + e)| / max(h, h_0)      odd: Eq. (I14), e, h_0 of Eq. (J34)

    Parameters
    ----------
    options, folder, progress
        As for `offline.reduce`; both bodies.
    results : Path
        Results file that has recorded the nodal forces and the film thickness.

    Raises
    ------
    BadInput
        As `offline.reduce`.
    ValueError
        Why nothing can be said: forces not recorded, or only once, or on another grid; or a body
        that was reduced without Eq. (J16).
    """
    build = read_options(options, folder)
    if not any(body.modes and not body.rigid for body in (build.piston, build.block)):
        return Truncations({}, None)
    files = reduced_bodies(options, folder, progress)
    piston = load(ReducedPiston, files["piston"])
    block = load(ReducedBlock, files["block"])
    loads = recorded_loads(results, build.grid, last_period=True)
    if len(loads.film.pressure) < 2:
        raise ValueError("the last period has one recorded instant (record.every)")
    rows = film_rows(piston.skirt_lower, piston.skirt_upper, build.grid)
    shape = loads.film.pressure.shape
    by_body = {}
    edge_error = None
    gap = np.zeros(shape)
    if len(piston.omega):
        left = load(MissingShapes, files["piston"])
        by_body["piston"] = truncation(left, static_modes(piston), loads.film)
        edge_error = float(left.edge_errors.max())
        gap = gap + by_body["piston"].missing.reshape(shape)
    if len(block.omega):
        film = on_stations(loads, rows, block.heights)
        left = load(MissingShapes, files["block"])
        by_body["block"] = truncation(left, static_modes(block), film)
        table = by_body["block"].missing.reshape(film.pressure.shape)
        gap = gap + on_rows(table, loads.height_of_A, rows, block.heights)
    thickness = recorded_film_thickness(results, build.grid)
    if thickness is None:
        return Truncations(by_body, None, None, edge_error)
    thickness = thickness[-shape[0] :]
    odd = None
    if claims(build):
        film = np.isfinite(thickness)
        whole = np.where(film, thickness, 0.0) + gap
        odd = share_of_film(odd_part(whole, 1) * film, thickness)  # Eq. (J49)
    return Truncations(by_body, share_of_film(gap, thickness), odd, edge_error)
