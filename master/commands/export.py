"""`piston-cosim export`."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ..api.fmus import compile_code
from ..case.export import experiment_ahead, export_fmu
from ..case.given import build_options
from ..case.schema import check_case, find_case, read_tree
from ..case.ssp import export_ssp
from ..case.system import open_system
from ..fmi.builder import build_fmu
from ..fmi.errors import BadInput
from .common import Changes, console, parse_change, say


def command(
    kind: Literal["fmu", "ssp"],
    case: str,
    *,
    set_: Changes = [],
    output: Path,
    fmi: Literal["2.0", "3.0"] = "2.0",
    native: Annotated[bool, Parameter(negative=())] = False,
    platform: str = "linux64",
):
    """Export a case: as one FMU with the iteration inside, for tools that cannot repeat a step, or
    as an SSP.

    Example: piston-cosim export fmu numerical_example --output engine.fmu

    Parameters
    ----------
    kind
        fmu or ssp.
    case
        Name of a case (see list), its folder, or a case file.
    set_
        Change of the case, KEY=VALUE.
    output
        Where to put it.
    fmi
        Version of the FMU, or of those inside an SSP: 2.0 (SSP 1.0, a connector for every scalar)
        or 3.0 (SSP 2.0, arrays).
    native
        One FMU of machine code that needs no Python; what it does not cover (another method than
        newton, several film surfaces, choices of physics ..) is refused by name.
    platform
        What a native FMU is for, several with commas between: linux64, win64, aarch64-linux,
        darwin64, aarch64-darwin; each needs a C compiler here, unless the release has brought its
        library.
    """
    if native and kind == "ssp":
        raise BadInput("--native: is for fmu; an SSP holds FMUs, give those of build --native")
    platforms = platform.split(",") if native else ()
    path = find_case(case)
    tree = read_tree(path, [parse_change(text) for text in set_])
    checked = check_case(tree, path)
    if kind == "fmu":
        fmus = [export_fmu(checked, path.parent, say, fmi, platforms)]
        output.write_bytes(fmus[0].read_bytes())
    else:
        system = open_system(built(checked, path.parent, fmi), path.parent, say)
        export_ssp(tree, system, output)
        fmus = [participant.path for participant in system.participants.values()]
    for fmu in () if native else fmus:
        compile_code(fmu, say)
    console.print(str(output), soft_wrap=True, highlight=False)


def built(case, folder, fmi):
    """The case with FMUs of that version in the place of the packages it builds; they say the
    case's own run.
    """
    usual = experiment_ahead(case, folder)
    options = build_options(case, folder, say)
    fmus = {
        name: build_fmu(table.package, options[name], folder, say, fmi, experiment=usual)
        for name, table in case.participants.items()
        if table.package
    }
    tables = {
        name: table.model_copy(update={"package": None, "build": {}, "fmu": str(fmus[name])})
        if name in fmus
        else table
        for name, table in case.participants.items()
    }
    return case.model_copy(update={"participants": tables})
