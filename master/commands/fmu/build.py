"""`piston-cosim fmu build`."""

from typing import Annotated, Any, Literal

from cyclopts import Parameter

from ...api.cases import open_case
from ...api.fmus import build_fmu
from ...fmi.errors import BadInput
from ..common import (
    Changes,
    Only,
    OutputFile,
    native_platforms,
    parse_changes,
    parse_grid,
    print_line,
    say,
)


def command(
    source: str,
    /,
    *,
    case: str = "numerical_example",
    set_: Changes = [],
    only: Only = None,
    grid: str | None = None,
    output: OutputFile | None = None,
    fmi: Literal["2.0", "3.0"] = "2.0",
    native: Annotated[bool, Parameter(negative=())] = False,
    platform: str | None = None,
):
    """Build the FMU of one participant of a case, or of a single-file model class.

    Example: piston-cosim fmu build ehd --grid 60x30 --output film.fmu

    Example: piston-cosim fmu build my_film.py:MyFilm --output film.fmu

    Parameters
    ----------
    source
        Name of the participant in the case, ehd or bodies, or model class FILE.py:CLASS.
    case
        Case whose build options and values the FMU has.
    set_
        Change of the case, KEY=VALUE, e.g. `viscosity="20 mPa s"`; repeatable.
    only
        Variant of the case. Default: the case itself.
    grid
        Number of cells, CIRCUMFERENTIALxAXIAL. Default: the grid of the case, or 40x40.
    output
        File to write. Default: a file in the cache, whose path is printed.
    fmi
        Version of FMI.
    native
        Write machine code that needs no Python. Reports each option that it does not support.
    platform
        Platforms of a native FMU, separated by commas: linux64, win64, aarch64-linux, darwin64,
        aarch64-darwin. Default: linux64. Needs a C compiler, except for platforms whose library is
        installed.
    """
    if ".py" in source:
        if set_ or only:
            raise BadInput("--set, --only: expected a participant of a case, got a single file")
        origin: tuple[Any, ...] = (source,)
        grid = grid or "40x40"
    else:
        changed = open_case(case, dict(parse_changes(set_)), only)
        origin = changed, {"mfbd": "bodies"}.get(source, source)
    fmu = build_fmu(
        *origin,
        output=output,
        options={"grid": parse_grid(grid)} if grid else {},
        fmi=fmi,
        platforms=native_platforms(platform, native),
        say=say,
    )
    print_line(str(fmu))
