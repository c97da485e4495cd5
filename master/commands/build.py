"""`piston-cosim build`."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ..case.given import build_options
from ..case.schema import check_case, find_case, read_tree
from ..fmi.builder import build_fmu
from ..fmi.errors import BadInput
from .common import console, parse_grid, say


def command(
    participant: str,
    *,
    case: str = "numerical_example",
    grid: str | None = None,
    output: Path | None = None,
    fmi: Literal["2.0", "3.0"] = "2.0",
    no_fields: Annotated[bool, Parameter(negative=())] = False,
):
    """Build the FMU of one participant of a case.

    Example: piston-cosim build ehd --grid 60x30 --output film.fmu

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
    """
    path = find_case(case)
    checked = check_case(read_tree(path), path)
    name = {"mfbd": "bodies"}.get(participant, participant)
    if name not in checked.participants or not checked.participants[name].package:
        raise BadInput(
            f"participant {participant!r}: the case builds {', '.join(checked.participants)}"
        )
    table = checked.participants[name]
    if grid:
        for one in checked.participants.values():
            if "grid" in one.build:
                one.build["grid"] = parse_grid(grid)
        table.build["grid"] = parse_grid(grid)
    if no_fields:
        table.build["no_fields"] = True
    options = build_options(checked, path.parent, say)[name]
    fmu = build_fmu(table.package, options, path.parent, say, fmi)
    if output:
        output.write_bytes(fmu.read_bytes())
    console.print(str(output or fmu), soft_wrap=True, highlight=False)
