"""Values that a user passes to a film in Python: quantities with units, numbers in SI, arrays."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..master.fmi.errors import BadInput, unknown
from ..master.fmi.quantities import to_si
from ..master.fmi.variables import Variable
from .common.grid import Flags


def read(texts: Mapping[str, Any], known: Mapping[str, Variable], kind: str) -> dict[str, Any]:
    """Return values in SI by name.

    Parameters
    ----------
    texts : mapping
        Numbers or arrays in SI, or text with a unit.
    known : mapping
        Variables by name. One with a shape takes a value for all elements too.
    kind : str
        Name for the variables in the sentence on an unknown one.

    Raises
    ------
    BadInput
        With every value that is unknown, of another unit or shape, or out of its range.
    """
    values: dict[str, Any] = {}
    faults: list[str] = []
    for name, value in texts.items():
        variable = known.get(name)
        if variable is None:
            faults.append(f"{name}: {unknown(kind, name, known)}")
            continue
        try:
            values[name] = value if variable.choices else _in_si(value, variable)
        except ValueError as error:
            faults.append(f"{name}: {error}")
            continue
        ends = [value] if variable.choices else [np.min(values[name]), np.max(values[name])]
        faults += dict.fromkeys(filter(None, map(variable.fault, ends)))
    if faults:
        raise BadInput(faults)
    return values


def _in_si(value: Any, variable: Variable) -> Any:
    """Return a finite float or array in SI; raise ValueError if the value is none."""
    array = np.asarray(value, dtype=object if isinstance(value, (list, tuple)) else None)
    if array.dtype.kind not in "iuf":
        numbers = [_number(one, variable.unit) for one in array.ravel()]
        array = np.array(numbers).reshape(array.shape)
    if array.shape not in ((), variable.shape):
        expected = f"shape {variable.shape}" if variable.shape else "one number"
        raise ValueError(f"expected {expected}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("expected finite values, got others")
    if not variable.shape:
        return float(array)
    return np.ascontiguousarray(np.broadcast_to(array, variable.shape), dtype=float)


def _number(value: Any, unit: str) -> float:
    """Return a number, or a quantity as text, in SI; raise ValueError if the value is neither."""
    if isinstance(value, (int, float, np.number)) and not isinstance(value, bool):
        return float(value)
    return to_si(str(value) if isinstance(value, str) else value, unit)


def cells_of(grid: tuple[int, int]) -> tuple[int, int]:
    """Return the numbers of cells; raise BadInput unless they are two numbers."""
    if len(grid) != 2 or not all(isinstance(n, (int, np.integer)) and n >= 1 for n in grid):
        raise BadInput(f"grid: expected two numbers of cells, around and along, got {grid}")
    around, along = grid
    return int(around), int(along)


def openings_of(grid: tuple[int, int], open_cells: Flags | None) -> Flags | None:
    """Return the openings; raise BadInput if their shape differs, or if there is no film."""
    if open_cells is None:
        return None
    cells = np.asarray(open_cells, dtype=bool)
    if cells.shape != grid:
        raise BadInput(f"open_cells: expected shape {grid}, got {cells.shape}")
    if cells.all():
        raise BadInput("open_cells: expected a film in at least one cell, got none")
    return cells
