"""Preview of a participant before its FMU is built: figures, faults, remarks, a picture."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Figure:
    """One figure of a preview.

    group : line of the output; name : as in `keys` if it is a key; value : in its SI unit; note
    : its source.
    """

    group: str
    name: str
    value: float
    unit: str
    note: str = ""


@dataclass(frozen=True)
class Preview:
    """Figures and faults of a participant before a run.

    faults : reasons to reject a run or to distrust it; remarks : points to check; draw : writes
    a picture of the geometry, None if there is none.
    """

    figures: list[Figure] = field(default_factory=list[Figure])
    faults: list[str] = field(default_factory=list[str])
    remarks: list[str] = field(default_factory=list[str])
    draw: Callable[[Path], None] | None = None

    def figure(self, name: str) -> Figure | None:
        """Return the figure of a name, None if there is none."""
        return next((one for one in self.figures if one.name == name), None)
