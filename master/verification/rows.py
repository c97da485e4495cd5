"""Verification rows of every part: computed against closed forms, published tables and independent
codes.

A part is a module with `checks()` and, for what takes long, `slow_checks()`; both yield `Check`.
"""

import itertools
from importlib.metadata import version

from rich.table import Table

from ..fmi.tree import import_part

PARTS = {
    "ehd": "fmu_ehd.verification",
    "mfbd": "fmu_mfbd.verification",
    "master": "master.verification.coupling",
    "coupled": "master.verification.coupled",
}


def checks(parts, slow):
    """The named parts' checks, computed one by one: pairs of part and `Check`."""
    for part in parts:
        module = import_part(PARTS[part])
        series = [module.checks, module.slow_checks] if slow else [module.checks]
        for check in itertools.chain.from_iterable(compute() for compute in series):
            yield part, check


HEADS = ("", "case", "quantity", "computed", "reference", "error", "allowed", "source")


def verify(parts, slow, console, page=None):
    """Print every check as it is computed, and write them all to the Markdown file `page`, if one
    is given; returns the number that failed.
    """
    failed = 0
    table = Table(*HEADS, box=None)
    rows = []
    with console.status("computing") as status:
        for part, check in checks(parts, slow):
            status.update(f"{part}: {check.case}")
            failed += not check.passed
            rows.append((part, _cells(check)))
            table.add_row("ok" if check.passed else "[red]FAIL[/]", *_cells(check))
    console.print(table)
    console.print(f"{table.row_count - failed} passed, {failed} failed")
    if page is not None:
        page.write_text(_page(rows, failed))
    return failed


def _cells(check):
    """What is said of a check, as texts."""
    return (
        check.case,
        check.quantity,
        f"{float(check.computed):.8g}",
        "" if check.reference is None else f"{float(check.reference):.8g}",
        f"{check.error:.2g}",
        f"{check.tolerance:.2g} {check.kind}",
        check.source,
    )


def _page(rows, failed):
    """Markdown of all rows, a table a part."""
    lines = [
        "# Figures and their references",
        "",
        f"Written by `piston-cosim verify --output`, version {version('piston-cosim')}: "
        f"{len(rows)} figures, {failed} of them outside what is allowed.",
        "",
    ]
    for part, several in itertools.groupby(rows, lambda row: row[0]):
        lines += [f"## {part}", "", f"| {' | '.join(HEADS[1:])} |", "|---" * len(HEADS[1:]) + "|"]
        lines += [
            f"| {' | '.join(c.replace('|', chr(92) + '|') for c in row)} |" for _, row in several
        ]
        lines.append("")
    return "\n".join(lines)
