"""Modes from a smooth prior of the pressure: hand values, nested bases, modes by their error."""

import numpy as np
import pytest
import scipy.sparse as sp

from piston_cosim.fmu_mfbd.body_options import Piston
from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.reduction.bases import Elastic, of_unit_energy
from piston_cosim.fmu_mfbd.reduction.interpolation import SurfaceReading
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedBlock, ReducedPiston, load
from piston_cosim.fmu_mfbd.reduction.smooth_prior import (
    AROUND,
    NEGLIGIBLE_VARIANCE,
    SurfaceAnswers,
    edge_patches,
    expected_missing,
    expected_patterns,
    pressure_root,
    smooth_pressure_modes,
    surface_answers,
)
from piston_cosim.master.fmi.errors import BadInput

from .conftest import clamped_box

ANGLE = np.radians(np.arange(0.0, 360.0, 30.0))
HEIGHT = np.linspace(-9e-3, 9e-3, 5)
EVERYWHERE = np.ones(60, dtype=bool)


def test_the_root_has_the_covariance_of_the_equation():
    """Every entry of Eq. (J31) is computed by hand, also over the cut at 0 deg.

    The tolerance is that of the dropped patterns: 60 of them have less than 60
    `NEGLIGIBLE_VARIANCE` of the largest variance.
    """
    there = np.arange(60) != 7
    root = pressure_root(ANGLE, HEIGHT, 0.2, there)
    length = 0.2 * 22.5e-3  # five cells of 4.5 mm
    expected = np.empty((60, 60))
    for i, j in np.ndindex(60, 60):
        apart = abs(ANGLE[i // 5] - ANGLE[j // 5])
        apart = min(apart, 2 * np.pi - apart)
        far = HEIGHT[i % 5] - HEIGHT[j % 5]
        expected[i, j] = np.exp(-((apart / AROUND) ** 2) / 2 - (far / length) ** 2 / 2)
    # 1 % more on the thrust lines, 90 and 270 deg; three times 10 deg off them 0.011 %
    weight = np.ones(12)
    weight[[3, 9]] = 1.01
    weight[[2, 4, 8, 10]] += 0.01 * np.exp(-4.5)
    weight = np.repeat(weight, 5) * there
    expected *= weight[:, None] * weight
    largest = np.linalg.norm(expected, 2)
    np.testing.assert_allclose(root @ root.T, expected, atol=60 * NEGLIGIBLE_VARIANCE * largest)
    strength = (pressure_root(ANGLE, HEIGHT, 0.2, EVERYWHERE) ** 2).sum(axis=0)
    assert np.all(strength[1:] <= 1.01**2 * strength[:-1])  # strongest first, but for the 1 %


@pytest.mark.parametrize("parity, pairs", [(1, 7), (-1, 5)])
def test_even_and_odd_films_have_their_part_of_the_prior(parity, pairs):
    """Eq. (J36): patterns are their own mirror images about the thrust plane, up to the sign.

    Their covariance is that of (p +- M p) / 2, here for all patterns without the condition. Of 12
    angles, 2 are their own images.
    """
    image = (6 - np.arange(12)) % 12  # 180 deg - theta
    mirror = np.kron(np.eye(12)[image], np.eye(5))
    free = pressure_root(ANGLE, HEIGHT, 0.2, EVERYWHERE)
    root = pressure_root(ANGLE, HEIGHT, 0.2, EVERYWHERE, parity)
    largest = np.linalg.norm(free, 2) ** 2
    np.testing.assert_allclose(mirror @ root, parity * root, atol=1e-12)
    half = (free + parity * mirror @ free) / 2
    np.testing.assert_allclose(
        root @ root.T, half @ half.T, atol=60 * NEGLIGIBLE_VARIANCE * largest
    )
    assert root.shape[1] == 5 * pairs


def test_edge_patches_are_at_the_outermost_cells_with_a_film():
    """Eq. (J46) by hand: 25/4 deg around, and a quarter of 0.2 of 22.5 mm along.

    Cells of 30 deg and 4.5 mm are 4.8 and 4 of these widths apart.
    """
    there = np.ones((12, 5), dtype=bool)
    there[3, :2] = False  # the film on the thrust line begins at the third row
    there[9] = False  # and there is none on the anti-thrust line
    lower, upper = edge_patches(ANGLE, HEIGHT, 0.2, there.ravel(), symmetric=False)
    assert lower.shape == upper.shape == (60, 11)
    columns = np.delete(np.arange(12), 9)
    rows = np.where(columns == 3, 2, 0)
    np.testing.assert_array_equal(lower.argmax(axis=0), 5 * columns + rows)
    np.testing.assert_array_equal(upper.argmax(axis=0), 5 * columns + 4)
    patch = lower[:, 3].reshape(12, 5)
    assert patch[3, 2] == 1.0
    assert patch[3, 3] == pytest.approx(np.exp(-(4.0**2) / 2))
    assert patch[2, 2] == pytest.approx(np.exp(-(4.8**2) / 2))
    assert not patch[3, :2].any()
    both, _ = edge_patches(ANGLE, HEIGHT, 0.2, there.ravel(), symmetric=True)
    assert both[5 * 1, 1] == both[5 * 5, 1] == 1.0  # 30 deg and 150 deg


def springs(points, stiffness):
    """Return a body of one spring per point."""
    diagonal = sp.identity(points, format="csr")
    body = Elastic(stiffness * diagonal, diagonal, np.empty(0, dtype=int))
    return body, SurfaceReading(diagonal, 0.0 * diagonal)


def test_equal_springs_yield_to_the_patterns_of_the_prior():
    """With G = 1/k the patterns are the singular vectors of S.

    A patch S S^T e_j misses its part in the other patterns.
    """
    body, reading = springs(60, 3.0)
    root = pressure_root(ANGLE, HEIGHT, 0.2, EVERYWHERE)
    answers = surface_answers(body, reading, root)
    np.testing.assert_allclose(answers.radial, root / 3.0, rtol=1e-14)
    nothing = np.empty((60, 0))
    found = expected_missing(answers, nothing, expected_patterns(answers, nothing))
    whole = np.linalg.norm(root @ root.T, axis=0)
    u, size, _ = np.linalg.svd(root, full_matrices=False)
    for k in (0, 1, 10):
        tail = np.linalg.norm(u[:, k:] * size[k:] ** 2 @ u[:, k:].T, axis=0)
        assert found[k] == pytest.approx((tail / whole).max(), rel=1e-9)
    assert found[-1] == 0.0
    assert np.all(np.diff(found) <= 0.0)


@pytest.fixture(scope="module")
def plate():
    """Return a clamped plate whose degrees of freedom represent the points of a surface."""
    _, body = clamped_box((3, 5, 2), (0.03, 0.05, 0.02))
    size = len(body.free)
    chosen = np.random.default_rng(3).permutation(size)[:60]
    radial = sp.csr_matrix((np.ones(60), (np.arange(60), chosen)), (60, size))
    root = pressure_root(ANGLE, HEIGHT, 0.2, EVERYWHERE)
    return body, radial, surface_answers(body, SurfaceReading(radial, 0.0 * radial), root)


def test_a_larger_basis_holds_every_smaller_one(plate):
    """Each shape, its sign apart, is that of the smaller basis, and free of the given ones."""
    body, radial, answers = plate
    first = body.solve(np.random.default_rng(5).normal(size=(len(body.free), 2)))
    small, large = (smooth_pressure_modes(body, radial, answers, k, first) for k in (8, 20))
    assert small.shape[1] == 8 and large.shape[1] == 20
    np.testing.assert_array_equal(small[:, :6], large[:, :6])
    psi = of_unit_energy(body, first)
    stiff = np.sqrt(np.einsum("ik,ik->k", small[:, :6], body.K @ small[:, :6]))
    assert np.abs(psi.T @ (body.K @ small[:, :6]) / stiff).max() <= 1e-8


def test_shapes_leave_the_least_energy_of_the_prior(plate):
    """Against any other eight patterns: what k shapes take is the sum of the k largest mu."""
    body, radial, answers = plate
    shapes = smooth_pressure_modes(body, radial, answers, 8, np.empty((len(body.free), 0)))
    psi = of_unit_energy(body, shapes)
    taken = ((psi.T @ (radial.T @ answers.root)) ** 2).sum()
    energy = answers.root.T @ answers.radial
    assert taken == pytest.approx(np.linalg.eigvalsh(energy)[-8:].sum(), rel=1e-9)


def test_modes_are_added_until_the_expected_error_is_reached(plate):
    body, radial, answers = plate
    none = np.empty((len(body.free), 0))
    nothing = np.empty((60, 0))
    missing = expected_missing(answers, nothing, expected_patterns(answers, nothing))
    for error in (0.2, 0.02):
        count = smooth_pressure_modes(body, radial, answers, error, none).shape[1]
        assert missing[count] <= error < missing[count - 1]


def test_an_error_that_needs_too_many_modes_is_named():
    body, reading = springs(300, 1.0)
    many = SurfaceAnswers(np.eye(300), np.eye(300), np.zeros((300, 300)), np.eye(300))
    with pytest.raises(ValueError, match="modes: expected an error that 200 modes"):
        smooth_pressure_modes(body, reading.radial, many, 0.01, np.empty((300, 0)))


SHEET = {"mesh": "a.msh", "density": "2700 kg/m^3", "young": "70 GPa", "poisson": 0.3}


@pytest.mark.parametrize("given, read", [(60, 60), ("60", 60), ("1 %", 0.01), (0.02, 0.02)])
def test_a_number_or_an_error(given, read):
    modes = Piston(**SHEET, modes=given).modes
    assert modes == read and type(modes) is type(read)
    # as it is written into a cache key or an FMU
    assert Piston(**SHEET, modes=modes).model_dump(mode="json")["modes"] == read


@pytest.mark.parametrize(
    "change, said",
    [
        ({"modes": 300}, "modes: expected a number of modes from 0 to"),
        ({"modes": "60 %"}, "modes: expected a number of modes from 0 to"),
        ({"modes": "1 mm"}, "got '1 mm'"),
        ({"modes": True}, "got 'true'"),
        ({"modes": "1 %", "basis": "craig_bampton"}, "modes: expected a number of modes with"),
        ({"basis": "trained"}, "train_on: expected it with basis ="),
        ({"train_on": "run.h5"}, "train_on: expected it with basis ="),
        ({"basis": "trained", "train_on": "none.h5"}, "train_on: expected a file"),
    ],
)
def test_other_modes_and_bases_are_rejected(coarse, change, said):
    folder, options = coarse
    with pytest.raises(BadInput, match=said):
        reduced_bodies(options | {"piston": options["piston"] | change}, folder, print)


def test_bodies_by_their_error(coarse, kept):
    """Each body has its own number of modes, and a smaller error has more."""
    folder, options = coarse
    counts = []
    for error in ("20 %", "5 %"):
        changed = options | {n: options[n] | {"modes": error} for n in ("piston", "block")}
        files = reduced_bodies(changed, folder, lambda text: None)
        kinds = {"piston": ReducedPiston, "block": ReducedBlock}
        counts.append([len(load(kind, files[name]).omega) for name, kind in kinds.items()])
    assert np.all(np.diff(counts, axis=0) > 0)
