"""Small bodies for the unit tests: a tube with a crown as piston, and a tube as block."""

import meshio
import numpy as np
import pytest

from piston_cosim.fmu_mfbd.finite_elements.element import rigid_motions
from piston_cosim.fmu_mfbd.finite_elements.faces import surface_matrix
from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled
from piston_cosim.fmu_mfbd.finite_elements.mesh import Mesh, outer_faces
from piston_cosim.fmu_mfbd.finite_elements.ring import Ring, ring_mesh
from piston_cosim.fmu_mfbd.reduction.bases import Elastic, MeanElastic, mean_conditions
from piston_cosim.tests.verification.cases.bodies import box_mesh

INNER, OUTER = 24e-3, 28e-3

SHEET = {
    "mass": "1.39 kg",
    "centre": ["1.5 mm", "26.5 mm"],
    "inertia": "0.003 kg*m^2",
    "radius": "54.95 mm",
}
"""Data sheet of a piston, as in `pin_models`."""


def sheets(piston=(), block=(), **build):
    """Build table of rigid bodies from data sheets, with more options of both and of the table."""
    ends = {"skirt_lower": "-45.5 mm", "skirt_upper": "37.3 mm"}
    bore = {"rigid": {"radius": "55 mm"}, "bore_lower": "90 mm", "bore_upper": "360 mm"}
    bodies = {"piston": {"rigid": SHEET} | ends | dict(piston), "block": bore | dict(block)}
    return {"grid": [16, 12]} | bodies | build


def quiet(text):
    """Take a message of a reduction."""


def tube(cells, low, high, inner, outer):
    """Return a tube of 10-node tetrahedra about y with cells (around, across, along).

    Edge nodes are on the cylinders.
    """
    mesh = ring_mesh(Ring(inner, outer, high - low, 2 * np.pi, cells))
    x, y, z = mesh.points.T
    return np.stack([y, z + (low + high) / 2, x], axis=1), mesh.tets


def clamped_box(cells, size):
    """Mesh of a box and its elastic body, held where y is 0."""
    points, tets = box_mesh(cells, size)
    mesh = Mesh(points, tets, {})
    _, K, M = assembled(mesh, 7e10, 0.3, 2700.0)
    return mesh, Elastic(K, M, np.flatnonzero(points[:, 1] == 0.0))


def mean_held(body, surface):
    """Return a body whose mean motion over a surface is held; balanced loads do not feel this."""
    points = body.mesh.points
    area = np.asarray(surface_matrix(points, body.mesh.faces[surface]).sum(axis=1)).ravel()
    return MeanElastic(body.K, body.M, mean_conditions(points, area), rigid_motions(points))


def write(path, points, tets, surfaces):
    """Mesh file with named surfaces, given as node masks."""
    faces = outer_faces(tets)
    groups = [(name, faces[mask[faces].all(axis=1)]) for name, mask in surfaces.items()]
    cells = [("tetra10", tets)] + [("triangle6", group) for _, group in groups]
    tags = [np.full(len(c[1]), k + 1) for k, c in enumerate(cells)]
    meshio.write(
        path,
        meshio.Mesh(
            points,
            cells,
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data={name: np.array([k + 2, 2]) for k, (name, _) in enumerate(groups)},
        ),
        file_format="gmsh22",
        binary=True,
    )
    return path


def write_bodies(folder, around, across, along):
    """Write a small piston and a small block with their build table.

    The piston is a tube held at two inner patches along z, the block a tube held at its lower end.
    """
    points, tets = tube((around, across, along[0]), -16e-3, 20e-3, INNER, OUTER)
    x, y, z = points.T
    radius = np.hypot(x, z)
    write(
        folder / "piston.msh",
        points,
        tets,
        {
            "skirt": np.isclose(radius, OUTER) & (y < 10.1e-3),
            "crown": np.isclose(y, 20e-3),
            "pin_bore": np.isclose(radius, INNER) & (np.abs(x) < 10e-3) & (np.abs(y) < 9e-3),
        },
    )
    points, tets = tube((around, across, along[1]), 50e-3, 155e-3, OUTER + 25e-6, 36e-3)
    radius = np.hypot(points[:, 0], points[:, 2])
    write(
        folder / "block.msh",
        points,
        tets,
        {"bore": np.isclose(radius, OUTER + 25e-6), "bolts": np.isclose(points[:, 1], 50e-3)},
    )
    material = {"density": "2700 kg/m^3", "young": "75 GPa", "poisson": 0.33}
    return folder, {
        "grid": [16, 12],
        "piston": {"mesh": "piston.msh", "modes": 12, **material},
        "block": {"mesh": "block.msh", "modes": 10, "stations": 24, **material},
    }


@pytest.fixture(scope="session")
def bodies(tmp_path_factory):
    """Folder and build table of the small bodies."""
    return write_bodies(tmp_path_factory.mktemp("bodies"), 24, 2, (6, 10))


@pytest.fixture(scope="session")
def coarse(tmp_path_factory):
    """Return the small bodies with a quarter of the nodes, for tests that need no accuracy."""
    return write_bodies(tmp_path_factory.mktemp("coarse"), 16, 1, (6, 4))


@pytest.fixture(scope="session")
def kept_bodies(tmp_path_factory):
    """Cache of reduced bodies for the whole session: each small body is reduced once."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def kept(kept_bodies):
    """Set that cache for a module."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PISTON_COSIM_CACHE", str(kept_bodies))
        yield


@pytest.fixture(scope="session")
def reduced(coarse, kept_bodies):
    """(options, piston, block) of the small bodies, reduced."""
    from piston_cosim.fmu_mfbd.build import prepare
    from piston_cosim.fmu_mfbd.dynamics.build_options import BuildOptions
    from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedBlock, ReducedPiston, load

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PISTON_COSIM_CACHE", str(kept_bodies))
        options, files = prepare(coarse[1], coarse[0], quiet)
        piston, block = load(ReducedPiston, files[0]), load(ReducedBlock, files[1])
        return BuildOptions.from_json(options), piston, block


@pytest.fixture
def model(reduced):
    """Return a running model of the small bodies.

    Parameters have their start values, except for a skewed mechanism.
    """
    from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
    from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters

    options, piston, block = reduced
    return assemble(piston, block, options, Parameters(crank_offset=1e-3))
