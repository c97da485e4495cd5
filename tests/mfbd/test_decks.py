"""Input decks of other programs, written here in the form that these programs write.

The programs are Nastran, Abaqus (parts, instances and included files), ANSYS and gmsh. Each deck
is read back as its original mesh: the same elements in the same order, with ten nodes each at
their positions. The elastic energy of a field that bends the elements is therefore the same. Node
numbers have gaps and run against the order of the nodes.
"""

import gzip

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.finite_elements.abaqus import rotation
from piston_cosim.fmu_mfbd.finite_elements.element import stiffness
from piston_cosim.fmu_mfbd.finite_elements.mesh import MeshFault, read_mesh, read_raw

SURFACES = ("skirt", "crown", "pin_bore")


@pytest.fixture(scope="module")
def source(coarse):
    """Return a piston with curved edges."""
    return read_mesh(coarse[0] / "piston.msh", dict.fromkeys(SURFACES))


def number(row):
    """Return the number of a node in the decks, falling with its row."""
    return 90001 - 3 * np.asarray(row)


def bending_energy(mesh):
    """Elastic energy of u = (y z, x^2, x y) + a cubic one, which the middles of the edges know."""
    x, y, z = mesh.points.T / 20e-3
    field = np.stack([y * z + x**3, x**2 - y * z**2, x * y], axis=1).ravel()
    return field @ stiffness(mesh.points, mesh.tets, 75e9, 0.33) @ field


def assert_same(mesh, source, digits=1e-12):
    """Check that elements, positions [m], energy and surfaces are the same."""
    np.testing.assert_allclose(
        mesh.points[mesh.tets], source.points[source.tets], rtol=0, atol=digits
    )
    assert len(mesh.points) == len(source.points)
    # places known to `digits` of lengths of 20 mm and more; elements are 3 mm and more
    assert bending_energy(mesh) == pytest.approx(bending_energy(source), rel=1e3 * digits)
    for name in mesh.faces:
        np.testing.assert_allclose(
            mesh.points[mesh.faces[name]], source.points[source.faces[name]], atol=digits
        )


def test_energy_tells_the_middles_of_edges_apart(source):
    """What the other tests stand on: gmsh's own order of the last two middles is not that."""
    turned = source.tets.copy()
    turned[:, [8, 9]] = turned[:, [9, 8]]
    wrong = type(source)(source.points, turned, {})
    assert bending_energy(wrong) != pytest.approx(bending_energy(source), rel=1e-3)


# Nastran


def small(*fields):
    return "".join(f"{field!s:<8}" for field in fields)


def tetra_cards(nodes, label, style):
    """Return a CTETRA whose continuation begins with blanks or a mark, or is between commas."""
    if style == "free":
        yield f"CTETRA,{label},7," + ",".join(map(str, nodes[:6]))
        yield "," + ",".join(map(str, nodes[6:]))
    elif style == "large":
        fields = [f"{field!s:<16}" for field in (label, 7, *nodes)]
        for k in range(0, 12, 4):
            yield f"{'CTETRA*' if k == 0 else '*':<8}" + "".join(fields[k : k + 4])
    else:
        mark = f"+E{label}" if style == "marked" else ""
        yield small("CTETRA", label, 7, *nodes[:6]) + mark
        yield small(mark, *nodes[6:])


def nastran(source, style, system="", points=None):
    points = source.points if points is None else points
    lines = ["$ made in a test", "SOL 101", "CEND", "BEGIN BULK"]
    for row, (x, y, z) in enumerate(points):
        lines += [
            f"{'GRID*':<8}{number(row):<16}{system:<16}{x:<16.9E}{y:<16.9E}",
            f"{'*':<8}{z:<16.9E}",
        ]
    for label, nodes in enumerate(number(source.tets), 1):
        lines += tetra_cards(nodes, label, style)
    return [*lines, small("RBE2", 99, number(0), 123, number(1)), "ENDDATA", "after the end"]


@pytest.mark.parametrize("style", ["blank", "marked", "free", "large"])
def test_nastran(source, tmp_path, style):
    """Some programs leave BEGIN BULK out."""
    path = tmp_path / "piston.bdf"
    lines = nastran(source, style)
    for text in (lines, lines[lines.index("BEGIN BULK") + 1 :]):
        path.write_text("\n".join(text))
        assert_same(read_mesh(path, {}), source, 1e-10)  # ten digits
        assert list(read_raw(path).labels) == list(number(np.arange(len(source.points))))


