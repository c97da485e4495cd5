"""BDF2 of a play: order with changing steps, and a pin that a film stops within a step."""

import numpy as np
import pytest
from scipy.optimize import brentq

from piston_cosim.fmu_mfbd.dynamics.first_steps import FIRST_STEPS, first_steps
from piston_cosim.fmu_mfbd.mechanism.bdf2 import (
    auxiliary_after,
    limit_plays,
    memory_of,
    predicted_of,
    reach_of,
)
from piston_cosim.fmu_mfbd.mechanism.cylinder import COORDINATES, PIN
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion, coefficients

from .pin_models import STEP, Springs, crank_model

PLAYS = np.array([PIN.boss_x, PIN.eye_x])
BY_BDF2 = np.zeros(COORDINATES)
BY_BDF2[PIN.boss_x : PIN.spin] = 1.0
"""Coordinates of a pin without modes and without films of the crank."""


class Play:
    """Play of a pin along x, of which everything else stands still.

    Its equation is x'' = force(x, x', k) with numbers at the end of step k.
    """

    def __init__(self, position, velocity, acceleration):
        self.motion = Motion(*np.zeros((3, COORDINATES)))
        for values, value in zip(self.motion, (position, velocity, acceleration)):
            values[PIN.boss_x] = value
        self.auxiliary = self.motion.acceleration.copy()
        self.mean_velocity = self.motion.velocity - 0.0
        self.last = 0.0

    def advance(self, c, solve):
        """Advance by a step with coefficients; `solve` returns x from its prediction and reach."""
        before = self.motion
        predicted = predicted_of(c, before, self.auxiliary, self.mean_velocity, BY_BDF2)
        reach = reach_of(c, BY_BDF2)
        each = predicted.position, reach.velocity, reach.position
        x, c1, c2 = (one[PIN.boss_x] for one in each)
        a = np.zeros(COORDINATES)
        a[PIN.boss_x] = (solve(x, predicted.velocity[PIN.boss_x], c1, c2) - x) / c2
        end = Motion(
            predicted.position + reach.position * a, predicted.velocity + reach.velocity * a, a
        )
        self.mean_velocity = (end.position - before.position) / c.step
        self.auxiliary = auxiliary_after(c, predicted, before, end, BY_BDF2)
        limit_plays(PLAYS, before, end, self.auxiliary, c.step)
        self.motion, self.last = end, c.step


def test_memory_by_hand():
    """Half, equal and double steps; beyond the double one the memory stays that of the double."""
    assert memory_of(1.0, 0.0) == 0.0
    assert memory_of(0.5, 1.0) == pytest.approx(1 / 8, rel=1e-15)
    assert memory_of(1.0, 1.0) == pytest.approx(1 / 3, rel=1e-15)
    assert memory_of(2.0, 1.0) == memory_of(5.0, 1.0) == pytest.approx(4 / 5, rel=1e-15)


@pytest.mark.parametrize("damping, stiffness", [(4.0, 900.0), (1e6, 1e6)])
def test_order_is_kept_by_steps_that_change(damping, stiffness):
    """Errors of a play under cos(2 pi t) fall at least by 3.6 where all steps are halved.

    The steps are halved, doubled and repeated, and the first two are backward Euler. The play
    oscillates, or a damper holds it. A first-order method gives 2.
    """
    pattern = np.tile([1.0, 2.0, 1.0, 0.5, 0.5, 1.0, 1.5], 6)
    omega = 2 * np.pi
    amplitude = 1 / (stiffness - omega**2 + 1j * damping * omega)
    errors = []
    for halvings in range(4):
        steps = np.repeat(pattern / pattern.sum(), 2**halvings) / 2**halvings
        exact = [(amplitude * (1j * omega) ** n).real for n in range(3)]
        play = Play(*exact)
        time = worst = 0.0
        for k, h in enumerate(steps):
            time += h
            memory = memory_of(h, play.last)
            c = first_steps(h) if k < FIRST_STEPS else coefficients(h, 0.6, memory)
            load = np.cos(omega * time)

            def solve(x, v, c1, c2, load=load):
                a = (load - damping * v - stiffness * x) / (1 + c1 * damping + c2 * stiffness)
                return x + c2 * a

            play.advance(c, solve)
            x = play.motion.position[PIN.boss_x]
            worst = max(worst, abs(x - (amplitude * np.exp(1j * omega * time)).real))
        errors.append(worst)
    assert np.all(np.array(errors[:-1]) / errors[1:] > 3.6)


