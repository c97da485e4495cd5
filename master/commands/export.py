"""`piston-cosim export`."""

from pathlib import Path
from typing import Literal

from ..case import check_case, find_case, read_tree
from ..export import export_fmu
from ..ssp import export_ssp
from ..system import open_system
from .common import Changes, console, parse_change, say


def command(kind: Literal["fmu", "ssp"], case: str, *, set_: Changes = [], output: Path):
    """Export a case: as one FMU with the iteration inside, for tools that cannot repeat a step, or as an SSP.

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
    """
    path = find_case(case)
    tree = read_tree(path, [parse_change(text) for text in set_])
    checked = check_case(tree, path)
    if kind == "fmu":
        output.write_bytes(export_fmu(checked, path.parent, say).read_bytes())
    else:
        export_ssp(tree, open_system(checked, path.parent, say), output)
    console.print(str(output), soft_wrap=True, highlight=False)
