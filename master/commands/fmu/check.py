"""`piston-cosim fmu check`."""

from pathlib import Path

from ...case.contract import check_fmu
from ...fmi.errors import BadInput
from ..common import print_line


def command(fmu: Path, /):
    """Compare an FMU with the contract of its role.

    The contract lists the variables that a lubrication or body model must have.

    Example: piston-cosim fmu check film.fmu

    Parameters
    ----------
    fmu
        File of the FMU.
    """
    role, breaches, remarks = check_fmu(fmu)
    for line in remarks:
        print_line(f"remark: {line}", markup=False)
    if breaches:
        raise BadInput([f"{fmu}, {line}" for line in breaches])
    print_line(f"[green]{fmu} can take part as {role}[/]")
