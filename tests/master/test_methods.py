"""Newton, Aitken and constant relaxation on a stiff pair with a known fixed point."""

import numpy as np
import pytest
from scipy.optimize import brentq

from piston_cosim.master.coupling.interface import Interface
from piston_cosim.master.coupling.methods import (
    Ageing,
    LeastSquares,
    MacroStep,
    MultiVector,
    Newton,
    NotConverged,
    QuasiNewton,
    Relaxation,
)
from piston_cosim.master.coupling.wiring import Wire

STEP, PADS = 1e-4, 7


def closed_form(h0, step):
    """Film after one backward-Euler step of one mass on its film, by bracketing."""

    def from_force(h):
        return h - h0 - step**2 / 1e-3 * (-2e-12 * (h - h0) / step / h**3 - 0.1)

    return brentq(from_force, h0 * 1e-3, h0, xtol=1e-18, rtol=1e-14)


def solve(pair, method, parallel=False):
    interface = Interface(pair.participants, pair.wires, parallel)
    saved = {name: p.save() for name, p in pair.participants.items()}
    return method.solve(MacroStep(interface, 0.0, STEP, saved), interface.read(), method.memory())


def test_newton_reaches_the_fixed_point(pair):
    start = pair.participants["film"].state.copy()
    solution = solve(pair, Newton())
    reference = [closed_form(h, STEP) for h in start]
    # the wires agree to 1e-9 m and 1e-6 N; the film's error is smaller still, by the film's
    # stiffness
    assert np.allclose(solution.x[:PADS], reference, atol=1e-9, rtol=0)
    assert solution.iterations <= 4
    assert solution.history[-1] <= 1.0


def test_derivative_matches_differences(pair):
    interface = Interface(pair.participants, pair.wires)
    saved = {name: p.save() for name, p in pair.participants.items()}
    x = interface.read()
    direction = (
        np.where(interface.feedback, np.linspace(-1, 1, interface.size), 0.0)
        * 1e-4
        * interface.nominal
    )
    _, high, _ = interface.evaluate(x + direction, 0, STEP, saved)
    _, low, _ = interface.evaluate(x - direction, 0, STEP, saved)
    interface.evaluate(x, 0, STEP, saved)
    product = interface.derivative(direction)
    # central differences: error of third order in the direction, relative 1e-6 here
    assert np.allclose((high - low) / 2, product, rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize(
    "method",
    [
        Relaxation(0.001, False, 20000),
        Relaxation(0.001, True, 5000),
        QuasiNewton(LeastSquares(), 0.001),
        QuasiNewton(MultiVector(), 0.001),
        QuasiNewton(Ageing(), 0.001),
        QuasiNewton(Ageing(), probing=True),
        QuasiNewton(LeastSquares(), probing=True),
    ],
)
def test_fixed_point_methods_agree_with_newton(pair, method):
    saved = {name: p.save() for name, p in pair.participants.items()}
    newton = solve(pair, Newton()).x
    for name, p in pair.participants.items():
        p.restore(saved[name])
    relaxed = solve(pair, method).x
    assert np.allclose(
        relaxed[:PADS], newton[:PADS], atol=2e-9, rtol=0
    )  # each is within 1e-9 m of the fixed point
    assert np.allclose(
        relaxed[PADS:], newton[PADS:], atol=1e-3, rtol=0
    )  # 1e-9 m times the film's stiffness


@pytest.mark.parametrize(
    "method", [Newton(), Newton(differences=True), QuasiNewton(Ageing(), probing=True)]
)
def test_jacobi_order_has_the_same_fixed_point(pair, method):
    saved = {name: p.save() for name, p in pair.participants.items()}
    sequential = solve(pair, Newton()).x
    for name, p in pair.participants.items():
        p.restore(saved[name])
    parallel = solve(pair, method, True).x
    assert np.allclose(
        parallel[:PADS], sequential[:PADS], atol=2e-9, rtol=0
    )  # each is within 1e-9 m of the fixed point


def criteria(**given):
    return Wire(
        ("a", "y"),
        ("b", "x"),
        (3,),
        "m",
        1.0,
        **{"tolerance": 0.0, "largest_decrease": None} | given,
    )


def test_criteria_of_a_wire():
    residual, values = (
        np.array([3e-3, -4e-3, 0.0]),
        np.array([1.0, -2.0, 2.0]),
    )  # rms 5e-3 / sqrt 3 and 3 / sqrt 3
    assert criteria(tolerance=2e-3).measure(residual, values) == pytest.approx(2.0)
    assert criteria(relative_tolerance=1e-3).measure(residual, values) == pytest.approx(5 / 3)
    both = criteria(tolerance=1e-6, relative_tolerance=1e-2)  # one that is met is enough
    assert both.measure(residual, values) == pytest.approx(1 / 6)
    assert criteria(tolerance=np.inf).measure(residual, values) == 0.0
    assert criteria(relative_tolerance=1e-3).measure(0 * residual, 0 * values) == 0.0


@pytest.mark.parametrize(
    "given", [{"tolerance": np.inf}, {"tolerance": 1e-3}, {"relative_tolerance": 1e-3}]
)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_never_converges(given, bad):
    residual, values = np.array([0.0, bad, 0.0]), np.array([1.0, bad, 1.0])
    assert not criteria(**given).measure(residual, values) <= 1.0


def test_nan_is_never_accepted(pair):
    pair.participants["mass"].load = np.nan
    with pytest.raises(NotConverged, match=r"^mass.film\[1\]: expected a finite output, got nan"):
        solve(pair, Newton())
