"""Kernels that borrow their arguments keep and free arrays as numba's own do.

The tuples here are passed by reference like those of the package.
"""

import gc
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit, typeof

from piston_cosim.master.fmi import references
from piston_cosim.master.fmi.compiled import compiled

nrt: Any = import_module("numba.core.runtime._nrt_python")
runtime: Any = import_module("numba.core.runtime.nrt").rtsys


class Pair(NamedTuple):
    """Two arrays that a kernel may exchange."""

    a: np.ndarray
    b: np.ndarray


class Tree(NamedTuple):
    """Tree of arrays, as models give to their kernels."""

    pair: Pair
    row: np.ndarray
    parts: tuple[np.ndarray, np.ndarray]


@pytest.fixture(autouse=True, scope="module")
def by_reference():
    """Count the tuples of this file among those of the package."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(references, "ROOT", __name__.partition(".")[0])
        yield


@compiled
def callee(tree):
    """Return an array of a tuple inside the argument."""
    return tree.parts[-1]


@compiled
def exchanged(tree, count):
    """Exchange two lent arrays `count` times, then replace one by an array of its own."""
    a, b = tree.pair
    for _ in range(count):
        a, b = b, a
    kept = b
    if count > 2:
        b = tree.row + callee(tree)
    part = Pair(tree.row + 1.0, a).a  # outlives its tuple
    filling = tree.row * 7.0  # would take the place of an array that was freed too early
    pair = Pair(a, b)
    return pair, kept, Tree(pair, tree.pair.a, (part, filling))


@njit
def full(value):
    """Return an array that numba has allocated, so that it counts it."""
    return np.full(3, value)


def arguments():
    """Return a tree of such arrays."""
    one, two, row, left, right = (full(float(k)) for k in range(5))
    return Tree(Pair(one, two), row, (left, right))


@pytest.fixture
def counted():
    """Count numba's allocations."""
    nrt.memsys_enable_stats()
    yield
    nrt.memsys_disable_stats()


@pytest.mark.usefixtures("counted")
@pytest.mark.parametrize("count", [0, 1, 2, 3, 4])
def test_arrays_live_as_long_as_they_are_used_and_no_longer(count):
    """Values are those of Python, with and without the arguments, and at last all is free."""
    exchanged(arguments(), count)
    gc.collect()
    before = runtime.get_allocation_stats()
    for _ in range(3):
        tree = arguments()
        expected = exchanged.py_func(tree, count)
        given = exchanged(tree, count)
        del tree
        gc.collect()
        arguments()  # would take the place of an array that was freed too early
        flat = [*given[0], given[1], *given[2].pair, given[2].row, *given[2].parts]
        wanted = [*expected[0], expected[1], *expected[2].pair, expected[2].row, *expected[2].parts]
        assert np.array_equal(flat, wanted)
    del given, expected, flat, wanted
    gc.collect()
    after = runtime.get_allocation_stats()
    assert after.alloc - before.alloc == after.free - before.free > 0


def test_only_large_tuples_are_passed_by_reference():
    """An array is seven numbers; numba passes each of a small tuple as an argument of its own."""
    tree = arguments()
    large, small = (references.registry.default_manager[typeof(one)] for one in (tree, tree.pair))
    assert large.get_argument_type().is_pointer
    assert len(small.get_argument_type()) == 2


class Mixed(NamedTuple):
    """Tuple of numbers of all kinds, in memory as a kernel has them."""

    row: np.ndarray
    is_first: bool
    count: int
    share: float
    tree: Tree


@compiled
def changed(mixed, turns):
    """Return a tuple that each turn makes from the one before."""
    for k in range(turns):
        mixed = Mixed(mixed.row + k, not mixed.is_first, mixed.count + 1, sum_of(mixed), mixed.tree)
    return mixed


@compiled
def sum_of(mixed):
    """Return a sum over all parts."""
    row, is_first, count, share, tree = mixed
    return row[0] + (0.5 if is_first else 0.25) + count + share + callee(tree)[1]


@pytest.mark.parametrize("turns", [0, 1, 3])
def test_a_tuple_that_changes_in_a_loop_is_passed_as_it_is_then(turns):
    mixed = Mixed(np.arange(3.0), True, 7, 0.125, arguments())
    ours, wanted = changed(mixed, turns), changed.py_func(mixed, turns)
    assert np.array_equal(ours.row, wanted.row)
    assert ours[1:4] == wanted[1:4]
    assert sum_of(ours) == sum_of.py_func(wanted)
