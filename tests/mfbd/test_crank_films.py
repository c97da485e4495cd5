"""Films of the crank in the rod's big end and in the main bearing.

Equations are compared with Newton's law of moving points. Films and closed forms are computed by
hand. The rod without play is the stiff limit.
"""

import dataclasses

import numpy as np
import pytest
from pydantic import ValidationError

from piston_cosim.fmu_mfbd.dynamics.model_faults import faults
from piston_cosim.fmu_mfbd.geometry.pin import PinForces, PinResultants
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED
from piston_cosim.fmu_mfbd.mechanism.equations import chain_forces
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.piston_motion import Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion
from piston_cosim.fmu_mfbd.options import Common

from .chains import loads_of
from .pin_models import (
    CENTRE,
    MAIN,
    OFFSET,
    OWN,
    PARAMETERS,
    SETS,
    SPEED,
    UNBALANCE,
    Springs,
    bodies,
    crank_model,
    crank_options,
    floating_model,
    rough_inputs,
)

with_none = pytest.mark.parametrize(
    "names", [(), *SETS], ids=lambda names: "+".join(names) or "none"
)


def joints(q, angle, b, m):
    """Return A, pin, rod centre, crank journal, crank direction and rod angle.

    The direction is from the journal to the crank pin. Crank pin and journal are at b and m from
    the axes of their shells.
    """
    p = PARAMETERS
    u = np.array([-np.sin(angle), np.cos(angle)])
    big_end = m + p.crank_radius * u - b
    eye_x = q[0] + q[2] - q[4] + OFFSET - p.crank_offset
    rise = np.sqrt(p.rod_length**2 - (eye_x - big_end[0]) ** 2)
    pin = np.array([eye_x, big_end[1] + rise]) + q[4:6]
    along = np.array([eye_x - big_end[0], rise]) / p.rod_length
    return np.array([pin - q[2:4], pin, big_end + p.rod_centre * along, m, u]), -np.arcsin(along[0])


class Points:
    """The mechanism in space as mass points and rotating rods.

    Its coordinates are x_A, rocking angle, pin from bosses, pin from eye and angle of the pin. Then
    follow crank pin from big end and journal from main bearing. The angle of the crank is separate.
    """

    def __init__(self, names):
        self.names = names

    def places(self, q, angle):
        """Return positions of centres and of journals from their shells' axes, and angles.

        The centres are those of piston, pin, rod and crank (4 kg). The angles are those of piston,
        pin and rod.
        """
        play = dict(zip(self.names, q[7:].reshape(-1, 2)))
        b, m = (play.get(name, np.zeros(2)) for name in ("big_end", "main_bearing"))
        (A, pin, rod, _, u), psi = joints(q, angle, b, m)
        c, s = np.cos(q[1]), np.sin(q[1])
        piston = A + np.array([[c, -s], [s, c]]) @ CENTRE
        crank = m + UNBALANCE / MAIN.crank_mass * u
        return np.array([piston, pin, rod, crank]), np.array([q[1], q[6], psi])

    def inertias(self):
        p = PARAMETERS
        crank = MAIN.crank_mass if "main_bearing" in self.names else 0.0
        return (
            np.array([1.39, p.pin_mass, p.rod_mass, crank]),
            np.array([0.003, p.pin_mass * p.pin_radius**2 / 2, p.rod_inertia]),
        )


def derivative(f, x, h):
    """By central differences of sixth order."""
    weights = {1: 0.75, 2: -0.15, 3: 1 / 60}
    return sum(w * (f(x + k * h) - f(x - k * h)) for k, w in weights.items()) / h


def second_derivative(f, x, h):
    weights = {1: 1.5, 2: -0.15, 3: 1 / 90}
    terms = (w * (f(x + k * h) - 2 * f(x) + f(x - k * h)) for k, w in weights.items())
    return sum(terms) / h**2


def some_motion(names, seed=4):
    """Play of micrometres to millimetres, all of it in motion."""
    rng = np.random.default_rng(seed)
    n = 7 + 2 * len(names)
    return Motion(1e-3 * rng.standard_normal(n), rng.standard_normal(n), 300 * rng.random(n))


