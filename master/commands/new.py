"""`piston-cosim new`."""

import tempfile
from dataclasses import make_dataclass
from pathlib import Path
from shlex import quote
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from ..case.reading import case_names
from ..engine.new import SIZES, engine, unusual, write_case
from ..engine.piston_mesh import mesh_of_sizes
from ..engine.step_mesh import mesh_of_step
from ..fmi.errors import BadInput
from ..runs.working import working
from .check import print_checked
from .common import OutputFolder, console, print_line


def _option(name: str) -> Any:
    """Return a size as an option of the command: name, type, default."""
    size = SIZES[name]
    unit = f" [{size.unit}]" if size.unit else ""
    rule = f" Default: estimate, {size.words}." if size.rule else ""
    option = Parameter(help=f"{size.meaning}{unit}.{rule}", allow_leading_hyphen=True)
    return (name, Annotated[str | None, option], None)


HERE = {"__module__": __name__}
"""Module of the generated class, without which cyclopts does not read its options."""
Sizes: Any = make_dataclass("Sizes", map(_option, SIZES), frozen=True, namespace=HERE)
"""Sizes of an engine as text: a number in the unit of its option, or a number with its unit."""


def command(
    name: OutputFolder,
    /,
    *,
    sizes: Annotated[Sizes, Parameter(name="*")] = Sizes(),  # noqa: B008  # pyright: ignore
    peak_pressure: str | None = None,
    motored: Annotated[bool, Parameter(negative=())] = False,
    piston: Literal["data-sheet", "slipper", "full"] | None = None,
    mesh: Path | None = None,
    step: Path | None = None,
):
    """Write a case of your own engine.

    The case is complete, has comments, and runs until its cycle settles. The command estimates each
    size that you omit and marks it with its rule. A number without a unit is in the unit shown.

    Example: piston-cosim new my_engine --bore 86 --stroke 86 --rod 143 --piston slipper

    Parameters
    ----------
    name
        Folder to create.
    peak_pressure
        Maximum gas pressure, gauge [bar]. Default: estimated from the heat of a full load of
        petrol, or of diesel from a compression ratio of 14 on.
    motored
        Compression and expansion without combustion.
    piston
        data-sheet: rigid, without a mesh. slipper: flexible, with two skirt panels. full: flexible,
        with a skirt all around. The flexible pistons need the extra `mesh`. Default: data-sheet.
    mesh
        Mesh of the piston: 10-node tetrahedra (.msh, .inp, .bdf) with the surfaces skirt, crown and
        pin_bore. The origin is on the pin axis, x points to thrust, y to the head, z along the pin.
    step
        STEP file of the piston in the same axes. The extra `mesh` (gmsh) meshes it.
    """
    new_engine = engine(vars(sizes), peak_pressure, motored)
    sources = {"--piston": piston, "--mesh": mesh, "--step": step}
    if len(named := [option for option, value in sources.items() if value]) > 1:
        raise BadInput(f"{named[0]}: expected one source of the piston, got {' and '.join(named)}")
    with tempfile.TemporaryDirectory() as place:
        if step:
            mesh = Path(place) / "piston.msh"
            mesh_of_step(step, mesh, new_engine["bore"])
        elif piston in ("slipper", "full"):
            mesh = Path(place) / "piston.msh.xz"
            with working(console, "meshing"):
                mesh_of_sizes(new_engine, piston, mesh)
        checked = write_case(new_engine, name, mesh)
    checked.warnings.extend(unusual(new_engine))
    if str(name) in case_names():
        text = "a shipped case has this name; in this folder, commands use yours"
        checked.remarks.append(f"{name}: {text}")
    print_line(f"case     {checked.path}")
    print_checked(checked, name / "check.png")
    print_line(f"run it   piston-cosim run {quote(str(name))}", markup=False)
