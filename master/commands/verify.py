"""`piston-cosim verify`."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from ..fmi.errors import BadInput
from ..verification.importers import verify_importers
from ..verification.rows import PARTS
from ..verification.rows import verify as compute
from .common import console, say

IMPORTERS = "importers"


def command(
    *parts: str,
    all_: Annotated[bool, Parameter(name="--all", negative=())] = False,
    output: Path | None = None,
):
    """Compute every verification figure and print it beside its reference and its error.

    Example: piston-cosim verify ehd

    Parameters
    ----------
    parts
        ehd, mfbd, master, coupled; all of them by default. Or importers: how far the engine FMU in
        FMI 2.0 and 3.0, with Python and native, is from a run, by a host of plain C and by each
        independent importer that is installed, here and in the Pythons that PISTON_COSIM_PYTHONS
        names, separated by colons.
    all_
        The slow studies too (minutes).
    output
        Also write the figures there, as Markdown.
    """
    unknown = [part for part in parts if part not in (*PARTS, IMPORTERS)]
    if unknown:
        raise BadInput(f"no part {', '.join(unknown)}: there are {', '.join((*PARTS, IMPORTERS))}")
    figures = [part for part in parts or PARTS if part != IMPORTERS]
    wide = Console(width=max(console.width, 190))
    failed = compute(figures, all_, wide, output) if figures else 0
    if IMPORTERS in parts:
        failed += verify_importers(wide, say)
    if failed:
        sys.exit(1)
