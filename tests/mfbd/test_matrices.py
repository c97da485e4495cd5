"""Matrices of other programs: our own mesh's stiffness and mass, written in each format, reduce to
the same body as the mesh.
"""

import meshio
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.io import mmwrite

from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.finite_elements.element import consistent_mass, stiffness
from piston_cosim.fmu_mfbd.finite_elements.matrices import read_matrix
from piston_cosim.fmu_mfbd.finite_elements.mesh import MeshFault, read_mesh
from piston_cosim.master.fmi.errors import BadInput

UNITS = {"stiffness_unit": "1 N/mm", "mass_unit": "1 t"}
GAP = 10  # node numbers of the text formats run 10, 20, ..., as after a renumbering


@pytest.fixture(scope="module")
def original(coarse):
    """Mesh of the small block, its matrices in N/mm and t, and its reduced body."""
    folder, options = coarse
    mesh = read_mesh(folder / "block.msh", {"bore": None, "bolts": None})
    K, M = (
        stiffness(mesh.points, mesh.tets, 75e9, 0.33) / 1e3,
        consistent_mass(mesh.points, mesh.tets, 2700.0) / 1e3,
    )
    return mesh, K, M


def reduced(table, folder, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(folder / "cache"))
    return np.load(
        reduced_bodies({"grid": [16, 12], "block": table}, folder, lambda text: None)["block"]
    )


