"""What a communication step of the coupled FMU without Python overwrites is taken back; its loops
run as written.
"""

import numpy as np
import pytest

from piston_cosim.master.coupling import native_block, native_newton, native_stepping
from piston_cosim.master.coupling.native_block import (
    ParticipantRow,
    Rules,
    WireRow,
    given_of,
    lay_out,
    nothing_yet,
    parts_of,
    state_of,
)
from piston_cosim.master.fmi.block import row_of
from piston_cosim.master.fmi.compiled import Kernel

N = 4
"""Unknowns, and pairs."""


@pytest.fixture(autouse=True)
def interpreted(monkeypatch):
    """Kernels as written, not compiled."""
    for module in (native_block, native_newton, native_stepping):
        for kernel in vars(module).values():
            if isinstance(kernel, Kernel):
                monkeypatch.setitem(kernel.__dict__, "dispatcher", kernel.py_func)


@pytest.fixture
def memory():
    """Of one participant, its state any numbers; the third of four pairs is forgotten next."""
    rules = Rules(*np.zeros(3), 2, 0, 20, 5, 0.01, 1e-6, 1)
    wire = WireRow(
        0, 0, 0, 0, 0, 0, elements=N, unknown=0, nominal=1, tolerance=1, largest_decrease=-1
    )
    head = lay_out(rules, [ParticipantRow(0, reals=9, variables=5)], [wire], [0])
    whole = np.full(int(head[0]), np.nan)
    whole[: len(head)] = head
    state, _ = nothing_yet(given_of(whole))
    rng = np.random.default_rng(1)
    for row in (parts_of(whole).state, parts_of(whole).before):
        row[:] = row_of(state)
        for array in arrays(state_of(whole)):
            array[...] = rng.standard_normal(array.shape)
    state_of(whole).pairs.oldest[0] = 2.0
    return whole


def arrays(state):
    """All that changes."""
    return (*state[:-1], *state.pairs)


def learn(memory, rows, value):
    """As GMRES: so many of the oldest pairs are other ones, and all else moves."""
    native_newton.overwrite(memory, rows)
    state = state_of(memory)
    first = int(state.pairs.oldest[0])
    for k in range(rows):
        state.pairs.images[(first + k) % N] = value
        state.pairs.differences[(first + k) % N] = value + 1.0
    for array in (*state[:-1], state.pairs.gram):
        array += value
    state.pairs.oldest[0] = (first + rows) % N


@pytest.mark.parametrize("solves", [[], [1], [3], [1, 1], [3, 4]])
def test_what_solves_overwrote_is_taken_back(memory, solves):
    """Rows that go round, rows that are overwritten twice in a step."""
    learn(memory, 2, 0.5)  # of the step before
    before = parts_of(memory).state.copy()
    native_newton.open_journal(memory)
    for k, rows in enumerate(solves):
        learn(memory, rows, 1.0 + k)
    assert np.array_equal(parts_of(memory).state, before) == (not solves)
    native_newton.take_back(memory)
    assert np.array_equal(parts_of(memory).state, before)


def test_what_was_forgotten_is_taken_back(memory):
    before = parts_of(memory).state.copy()
    native_newton.open_journal(memory)
    native_stepping.forget_products(memory)
    assert not any(array.any() for array in state_of(memory).pairs)
    native_newton.take_back(memory)
    assert np.array_equal(parts_of(memory).state, before)


def test_another_memory_has_another_print(memory):
    """Also one of the same pairs in another order."""
    own = native_stepping.print_of(memory)
    assert native_stepping.print_of(memory.copy()) == own
    gram = state_of(memory).pairs.gram
    gram[:] = gram[::-1, ::-1].copy()
    assert native_stepping.print_of(memory) != own
