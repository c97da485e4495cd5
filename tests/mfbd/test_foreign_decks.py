"""Small decks with the features that other programs write: each is read right or rejected.

Each body is one ten-node tetrahedron with straight edges of 30, 40 and 50 mm along the axes, so
that its ten nodes are known by hand.
"""

import re

import h5py
import meshio
import numpy as np
import pytest

from piston_cosim.fmu_mfbd.body_options import Piston
from piston_cosim.fmu_mfbd.finite_elements.element import EDGES
from piston_cosim.fmu_mfbd.finite_elements.mesh import MeshFault, read_mesh, read_raw
from piston_cosim.fmu_mfbd.options import SmallEnd
from piston_cosim.fmu_mfbd.reduction.reading import read_surfaces
from piston_cosim.fmu_mfbd.reduction.store import contents

CORNERS = np.array([[0, 0, 0], [0.03, 0, 0], [0, 0.04, 0], [0, 0, 0.05]])
NODES = np.vstack([CORNERS, CORNERS[EDGES].mean(axis=1)])
MATERIAL = {"density": "2700 kg/m^3", "young": "70 GPa", "poisson": 0.33}
MIRROR = NODES[[0, 2, 1, 3, 6, 5, 4, 7, 9, 8]] * [1, 1, -1]
"""Nodes of a second element that shares the face z = 0 with the first."""


def row(values, form="{}", between=", "):
    return between.join(form.format(value) for value in values) + "\n"


# Abaqus

NODE = "*NODE\n" + "".join(row([k, *p]) for k, p in enumerate(NODES.tolist(), 1))
FIRST = "*ELEMENT, TYPE=C3D10, ELSET=ALL\n" + row([1, *range(1, 11)])
ABAQUS = NODE + FIRST
HEXAHEDRON = "*ELEMENT, TYPE={}\n" + row([9, *range(1, 9)])
PARTS = (
    f"*PART, NAME=Piston\n{ABAQUS}*NSET, NSET=Skirt\n1, 2, 3\n*END PART\n*PART, NAME=Pin\n"
    + NODE
    + HEXAHEDRON.format("C3D8R")
    + "*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=P-1, PART=Piston\n*END INSTANCE\n"
    "*INSTANCE, NAME=P-2, PART=PISTON\n0.2, 0., 0.\n*END INSTANCE\n"
    "*INSTANCE, NAME=Q-1, PART=Pin\n*END INSTANCE\n*END ASSEMBLY\n"
)
SECTIONS = (
    "*NODE\n"
    + "".join(row([k, *p]) for k, p in enumerate(MIRROR.tolist(), 21))
    + "*ELEMENT, TYPE=C3D10, ELSET=IRON\n"
    + row([2, *range(21, 31)])
    + "*ELSET, ELSET=IRON\n2\n*SOLID SECTION, ELSET=ALL, MATERIAL=Alu\n"
    "*SOLID SECTION, ELSET=IRON, MATERIAL=Iron\n"
)

# Nastran


def grid(points=NODES, system="", first=1):
    return "".join(row(["GRID", k, system, *p], between=",") for k, p in enumerate(points, first))


CTETRA = "CTETRA,1,1,1,2,3,4,5,6\n,7,8,9,10\n"
NASTRAN = grid() + CTETRA
TURNED = NODES[:, [1, 0, 2]] * [1, -1, 1]
"""Nodes in a system whose x is y and whose y is -x."""
X, Y, Z = NODES.T
POLAR = np.stack([np.hypot(X, Y), np.degrees(np.arctan2(Y, X)), Z], axis=1)
RADIUS = np.linalg.norm(NODES, axis=1)
FROM_Z = np.degrees(np.arctan2(np.hypot(X, Y), Z))
SPHERICAL = np.stack([RADIUS, FROM_Z, POLAR[:, 1]], axis=1)
AXES = "7,0,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"

# Ansys