@pytest.fixture(scope="module")
def from_mesh(coarse, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        return reduced(
            coarse[1]["block"] | {"mesh": str(coarse[0] / "block.msh")},
            tmp_path_factory.mktemp("mesh"),
            patch,
        )


def write_labels(path, matrix, lower=True):
    """Abaqus' matrix input format: one triangle, node numbers with gaps, a heading."""
    part = sp.tril(matrix).tocoo() if lower else matrix.tocoo()
    lines = [
        f"{GAP * (r // 3 + 1)},{r % 3 + 1}, {GAP * (c // 3 + 1)},{c % 3 + 1}, {v:.17e}"
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
        node, direction = GAP * (c // 3 + 1), c % 3 + 1
        if large:
            lines.append(f"DMIG*   {name:<16}{node:>16}{direction:>16}")
            lines += [
                f"*       {GAP * (r // 3 + 1):>16}{r % 3 + 1:>16}{v:>16.9E}".replace("E", "D")
                for r, v in zip(rows, values)
            ]
        else:
            entries = [f"{GAP * (r // 3 + 1)},{r % 3 + 1},{v:.9e},0." for r, v in zip(rows, values)]
            lines.append(f"DMIG,{name},{node},{direction},,{entries[0]}")
            lines += [f",{','.join(entries[k : k + 2])}" for k in range(1, len(entries), 2)]
    path.write_text("\n".join(lines) + "\n")


def write_inp(path, mesh):
    """Abaqus mesh with gaps between its node numbers, in millimetres, thrust along the file's z,
    pin along -x.
    """
    lines = ["*NODE, NSET=ALL"]
    lines += [
        f"{GAP * k}, {-1e3 * z:.12g}, {1e3 * y:.12g}, {1e3 * x:.12g}"
        for k, (x, y, z) in enumerate(mesh.points, 1)
    ]
    lines += ["*ELEMENT, TYPE=C3D10"]
    lines += [
        f"{k}, " + ", ".join(str(GAP * (n + 1)) for n in nodes)
        for k, nodes in enumerate(mesh.tets, 1)
    ]
    for name in ("bore", "bolts"):
        lines += [f"*NSET, NSET={name}", *(f"{GAP * (n + 1)}," for n in mesh.nodes(name))]
    path.write_text("\n".join(lines) + "\n")


def write_bdf(path, mesh):
    """Nastran mesh with the same numbers, units and axes, large and free fields mixed."""
    lines = ["BEGIN BULK"]
    for k, (x, y, z) in enumerate(mesh.points * 1e3, 1):
        lines += [f"GRID*   {GAP * k:>16}{'':>16}{-z:>16.9f}{y:>16.9f}*", f"*       {x:>16.9f}"]
    for k, nodes in enumerate(GAP * (mesh.tets + 1), 1):
        lines += [
            f"CTETRA,{k},1," + ",".join(map(str, nodes[:6])) + ",+",
            "+," + ",".join(map(str, nodes[6:])),
        ]
    path.write_text("\n".join([*lines, "ENDDATA", ""]))


BY_GEOMETRY = {
    "bore": {"shape": "cylinder", "radius": "28.025 mm", "lower": "50 mm", "upper": "155 mm"},
    "bolts": {"shape": "plane", "height": "50 mm"},
}


def turned_to_file(matrix):
    """The matrix with the vectors of `write_inp`'s axes."""
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
    """DMIG's fields of sixteen characters hold ten digits, which the ratio of largest to lowest
    eigenvalue, 1e8, makes 1e-6 of the lowest frequencies; the other formats hold seventeen.
    """
    mesh, K, M = original
    names = {
        "stiffness": "K.pch" if "dmig" in kind else "K.mtx",
        "mass": "M.pch" if "dmig" in kind else "M.mtx",
    }
    table = {"mesh": str(coarse[0] / "block.msh"), "modes": 10, "stations": 24, **UNITS, **names}
    if "labels" in kind or "dmig" in kind:
        write_inp(tmp_path / "block.inp", mesh)
        write_bdf(tmp_path / "block.bdf", mesh)
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
    """A CSV of nodes with sets: the same fixed-interface frequencies, surfaces triangulated to the
    mesh's own accuracy.
    """
    mesh, K, M = original
    order = np.random.default_rng(0).permutation(len(mesh.points))
    lines = ["node,x,y,z,sets"]
    for k in order:
        sets = " ".join(name for name in ("bore", "bolts") if k in mesh.nodes(name))
        lines.append(
            f"{GAP * (k + 1)},{','.join(f'{1e3 * x:.12g}' for x in mesh.points[k])},{sets}"
        )
    (tmp_path / "nodes.csv").write_text("\n".join(lines) + "\n")
    for name, matrix in (("K.mtx", K), ("M.mtx", M)):
        write_labels(tmp_path / name, matrix)
    table = {
        "mesh": "nodes.csv",
        "mesh_unit": "1 mm",
        "stiffness": "K.mtx",
        "mass": "M.mtx",
        "modes": 10,
        "stations": 24,
    }
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
    """Crown of three-node triangles: the modal gas force of the mesh's six-node faces, within the
    faces' own error.
    """
    folder, options = coarse
    mesh = read_mesh(folder / "piston.msh", {"skirt": None, "crown": None, "pin_bore": None})
    for name, matrix in (
        ("K.mtx", stiffness(mesh.points, mesh.tets, 75e9, 0.33)),
        ("M.mtx", consistent_mass(mesh.points, mesh.tets, 2700.0)),
    ):
        mmwrite(tmp_path / name, matrix, symmetry="symmetric")
    lines = ["node,x,y,z,sets"]
    for k, point in enumerate(mesh.points):
        sets = " ".join(name for name in ("skirt", "crown", "pin_bore") if k in mesh.nodes(name))
        lines.append(f"{k},{','.join(f'{x:.12g}' for x in point)},{sets}")
    (tmp_path / "nodes.csv").write_text("\n".join(lines) + "\n")
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "cache"))
    table = {
        "mesh": "nodes.csv",
        "stiffness": "K.mtx",
        "mass": "M.mtx",
        "stiffness_unit": "1 N/m",
        "mass_unit": "1 kg",
        "basis": "craig_bampton",
        "modes": 12,
    }
    imported = np.load(
        reduced_bodies({"grid": [16, 12], "piston": table}, tmp_path, lambda text: None)["piston"]
    )
    exact = np.load(
        reduced_bodies(
            {"grid": [16, 12], "piston": options["piston"] | {"basis": "craig_bampton"}},
            folder,
            lambda text: None,
        )["piston"]
    )
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
    lines = ["node,x,y,z"] + [
        f"{k},{','.join(f'{1e3 * x:.12g}' for x in point)}" for k, point in enumerate(mesh.points)
    ]
    (tmp_path / "nodes.csv").write_text("\n".join(lines) + "\n")
    mmwrite(tmp_path / "K.mtx", K, symmetry="symmetric")
    mmwrite(tmp_path / "M.mtx", M, symmetry="symmetric")
    scale = 1e3 if "mesh_unit" in change else 1.0
    table = {
        "mesh": "nodes.csv",
        "mesh_unit": "1 mm",
        "stiffness": "K.mtx",
        "mass": "M.mtx",
        **UNITS,
        "surfaces": {
            "bore": {"shape": "cylinder"}
            | {
                key: f"{value * scale} mm"
                for key, value in (("radius", 28.025), ("lower", 50), ("upper", 155))
            },
            "bolts": {"shape": "plane", "height": f"{50 * scale} mm"},
        },
    } | change
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
    mmwrite(tmp_path / "K.mtx", K[wrong][:, wrong])
    mmwrite(tmp_path / "M.mtx", M)
    table = {"mesh": "block.inp", "stiffness": "K.mtx", "mass": "M.mtx", **UNITS}
    with pytest.raises(BadInput, match="mtx: expected no resistance to rigid"):
        reduced(table, tmp_path, monkeypatch)


def test_supports_in_one_line_are_refused(original, tmp_path, monkeypatch):
    mesh, K, M = original
    line = np.flatnonzero(np.isclose(mesh.points[:, 0], 0.0) & np.isclose(mesh.points[:, 2], 36e-3))
    lines, bore = ["node,x,y,z,sets"], mesh.nodes("bore")
    for k, point in enumerate(mesh.points):
        position = ",".join(f"{x:.12g}" for x in point)
        lines.append(f"{k},{position},{'bolts' * (k in line)} {'bore' * (k in bore)}")
    (tmp_path / "nodes.csv").write_text("\n".join(lines) + "\n")
    mmwrite(tmp_path / "K.mtx", K, symmetry="symmetric")
    mmwrite(tmp_path / "M.mtx", M, symmetry="symmetric")
    with pytest.raises(BadInput, match=f"got {len(line)} that leave 1 rigid motions"):
        reduced(
            {"mesh": "nodes.csv", "stiffness": "K.mtx", "mass": "M.mtx", **UNITS},
            tmp_path,
            monkeypatch,
        )
