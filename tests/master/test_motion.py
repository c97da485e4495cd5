"""Series for ParaView: bodies and films are where the recovered motion puts them."""

import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import meshio
import numpy as np
import pytest

from piston_cosim.master.results.fields_export import ExportedField, cylinder_cells, pin_cells
from piston_cosim.master.results.series import Film, write_series
from piston_cosim.master.results.solids import Solid, Stand

INSTANTS = np.array([0.1, 0.2, 0.3, 0.5])


def solids():
    random = np.random.default_rng(7)
    triangles = np.array([[0, 1, 2], [2, 3, 4], [4, 5, 6]])
    points = random.normal(size=(7, 3))
    motion = np.column_stack([1e-3 * random.normal(size=4), random.normal(size=4), [0, 0.01, 1, 2]])
    piston = Solid(
        "piston",
        points,
        triangles,
        random.normal(size=(7, 3, 3)),
        1e-3 * random.normal(size=(4, 3)) * [1, 1, 0],  # the third coordinate stays zero
        motion,
        film=(-0.5, 1.5),
        stress=random.uniform(size=(4, 7)),
    )
    return [piston, Solid("block", points, triangles, np.zeros((7, 3, 0)), np.zeros((4, 0)))]


def in_line():
    """Return the bodies of two cylinders at 0.2 m and -0.1 m along the crank.

    The first cylinder is turned by 30 deg.
    """
    stands = {"front": Stand(0.2, np.radians(30)), "rear": Stand(-0.1)}
    return [
        replace(solid, owner=owner, stand=stand)
        for owner, stand in stands.items()
        for solid in solids()
    ]


def in_the_engine(points, stand):
    """By hand: turned about z, then along it."""
    c, s = np.cos(stand.bank), np.sin(stand.bank)
    x, y, z = np.transpose(points)
    return np.column_stack([c * x - s * y, s * x + c * y, z + stand.along])


def test_bodies_and_films_of_every_cylinder_are_at_their_places(tmp_path):
    bodies = in_line()
    piston, stand = bodies[0], bodies[0].stand
    pressure = np.arange(4 * 8 * 2.0).reshape(4, 8, 2)
    block = ExportedField(
        "low.pressure", "Pa", INSTANTS, np.arange(1, 9), np.arange(1, 3), pressure
    )
    surface = cylinder_cells((8, 2), 0.7, (0.25, 0.5))
    films = [Film("low", [block], *surface, piston.motion, stand)]
    path = write_series(bodies, films, INSTANTS, np.array([0, 2]), tmp_path / "run.pvd")
    entries = [one.attrib for one in ElementTree.parse(path).iter("DataSet")]
    assert [(float(one["timestep"]), one["part"]) for one in entries] == [
        (time, part) for time in (0.1, 0.3) for part in "01234"
    ]
    files = [one["file"] for one in entries[5:]]
    wanted = ["front_piston", "front_block", "rear_piston", "rear_block", "low"]
    assert files == [f"run/{name}_00002.vtu" for name in wanted]
    meshes = [meshio.read(tmp_path / file) for file in files]
    across, along, beta = piston.motion[2]
    turned = np.array([[np.cos(beta), -np.sin(beta)], [np.sin(beta), np.cos(beta)]])

    def gone(points):
        return np.column_stack([points[:, :2] @ turned.T + [across, along], points[:, 2]])

    for mesh, solid in zip(meshes, bodies):
        own = solid.points if solid.motion is None else gone(solid.points)
        assert mesh.points == pytest.approx(in_the_engine(own, solid.stand))
    assert meshes[-1].points == pytest.approx(in_the_engine(gone(surface[0]), stand))
    assert meshes[-1].cell_data["low.pressure [Pa]"][0] == pytest.approx(pressure[2].ravel())
    deflection = gone((piston.modes @ piston.coordinates[2])[4:5]) - [across, along, 0]
    shown = meshes[0].point_data["displacement [m]"][4:5]
    assert shown == pytest.approx(in_the_engine(deflection, Stand(0.0, stand.bank)))
    assert meshes[0].point_data["von Mises stress [Pa]"] == pytest.approx(piston.stress[2])


def test_cells_of_a_pin_are_centred_where_its_grid_has_them():
    """Cell i at 2 pi (i - 1)/n from x towards y; j along z."""
    points, cells = pin_cells((6, 2), 0.02, (-0.01, 0.03))
    centres = points[cells].mean(axis=1).reshape(6, 2, 3)
    angle = np.arctan2(centres[..., 1], centres[..., 0]) % (2 * np.pi)
    assert angle == pytest.approx(np.repeat(np.arange(6)[:, None] * np.pi / 3, 2, axis=1))
    assert centres[..., 2] == pytest.approx(np.tile([0.0, 0.02], (6, 1)))
    assert np.hypot(*points[:, :2].T) == pytest.approx(0.02)
