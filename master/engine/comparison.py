"""Comparison of two runs: what differs in their cases, and each figure with its uncertainty.

Eq. (X53):  u = sqrt(sum over causes of u_c^2),   u_c = max(|a_c - b_c|, sqrt(a_c^2 + b_c^2) / 5)
            a_c and b_c are the parts of both figures with the signs of their errors, which runs
            with equal grids and steps share. For other runs and for estimates,
            u_c is the root of a_c^2 + b_c^2.

A difference below u is not distinguishable from zero.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot
from pathlib import PurePath
from typing import Any

from .measures import LEAST_SHARE, Measure, Measures
from .uncertainty import DIVERGES, display_unit, numbers_text

SHARED = 0.2
"""Smallest part of the uncertainties of two figures that remains in their difference, an
assumption: errors of two runs on equal grids are similar, and not equal."""
BETTER = {
    "minimum_film_thickness_m": 1,
    "maximum_pressure_pa": -1,
    "mean_friction_power_w": -1,
    "friction_mean_effective_pressure_pa": -1,
    "contact_share": -1,
    "slap_energy_j": -1,
    "side_force_n": 0,
    "range_lateral_displacement_m": 0,
    "range_rocking_angle_rad": -1,
    "oil_throughput_m3": 0,
}
"""Key of a compared measure -> sign of a change that improves a design, 0 for neither."""
NOT_RESULTS = ("title", "label", "monitor", "pictures", "axes", "window", "studies", "variants")
"""Tables of a case that do not affect its results."""
MOST_NAMED = 3
"""Largest number of differences that a headline names."""
NOT_DISTINGUISHABLE = "not distinguishable"


@dataclass(frozen=True)
class Difference:
    """Difference of a figure between a first and a second run.

    label : of the figure; first, second : their texts; text : difference with its uncertainty, or
    `NOT_DISTINGUISHABLE`, or why it is unknown; size : of a known difference, 0 otherwise; better :
    1 if the first run is better, -1 if the second is, else 0.
    """

    label: str
    first: str
    second: str
    text: str
    size: float
    better: int


@dataclass(frozen=True)
class Compared:
    """Comparison of two runs.

    headline : sentence; names : what is different in the first and the second run; rows : the
    difference of every figure.
    """

    headline: str
    names: tuple[str, str]
    rows: list[Difference]


def compared(
    names: Sequence[str], trees: Sequence[dict[str, Any]], tables: Sequence[Measures]
) -> Compared:
    """Return the comparison of two runs.

    Parameters
    ----------
    names : sequence of str
        Their labels, used if the cases do not differ in a few keys.
    trees : sequence of dict
        Their resolved TOML trees.
    tables : sequence of Measures
    """
    first, second = tables
    alike = grids(trees[0]) == grids(trees[1])
    rows = [
        difference(one, other, alike)
        for one in first.all
        if one.key in BETTER and not (one.key == "mean_friction_power_w" and one.owner)
        if (other := second.of(one.key, one.owner))
    ]
    found = differing(trees[0], trees[1], names)
    return Compared(headline(found, rows), found, rows)


def grids(tree: Mapping[str, Any]) -> list[Any]:
    """Return grids and macro step of a case."""
    builds = (one.get("build", {}) for one in tree.get("participants", {}).values())
    return [tree.get("time", {}).get("step"), *(build.get("grid") for build in builds)]


def spread(one: Measure, other: Measure, alike: bool) -> float | None:
    """Return the uncertainty of the difference of two figures, None if it is unknown."""
    pair = one.uncertainty, other.uncertainty
    if any(each.value is None for each in pair):
        return None
    found = []
    for cause in {**pair[0].parts, **pair[1].parts}:
        a, b = (each.parts.get(cause, 0.0) for each in pair)
        both = hypot(a, b)
        signed = alike and all(each.signed for each in pair) and cause in ("grid", "step")
        found.append(max(abs(a - b), SHARED * both) if signed else both)
    return hypot(*found)  # Eq. (X53)


def difference(one: Measure, other: Measure, alike: bool) -> Difference:
    """Return the difference of a figure; `alike`: whether both runs have equal grids and steps."""
    size, own = one.value - other.value, spread(one, other, alike)
    texts = one.label, one.figure, other.figure
    if own is None:
        reasons = [each.uncertainty.reason for each in (one, other)]
        text = DIVERGES if DIVERGES in reasons else f"uncertainty unknown: {max(reasons)}"
        return Difference(*texts, text, 0.0, 0)
    if abs(size) <= own or (one.unit == "1" and abs(size) < LEAST_SHARE):
        return Difference(*texts, NOT_DISTINGUISHABLE, 0.0, 0)
    factor, label = display_unit(one.unit, max(abs(size), own))
    text = f"{numbers_text(factor * size, factor * own)} {label}".strip()
    sign = 1 if size > 0.0 else -1
    return Difference(*texts, f"+{text}" if sign > 0 else text, size, sign * BETTER.get(one.key, 0))


def leaves(tree: Any, key: str = "") -> dict[str, Any]:
    """Return the values of a tree by dotted key."""
    if isinstance(tree, dict):
        items = tree.items()
    elif isinstance(tree, list) and any(isinstance(one, (dict, list)) for one in tree):
        items = enumerate(tree)
    else:
        return {key: tree}
    return {
        name: value
        for part, one in items
        for name, value in leaves(one, f"{key}.{part}".strip(".")).items()
    }


def differing(one: dict[str, Any], other: dict[str, Any], names: Sequence[str]) -> tuple[str, str]:
    """Return what two cases do not share, in words; their names if it is nothing or too much."""
    pair = [
        leaves({key: value for key, value in tree.items() if key not in NOT_RESULTS})
        for tree in (one, other)
    ]
    keys = [key for key in {**pair[0], **pair[1]} if pair[0].get(key) != pair[1].get(key)]
    parts: dict[str, tuple[str, str]] = {}
    for key in keys:
        parts.setdefault(key.rpartition(".")[2], (_shown(key, pair[0]), _shown(key, pair[1])))
    if not 0 < len(parts) <= MOST_NAMED:
        return names[0], names[1]
    first, second = (" and ".join(each[k] for each in parts.values()) for k in (0, 1))
    return first, second


def _shown(key, known):
    """Return the value at a key in words: the name of a file alone, other values with their key."""
    words = key.rpartition(".")[2].replace("_", " ")
    if key not in known:
        return f"no {words}"
    value = known[key]
    if isinstance(value, str) and PurePath(value).suffix and " " not in value:
        return PurePath(value).name
    return f"{words} {value}"


def headline(names: tuple[str, str], rows: list[Difference]) -> str:
    """Return a sentence about two runs: what differs, and what that changes."""
    first, second = names
    changes = [row for row in rows if row.size]
    same = [row for row in rows if row.text == NOT_DISTINGUISHABLE]
    said = []
    for verb, sign in (("raises", 1), ("lowers", -1)):
        own = [
            f"the {one.label} by {one.text.lstrip('+-')}" for one in changes if one.size * sign > 0
        ]
        said += [f"{verb} {listed(own)}"] if own else []
    text = f"{first} instead of {second} {listed(said) if said else 'makes no clear difference'}."
    if same and changes:
        text += f" Not distinguishable: {', '.join(row.label for row in same)}."
    wins = [_won(name, rows, sign) for name, sign in ((first, 1), (second, -1))]
    begin = text[0] if "." in first else text[0].upper()  # the name of a file keeps its letters
    return " ".join(filter(None, [begin + text[1:], *wins]))


def _won(name, rows, sign):
    """Return the figures in which a run is better, as a sentence."""
    own = [row.label for row in rows if row.better == sign]
    return f"Better with {name}: {', '.join(own)}." if own else ""


def listed(texts: Sequence[str]) -> str:
    """Return texts joined by commas, the last one by "and"."""
    *most, last = texts
    return f"{', '.join(most)} and {last}" if most else last
