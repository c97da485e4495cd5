"""Gas on the bore's wall: closed forms, sums over the faces of a mesh, effect on a run."""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import ReducedBodies, assemble
from piston_cosim.fmu_mfbd.dynamics.gas_on_bore import WallPressures, bore_wall, wall_forces
from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.dynamics.model_faults import faults
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.finite_elements.faces import face_load
from piston_cosim.fmu_mfbd.finite_elements.mesh import read_mesh
from piston_cosim.fmu_mfbd.options import read_options
from piston_cosim.fmu_mfbd.reduction.reduce import reduce_block

RADIUS = 36.5e-3
LOW, HIGH = 60e-3, 166e-3


def test_pressure_times_projected_area():
    """Forces of three fields agree with hand calculations, also between the table's heights.

    The wall's area above the top ring is 2 pi 36.5 mm x 26 mm = 5.9627e-3 m2 under 4 MPa. That of
    the 9 mm between the rings is 2.0640e-3 m2 under 0.5 MPa. The field phi = 1 gives pressure times
    area. The field phi = y - 60 mm uses the middles of both bands, 93 and 75.5 mm above the table's
    foot. The field phi = cos(theta) gives zero. A cubic represents the quadratic W exactly.
    """
    theta = 2 * np.pi * np.arange(16)[:, None, None] / 16
    heights = np.linspace(LOW, HIGH, 12)
    y = heights[None, :, None]
    radial = np.concatenate(
        [1 + 0 * (theta + y), y - LOW + 0 * theta, np.cos(theta) + 0 * y], axis=2
    )
    wall = bore_wall(heights, radial, RADIUS, top_ring=24e-3, second_ring=15e-3)
    found = wall_forces(wall, 116e-3, WallPressures(4e6, 0.5e6))
    first = 4e6 * 5.962743e-3
    land = 0.5e6 * 2.064026e-3
    expected = [first + land, first * 93e-3 + land * 75.5e-3, 0.0]
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_no_wall_above_the_rings_and_none_below_the_bore():
    """With the top ring out of the bore nothing stands above it; far below, all of the wall."""
    heights = np.linspace(LOW, HIGH, 12)
    wall = bore_wall(heights, np.ones((16, 12, 1)), RADIUS, top_ring=24e-3, second_ring=15e-3)
    assert wall_forces(wall, 0.160, WallPressures(4e6, 0.5e6)).item() == 0.0
    everywhere = wall_forces(wall, 0.0, WallPressures(4e6, 0.0)).item()
    assert everywhere == pytest.approx(4e6 * 2 * np.pi * RADIUS * (HIGH - LOW), rel=1e-12)


def test_virtual_work_is_that_of_the_mesh(bodies):
    """Modal forces from the table of the bore agree with nodal forces on the faces of the mesh.

    The pressure acts above a ring at an edge of faces. The tolerance is 2 %: modes have a peak at
    the thrust line, where 16 angles would miss 5 %, and fast modes bend within a ring of faces.
    """
    folder, build = bodies
    block = read_options(build, folder).block
    reduced = reduce_block(block, (48, 12), lambda text: None)
    mesh = read_mesh(folder / "block.msh", {"bore": None})
    faces = mesh.faces["bore"]
    for layer in (0, 4, 8):
        edge = 50e-3 + layer * 10.5e-3
        above = faces[mesh.points[faces, 1].min(axis=1) > edge - 1e-6]
        nodal = face_load(mesh.points, above)
        expected = np.einsum("na,nak->k", nodal, reduced.anatomy.shapes)
        wall = bore_wall(reduced.body.heights, reduced.body.radial, reduced.body.radius, 1e-9, 1e-9)
        found = wall_forces(wall, edge, WallPressures(1.0, 1.0))
        assert np.abs(found - expected).max() <= 0.02 * np.abs(expected).max()


def test_a_share_of_the_gas_between_the_rings(reduced):
    """Eq. (D18) by hand: an unit of W a metre of height, one mode that is wide everywhere alike.

    Bore 0 to 0.2 m, A at 0.1 m, rings 20 and 10 mm above it: 80 mm of wall bear 5 MPa, 10 mm a
    fifth of it and 0.3 MPa of the input.
    """
    height = np.linspace(0.0, 0.2, 21)
    even = np.full((8, 21, 1), 1.0 / (2 * np.pi * 0.04))
    wall = bore_wall(height, even, 0.04, 20e-3, 10e-3, 0.2)
    (force,) = wall_forces(wall, 0.1, WallPressures(5e6, 3e5))
    assert force == pytest.approx(5e6 * 0.08 + (1e6 + 3e5) * 0.01, rel=1e-12)
    options, piston, block = reduced
    rings = dict(top_ring_height=16e-3, second_ring_height=12e-3)
    shared = assemble(piston, block, options, Parameters(**rings, land_pressure_share=0.3))
    assert shared.system.wall.land_share == 0.3


def test_an_even_land_pressure_leaves_a_rigid_piston_alone(reduced):
    """With a rigid block the motion is the same to the last bit.

    The land pressure loads both rings along the bore's axis with equal and opposite forces.
    """
    options, piston, block = reduced
    last = ("radial", "axial", "omega", "kind")
    rigid = dataclasses.replace(block, **{name: getattr(block, name)[..., :0] for name in last})
    nothing = np.zeros((16, 12))
    rings = dict(top_ring_height=16e-3, second_ring_height=12e-3)
    ends = []
    for share in (0.0, 0.5):
        parameters = Parameters(**rings, land_pressure_share=share)
        model = assemble(piston, rigid, options, parameters)
        gas = Inputs(300.0, 6e6, nothing, nothing)
        state, _ = model.start(0.3, 2e-6, 1e-4, gas)
        for _ in range(3):
            state, out = model.advance(state, gas, 5e-5)
        ends.append((state.position, out["pin_force_x"], out["pin_force_y"]))
    for there, here in zip(*ends):
        np.testing.assert_array_equal(there, here)


def test_rings_beside_one_another_are_refused(reduced):
    options, piston, block = reduced
    for second in (5e-3, 17e-3):
        wrong = Parameters(top_ring_height=16e-3, second_ring_height=second)
        (text,) = faults(ReducedBodies(piston, block), options, wrong)
        assert text.startswith("second_ring_height: expected") and f", got {second:g} m" in text
        assert "to top_ring_height = 0.016 m" in text
