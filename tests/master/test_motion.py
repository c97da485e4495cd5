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


def test_a_series_has_bodies_and_film_where_they_are(tmp_path):
    bodies = solids()
    pressure = np.arange(4 * 8 * 2.0).reshape(4, 8, 2)
    block = ExportedField(
        "ehd.pressure", "Pa", INSTANTS, np.arange(1, 9), np.arange(1, 3), pressure
    )
    upright = bodies[0].motion * [0, 1, 0]
    films = [Film("ehd", [block], *cylinder_cells((8, 2), 0.7, (-0.5, 1.5)), upright)]
    path = write_series(bodies, films, INSTANTS, np.array([0, 2]), tmp_path / "run.pvd")
    entries = [one.attrib for one in ElementTree.parse(path).iter("DataSet")]
    assert [(float(one["timestep"]), one["part"]) for one in entries] == [
        (time, part) for time in (0.1, 0.3) for part in "012"
    ]
    body, _, film = [meshio.read(tmp_path / one["file"]) for one in entries[3:]]
    piston = bodies[0]
    across, along, beta = piston.motion[2]
    c, s = np.cos(beta), np.sin(beta)
    turned = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert body.points == pytest.approx(piston.points @ turned.T + [across, along, 0])
    moved = turned @ (piston.modes @ piston.coordinates[2])[4]
    assert body.point_data["displacement [m]"][4] == pytest.approx(moved)
    assert body.point_data["von Mises stress [Pa]"] == pytest.approx(piston.stress[2])
    assert film.cell_data["ehd.pressure [Pa]"][0] == pytest.approx(pressure[2].ravel())
    assert np.hypot(film.points[:, 0], film.points[:, 2]) == pytest.approx(0.7)
    heights = film.points[:, 1]
    assert (heights.min(), heights.max()) == pytest.approx((along - 0.5, along + 1.5))


def in_line():
    """Two cylinders: the bodies above, 0.2 m along the crank and turned by 30 deg; and as they are,
    at -0.1 m.
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


def test_every_cylinder_of_a_series_stands_at_its_place(tmp_path):
    bodies = in_line()
    block = ExportedField(
        "low.pressure", "Pa", INSTANTS, np.arange(1, 5), np.arange(1, 3), np.ones((4, 4, 2))
    )
    surface = cylinder_cells((4, 2), 0.7, (0.25, 0.5))
    films = [Film("low", [block], *surface, bodies[0].motion, bodies[0].stand)]
    path = write_series(bodies, films, INSTANTS, np.array([2]), tmp_path / "run.pvd")
    files = [one.attrib["file"] for one in ElementTree.parse(path).iter("DataSet")]
    wanted = ["front_piston", "front_block", "rear_piston", "rear_block", "low"]
    assert files == [f"run/{name}_00002.vtu" for name in wanted]
    meshes = [meshio.read(tmp_path / file) for file in files]
    across, along, beta = bodies[0].motion[2]
    turned = np.array([[np.cos(beta), -np.sin(beta)], [np.sin(beta), np.cos(beta)]])

    def gone(points):
        return np.column_stack([points[:, :2] @ turned.T + [across, along], points[:, 2]])

    for mesh, solid in zip(meshes, bodies):
        own = solid.points if solid.motion is None else gone(solid.points)
        assert mesh.points == pytest.approx(in_the_engine(own, solid.stand))
    points, _ = surface
    assert meshes[-1].points == pytest.approx(in_the_engine(gone(points), bodies[0].stand))
    deflection = gone((bodies[0].modes @ bodies[0].coordinates[2])[4:5]) - [across, along, 0]
    shown = meshes[0].point_data["displacement [m]"][4:5]
    assert shown == pytest.approx(in_the_engine(deflection, Stand(0.0, bodies[0].stand.bank)))


def test_cells_of_a_pin_are_centred_where_its_grid_has_them():
    """Cell i at 2 pi (i - 1)/n from x towards y; j along z."""
    points, cells = pin_cells((6, 2), 0.02, (-0.01, 0.03))
    centres = points[cells].mean(axis=1).reshape(6, 2, 3)
    angle = np.arctan2(centres[..., 1], centres[..., 0]) % (2 * np.pi)
    assert angle == pytest.approx(np.repeat(np.arange(6)[:, None] * np.pi / 3, 2, axis=1))
    assert centres[..., 2] == pytest.approx(np.tile([0.0, 0.02], (6, 1)))
    assert np.hypot(*points[:, :2].T) == pytest.approx(0.02)
