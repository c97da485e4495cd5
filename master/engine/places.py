"""Position of the extreme value of a film: side, angle and height."""

from dataclasses import dataclass

import numpy as np

from ..case.contract import interface


@dataclass(frozen=True)
class Place:
    """Cell in which a field takes its extreme value.

    side : the mark of the axis that is nearest, "" without marks; around, along : positions, with
    their axes' labels and units; index : of the cell, (i, j).
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


def highest_place(case, results, film) -> Place | None:
    """Return where the pressure of a film is highest; None if the run lacks it."""
    return _place_of(case, results, film, f"{film}.pressure", "maximum_pressure")


def thinnest_place(case, results, film) -> Place | None:
    """Return where a film is thinnest; None if the run lacks it."""
    return _place_of(case, results, film, gap_port(results, film), "minimum_film_thickness")


def gap_port(results, film) -> str:
    """The film thickness of participant `film`, as the side that gives it records it; that of the
    film itself where no wire brings it.
    """
    other = interface(results.case.get("wires", ()), film, "lubrication")
    return f"{other.owner}.{other.surface}film_thickness" if other else f"{film}.film_thickness"


def film_body(results, film) -> str | None:
    """Participant on whose body film `film` lies; None where no wire brings it its thickness."""
    other = interface(results.case.get("wires", ()), film, "lubrication")
    return other.owner if other else None


def film_surface(results, film) -> str:
    """Surface of that body, with a point behind it; "" of a body with one alone."""
    other = interface(results.case.get("wires", ()), film, "lubrication")
    return other.surface if other else ""


def _place_of(case, results, film, port, extreme):
    """Cell whose value in the envelope of a field is nearest to the extreme of a film's output.

    Bodies give a gap also where there is no skirt; the film's own smallest value tells which cell
    it is.
    """
    results = results.last
    envelope = results.envelope(port)
    if envelope is None or f"{film}.{extreme}" not in results.ports:
        return None
    values = results.series(f"{film}.{extreme}").values
    wanted = values.min() if envelope.kind == "min" else values.max()
    index = np.unravel_index(np.abs(envelope.values - wanted).argmin(), envelope.values.shape)
    return _place(case.axes_of(f"{film}.pressure"), index, envelope.values.shape)


def _place(axes, index, shape):
    """A cell in the words of the case's axes."""
    i, j = map(int, index)
    cells_around, cells_along = shape
    around = float(axes.first.positions(cells_around)[i])
    along = float(axes.second.positions(cells_along)[j])
    low, high = axes.first.range
    turn = high - low
    marks = axes.first.marks
    apart = {word: abs((around - at + turn / 2) % turn - turn / 2) for word, at in marks.items()}
    return Place(
        side=min(apart, key=lambda word: apart[word]) if apart else "",
        around=f"{around:.4g} {axes.first.unit}".strip(),
        around_label=axes.first.label,
        along=f"{along:.3g} {axes.second.unit}".strip(),
        along_label=axes.second.label,
        index=(i, j),
    )
