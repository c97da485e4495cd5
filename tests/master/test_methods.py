"""Newton, Aitken and constant relaxation on a stiff pair with a known fixed point."""

import numpy as np
import pytest
from scipy.optimize import brentq

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.coupling.interface import Interface
from piston_cosim.master.coupling.methods import (
    LeastSquares,
    MacroStep,
    Newton,
    NotConverged,
    QuasiNewton,
    Relaxation,
)
from piston_cosim.master.coupling.wiring import Wire
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.models.elastic_tube.secants import Ageing

from .toys import Toy, variable

STEP = 1e-4
H0 = 1e-5 * np.linspace(0.6, 1.4, 7)
"""Films at the start [m]; the masses are at rest."""
DAMPING, MASS = 2e-12 / STEP, 1e-3 / STEP**2
"""At 10 um a fixed-point pass amplifies an error by 200."""


class Film(Toy):
    """Squeeze film of pads: force = -c (h - h_n) / step / h^3."""

    def _advance(self, step):
        h = self.values["film"]
        self.values["force"] = -DAMPING * (h - H0) / h**3
        self.slope = -DAMPING * (1 / h**3 - 3 * (h - H0) / h**4)

    def derivative(self, seeds, products):
        return {"force": self.slope * seeds["film"]}


class Mass(Toy):
    """Masses under a steady load, backward Euler: m dv/dt = force - load, film grows with v."""

    def _advance(self, step):
        self.values["film"] = H0 + (self.values["force"] - self.load) / MASS

    def derivative(self, seeds, products):
        return {"film": seeds["force"] / MASS}


def solve(method, parallel=False, load=0.1):
    def participant(kind, of_film, of_force):
        film = variable("film", of_film, shape=H0.shape, nominal=1e-5)
        fields = {"film": film, "force": variable("force", of_force, shape=H0.shape)}
        return kind("mass", fields, np.zeros(0), {"film": H0.copy(), "force": 0 * H0})

    film, mass = participant(Film, "input", "output"), participant(Mass, "output", "input")
    mass.load = load
    wires = (
        Wire(("mass", "film"), ("film", "film"), H0.shape, "m", 1e-5, 1e-9, 0.3),
        Wire(("film", "force"), ("mass", "force"), H0.shape, "N", 1.0, 1e-6, None),
    )
    interface = Interface({"film": film, "mass": mass}, wires, parallel)
    saved = {"film": film.save(), "mass": mass.save()}
    return method.solve(MacroStep(interface, 0.0, STEP, saved), interface.read(), method.memory())


def closed_form(h0):
    """Film after one step of one mass on its film, by bracketing."""

    def from_force(h):
        return h - h0 - (-DAMPING * (h - h0) / h**3 - 0.1) / MASS

    return brentq(from_force, h0 * 1e-3, h0, xtol=1e-18, rtol=1e-14)


@pytest.mark.parametrize(
    "method, parallel, most",
    [
        (Newton(), False, 4),
        (Newton(), True, 4),
        (Newton(differences=True), True, 4),
        (Relaxation(0.001, False, 20000), False, 20000),
        (Relaxation(0.001, True, 5000), False, 5000),
        (QuasiNewton(LeastSquares(), 0.001), False, 20),
        (QuasiNewton(LeastSquares(), probing=True), False, 20),
        (QuasiNewton(Ageing(), probing=True), False, 20),
        (QuasiNewton(Ageing(), probing=True), True, 20),
    ],
)
def test_every_method_reaches_the_fixed_point(method, parallel, most):
    solution = solve(method, parallel)
    # the wires agree to 1e-9 m and 1e-6 N
    assert np.allclose(solution.x[: H0.size], [*map(closed_form, H0)], atol=1e-9, rtol=0)
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


def test_nan_is_never_accepted():
    with pytest.raises(NotConverged, match=r"^mass.film\[1\]: expected a finite output, got nan"):
        solve(Newton(), load=np.nan)


@pytest.mark.parametrize(
    "method",
    [
        lambda most: Newton(max_iterations=most),
        lambda most: QuasiNewton(max_iterations=most, probing=True),
        lambda most: Relaxation(1e-6, False, most),
    ],
)
@pytest.mark.parametrize(
    "share, most, is_accepted", [(0.05, 20, True), (0.5, 20, False), (0.5, 1, True)]
)
def test_a_first_guess_is_accepted_at_a_tenth_of_the_tolerance(method, share, most, is_accepted):
    """The load moves the masses by a share of the tolerance; with one evaluation there is no other.

    The film amplifies what is left of it, so that guesses from accepted guesses would drift.
    """
    load = share * 1e-9 * MASS
    assert (len(solve(method(most), load=load).history) == 1) == is_accepted


class Link(Toy):
    """y = 1 + u / 1000, without derivatives."""

    has_derivatives = False

    def _advance(self, step):
        self.values["y"] = 1.0 + 1e-3 * self.values["u"]


def test_a_long_ring_of_weak_couplings_is_solved():
    """A change fades by 1e-3 in each of 150 links, to 1e-450."""
    fields = {"u": variable("u", "input"), "y": variable("y", "output")}
    start = {"u": np.array(0.0), "y": np.array(0.0)}
    links = {f"l{k}": Link(f"l{k}", fields, np.zeros(0), dict(start)) for k in range(150)}
    names = list(links)
    wires = [
        Wire((a, "y"), (b, "u"), (), "1", 1.0, 1e-9, None)
        for a, b in zip(names, [*names[1:], names[0]])
    ]
    saved = {name: link.save() for name, link in links.items()}
    step = MacroStep(Interface(links, wires), 0.0, 1.0, saved)
    solution = Newton().solve(step, np.zeros(len(wires)), Newton().memory())
    assert solution.x == pytest.approx(1 / 0.999, abs=1e-9)


def test_an_exported_fmu_rejects_methods_of_plug_ins():
    """Its code has no entry points."""
    path = find_case("data_sheet")
    case = check_case(read_tree(path, [("coupling.method", "iqn_ageing")]), path)
    with pytest.raises(BadInput, match=r"coupling.method: expected one of newton, .* got 'iqn_ag"):
        export_fmu(case, path.parent, print)
