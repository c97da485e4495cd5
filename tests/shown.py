"""Numbers of the tables of pages, which tests compare with runs."""

import re
from decimal import Decimal
from pathlib import Path

ROOT = Path(__file__).parents[1]
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?")
LEAST = 0.6
"""Largest difference from a rounded value, in units of its last digit: machines differ by 0.1."""


def table(page, first, number=0):
    """Return the rows of a table: label -> cells, each with its numbers as they are written.

    Parameters
    ----------
    page : str
        Path in the project.
    first : str
        First cell of the head of the table.
    number : int
        Number of the table among those with this cell, from 0.
    """
    lines = (ROOT / page).read_text().split("\n")
    head = [k for k, line in enumerate(lines) if line.startswith(f"| {first} |")][number]
    rows = {}
    for line in lines[head + 2 :]:
        if not line.startswith("|"):
            break
        label, *cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        rows[label] = [NUMBER.findall(cell) for cell in cells]
    return rows


def rounds_to(value, text):
    """Return whether a value rounds to a number as it is written."""
    unit = 10.0 ** int(Decimal(text).as_tuple().exponent)
    return abs(value - float(text)) <= LEAST * unit


def written(pattern: str, text: str) -> tuple[str, ...]:
    """Return the groups of the only match of a pattern in a text."""
    (groups,) = re.findall(pattern, text)
    return (groups,) if isinstance(groups, str) else groups


def check(rows, computed):
    """Raise AssertionError with all cells whose numbers are not those that a run computed.

    Parameters
    ----------
    rows : dict
        Of `table`.
    computed : dict
        Label -> the numbers of each cell, in the units of the page.
    """
    wrong = [f"{label}: not computed" for label in rows if label not in computed]
    wrong += [f"{label}: not on the page" for label in computed if label not in rows]
    for label in {*rows} & {*computed}:
        cells = computed[label]
        for shown, values in zip(rows[label], [*cells, *[[]] * (len(rows[label]) - len(cells))]):
            agree = len(shown) == len(values) and all(map(rounds_to, values, shown))
            if not agree:
                wrong.append(f"{label}: {shown}, computed {values}")
    assert not wrong, "\n".join(["numbers of the page", *wrong])