@with_none
def test_equations_of_motion_against_newtons_law_of_every_body(names):
    """Residual and torque follow from inertia forces and loads of a motion with given derivatives.

    Accelerations of all centres of mass are differences in time. Virtual work gives their inertia
    forces on every coordinate, and its directions are differences too. Forces of films and gas act
    likewise at their positions in their directions. Differences of sixth order leave 1e-9 of the
    largest term.
    """
    model = crank_model(names)
    points = Points(names)
    now = some_motion(names)
    crank = CrankMotion(0.7, 110.0, 900.0)
    rng = np.random.default_rng(5)
    films = {
        name: PinResultants(3e3 * rng.standard_normal(2), *rng.standard_normal(2))
        for name in ("bosses", "eye", *names)
    }
    load = Load(lateral=110.0, axial=-9e3, moment=1.5, axis_force=800.0, modal=np.zeros(0))
    loads = loads_of(model.chain, load, now, films.values())
    found = chain_forces(model.chain, loads, now, crank, FIXED)

    def at(t):
        q = now.position + t * now.velocity + t**2 / 2 * now.acceleration
        return points.places(q, crank.angle + t * crank.speed + t**2 / 2 * crank.acceleration)

    linear = second_derivative(lambda t: at(t)[0], 0.0, 2e-4)
    angular = second_derivative(lambda t: at(t)[1], 0.0, 2e-4)
    masses, moments = points.inertias()

    def pulled(k):
        """Inertia, films and load by virtual work along coordinate k, the last one the angle."""
        everything = np.append(now.position, crank.angle)
        way = np.eye(len(everything))[k]

        def along(e):
            moved = everything + e * way
            return points.places(moved[:-1], moved[-1])

        by_place = derivative(lambda e: along(e)[0], 0.0, 1e-3)
        by_angle = derivative(lambda e: along(e)[1], 0.0, 1e-3)
        demand = np.sum(masses[:, None] * linear * by_place) + moments @ (angular * by_angle)
        piston, pin, rod = by_angle
        turn = now.position[1]
        c, s = np.cos(turn), np.sin(turn)
        lever = np.array([[c, -s], [s, c]]) @ CENTRE
        of_A = by_place[0] - piston * np.array([-lever[1], lever[0]])
        given = of_A @ [load.lateral, load.axial]
        given += piston * (load.moment + load.axis_force * now.position[0])
        starts = {"bosses": 2, "eye": 4} | {name: 7 + 2 * j for j, name in enumerate(names)}
        shells = {"bosses": piston, "eye": rod, "big_end": rod, "main_bearing": 0.0}
        drive = float(k == len(now.position))
        journals = {"bosses": pin, "eye": pin, "big_end": drive, "main_bearing": drive}
        for name, film in films.items():
            given += way[starts[name] : starts[name] + 2] @ film.force
            given += film.on_pin * journals[name] + film.on_shell * shells[name]
        return demand - given

    wanted = np.array([pulled(k) for k in range(len(now.position) + 1)])
    scale = np.abs(found.residual).max()
    np.testing.assert_allclose(found.residual, wanted[:-1], atol=1e-9 * scale)
    # m e^2 w' of the unbalance about the journal is part of `crank_inertia`
    own = UNBALANCE**2 / MAIN.crank_mass * crank.acceleration * ("main_bearing" in names)
    assert found.torque == pytest.approx(wanted[-1] - own, rel=1e-8)


def test_gaps_and_velocities_by_hand():
    """Gaps and velocities of both crank films agree with hand calculations.

    The crank pin is 3 um right of the big end's middle and 4 um above it. The journal is 5 um left
    of the main bearing's middle and 2 um below it. The rod is inclined and its shell turns with it,
    so +x of the shell is at the rod's angle.
    """
    model = crank_model()
    state, _ = model.start(0.9, 0.0, 0.0, rough_inputs(model, 0, 0.0))
    position = state.position.copy()
    position[7:] = [3e-6, 4e-6, -5e-6, -2e-6]
    _, out = model.start_moving(0.9, position, state.velocity, rough_inputs(model, 0, 0.0))
    p = PARAMETERS
    # eye minus big end: both displacements go into the rod's angle, 8 um of 223 mm
    aside = OFFSET - p.crank_offset + p.crank_radius * np.sin(0.9) + 3e-6 + 5e-6
    psi = -np.arcsin(aside / p.rod_length)
    around = 2 * np.pi * np.arange(20) / 20
    wanted = 25e-6 - 3e-6 * np.cos(around + psi) - 4e-6 * np.sin(around + psi)
    np.testing.assert_allclose(out["big_end.film_thickness"][:, 2], wanted, atol=1e-17)
    rod_speed = -p.crank_radius * np.cos(0.9) * SPEED / np.sqrt(p.rod_length**2 - aside**2)
    np.testing.assert_allclose(
        out["big_end.circumferential_velocity"], 24e-3 * (SPEED - rod_speed), rtol=1e-12
    )
    around = 2 * np.pi * np.arange(16) / 16
    wanted = 30e-6 + 5e-6 * np.cos(around) + 2e-6 * np.sin(around)
    np.testing.assert_allclose(out["main_bearing.film_thickness"][:, 1], wanted, atol=1e-17)
    np.testing.assert_allclose(
        out["main_bearing.circumferential_velocity"], 27e-3 * SPEED, rtol=1e-14
    )
    for one in ("big_end", "main_bearing"):
        assert np.all(out[f"{one}.sliding_velocity"] == 0.0)
    shown = [out[f"{one}_displacement_{way}"] for one in OWN for way in "xy"]
    assert shown == [3e-6, 4e-6, -5e-6, -2e-6]


