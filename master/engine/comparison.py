"""Comparison of two runs: what differs in their cases, and each figure with its uncertainty.

Eq. (X53):  u = sqrt(sum over causes of u_c^2),   u_c = max(|a_c - b_c|, sqrt(a_c^2 + b_c^2) / 5)
            a_c and b_c are the parts of both figures with the signs of their errors, which runs
            with equal grids and steps share. For other runs and for estimates,
            u_c is the root of a_c^2 + b_c^2.

A difference below u is not distinguishable from zero.
"""

import re
from collections.abc import Mapping, Sequence
from math import hypot, isclose
from pathlib import PurePath
from typing import Any, NamedTuple

from ..case.tables import titles, with_effect
from ..fmi.quantities import are_compatible, numbers_text, quantity
from .measures import LEAST_SHARE, Measure, Measures, unknown_in_words
from .uncertainty import DIVERGES, display_unit

LEAST_REMAINING_SHARE = 0.2
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
MAIN = ("minimum_film_thickness_m", "maximum_pressure_pa", "mean_friction_power_w", "slap_energy_j")
"""Keys of the measures that a headline compares, the worst ones of all participants."""
MOST_NAMED = 3
"""Largest number of differences that a headline names."""
MOST_WORDS = 25
"""Largest number of words in a sentence about changes."""
ROUND_OFF = 1e-9
"""Relative difference up to which values in different units are equal."""
NOT_DISTINGUISHABLE, NOT_KNOWN = "not distinguishable", "uncertainty unknown"


class Difference(NamedTuple):
    """Difference of a figure between a first and a second run.

    text : difference with its uncertainty, `NOT_DISTINGUISHABLE`, `NOT_KNOWN` or `DIVERGES`; size :
    of a known difference, 0 otherwise; better : 1 if the first run is better, -1 if the second is,
    else 0.
    """

    first: Measure
    second: Measure
    text: str
    size: float = 0.0
    better: int = 0

    @property
    def label(self) -> str:
        """Name of the figure."""
        return self.first.label

    @property
    def is_zero(self) -> bool:
        """True if the figure is zero in both runs."""
        return not self.first.value and not self.second.value


class Compared(NamedTuple):
    """Comparison of two runs.

    headline : sentences; names : what is different in the first and the second run; rows : the
    differences of the figures that are not zero in both runs; remarks : sentences about the others,
    and about unknown uncertainties.
    """

    headline: str
    names: tuple[str, str]
    rows: list[Difference]
    remarks: list[str]


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
    alike = have_equal_grids(trees[0], trees[1])
    changes = differing(trees[0], trees[1], names)
    rows = [
        difference(tables[0].named(one), other, alike)
        for one in tables[0].all
        if one.key in BETTER and not (one.key == "mean_friction_power_w" and one.owner)
        if (other := tables[1].of(one.key, one.owner))
    ]
    zero = [row.label for row in rows if row.is_zero]
    rows = [row for row in rows if not row.is_zero]
    remarks = [f"Zero in both runs: {', '.join(zero)}."] if zero else []
    if titles(trees[0]).isdisjoint(titles(trees[1])):
        remarks.append("The runs are of cases with different titles, whose other keys may differ.")
    remarks += unknown_in_words([one for row in rows for one in (row.first, row.second)])
    worst = [[table.worst(key) for key in MAIN] for table in tables]
    main = [difference(one, other, alike) for one, other in zip(*worst) if one and other]
    main = [row for row in main if not row.is_zero]
    unequal = unequal_lengths(changes, tables)
    main = [row._replace(better=0) for row in main] if unequal else main
    text = " ".join(filter(None, [headline(changes, main), unequal]))
    return Compared(text, changes, rows, remarks)


def unequal_lengths(names: Sequence[str], tables: Sequence[Measures]) -> str:
    """Return a sentence if two runs have results of unequal lengths, "" otherwise."""
    first, second = (table.length for table in tables[:2])
    if first == second:
        return ""
    return f"Not comparable: {names[0]} has results of {first}, and {names[1]} of {second}."


