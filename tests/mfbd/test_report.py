"""Table of modes, files of mode shapes, recovered displacement and stress."""

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.finite_elements.element import (
    corner_stress,
    von_mises,
)
from piston_cosim.fmu_mfbd.reduction.mode_tables import (
    mode_table,
    recover,
)
from piston_cosim.fmu_mfbd.reduction.reduce import Reduced
from piston_cosim.fmu_mfbd.reduction.reduced_body import (
    Anatomy,
    MeshProperties,
    ReducedBlock,
    ReducedPiston,
    load,
)

from .conftest import quiet


@pytest.fixture(scope="module")
def report(coarse, kept):
    files = reduced_bodies(coarse[1], coarse[0], quiet)
    return {
        name: Reduced(*(load(part, files[name]) for part in (kind, Anatomy, MeshProperties)))
        for name, kind in (("piston", ReducedPiston), ("block", ReducedBlock))
    }


def test_table_of_modes(report):
    for body, _, properties, *_ in report.values():
        rows = mode_table(body, properties.angles)
        assert [row.number for row in rows] == list(range(1, len(body.omega) + 1))
        assert np.all(np.diff([row.frequency for row in rows]) >= 0)
        assert sum(row.film_share for row in rows) == pytest.approx(1.0)
        assert all(0 < row.modal_mass < 10 for row in rows)


def test_stress_is_the_mean_at_corners_and_its_largest_value_is_found(report):
    """Nodal stress is the mean of the adjacent elements, and the peak is the largest value.

    A corner has the mean of all elements that meet there, the middle of an edge the mean of its
    ends. The largest equivalent stress is at a corner. Its jump is the range of the elements there.
    """
    anatomy = report["block"].anatomy
    q = np.zeros(anatomy.shapes.shape[2])
    q[1] = 1e-6
    displacement, stress, peak = recover(anatomy, q)
    assert peak.value == von_mises(stress).max()
    node = int(np.argmax(von_mises(stress)))
    np.testing.assert_array_equal(peak.position, anatomy.points[node])
    own = [
        corner_stress(
            anatomy.points[tet],
            np.arange(10)[None],
            displacement[tet],
            anatomy.young,
            anatomy.poisson,
        )[0, tet[:4] == node][0]
        for tet in anatomy.tets[(anatomy.tets == node).any(axis=1)]
    ]
    np.testing.assert_allclose(np.mean(own, axis=0), stress[node], rtol=1e-9)
    assert peak.jump == pytest.approx(np.ptp(von_mises(np.array(own))), rel=1e-9)
    first = anatomy.tets[0]
    np.testing.assert_allclose(stress[first[4]], stress[first[:2]].mean(axis=0), rtol=1e-12)
