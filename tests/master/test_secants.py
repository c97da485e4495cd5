"""What secants know: everything of a linear map after as many pairs as it has dimensions; the
youngest of a drifting one.
"""

import numpy as np
import pytest

from piston_cosim.master.coupling.methods import Ageing

N = 8


def taught(way, matrix, pairs, seed=1):
    """Memory of pairs dr = -A dx of a linear map."""
    memory, random = way.memory(), np.random.default_rng(seed)
    memory.begin()
    for _ in range(pairs):
        change = random.standard_normal(N)
        memory.learn(change, -matrix @ change)
    return memory


@pytest.fixture
def matrix():
    return np.eye(N) + 0.5 * np.random.default_rng(0).standard_normal((N, N))


def test_oldest_pairs_make_room(matrix):
    memory = taught(Ageing(kept=N, noise=1e-12), -matrix, N)
    random = np.random.default_rng(5)
    for _ in range(N):
        change = random.standard_normal(N)
        memory.learn(change, -matrix @ change)
    change, _ = memory.update(np.ones(N), [slice(0, N)])
    assert np.allclose(change, np.linalg.solve(matrix, np.ones(N)), rtol=1e-6, atol=1e-5)
