"""What secants know: everything of a linear map after as many pairs as it has dimensions; the
youngest of a drifting one.
"""

import numpy as np
import pytest

from piston_cosim.master.coupling.methods import Ageing, LeastSquares, MultiVector

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


def drifting(way, pairs_a_step, steps=40, seed=3):
    """Mean error of the answer, while the map drifts by 1 % a step and each step teaches a few
    pairs.
    """
    random, memory, errors = np.random.default_rng(seed), way.memory(), []
    matrix = np.eye(N) + 0.5 * random.standard_normal((N, N))
    for _ in range(steps):
        memory.begin()
        for _ in range(pairs_a_step):
            change = random.standard_normal(N)
            memory.learn(change, -matrix @ change)
        r = random.standard_normal(N)
        answer, rest = memory.update(r, [slice(0, N)])
        errors.append(np.linalg.norm(r - matrix @ (answer + rest)) / np.linalg.norm(r))
        memory.close()
        matrix = matrix + 0.01 * random.standard_normal((N, N))
    return float(np.mean(errors[10:]))


def test_ageing_pairs_follow_a_drifting_map_best():
    aged = drifting(Ageing(drift=1e-3), 2)
    assert aged < drifting(MultiVector(), 2)
    assert aged < drifting(LeastSquares(windows=10), 2)


def test_oldest_pairs_make_room(matrix):
    memory = taught(Ageing(kept=N, noise=1e-12), -matrix, N)
    random = np.random.default_rng(5)
    for _ in range(N):
        change = random.standard_normal(N)
        memory.learn(change, -matrix @ change)
    change, _ = memory.update(np.ones(N), [slice(0, N)])
    assert np.allclose(change, np.linalg.solve(matrix, np.ones(N)), rtol=1e-6, atol=1e-5)
