"""models/crank_bearings: six films on one piston's mechanism.

The tests compare orbits with the mobility method, check forces, and export the case.
"""

from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.participants.fmi2 import FmuParticipant

from .runs import export, run_tree
from .shipped import CRANK_BEARINGS as PATH
from .shipped import PARAMETERS, small_crank

computed = partial(run_tree, PATH)
CRANK = {"big_end_film": "big_end", "main_film": "main_bearing"}
OFFSET, RADIUS, LENGTH = 0.0, 72e-3, 223e-3
SPEED = 1680 * 2 * np.pi / 60
SIZES = {"big_end": (37e-3, 32e-3, 35e-6), "main_bearing": (43e-3, 34e-3, 40e-6)}
"""Radius, length and clearance of the crank's bearings [m]."""
VISCOSITY = 5.6e-3
BEFORE_FIRING = (f"{PARAMETERS}.start_crank_angle", "-60 deg")


class Bearing:
    """A bearing of finite length and a journal without mass, in the shell's axes.

    At each instant the mobility method gives the velocity with which the film carries a load, and
    from it the orbit.

    div(h^3/(12 mu) grad p) = dh/dt + w/2 dh/da, p = 0 at both ends and cut off below zero; w of
    the journal less that of the shell. p is a cosine series along the bearing, differences around.
    """

    def __init__(self, radius, length, clearance, viscosity, around=96, terms=6, along=8):
        self.clearance = clearance
        angle = 2 * np.pi / around * np.arange(around)
        self.outward = np.array([np.cos(angle), np.sin(angle)])
        self.onward = np.array([-np.sin(angle), np.cos(angle)])
        self.waves = (2 * np.arange(terms) + 1) * np.pi / length
        z, weight = np.polynomial.legendre.leggauss(along)
        self.along = np.cos(np.outer(self.waves, z * length / 2))
        self.area = radius * 2 * np.pi / around * weight * length / 2
        # 1 = sum of these times the cosines, and 12 mu
        share = 4 * (-1) ** np.arange(terms) / ((2 * np.arange(terms) + 1) * np.pi)
        self.right = 12 * viscosity * share
        self.step = radius * 2 * np.pi / around

    def pressures(self, place, turning):
        """Before the cut: of velocities 1 along both axes, and of turning; (3, around, along)."""
        h = self.clearance - place @ self.outward
        face = ((h + np.roll(h, -1)) / 2) ** 3 / self.step**2
        own = np.arange(len(h))
        around = np.zeros((len(h), len(h)))
        around[own, (own + 1) % len(h)] = face
        around[own, own - 1] = np.roll(face, 1)
        around[own, own] = -face - np.roll(face, 1)
        across = h**3 * self.waves[:, None] ** 2
        matrix = around - across[:, :, None] * np.eye(len(h))
        growth = np.array([*-self.outward, -turning / 2 * (place @ self.onward)])
        parts = np.linalg.solve(matrix, self.right[:, None, None] * growth.T)
        return np.einsum("nak,nz->kaz", parts, self.along)

    def velocity(self, place, turning, load, guess):
        """Return the journal velocity that carries the load [m/s], by Newton's method."""
        *moving, spinning = self.pressures(place, turning)
        scale = np.abs(load).max() + 1.0
        for _ in range(50):
            pressure = spinning + guess[0] * moving[0] + guess[1] * moving[1]
            full = (pressure > 0.0) | (pressure.max() <= 0.0)
            lack = load - self.outward @ ((pressure * full) @ self.area)
            if np.abs(lack).max() <= 1e-8 * scale:
                break
            by = [self.outward @ ((one * full) @ self.area) for one in moving]
            guess = guess + np.linalg.solve(np.array(by).T, lack)
        return guess

    def orbit(self, load, turning, times):
        """Places from the middle on, (n, 2) [m]."""
        guess = np.zeros(2)

        def velocity(time, place):
            nonlocal guess
            guess = self.velocity(self.clearance * place, turning(time), load(time), guess)
            return guess / self.clearance

        span = times[0], times[-1]
        found = solve_ivp(velocity, span, np.zeros(2), t_eval=times, rtol=1e-4, atol=1e-6)
        return self.clearance * found.y.T


def rod_motion(angle):
    """Angle of the rod and what its speed is of the crank's."""
    aside = OFFSET + RADIUS * np.sin(angle)
    return -np.arcsin(aside / LENGTH), -RADIUS * np.cos(angle) / np.sqrt(LENGTH**2 - aside**2)


def course(results, name):
    return np.column_stack([results.series(f"bodies.{name}_{way}").values for way in "xy"])


def course_of(time, values):
    """Linear between the instants."""
    slopes = np.diff(values, axis=0) / np.diff(time).reshape(-1, *[1] * (values.ndim - 1))

    def at(t):
        k = min(max(np.searchsorted(time, t) - 1, 0), len(slopes) - 1)
        return values[k] + (t - time[k]) * slopes[k]

    return at


def in_axes(vectors, turn):
    """Vectors (n, 2) in axes turned by `turn` (n,)."""
    x, y = vectors.T
    c, s = np.cos(turn), np.sin(turn)
    return np.column_stack([c * x + s * y, c * y - s * x])


