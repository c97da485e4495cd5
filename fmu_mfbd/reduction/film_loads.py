"""What a film has done to the bodies in a finished run, read from its results file."""

import hashlib
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..geometry.pin import CRANK_SURFACES, PIN_SURFACES

FORCES = ("nodal_pressure_force", "nodal_friction_force")
"""Fields that have to be recorded: outputs of the interface contract's film."""
HEIGHT = "piston_position"
"""Scalar output of the bodies: height of A above the crank axis [m]."""


FILM_THICKNESS = "film_thickness"
"""Output of the bodies for each film on the skirt [m]."""


class NotRecorded(ValueError):
    """A results file that does not say what the film did to the bodies."""


class FilmLoads(NamedTuple):
    """Forces on a grid at m instants.

    Parameters
    ----------
    pressure, friction : ndarray, shape (m, c, a)
        Pushing the surfaces apart; along y on the skirt [N].
    """

    pressure: np.ndarray
    friction: np.ndarray


class RecordedLoads(NamedTuple):
    """Forces of the film on its grid at the instants of a results file.

    Parameters
    ----------
    film : FilmLoads
        On c x a cells.
    height_of_A : ndarray, shape (m,)
        Above the crank axis [m].
    """

    film: FilmLoads
    height_of_A: np.ndarray


class Training(NamedTuple):
    """Forces that a body is trained on.

    Parameters
    ----------
    loads : RecordedLoads
    rows : ndarray, shape (a,)
        Heights of the grid rows above A [m]; a piston knows them itself.
    """

    loads: RecordedLoads
    rows: np.ndarray

    def digest(self) -> str:
        """Of all its numbers."""
        digest = hashlib.sha256()
        for array in (*self.loads.film, self.loads.height_of_A, self.rows):
            digest.update(str(array.shape).encode() + np.ascontiguousarray(array).data)
        return digest.hexdigest()


def recorded_loads(
    path: Path | str, grid: tuple[int, int], last_period: bool = False
) -> RecordedLoads:
    """Nodal forces that a run has recorded, of all films on the skirt's grid.

    Which films press on the skirt, and on which of its rows, the wires and the build table in the
    run's case tell; rows without a film have no forces. Of a file that names no such wires it is
    the one participant that has recorded forces.

    Parameters
    ----------
    path : Path
        Results file (`master.runs.recorder` says how it is laid out) whose case names the nodal
        forces in record.fields.
    grid : (int, int)
        Film grid that is wanted.
    last_period : bool
        Whether only the instants of the run's last period are read.

    Raises
    ------
    NotRecorded
        If the file lacks them, has them on another grid, or of several bodies.
    """
    import h5py  # slow to import, and used after runs alone

    path = Path(path)
    try:
        with h5py.File(path, "r") as opened:
            file: Any = opened
            pressure, friction = (_force(file, name, path, grid) for name in FORCES)
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
    """Return the film thickness that a run has recorded on the skirt's grid, (m, c, a) [m].

    Rows without a film have inf. The result is None if not all of it was recorded. Arguments as of
    `recorded_loads`, which finds the films in the same way.
    """
    import h5py  # slow to import, and used after runs alone

    path = Path(path)
    with h5py.File(path, "r") as opened:
        file: Any = opened
        fields = file["fields"]
        bands = _bands(json.loads(file.attrs.get("case", "{}")), FORCES[0], path)
        if not bands:
            thickness = _named(fields, FILM_THICKNESS, path)
            return None if thickness is None else _shaped(thickness[:], grid, path)
        whole = np.full((len(fields["time"]), *grid), np.inf)
        for band in bands:
            owner, prefix = band.skirt
            if f"{owner}/{prefix}{FILM_THICKNESS}" not in fields:
                return None
            rows = whole[:, :, band.first : band.last]
            dataset = fields[f"{owner}/{prefix}{FILM_THICKNESS}"]
            rows[:] = _shaped(dataset[:], rows.shape[1:], path)
        return whole


class HeightBand(NamedTuple):
    """Where a force on some rows of the grid is recorded: port, the participant and prefix of the
    film surface, and rows from 0 on (`last` is not among them; None: up to the grid's end).
    """

    port: str
    skirt: tuple[str, str]
    first: int
    last: int | None


def _force(file: Any, name: str, path: Path, grid: tuple[int, int]) -> np.ndarray | None:
    """A nodal force on the whole grid, (m, c, a); None if not all of it was recorded."""
    bands = _bands(json.loads(file.attrs.get("case", "{}")), name, path)
    fields = file["fields"]
    if not bands:
        found = _named(fields, name, path)
        return None if found is None else _shaped(found[:], grid, path)
    whole = np.zeros((len(fields["time"]), *grid))
    for band in bands:
        dataset = fields.get(band.port.replace(".", "/", 1))
        if dataset is None:
            return None
        around, along = grid
        last = along if band.last is None else band.last
        whole[:, :, band.first : last] = _shaped(dataset[:], (around, last - band.first), path)
    return whole


def _shaped(force: np.ndarray, shape: tuple[int, int], path: Path) -> np.ndarray:
    """The force; NotRecorded if it has another shape."""
    if force.shape[1:] != tuple(shape):
        raise NotRecorded(
            f"{path.name} has recorded nodal forces of shape {force.shape[1:]}, the "
            f"film grid is {tuple(shape)}"
        )
    return force


def _bands(case: dict[str, Any], name: str, path: Path) -> list[HeightBand]:
    """Whence the wires of a run's case bring a force to the skirt; films of a floating pin
    and of the crank have no part in it.
    """
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
        bands.append(HeightBand(source, (owner, prefix), first - 1, last))
    return bands


def _named(group: Any, name: str, path: Path) -> Any:
    """The dataset of a participant's variable; None if there is none."""
    found = {
        owner: member[name]
        for owner, member in group.items()
        if owner != "fields" and hasattr(member, "keys") and name in member
    }
    if len(found) > 1:
        raise NotRecorded(
            f"{path.name} has {name} of {', '.join(found)}, and its case has no wire that tells "
            "which of them acts on the skirt"
        )
    return next(iter(found.values()), None)


def on_stations(loads: RecordedLoads, rows: np.ndarray, stations: np.ndarray) -> FilmLoads:
    """The same forces at the stations of the bore's table, (m, c, s), by virtual work.

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
    """Return values of the bore's table, (m, c, s), at the rows of the moving film, (m, c, a), by
    the same spline as Eq. (J15).
    """
    reading = spline_matrix(height_of_A, rows, stations)
    return np.einsum("mcs,mas->mca", table, reading, optimize=True)


def spline_matrix(height_of_A: np.ndarray, rows: np.ndarray, stations: np.ndarray) -> np.ndarray:
    """Return S(Y_A + y') of Eq. (J15), (m, a, s); arguments as of `on_stations`."""
    from scipy.interpolate import CubicSpline  # slow to import, and used after runs alone

    spline = CubicSpline(stations, np.eye(len(stations)), bc_type="natural")
    return spline(height_of_A[:, None] + rows)