def test_a_crank_without_play_is_the_limit_of_stiff_films():
    """The difference to a crank without play halves with every doubling of the stiffness.

    Both models have springs K in the films of the pin, one has them in the films of the crank too.
    """
    compared = ("lateral_displacement", "rocking_angle", "side_force", "crank_torque")
    apart = [
        Springs(crank_model(), k).apart(Springs(floating_model(), k), 8, compared)
        for k in (64e9, 128e9, 256e9)
    ]
    rates = np.array(apart)
    assert rates[-1].max() < 2e-2
    np.testing.assert_allclose(rates[:-1] / rates[1:], 2.0, rtol=0.2)


def test_a_picometre_of_play_keeps_its_digits():
    """The crank pin moves by a picometre in the big end: the gap by as much, to six digits."""
    model = crank_model()
    state, _ = model.start(0.9, 0.0, 0.0, rough_inputs(model, 0, 0.0))
    gaps = []
    for more in (0.0, 1e-12):
        position = state.position.copy()
        position[7:9] = [20e-6 + more, 0.0]
        _, out = model.start_moving(0.9, position, state.velocity, rough_inputs(model, 0, 0.0))
        gaps.append(out["big_end.film_thickness"])
    change = gaps[1] - gaps[0]
    assert np.abs(change).max() == pytest.approx(1e-12, rel=0.05)
    wanted = np.array([np.max(np.abs(change @ np.ones(5))) / 5])
    assert wanted == pytest.approx(np.abs(change).max(), rel=1e-6)


def test_friction_of_the_crank_by_hand():
    """Friction of the crank films drives the shells, and cell forces push them outwards.

    Half a newton a cell acts against the rotation of crank pin and journal. One newton acts on the
    first cell, along the axes of rod and block. Two newtons act on the cell a quarter turn on.
    """
    model = crank_model()
    inputs = rough_inputs(model, 0, 0.0)
    drags = {f"{name}.": -0.5 for name in OWN}
    push = [np.zeros(one.shape) for one in model.grids]
    for one in push[3:]:
        one[0, 0], one[len(one) // 4, 0] = 1.0, 2.0
    pins = tuple(
        PinForces(on, np.full(one.shape, drags.get(one.prefix, 0.0)))
        for on, one in zip(push, model.grids)
    )
    _, out = model.start(0.9, 0.0, 0.0, dataclasses.replace(inputs, pins=pins))
    p = PARAMETERS
    lean = -np.arcsin((OFFSET - p.crank_offset + p.crank_radius * np.sin(0.9)) / p.rod_length)
    for name, angle in (("big_end", lean), ("main_bearing", 0.0)):
        force = [out[f"{name}_force_x"], out[f"{name}_force_y"]]
        c, s = np.cos(angle), np.sin(angle)
        np.testing.assert_allclose(force, [c - 2 * s, s + 2 * c], atol=1e-12)
    shown = [out[f"{name}_friction_moment"] for name in OWN]
    assert shown == pytest.approx([24e-3 * 100 * 0.5, 27e-3 * 64 * 0.5], rel=1e-12)


def test_what_does_not_go_with_films_of_the_crank_is_told():
    wrong = dataclasses.replace(PARAMETERS, rod_mass=0.0, rod_inertia=0.0)
    told = "\n".join(faults(bodies(), crank_options(("big_end",)), wrong))
    assert "rod_mass: expected more than 0 kg with a film in big_end, got 0 kg" in told
    assert "rod_inertia: expected more than 0 kg.m2 with a film in big_end, got 0 kg.m2" in told
    assert faults(bodies(), crank_options(SETS[-1]), PARAMETERS) == []
    beside = {"big_end": 25e-3, "main_bearing": 27.1e-3}
    (told,) = faults(bodies(), crank_options(SETS[-1]), PARAMETERS, [*OWN.values()], beside)
    assert told == "big_end_radius: expected within 2 % of the shell, 25 mm, got 24 mm"
    with pytest.raises(
        ValidationError, match=r"film_surfaces\.0\.name: expected a new name, got 'big_end'"
    ):
        Common.model_validate(
            {
                "floating_pin": {"boss_length": "20 mm", "small_end_length": "20 mm"},
                "big_end": {"length": "30 mm"},
                "film_surfaces": [{"name": "big_end", "rows": (1, 10)}],
            }
        )