def test_nastran_in_a_turned_system_and_an_included_file(source, tmp_path):
    """A CORD2R on another; the nodes stand in a file beside the deck."""
    outer = rotation(np.array([1.0, 2.0, -0.5]), 0.7)
    inner = rotation(np.array([0.3, -1.0, 2.0]), -1.1)
    first, second = np.array([0.01, -0.02, 0.03]), np.array([-0.05, 0.01, 0.02])
    # basic = first + outer (second + inner local)
    local = ((source.points - first) @ outer - second) @ inner
    lines = nastran(source, "blank", "12", local)
    cards = []
    for label, base, origin, turn in ((11, 0, first, outer), (12, 11, second, inner)):
        seen = [*origin, *(origin + turn[:, 2]), *(origin + turn @ [2.0, 0.0, 5.0])]
        text = [f"{value:.15g}" for value in seen]
        cards += [f"CORD2R,{label},{base}," + ",".join(text[:6]), "+," + ",".join(text[6:])]
    begin = lines.index("BEGIN BULK")
    nodes = [line for line in lines if line.startswith(("GRID", "* "))]
    rest = [line for line in lines[begin + 1 :] if line not in nodes]
    (tmp_path / "nodes.bdf").write_text("\n".join(nodes))
    path = tmp_path / "deck.bdf"
    path.write_text("\n".join([*lines[: begin + 1], *cards, "INCLUDE 'nodes.bdf'", *rest]))
    assert_same(read_mesh(path, {}), source, 1e-10)


# Abaqus


def abaqus_part(source, points, sets=True, shell="STRI65"):
    """Nodes, elements and sets of a part: a set of nodes, a set of shells, a surface by sides."""
    lines = ["****** N O D E S ******", "*Node"]
    lines += [
        f"{number(row)}, {x!r}, {y!r}, {z!r}" for row, (x, y, z) in enumerate(points.tolist())
    ]
    lines += ["*Element, type=C3D10M, elset=Solid"]
    for label, nodes in enumerate(number(source.tets).tolist(), 1):
        cells = [f"{cell}" for cell in (label, *nodes)]
        lines += [", ".join(cells[:8]) + ",", ", ".join(cells[8:])]
    if not sets:
        return lines
    nodes = number(source.nodes("crown")).tolist()
    lines += [
        "*Nset, nset=Crown",
        *(", ".join(map(str, nodes[k : k + 16])) for k in range(0, len(nodes), 16)),
    ]
    lines += [f"*Element, type={shell}, elset=pin_bore"]
    lines += [
        ", ".join(map(str, (500000 + k, *nodes)))
        for k, nodes in enumerate(number(source.faces["pin_bore"]).tolist())
    ]
    corners = {frozenset(face[:3]) for face in source.faces["skirt"].tolist()}
    for side, places in (
        ("S1", (0, 1, 2)),
        ("S2", (0, 1, 3)),
        ("S3", (1, 2, 3)),
        ("S4", (0, 2, 3)),
    ):
        found = [
            label
            for label, nodes in enumerate(source.tets.tolist(), 1)
            if frozenset(nodes[place] for place in places) in corners
        ]
        lines += [f"*Elset, elset=_skirt_{side}, internal", *(f"{label}," for label in found)]
    return [
        *lines,
        "*Surface, type=ELEMENT, name=skirt",
        *(f"_skirt_{side}, {side}" for side in ("S1", "S2", "S3", "S4")),
    ]


def placed_part(source, shift, centre, turn):
    """Return a mesh in the coordinates of its part.

    The instance moves the part by `shift`, then turns it about `centre`.
    """
    return (source.points - centre) @ turn + centre - shift


SHIFT, CENTRE, AXIS, ANGLE = (
    np.array([0.3, -0.1, 0.2]),
    np.array([0.02, 0.05, -0.01]),
    np.array([1.0, -2.0, 0.5]),
    37.0,
)


