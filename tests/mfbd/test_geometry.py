"""Meshes that lie wrong are refused, with every fault; the shipped ones are not."""

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.finite_elements.mesh import read_mesh
from piston_cosim.fmu_mfbd.reduction.geometry import block_faults, circle_through, piston_faults
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.models import MODELS

from .conftest import quiet

SURFACES = dict.fromkeys(("skirt", "crown", "pin_bore"))
TURNS = {
    "upside down": np.diag([1.0, -1.0, -1.0]),
    "swapped": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
    "20 deg about y": Rotation.from_euler("y", 20, degrees=True).as_matrix(),
    "lying": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
}
MASS = 0.2  # [kg]


@pytest.fixture(scope="module")
def piston():
    """Mesh of the shipped fired piston."""
    return read_mesh(MODELS / "fired_motorcycle/piston.msh.xz", SURFACES, say=quiet)


UNTURNED = np.eye(3)


def moved(mesh, turn=UNTURNED, by=(0.0, 0.0, 0.0), scale=1.0):
    return type(mesh)(scale * mesh.points @ turn.T + by, mesh.tets, mesh.faces)


def test_circle_of_three_points():
    """(4, 2), (2, 4), (0, 2): centre (2, 2), radius 2."""
    circle = circle_through(np.array([4.0, 2.0, 0.0]), np.array([2.0, 4.0, 2.0]))
    assert circle == pytest.approx((2.0, 2.0, 2.0, 0.0), abs=1e-12)


@pytest.mark.parametrize("case", ["fired_motorcycle", "numerical_example"])
def test_shipped_meshes_lie_right(case):
    folder = MODELS / case
    mesh = read_mesh(folder / "piston.msh.xz", SURFACES, say=quiet)
    assert piston_faults(mesh, MASS, 0.0) == []
    bore = dict.fromkeys(("bore", "bolts"))
    assert block_faults(read_mesh(folder / "block.msh.xz", bore, say=quiet)) == []


@pytest.mark.parametrize(
    "change, words",
    [
        (dict(turn=TURNS["upside down"]), ["crown"]),
        (dict(turn=TURNS["swapped"]), ["expected an axis along z", "90 deg off"]),
        (dict(turn=TURNS["20 deg about y"]), ["20 deg off", "(0.342, "]),
        (dict(turn=TURNS["lying"]), ["expected an axis along y"]),
        (dict(by=(0.0, -8e-3, 0.0)), ["expected an axis at y = 0, got y = -8 mm"]),
        (dict(by=(3e-3, 0.0, 0.0)), ["got x = 3 mm", "of pin_offset = 0 mm"]),
        (dict(by=(0.0, 0.0, 3e-3)), ["z = 3 mm"]),
        (dict(scale=1.0 / 0.0254), ["mesh_unit"]),
    ],
)
def test_each_fault_is_told(piston, change, words):
    told = "\n".join(piston_faults(moved(piston, **change), MASS, 0.0))
    assert all(word in told for word in words), told


def test_a_pin_offset_of_the_mesh_must_be_that_of_the_case(piston):
    assert "pin_offset = 4 mm" in piston_faults(piston, MASS, 4e-3)[0]


@pytest.mark.parametrize("mass", [0.01, 4658.0])
def test_a_mass_that_cannot_be_is_told(piston, mass):
    (fault,) = piston_faults(piston, mass, 0.0)
    assert f"and {mass:.4g} kg" in fault


def test_all_faults_of_both_bodies_are_one_answer(coarse, tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    folder, options = coarse
    for name, by in (("piston", (3e-3, 8e-3, 0.0)), ("block", (0.0, -60e-3, 0.0))):
        mesh = meshio.read(folder / f"{name}.msh")
        mesh.points = mesh.points + by
        meshio.write(tmp_path / f"{name}.msh", mesh, file_format="gmsh22", binary=True)
    table = {"grid": options["grid"]}
    table |= {name: options[name] | {"modes": 0} for name in ("piston", "block")}
    with pytest.raises(BadInput) as refused:
        reduced_bodies(table, tmp_path, quiet)
    told = str(refused.value)
    for words in (
        "'skirt': expected an axis at x = z = 0, got x = 3 mm",
        "'pin_bore': expected an axis at y = 0, got y = 10 mm",
        "'bore': expected it above the crank axis at y = 0, got y = -10 mm",
    ):
        assert words in told
