"""Meshes in other units and axes, surfaces by set or by geometry, linear elements, faults."""

import meshio
import numpy as np
import pytest
from scipy.spatial import cKDTree

from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.finite_elements.mesh import MeshFault, read_mesh
from piston_cosim.fmu_mfbd.finite_elements.regions import Cylinder
from piston_cosim.master.fmi.errors import BadInput

SKIRT = Cylinder(28e-3, -16e-3, 8e-3)


@pytest.fixture(scope="module")
def original(coarse):
    return read_mesh(coarse[0] / "piston.msh", {"skirt": None})


def same_faces(a, b):
    """Faces of two meshes at the same places, whatever their numbers."""
    ours, theirs = (mesh.points[faces].mean(axis=1) for mesh, faces in (a, b))
    return (
        len(ours) == len(theirs) and cKDTree(ours).query(theirs)[0].max() < 1e-7
    )  # files hold about nine digits


def test_linear_elements_get_edge_nodes_with_a_warning(original, tmp_path):
    path, said = tmp_path / "linear.inp", []
    meshio.write(path, meshio.Mesh(original.points, [("tetra", original.tets[:, :4])]))
    mesh = read_mesh(path, {"skirt": SKIRT}, say=said.append)
    assert mesh.tets.shape == original.tets.shape and len(mesh.points) == len(original.points)
    assert "linear tetrahedra" in said[0]
    corners = ((one, one.faces["skirt"][:, :3]) for one in (mesh, original))
    assert same_faces(*corners)


def test_left_handed_axes_are_refused(coarse):
    with pytest.raises(MeshFault, match="axes: expected three right-handed"):
        read_mesh(coarse[0] / "piston.msh", {}, axes=("-x", "y", "z"))


FAULTS = {
    "modes of the grid": (
        {"modes": 191, "basis": "pressure_modes"},
        "modes: expected at most 190 with",
    ),
    "edges": (
        {"skirt_upper": "60 mm"},
        "skirt_upper: expected within surface",
    ),
    "units": ({"mesh_unit": "1 mm"}, "msh: expected a body of 5 mm to 5 m, got"),
    "density": ({"density": "2.7 kg/m^3"}, r"density: expected a value of at least 500 kg/m\^3,"),
    "no mesh": ({"mesh": "words.msh"}, "msh: expected a mesh file, got other or"),
    "not reduced": (
        {"reduced": "words.msh"} | dict.fromkeys(("mesh", "density", "poisson", "young")),
        r"reduced: expected an \.npz file, got",
    ),
    "shell": ({"mesh": "shell.inp"}, "inp: expected 10-node tetrahedra, got 1"),
    "surface": (
        {"mesh": "block.msh"},
        "surface 'pin_bore': expected outer faces, got no such name; the file names bolts, bore",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_named_before_anything_is_solved(name, coarse, monkeypatch, tmp_path):
    """No factorisation may begin."""
    from piston_cosim.fmu_mfbd.finite_elements import solver

    def never(K):
        raise AssertionError("factorised")

    monkeypatch.setattr(solver, "factorise", never)
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    change, message = FAULTS[name]
    folder, options = coarse
    (folder / "words.msh").write_text("no mesh")
    meshio.write(folder / "shell.inp", meshio.Mesh(np.eye(3), [("triangle", [[0, 1, 2]])]))
    table = {key: value for key, value in (options["piston"] | change).items() if value is not None}
    with pytest.raises(BadInput, match=message):
        reduced_bodies({"grid": [16, 12], "piston": table}, folder, lambda text: None)
