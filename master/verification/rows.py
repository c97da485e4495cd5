"""Verification rows of every part: computed against closed forms, published tables and independent
codes.

A part is a module with `checks()` and, for what takes long, `slow_checks()`; both yield dicts with
case, quantity, computed, reference, tolerance, kind ("relative", "absolute", "at most"), source and
reason.
"""

from rich.table import Table

from ..fmi.tree import import_part

PARTS = {
    "ehd": "fmu_ehd.verification",
    "mfbd": "fmu_mfbd.verification",
    "master": "master.verification.coupling",
}


def error_of(row):
    """What is compared with the tolerance: the value itself ("at most"), or its distance from the
    reference.
    """
    if row["kind"] == "at most":
        return row["computed"]
    scale = abs(row["reference"]) if row["kind"] == "relative" else 1.0
    return abs(row["computed"] - row["reference"]) / scale


def rows(parts, slow):
    """Rows of the named parts, each with `part`, `error` and `passed` added."""
    for part in parts:
        module = import_part(PARTS[part])
        for name in ("checks", "slow_checks") if slow else ("checks",):
            for row in getattr(module, name, tuple)():
                error = error_of(row)
                yield row | {
                    "part": part,
                    "error": error,
                    "passed": bool(error <= row["tolerance"]),
                }


def verify(parts, slow, console):
    """Print every row as it is computed; returns the number of rows that failed."""
    failed = 0
    heads = ("", "case", "quantity", "computed", "reference", "error", "allowed", "source")
    table = Table(*heads, box=None)
    with console.status("computing") as status:
        for row in rows(parts, slow):
            status.update(f"{row['part']}: {row['case']}")
            failed += not row["passed"]
            reference = "" if row["reference"] is None else f"{row['reference']:.8g}"
            table.add_row(
                "ok" if row["passed"] else "[red]FAIL[/]",
                row["case"],
                row["quantity"],
                f"{row['computed']:.8g}",
                reference,
                f"{row['error']:.2g}",
                f"{row['tolerance']:.2g} {row['kind']}",
                row["source"],
            )
    console.print(table)
    console.print(f"{table.row_count - failed} passed, {failed} failed")
    return failed