def assembly(source, tmp_path, solids=("Piston-1",)):
    """Return an assembly in the form that CAE writes.

    One part is never used, and the mesh of another is included. Its instance is moved and turned.
    The assembly also has a rigid plate and a reference point.
    """
    turn = rotation(AXIS, np.radians(ANGLE))
    points = placed_part(source, SHIFT, CENTRE, turn)
    part = abaqus_part(source, points)
    (tmp_path / "mesh").mkdir(exist_ok=True)
    (tmp_path / "mesh/elements.inp").write_text("\n".join(part[len(points) + 2 :]))
    (tmp_path / "mesh/nodes.inp").write_text(
        "\n".join([*part[: len(points) + 2], "*Include, input=elements.inp"])
    )
    lines = ["*Heading", " made in a test", "** PARTS", "*Part, name=Unused"]
    lines += abaqus_part(source, 2.0 * source.points, sets=False)
    lines += ["*End Part", "*Part, name=Piston", "*INCLUDE, INPUT=mesh/nodes.inp", "*End Part"]
    lines += ["*Part, name=Plate", "*Node", "1, 0., 0., 0.", "2, 1., 0., 0.", "3, 0., 1., 0."]
    lines += ["*Element, type=R3D3", "1, 1, 2, 3", "*End Part", "*Assembly, name=Assembly"]
    for name in solids:
        second = CENTRE + AXIS
        lines += [f"*Instance, name={name},", "  part=piston", ", ".join(map(repr, SHIFT.tolist()))]
        lines += [", ".join(map(repr, [*CENTRE.tolist(), *second.tolist(), ANGLE]))]
        lines += ["*End Instance"]
    lines += ["*Instance, name=Plate-1, part=Plate", "5., 0., 0.", "*End Instance"]
    lines += ["*Node", "1, 9., 9., 9."]
    first = number(source.nodes("crown")).tolist()
    lines += [f"*Nset, nset=top, instance={solids[0]}", *(f"{node}," for node in first)]
    path = tmp_path / "assembly.inp"
    path.write_text("\n".join([*lines, "*End Assembly", ""]))
    return path


@pytest.mark.parametrize("shell", ["STRI65", "CPS6"])
def test_abaqus_flat(source, tmp_path, shell):
    """gmsh writes surfaces as plane stress elements."""
    path = tmp_path / "piston.inp"
    path.write_text("\n".join(abaqus_part(source, source.points, shell=shell)))
    mesh = read_mesh(path, dict.fromkeys(SURFACES))
    assert_same(mesh, source)
    assert list(mesh.labels) == list(number(np.arange(len(source.points))))


def test_abaqus_instance_moved_and_turned_with_included_files(source, tmp_path):
    """Crown, a set of nodes; skirt, a surface by sides of elements; pin bores, a set of shells."""
    path = assembly(source, tmp_path)
    mesh = read_mesh(path, dict.fromkeys(SURFACES))
    assert_same(mesh, source, 1e-12)
    known = read_raw(path).known()
    assert {"Crown", "Piston-1.Crown", "top", "skirt"} <= set(known)
    top = read_mesh(path, {"top": None})
    np.testing.assert_array_equal(top.faces["top"], mesh.faces["crown"])


def test_turn_comes_after_the_move(source, tmp_path):
    """By hand: a quarter turn about z through (1, 0, 0) takes (2, 0, 0) to (1, 1, 0)."""
    path = tmp_path / "one.inp"
    path.write_text(
        "*Part, name=P\n*Node\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n"
        "*Element, type=C3D4\n1, 1, 2, 3, 4\n*End Part\n*Instance, name=I, part=P\n2., 0., 0.\n"
        "1., 0., 0., 1., 0., 1., 90.\n*End Instance\n"
    )
    np.testing.assert_allclose(read_raw(path).points[0], [1.0, 1.0, 0.0], atol=1e-15)


def test_two_instances_are_two_pieces(source, tmp_path):
    path = assembly(source, tmp_path, ("Piston-1", "Piston-2"))
    raw = read_raw(path)
    assert len(raw.tets) == 2 * len(source.tets) and raw.labels is None
    assert len(raw.node_sets["Crown"]) == 2 * len(raw.node_sets["Piston-2.Crown"])
    with pytest.raises(MeshFault, match="2 unconnected pieces"):
        read_mesh(path, {})


# ANSYS


