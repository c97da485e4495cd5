"""`piston-cosim fmu export`."""

from typing import Annotated, Literal

from cyclopts import Parameter

from ...api.cases import open_case
from ...api.fmus import compile_code
from ...case.checked import check_case
from ...case.export import experiment_ahead, export_fmu
from ...case.ssp import export_ssp
from ...case.system import open_system
from ...fmi.errors import BadInput
from ..common import Changes, Only, OutputFile, native_platforms, parse_changes, print_line, say


def command(
    case: str,
    /,
    *,
    set_: Changes = [],
    only: Only = None,
    output: OutputFile,
    fmi: Literal["2.0", "3.0"] = "2.0",
    native: Annotated[bool, Parameter(negative=())] = False,
    platform: str | None = None,
):
    """Export a case as one FMU or as an SSP.

    The FMU contains all participants and the coupling iteration. Use it in tools that cannot repeat
    a step. An SSP contains the FMUs of the case, their parameters and their connections.

    Example: piston-cosim fmu export numerical_example --output engine.fmu

    Example: piston-cosim fmu export numerical_example --output engine.ssp

    Parameters
    ----------
    case
        Name of a case, its folder or its file.
    set_
        Change of the case, KEY=VALUE; repeatable.
    only
        Variant of the case. Default: the case itself.
    output
        File to write. The suffix .ssp selects an SSP.
    fmi
        Version of FMI. With 2.0 an SSP is of version 1.0 with one connector per scalar. With 3.0 it
        is of version 2.0 with arrays.
    native
        Write an FMU of machine code that needs no Python. Reports each option that it does not
        support.
    platform
        Platforms of a native FMU, separated by commas: linux64, win64, aarch64-linux, darwin64,
        aarch64-darwin. Default: linux64. Needs a C compiler, except for platforms whose library is
        installed.
    """
    if output.suffix not in (".fmu", ".ssp"):
        raise BadInput(f"--output: expected a file *.fmu or *.ssp, got {str(output)!r}")
    platforms = native_platforms(platform, native)
    opened = open_case(case, dict(parse_changes(set_)), only)
    tree, path = opened.tree, opened.path
    checked = check_case(tree, path)
    if output.suffix == ".ssp":
        if native:
            raise BadInput("--native: expected one FMU, got an SSP")
        system = open_python(checked, path.parent, fmi)
        export_ssp(tree, system, output)
        own = [name for name, table in checked.participants.items() if table.package]
        files = [system.participants[name].path for name in own]
    else:
        files = [export_fmu(checked, path.parent, say, fmi, platforms)]
        output.write_bytes(files[0].read_bytes())
    for one in () if native else files:
        compile_code(one, say)
    print_line(str(output))


def open_python(case, folder, fmi):
    """Return the system of a case whose FMUs are built for Python, with this version of FMI.

    Their default experiment is the run of the case. Raises `BadInput` if a participant is a table
    or a plugin.
    """
    others = [
        f"participants.{name}: expected an FMU in an SSP, got a {kind}"
        for name, table in case.participants.items()
        for kind in ("table", "plugin")
        if getattr(table, kind)
    ]
    if others:
        raise BadInput(others)
    options = {"version": fmi, "experiment": experiment_ahead(case, folder)}
    return open_system(case.model_copy(update={"native": None}), folder, say, fmu_options=options)
