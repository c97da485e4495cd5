"""`piston-cosim fmu export`."""

from typing import Annotated, Literal

from cyclopts import App, Parameter

from ...api.fmus import compile_code
from ...case.checked import check_case
from ...case.export import experiment_ahead, export_fmu
from ...case.given import build_options
from ...case.reading import find_case, read_tree
from ...case.ssp import export_ssp
from ...case.system import open_system
from ...fmi.builder import build_fmu
from ..common import Changes, OutputFile, parse_changes, say, tell

command = App(
    name="export",
    usage="Usage: piston-cosim fmu export [ssp] --output PATH CASE\n",
)


@command.default
def fmu(
    case: str,
    /,
    *,
    set_: Changes = [],
    output: OutputFile,
    fmi: Literal["2.0", "3.0"] = "2.0",
    native: Annotated[bool, Parameter(negative=())] = False,
    platform: str = "linux64",
):
    """Export a case as one FMU.

    The FMU contains all participants and the coupling iteration. Use it in tools that cannot repeat
    a step.

    Example: piston-cosim fmu export numerical_example --output engine.fmu

    Parameters
    ----------
    case
        Name of a case, its folder or its file.
    set_
        Change of the case, KEY=VALUE; repeatable.
    output
        File to write.
    fmi
        Version of FMI.
    native
        Write machine code that needs no Python. Reports each option that it does not support.
    platform
        Platforms of a native FMU, separated by commas: linux64, win64, aarch64-linux, darwin64,
        aarch64-darwin. Needs a C compiler, except for platforms whose library is installed.
    """
    platforms = platform.split(",") if native else ()
    path = find_case(case)
    checked = check_case(read_tree(path, parse_changes(set_)), path)
    made = export_fmu(checked, path.parent, say, fmi, platforms)
    output.write_bytes(made.read_bytes())
    if not native:
        compile_code(made, say)
    tell(str(output))


@command.command
def ssp(
    case: str, /, *, set_: Changes = [], output: OutputFile, fmi: Literal["2.0", "3.0"] = "2.0"
):
    """Export a case as an SSP.

    The SSP contains the FMUs of the case, their parameters and their connections.

    Example: piston-cosim fmu export ssp numerical_example --output engine.ssp

    Parameters
    ----------
    case
        Name of a case, its folder or its file.
    set_
        Change of the case, KEY=VALUE; repeatable.
    output
        File to write.
    fmi
        Version of FMI. With 2.0 the file is SSP 1.0 with one connector per scalar. With 3.0 it is
        SSP 2.0 with arrays.
    """
    path = find_case(case)
    tree = read_tree(path, parse_changes(set_))
    system = open_system(built(check_case(tree, path), path.parent, fmi), path.parent, say)
    export_ssp(tree, system, output)
    for participant in system.participants.values():
        compile_code(participant.path, say)
    tell(str(output))


def built(case, folder, fmi):
    """Return the case with FMUs of this FMI version instead of the packages that build them.

    Their default experiment is the run of the case.
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
