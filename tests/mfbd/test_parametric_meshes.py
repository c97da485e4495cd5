"""The parametric piston and block: valid, symmetric and of the mass given by their sizes.

These tests need the extra `mesh`.
"""

from dataclasses import replace

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.finite_elements.element import consistent_mass
from piston_cosim.fmu_mfbd.finite_elements.mesh import read_mesh
from piston_cosim.fmu_mfbd.reduction.symmetry import mirror_image

pytest.importorskip("gmsh", reason="the extra `mesh` is not installed")


def made(shape, path, size, surfaces):
    from piston_cosim.models.meshes import make

    make(path, shape, size, 8)
    return read_mesh(path, dict.fromkeys(surfaces))


def test_box_walls_add_what_they_weigh(tmp_path):
    """Walls between the thrust sides, outside of bosses and pillars, add the mass of their volume.

    The tolerance is that of the chords of the mesh.
    """
    from piston_cosim.models.numerical_example.make_meshes import PISTON

    coarse, surfaces = replace(PISTON, top=27.0), ("skirt", "crown", "pin_bore")
    meshes = [
        made(shape, tmp_path / f"{k}.msh.xz", 7.0, surfaces)
        for k, shape in enumerate((coarse, replace(coarse, box_wall=(2.0, 20.0))))
    ]
    for mesh in meshes:
        assert all(mirror_image(mesh.points, axis) is not None for axis in (0, 2))
        assert np.ptp(mesh.points, axis=0) == pytest.approx([56.45e-3, 43e-3, 56.45e-3], rel=1e-6)
    plain, walled = (consistent_mass(mesh.points, mesh.tets, 1.0).sum() / 3 for mesh in meshes)
    # each of two walls: 2 mm thick, between x = +-sqrt(27^2 - z^2) for z = 20..22, from y = -16 to
    # the root at 24, less the
    # ring belt (inner radius 23, y > 11), the pillars (x within 7.5, y > 0) and the bosses (circle
    # of 11.5 about the pin)
    z = np.linspace(20.0, 22.0, 401)[:, None]
    x, y = np.linspace(-27, 27, 1081), np.linspace(-16, 24, 801)[:, None, None]
    inner = np.hypot(x, z) < np.where(y < 11, np.interp(y, [-16, 11], [26.5, 26.0]), 23.0)
    solid = ((np.abs(x) < 7.5) & (y > 0)) | (np.hypot(x, y) < 11.5)
    volume = 2 * (inner & ~solid & (y < 22)).mean() * 2.0 * 54 * 40 * 1e-9
    assert walled - plain == pytest.approx(volume, rel=0.03)


def test_fins_of_a_block(tmp_path):
    """A block without fins is lighter by the fins' volume."""
    from piston_cosim.models.numerical_example.make_meshes import BLOCK

    meshes = [
        made(shape, tmp_path / f"{k}.msh.xz", 14.0, ("bore", "bolts"))
        for k, shape in enumerate((BLOCK, replace(BLOCK, fins=(102.0,))))
    ]
    finned, plain = (consistent_mass(mesh.points, mesh.tets, 1.0).sum() / 3 for mesh in meshes)
    ring, holes = np.pi * (47.0**2 - 35.25**2) * 4.0, 4 * np.pi * 4.5**2 * 4.0
    # the stud holes lie partly beyond the fins' edge
    assert 2 * (ring - holes) * 1e-9 < finned - plain < 2 * ring * 1e-9


@pytest.mark.parametrize("kind", ["slipper", "full"])
def test_own_piston_has_its_sizes_and_its_skirt(tmp_path, kind):
    """The piston has its given sizes and is symmetric to the last bit.

    The skirt of a slipper is two panels of half width 0.36 bores. A node within 1e-7 m of a surface
    belongs to it.
    """
    from piston_cosim.master.engine.new import engine
    from piston_cosim.master.engine.piston_mesh import mesh_of_sizes

    made = engine({"bore": 86, "stroke": 86, "rod": 143})
    mesh_of_sizes(made, kind, tmp_path / "piston.msh.xz")
    mesh = read_mesh(tmp_path / "piston.msh.xz", dict.fromkeys(("skirt", "crown", "pin_bore")))
    assert all(mirror_image(mesh.points, axis) is not None for axis in (0, 2))
    x, y, z = mesh.points[mesh.nodes("skirt")].T
    assert np.hypot(x, z) == pytest.approx(made.skirt_radius, abs=1e-7)
    assert (y.min(), y.max()) == pytest.approx((-0.32 * 0.086, 0.16 * 0.086), abs=1e-7)
    widest = 0.36 * 0.086 if kind == "slipper" else made.skirt_radius
    assert np.abs(z).max() == pytest.approx(widest, abs=1e-7)
    x, y, _ = mesh.points[mesh.nodes("pin_bore")].T
    assert np.hypot(x, y) == pytest.approx(0.125 * 0.086, abs=1e-7)
    assert mesh.points[mesh.nodes("crown")][:, 1] == pytest.approx(0.36 * 0.086, abs=1e-7)
    mass = consistent_mass(mesh.points, mesh.tets, 2700.0).sum() / 3
    assert 0.25 < mass < 0.5  # kg; passenger car pistons of that bore: 0.25 to 0.5