def nblock(form="(3i9,6e21.13e3)", width=9, size=21, integers=3):
    lines = [
        f"{k:{width}}" + f"{0:{width}}" * (integers - 1) + row(p, f"{{:{size}.13E}}", "")
        for k, p in enumerate(NODES.tolist(), 1)
    ]
    return f"NBLOCK,6,SOLID,10,10\n{form}\n{''.join(lines)}N,R5.3,LOC,       -1,\n"


def solids(*elements):
    """Return an EBLOCK of elements, each with type, material and nodes."""
    lines = ["EBLOCK,19,SOLID,1,1\n(19i9)\n"]
    for label, (kind, material, nodes) in enumerate(elements, 1):
        head = [material, kind, 1, 1, 0, 0, 0, 0, len(nodes), 0, label, *nodes[:8]]
        lines += [row(head, "{:9}", ""), row(nodes[8:], "{:9}", "")]
    return "".join(lines) + "       -1\n"


TEN = list(range(1, 11))
ONE = solids((1, 1, TEN))
SURF154 = "ET,2,154\nEBLOCK,10,,,1\n(15i9)\n" + row(
    [2, 2, 2, 2, 0, 1, 2, 3, 3, 5, 6, 3, 7], "{:9}", ""
)
SURF154 += "-1\n"
ANSYS = "/PREP7\nET,1,187\n" + nblock()

# gmsh 4.1 with a volume and a face of the same name, parametric nodes and all elements

GMSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 "skirt"
2 2 "all"
3 3 "skirt"
$EndPhysicalNames
$Entities
1 0 1 1
9 0 0 0 0
4 0 0 0 1 1 1 2 1 2 3 1 2 3
5 0 0 0 1 1 1 1 3 1 4
$EndEntities
$Nodes
2 10 7 70
2 4 1 3
7
14
21
0 0 0 0.1 0.2
0.03 0 0 0.1 0.2
0 0.04 0 0.1 0.2
3 5 0 7
28
35
42
49
56
63
70
0 0 0.05
0.015 0 0
0.015 0.02 0
0 0.02 0
0 0 0.025
0.015 0 0.025
0 0.02 0.025
$EndNodes
$Elements
3 3 1 3
0 9 15 1
1 7
2 4 2 1
2 7 14 21
3 5 11 1
3 7 14 21 28 35 42 49 56 70 63
$EndElements
"""

DECKS = {
    # Abaqus and CalculiX: sets, names, numbers, files
    "generate.inp": (ABAQUS + "*NSET, NSET=s, GENERATE\n1, 9, 4\n2\n3, 4\n", {"s": 6}, ""),
    "lower_case.inp": (ABAQUS.lower() + "*nset, nset=s\n1, 2, 3\n", {"s": 3}, ""),
    "one_name.inp": (ABAQUS + "*NSET, NSET=s\n1\n*NSET, NSET=S\n2\n", {"s": 2}, ""),
    "forward.inp": (ABAQUS + "*SURFACE, NAME=s\nB, S1\n*ELSET, ELSET=B\n1\n", {"s": 1}, ""),
    "quoted.inp": (ABAQUS + '*NSET, NSET="a b"\n1, 2\n*NSET, NSET=s\n"a b"\n', {"s": 2}, ""),
    "node_surface.inp": (ABAQUS + "*SURFACE, NAME=s, TYPE=NODE\n1, 1.5\n2\n", {"s": 2}, ""),
    "nodes_of_elements.inp": (ABAQUS + "*NSET, NSET=s, ELSET=ALL\n", {"s": 10}, ""),
    "union.inp": (
        ABAQUS + "*SURFACE, NAME=A\nALL, S1\n*SURFACE, NAME=B\n1, S2\n"
        "*SURFACE, NAME=s, COMBINE=UNION\nA, B\n",
        {"s": 2},
        "",
    ),
    "unknown_set.inp": (ABAQUS + "*NSET, NSET=o\nX\n*NSET, NSET=s\n1\n", {"s": 1}, "o: set: .*'X'"),
    "circular.inp": (ABAQUS + "*NSET, NSET=a\nb\n*NSET, NSET=b\na\n", {}, "no circular definition"),
    "side.inp": (ABAQUS + "*SURFACE, NAME=s\nALL, S6\n", {}, "a side S1 to S4, got 'S6'"),
    "difference.inp": (
        ABAQUS + "*SURFACE, NAME=s, COMBINE=DIFFERENCE\nA, B\n",
        {},
        "expected faces or combine=union",
    ),
    "fortran.inp": (ABAQUS.replace("0.03,", "3.D-2,"), {}, ""),
    "mark.inp": ("\ufeff" + ABAQUS, {}, ""),
    "utf16.inp": (ABAQUS, {}, ""),
    "include.inp": ("*INCLUDE, INPUT=mesh\\deck.txt\n*STEP\n", {}, ""),
    "midside_E.inp": (ABAQUS.replace("C3D10", "C3D10MT"), {}, ""),
    "two_materials.inp": (ABAQUS + SECTIONS, {}, ""),
    "part_without_instance.inp": (f"*PART, NAME=P\n{ABAQUS}*END PART\n", {}, ""),
    "instance_with_mesh.inp": (
        f"*PART, NAME=P\n*END PART\n*INSTANCE, NAME=I, PART=P\n{ABAQUS}*END INSTANCE\n",
        {},
        "",
    ),
    # rejected
    "thermal.inp": (ABAQUS.replace("C3D", "DC3D"), None, "got 1 DC3D10; only structural"),
    "acoustic.inp": (ABAQUS.replace("C3D", "AC3D"), None, "got 1 AC3D10; only structural"),
    "shell.inp": (ABAQUS + HEXAHEDRON.format("SC8R"), None, "got also 1 SC8R; only"),
    "hexahedron.inp": (ABAQUS + HEXAHEDRON.format("C3D8I"), None, "1 C3D8I.*wedges.*CMS matrices"),
    "no_type.inp": (ABAQUS.replace("TYPE=C3D10, ", ""), None, "Element: expected type=, got"),
    "system.inp": ("*SYSTEM\n1., 0., 0.\n" + ABAQUS, None, r"expected written nodes, got \*SYSTEM"),
    "cylindrical.inp": (ABAQUS.replace("*NODE", "*NODE, SYSTEM=C"), None, "got system=C"),
    "mixed.inp": (ABAQUS + "*ELEMENT, TYPE=C3D4\n2, 1, 3, 2, 4\n", None, "1 of 2 with four nodes"),
    "nan.inp": (
        ABAQUS.replace("0.05", "nan"),
        None,
        "node 4: expected finite coordin",
    ),
    "generated.inp": (ABAQUS + "*NGEN\n1, 5, 1\n", None, r"got \*NGEN; write the mesh in full"),
    "no_part.inp": (
        ABAQUS + "*INSTANCE, NAME=I, PART=Q\n",
        None,
        "I: expected a known part, got 'Q'",
    ),
    "no_file.inp": (ABAQUS + "*INCLUDE, INPUT=b.inp\n", None, "include 'b.inp', got no such file"),
    "short.inp": (ABAQUS + FIRST[:40], None, "=C3D10: expected a multiple of 11 numbers, got 3"),
    "letter.inp": (ABAQUS.replace("0.05", "O.05"), None, "expected a number, got 'O.05'"),
    # Nastran
    "copied.bdf": ("GRID,1,,0.,0.,0.\n=,*1,=,*30.,=,=\n" + CTETRA, None, "got replication by ="),
    "polar.bdf": (f"BEGIN BULK\nCORD2C,{AXES}" + grid(POLAR, 7) + CTETRA, {}, ""),
    "sphere.dat": (f"BEGIN BULK\nCORD2S,{AXES}" + grid(SPHERICAL, 7) + CTETRA, {}, ""),
    "by_nodes.bdf": (
        "CORD1R,6,91,92,93,5,91,92,94\n"
        + grid([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0]], "", 91)
        + grid(TURNED, 5)
        + CTETRA,
        {},
        "",
    ),
    "chain.bdf": (
        f"CORD2C,{AXES}CORD2R,8,7,1.,90.,0.,1.,90.,1.\n,2.,90.,0.\nGRDSET,,8\n"
        + grid(TURNED - [1, 0, 0])
        + CTETRA,
        {},
        "",
    ),
    "unused_node.bdf": ("GRID,99,5,1.,30.,0.\n" + NASTRAN, {}, ""),
    "exponents.bdf": (NASTRAN.replace("0.05", "5.-2").replace("0.04", "4.d-2"), {}, ""),
    "no_middle.bdf": (NASTRAN.replace(",9,10", ",9"), {}, "1 midside nodes omitted"),
    "blanks.bdf": ((grid(NODES, 0) + CTETRA).replace(",", " "), {}, ""),
    "long_line.bdf": (
        grid() + CTETRA.replace("\n,", ",", 1),
        None,
        "CTETRA: expected at most 8 fields and a mark",
    ),
    "include.bdf": (f"BEGIN BULK\nINCLUDE 'mesh\\grid.txt'\n{CTETRA}ENDDATA\n", {}, ""),
    "two_materials.fem": (
        NASTRAN + grid(MIRROR, "", 21) + "CTETRA,2,2,21,22,23,24,25,26\n,27,28,29,30\n"
        "PSOLID,1,3\nPSOLID,2,4\n",
        {},
        "",
    ),
    "corners.bdf": (
        NASTRAN + "CTETRA,2,1,1,,2,3\n",
        None,
        "CTETRA 2: expected 4 corners and up to 6 middle nodes, got .1, 0,",
    ),
    "unknown_node.bdf": (NASTRAN + "CTETRA,2,1,1,2,3,33\n", None, "a known node, got 33"),
    "mixed.bdf": (NASTRAN + "CTETRA,2,1,1,2,3,4\n", None, "got 1 of 2 with four nodes"),
    "own_system.bdf": (
        "CORD1R,5,1,2,3\n" + grid(NODES, 5) + CTETRA,
        None,
        "a known coordinate system, got 5, which depends on itself",
    ),
    "in_line.bdf": (
        "CORD2C,5,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\n" + grid(NODES, 5) + CTETRA,
        None,
        "CORD2C 5: expected three points that are not in line",
    ),
    "letter.bdf": (NASTRAN + "GRID,11,,1.x\n", None, "GRID 11: .* in field 4, got '1.X'"),
    "two_places.bdf": (NASTRAN + "GRID,1,,1.,2.,3.\n", None, "node 1: expected one position, got"),
    "no_file.bdf": (NASTRAN + "INCLUDE 'b.bdf'\n", None, "include 'b.bdf', got no such file"),
    "circular.bdf": (NASTRAN + "INCLUDE 'circular.bdf'\n", None, "no circular include, got"),
    "elsewhere.bdf": (
        "CTETRA  1       1       1       2       3       4       5       6       +E1\n"
        "+E2     7       8       9       10\n" + grid(),
        None,
        r"CTETRA 1: expected its continuations right behind it, got '\+E2",
    ),
    "fluid.bdf": (NASTRAN + "PSOLID,1,3,,,,,PFLUID\n", None, "got 1 CTETRA of a fluid; only"),
    "unknown_system.bdf": (grid(NODES, 7) + CTETRA, None, "a known coordinate system, got 7"),
    "hexahedron.bdf": (NASTRAN + "CHEXA,2,1,1,2,3,4,5,6\n,7,8\n", None, "got also 1 CHEXA; only"),
    # Ansys
    "etblock.cdb": (
        "/PREP7\nETBLOCK,1,1\n(2i9,19a9)\n        1      187        0\n       -1\n"
        + nblock()
        + ONE,
        {},
        "",
    ),
    "ds.dat": (
        '/com,*********** Elements for Body 1 "Piston" ***********\net,1,187\n'
        + nblock("(1i9,3e20.13e3)", 9, 20, 1).replace("N,R5.3,LOC,       ", "")
        + ONE,
        {},
        "",
    ),
    "surface_effect.cdb": (ANSYS + ONE + SURF154, {}, ""),
    "components.cdb": (
        ANSYS + ONE + "CMBLOCK,S,NODE,2\n(8i10)\n         1        -3\n"
        "CMBLOCK,BODY,ELEM,1\n(8i10)\n         1\n",
        {"S": 3},
        "",
    ),
    "no_middle.cdb": (ANSYS + solids((1, 1, [*TEN[:9], 0])), {}, "1 midside nodes omitted"),
    "few_nodes.cdb": (ANSYS + solids((1, 1, TEN[:8])), {}, "2 midside nodes omitted"),
    "no_solid.cdb": (
        ANSYS + "EBLOCK,10,,,1\n(15i9)\n" + row([1, 1, 1, 1, 0, *TEN], "{:9}", "") + "-1\n",
        {},
        "",
    ),
    "no_corner.cdb": (ANSYS + solids((1, 1, [1, 2, 0, *TEN[3:]])), None, "four corners of each"),
    "two_materials.cdb": (ANSYS + solids((1, 1, TEN), (1, 2, TEN)), {}, ""),
    "thermal.cdb": (ANSYS.replace("187", "87") + ONE, None, "got 1 SOLID87; only structural"),
    "repeated_nodes.cdb": (
        ANSYS.replace("187", "186")
        + solids((1, 1, [1, 2, 3, 3, 4, 4, 4, 4, 5, 6, 3, 7, 4, 4, 4, 4, 8, 9, 10, 10])),
        {},
        "",
    ),
    "repeated_corners.cdb": (
        ANSYS.replace("187", "185") + solids((1, 1, [1, 2, 3, 3, 4, 4, 4, 4])),
        {},
        "linear",
    ),
    "no_type.cdb": (
        ANSYS + solids((1, 1, TEN), (4, 1, TEN)),
        None,
        "got also 1 type 4, which no ET names; only",
    ),
    "format.cdb": (
        ANSYS + ONE.replace("(19i9)", "(free)"),
        None,
        r"a known format, got '\(free\)'",
    ),
    "no_blocks.cdb": (
        "/PREP7\nN,1,0.,0.,0.\n",
        None,
        "expected NBLOCK and EBLOCK, got 0 nodes and 0 elements; .*CDWRITE",
    ),
    "hexahedron.dat": (ANSYS + "ET,2,186\n" + solids((1, 1, TEN), (2, 1, TEN)), None, "SOLID186"),
    # gmsh
    "blank.msh": (GMSH.replace('"skirt"', '"skirt "'), {"skirt": 1, "all": 1}, ""),
    "a.msh": (GMSH, {"skirt": 1, "all": 1}, ""),
    "old.msh": (GMSH.replace("4.1 0", "4 0"), None, "format 2.2 or 4.1, got 4; .*MshFileVersion"),
    "third_order.msh": (
        GMSH.replace("3 5 11 1", "3 5 29 1"),
        None,
        "up to order 2, got .* type 29",
    ),
    "cut_off.msh": (GMSH[:-40], None, "expected .EndElements, got the end"),
    # no mesh, or none that is read
    "piston.step": (
        "ISO-10303-21;\nHEADER;\n",
        None,
        "a mesh of tetrahedra, got geometry; mesh it",
    ),
    "ls_dyna.k": ("*KEYWORD\n" + ABAQUS, None, "got a deck of LS-DYNA; export Abaqus"),
    "ideas.unv": ("    -1\n  2411\n", None, r"got a universal file \(UNV\); export MED"),
    "cut_off.inp.xz": ("no archive", None, "expected a compressed mesh, got"),
    "text.med": ("no HDF5", None, "expected a MED file in HDF5"),
    "empty.inp": ("", None, "readable suffixes: .msh"),
}
"""Text, members of sets and surfaces (None if rejected), and a pattern in error or remarks."""


@pytest.mark.parametrize("name", DECKS)
def test_deck_is_read_right_or_rejected_with_the_reason(name, tmp_path):
    text, sets, pattern = DECKS[name]
    path = tmp_path / name
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh/deck.txt").write_text(ABAQUS)
    (tmp_path / "mesh/grid.txt").write_text(grid())
    path.write_text(text, encoding="utf-16" if name.startswith("utf16") else "utf-8")
    if sets is None:
        with pytest.raises(MeshFault, match=f"{path.name}: .*{pattern}"):
            read_raw(path)
        return
    deck = read_raw(path)
    # decks have 13 digits or more
    np.testing.assert_allclose(deck.points[deck.tets[0]], NODES, rtol=0, atol=1e-14)
    said = [*deck.remarks, *(f"{key}: {fault}" for key, fault in deck.faults.items())]
    assert bool(said) == bool(pattern) and re.search(pattern, " ".join(said))
    for key, count in sets.items():
        assert len(deck.faces.get(key, deck.node_sets.get(key, ()))) == count


@pytest.mark.parametrize(
    "deck, message",
    [
        (ABAQUS + "*NSET, NSET=SKIRT\n1, 2\n", "'skirt': expected outer faces, got a set of 2 nod"),
        (ABAQUS + "*ELSET, ELSET=SKIRT\n1\n", "got a set of solid elements; define a set of nod"),
        (NASTRAN + CTETRA.replace("A,1", "A,2"), "expected different elements, got 1 duplicates"),
    ],
)
def test_what_a_file_has_instead_of_a_surface(deck, message, tmp_path):
    (tmp_path / "deck.txt").write_text(deck)
    with pytest.raises(MeshFault, match=message):
        read_mesh(tmp_path / "deck.txt", {"skirt": None})


def test_part_of_an_assembly(tmp_path):
    """The assembly has two pistons, the second one 0.2 m aside, and a pin of hexahedra."""
    path = tmp_path / "assembly.inp"
    path.write_text(PARTS)
    mesh = read_mesh(path, {"skirt": None}, part="p-2")
    np.testing.assert_allclose(mesh.points[mesh.tets[0]], NODES + [0.2, 0, 0], atol=1e-14)
    assert len(mesh.faces["skirt"]) == 1 and list(mesh.labels) == TEN
    assert len(read_raw(path, "Piston").tets) == 2
    for part, fault in (
        ("Q-1", "expected 10-node tetrahedra, got 1 C3D8R"),
        ("R-1", r"part: expected a part of the file \(Piston, P-1, P-2, Pin, Q-1, .*got 'R-1'"),
        ("Piston", "2 unconnected pieces(.|\n)*the option part selects one of Piston, P-1, P-2"),
        (None, r"got also 1 C3D8R(.|\n)*: the option part selects one of Piston, P-1,"),
    ):
        with pytest.raises(MeshFault, match=fault):
            read_mesh(path, {}, part=part)


def test_option_part(tmp_path):
    """It selects a part of a mesh of elements; a body without it has no such key."""
    path = tmp_path / "assembly.inp"
    path.write_text(PARTS)
    options = Piston(mesh=str(path), part="P-1", **MATERIAL)
    assert len(read_surfaces(options, ["skirt"], print).tets) == 1
    assert contents(options)["part"] == "P-1"
    assert "part" not in contents(Piston(mesh=str(path), **MATERIAL))
    with pytest.raises(ValueError, match="part: expected it with a mesh of elements, got mesh"):
        SmallEnd(mesh="nodes.csv", part="P-1", **MATERIAL)


def test_included_file_determines_the_reduced_body(tmp_path):
    (tmp_path / "mesh").mkdir()
    paths = tmp_path / "deck.inp", tmp_path / "mesh/nodes.inp"
    paths[0].write_text("*Node, nset=all, input=mesh\\nodes.inp\n")
    options = Piston(mesh=str(paths[0]), **MATERIAL)
    paths[1].write_text("1, 0.0\n")
    before = contents(options)
    paths[1].write_text("1, 0.1\n")
    assert contents(options)["mesh"] != before["mesh"]


@pytest.mark.parametrize(
    ("name", "part"),
    [("two_materials.inp", "IRON"), ("two_materials.fem", "2"), ("a.msh", "skirt")],
)
def test_part_by_set_of_elements(name, part, tmp_path):
    """An element set, a property and a physical volume; one material gives no warning."""
    path = tmp_path / name
    path.write_text(DECKS[name][0])
    deck = read_raw(path, part)
    assert len(deck.tets) == 1 and not deck.remarks


def test_omitted_middle_node_is_that_of_the_neighbour(tmp_path):
    """Edge 1-2 is common: the second element gets node 5, which is not midway."""
    path = tmp_path / "neighbour.bdf"
    middle = NODES.copy()
    middle[4] += [0.001, 0, 0]
    own = MIRROR[[3, 7, 8, 9]]
    path.write_text(
        grid(middle) + grid(own, "", 11) + CTETRA + "CTETRA,2,1,1,3,2,11,7,6\n,,12,14,13\n"
    )
    deck = read_raw(path)
    assert deck.tets[1, 6] == 4 and len(deck.points) == 14 and deck.labels is None


@pytest.mark.parametrize("move", [0.0, 0.28, 0.9])
def test_jacobian_that_is_negative_at_a_corner_only(move, tmp_path):
    """Edge 1-2 with its middle node moved along it by a share of its length.

    Along the edge, x = L (s + 4 m s (1 - s)) and dx/ds = L (1 + 4 m (1 - 2 s)), which is negative
    at the end s = 1 if m > 1/4.
    """
    nodes = NODES.copy()
    nodes[4, 0] += move * 0.03
    path, said = tmp_path / "corner.bdf", []
    path.write_text(grid(nodes) + CTETRA)
    if move > 0.5:
        with pytest.raises(MeshFault, match="1 inverted elements; the first is number 1 at"):
            read_mesh(path, {})
        return
    mesh = read_mesh(path, {}, say=said.append)
    assert len(mesh.tets) == 1 and len(said) == (move > 0.25)
    for text in said:
        assert "negative Jacobian at a corner" in text and "at (0.03, 0, 0) m" in text


@pytest.mark.parametrize("file_format", ["gmsh", "gmsh22"])
@pytest.mark.parametrize("binary", [False, True])
def test_gmsh_in_text_and_binary(file_format, binary, tmp_path):
    """As meshio writes them."""
    path = tmp_path / "a.msh"
    cells = [("triangle6", [[0, 2, 1, 6, 5, 4]]), ("tetra10", [list(range(10))])]
    mesh = meshio.Mesh(
        NODES,
        cells,
        point_data={"gmsh:dim_tags": np.array([[3, 1]] * 9 + [[2, 1]])},
        cell_data={tag: [[1], [2]] for tag in ("gmsh:physical", "gmsh:geometrical")},
        field_data={"skirt": np.array([1, 2]), "body": np.array([2, 3])},
    )
    meshio.write(path, mesh, file_format=file_format, binary=binary)
    deck = read_raw(path)
    np.testing.assert_array_equal(deck.points[deck.tets[0]], NODES)
    if file_format == "gmsh22":  # meshio omits the groups of format 4.1
        assert deck.faces["skirt"].tolist() == [[0, 2, 1]] and list(deck.parts) == ["body"]


def test_med(tmp_path):
    """MED numbers the corners of a tetrahedron the other way around."""
    path = tmp_path / "a.med"
    with h5py.File(path, "w") as file:
        step = file.create_group("ENS_MAA/body/-1-1")
        step.create_group("NOE")["COO"] = NODES.T.ravel()
        for kind, nodes, family in (
            ("T10", [0, 2, 1, 3, 6, 5, 4, 7, 9, 8], None),
            ("TR6", [0, 1, 2, 4, 5, 6], -7),
        ):
            group = step.create_group(f"MAI/{kind}")
            group["NOD"] = np.array(nodes) + 1
            group["NOD"].attrs["NBR"] = 1
            if family:
                group["FAM"] = [family]
        family = file.create_group("FAS/body/ELEME/FAM_-7")
        family.attrs["NUM"] = -7
        name = np.zeros((1, 80), dtype=np.int8)
        name[0, :5] = list(b"skirt")
        family["GRO/NOM"] = name
    deck = read_raw(path)
    np.testing.assert_array_equal(deck.points[deck.tets[0]], NODES)
    assert deck.faces["skirt"].tolist() == [[0, 1, 2]]