def test_six_films_are_of_second_order():
    """Differences of halved steps fall at least by 3.2 in all plays, forces and motions.

    Springs replace the films. Backward Euler of the plays gives 2 for everything.
    """
    bearings = ("pin", "small_end", "big_end", "main_bearing")
    names = [f"{one}_displacement_{axis}" for one in bearings for axis in "xy"]
    names += ["lateral_displacement", "rocking_angle", "crank_torque", "small_end_force_y"]
    ends = []
    for parts in (16, 32, 64):
        out = Springs(crank_model(), 4e7, skirt=5e6).run(parts, step=STEP / parts)[-1]
        ends.append([out[name] for name in names])
    first, second = np.abs(np.diff(ends, axis=0))
    assert np.all(first > 3.2 * second)


def squeeze(share):
    """Return the force of a short bearing against its squeeze, over that in its middle [-].

    Eq.:  int_(-pi/2)^(pi/2) cos^2 a/(1 - e cos a)^3 da 2/pi; half of it bears, as of a cavity.
    """
    a = np.linspace(-np.pi / 2, np.pi / 2, 401)
    return np.trapezoid(np.cos(a) ** 2 / (1 - share[:, None] * np.cos(a)) ** 3, a) * 2 / np.pi


SHARES = 1 - np.logspace(np.log10(2.0) - 1e-6, -6, 600)
SQUEEZE = squeeze(SHARES)


def returned(rng, pushed):
    """Return the largest velocity back over that of the approach, of a random pin in 15 steps.

    Mass, radius, length, clearance and oil are those of pins from a motorcycle to a truck.
    """
    mass, radius, length, clearance = 10 ** rng.uniform(
        (-1.3, -2.1, -1.9, -5.3), (0.5, -1.4, -1.2, -4.5)
    )
    viscosity, speed, step = 10 ** rng.uniform((-2.7, -2, -5.5), (-1.5, 0, -4))
    rate = np.pi / 2 * viscosity * radius * length**3 / clearance**3 / mass
    push = 10 ** rng.uniform(1, 4) if pushed else 0.0
    play = Play(rng.uniform(0, 0.9) * clearance, speed, push)
    play.last = step
    fastest, back = speed, 0.0
    for _ in range(15):
        begun = play.motion.position[PIN.boss_x]

        def solve(x, v, c1, c2, begun=begun):
            def lack(end):
                way = end - begun
                toward = end / clearance * np.sign(way)
                held = rate * np.interp(toward, SHARES, SQUEEZE) * way / step
                return end - x - c2 * (push - held)

            return brentq(lack, -0.9999 * clearance, 0.9999 * clearance, xtol=1e-18)

        play.advance(coefficients(step, 0.6, memory_of(step, play.last)), solve)
        velocity = play.motion.velocity[PIN.boss_x]
        fastest, back = max(fastest, velocity), max(back, -velocity)
    return back / fastest


def test_no_film_returns_a_pin():
    """None of 1000 random pins returns more than 3 % of the speed with which it came.

    Films cavitate: only what closes bears. Half of the pins are also pushed. BDF2 alone returns 984
    of them faster than that, up to the total speed.
    """
    rng = np.random.default_rng(2)
    shares = np.array([returned(rng, k % 2) for k in range(1000)])
    assert shares.max() < 0.03
