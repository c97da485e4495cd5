"""Options of the lubrication FMU that are fixed when it is built."""

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, field_validator

from ..master.fmi.errors import BadInput, file_fault, unknown
from ..master.fmi.option_classes import validated, with_meanings
from ..master.fmi.quantities import to_si
from ..master.fmi.separated import read_rows
from ..master.fmi.symmetry import Symmetry, odd_part
from ..master.fmi.variables import Variable
from ..models import MODELS
from .laws.oil import Oil, vogel_constants
from .options import BuildOptions
from .parameters import CHOICES, has_image
from .variables import CONDITION_VARIABLES, OIL_VARIABLES, variables

FEWEST_CELLS, MOST_CELLS = 4, 1000  # cells along one side
POSSIBLE_INPUTS = [v.name for v in CONDITION_VARIABLES] + ["oil_temperature"]


class CaseOptions(BaseModel):
    """Build options of the lubrication FMU in a case file."""

    model_config = ConfigDict(extra="forbid", json_schema_extra=with_meanings)
    grid: tuple[int, int] = (40, 40)
    """Number of cells around and along the skirt or bearing."""
    surface: Literal["skirt", "bearing"] = "skirt"
    """Type of film surface. A skirt slides along its bore. A bearing slides around and along its
    shell.
    """
    inputs: list[str] = []
    """Conditions that are inputs instead of parameters."""
    oil: str | None = None
    """Name of an oil in the oil library. Its values become the start values of the oil parameters.
    """
    mask: str | list[list[int]] | None = None
    """Mask of the film: a CSV file relative to the case folder, or its rows, one per
    circumferential cell. 1: film, 0: opening. "none": film everywhere. Default: mask of the body's
    mesh.
    """

    @field_validator("grid")
    @classmethod
    def _size(cls, grid):
        if not all(FEWEST_CELLS <= n <= MOST_CELLS for n in grid):
            raise ValueError(
                f"expected {FEWEST_CELLS} to {MOST_CELLS} cells each, got {list(grid)}"
            )
        return grid

    @field_validator("inputs")
    @classmethod
    def _known(cls, names):
        for name in names:
            if name not in POSSIBLE_INPUTS:
                raise ValueError(unknown("input", name, POSSIBLE_INPUTS))
        return names


def options_schema() -> dict[str, Any]:
    """Return the JSON schema of the build options."""
    return CaseOptions.model_json_schema()


def declared_variables(options: Mapping[str, Any] | None, folder: Path) -> list[Variable]:
    """Return the variables of the FMU of these build options, or without options; nothing is built.

    Raises
    ------
    BadInput
        As `prepare`.
    """
    built = BuildOptions.read(prepare(options or {}, folder, lambda line: None)[0])
    return variables(built.grid, built.inputs, built.oil, built.surface)


def on_grid(options: Mapping[str, Any], key: str, grid: tuple[int, int]) -> dict[str, Any]:
    """Return a build table on the grid of a given body; `key` is the option with the grid."""
    return {**options, key: [*grid]}


def prepare(
    options: Mapping[str, Any], folder: Path, progress: Callable[[str], None]
) -> tuple[dict[str, Any], list[Path]]:
    """Check the build options and read oil and mask.

    The lubrication FMU needs no offline work.

    Parameters
    ----------
    options : mapping
        From the case file.
    folder : pathlib.Path
        Folder of the case.
    progress : callable
        Takes a line of text (unused).

    Returns
    -------
    options : dict
        Content of build.json, `options.BuildOptions`.
    files : list of pathlib.Path
        Empty.

    Raises
    ------
    BadInput
        With every fault: key, value, what is allowed.
    """
    chosen = validated(CaseOptions, options)
    faults = []
    oil = library_oil(chosen.oil, faults)
    mask = _mask(chosen, Path(folder), faults)
    if faults:
        raise BadInput(faults)
    built = BuildOptions(chosen.grid, tuple(chosen.inputs), oil, mask, chosen.surface)
    return built.written(), []


def symmetry(options: Mapping[str, Any], parameters: Mapping[str, Any], folder: Path) -> Symmetry:
    """Return the symmetry of a film about the thrust plane.

    A bearing is along the pin or the crank, so that its image has the other edge.

    Parameters
    ----------
    options, folder
        As for `prepare`.
    parameters : mapping
        Given values in SI.

    Raises
    ------
    BadInput
        As `prepare`.
    """
    built = BuildOptions.read(prepare(options, folder, lambda line: None)[0])
    reasons = []
    if built.mask is not None:
        mask = np.array(built.mask, dtype=float)
        bearing = built.surface == "bearing"
        odd = (mask - mask[:, ::-1]) / 2 if bearing else odd_part(mask)
        if cells := np.count_nonzero(odd):
            reasons.append(f"build.mask ({cells} cells differ from their mirror image)")
    if built.surface == "bearing":
        usual = {v.name: v.start for v in CONDITION_VARIABLES}
        for lower in (name for name in usual if name.endswith("_lower_edge")):
            upper = lower.replace("_lower_", "_upper_")
            pair = [parameters.get(name, usual[name]) for name in (lower, upper)]
            if pair[0] != pair[1]:
                reasons.append(f"parameters.{lower} (differs from {upper})")
            elif {lower, upper} & {*built.inputs}:
                reasons.append(f"build.inputs ({lower} may differ from {upper})")
    halves = has_image(built.grid, built.open_cells, built.surface)
    return Symmetry(reasons, can_halve=halves)


