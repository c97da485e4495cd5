"""`piston-cosim profile`."""

from pathlib import Path
from typing import Annotated, Any, TypeVar

from cyclopts import Parameter

from ..fmi.errors import BadInput, for_all
from ..fmi.quantities import in_unit, to_si
from ..fmi.tree import import_part
from .check import print_figures
from .common import OutputFile, PictureFile, print_line

READER = "fmu_mfbd.profile_reader"
"""Module that reads profiles, called by name because this package does not import bodies."""
UNITS = ("angle_unit", "height_unit", "value_unit")
"""Options that are units of the table, of which those of angles and heights are positive."""
POSITIVE = ("angle_unit", "height_unit", "radius")
Value = TypeVar("Value")
Signed = Annotated[Value, Parameter(allow_leading_hyphen=True)]
"""Option whose value may begin with a minus sign."""


def command(
    file: Path,
    /,
    *,
    angle_unit: Signed[str] = "1 deg",
    height_unit: Signed[str] = "1 mm",
    value_unit: Signed[str] = "1 um",
    turn: Signed[str] = "0 deg",
    skirt_lower: Signed[str | None] = None,
    skirt_upper: Signed[str | None] = None,
    radius: Signed[str | None] = None,
    smooth: Annotated[bool, Parameter(negative=())] = False,
    output: OutputFile | None = None,
    picture: PictureFile | None = None,
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
    entries = {
        "angle_unit": (angle_unit, "rad"),
        "height_unit": (height_unit, "m"),
        "value_unit": (value_unit, "m"),
        "turn": (turn, "rad"),
        "skirt_lower": (skirt_lower, "m"),
        "skirt_upper": (skirt_upper, "m"),
        "radius": (radius, "m"),
    }
    *units, turned, lower, upper, size = for_all(_in_si, entries.items())
    if output and output.exists() and file.exists() and output.samefile(file):
        raise BadInput(f"--output: expected another file than the profile, got {str(output)!r}")
    reader: Any = import_part(READER)
    ends = {key: value for key, value in (("lower", lower), ("upper", upper)) if value is not None}
    reading = reader.Reading(units, turned, **ends, **({} if size is None else {"radius": size}))
    drawn = picture or Path("results/profile") / f"{file.stem}.png"
    drawn.parent.mkdir(parents=True, exist_ok=True)
    report = reader.read_profile(file, reading, drawn, smooth, output)
    print_figures(report.figures)
    for message in report.messages:
        if message.kind != "fault":
            print_line(f"[yellow]{message.kind:8s}[/] {message.text}")
    for line in report.changes:
        print_line(f"changed   {line}")
    print_line(f"picture   {drawn}")
    if output:
        print_line(f"table     {output}")
    if faults := [message.text for message in report.messages if message.kind == "fault"]:
        raise BadInput([f"{file}: {text}" for text in faults])


def _in_si(item: tuple[str, tuple[str | None, str]]) -> float | None:
    """Return the value of an option in SI; a unit may stand without the number 1."""
    name, (text, unit) = item
    key = f"--{name.replace('_', '-')}"
    try:
        value = to_si(in_unit(unit, alone=name in UNITS).with_number(text), unit) if text else None
    except ValueError as error:
        raise BadInput(f"{key}: {error}") from None
    if value is not None and (value <= 0.0 if name in POSITIVE else name in UNITS and not value):
        expected = "above 0" if name in POSITIVE else "other than 0"
        raise BadInput(f"{key}: expected a value {expected} {unit}, got {text!r}")
    return value
