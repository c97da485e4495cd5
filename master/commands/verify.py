"""`piston-cosim verify`."""

import sys
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from ..fmi.errors import BadInput
from ..verify import PARTS
from ..verify import verify as compute
from .common import console


def command(*parts: str, all_: Annotated[bool, Parameter(name="--all", negative=())] = False):
    """Compute every verification figure and print it beside its reference and its error.

    Example: piston-cosim verify ehd

    Parameters
    ----------
    parts
        ehd, mfbd, master; all of them by default.
    all_
        The slow studies too (minutes).
    """
    unknown = [part for part in parts if part not in PARTS]
    if unknown:
        raise BadInput(f"no part {', '.join(unknown)}: there are {', '.join(PARTS)}")
    if compute(parts or tuple(PARTS), all_, Console(width=max(console.width, 190))):
        sys.exit(1)
