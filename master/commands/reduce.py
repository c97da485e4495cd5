"""`piston-cosim reduce`."""

from rich.table import Table

from ..api.bodies import reduced
from ..case.reading import find_case, read_tree
from ..runs.working import working
from .common import Changes, OutputFolder, console, default_folder, parse_changes, print_line, say


def command(source: str, /, *, set_: Changes = [], output: OutputFolder | None = None):
    """Reduce flexible bodies and list their modes.

    The command reads meshes or matrices. It writes a reduced body, a table of its modes, pictures
    and VTU files of the mode shapes.

    Example: piston-cosim reduce numerical_example --set participants.bodies.build.piston.modes=20

    Parameters
    ----------
    source
        Case that builds bodies, or a TOML file with the key `grid` and the tables `piston`, `block`
        or both.
    set_
        Change of the case, KEY=VALUE, e.g. `viscosity="20 mPa s"`; repeatable.
    output
        Folder. Default: results/SOURCE/bodies.
    """
    path = find_case(source)
    tree = read_tree(path, parse_changes(set_))
    folder = output or default_folder(path) / "bodies"
    with working(console, "preparing bodies"):
        bodies = reduced(tree, path.parent, folder, say)
    for body in bodies:
        print_body(body)


def print_body(body):
    """Print size, mass properties, cost and modes of a reduced body."""
    centre = body.centre
    inertia = body.inertia
    console.print(
        f"\n[bold]{body.name}[/]  {body.nodes} nodes, {body.elements} elements, "
        f"{body.degrees_of_freedom} degrees of freedom",
        highlight=False,
    )
    console.print(
        f"mass {body.mass:.6g} kg, "
        f"centre of mass at {', '.join(f'{1e3 * x:z.4f}' for x in centre)} mm",
        highlight=False,
    )
    console.print(
        "inertia about it  "
        + "  ".join(
            f"{name} {inertia[at]:.5g}"
            for name, at in zip(
                ("xx", "yy", "zz", "xy", "yz", "zx"),
                ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)),
            )
        )
        + " kg m2",
        highlight=False,
    )
    console.print(
        f"reduced in {body.seconds:.1f} s, "
        f"peak memory of the process {body.peak_memory / 1e9:.2f} GB",
        highlight=False,
    )
    table = Table(
        "mode", "frequency [Hz]", "modal mass [g]", "share in film thickness", "class", box=None
    )
    for row in body.modes:
        table.add_row(
            str(row.number),
            f"{row.frequency:.1f}",
            f"{1e3 * row.modal_mass:.3g}",
            f"{100 * row.film_share:.2f} %",
            row.kind_in_words,
        )
    if body.modes:
        console.print(table)
    if body.errors:
        console.print(f"the modes {body.errors}", highlight=False)
    for file in body.files:
        print_line(f"file  {file}")