def have_equal_grids(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Return whether two cases have the same grids and the same macro step, in any unit."""
    steps = (tree.get("time", {}).get("step") for tree in (one, other))
    return _grids(one) == _grids(other) and _equal(*steps)


def _grids(tree):
    """Return the grids of a case."""
    builds = (one.get("build", {}) for one in tree.get("participants", {}).values())
    return [build.get("grid") for build in builds]


def spread(one: Measure, other: Measure, alike: bool) -> float | None:
    """Return the uncertainty of the difference of two figures, None if it is unknown."""
    pair = one.uncertainty, other.uncertainty
    if any(each.value is None for each in pair):
        return None
    spreads = []
    for cause in {**pair[0].parts, **pair[1].parts}:
        a, b = (each.parts.get(cause, 0.0) for each in pair)
        both = hypot(a, b)
        signed = alike and all(each.signed for each in pair) and cause in ("grid", "step")
        spreads.append(max(abs(a - b), LEAST_REMAINING_SHARE * both) if signed else both)
    return hypot(*spreads)  # Eq. (X53)


def difference(one: Measure, other: Measure, alike: bool) -> Difference:
    """Return the difference of a figure; `alike`: whether both runs have equal grids and steps."""
    size, own = one.value - other.value, spread(one, other, alike)
    if own is None:
        reasons = [each.uncertainty.reason for each in (one, other)]
        return Difference(one, other, DIVERGES if DIVERGES in reasons else NOT_KNOWN)
    if abs(size) <= own or (one.unit == "1" and abs(size) < LEAST_SHARE):
        return Difference(one, other, NOT_DISTINGUISHABLE)
    factor, label = display_unit(one.unit, max(abs(size), own))
    text = f"{numbers_text(factor * size, factor * own)} {label}".strip()
    sign = 1 if size > 0.0 else -1
    better = sign * BETTER.get(one.key, 0)
    return Difference(one, other, f"+{text}" if sign > 0 else text, size, better)


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
    """Return what two cases do not share, in words.

    Variants of a case have names, which are returned. So they are if nothing or too much differs.
    """
    labels = [tree.get("label", "base") for tree in (one, other)]
    if labels[0] != labels[1] or {*names[:2]} <= {labels[0], *one.get("variants", {})}:
        return names[0], names[1]
    pair = [leaves(with_effect(tree)) for tree in (one, other)]
    keys = [key for key in {**pair[0], **pair[1]} if not _equal(*(one.get(key) for one in pair))]
    parts = _parts(keys, pair)
    if not 0 < len(parts) <= MOST_NAMED:
        return names[0], names[1]
    first, second = (" and ".join(each[k] for each in parts) for k in (0, 1))
    return first, second


def _equal(one, other):
    """Return whether two values are the same, also in different units."""
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_equal, one, other))
    first, second = _quantity(one), _quantity(other)
    if first is None or second is None or not are_compatible(first.units, second.units):
        return one == other
    return isclose(first.to(second.units).magnitude, second.magnitude, rel_tol=ROUND_OFF)


def _quantity(value):
    """Return the quantity of a text with a unit, None for other values."""
    try:
        return quantity(value) if isinstance(value, str) else None
    except ValueError:
        return None


def _parts(keys, pair):
    """Return what differs in words, equal pairs once.

    If keys with the same last part have different pairs, the part that tells them apart is added.
    """
    by_key: dict[str, dict[tuple[str, ...], list[str]]] = {}
    for key in keys:
        shown = tuple(_shown(key, one) for one in pair)
        if shown[0] == shown[1]:  # files of one name in different folders
            shown = tuple(str(one[key]) for one in pair)
        by_key.setdefault(key.rpartition(".")[2], {}).setdefault(shown, key.split("."))
    parts: list[tuple[str, ...]] = []
    for own in by_key.values():
        level = next((k for k, part in enumerate(zip(*own.values())) if len({*part}) > 1), None)
        parts += [
            shown if level is None else tuple(f"{key[level]} {text}" for text in shown)
            for shown, key in own.items()
        ]
    return parts


def _shown(key, known):
    """Return the value at a key in words: the name of a file alone, other values with their key."""
    words = key.rpartition(".")[2].replace("_", " ")
    if key not in known:
        return f"no {words}"
    value = known[key]
    is_text = isinstance(value, str) and _quantity(value) is None  # "12.5um" is no file
    if is_text and PurePath(value).suffix and " " not in value:
        return PurePath(value).name
    return f"{words} {value}"


def headline(names: Sequence[str], rows: list[Difference]) -> str:
    """Return sentences about two runs: what differs, what that changes, and which is better."""
    sentences = [changes(names, rows)]
    for text in dict.fromkeys(row.text for row in rows if not row.size):
        own = ", ".join(row.label for row in rows if row.text == text)
        sentences.append(f"{text[0].upper()}{text[1:]}: {own}.")
    for name, sign in zip(names, (1, -1)):
        if own := [row.label for row in rows if row.better == sign]:
            sentences.append(f"Better with {name}: {', '.join(own)}.")
    return " ".join(sentences)


def changes(names: Sequence[str], rows: list[Difference]) -> str:
    """Return sentences about what differs in two runs, and what that changes."""
    first, second, *_ = names
    is_file = {*"./_"} & {*first.split()[0]}  # which keeps its letters
    begin = first if is_file else f"{first[0].upper()}{first[1:]}"
    if not rows:
        return f"{begin} and {second} have no main result in common."
    subject, clauses = f"{begin} instead of {second}", []
    for verb, sign in (("raises", 1), ("lowers", -1)):
        known = [row for row in rows if row.size * sign > 0]
        own = [f"the {row.label} by {row.text.lstrip('+-')}" for row in known]
        while own:
            fits = [f"{subject} {verb} {listed(own[: k + 1])}." for k in range(len(own))]
            count = max(1, sum(_words(text) <= MOST_WORDS for text in fits))
            clauses.append(fits[count - 1])
            own, subject = own[count:], "It"
    return " ".join(clauses) or f"{subject} makes no clear difference."


def _words(text):
    """Return the number of words of a text."""
    return len(re.findall(r"\S*\w\S*", text))


def listed(texts: Sequence[str]) -> str:
    """Return texts joined by commas, the last one by "and"."""
    *most, last = texts
    return f"{', '.join(most)} and {last}" if most else last
