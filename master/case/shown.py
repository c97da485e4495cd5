"""Tables of a case file for pictures and axes of fields."""

import re
from typing import Literal

import numpy as np
from pydantic import (
    Field,
    field_validator,
    model_validator,
)

from ..fmi.quantities import is_angle, to_si
from .tables import TAKEN, FileName, Port, Table, reduced

ENVELOPE = "envelope"
"""Time of a picture of extreme values."""


class Picture(Table):
    """Picture of a run.

    `lines` plots `y` over `x`, one panel per entry. `map` shows `fields` at one instant, one panel
    each. `section` shows `fields` at one instant along their first index, within `angles` and at
    `height`.
    """

    file: FileName
    """Name of the PNG file in the output folder."""
    title: str
    """Title above the picture."""
    kind: Literal["lines", "map", "section"]
    """`lines` plots `y` over `x`. `map` shows `fields` at one instant. `section` shows them along
    their first index.
    """
    x: Port | Literal["time"] | None = None
    """Horizontal axis of `lines`: an output or "time"."""
    y: list[list[Port]] = []
    """Outputs of `lines`, one list per panel."""
    fields: list[Port] = []
    """Fields of `map` and `section`, one panel each."""
    time: str | None = None
    """Instant of `map` and `section`: a time, a crank angle, or the extreme of a scalar output such
    as "max bodies.side_force". The nearest recorded instant is shown. A `map` with "envelope" shows
    the extreme value of every cell over all macro steps of the last period.
    """
    angles: tuple[str, str] = ("0 deg", "360 deg")
    """Range of `section` around the circumference. A full revolution is 360 deg."""
    height: float = Field(0.5, ge=0, le=1)
    """Position of `section` along the second index, as a fraction of its length."""
    units: dict[str, str] = {}
    """Displayed units by "participant.variable"."""

    @field_validator("time")
    @classmethod
    def an_instant(cls, text):
        if text is None or text == ENVELOPE or is_angle(text):
            return text
        kind, port = reduced(text)
        if kind in ("min", "max") and re.fullmatch(r"\w+\.\S.*", port):
            return text
        try:
            to_si(text, "s")
        except ValueError:
            raise ValueError(
                f"expected a time, a crank angle or min|max participant.variable, got {text!r}; "
                "write for example '24 deg'"
            ) from None
        return text

    @field_validator("angles")
    @classmethod
    def in_degrees(cls, ends):
        for text in ends:
            to_si(text, "rad")
        return ends

    @property
    def marker(self) -> str:
        """Output whose smallest or largest value determines the instant; "" if there is none."""
        kind, port = reduced(self.time or "")
        return port if kind in ("min", "max") else ""

    @property
    def outputs(self) -> list[str]:
        """Scalar outputs of participants that the picture needs, without time and `coupling`."""
        ports = filter(None, (self.x, self.marker, *sum(self.y, [])))
        return [port for port in ports if port.partition(".")[0] not in TAKEN]

    @model_validator(mode="after")
    def complete(self):
        needed = ("x", "y") if self.kind == "lines" else ("fields", "time")
        missing = [key for key in needed if not getattr(self, key)]
        if missing:
            expected = " and ".join(missing)
            raise ValueError(f"expected {expected} in a picture of kind {self.kind!r}, got nothing")
        if self.time == ENVELOPE and self.kind != "map":
            raise ValueError(
                f"expected an instant in a picture of kind {self.kind!r}, got {self.time!r}"
            )
        return self


class Axis(Table):
    """Axis of one index of a field, from the start of the first cell to the end of the last.

    On a closed axis, `centred` shifts the range by at most half a cell.
    """

    label: str
    """Label of the axis."""
    unit: str = ""
    """Unit of the positions."""
    range: tuple[float, float] = (0.0, 1.0)
    """Positions of the start of the first cell and of the end of the last."""
    centred: float | None = None
    """Position of a cell centre on a closed axis."""
    length: Port | None = None
    """Parameter that holds a length. If set, `range` is relative to this length and shown in
    `unit`.
    """
    lower: str | None = None
    """Position at which `length` begins: a length, or a build option that holds it, such as
    "bodies.build.piston.skirt_lower". Default: 0.
    """
    marks: dict[str, float] = {}
    """Labels at positions along the axis."""

    @property
    def title(self) -> str:
        """Label and unit, as in a picture."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    @property
    def marked(self) -> str:
        """Title and marks, as a sentence."""
        marks = ", ".join(f"{word} {position:g}" for word, position in self.marks.items())
        return f"{self.title}; {marks}" if marks else self.title

    def ends(self, cells):
        """Return the start of the first cell and the end of the last, for a number of cells."""
        low, high = self.range
        if self.centred is None:
            return low, high
        before = cells * (self.centred - low) / (high - low)
        shift = (before % 1.0 - 0.5) * (high - low) / cells
        return low + shift, high + shift

    def positions(self, cells):
        """Return the centres of a number of cells."""
        low, high = self.ends(cells)
        return low + (np.arange(cells) + 0.5) / cells * (high - low)


class Axes(Table):
    """Axes of the fields of some participants. They are labels that no computation uses."""

    participants: list[str] = Field(min_length=1)
    """Participants whose fields have these axes: "PARTICIPANT", or "PARTICIPANT.SURFACE" for one of
    several film surfaces.
    """
    first: Axis = Axis(label="first index / its number")
    """Axis of the first index."""
    second: Axis = Axis(label="second index / its number")
    """Axis of the second index."""


NEUTRAL = Axes(participants=[""])
"""Axes of a field that the case does not describe."""
