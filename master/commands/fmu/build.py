"""`piston-cosim fmu build`."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ...api.fmus import build_fmu
from ..common import console, parse_grid, say


def command(
    participant: str,
    *,
    case: str = "numerical_example",
    grid: str | None = None,
    output: Path | None = None,
    fmi: Literal["2.0", "3.0"] = "2.0",
    no_fields: Annotated[bool, Parameter(negative=())] = False,
    native: Annotated[bool, Parameter(negative=())] = False,
    platform: str = "linux64",
):
    """Build the FMU of one participant of a case.

    Example: piston-cosim fmu build ehd --grid 60x30 --output film.fmu

    Parameters
    ----------
    participant
        Its name in the case: ehd or bodies.
    case
        Case whose build options are used.
    grid
        Circumferential x axial cells, instead of the case's.
    output
        Where to put the FMU; without it the path in the cache is printed.
    fmi
        Version of the standard.
    no_fields
        Leave out the fields to look at (pressure, asperity pressure, film fraction), for tools that
        choke on thousands of scalars.
    native
        Machine code that needs no Python; choices of physics that it does not cover are refused by
        name.
    platform
        What native FMUs are for, several with commas between: linux64, win64, aarch64-linux,
        darwin64, aarch64-darwin; each needs a C compiler here, unless the release has brought its
        library.
    """
    options = {"grid": parse_grid(grid)} if grid else {}
    fewer = {"no_fields": True} if no_fields else {}
    name = {"mfbd": "bodies"}.get(participant, participant)
    platforms = platform.split(",") if native else ()
    fmu = build_fmu(
        case, name, output=output, options=options | fewer, fmi=fmi, platforms=platforms, say=say
    )
    console.print(str(fmu), soft_wrap=True, highlight=False)
