"""What a communication step of the coupled FMU without Python overwrites is taken back; its loops
run as written.
"""

import numpy as np
import pytest

from piston_cosim.master.coupling import native_journal, native_stepping
from piston_cosim.master.coupling.native_block import (
    COUNTED,
    DIFFERENCES,
    GIVEN,
    GRAM,
    IMAGES,
    OLDEST,
    PAST,
    STANDING,
    STATE,
    TIMES,
    given,
)
from piston_cosim.master.fmi.block import part
from piston_cosim.master.fmi.compiled import Kernel

KEPT, UNKNOWNS = 4, 3
LENGTHS = dict(standing=5, times=3, past=6, oldest=1, gram=KEPT**2)
LENGTHS |= dict.fromkeys(("images", "differences"), KEPT * UNKNOWNS)
REMEMBERED = (STANDING, TIMES, PAST, OLDEST, IMAGES, DIFFERENCES, GRAM)


@pytest.fixture(autouse=True)
def interpreted(monkeypatch):
    """Kernels as written, not compiled."""
    for module in (native_journal, native_stepping):
        for kernel in vars(module).values():
            if isinstance(kernel, Kernel):
                monkeypatch.setitem(kernel.__dict__, "dispatcher", kernel.py_func)


@pytest.fixture
def memory():
    """Of no participants, its state any numbers; the third of four pairs is forgotten next."""
    counts = np.zeros(len(COUNTED))
    counts[COUNTED.index("kept")] = KEPT
    counts[COUNTED.index("unknowns")] = UNKNOWNS
    contents = dict.fromkeys(GIVEN, np.zeros(0)) | {"counts": counts}
    others = dict(inside=2, saved=5, before=sum(LENGTHS.values()), marks=KEPT, last=4)
    others |= dict(last_inputs=0, last_outputs=0, trail=2, failures=1, faults=1)
    head = given(contents, LENGTHS | others)
    whole = np.full(int(head[0]), np.nan)
    whole[: len(head)] = head
    rng = np.random.default_rng(1)
    for which in REMEMBERED:
        part(whole, which)[:] = rng.standard_normal(len(part(whole, which)))
    part(whole, OLDEST)[0] = 2.0
    return whole


def state(memory):
    """A copy of the state, whole."""
    assert len(REMEMBERED) == len(STATE)
    return np.concatenate([part(memory, which) for which in REMEMBERED])


def learn(memory, rows, value):
    """As GMRES: so many of the oldest pairs are other ones, and all else moves."""
    native_journal.overwrite(memory, rows)
    first = int(part(memory, OLDEST)[0])
    for which in (IMAGES, DIFFERENCES):
        pairs = part(memory, which).reshape(KEPT, UNKNOWNS)
        for k in range(rows):
            pairs[(first + k) % KEPT] = value + which
    for which in (STANDING, TIMES, PAST, GRAM):
        part(memory, which)[:] += value
    part(memory, OLDEST)[0] = (first + rows) % KEPT


@pytest.mark.parametrize("solves", [[], [1], [3], [1, 1], [3, 4]])
def test_what_solves_overwrote_is_taken_back(memory, solves):
    """Rows that go round, rows that are overwritten twice in a step."""
    learn(memory, 2, 0.5)  # of the step before
    before = state(memory)
    native_journal.open_journal(memory)
    for k, rows in enumerate(solves):
        learn(memory, rows, 1.0 + k)
    assert np.array_equal(state(memory), before) == (not solves)
    native_journal.take_back(memory)
    assert np.array_equal(state(memory), before)


def test_what_was_forgotten_is_taken_back(memory):
    before = state(memory)
    native_journal.open_journal(memory)
    native_stepping.forget_products(memory)
    assert not part(memory, IMAGES).any() and not part(memory, GRAM).any()
    native_journal.take_back(memory)
    assert np.array_equal(state(memory), before)


def test_another_memory_has_another_print(memory):
    """Also one of the same pairs in another order."""
    own = native_journal.print_of(memory)
    assert native_journal.print_of(memory.copy()) == own
    gram = part(memory, GRAM)
    gram[:] = gram.reshape(KEPT, KEPT)[::-1, ::-1].ravel()
    assert native_journal.print_of(memory) != own