def orbits(results):
    """Return both orbits of each journal, from the run and from the mobility method, by surface.

    Each has shape (n, 2), in clearances. The mobility method takes the loads of the run.
    """
    time, angle = results.time, results.series("bodies.crank_angle").values
    turn, share = rod_motion(angle)
    turns = {"big_end": turn, "main_bearing": 0.0 * turn}
    relative = {"big_end": SPEED * (1 - share), "main_bearing": SPEED + 0.0 * share}
    found = {}
    for surface, (radius, length, clearance) in SIZES.items():
        shown = in_axes(course(results, f"{surface}_displacement"), turns[surface])
        pressed = in_axes(course(results, f"{surface}_force"), turns[surface])
        bearing = Bearing(radius, length, clearance, VISCOSITY)
        orbit = bearing.orbit(course_of(time, pressed), course_of(time, relative[surface]), time)
        found[surface] = shown / clearance, orbit / clearance
        apart = np.linalg.norm((shown - orbit) / clearance, axis=1)
        thinnest = [clearance - np.linalg.norm(one, axis=1).max() for one in (shown, orbit)]
        told = ", ".join(f"{1e6 * one:.2f} um" for one in thinnest)
        print(f"{surface}: apart by {np.sqrt(np.mean(apart**2)):.4f} rms, thinnest {told}")
    return found


def are_near(results, apart, share, eccentric=0.0):
    """Assert the rms distance of both orbits in clearances, and their thinnest films."""
    for shown, orbit in orbits(results).values():
        largest = [np.linalg.norm(one, axis=1).max() for one in (shown, orbit)]
        assert largest[0] > eccentric
        assert np.sqrt(np.mean((shown - orbit) ** 2) * 2) < apart
        assert 1 - largest[0] == pytest.approx(1 - largest[1], rel=share)


def test_journals_go_the_way_of_the_mobility_method_under_their_loads(tmp_path):
    """Orbits agree with those of the mobility method to 2 % of the clearance.

    The engine is fired, the bearings are smooth and have their finite length. Pressure below zero
    is cut off, as in the method. The loads come from the run. The rest comes from the run's steps
    of a degree, with squeeze and position at their ends, and from its 6 cells along.
    """
    changes = []
    for name in CRANK:
        own = f"participants.{name}.parameters"
        changes += [(f"{own}.cavitation_model", "gumbel"), (f"{own}.roughness_rms", "0 um")]
    results = computed(
        small_crank(BEFORE_FIRING, *changes, crank=(96, 6), stop="120 deg"), tmp_path / "cut.h5"
    )
    are_near(results, 2e-2, 5e-2, eccentric=0.9)


@pytest.mark.slow
def test_the_shipped_case_beside_the_mobility_method(tmp_path):
    """Orbits of the whole cycle agree to a tenth of the clearance, thinnest films to 15 %.

    The run's films conserve their oil and are fed by slots.
    """
    tree = read_tree(PATH) | {"record": {"every": 100}, "pictures": []}
    results = computed(tree, tmp_path / "shipped.h5")
    are_near(results, 0.1, 0.15)


def test_gas_and_inertia_pass_through_all_bearings(results_of):
    """The eye, the big end and the main bearing carry the forces of Newton's law for rod and crank.

    Their centres are those of a mechanism without play. Films give way by micrometres. This motion
    adds little acceleration: the forces agree to 2 % of the largest force.
    """
    six = results_of("crank_bearings")
    eye, big, main = (course(six, f"{name}_force") for name in ("small_end", *CRANK.values()))
    angle = six.series("bodies.crank_angle").values
    r, w, k = RADIUS, SPEED, 72 / 223

    def pin_and_centre(angle):
        turn, _ = rod_motion(angle)
        pin = r * np.column_stack([-np.sin(angle), np.cos(angle)])
        return pin, pin + k * LENGTH * np.column_stack([-np.sin(turn), np.cos(turn)])

    # rows have unequal steps; a second difference over 2 mrad is good to 1e-6
    turned = 1e-3
    (_, before), (pin, now), (_, after) = map(
        pin_and_centre, (angle - turned, angle, angle + turned)
    )
    thrown = w**2 * (before - 2 * now + after) / turned**2
    given = slice(40, -3)  # the start's films settle
    scale = np.abs(big).max()
    np.testing.assert_allclose((eye + big)[given], (1.7 * thrown)[given], atol=2e-2 * scale)
    unbalanced = 0.0414 * w**2 * pin / r  # against its centripetal acceleration
    np.testing.assert_allclose((big + main)[given], unbalanced[given] * -1, atol=2e-2 * scale)


def test_the_exported_fmu_of_six_films_gives_the_values_of_the_run(tmp_path):
    """An importer that steps the FMU of bodies and six films repeats the recorded run.

    By name the film of the big end comes before the bodies, but it starts after them. Its first gap
    is therefore that of the bodies.
    """
    tree = small_crank(stop="6 deg")
    results = computed(tree, tmp_path / "run.h5")
    exported = FmuParticipant("coupled", export(tree, PATH))
    exported.start({}, 0.0, 1.0)
    for begin, end in pairwise(results.time):
        exported.step(begin, end - begin)
    for name in ("big_end_displacement_y", "main_bearing_force_x", "crank_torque"):
        values = results.series(f"bodies.{name}").values
        assert exported.get(name) == pytest.approx(values[-1], rel=1e-6)
