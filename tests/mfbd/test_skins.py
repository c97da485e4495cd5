"""Surfaces that pages draw: corners of outer faces, with the displacement of `results recover`."""

from dataclasses import fields

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.finite_elements.element import von_mises
from piston_cosim.fmu_mfbd.offline import AROUND, _skin, cylinder, skins
from piston_cosim.fmu_mfbd.reduction.mode_tables import recover
from piston_cosim.fmu_mfbd.reduction.reduce import Reduced
from piston_cosim.fmu_mfbd.reduction.reduced_body import Anatomy, ReducedBlock, ReducedPiston
from piston_cosim.tests.verification.cases.bodies import box_mesh

from .conftest import sheets


def body_of(kind, **given):
    """Return a reduced body whose fields are None unless given."""
    return kind(**({one.name: None for one in fields(kind)} | given))


def test_displacement_and_stress_on_the_skin_are_the_recovered_ones():
    """Displacement and stress on the skin of two elements in a row of cells are the recovered ones.

    Corners take the mean of all elements around them. Elements that are left out have no effect.
    """
    points, tets = box_mesh((6, 1, 1), (6.0, 1.0, 1.0))
    assert not np.isin(tets, tets[:2]).any(axis=1).all()
    random = np.random.default_rng(7)
    anatomy = body_of(
        Anatomy,
        points=points,
        tets=tets,
        skin=tets[[1, 0]][:, [2, 0, 1, 6, 4, 5]],
        shapes=random.normal(size=(len(points), 3, 4)),
        young=7e10,
        poisson=0.3,
    )
    piston = body_of(ReducedPiston, skirt_lower=-0.02, skirt_upper=0.01)
    skin = _skin("piston", Reduced(piston, anatomy, None))
    assert skin.skirt == (-0.02, 0.01)
    assert skin.points[skin.triangles] == pytest.approx(anatomy.points[anatomy.skin[:, :3]])
    coordinates = random.normal(size=(2, 4))
    shown = skin.von_mises(coordinates)
    assert shown is not None
    for own, q in zip(shown, coordinates):
        found = recover(anatomy, q)
        whole = von_mises(found.stress)[np.unique(anatomy.skin[:, :3])]
        assert own == pytest.approx(whole, rel=1e-12)
        moved = (skin.modes @ q)[skin.triangles]
        assert moved == pytest.approx(found.displacement[anatomy.skin[:, :3]], rel=1e-12)
    block = _skin("block", Reduced(body_of(ReducedBlock), anatomy, None))
    assert block.von_mises(coordinates) is None and block.skirt is None


@pytest.mark.parametrize("top", [True, False])
def test_a_cylinder_has_the_area_and_the_volume_of_its_prism(top):
    """Of a prism over a regular polygon; the divergence theorem over the wall and the top."""
    radius, low, high = 0.04, -0.02, 0.03
    drawn = cylinder("any", radius, (low, high), top)
    a, b, c = np.moveaxis(drawn.points[drawn.triangles], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    base = AROUND / 2 * radius**2 * np.sin(2 * np.pi / AROUND)
    wall = 2 * AROUND * radius * np.sin(np.pi / AROUND) * (high - low)
    assert area == pytest.approx(wall + top * base, rel=1e-12)
    outwards = np.einsum("ti,ti->t", a, np.cross(b - a, c - a)) / 6
    # the wall gives 2/3 of base times length, the top a third of base times its height
    whole = base * (2 * (high - low) + top * high) / 3
    assert abs(outwards.sum()) == pytest.approx(whole, rel=1e-12)
    assert drawn.modes.shape == (len(drawn.points), 3, 0)
    assert drawn.skirt == ((low, high) if top else None)


def test_bodies_of_a_data_sheet_are_cylinders(tmp_path):
    drawn = skins(sheets(), tmp_path, print)
    skirt = -0.0455, 0.0373
    assert [(one.name, one.skirt) for one in drawn] == [("piston", skirt), ("block", None)]
    reached = [np.hypot(one.points[:, 0], one.points[:, 2]).max() for one in drawn]
    assert reached == pytest.approx([0.05495, 0.055], rel=1e-12)
    low, high = drawn[1].points[:, 1].min(), drawn[1].points[:, 1].max()
    assert (low, high) == pytest.approx((0.09, 0.36), rel=1e-12)
