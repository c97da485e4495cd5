"""Forward sensitivities against differences of runs, in the steps that a run takes."""

from dataclasses import replace

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.coupling.forward import (
    ForwardSensitivities,
    NotCovered,
    Pair,
    solutions,
)
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import start
from piston_cosim.master.coupling.stepping import Observer, Stepper
from piston_cosim.master.runs.forward import SHARE, local_system

BODIES, FILM = "participants.bodies.parameters", "participants.ehd.parameters"
GRID = {f"participants.{name}.build.grid": [12, 12] for name in ("bodies", "ehd")}
MOVED = {
    f"{BODIES}.start_lateral_displacement": "1.5 um",
    f"{BODIES}.start_rocking_angle": "0.1 mrad",
}
TOUCHING = {
    f"{BODIES}.radial_clearance": "2 um",
    f"{BODIES}.barrel": "5 um",
    f"{BODIES}.ovality": "3 um",
    f"{FILM}.roughness_rms": "1 um",
}
FEW_MODES = {f"participants.bodies.build.{body}.modes": 4 for body in ("piston", "block")}
START, VISCOSITY, CLEARANCE = (
    f"{BODIES}.start_lateral_displacement",
    f"{FILM}.viscosity",
    f"{BODIES}.radial_clearance",
)
STEPS = {START: (1.5, 0.1, "um"), VISCOSITY: (6.0, 0.12, "mPa s"), CLEARANCE: (10.0, 0.1, "um")}
"""Value, step and unit of the variables."""
PORTS = (
    ("bodies", "lateral_displacement"),
    ("bodies", "rocking_angle"),
    ("ehd", "friction_power"),
    ("ehd", "minimum_film_thickness"),
    ("ehd", "oil_in_film"),
)
SHARPER = 1e-7
"""Tolerance of the wires over that of the case, so that differences of runs are accurate."""


class Course(Observer):
    """Scalar outputs of a run."""

    def __init__(self, system):
        self.participants, self.times, self.rows = system.participants, [], []

    def accepted(self, time, solution):
        self.times.append(time)
        self.rows.append([self.participants[name].get(port) for name, port in PORTS])


class Runs:
    """Runs of a changed case over some macro steps."""

    def __init__(self, variant, changes, count):
        self.case = pc.open_case("numerical_example", variant=variant).changed(changes)
        self.values, self.count = STEPS | self._own(changes), count

    @staticmethod
    def _own(changes):
        texts = {key: changes[key].split() for key in STEPS if key in changes}
        return {key: (float(text[0]), *STEPS[key][1:]) for key, text in texts.items()}

    def system(self, key=None, share=0.0):
        value, step, unit = self.values[key or VISCOSITY]
        case = self.case.changed({key: f"{value + share * step!r} {unit}"}) if key else self.case
        system = local_system(case.tree, case.path)
        wires = [replace(one, tolerance=SHARPER * one.tolerance) for one in system.wires]
        return replace(system, wires=tuple(wires))

    def run(self, system, observer):
        coupling = check_case(self.case.tree, self.case.path).coupling
        halvings = coupling.advanced.halvings
        stepper = Stepper(system, method_of(coupling), halvings, observer, coupling.predictor)
        for k in range(self.count):
            stepper.advance(k * system.step, system.step)
        return observer

    def course(self, key=None, share=0.0):
        """Return the outputs at the ends of all steps, (rows, ports)."""
        system = self.system(key, share)
        start(system)
        return np.array(self.run(system, Course(system)).rows)

    def forward(self, *keys):
        """Return the derivatives at the ends of all steps, (rows, variables, ports)."""
        pairs = [Pair(self.system(k, SHARE), self.system(k, -SHARE), SHARE) for k in keys]
        observer = ForwardSensitivities(self.system(), pairs)
        system = self.system()
        start(system)
        self.run(system, observer)
        columns = [observer.ports.index(port) for port in PORTS]
        return observer, np.array(observer.rows)[1:, :, columns]


