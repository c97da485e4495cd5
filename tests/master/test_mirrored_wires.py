"""Half of the unknowns of a mirrored wire in Newton's iteration."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.coupling.methods.iteration import Answer, converge, field_update
from piston_cosim.master.coupling.methods.krylov import no_pairs
from piston_cosim.master.coupling.methods.newton import Newton
from piston_cosim.master.coupling.vector import Evaluation, largest
from piston_cosim.master.coupling.wiring import Wire, layout_of
from piston_cosim.master.fmi.symmetry import thrust_image

SHAPE = (8, 3)
TOLERANCE = 1e-10


def wire(source, target, **more):
    return Wire(source, target, SHAPE, "m", 1.0, TOLERANCE, None, **more)


def solved(matrix, constant, mirrored=True):
    """Return x = G(x) = matrix x + constant on a mirrored wire, the pairs and all directions."""
    wires = [wire(("b", "y"), ("a", "u"), mirrored=mirrored), wire(("a", "y"), ("b", "u"))]
    layout = layout_of(wires, ["a", "b"], False)
    size = matrix.shape[0]
    seen = []

    def evaluate(step, x):
        y = np.concatenate([matrix @ x[:size] + constant, x[:size]])
        at = Evaluation(np.concatenate([x[:size], y[size:]]), y, y - x)
        tolerance = layout.tolerance
        return Answer(at, largest(np.abs(at.residual[:size]) / tolerance[:size]), tolerance)

    def derivative(step, change, out):
        seen.append(change[:size].copy())
        out[:] = np.concatenate([matrix @ change[:size], change[:size]])
        return True

    pairs = no_pairs(size)
    rules: SimpleNamespace | Newton = Newton()
    update = partial(field_update, derivative)
    end = converge(evaluate, update, None, np.zeros(2 * size), rules, layout, pairs)
    return end, pairs, np.array(seen), layout


@pytest.mark.parametrize("mirrored", [True, False])
def test_newton_solves_half_of_an_even_field_and_all_of_another(mirrored):
    """The solution is that of numpy. Directions are even while the residual is."""
    rng = np.random.default_rng(2)
    size = int(np.prod(SHAPE))
    image = np.arange(size).reshape(SHAPE)[thrust_image(SHAPE[0])].ravel()
    matrix = 0.1 * rng.standard_normal((size, size))
    constant = rng.standard_normal(size)
    if mirrored:
        matrix = matrix + matrix[image][:, image]
        constant = constant + constant[image]
    end, pairs, seen, layout = solved(matrix, constant)
    # 8 cells around: 2 on the plane and 3 pairs
    assert len(layout.half) == 5 * SHAPE[1] and len(layout.unknowns) == size
    expected = np.linalg.solve(np.eye(size) - matrix, constant)
    assert end.is_converged
    np.testing.assert_allclose(end.at.used[:size], expected, atol=100 * TOLERANCE)
    assert pairs.is_whole[0] == (not mirrored)
    assert np.array_equal(seen, seen[:, image]) == mirrored
    if mirrored:  # the norms are those of the whole field, so that both take the same iterates
        whole, *_ = solved(matrix, constant, mirrored=False)
        assert end.products == whole.products <= len(layout.half) * len(end.history)
        np.testing.assert_allclose(end.history, whole.history, rtol=1e-6, atol=1e-2)
