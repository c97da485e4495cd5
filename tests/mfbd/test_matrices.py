"""Matrices of other programs.

The stiffness and mass of our own mesh, written in each format, reduce to the same body as the
mesh.
"""

import meshio
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.io import mmwrite

from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled, read_matrix
from piston_cosim.fmu_mfbd.finite_elements.mesh import MeshFault, read_mesh
from piston_cosim.master.fmi.errors import BadInput

from .test_decks import abaqus_part, nastran, number

UNITS = {"stiffness_unit": "1 N/mm", "mass_unit": "1 t"}
MATERIAL = (75e9, 0.33, 2700.0)
FILES = {"stiffness": "K.mtx", "mass": "M.mtx"}


@pytest.fixture(scope="module")
def original(coarse):
    """Mesh of the small block, its matrices in N/mm and t, and its reduced body."""
    folder, options = coarse
    mesh = read_mesh(folder / "block.msh", {"bore": None, "bolts": None})
    _, K, M = assembled(mesh, *MATERIAL)
    return mesh, K / 1e3, M / 1e3


def reduced(table, folder, monkeypatch, name="block"):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(folder / "cache"))
    files = reduced_bodies({"grid": [16, 12], name: table}, folder, lambda text: None)
    return np.load(files[name])


@pytest.fixture(scope="module")
def from_mesh(coarse, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        return reduced(
            coarse[1]["block"] | {"mesh": str(coarse[0] / "block.msh")},
            tmp_path_factory.mktemp("mesh"),
            patch,
        )


def write_pair(folder, *matrices):
    """Stiffness and mass in Matrix Market files."""
    for name, matrix in zip(FILES.values(), matrices, strict=True):
        mmwrite(folder / name, matrix, symmetry="symmetric")


def write_nodes(folder, mesh, names=(), scale=1.0, order=None, **sets):
    """Write a CSV of nodes in some order, with sets: mesh surfaces by name, or given nodes."""
    sets |= {name: mesh.nodes(name) for name in names}
    lines = ["node,x,y,z" + ",sets" * bool(sets)]
    for k in range(len(mesh.points)) if order is None else order:
        cells = [f"{number(k)}", *(f"{scale * x:.12g}" for x in mesh.points[k])]
        if sets:
            cells.append(" ".join(name for name, nodes in sets.items() if k in nodes))
        lines.append(",".join(cells))
    (folder / "nodes.csv").write_text("\n".join(lines) + "\n")
    return {"mesh": "nodes.csv", **FILES}


def write_labels(path, matrix, lower=True):
    """Abaqus' matrix input format: one triangle, node numbers with gaps, a heading."""
    part = sp.tril(matrix).tocoo() if lower else matrix.tocoo()
    lines = [
        f"{number(r // 3)},{r % 3 + 1}, {number(c // 3)},{c % 3 + 1}, {v:.17e}"
        for r, c, v in zip(part.row, part.col, part.data)
    ]
    path.write_text("** matrix of a test\n" + "\n".join(lines) + "\n")


def write_dmig(path, matrix, name, large=True):
    """Nastran DMIG, symmetric, one triangle; large fields or commas."""
    lines = ["$ matrix of a test", f"DMIG    {name:<8}{0:>8}{6:>8}{2:>8}{0:>8}"]
    lower = sp.tril(matrix).tocsc()
    for c in range(lower.shape[1]):
        rows, values = (
            part[lower.indptr[c] : lower.indptr[c + 1]] for part in (lower.indices, lower.data)
        )
        node, direction = number(c // 3), c % 3 + 1
        if large:
            lines.append(f"DMIG*   {name:<16}{node:>16}{direction:>16}")
            lines += [
                f"*       {number(r // 3):>16}{r % 3 + 1:>16}{v:>16.9E}".replace("E", "D")
                for r, v in zip(rows, values)
            ]
        else:
            entries = [f"{number(r // 3)},{r % 3 + 1},{v:.9e},0." for r, v in zip(rows, values)]
            lines.append(f"DMIG,{name},{node},{direction},,{entries[0]}")
            lines += [f",{','.join(entries[k : k + 2])}" for k in range(1, len(entries), 2)]
    path.write_text("\n".join(lines) + "\n")


def in_file(mesh):
    """Nodes in millimetres, thrust along the file's z, pin along -x."""
    x, y, z = 1e3 * mesh.points.T
    return np.stack([-z, y, x], axis=1)


def write_inp(path, mesh):
    """Abaqus mesh with both surfaces as sets of nodes."""
    lines = abaqus_part(mesh, in_file(mesh), sets=False)
    for name in ("bore", "bolts"):
        lines += [f"*NSET, NSET={name}", *(f"{number(n)}," for n in mesh.nodes(name))]
    path.write_text("\n".join(lines) + "\n")


BY_GEOMETRY = {
    "bore": {"shape": "cylinder", "radius": "28.025 mm", "lower": "50 mm", "upper": "155 mm"},
    "bolts": {"shape": "plane", "height": "50 mm"},
}


def turned_to_file(matrix):
    """Return the matrix with vectors in the axes of `in_file`."""
    turn = np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]])  # file = turn @ body
    whole = sp.kron(sp.identity(matrix.shape[0] // 3), turn)
    return whole @ matrix @ whole.T


def assert_same_body(imported, reference, tolerance):
    np.testing.assert_allclose(imported["omega"], reference["omega"], rtol=tolerance)
    # modes up to sign and, in pairs of nearly equal frequency, up to a turn: compare the compliance
    # they add up to
    compliance = [
        np.einsum("ijk,ilk->ijl", body["radial"], body["radial"] / body["omega"] ** 2)
        for body in (imported, reference)
    ]
    np.testing.assert_allclose(
        compliance[0], compliance[1], atol=tolerance * 100 * np.abs(compliance[1]).max()
    )
    np.testing.assert_allclose(
        imported["rigid_mass"],
        reference["rigid_mass"],
        atol=tolerance * np.abs(reference["rigid_mass"]).max(),
    )


@pytest.mark.parametrize(
    "kind", ["matrix market", "abaqus coordinate", "abaqus labels", "dmig large", "dmig commas"]
)
def test_round_trip(kind, original, from_mesh, coarse, tmp_path, monkeypatch):
    """Every format gives the same body to its own number of digits.

    Fields of 16 characters in DMIG hold ten digits. The ratio of largest to lowest eigenvalue, 1e8,
    turns these into 1e-6 of the lowest frequencies. The other formats hold 17 digits.
    """
    mesh, K, M = original
    names = {
        "stiffness": "K.pch" if "dmig" in kind else "K.mtx",
        "mass": "M.pch" if "dmig" in kind else "M.mtx",
    }
    table = {"mesh": str(coarse[0] / "block.msh"), "modes": 10, "stations": 24, **UNITS, **names}
    if "labels" in kind or "dmig" in kind:
        write_inp(tmp_path / "block.inp", mesh)
        deck = nastran(mesh, "free", points=in_file(mesh))
        (tmp_path / "block.bdf").write_text("\n".join(deck))
        table |= {"mesh": "block.inp", "mesh_unit": "1 mm", "axes": ["z", "y", "-x"]}
        table |= {"mesh": "block.bdf", "surfaces": BY_GEOMETRY} if "commas" in kind else {}
        K, M = turned_to_file(K), turned_to_file(M)
    for (key, name), matrix in zip(names.items(), (K, M)):
        path = tmp_path / name
        if kind == "matrix market":
            mmwrite(path, matrix, symmetry="symmetric")
        elif kind == "abaqus coordinate":
            whole = matrix.tocoo()
            np.savetxt(
                path, np.column_stack([whole.row + 1, whole.col + 1, whole.data]), fmt="%d %d %.17e"
            )
        elif kind == "abaqus labels":
            write_labels(path, matrix, lower=key == "stiffness")
        else:
            write_dmig(path, matrix, "KAAX", large="large" in kind)
    imported = reduced(table, tmp_path, monkeypatch)
    assert_same_body(imported, from_mesh, 1e-6 if "dmig" in kind else 1e-9)


def test_nodes_alone(original, coarse, from_mesh, tmp_path, monkeypatch):
    """A CSV of nodes with sets gives the same fixed-interface frequencies.

    The triangulated surfaces have the accuracy of the mesh.
    """
    mesh, K, M = original
    order = np.random.default_rng(0).permutation(len(mesh.points))
    table = write_nodes(tmp_path, mesh, ("bore", "bolts"), 1e3, order)
    for name, matrix in zip(FILES.values(), (K, M)):
        write_labels(tmp_path / name, matrix)
    table |= {"mesh_unit": "1 mm", "modes": 10, "stations": 24}
    table |= UNITS
    imported = reduced(table | {"basis": "craig_bampton"}, tmp_path, monkeypatch)
    exact = reduced(
        coarse[1]["block"] | {"mesh": str(coarse[0] / "block.msh"), "basis": "craig_bampton"},
        tmp_path,
        monkeypatch,
    )
    np.testing.assert_allclose(imported["omega"], exact["omega"], rtol=1e-9)
    # three-node triangles between nodes 11 degrees apart: (4 pi/16)^2/8 of a mode with four waves
    # around
    strength = [np.linalg.norm(body["radial"]) for body in (imported, exact)]
    assert strength[0] == pytest.approx(strength[1], rel=(4 * np.pi / 16) ** 2 / 8)
    by_geometry = table | {"surfaces": BY_GEOMETRY, "basis": "craig_bampton"}
    # round-off of eigenvectors, 0 to 2e-13 by the libraries: the same faces in another order, so
    # that sums over them round otherwise
    found = reduced(by_geometry, tmp_path, monkeypatch)["radial"]
    np.testing.assert_allclose(
        found, imported["radial"], rtol=0.0, atol=1e-13 * np.abs(found).max()
    )


def test_piston_of_nodes_alone_has_its_gas_force(coarse, tmp_path, monkeypatch):
    """The modal gas force on a crown of three-node triangles is that of the mesh's six-node faces.

    The difference is within the error of the faces.
    """
    folder, options = coarse
    surfaces = ("skirt", "crown", "pin_bore")
    mesh = read_mesh(folder / "piston.msh", dict.fromkeys(surfaces))
    _, *matrices = assembled(mesh, *MATERIAL)
    write_pair(tmp_path, *matrices)
    chosen = {"basis": "craig_bampton", "modes": 12}
    table = write_nodes(tmp_path, mesh, surfaces) | chosen
    table |= {"stiffness_unit": "1 N/m", "mass_unit": "1 kg"}
    imported = reduced(table, tmp_path, monkeypatch, "piston")
    own = options["piston"] | {"mesh": str(folder / "piston.msh")} | chosen
    exact = reduced(own, tmp_path, monkeypatch, "piston")
    np.testing.assert_allclose(imported["omega"], exact["omega"], rtol=1e-9)
    crown = exact["shapes"][:, 1][mesh.nodes("crown")]
    assert (
        len(crown)
        and np.abs(np.abs(imported["gas_force"]) - np.abs(exact["gas_force"])).max()
        < 0.02 * np.abs(crown).max()
    )


FAULTS = {
    "size": (
        "%%MatrixMarket matrix coordinate real symmetric\n3 3 1\n1 1 1.0\n",
        "mtx: expected 6 rows for 2 nodes, got 3 x 3",
    ),
    "strange node": ("1,1,1,1,2.0\n7,1,7,1,2.0\n", "2: expected a node of the body, got 7"),
    "rotation": ("1,1,1,1,2.0\n1,4,1,4,2.0\n", "2: expected direction 1, 2 or 3, got 4 of"),
    "not symmetric": (
        "1,1,2,1,2.0\n2,1,1,1,3.0\n1,1,1,1,1.0\n",
        "mtx: expected a symmetric matrix, got a",
    ),
    "columns": ("1 2\n", "mtx: expected 3 or 5 columns, got 2"),
    "text": ("1,1,1,1,two\n", "mtx: expected rows of numbers, got other"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_of_files(name, tmp_path):
    text, message = FAULTS[name]
    (tmp_path / "K.mtx").write_text(text)
    with pytest.raises(MeshFault, match="K.mtx") as caught:
        read_matrix(tmp_path / "K.mtx", np.array([1, 2]))
    assert message in str(caught.value)


def test_faults_of_dmig(tmp_path):
    (tmp_path / "two.pch").write_text(
        "DMIG,K,0,6,2\nDMIG,K,1,1,,1,1,5.\nDMIG,M,0,6,2\nDMIG,M,1,1,,1,1,5.\n"
    )
    with pytest.raises(MeshFault, match="pch: expected one DMIG matrix, got K, M"):
        read_matrix(tmp_path / "two.pch", np.array([1]))
    (tmp_path / "odd.pch").write_text("DMIG,K,0,6,2\nDMIG,K,1,1,,1,1,five\n")
    with pytest.raises(MeshFault, match="odd.pch: DMIG K: expected a number in field 8, got"):
        read_matrix(tmp_path / "odd.pch", np.array([1]))


@pytest.mark.parametrize(
    "change, message",
    [
        (
            {"stiffness_unit": "1 N/m"},
            "mtx: expected a speed of sound of 800 to",
        ),
        ({"mass_unit": "1 kg"}, "check mass_unit, mesh_unit"),
        ({"mass": None}, "mass: expected a value with a body of"),
        ({"mesh_unit": "1 m"}, "check"),
    ],
)
def test_units_that_cannot_be(change, message, original, tmp_path, monkeypatch):
    mesh, K, M = original
    write_pair(tmp_path, K, M)
    scale = 1e3 if "mesh_unit" in change else 1.0
    cylinder = {"radius": 28.025, "lower": 50, "upper": 155}
    cylinder = {key: f"{value * scale} mm" for key, value in cylinder.items()}
    bolts = {"shape": "plane", "height": f"{50 * scale} mm"}
    table = write_nodes(tmp_path, mesh, scale=1e3) | {"mesh_unit": "1 mm", **UNITS}
    table |= {"surfaces": {"bore": {"shape": "cylinder"} | cylinder, "bolts": bolts}} | change
    with pytest.raises(BadInput, match=message):
        reduced(table, tmp_path, monkeypatch)


def test_held_or_misordered_matrices_are_refused(original, tmp_path, monkeypatch):
    mesh, K, M = original
    meshio.write(
        tmp_path / "block.inp",
        meshio.Mesh(
            mesh.points,
            [("tetra10", mesh.tets)],
            point_sets={name: mesh.nodes(name) for name in ("bore", "bolts")},
        ),
    )
    wrong = np.random.default_rng(0).permutation(K.shape[0])
    write_pair(tmp_path, K[wrong][:, wrong], M)
    table = {"mesh": "block.inp", **FILES, **UNITS}
    with pytest.raises(BadInput, match="mtx: expected no resistance to rigid"):
        reduced(table, tmp_path, monkeypatch)


def test_supports_in_one_line_are_refused(original, tmp_path, monkeypatch):
    mesh, K, M = original
    line = np.flatnonzero(np.isclose(mesh.points[:, 0], 0.0) & np.isclose(mesh.points[:, 2], 36e-3))
    table = write_nodes(tmp_path, mesh, ("bore",), bolts=line) | UNITS
    write_pair(tmp_path, K, M)
    with pytest.raises(BadInput, match=f"got {len(line)} that leave 1 rigid motions"):
        reduced(table, tmp_path, monkeypatch)
