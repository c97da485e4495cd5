"""Position of the extreme value of a film: side, angle and height."""

from dataclasses import dataclass

import numpy as np

from ..case.contract import interface
from ..results.instants import told


@dataclass(frozen=True)
class Place:
    """A cell of a recorded field at a recorded instant.

    instant : in words; side : the mark of the axis that is nearest, "" without marks;
    around, along : positions, with their axes' labels and units; index : of the cell, (i, j);
    row : number of the instant.
    """

    instant: str
    side: str
    around: str
    around_label: str
    along: str
    along_label: str
    index: tuple[int, int]
    row: int

    @property
    def clause(self) -> str:
        """Sentence that follows another one."""
        side = f"{self.side} side, " if self.side else ""
        return (
            f" The extreme of the recorded fields is at {self.instant}, {side}"
            f"{self.around_label} {self.around}, {self.along_label} {self.along}."
        )

    @property
    def brief(self) -> str:
        """Short form for tables."""
        side = f"{self.side} side, " if self.side else ""
        return f"{side}{self.around}, height {self.along}"


def worst_place(case, results, port, lowest) -> Place | None:
    """Where a recorded field has its smallest or largest value; None where it was not recorded."""
    if port not in results.recorded:
        return None
    values = results.dataset(port)[:]
    at = values.argmin() if lowest else values.argmax()
    row, i, j = np.unravel_index(at, values.shape)
    return _place(case, results, port, int(row), (int(i), int(j)), values.shape)


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


def thinnest_place(case, results, film) -> Place | None:
    """Where the film of participant `film` is thinnest, of the instants of the recorded fields.

    Bodies give a gap also where there is no skirt; the film's own smallest value tells which cell
    it is.
    """
    port = gap_port(results, film)
    smallest = f"{film}.minimum_film_thickness"
    if port not in results.recorded or smallest not in results.ports:
        return None
    rows = np.searchsorted(results.time, results.instants - 1e-12)
    own = results.series(smallest).values[rows]
    if not own.size:
        return None
    row = int(own.argmin())
    gap = results.dataset(port)[row]
    i, j = np.unravel_index(np.abs(gap - own[row]).argmin(), gap.shape)
    shape = (len(rows), *gap.shape)
    return _place(case, results, port, row, (int(i), int(j)), shape)


def _place(case, results, port, row, index, shape):
    """A cell in the words of the case's axes."""
    axes = case.axes_of(port)
    i, j = index
    _, cells_around, cells_along = shape
    around = float(axes.first.positions(cells_around)[i])
    along = float(axes.second.positions(cells_along)[j])
    low, high = axes.first.range
    turn = high - low
    marks = axes.first.marks
    apart = {word: abs((around - at + turn / 2) % turn - turn / 2) for word, at in marks.items()}
    return Place(
        instant=told(results, results.instants[row]),
        side=min(apart, key=lambda word: apart[word]) if apart else "",
        around=f"{around:.4g} {axes.first.unit}".strip(),
        around_label=axes.first.label,
        along=f"{along:.3g} {axes.second.unit}".strip(),
        along_label=axes.second.label,
        index=index,
        row=row,
    )
