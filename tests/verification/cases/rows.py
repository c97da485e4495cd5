"""Verification rows of every part, against closed forms, published tables and independent codes.

A part is modules with `checks()` and, for what takes long, `slow_checks()`; both yield `Check`.
"""

import itertools
from collections import Counter
from importlib.metadata import version

from rich.markup import escape
from rich.table import Table

from . import bodies, coupled, coupling, film, reciprocating

PARTS = {
    "ehd": [film, reciprocating],
    "mfbd": [bodies],
    "master": [coupling],
    "coupled": [coupled],
}


def checks(parts, slow):
    """Yield pairs of part and `Check` of the named parts, computed one by one."""
    for part in parts:
        series = [module.checks for module in PARTS[part]]
        series += [module.slow_checks for module in PARTS[part] if slow]
        for check in itertools.chain.from_iterable(compute() for compute in series):
            yield part, check


HEADS = ("", "case", "quantity", "computed", "reference", "error", "tolerance", "source")


def verify(parts, slow, console, page=None):
    """Print every check and return the number of failed ones; write all to `page` if present."""
    failed, counts = 0, Counter()
    table = Table(*HEADS, box=None)
    rows = []
    with console.status("computing") as status:
        for part, check in checks(parts, slow):
            status.update(f"{part}: {check.case}")
            failed += not check.passed
            counts[part] += 1
            rows.append((part, _cells(check)))
            table.add_row("ok" if check.passed else "[red]FAIL[/]", *map(escape, _cells(check)))
    console.print(table)
    split = ", ".join(f"{part} {count}" for part, count in counts.items())
    console.print(f"{table.row_count - failed} passed, {failed} failed: {split}")
    if page is not None:
        page.write_text(_page(rows, failed, split))
    return failed


def _cells(check):
    """Return the cells of a check's row."""
    return (
        check.case,
        check.quantity,
        f"{float(check.computed):.8g}",
        "" if check.reference is None else f"{float(check.reference):.8g}",
        f"{check.error:.2g}",
        f"{check.tolerance:.2g} {check.kind}",
        check.source,
    )


def _page(rows, failed, split):
    """Return the Markdown page of all rows, one table per part."""
    lines = [
        "# Figures and their references",
        "",
        f"`piston-cosim verify --output` of version {version('piston-cosim')} writes this page. "
        f"It has {len(rows)} figures ({split}), and {failed} of them exceed their tolerance.",
        "",
        "- An asterisk marks dimensionless values. K is the inclination of a pad, e an "
        "eccentricity, and c a curvature.",
        "- B/D and L/D are length over diameter of a bearing. Lambda is separation over roughness.",
        "- The error is relative or absolute, as the tolerance is. Without a reference, the figure "
        "itself must not exceed the tolerance.",
        "",
    ]
    for part, several in itertools.groupby(rows, lambda row: row[0]):
        lines += [f"## {part}", "", f"| {' | '.join(HEADS[1:])} |", "|---" * len(HEADS[1:]) + "|"]
        lines += [
            f"| {' | '.join(c.replace('|', chr(92) + '|') for c in row)} |" for _, row in several
        ]
        lines.append("")
    return "\n".join(lines)
