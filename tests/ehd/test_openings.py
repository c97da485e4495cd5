"""Cells without a film."""

from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

import piston_cosim as pc
from piston_cosim.fmu_ehd.balance import openings
from piston_cosim.fmu_ehd.balance.openings import limit_supply
from piston_cosim.fmu_ehd.balance.reynolds import Faces
from piston_cosim.fmu_ehd.common.grid import Cells


def nearest(open_cells, dx, dy):
    return openings.nearest(open_cells, Cells(dx, dy, ring=True, mirrored=False))


def test_the_nearest_film_is_that_of_an_exact_distance_transform():
    """Also the same one of several at one distance, on square cells and on others."""
    rng = np.random.default_rng(0)
    sizes = (1e-3, 0.7e-3, 0.5e-3, 3.3e-3)
    for k in range(200):
        shape = n_c, n_a = rng.integers(4, 14, 2)
        open_cells = rng.random(shape) < rng.choice([0.1, 0.4, 0.7, 0.95])
        open_cells[rng.integers(n_c), rng.integers(n_a)] = False
        size = rng.choice(sizes, 2) if k % 2 else rng.uniform(1e-4, 1e-2, 2)
        turns = np.concatenate([open_cells] * 3)
        i, j = distance_transform_edt(turns, size, return_distances=False, return_indices=True)
        middle = slice(n_c, 2 * n_c)
        assert np.array_equal(nearest(open_cells, *size), i[middle] % n_c * n_a + j[middle])


def test_of_two_films_at_one_distance_the_lower_and_the_one_before_are_taken():
    """Of two films at one distance the lower one and the one before are taken.

    By hand: an opening in the middle of four, next to a wide cell, and across the first row.
    """
    open_cells = np.zeros((4, 3), dtype=bool)
    open_cells[1, 1] = True
    assert nearest(open_cells, 1.0, 1.0)[1, 1] == 3 * 1 + 0
    assert nearest(open_cells, 1.0, 2.0)[1, 1] == 3 * 0 + 1
    open_cells[:, 0] = [True, True, False, True]
    assert nearest(open_cells, 1.0, 9.0)[0, 0] == 3 * 2 + 0  # two cells away, by the row before
    assert nearest(open_cells, 1.0, 0.1)[0, 0] == 3 * 0 + 1


@pytest.mark.parametrize(
    "options",
    [
        dict(pressure_viscosity_law="roelands_1966", coating_thickness=1.4e-5, roughness_rms=3e-7),
        dict(oil_supply="bore", initial_oil_layer=3e-6, stroke=0.1),
        dict(surface="bearing", film_fraction_lower_edge=0.7, initial_film_fraction=0.4),
    ],
    ids=["coated", "oil on the bore", "bearing"],
)
def test_no_film_depends_on_what_openings_show(options):
    """Openings show the nearest cell with a film, or any other one: the film has the same bits.

    One opening is one cell from the edge.
    """
    cells = np.zeros((8, 9), dtype=bool)
    cells[2:4, 7] = cells[5, 2:5] = True
    answers = []
    for seed in range(3):
        film = pc.Film(cells.shape, open_cells=cells, **options)
        if seed > 0:
            other = np.random.default_rng(seed).choice(np.flatnonzero(~cells), cells.sum())
            film.model._tables.nearest_cell[cells] = other
        rng = np.random.default_rng(0)
        turning = dict(circumferential_velocity=4.0) if film.model._bearing else {}
        outputs: dict[str, Any] = {}
        for n in range(12):
            thickness = 5e-6 * (1.0 + 0.2 * rng.random(cells.shape))
            moved = dict(sliding_velocity=9.0 + rng.random(cells.shape), **turning)
            kelvin = rng.uniform(350.0, 360.0, cells.shape)
            call = partial(film.step, step=1e-4) if n else film.start
            outputs = call(thickness, oil_temperature=kelvin, **moved)
        direction = 1e-7 * rng.standard_normal(cells.shape)
        changes = film.tangent(direction, dsliding_velocity=rng.random(cells.shape))
        fields = [x for x in outputs.values() if np.ndim(x) == 2]
        scalars = [x for x in outputs.values() if np.ndim(x) == 0]
        answers.append([x[~cells] for x in (*fields, *changes)] + scalars)
    for answer in answers[1:]:
        assert all(np.array_equal(a, b) for a, b in zip(answers[0], answer))


def test_where_there_is_no_film_at_all_each_cell_is_its_own():
    assert np.array_equal(nearest(np.ones((4, 5), dtype=bool), 1.0, 1.0).ravel(), range(20))


def test_what_sliding_drags_in_from_an_opening_is_bounded_both_ways():
    """Of 3 and 5 m3/s out of the middle cell, 2 and 4 are there; what flows into it is free."""
    middle = np.array([[False, True, False]])
    limit = np.array([[0.0, 2.0, 4.0, 0.0]])
    nothing = np.zeros((2, 3))
    for dragged, passed in ([-3.0, 5.0], [-2.0, 4.0]), ([9.0, -9.0], [9.0, -9.0]):
        faces = Faces(nothing, nothing, np.zeros((1, 4)), np.array([[7.0, *dragged, 7.0]]))
        bounded = limit_supply(middle, faces, limit)
        assert faces.transport_a.tolist() == [[7.0, *passed, 7.0]]
        assert bounded.tolist() == [[False, *(dragged != passed,) * 2, False]]
