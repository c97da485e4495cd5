"""Virtual work of every force element, at random motions and under random forces.

The accelerations of the FMU's model are those of a multibody program in absolute coordinates
(`multibody`), whose forces do work on the velocities of the cells, one by one. Both solve
M a = Q for forces of any size on every cell. Equal accelerations mean equal work along every
coordinate.
"""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.dynamics.pin_shells import shell_modes_of
from piston_cosim.fmu_mfbd.dynamics.system import RingForce
from piston_cosim.fmu_mfbd.force_elements.land_contact import LandParameters
from piston_cosim.fmu_mfbd.geometry.pin import PinForces
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED, BlockMotion
from piston_cosim.fmu_mfbd.mechanism.cylinder import EYE

from .multibody import QUARTER, Rubbing, Touching
from .test_multibody import BORE, CASES, CONCENTRIC, SPEED, START, P, Reference, fmu_model

RUBBED = dataclasses.replace(P, pin_friction_coefficient=0.1, pin_friction_damping=0.02)
ANGLE, GAS = 0.7, 3e5
TIME = (ANGLE - START) / SPEED
CARRIER = BlockMotion(30.0, -40.0, 900.0, 1.3)
LAND = LandParameters(1e7, 0.2, 0.0, 0.03)
"""The top land touches the bore in all of the random motions."""
RINGS = RingForce(40.0, -60.0, 0.3)
SKIRT, ROLL = 2, 1
"""Number of coordinates of the piston, index of the rocking angle."""


def random_motion(case, model, rng):
    """Return position and velocity: plays of tens of micrometres, tilts of milliradians."""
    n = model.coordinates
    position, velocity = 5e-5 * rng.standard_normal(n), 0.3 * rng.standard_normal(n)
    position[ROLL] *= 30.0
    if case.floats:
        position[6] *= 1e4
        velocity[6] *= 10.0
    return position, velocity


class Split:
    """Coordinates of the FMU by their names, (2,) or (k,)."""

    def __init__(self, case, values):
        parts = iter(np.split(values, np.cumsum(self.sizes(case))[:-1]))
        self.x, self.roll, self.boss, self.eye, self.spin, self.big_end, self.main = (
            next(parts) for _ in range(7)
        )
        self.piston, self.block, self.shapes, self.shell = (next(parts) for _ in range(4))

    @staticmethod
    def sizes(case):
        plays = [2 * case.floats, 2 * case.floats, case.floats, 2 * case.crank, 2 * case.crank]
        return [1, 1, *plays, 3, 2 * case.block_modes, 6 * case.bends, 4 * case.bends]


def pair(values):
    """Return a play, zeros without it."""
    return values if len(values) else np.zeros(2)


def absolute(reference, case, position, velocity, carrier):
    """Return positions and velocities of all bodies; the block turns about the origin."""
    q, v = (np.zeros(reference.system.size) for _ in range(2))
    now, rate = Split(case, position), Split(case, velocity)
    arm = P.crank_radius * np.array([-np.sin(ANGLE), np.cos(ANGLE)])
    journal, moving = pair(now.main), pair(rate.main)
    big_end = journal + arm - pair(now.big_end)
    big_moving = moving + SPEED * QUARTER @ arm - pair(rate.big_end)
    A_x = CONCENTRIC + now.x[0]
    eye_x = A_x + pair(now.boss)[0] - pair(now.eye)[0]
    aside = eye_x - big_end[0]
    rise = np.sqrt(P.rod_length**2 - aside**2)
    eye_vx = rate.x[0] + pair(rate.boss)[0] - pair(rate.eye)[0]
    turning = -(eye_vx - big_moving[0]) / rise
    eye = np.array([eye_x, big_end[1] + rise])
    eye_moving = np.array([eye_vx, big_moving[1] + turning * aside])
    pin, pin_moving = eye + pair(now.eye), eye_moving + pair(rate.eye)
    spin = (now.spin[0], rate.spin[0]) if case.floats else (0.0, 0.0)
    for name, place, turn, speed, rotating in (
        ("crank", journal, ANGLE, moving, SPEED),
        ("rod", big_end, -np.arcsin(aside / P.rod_length), big_moving, turning),
        ("pin", pin, spin[0], pin_moving, spin[1]),
        ("piston", pin - pair(now.boss), now.roll[0], pin_moving - pair(rate.boss), rate.roll[0]),
    ):
        first = reference.of[name].first
        q[first : first + 3] = (*place, turn)
        v[first : first + 2] = speed + carrier.w * QUARTER @ place
        v[first + 2] = rotating + carrier.w
    if not case.floats:
        v[reference.of["pin"].first + 2] = 0.0
    v[2] = carrier.w
    bodies = {"piston": "piston", "block": "block", "pin": "shapes", "rod": "shell"}
    for name, part in bodies.items():
        body = reference.of[name]
        own = slice(body.first + 3, body.first + body.size)
        q[own], v[own] = getattr(now, part), getattr(rate, part)
    return q, v


