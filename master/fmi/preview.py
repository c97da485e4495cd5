"""Preview of a participant before its FMU is built: figures, messages, a picture."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple


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


class Message(NamedTuple):
    """Message of a check.

    A fault rejects the case. A warning is likely an error of the user. A remark states an
    assumption.
    """

    kind: Literal["fault", "warning", "remark"]
    text: str


@dataclass(frozen=True)
class Preview:
    """Figures and messages of a participant before a run.

    faults, warnings, remarks : texts of messages, see `Message`; draw : writes a picture of the
    geometry, None if there is none.
    """

    figures: list[Figure] = field(default_factory=list[Figure])
    faults: list[str] = field(default_factory=list[str])
    warnings: list[str] = field(default_factory=list[str])
    remarks: list[str] = field(default_factory=list[str])
    draw: Callable[[Path], None] | None = None

    def figure(self, name: str) -> Figure | None:
        """Return the figure of a name, None if there is none."""
        return next((one for one in self.figures if one.name == name), None)
