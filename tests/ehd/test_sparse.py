import numpy as np
import pytest

from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.fmu_ehd.solvers import sparse
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

SHAPE = (11, 9)


def pressure_force(solver):
    """Nodal pressure force after a few degrees, and its derivative, with a given solver class."""
    model = LubricationModel(Parameters(SHAPE, roughness_rms=1e-6))
    model.solver = solver(SHAPE)
    state, _ = model.start(*motored_film(SHAPE, 0.0))
    for k in range(1, 20):
        state, outputs = model.advance(state, *motored_film(SHAPE, k * DEGREE), DEGREE)
    derivative = model.tangent(
        *np.ones((2, 3, *SHAPE)) * np.array([1e-6, 1.0])[:, None, None, None]
    )
    return outputs["nodal_pressure_force"], derivative[1]


@pytest.mark.parametrize("name", ["SuperLU", "Pardiso"])
def test_every_solver_gives_the_same_answer(name):
    try:
        other = pressure_force(getattr(sparse, name))
    except ImportError:
        pytest.skip("pypardiso is an optional extra")
    for value, reference in zip(other, pressure_force(sparse.BlockTridiagonal)):
        assert (
            np.abs(value - reference).max() <= 1e-10 * np.abs(reference).max()
        )  # round-off x condition


def test_pardiso_repeats_its_bits_and_returns_its_memory():
    pytest.importorskip("pypardiso")
    resource = pytest.importorskip("resource")
    sizes = []
    for _ in range(6):
        first, again = (pressure_force(sparse.Pardiso) for _ in range(2))
        assert all(np.array_equal(a, b) for a, b in zip(first, again))
        big = sparse.Pardiso((150, 150))
        ones = np.ones((150, 150))
        big.factorise((4.1 * ones, -ones, -ones, -ones, -ones))
        assert np.isfinite(big.solve(ones[None])).all()
        del big
        sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    assert sizes[-1] - sizes[1] < 20e3  # kB; a factorisation of this size holds some 30 MB


def test_small_grids_get_dense_blocks_and_huge_ones_do_not():
    assert isinstance(sparse.linear_solver((40, 40)), sparse.BlockTridiagonal)
    assert not isinstance(sparse.linear_solver((700, 700)), sparse.BlockTridiagonal)
