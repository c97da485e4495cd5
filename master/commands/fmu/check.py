"""`piston-cosim fmu check`."""

from pathlib import Path

from ...case.contract import check_fmu
from ...fmi.errors import BadInput
from ..common import console


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
        console.print(f"remark: {line}", markup=False, highlight=False, soft_wrap=True)
    if breaches:
        raise BadInput([f"{fmu}, {line}" for line in breaches])
    console.print(f"[green]{fmu} can take part as {role}[/]", highlight=False, soft_wrap=True)
