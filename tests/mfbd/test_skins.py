"""Surfaces that pages draw: corners of outer faces, with the displacement that `recover` has."""

from dataclasses import fields

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.offline import _skin
from piston_cosim.fmu_mfbd.reduction.mode_tables import recover
from piston_cosim.fmu_mfbd.reduction.reduce import Reduced
from piston_cosim.fmu_mfbd.reduction.reduced_body import Anatomy, ReducedBlock, ReducedPiston


def body_of(kind, **given):
    """A reduced body of which only what is given matters."""
    return kind(**({one.name: None for one in fields(kind)} | given))


def test_displacement_at_the_corners_is_the_recovered_one():
    random = np.random.default_rng(3)
    anatomy = body_of(
        Anatomy,
        points=random.normal(size=(9, 3)),
        tets=np.empty((0, 10), int),
        skin=np.array([[8, 2, 5, 0, 1, 3], [5, 2, 7, 1, 4, 6]]),  # corners, then middles of edges
        shapes=random.normal(size=(9, 3, 4)),
        young=np.nan,
    )
    piston = body_of(ReducedPiston, skirt_lower=-0.02, skirt_upper=0.01)
    skin = _skin("piston", Reduced(piston, anatomy))
    assert skin.skirt == (-0.02, 0.01)
    assert skin.points[skin.triangles] == pytest.approx(anatomy.points[anatomy.skin[:, :3]])
    q = random.normal(size=4)
    whole = recover(anatomy, q).displacement[anatomy.skin[:, :3]]
    shown = (skin.modes @ q)[skin.triangles]
    assert shown == pytest.approx(whole, rel=1e-12)
    assert _skin("block", Reduced(body_of(ReducedBlock), anatomy)).skirt is None
