"""What a part says of a participant before its FMU is built: figures, faults, remarks, a
picture.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Figure:
    """One figure: name as in `keys` where there is one, value in its SI unit, and in words where it
    comes from; `group` is its line on the screen.
    """

    group: str
    name: str
    value: float
    unit: str
    note: str = ""


@dataclass(frozen=True)
class Preview:
    """What a part knows of a participant beforehand.

    faults : what a run would be refused for, or would be wrong by; remarks : what is worth a look;
    draw : writes a picture of the geometry, where there is one to draw.
    """

    figures: list[Figure] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    draw: Callable[[Path], None] | None = None

    def figure(self, name: str) -> Figure | None:
        """The figure of a name."""
        return next((one for one in self.figures if one.name == name), None)
