"""Rows of trees of named tuples, against trees of random numbers."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from piston_cosim.master.fmi.block import alike, flatten, reader, room, row_of
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


@pytest.mark.parametrize("is_compiled", [True, False])
@pytest.mark.parametrize("n, m", [(3, 4), (1, 1)])
def test_a_tree_comes_back_from_its_row(n, m, is_compiled):
    random = np.random.default_rng(n)
    absent = branch(random, n, m)._replace(field=np.zeros((0, 0)))
    tree = Tree(branch(random, n, m), 0.3, absent, random.random((2, n, m)))
    put, get = flatten(Tree)
    if is_compiled:
        put, get = compiled(put.py_func), compiled(get.py_func)
    length = room(Tree, n=n, m=m)
    row = np.full(length, np.nan)
    end = put(row, tree)
    assert np.array_equal(row[:end], row_of(tree))
    assert same(get(row), tree)
    # the absent array alone leaves room
    assert np.isnan(row).sum() == n * (m + 1)


@pytest.mark.parametrize("is_compiled", [True, False])
def test_a_row_is_alike_where_its_lengths_are(is_compiled):
    """Every length is compared and nothing else, by their positions in the 25 words."""
    random = np.random.default_rng(5)
    row = row_of(Tree(branch(random, 2, 1), 0.3, branch(random, 1, 1), random.random((2, 1, 1))))
    lengths = {1, 2, 8, 13, 14, 18, 20, 21, 22}
    is_alike = compiled(alike(Tree).py_func) if is_compiled else alike(Tree)
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


@pytest.mark.parametrize("is_compiled", [True, False])
@pytest.mark.parametrize("n, m", [(3, 4), (3, 5)])
def test_bits_of_single_precision_and_whole_numbers_come_back(n, m, is_compiled):
    random = np.random.default_rng(m)
    single = random.random((n, m)).astype(np.float32)
    table = Table(single, random.integers(-(2**62), 2**62, (n, m)), 0.3)
    get = reader(Table)
    if is_compiled:
        get = compiled(get.py_func)
    found = get(row_of(table))
    assert [one.dtype for one in found[:2]] == [np.float32, np.int64]
    assert same(found, table)
