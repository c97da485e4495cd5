"""`piston-cosim new`."""

import tempfile
from dataclasses import make_dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from ..engine.new import SIZES, engine, write_case
from ..engine.piston_mesh import mesh_of_sizes
from ..engine.step_mesh import mesh_of_step
from ..fmi.errors import BadInput
from .check import print_checked
from .common import console


def _option(name: str) -> Any:
    """A size as an option of the command."""
    size = SIZES[name]
    unit = f" [{size.unit}]" if size.unit else ""
    words = f"; without it {size.words}, our estimate" if size.rule else ""
    told = Parameter(help=f"{size.meaning}{unit}{words}.", allow_leading_hyphen=True)
    return (name, Annotated[str | None, told], None)


HERE = {"__module__": __name__}
"""Without it a made class counts as built in, and has no options."""
Sizes: Any = make_dataclass("Sizes", map(_option, SIZES), frozen=True, namespace=HERE)
"""The sizes of an engine, as text: a number in the unit shown, or with a unit of its own."""


def command(
    name: Path,
    *,
    sizes: Annotated[Sizes, Parameter(name="*")] = Sizes(),  # noqa: B008  # pyright: ignore
    peak_pressure: str | None = None,
    motored: Annotated[bool, Parameter(negative=())] = False,
    piston: Literal["data-sheet", "slipper", "full"] | None = None,
    mesh: Path | None = None,
    step: Path | None = None,
):
    """Write a commented case of an own engine that runs at once, from a few lengths; the piston of
    a data sheet, of our own proportions, of a mesh or of a STEP file. What is estimated is marked,
    with its rule.

    Example: piston-cosim new my_engine --bore 86 --stroke 86 --rod 143 --piston slipper

    Parameters
    ----------
    name
        Folder to be made.
    peak_pressure
        Largest gas pressure, gauge [bar]; without it 1.9 times what compression gives is added
        by burning, our estimate.
    motored
        Compression and expansion without combustion.
    piston
        data-sheet: rigid, without a mesh (the default); slipper, full: flexible, a mesh of our own
        proportions made by gmsh (extra mesh), its skirt two panels or all around.
    mesh
        Mesh of the piston: 10-node tetrahedra (.msh, .inp, .bdf), surfaces skirt, crown and
        pin_bore, x thrust, y towards the head, z pin, origin on the pin's axis.
    step
        STEP file of the piston, meshed by gmsh (extra mesh); axes likewise.
    """
    made = engine(vars(sizes), peak_pressure, motored)
    given = {"--piston": piston, "--mesh": mesh, "--step": step}
    if len(named := [option for option, value in given.items() if value]) > 1:
        raise BadInput(f"{' and '.join(named)}: give one of them")
    with tempfile.TemporaryDirectory() as place:
        if step:
            mesh = Path(place) / "piston.msh"
            mesh_of_step(step, mesh, made["bore"])
        elif piston in ("slipper", "full"):
            mesh = Path(place) / "piston.msh.xz"
            with console.status("meshing"):
                mesh_of_sizes(made, piston, mesh)
        found = write_case(made, name, mesh)
    console.print(f"case     {found.path}", highlight=False, soft_wrap=True)
    print_checked(found, name / "check.png")
    console.print(f"run it   piston-cosim run {name}", highlight=False, soft_wrap=True)
