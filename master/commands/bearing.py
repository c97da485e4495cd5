"""`piston-cosim bearing`."""

from collections.abc import Collection
from typing import Annotated, Any

from cyclopts import Parameter

from ..fmi.errors import BadInput, Discard, Stopped
from ..fmi.tree import import_part
from .common import Changes, PictureFile, parse_changes, print_line, say

Quantity = Annotated[str | None, Parameter(allow_leading_hyphen=True)]
"""Number with a unit; a missing one is reported with the other faults."""


def command(
    *,
    radius: Quantity = None,
    length: Quantity = None,
    clearance: Quantity = None,
    speed: Quantity = None,
    load: Quantity = None,
    oil: Quantity = None,
    supply: str = "flooded",
    supply_pressure: Annotated[str, Parameter(allow_leading_hyphen=True)] = "0 bar",
    groove_angle: Annotated[str, Parameter(allow_leading_hyphen=True)] = "180 deg",
    grid: tuple[int, int] = (120, 24),
    set_: Changes = [],
    picture: PictureFile | None = None,
):
    """Compute a journal bearing under a constant load.

    The command prints eccentricity, attitude angle, film, pressure, friction, flow, stiffness and
    damping, each with its uncertainty by the grid. `piston_cosim.bearing` returns the same.

    Example: piston-cosim bearing --radius "25 mm" --length "25 mm" --clearance "25 um"
    --speed "3000 rpm" --load "2 kN" --oil "SAE 5W-30 at 90 degC"

    Parameters
    ----------
    radius
        Radius of the shell, with a unit like all values.
    length
        Length of the bearing.
    clearance
        Radial clearance.
    speed
        Speed of the journal.
    load
        Load on the journal.
    oil
        Viscosity, such as "12 mPa s", or oil and temperature, such as "SAE 5W-30 at 90 degC".
    supply
        Oil supply: flooded or groove.
    supply_pressure
        Gauge pressure in the groove.
    groove_angle
        Angle from the load to the groove in the direction of rotation.
    grid
        Cells around and along, multiples of 120 and 24.
    set_
        Other parameter of the film, NAME=VALUE, e.g. `roughness_rms="0.3 um"`; repeatable.
    picture
        Picture of the bearing: .png, .svg or .pdf.
    """
    part: Any = import_part("fmu_ehd.bearing")
    inputs = dict(
        radius=radius, length=length, clearance=clearance, speed=speed, load=load, oil=oil
    )
    inputs |= dict(supply=supply, supply_pressure=supply_pressure, groove_angle=groove_angle)
    others = dict(parse_changes(set_)) | {"grid": grid}
    if twice := [name for name in others if name in inputs]:
        options = (name.replace("_", "-") for name in twice)
        raise BadInput([f"--set: expected --{name} instead, got {name}=..." for name in options])
    try:
        result = part.bearing(**inputs, **others, progress=say)
    except BadInput as error:
        raise BadInput([_of_option(fault, {*inputs, "grid"}) for fault in error.faults]) from None
    except Discard as error:
        raise Stopped(f"{error}; try another load, or roughness_rms for contact") from None
    print_line(str(result), markup=False)
    if picture:
        result.plot().savefig(picture)
        print_line(f"picture   {picture}")


def _of_option(fault: str, options: Collection[str]) -> str:
    """Return a fault with the option that the user writes, if its key is one."""
    name, colon, text = fault.partition(":")
    return f"--{name.replace('_', '-')}{colon}{text}" if name in options else fault
