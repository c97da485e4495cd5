"""`piston-cosim check`."""

from collections.abc import Iterable
from pathlib import Path

from ..case.check import CheckedCase, check
from ..fmi.errors import BadInput
from ..fmi.preview import Figure
from ..fmi.quantities import short
from .common import Changes, Only, PictureFile, default_folder, parse_changes, print_line


def command(
    source: str,
    /,
    *,
    only: Only = None,
    set_: Changes = [],
    picture: PictureFile | None = None,
):
    """Check a case without a run.

    The command prints every fault, geometry, masses, clearance and the cells with a film, and draws
    skirt and bore. For a system of FMUs it prints each loop with its gain, its condition, and the
    method and step that suit it.

    Example: piston-cosim check my_engine

    Parameters
    ----------
    source
        Name of a case, its folder or its file. `piston-cosim list` prints the names.
    only
        Check this variant of the case.
    set_
        Change of the case, KEY=VALUE, e.g. `viscosity="20 mPa s"`; repeatable.
    picture
        Picture of skirt and bore: .png, .svg or .pdf. Default: results/CASE/check.png.
    """
    checked = check(source, parse_changes(set_), only)
    print_checked(checked, picture or default_folder(checked.path) / "check.png")


def print_checked(checked: CheckedCase, picture: Path):
    """Print the checks of a case and draw it; raise BadInput if it has faults."""
    print_line(f"[bold]{checked.title}[/]")
    for preview in checked.previews.values():
        print_figures(preview.figures)
    for line in checked.loop_table():
        print_line(line, markup=False)
    for kind, lines in (("[yellow]warning[/]", checked.warnings), ("remark ", checked.remarks)):
        for line in lines:
            print_line(f"{kind}  {line}")
    for file in checked.draw(picture):
        print_line(f"picture  {file}")
    if checked.faults:
        raise BadInput(checked.faults)
    numbers = {"warning": len(checked.warnings), "remark": len(checked.remarks)}
    counts = [f"{n} {kind}{'s' * (n > 1)}" for kind, n in numbers.items() if n]
    print_line(", ".join(["[green]no faults[/]", *counts]))


def print_figures(figures: Iterable[Figure]):
    """Print figures, one line for each of their groups."""
    groups: dict[str, list[Figure]] = {}
    for figure in figures:
        groups.setdefault(figure.group, []).append(figure)
    for group, members in groups.items():
        text = "   ".join(map(_figure_text, members))
        print_line(f"  {group:10s} {text}", markup=False)


def _figure_text(figure: Figure) -> str:
    """Return a figure as text with its name."""
    note = f" ({figure.note})" if figure.note else ""
    return f"{figure.name.replace('_', ' ')} {_value_text(figure)}{note}"


def _value_text(figure: Figure) -> str:
    """Return its value as text: in mm or um, cm^3, degC, or percent for a share."""
    if figure.unit == "m":
        size = abs(figure.value)
        return (
            f"{1e3 * figure.value:.5g} mm"
            if size >= 1e-3 or not size
            else (f"{1e6 * figure.value:.4g} \N{MICRO SIGN}m")
        )
    if figure.unit == "m3":
        return f"{1e6 * figure.value:.5g} cm^3"
    if figure.unit == "kg.m2":
        return f"{1e6 * figure.value:.4g} kg mm^2"
    if figure.unit == "K":
        return f"{figure.value - 273.15:.4g} degC"
    if "share" in figure.name:
        return f"{100 * figure.value:.4g} %"
    if figure.unit == "1":
        return f"{figure.value:g}"
    return short(figure.value, figure.unit)