def ansys(source, form="19i9"):
    """Return an archive in CDWRITE's form: two element types, node components with ranges."""
    width = int(form.split("i")[1])
    count = len(source.points)
    lines = ["/COM,ANSYS RELEASE 2024", "/PREP7", "ET,        1,187", "ET,        4,174"]
    lines += [f"NBLOCK,6,SOLID,{number(0):10},{count:10}", f"(3i{width},6e21.13e3)"]
    for row in range(count - 1, -1, -1):
        reals = [*source.points[row]]
        while reals and reals[-1] == 0.0:  # the archive leaves zeros at the end out
            reals.pop()
        text = "".join(f"{value:21.13E}" for value in reals)
        lines.append(f"{number(row):{width}}{0:{width}}{0:{width}}{text}")
    lines += [
        "N,R5.3,LOC,       -1,",
        f"EBLOCK,19,SOLID,{len(source.tets):10},{len(source.tets):10}",
        f"({form})",
    ]
    for label, nodes in enumerate(number(source.tets).tolist(), 1):
        head = (1, 1, 1, 1, 0, 0, 0, 0, 10, 0, label)
        lines += ["".join(f"{k:{width}}" for k in (*head, *nodes[:8]))]
        lines += ["".join(f"{k:{width}}" for k in nodes[8:])]
    contact = (1, 4, 1, 1, 0, 0, 0, 0, 3, 0, 999999, *number([0, 1, 2]))
    lines += ["".join(f"{k:{width}}" for k in contact), f"{-1:{width}}"]
    for name in ("skirt", "crown", "pin_bore"):
        items = with_ranges(sorted(number(source.nodes(name)).tolist()))
        lines += [
            f"CMBLOCK,{name.upper():<8},NODE,{len(items):8}  ! users node component definition"
        ]
        lines += ["(8i10)"]
        lines += ["".join(f"{k:10}" for k in items[k : k + 8]) for k in range(0, len(items), 8)]
    return [*lines, "CMBLOCK,ALL_ELEM,ELEM,       2", "(8i10)", f"{1:10}{-5:10}", "FINISH", ""]


def with_ranges(numbers):
    """Numbers in a row as first and minus last."""
    items = []
    for one in numbers:
        if len(items) > 1 and items[-1] == 1 - one:
            items[-1] = -one
        elif items and items[-1] == one - 1:
            items.append(-one)
        else:
            items.append(one)
    return items


@pytest.mark.parametrize("form", ["19i9", "19i10", "19i8"])
@pytest.mark.parametrize("step", [1, 3])
def test_ansys(source, tmp_path, form, step, monkeypatch):
    """Step 1: ranges in the components."""
    monkeypatch.setitem(globals(), "number", lambda row: 90001 - step * np.asarray(row))
    path = tmp_path / "piston.cdb.gz"
    with gzip.open(path, "wt") as file:
        file.write("\n".join(ansys(source, form)))
    mesh = read_mesh(path, dict.fromkeys(SURFACES))
    # files hold 14 digits; nodes stand in the file from the last to the first
    np.testing.assert_allclose(mesh.points[::-1], source.points, atol=1e-14)
    np.testing.assert_allclose(mesh.points[mesh.tets], source.points[source.tets], atol=1e-14)
    assert bending_energy(mesh) == pytest.approx(bending_energy(source), rel=1e-10)
    for name in SURFACES:
        found, made = (
            set(map(tuple, one.points[one.faces[name]].mean(1).round(12))) for one in (mesh, source)
        )
        assert found == made


# gmsh

gmsh_formats = {"a.inp": 0, "a.med": 0, "small.bdf": 1, "free.bdf": 0, "large.bdf": 2}


def test_what_gmsh_writes(tmp_path):
    """The same mesh as .msh, .inp, .med and .bdf in its three field formats."""
    gmsh = pytest.importorskip("gmsh", reason="the extra `mesh` is not installed")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        body = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 0.04, 0.03)
        gmsh.model.occ.synchronize()
        for dimension, tags, name in ((3, [body], "body"), (2, [1], "skirt"), (2, [2], "crown")):
            gmsh.model.addPhysicalGroup(dimension, tags, name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMin", 0.02)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.02)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(tmp_path / "a.msh"))
        for name, field_format in gmsh_formats.items():
            gmsh.option.setNumber("Mesh.BdfFieldFormat", field_format)
            gmsh.write(str(tmp_path / name))
    finally:
        gmsh.finalize()
    named = dict.fromkeys(("skirt", "crown"))
    made = read_mesh(tmp_path / "a.msh", named)
    assert_same(read_mesh(tmp_path / "a.inp", named), made, 1e-13)
    assert_same(read_mesh(tmp_path / "a.med", named), made, 1e-13)
    assert_same(read_mesh(tmp_path / "large.bdf", {}), made, 1e-10)
    for name in ("small.bdf", "free.bdf"):  # fields of eight columns: five digits
        mesh = read_mesh(tmp_path / name, {})
        np.testing.assert_array_equal(mesh.tets, made.tets)
        np.testing.assert_allclose(mesh.points, made.points, atol=1e-5)
