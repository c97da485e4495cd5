"""What the reduced bodies of a build table leave out at the film forces of a run: read from what
the reduction kept, so that nothing of finite elements is loaded after a run.
"""

from pathlib import Path
from typing import Any

from .build import Say, reduced_bodies
from .geometry.grid import film_rows
from .options import read_options
from .reduction.film_loads import FilmLoads, on_stations, recorded_loads
from .reduction.reduced_body import Probes, ReducedBlock, ReducedBody, ReducedPiston, load
from .reduction.truncation import Truncation, static_modes, truncation


def truncations(
    options: dict[str, Any], folder: Path, results: Path, progress: Say = print
) -> dict[str, Truncation]:
    """Truncation error of the flexible bodies of a build table at the film forces of a run's last
    period, Eq. (J17).

    Parameters
    ----------
    options, folder, progress
        As for `offline.reduce`; both bodies.
    results : Path
        Results file that has recorded the nodal forces.

    Returns
    -------
    dict of str to Truncation
        Of piston and block; a rigid body has none.

    Raises
    ------
    BadInput
        As `offline.reduce`.
    ValueError
        Why nothing can be said: forces not recorded or on another grid, or a body that was reduced
        without its probes (Eq. (J16)).
    """
    build = read_options(options, folder)
    if not any(body.modes and not body.rigid for body in (build.piston, build.block)):
        return {}
    files = reduced_bodies(options, folder, progress)
    piston = load(ReducedPiston, files["piston"])
    block = load(ReducedBlock, files["block"])
    loads = recorded_loads(results, build.grid, last_period=True)
    rows = film_rows(piston.skirt_lower, piston.skirt_upper, build.grid)
    bodies: dict[str, tuple[ReducedBody, FilmLoads]] = {
        "piston": (piston, loads.film),
        "block": (block, on_stations(loads, rows, block.heights)),
    }
    return {
        name: truncation(load(Probes, files[name]), static_modes(body), film)
        for name, (body, film) in bodies.items()
        if len(body.omega)
    }
