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


@pytest.mark.parametrize(
    "method, parallel, most",
    [
        (Newton(), False, 4),
        (Newton(), True, 4),
        (Newton(differences=True), True, 4),
        (Relaxation(0.001, False, 20000), False, 20000),
        (Relaxation(0.001, True, 5000), False, 5000),
        (QuasiNewton(MultiVector(), 0.001), False, 20),
        (QuasiNewton(LeastSquares(), probing=True), False, 20),
        (QuasiNewton(Ageing(), probing=True), False, 20),
        (QuasiNewton(Ageing(), probing=True), True, 20),
    ],
)
def test_every_method_reaches_the_fixed_point(pair, method, parallel, most):
    reference = [closed_form(h, STEP) for h in pair.participants["film"].state]
    solution = solve(pair, method, parallel)
    # the wires agree to 1e-9 m and 1e-6 N
    assert np.allclose(solution.x[:PADS], reference, atol=1e-9, rtol=0)
    assert solution.iterations <= most
    assert solution.history[-1] <= 1.0


@pytest.mark.parametrize(
    "given", [{"tolerance": np.inf}, {"tolerance": 1e-3}, {"relative_tolerance": 1e-3}]
)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_never_converges(given, bad):
    usual = {"tolerance": 0.0, "largest_decrease": None}
    wire = Wire(("a", "y"), ("b", "x"), (3,), "m", 1.0, **usual | given)
    assert not wire.measure(np.array([0.0, bad, 0.0]), np.array([1.0, bad, 1.0])) <= 1.0
    assert wire.measure(np.zeros(3), np.zeros(3)) == 0.0  # also by a share of nothing


def test_nan_is_never_accepted(pair):
    pair.participants["mass"].load = np.nan
    with pytest.raises(NotConverged, match=r"^mass.film\[1\]: expected a finite output, got nan"):
        solve(pair, Newton())