@pytest.mark.parametrize(
    "variant, changes, count, tolerance",
    [
        pytest.param("rigid", MOVED, 20, 1e-5, id="rigid"),
        pytest.param("rigid", MOVED | TOUCHING, 12, 1e-5, id="touching, with repeated steps"),
        pytest.param(
            "flexible", MOVED | FEW_MODES, 6, 1e-4, id="with modes", marks=pytest.mark.slow
        ),
    ],
)
def test_derivatives_are_those_of_differences_of_runs(variant, changes, count, tolerance):
    runs = Runs(variant, GRID | changes, count)
    observer, known = runs.forward(*STEPS)
    share = 1e-3  # truncation below 1e-6 of the derivative, error of the wires too
    for k, key in enumerate(STEPS):
        difference = (runs.course(key, share) - runs.course(key, -share)) / (2.0 * share)
        assert len(difference) == len(known)
        error = np.abs(known[:, k] - difference).max(axis=0)
        assert np.all(error <= tolerance * np.abs(difference).max(axis=0)), key
    assert not any(observer.switches.values())


@pytest.mark.slow
def test_figures_of_a_periodic_run_change_as_by_differences_of_runs(tmp_path):
    """The steps of the variables are 1 and 2 %, whose curvature and scatter are below 2 %."""
    case = pc.open_case("numerical_example", variant="rigid").changed(GRID)
    by = {"radial_clearance": "0.1 um", "viscosity": "0.12 mPa s"}
    known = [
        {(one.variable, one.figure): one.change for one in found}
        for found in (
            pc.sensitivities(case, by, tmp_path / f"{forward}", 1, forward=forward)
            for forward in (True, False)
        )
    ]
    figures = (
        "minimum_film_thickness_m",
        "friction_mean_effective_pressure_pa",
        "maximum_pressure_pa",
    )
    for variable in by:
        for figure in figures:
            here, other = (one[variable, figure] for one in known)
            print(f"{variable}, {figure}: {here:.4g}, by differences {other:.4g}")
            assert here == pytest.approx(other, rel=0.02)


def test_the_remainder_of_a_step_of_a_variable_is_of_second_order():
    runs = Runs("rigid", GRID | MOVED, 10)
    _, known = runs.forward(CLEARANCE)
    base = runs.course()
    remainders = [
        np.abs(runs.course(CLEARANCE, x) - base - x * known[:, 0]).max(axis=0)
        for x in (0.25, 0.125)
    ]
    orders = np.log2(remainders[0] / remainders[1])
    assert np.all(orders > 1.95), orders  # cells that fill or empty disturb larger steps


def test_the_start_is_differentiated_too():
    observer, _ = Runs("rigid", GRID | MOVED, 1).forward(START)
    column = observer.ports.index(("bodies", "lateral_displacement"))
    assert observer.rows[0][0, column] == pytest.approx(1e-7, rel=1e-9)  # its own step
    assert observer.times[0] == 0.0 and len(observer.times) == 2


def test_all_right_hand_sides_share_the_products_of_the_interface():
    random = np.random.default_rng(0)
    size, rank, count = 40, 3, 8
    matrix = random.standard_normal((size, rank)) @ random.standard_normal((rank, size)) / 4.0
    right = random.standard_normal((size, count))
    products = []

    def product(x):
        products.append(x)
        return matrix @ x

    known = solutions(product, right)
    exact = np.linalg.solve(np.eye(size) - matrix, right)
    assert np.abs(known - exact).max() < 1e-9 * np.abs(exact).max()
    assert len(products) <= count + rank + 1


def test_cases_that_are_not_covered_say_why(tmp_path):
    explicit = pc.open_case("numerical_example", variant="rigid").changed(
        GRID | {"coupling.method": "explicit"}
    )
    with pytest.raises(NotCovered, match="explicit coupling"):
        local_system(explicit.tree, explicit.path)
    coated = GRID | {f"{FILM}.coating_thickness": "10 um", f"{FILM}.coating_modulus": "1 GPa"}
    with pytest.raises(NotCovered, match="coating"):
        Runs("rigid", coated, 1).forward(VISCOSITY)
