"""Bases trained on the film forces of a run: closed values, order, reproducibility."""

import numpy as np
import pytest
import scipy.sparse as sp

from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.reduction.bases import of_unit_energy, pressure_modes
from piston_cosim.fmu_mfbd.reduction.film_loads import FilmLoads
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedBlock, ReducedPiston, load
from piston_cosim.fmu_mfbd.reduction.training import (
    REMAINING_DEFLECTION,
    load_patterns,
    trained_shapes,
)
from piston_cosim.fmu_mfbd.truncations import truncations
from piston_cosim.master.fmi.errors import BadInput

from .conftest import clamped_box, quiet
from .test_truncation import GRID, film_forces, results

AROUND, ALONG = 8, 3


@pytest.fixture(scope="module")
def plate():
    """Return a clamped plate and forces at 24 of its degrees of freedom, pressure and friction."""
    _, body = clamped_box((3, 4, 2), (0.03, 0.05, 0.02))
    points = AROUND * ALONG
    chosen = np.random.default_rng(3).permutation(len(body.free))[: 2 * points]
    spread = sp.csr_matrix(
        (np.ones(2 * points), (chosen, np.arange(2 * points))), (len(body.free), 2 * points)
    )
    return body, spread


def random_film(patterns, instants=30, seed=0):
    """Return forces at many instants, in the span of a few patterns of falling strength."""
    random = np.random.default_rng(seed)
    weight = random.normal(size=(2, instants, patterns)) * 10.0 ** -np.arange(patterns)
    shape = random.normal(size=(2, patterns, AROUND * ALONG))
    return FilmLoads(*(weight @ shape).reshape(2, instants, AROUND, ALONG))


def answers(body, spread, film):
    """Return loads and deflections at all instants, (free, m) each."""
    both = np.hstack([force.reshape(len(force), -1) for force in film])
    loads = spread @ both.T
    return loads, body.solve(loads)


def none(body):
    return np.empty((body.K.shape[0], 0))


def test_all_loads_of_the_training_are_answered_to_round_off(plate, monkeypatch):
    """With all 16 shapes the error of every training load is the 1e-12 of solving.

    Four mirror images of two patterns of each of two fields span these shapes.
    """
    body, spread = plate
    film = random_film(2)
    monkeypatch.setattr("piston_cosim.fmu_mfbd.reduction.training.REMAINING_DEFLECTION", 1e-9)
    phi = trained_shapes(body, spread, film, none(body), 40)
    assert phi.shape[1] <= 16
    loads, whole = answers(body, spread, film)
    assert np.abs(phi @ (phi.T @ loads) - whole).max() <= 1e-8 * np.abs(whole).max()
    np.testing.assert_allclose(phi.T @ (body.K @ phi), np.eye(phi.shape[1]), atol=1e-9)


def test_shapes_come_in_the_order_of_what_they_take(plate):
    """Each shape leaves less energy than any other direction would.

    The remainder falls, and each shape takes at most as much as the previous one. The series stops
    if `REMAINING_DEFLECTION` of the total is left.
    """
    body, spread = plate
    film = random_film(6)
    phi = trained_shapes(body, spread, film, none(body), 40)
    images = [answers(body, spread, FilmLoads(*one)) for one in mirrored(film)]
    loads = np.hstack([load for load, _ in images])
    whole = sum(np.sum(load * answer) for load, answer in images)
    taken = np.sum((phi.T @ loads) ** 2, axis=1) / whole
    assert np.all(np.diff(taken) <= 1e-12)
    left = 1 - np.cumsum(taken)
    # patterns below 1e-4 of the strongest are not solved for: 1e-8 of the energy
    assert left[-1] <= REMAINING_DEFLECTION**2 + 1e-7
    assert left[-2] > REMAINING_DEFLECTION**2
    fewer = trained_shapes(body, spread, film, none(body), 3)
    np.testing.assert_array_equal(fewer, phi[:, :3])


def mirrored(film):
    """Yield the four mirror images of film forces, by their angles pi/2 + (i - 2) pi/4."""
    index = np.arange(AROUND)
    across_z = (4 - index) % AROUND
    across_x = (-index) % AROUND
    both = (index + 4) % AROUND
    for image in (index, across_z, across_x, both):
        yield [force[:, image] for force in film]


def test_given_shapes_are_left_to_themselves(plate):
    """Trained shapes, then compliance patterns, are free of what is there already."""
    body, spread = plate
    psi = of_unit_energy(
        body, body.solve(np.random.default_rng(5).normal(size=(len(body.free), 2)))
    )
    phi = trained_shapes(body, spread, random_film(3), psi, 4)
    both = np.hstack([phi, psi])
    np.testing.assert_allclose(both.T @ (body.K @ both), np.eye(6), atol=1e-9)
    points = AROUND * ALONG
    radial = spread.T.tocsr()[:points]
    shapes = pressure_modes(body, radial, np.ones(points), 9, both, both)
    added = shapes[:, :3]
    stiff = np.sqrt(np.einsum("ik,ik->k", added, body.K @ added))
    assert np.abs(both.T @ (body.K @ added) / stiff).max() <= 1e-8
    np.testing.assert_array_equal(shapes[:, 3:], both)


