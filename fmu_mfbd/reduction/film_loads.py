"""Film forces on the bodies in a finished run, from its results file."""

import hashlib
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..geometry.pin import CRANK_SURFACES, PIN_SURFACES

FORCES = ("nodal_pressure_force", "nodal_friction_force")
"""Fields that must be recorded: outputs of the film."""
HEIGHT = "piston_position"
"""Scalar output of the bodies: height of A above the crank axis [m]."""
FILM_THICKNESS = "film_thickness"
"""Output of the bodies for each film on the skirt [m]."""


class NotRecorded(ValueError):
    """Error for a results file without the film forces on the bodies."""


class FilmLoads(NamedTuple):
    """Forces on a grid at m instants.

    Parameters
    ----------
    pressure, friction : ndarray, shape (m, c, a)
        Force that separates the surfaces, and force along y on the skirt [N].
    """

    pressure: np.ndarray
    friction: np.ndarray


class RecordedLoads(NamedTuple):
    """Forces of the film on its grid at the instants of a results file.

    Parameters
    ----------
    film : FilmLoads
        Forces on c x a cells.
    height_of_A : ndarray, shape (m,)
        Height above the crank axis [m].
    """

    film: FilmLoads
    height_of_A: np.ndarray


class Training(NamedTuple):
    """Forces for the basis `trained`.

    Parameters
    ----------
    loads : RecordedLoads
    rows : ndarray, shape (a,)
        Heights of the grid rows above A [m], for the block.
    """

    loads: RecordedLoads
    rows: np.ndarray

    def digest(self) -> str:
        """Return the SHA-256 of all numbers."""
        digest = hashlib.sha256()
        for array in (*self.loads.film, self.loads.height_of_A, self.rows):
            digest.update(str(array.shape).encode() + np.ascontiguousarray(array).data)
        return digest.hexdigest()


def recorded_loads(
    path: Path | str, grid: tuple[int, int], last_period: bool = False
) -> RecordedLoads:
    """Return the recorded nodal forces of all films on the skirt's grid.

    The wires and the build table in the case of the run determine the films on the skirt and their
    rows. Rows without a film have no forces. Without such wires, the forces are those of the only
    participant that has recorded forces.

    Parameters
    ----------
    path : Path
        Results file of `master.runs.recorder`. The case must list the nodal forces in
        record.fields.
    grid : (int, int)
        Expected film grid.
    last_period : bool
        Whether only the instants of the run's last period are read.

    Raises
    ------
    NotRecorded
        If the file lacks the forces, or has them on another grid or for several bodies.
    """
    import h5py  # slow to import, and used after runs alone

    path = Path(path)
    try:
        with h5py.File(path, "r") as opened:
            file: Any = opened
            pressure, friction = (_recorded(file, name, path, grid) for name in FORCES)
            height = _named(file, HEIGHT, path)
            if pressure is None or friction is None or height is None:
                raise NotRecorded(
                    f"{path.name} has not recorded {FORCES[0]} and {FORCES[1]}: the case must name "
                    "both in record.fields"
                )
            instants = file["fields/time"][:]
            begin = file.attrs.get("last_period", 0.0) if last_period else instants[0]
            first = int(np.searchsorted(instants, begin - 1e-9 * instants[-1]))
            at = np.interp(instants, file["time"][:], height[:])[first:]
            return RecordedLoads(FilmLoads(pressure[first:], friction[first:]), at)
    except (OSError, KeyError) as error:
        raise NotRecorded(f"{path.name} is no results file of a run: {error}") from None


def recorded_film_thickness(path: Path | str, grid: tuple[int, int]) -> np.ndarray | None:
    """Return the recorded film thickness on the skirt's grid, (m, c, a) [m].

    Rows without a film have inf. The result is None if a part is not recorded. Arguments are those
    of `recorded_loads`.
    """
    import h5py  # slow to import, and used after runs alone

    with h5py.File(path, "r") as file:
        return _recorded(file, FILM_THICKNESS, Path(path), grid, np.inf)


class HeightBand(NamedTuple):
    """Film on some rows of the grid.

    Parameters
    ----------
    rows : slice
    source, owner : str
        Recorded field of the force, and beginning of the names of the body's own fields.
    """

    rows: slice
    source: str
    owner: str


