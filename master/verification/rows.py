"""Verification rows of every part: computed against closed forms, published tables and independent
codes.

A part is a module with `checks()` and, for what takes long, `slow_checks()`; both yield `Check`.
"""

import itertools

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


def verify(parts, slow, console):
    """Print every check as it is computed; returns the number that failed."""
    failed = 0
    heads = ("", "case", "quantity", "computed", "reference", "error", "allowed", "source")
    table = Table(*heads, box=None)
    with console.status("computing") as status:
        for part, check in checks(parts, slow):
            status.update(f"{part}: {check.case}")
            failed += not check.passed
            table.add_row(
                "ok" if check.passed else "[red]FAIL[/]",
                check.case,
                check.quantity,
                f"{float(check.computed):.8g}",
                "" if check.reference is None else f"{float(check.reference):.8g}",
                f"{check.error:.2g}",
                f"{check.tolerance:.2g} {check.kind}",
                check.source,
            )
    console.print(table)
    console.print(f"{table.row_count - failed} passed, {failed} failed")
    return failed
