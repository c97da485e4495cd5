"""Position of the extreme value of a film, and what the case states about a film."""

from dataclasses import dataclass

import numpy as np

from ..case.contract import interface
from ..fmi.quantities import to_si


@dataclass(frozen=True)
class CellPosition:
    """Cell in which a field takes its extreme value.

    side : the nearest mark of the axis, "" without marks; around, along : positions, with the
    labels and units of their axes; index : of the cell, (i, j).
    """

    side: str
    around: str
    around_label: str
    along: str
    along_label: str
    index: tuple[int, int]

    @property
    def clause(self) -> str:
        """Sentence that follows another one."""
        around = f"{self.around_label} {self.around}"
        where = f"on the {self.side} side, {around}" if self.side else f"at {around}"
        return f" It is {where}, {self.along_label} {self.along}."

    @property
    def brief(self) -> str:
        """Short form for tables."""
        side = f"{self.side} side, " if self.side else ""
        return f"{side}{self.around}, {self.along_label} {self.along}"


def highest_position(case, results, film) -> CellPosition | None:
    """Return the position of the highest pressure of a film; None if the run lacks it."""
    return _extreme_position(case, results, film, f"{film}.pressure", "maximum_pressure")


def thinnest_position(case, results, film) -> CellPosition | None:
    """Return the position of the minimum film thickness; None if the run lacks it."""
    return _extreme_position(case, results, film, gap_port(results, film), "minimum_film_thickness")


def gap_port(results, film) -> str:
    """Return the port that records the thickness of a film: its source, or else the film itself."""
    other = interface(results.case.get("wires", ()), film, "lubrication")
    return f"{other.owner}.{other.surface}film_thickness" if other else f"{film}.film_thickness"


def film_body(results, film) -> str | None:
    """Return the participant of the body of a film; None if no wire feeds its thickness."""
    other = interface(results.case.get("wires", ()), film, "lubrication")
    return other.owner if other else None


def film_surface(results, film) -> str:
    """Return the prefix of that body's surface, "" if the body has only one."""
    other = interface(results.case.get("wires", ()), film, "lubrication")
    return other.surface if other else ""


def parameter(results, owner, name: str, unit: str) -> float:
    """Return a parameter of a participant in the SI `unit`; 0 if the case does not set it."""
    parameters = results.case["participants"].get(owner, {}).get("parameters", {})
    return to_si(parameters[name], unit) if name in parameters else 0.0


def _extreme_position(case, results, film, port, extreme):
    """Return the cell whose envelope value is nearest to the extreme of a film's output.

    Bodies have a gap also outside the skirt, so the minimum of the film's output identifies the
    cell.
    """
    results = results.last
    envelope = results.envelope(port)
    if envelope is None or f"{film}.{extreme}" not in results.ports:
        return None
    values = results.series(f"{film}.{extreme}").values
    extreme_value = values.min() if envelope.kind == "min" else values.max()
    index = np.unravel_index(
        np.abs(envelope.values - extreme_value).argmin(), envelope.values.shape
    )
    return _cell_position(case.axes_of(f"{film}.pressure"), index, envelope.values.shape)


def _cell_position(axes, index, shape):
    """Return a cell with the labels of the case's axes."""
    i, j = map(int, index)
    cells_around, cells_along = shape
    around = float(axes.first.positions(cells_around)[i])
    along = float(axes.second.positions(cells_along)[j])
    low, high = axes.first.range
    turn = high - low
    marks = axes.first.marks
    distance = {word: abs((around - at + turn / 2) % turn - turn / 2) for word, at in marks.items()}
    return CellPosition(
        side=min(distance, key=lambda word: distance[word]) if distance else "",
        around=f"{around:.4g} {axes.first.unit}".strip(),
        around_label=axes.first.label,
        along=f"{along:.3g} {axes.second.unit}".strip(),
        along_label=axes.second.label,
        index=(i, j),
    )