def _recorded(
    file: Any, name: str, path: Path, grid: tuple[int, int], empty: float = 0.0
) -> np.ndarray | None:
    """Return a field on the whole grid, (m, c, a), None if a part is not recorded.

    empty : value of rows without a film.
    """
    force = name if name in FORCES else FORCES[0]
    bands = _bands(json.loads(file.attrs.get("case", "{}")), force, path)
    fields = file["fields"]
    if not bands:
        field = _named(fields, name, path)
        return None if field is None else _shaped(field[:], grid, path)
    whole = np.full((len(fields["time"]), *grid), empty)
    for band in bands:
        dataset = fields.get(band.source if name == force else band.owner + name)
        if dataset is None:
            return None
        rows = whole[:, :, band.rows]
        rows[:] = _shaped(dataset[:], rows.shape[1:], path)
    return whole


def _shaped(force: np.ndarray, shape: tuple[int, int], path: Path) -> np.ndarray:
    """Return the force, or raise NotRecorded if it has another shape."""
    if force.shape[1:] != tuple(shape):
        raise NotRecorded(
            f"{path.name} has recorded nodal forces of shape {force.shape[1:]}, the "
            f"film grid is {tuple(shape)}"
        )
    return force


def _bands(case: dict[str, Any], name: str, path: Path) -> list[HeightBand]:
    """Return the sources of a force on the skirt by the wires of a case, without pin and crank."""
    wires = [(*wire["to"].split(".", 1), wire["from"]) for wire in case.get("wires", ())]
    ours = [
        (owner, variable.removesuffix(name), source)
        for owner, variable, source in wires
        if variable == name or variable.endswith(f".{name}")
    ]
    on_pin = {f"{name}." for name in (*PIN_SURFACES, *CRANK_SURFACES)}
    ours = [one for one in ours if one[1] not in on_pin]
    owners = sorted({owner for owner, _, _ in ours})
    if len(owners) > 1:
        raise NotRecorded(
            f"{path.name} has {name} on {' and '.join(owners)}: of one piston it can be said, not "
            "of several"
        )
    bands = []
    for owner, prefix, source in ours:
        build = case["participants"][owner].get("build", {})
        rows = {f"{one['name']}.": one["rows"] for one in build.get("film_surfaces", ())}
        first, last = rows.get(prefix, (1, None))
        field = source.replace(".", "/", 1)
        bands.append(HeightBand(slice(first - 1, last), field, f"{owner}/{prefix}"))
    return bands


def _named(group: Any, name: str, path: Path) -> Any:
    """Return the dataset of a participant's variable, None if there is none."""
    loads = {
        owner: member[name]
        for owner, member in group.items()
        if owner != "fields" and hasattr(member, "keys") and name in member
    }
    if len(loads) > 1:
        raise NotRecorded(
            f"{path.name} has {name} of {', '.join(loads)}, and its case has no wire that tells "
            "which of them acts on the skirt"
        )
    return next(iter(loads.values()), None)


def on_stations(loads: RecordedLoads, rows: np.ndarray, stations: np.ndarray) -> FilmLoads:
    """Return the forces at the stations of the bore's table, (m, c, s), by virtual work.

    Eq. (J15):  t = S(Y_A + y')^T f      S: natural cubic spline through the stations

    Parameters
    ----------
    loads : RecordedLoads
    rows : ndarray, shape (a,)
        Heights of the grid rows above A [m].
    stations : ndarray, shape (s,)
        Above the crank axis [m].
    """
    reading = spline_matrix(loads.height_of_A, rows, stations)
    # Eq. (J15)
    return FilmLoads(
        *(np.einsum("mca,mas->mcs", force, reading, optimize=True) for force in loads.film)
    )


def on_rows(
    table: np.ndarray, height_of_A: np.ndarray, rows: np.ndarray, stations: np.ndarray
) -> np.ndarray:
    """Return values of the bore's table, (m, c, s), at the film's rows, (m, c, a).

    The spline is that of Eq. (J15).
    """
    reading = spline_matrix(height_of_A, rows, stations)
    return np.einsum("mcs,mas->mca", table, reading, optimize=True)


def spline_matrix(height_of_A: np.ndarray, rows: np.ndarray, stations: np.ndarray) -> np.ndarray:
    """Return S(Y_A + y') of Eq. (J15), (m, a, s); arguments as of `on_stations`."""
    from scipy.interpolate import CubicSpline  # slow to import, and used after runs alone

    spline = CubicSpline(stations, np.eye(len(stations)), bc_type="natural")
    return spline(height_of_A[:, None] + rows)
