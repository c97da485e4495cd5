"""Maps of fields as data: colours, contours of the film, its rupture and marks at extremes.

`pictures` draws them with matplotlib, and templates/map.js on a page, both with `STYLE`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..case.shown import ENVELOPE, NEUTRAL, Axes
from .instants import instant, instant_text
from .words import labelled, name_of, scaled

STYLE: dict[str, Any] = {
    "ramps": {
        "pressure": ["#ffffff", "#fee090", "#fda048", "#de4933", "#890a42", "#35003c"],
        "thickness": ["#3c095c", "#205ca4", "#56aac4", "#bee0d6", "#f8f8f2"],
        "fraction": ["#f7f2e8", "#c9a86a", "#3b2a12"],
        "contact": ["#ffffff", "#f4b6c2", "#c51b7d", "#40004b"],
    },
    "rupture": 0.99,
}
"""Colours of each kind of field, lowest value first, and film fraction at which a film ruptures.

Other fields have the colours of viridis. Scales are linear.
"""
KINDS = {
    "pressure": "pressure",
    "film_thickness": "thickness",
    "film_fraction": "fraction",
    "asperity_pressure": "contact",
}
"""Kinds of fields by their names; other fields have the kind "field"."""
UNITS = {"Pa": "MPa", "m": "um"}
"""Default units of the other fields of a film, by their SI units."""
ROUND = ((1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 7), (1, 1.5, 2, 3, 5, 7), (1, 2, 5), (1, 3))
"""Digits of contours, from the closest choice to the widest."""
MOST_CONTOURS = 10
"""Number of contours below which a choice is taken."""


class Mark(NamedTuple):
    """Mark of an extreme: `sign` "ring" (thinnest film) or "cross", its cell, and its value."""

    sign: str
    cell: tuple[int, int]
    text: str


class Layer(NamedTuple):
    """Values of a field in `unit`, masked where it has no cell."""

    values: np.ma.MaskedArray
    unit: str


@dataclass(frozen=True)
class FieldMap:
    """Map of one field at one instant.

    Parameters
    ----------
    label : str
        Name of the field with its unit.
    kind : str
        Kind of the field, which determines the colours.
    axes : Axes
    when : str
        Instant in words.
    layers : dict of str to Layer
        Kind -> field, and what else is known of the same film.
    """

    label: str
    kind: str
    axes: Axes
    when: str
    layers: Mapping[str, Layer]

    @property
    def values(self) -> np.ma.MaskedArray:
        return self.layers[self.kind].values

    def values_of(self, kind: str) -> np.ma.MaskedArray | None:
        """Return the field of a kind, None if it is unknown."""
        layer = self.layers.get(kind)
        return layer and layer.values

    @property
    def marks(self) -> list[Mark]:
        """Marks of the highest pressure (of asperities in their map) and of the thinnest film."""
        pressed = "contact" if self.kind == "contact" else "pressure"
        marks = []
        for kind, sign, where in (("thickness", "ring", "argmin"), (pressed, "cross", "argmax")):
            layer = self.layers.get(kind)
            if layer is None or (sign == "cross" and not layer.values.max() > 0.0):
                continue
            i, j = np.unravel_index(getattr(layer.values, where)(), layer.values.shape)
            text = f"{layer.values[i, j]:.3g} {layer.unit}"
            marks.append(Mark(sign, (int(i), int(j)), text))
        return marks


def contour_levels(low: float, high: float) -> list[float]:
    """Return about ten round values between two, closer where they are small."""
    levels: list[float] = []
    for digits in ROUND:
        values = [float(f"{digit * 10.0**power:.2g}") for power in range(-3, 5) for digit in digits]
        levels = sorted(value for value in values if low < value < high)
        if len(levels) < MOST_CONTOURS:
            break
    return levels


def kind_of(port: str) -> str:
    """Return the kind of a field."""
    return KINDS.get(port.rpartition(".")[2], "field")


def field_map(case, results, port: str, time: str | float, units: Mapping[str, str]) -> FieldMap:
    """Return the map of a field.

    Parameters
    ----------
    case : Case
    results : Results
    port : str
        "participant.variable".
    time : str or float
        Instant as in a picture, or in seconds; the nearest recorded one is shown. "envelope" shows
        the extreme value of every cell, without other fields of the same film.
    units : mapping of str to str
        Shown unit by port. Default: SI, and `UNITS` for other fields of the same film.
    """
    kind, axes = kind_of(port), case.axes_of(port)
    if time == ENVELOPE:
        extreme = results.envelope(port)
        steps = "all steps" if extreme.every_step else "recorded instants"
        when = f"extremes of {steps} of the last period"
        fields = {kind: (port, extreme)}
    else:
        seconds = instant(results, time) if isinstance(time, str) else time
        ports = _others(case, results, port, axes) | {kind: port}
        fields = {one: (name, results.field(name, seconds)) for one, name in ports.items()}
        when = instant_text(results, fields[kind][1].time)
    layers = {}
    for one, (name, field) in fields.items():
        target_unit = units.get(name) or (None if name == port else UNITS.get(field.unit))
        values, unit = scaled(field.values, field.unit, target_unit)
        layers[one] = Layer(masked(values, results.existing_cells(name)), unit)
    shape = layers[kind].values.shape
    fitting = {one: layer for one, layer in layers.items() if layer.values.shape == shape}
    return FieldMap(labelled(name_of(port), layers[kind].unit), kind, axes, when, fitting)


def _others(case, results, port, axes) -> dict[str, str]:
    """Return kind -> port of the recorded fields of the same film.

    They have the same axes. Among several films with equal axes, only the fields of the same
    participant are known to belong to it, as without axes.
    """
    by_kind: dict[str, list[str]] = {}
    owner = port.partition(".")[0]
    if kind_of(port) == "field":
        return {}
    for other in results.recorded:
        is_own = other.partition(".")[0] == owner
        if kind_of(other) != "field" and case.axes_of(other) == axes:
            if is_own or axes is not NEUTRAL:
                by_kind.setdefault(kind_of(other), []).append(other)
    chosen = {}
    for kind, ports in by_kind.items():
        own = [other for other in ports if other.partition(".")[0] == owner]
        if len(own or ports) == 1:
            chosen[kind] = (own or ports)[0]
    return chosen


def masked(image, exists) -> np.ma.MaskedArray:
    """Mask the cells that do not exist; `exists` as of `Results.existing_cells`."""
    return np.ma.array(image, mask=np.zeros(np.shape(image), bool) if exists is None else ~exists)


class MapRow(NamedTuple):
    """Maps of one field with the same colours and contours."""

    maps: Sequence[FieldMap]
    low: float
    high: float
    levels: list[float]


def map_row(maps: Sequence[FieldMap]) -> MapRow:
    """Return maps with the range of their colours and the contours of the film thickness."""
    low = min(float(one.values.min()) for one in maps)
    high = max(float(one.values.max()) for one in maps)
    films = [film for one in maps if (film := one.values_of("thickness")) is not None]
    ends = [(float(film.min()), float(film.max())) for film in films]
    levels = contour_levels(min(ends)[0], max(end for _, end in ends)) if ends else []
    return MapRow(maps, low, high, levels)