def library_oil(name: str | None, faults: list[str]) -> dict[str, float | str]:
    """Start values of the chosen oil in SI, {} without one."""
    if name is None:
        return {}
    library = _library()
    if name not in library:
        hint = "`piston-cosim keys oil` lists the oils"
        faults.append(f"oil: {unknown('oil', name, library, hint)}")
        return {}
    return oil_values(name, library[name], faults)


def _library() -> dict[str, Any]:
    """Return the tables of the shipped oils by name."""
    return tomllib.loads((MODELS / "oils.toml").read_text())


class LibraryOil(NamedTuple):
    """An oil of a library.

    Parameters
    ----------
    name, title, source : str
        The source is that of its viscosity.
    viscosity : tuple of float
        Dynamic viscosity at low shear at 40 and 100 degC [Pa s].
    """

    name: str
    title: str
    source: str
    viscosity: tuple[float, float]


def library_oils() -> list[LibraryOil]:
    """Return the oils that a film can select by `oil`; raise BadInput if the library has faults."""
    faults: list[str] = []
    oils = []
    for name, entry in _library().items():
        values: dict[str, Any] = oil_values(name, entry, faults)
        oil = Oil(**values)
        cold, hot = oil.low_shear_viscosity(np.array([313.15, 373.15]))
        sources = entry.get("sources", {})
        source = sources.get("points") or sources.get("viscosity_40") or sources["viscosity_law"]
        oils.append(LibraryOil(name, entry["title"], source, (float(cold), float(hot))))
    if faults:
        raise BadInput(faults)
    return oils


def oil_values(name: str, entry: Mapping[str, Any], faults: list[str]) -> dict[str, float | str]:
    """Start values of an oil's parameters in SI from its library entry.

    Parameters
    ----------
    name : str
        Name of the oil.
    entry : mapping
        Its table in the library.
    faults : list of str
        Every fault is appended.

    Returns
    -------
    dict
        Parameter -> float or str.
    """
    known = {v.name: v for v in OIL_VARIABLES}
    values: dict[str, float | str] = {}
    for key, value in entry.items():
        if key in ("title", "sources"):
            continue
        if key not in entry.get("sources", {}):
            faults.append(f"oil {name}.{key}: expected a source in sources, got nothing")
        try:
            if key == "points":
                temperatures = [to_si(temperature, "K") for temperature, _ in value]
                viscosities = [to_si(viscosity, "Pa.s") for _, viscosity in value]
                k, b, c = vogel_constants(viscosities, temperatures)
                values["vogel_viscosity"] = float(k)
                values["vogel_b"] = float(b)
                values["vogel_c"] = float(c)
            elif key in CHOICES:
                values[key] = value
            elif key in known:
                values[key] = to_si(value, known[key].unit)
            else:
                faults.append(f"oil {name}: {unknown('parameter', key, known)}")
        except (ValueError, IndexError, TypeError) as error:
            message = str(error) if "expected" in str(error) else f"expected pairs, got {value!r}"
            faults.append(f"oil {name}.{key}: {message}")
    for key, value in values.items():
        if fault := known[key].fault(value):
            faults.append(f"oil {name}.{fault}")
    return values


def _mask(chosen: CaseOptions, folder: Path, faults: list[str]) -> list[list[int]] | None:
    """Return the rows of the mask, None without a mask."""
    if chosen.mask is None or chosen.mask == "none":
        return None
    shown = f"mask: {chosen.mask}" if isinstance(chosen.mask, str) else "mask"
    try:
        mask = np.array(
            [cells for _, cells in read_rows(folder / chosen.mask)]
            if isinstance(chosen.mask, str)
            else chosen.mask,
            dtype=float,
            ndmin=2,
        )
    except OSError as error:
        faults.append(f"mask: {file_fault(str(chosen.mask), error)}")
        return None
    except ValueError:
        faults.append(f"{shown}: expected rows of 0 and 1, got other text")
        return None
    if mask.shape != chosen.grid:
        shape = " x ".join(map(str, mask.shape))
        expected = " x ".join(map(str, chosen.grid))
        faults.append(f"{shown}: expected the grid's {expected} cells, got {shape}")
    elif not np.isin(mask, (0.0, 1.0)).all():
        faults.append(f"{shown}: expected 1 for film and 0 for opening, got other values")
    elif not mask.any():
        faults.append(f"{shown}: expected a film in at least one cell, got none")
    return mask.astype(int).tolist()
