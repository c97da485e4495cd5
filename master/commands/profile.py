"""`piston-cosim profile`."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..fmi.errors import BadInput, for_all
from ..fmi.quantities import to_si
from ..fmi.tree import import_part
from .check import print_figures
from .common import OutputFile, tell

READER = "fmu_mfbd.profile_reader"
"""Module that reads profiles, called by name because this package does not import bodies."""


def command(
    file: Path,
    /,
    *,
    angle_unit: str = "1 deg",
    height_unit: str = "1 mm",
    value_unit: str = "1 um",
    turn: Annotated[str, Parameter(allow_leading_hyphen=True)] = "0 deg",
    skirt_lower: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    skirt_upper: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    radius: str | None = None,
    smooth: Annotated[bool, Parameter(negative=())] = False,
    output: OutputFile | None = None,
    picture: OutputFile | None = None,
):
    """Read a measured profile of a skirt, judge and draw it.

    The command prints size, form and noise of the table. It reports dust, a wrong sign, a turn,
    diameters, and heights without values. `check` reports the same for the profiles of a case.

    Example: piston-cosim profile skirt.csv --smooth --output skirt-smooth.csv

    Parameters
    ----------
    file
        CSV file. The first row holds angles from the pin axis towards thrust. Each further row
        holds a height above the pin and the distances inside the nominal radius.
    angle_unit
        Unit of the angles.
    height_unit
        Unit of the heights.
    value_unit
        Unit of the values. Use "-1 um" for values positive outwards, "0.5 um" for differences of
        diameters.
    turn
        Angle to add to all angles, e.g. "90 deg" if they count from the thrust side.
    skirt_lower
        Lower end of the skirt above the pin, e.g. "-26 mm". Default: that of the table.
    skirt_upper
        Upper end of the skirt above the pin. Default: that of the table.
    radius
        Nominal radius of the skirt, to judge the size of barrel and ovality.
    smooth
        Remove noise and dust: a Fourier series around and smoothing splines along.
    output
        CSV file for the table after these changes, in deg, mm and um.
    picture
        Picture of the profile: .png, .svg or .pdf. Default: results/profile/FILE.png.
    """
    given = {
        "angle_unit": (angle_unit, "rad"),
        "height_unit": (height_unit, "m"),
        "value_unit": (value_unit, "m"),
        "turn": (turn, "rad"),
        "lower": (skirt_lower, "m"),
        "upper": (skirt_upper, "m"),
        "radius": (radius, "m"),
    }
    *units, turned, lower, upper, size = for_all(_in_si, given.items())
    reader: Any = import_part(READER)
    ends = {key: value for key, value in (("lower", lower), ("upper", upper)) if value is not None}
    reading = reader.Reading(units, turned, **ends, **({"radius": size} if size else {}))
    drawn = picture or Path("results/profile") / f"{file.stem}.png"
    drawn.parent.mkdir(parents=True, exist_ok=True)
    report = reader.read_profile(file, reading, drawn, smooth, output)
    print_figures(report.figures)
    for message in report.messages:
        if message.kind != "fault":
            tell(f"[yellow]{message.kind:8s}[/] {message.text}")
    for line in report.changes:
        tell(f"changed   {line}")
    tell(f"picture   {drawn}")
    if output:
        tell(f"table     {output}")
    if faults := [message.text for message in report.messages if message.kind == "fault"]:
        raise BadInput([f"{file}: {text}" for text in faults])


def _in_si(item: tuple[str, tuple[str | None, str]]) -> float | None:
    """Return the value of an option in SI."""
    name, (text, unit) = item
    try:
        return None if text is None else to_si(text, unit)
    except ValueError as error:
        raise BadInput(f"--{name.replace('_', '-')}: {error}") from None
