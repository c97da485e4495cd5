"""Rows of trees of named tuples, against trees of random numbers."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from piston_cosim.master.fmi.block import (
    alike,
    checker,
    flatten,
    given_part,
    is_head,
    length_of,
    memory_of,
    reader,
    room_of,
    row_of,
)
from piston_cosim.master.fmi.compiled import compiled
from piston_cosim.master.fmi.noted import ROOM


class Branch(NamedTuple):
    """Leaves of every kind."""

    count: int
    field: Annotated[NDArray[np.float64], "n, m + 1"]
    is_wet: bool
    full: Annotated[NDArray[np.bool_], "n"]


class Tree(NamedTuple):
    """Two branches beside numbers."""

    first: Branch
    length: float
    last: Branch
    stencil: Annotated[NDArray[np.float64], "2, n, m"]


@pytest.fixture(params=[True, False])
def ready(request):
    """Kernels as they are called inside others, and as Python calls them."""
    return (lambda kernel: compiled(kernel.py_func)) if request.param else lambda kernel: kernel


def branch(random, n, m):
    """Return a branch of random numbers."""
    return Branch(
        int(random.integers(100)),
        random.random((n, m + 1)),
        bool(random.integers(2)),
        random.random(n) > 0.5,
    )


def same(one, other):
    """Return whether two trees are of equal leaves."""
    if isinstance(one, tuple):
        return type(one) is type(other) and all(map(same, one, other))
    return np.array_equal(one, other)


def test_a_tree_comes_back_from_its_row(ready):
    put, get = map(ready, flatten(Tree))
    for n, m in ((3, 4), (1, 1)):
        random = np.random.default_rng(n)
        absent = branch(random, n, m)._replace(field=np.zeros((0, 0)))
        tree = Tree(branch(random, n, m), 0.3, absent, random.random((2, n, m)))
        row = np.full(room_of(Tree, "n, m")(n, m), np.nan)
        end = put(row, tree)
        assert np.array_equal(row[:end], row_of(tree))
        assert same(get(row), tree)
        # the absent array alone leaves room
        assert np.isnan(row).sum() == n * (m + 1)


def test_a_row_is_alike_where_its_lengths_are(ready):
    """Every length is compared and nothing else, by their positions in the 25 words."""
    random = np.random.default_rng(5)
    row = row_of(Tree(branch(random, 2, 1), 0.3, branch(random, 1, 1), random.random((2, 1, 1))))
    lengths = {1, 2, 8, 13, 14, 18, 20, 21, 22}
    is_alike = ready(alike(Tree))
    assert is_alike(row, row)
    for k in range(len(row)):
        for value in (row[k] + 1.0, -1.0, np.nan, 1e300):
            other = row.copy()
            other[k] = value
            assert is_alike(other, row) == (k not in lengths), k


class Table(NamedTuple):
    """Arrays that are kept by their bits."""

    single: Annotated[NDArray[np.float32], "n, m"]
    whole: Annotated[NDArray[np.int64], "n, m"]
    length: float


def test_bits_of_single_precision_and_whole_numbers_come_back(ready):
    get = ready(reader(Table))
    for n, m in ((3, 4), (3, 5)):
        random = np.random.default_rng(m)
        single = random.random((n, m)).astype(np.float32)
        table = Table(single, random.integers(-(2**62), 2**62, (n, m)), 0.3)
        found = get(row_of(table))
        assert [one.dtype for one in found[:2]] == [np.float32, np.int64]
        assert same(found, table)


# ---- rows from a file


class Inside(NamedTuple):
    """A tuple in another, which knows the lengths of that."""

    place: Annotated[int, "has_room(x, cells, reals)"]
    factor: float
    of_cells: Annotated[np.ndarray, "cells"]


class Setup(NamedTuple):
    """Lengths with names, positions, flags and numbers of every kind."""

    inside: Annotated[Inside, "x.factor > 0.0"]
    field: Annotated[NDArray[np.float64], "cells, n"]
    halves: Annotated[NDArray[np.float32], "2, cells"]
    order: Annotated[NDArray[np.int64], "cells", "within(x, -1.0, cells)"]
    is_wet: bool
    anything: Annotated[NDArray[np.float64], "2", "True"]


CELLS = 3
FACTOR, OF_CELLS, FIELD, HALVES, ORDER, IS_WET = 1, 3, 8, 16, 20, 23
"""Positions in the row of `Setup` where numbers begin."""
FREE = {*range(OF_CELLS, OF_CELLS + 3), *range(FIELD, FIELD + 6), *range(HALVES, HALVES + 3)}
"""Positions of numbers that may be any finite one."""


def setup_row():
    tree = Setup(
        Inside(7, 0.5, np.ones(CELLS)),
        np.ones((CELLS, 2)),
        np.ones((2, CELLS), np.float32),
        np.arange(CELLS) - 1,
        True,
        np.array([np.nan, np.inf]),
    )
    return row_of(tree)


def test_checker_accepts_the_row_and_rejects_what_is_out_of_range(ready):
    """Lengths, positions, whole numbers by their bits, and numbers that are not finite."""
    row, reals = setup_row(), 7 + CELLS
    check = ready(checker(Setup, "reals"))
    assert check(row, reals) == len(row) == IS_WET + 4
    assert check(row, reals - 1) == -1  # the cells of `place` end at 10
    for k in range(IS_WET + 1):
        for value in (4.0, -3.0, 0.25, np.nan, np.inf, 1e300):
            other = row.copy()
            other[k] = value
            fits = np.isfinite(value) and (k in FREE or (k == FACTOR and value > 0.0))
            fits = fits or (k == 0 and value == 4.0)
            assert (check(other, reals) == len(row)) == fits, (k, value)
    for end in range(len(row)):
        assert check(row[:end], reals) == -1


def test_lengths_of_kernels_are_those_of_rows():
    random = np.random.default_rng(1)
    tree = Tree(branch(random, 3, 4), 0.3, branch(random, 3, 4), random.random((2, 3, 4)))
    assert length_of(Tree)(tree) == room_of(Tree, "n, m")(3, 4) == len(row_of(tree))


def test_head_from_a_file_fits_its_lengths_only():
    """Parts given, state, other and faults; a saved state omits the last of its five numbers."""
    given = np.arange(6.0)
    memory = memory_of({"given": given}, {"state": 5, "other": 2, "faults": ROOM}, unsaved=1)

    def first_of(memory, parts, end=6):
        """Return the first part if its checker ends at a position."""
        return given_part(memory, parts, lambda row, reals, integers: end, 0, 0)

    assert np.array_equal(first_of(memory, 4.0), given)
    assert len(first_of(memory, 4.0, end=5)) == len(first_of(memory, 4.0, end=-1)) == 0
    lengths = 5, 2, int(ROOM)
    assert is_head(memory, lengths, 0.0, 1)
    assert not is_head(memory, (5, 3, ROOM), 0.0, 1) and not is_head(memory, lengths, 0.0, 0)
    assert not is_head(memory, (5, 2, ROOM - 1), 0.0, 1)
    assert len(first_of(memory, 3.0)) == len(first_of(memory[:-1], 4.0)) == 0
    for k in range(len(memory) - len(given)):
        other = memory.copy()
        other[k] += 1.0
        is_first = len(first_of(other, 4.0)) > 0
        assert not (is_first and is_head(other, lengths, 0.0, 1)), k