def trained(options, path):
    table = {"basis": "trained", "train_on": str(path)}
    return options | {name: options[name] | table for name in ("piston", "block")}


@pytest.fixture
def run(kept, tmp_path):
    return results(tmp_path / "run.h5", {}, film_forces(GRID))


def test_a_run_adds_its_shapes_to_those_of_the_prior(coarse, run):
    """Training on four instants and their mirror images adds at most 16 shapes.

    It leaves `REMAINING_DEFLECTION` by energy on purpose, which can be three times as much by
    deflection. Under other loads than those of the training, the error is at most that of the
    prior's shapes alone.
    """
    folder, options = coarse
    before = truncations(options, folder, run).bodies
    after = truncations(trained(options, run), folder, run).bodies
    other = results(run.parent / "beside.h5", {}, beside_the_pin())
    untrained = truncations(options, folder, other).bodies
    for body, kind in (("piston", ReducedPiston), ("block", ReducedBlock)):
        assert before[body].error > 0.01
        assert after[body].error < 3 * REMAINING_DEFLECTION
        own, prior = (
            load(kind, reduced_bodies(one, folder, quiet)[body])
            for one in (trained(options, run), options)
        )
        assert 0 < len(own.omega) - len(prior.omega) <= 16
        both = truncations(trained(options, run), folder, other).bodies[body].error
        assert both <= untrained[body].error


def beside_the_pin():
    """Pressure that no instant of the training has."""
    angle, _ = cell_centres(*GRID, 0.0, 1.0)
    around = np.exp(-((np.remainder(angle, 2 * np.pi) / 0.3) ** 2))
    along = np.exp(-(((np.arange(GRID[1]) - 4) / 2.0) ** 2))
    pressure = np.tile(np.multiply.outer(around, along), (4, 1, 1))
    return FilmLoads(pressure, 0.0 * pressure)


def test_a_cache_knows_the_forces_and_not_the_file(coarse, run, tmp_path):
    """The same forces in another file: the same body. Others: another one."""
    folder, options = coarse
    first = reduced_bodies(trained(options, run), folder, quiet)
    again = results(tmp_path / "again.h5", {"title": "other"}, film_forces(GRID))
    assert reduced_bodies(trained(options, again), folder, quiet) == first
    other = results(tmp_path / "other.h5", {}, film_forces(GRID, seed=1))
    others = reduced_bodies(trained(options, other), folder, quiet)
    assert others["piston"] != first["piston"] and others["block"] != first["block"]
    assert reduced_bodies(options, folder, quiet)["piston"] != first["piston"]
    # the same bytes when it is made again
    first["piston"].rename(tmp_path / "kept.npz")
    (anew,) = reduced_bodies(
        {"grid": list(GRID), "piston": trained(options, run)["piston"]}, folder, quiet
    ).values()
    one, two = load(ReducedPiston, anew), load(ReducedPiston, tmp_path / "kept.npz")
    np.testing.assert_array_equal(one.radial, two.radial)


def test_what_a_run_cannot_train_is_refused(coarse, run, tmp_path):
    folder, options = coarse
    table = trained(options, run)
    with pytest.raises(BadInput, match="train_on: expected a piston with the block,"):
        reduced_bodies({"grid": list(GRID), "block": table["block"]}, folder, quiet)
    with pytest.raises(BadInput, match=r"the film grid is \(20, 12\)"):
        reduced_bodies(table | {"grid": [20, 12]}, folder, quiet)
    still = FilmLoads(np.zeros((3, *GRID)), np.zeros((3, *GRID)))
    nothing = trained(options, results(tmp_path / "still.h5", {}, still))
    with pytest.raises(BadInput, match="train_on: expected a run whose film loads"):
        reduced_bodies(nothing, folder, quiet)


def test_load_patterns_are_orthonormal_and_weighed():
    found = load_patterns(random_film(4))
    np.testing.assert_allclose(
        found.pattern @ found.pattern.T, np.eye(len(found.strength)), atol=1e-12
    )
    assert np.all(np.diff(found.strength) <= 0)
    assert found.strength[-1] > 1e-4 * found.strength[0]
    one = FilmLoads(np.ones((5, AROUND, ALONG)), np.zeros((5, AROUND, ALONG)))
    (strength,) = load_patterns(one).strength
    assert strength == pytest.approx(np.sqrt(5 * AROUND * ALONG), rel=1e-12)
