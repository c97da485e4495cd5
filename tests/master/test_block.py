"""Rows of trees of named tuples, against trees of random numbers."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from piston_cosim.master.fmi.block import (
    alike,
    flatten,
    length_of,
    memory_of,
    reader,
    room_of,
    row_of,
)
from piston_cosim.master.fmi.compiled import compiled


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


def test_lengths_of_kernels_are_those_of_rows():
    random = np.random.default_rng(1)
    tree = Tree(branch(random, 3, 4), 0.3, branch(random, 3, 4), random.random((2, 3, 4)))
    assert length_of(Tree)(tree) == room_of(Tree, "n, m")(3, 4) == len(row_of(tree))


def test_the_head_of_a_memory():
    """Parts given, state, other and faults; a saved state omits the last of its five numbers."""
    given = np.arange(6.0)
    memory = memory_of({"given": given}, {"state": 5, "other": 2, "faults": 7}, unsaved=1)
    first = 9  # length of the head: four numbers, begins of the parts, and end
    parts = first, first + 6, first + 11, first + 13, first + 20
    assert np.array_equal(memory, [first + 20, first + 6, 5 - 1, first + 13, *parts, *given])
