"""`piston-cosim verify`."""

import sys
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from ..fmi.errors import BadInput, unknown
from .common import OutputFile, console, say

IMPORTERS = "importers"
LITERATURE = "literature"
OPTIONAL_PARTS = (IMPORTERS, LITERATURE)
"""Parts that do not run by default."""


def command(
    *parts: str,
    all_: Annotated[bool, Parameter(name="--all", negative=())] = False,
    output: OutputFile | None = None,
):
    """Compute the verification figures next to their references.

    Each figure has a reference (closed form, table, other code or observed order) and a tolerance.
    The exit code is 1 if a figure is outside its tolerance.

    Example: piston-cosim verify ehd

    Parameters
    ----------
    parts
        ehd, mfbd, master or coupled; default: all four. The part importers runs the engine FMU in
        each installed FMI importer and compares it with a run. The part literature compares
        bearings with experiments and published studies, without a tolerance.
    all_
        Include the slow studies, which take minutes.
    output
        Also write the figures to this Markdown file.
    """
    from ...tests.verification.cases.importers import verify_importers
    from ...tests.verification.cases.measured import verify_measured
    from ...tests.verification.cases.rows import PARTS, verify

    known = (*PARTS, *OPTIONAL_PARTS)
    if unknown_parts := [part for part in parts if part not in known]:
        raise BadInput([f"PARTS: {unknown('part', part, known)}" for part in unknown_parts])
    figures = [part for part in parts or PARTS if part not in OPTIONAL_PARTS]
    wide = Console(width=max(console.width, 190))
    failed = verify(figures, all_, wide, output) if figures else 0
    if IMPORTERS in parts:
        failed += verify_importers(wide, say)
    if LITERATURE in parts:
        verify_measured(wide, None if figures else output)
    if failed:
        sys.exit(1)