def relative(reference, case, q, v, acceleration, carrier):
    """Return the accelerations of the FMU's coordinates, in the axes of the block."""

    def inside(name):
        first = reference.of[name].first
        place, moving = q[first : first + 2], v[first : first + 2]
        a = acceleration[first : first + 2]
        # Eq. (K14)
        a = a - [carrier.ax, carrier.ay] - carrier.alpha * QUARTER @ place + carrier.w**2 * place
        return a - 2 * carrier.w * QUARTER @ (moving - carrier.w * QUARTER @ place)

    def turned(name):
        return acceleration[reference.of[name].first + 2] - carrier.alpha

    def modal(name):
        body = reference.of[name]
        return acceleration[body.first + 3 : body.first + body.size]

    def at_end(name, length):
        """Return the acceleration of a point on the y axis of a body."""
        first = reference.of[name].first
        turn, speed = q[first + 2], v[first + 2] - carrier.w
        arm = length * np.array([-np.sin(turn), np.cos(turn)])
        return inside(name) + turned(name) * QUARTER @ arm - speed**2 * arm

    piston, pin = inside("piston"), inside("pin")
    out = [piston[0], turned("piston")]
    if case.floats:
        out += [*(pin - piston), *(pin - at_end("rod", P.rod_length)), turned("pin")]
    if case.crank:
        out += [*(at_end("crank", P.crank_radius) - inside("rod")), *inside("crank")]
    modes = (modal(name) for name in ("piston", "block", "pin", "rod"))
    return np.concatenate([out, *modes])


def solved(reference, case, carrier, q, v):
    """Return accelerations and multipliers; friction of a tied pin depends on the latter."""
    of, elements = reference.of, reference.system.elements
    joints = dict(zip(reference.rows, reference.system.constraints))
    given = dict(zip(("block_0", "block_1", "block_2", "drive"), (*carrier[:3], carrier.alpha)))
    for name, value in given.items():
        joints[name] = joints[name]._replace(acceleration=lambda time, value=value: value)
    reference.system.constraints = list(joints.values())
    if case.floats:
        return reference.system.solve(TIME, q, v)
    lever = RUBBED.pin_friction_coefficient * RUBBED.pin_radius
    rubbing = Rubbing(
        of["piston"], of["rod"], lever, RUBBED.pin_friction_speed, RUBBED.pin_friction_damping
    )
    elements["pin_friction"] = rubbing
    for _ in range(40):
        acceleration, held = reference.system.solve(TIME, q, v)
        rubbing.load = np.linalg.norm(held[reference.rows["boss"]])
    del elements["pin_friction"]
    return acceleration, held


@pytest.mark.parametrize("name", CASES)
def test_accelerations_and_reactions_under_random_forces(name):
    """Films, gas, rings, pin friction, land and the motion of the block act at random motions.

    The tolerance of 1e-11 of the largest value is the round-off of constraints whose rods are 1e4
    times as long as the plays. Modes of the bore are stored in single precision, which leaves 1e-8.
    The land is pressed by 1 um or more, of which positions in the engine leave 1e-10.
    """
    case = CASES[name]
    limit = 1e-8 if case.block_modes else 1e-11
    model = fmu_model(case, RUBBED, (LAND,))
    rng = np.random.default_rng(7)
    for _ in range(3):
        position, velocity = random_motion(case, model, rng)
        films = [
            (50 * rng.random(one.shape), 20 * rng.standard_normal(one.shape))
            for one in (*model.films, *model.grids)
        ]
        carrier = CARRIER if case.moves else FIXED
        (push, drag), *pins = films
        forces = tuple(PinForces(*one) for one in pins)
        inputs = Inputs(SPEED, GAS, push, drag, RINGS, pins=forces, carrier=carrier)
        state, out = model.start_moving(ANGLE, position, velocity, inputs)
        reference = Reference(case)
        elements = reference.system.elements
        q, v = absolute(reference, case, position, velocity, carrier)
        names = [one for one in elements if one != "gas"]
        for film, given in zip(names, films, strict=True):
            elements[film].given = tuple(one.ravel() for one in given)
        elements["gas"].force = lambda time: GAS * np.pi * BORE**2
        elements["gas"].rings = RINGS
        of, land = reference.of, vars(LAND)
        touching = (land[f"land_{one}"] for one in ("clearance", "stiffness", "damping"))
        elements["land"] = Touching(
            of["piston"], of["block"], LAND.land_height, CONCENTRIC, *touching
        )
        acceleration, held = solved(reference, case, carrier, q, v)
        known = relative(reference, case, q, v, acceleration, carrier)
        assert np.abs(state.acceleration - known).max() < limit * np.abs(known).max()
        reactions = reference.outputs(TIME, q, v, held)
        if case.bends:
            out["eye"] = shell_modes_of(model.chain.elements, position, EYE)
        size = max(np.abs(reactions[one]).max() for one in reactions)
        for one, value in reactions.items():
            np.testing.assert_allclose(out[one], value, rtol=0.0, atol=limit * size, err_msg=one)
        _, power = elements["land"].forces(TIME, q, v)
        assert out["element_power"] == pytest.approx(power, rel=1e-9) != 0.0
