"""Forces on the block of a floating pin and of a motion in space.

They are compared with the changes of momentum and angular momentum of all bodies. These use
positions and velocities only.
"""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.instant import of_skirt
from piston_cosim.fmu_mfbd.dynamics.motion_in_space import forces_on_block, imbalance, tangent
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.dynamics.pin_shells import play_at, shapes_of
from piston_cosim.fmu_mfbd.geometry.pin import turned
from piston_cosim.fmu_mfbd.mechanism.chain import BLOCK, NONE
from piston_cosim.fmu_mfbd.mechanism.cylinder import BODY, EYE, film_of
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.inertia import coupling_of
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion

from .pin_models import (
    MAIN,
    PARAMETERS,
    SETS,
    SPEED,
    UNBALANCE,
    all_that_yields,
    crank_model,
    rough_way,
)
from .test_crank_films import derivative, joints
from .test_motion_in_space import Points, load_on, space_bodies

INERTIA = Parameters().crank_inertia


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def piston_of_tables(chain):
    """Return the inertia integrals of the piston, the last body."""
    bodies = chain.bodies
    B, G = np.split(coupling_of(bodies, len(bodies.mass) - 1), 2)
    return SimpleNamespace(
        mass=bodies.mass[-1],
        S=bodies.S[-1],
        I0=bodies.I0[-1],
        T=bodies.T,
        b=bodies.b,
        B=B,
        g=bodies.g,
        G=G,
    )


def all_momentum(model, position, velocity, crank):
    """Return the momentum (2,) of everything that moves, and its angular momentum.

    The angular momentum is about the crank axis, without the crank's own rotation. Velocities are
    differences of positions. Modes of eye, big end and main bearing have no momentum (Eq. (D40)).
    """
    p, piston, chain = PARAMETERS, piston_of_tables(model.chain), model.chain
    play = [*chain.elements.play, NONE]  # the last one is that of no film
    in_big_end, in_main = play[film_of(chain, BODY.rod)], play[film_of(chain, BLOCK)]

    def at(t):
        q = position + t * velocity
        plays = play_at(in_big_end, q), play_at(in_main, q)
        return joints(q, crank.angle + t * crank.speed, *plays)

    (A, pin, rod, journal, u), _ = at(0.0)
    A_v, pin_v, rod_v, journal_v, u_v = derivative(lambda t: at(t)[0], 0.0, 1e-4)
    rod_turn = derivative(lambda t: at(t)[1], 0.0, 1e-4)
    w, axes = velocity[1], turned(position[1])
    parts, modes = model.model.parts, slice(2, 2 + len(piston.g))
    q, dq = of_skirt(parts, position)[modes], of_skirt(parts, velocity)[modes]
    s = axes @ (piston.S + piston.T @ q)
    s_v = w * np.array([-s[1], s[0]]) + axes @ piston.T @ dq
    spread = piston.I0 + 2 * piston.b @ q + q @ piston.B @ q
    in_frame = spread * w + (piston.g + piston.G @ q) @ dq
    thrown, thrown_v = (UNBALANCE * model.unbalanced * one for one in (u, u_v))
    mass = MAIN.crank_mass if in_main >= 0 else 0.0
    momentum = piston.mass * A_v + s_v + p.pin_mass * pin_v + p.rod_mass * rod_v
    momentum = momentum + mass * journal_v + thrown_v
    bent, bent_v = (
        shapes_of(chain.elements, position, EYE),
        shapes_of(chain.elements, velocity, EYE),
    )
    shapes = sum(cross(*two) for two in zip(bent, bent_v))
    return np.array(
        [
            *momentum,
            cross(A, piston.mass * A_v + s_v)
            + cross(s, A_v)
            + in_frame
            + p.pin_mass * cross(pin, pin_v)
            + chain.bodies.I0[BODY.pin] * velocity[6]
            + shapes
            + p.rod_mass * cross(rod, rod_v)
            + p.rod_inertia * rod_turn
            + cross(journal, mass * journal_v + thrown_v)
            + cross(thrown, journal_v),
        ]
    )


def yields():
    """Return a model of a bending pin in elastic bosses and eye, without damping.

    Dampers of its shapes would act against space.
    """
    undamped = dataclasses.replace(PARAMETERS, damping_ratio=0.0, high_frequency_damping_ratio=0.0)
    return all_that_yields(undamped)


MODELS = {
    "pin": lambda: crank_model(()),
    **{"+".join(names): lambda names=names: crank_model(names) for names in SETS},
    "flexible": lambda: crank_model(yielding=True),
    "bending": yields,
}


def made(name):
    model = MODELS[name]()
    model.unbalanced = model.model.settings.crank_unbalance / UNBALANCE
    return model


@pytest.mark.parametrize("name", MODELS)
def test_block_and_drive_change_the_momentum_of_all_bodies(name):
    """Force and moment on the block and the drive change the momentum of all bodies.

    All films have rough forces. The crank is unbalanced and speeds up.
    Differences of sixth order leave 1e-9 of the largest term, as for the equations of motion.
    """
    model = made(name)
    _, out = rough_way(model, 6)
    now, crank = model._last.now, model._last.crank

    def at(t):
        position = now.position + t * now.velocity + t**2 / 2 * now.acceleration
        velocity = now.velocity + t * now.acceleration
        angle = crank.angle + t * crank.speed + t**2 / 2 * crank.acceleration
        turning = CrankMotion(angle, crank.speed + t * crank.acceleration, 0.0)
        return all_momentum(model, position, velocity, turning)

    change = derivative(at, 0.0, 2e-5)
    drive = out["crank_torque"] - INERTIA * crank.acceleration
    force = np.array([out["force_on_block_x"], out["force_on_block_y"]])
    size = np.abs([out["main_bearing_force_x"], out["main_bearing_force_y"]]).max()
    np.testing.assert_allclose(force, -change[:2], atol=1e-8 * size)
    arm = PARAMETERS.rod_length
    assert out["moment_on_block"] == pytest.approx(drive - change[2], abs=1e-8 * size * arm)
    assert np.abs(force).min() > 1e-3 * size


def missed_in_space(size, direction):
    """Return the error of forces and moments on the block, and the reference, both (6,).

    The reference is the points' change of momentum and of angular momentum about the crank axis.
    Accelerations are those of the model. The cylinder is 3 mm off the crank axis.
    """
    of = Points(size)
    crank = CrankMotion(0.3, SPEED, 0.0)
    begin = crank.angle / SPEED
    of.rates(begin, size * direction)  # sets where it is pushed
    bodies, load = space_bodies(of, 3e-3), load_on(of)
    aside = np.array([3e-3, 0.0, 0.0, 0.0, 0.0])
    bodies = bodies._replace(pin_offset=2e-3)
    plane = load.plane
    load = load._replace(
        plane=plane._replace(lateral=plane.lateral - 800.0, axial=plane.axial + 700.0)
    )
    position, velocity = np.split(size * direction, 2)
    now = Motion(position, velocity, np.zeros(5))
    for _ in range(20):
        lack = imbalance(bodies, load, now, crank)
        slope = tangent(bodies, load, now, crank, 0.0, 0.0)
        change = np.linalg.solve(slope, lack.residual)
        now = now._replace(acceleration=now.acceleration - change)
    on, (force_z, *across) = forces_on_block(bodies, load, now, lack)
    about_z = on.moment_on_block - lack.torque
    found = on.force_on_block_x, on.force_on_block_y, force_z, *across, about_z
    masses = np.array([*of.masses, 0.25, 0.25, 0.85, 0.85])[:, None]

    def momentum(t):
        q = aside + position + t * velocity + t**2 / 2 * now.acceleration
        dq = velocity + t * now.acceleration
        places = of.all(q, begin + t)[: len(masses)]
        moving = masses * of.velocity(q, dq, begin + t)[: len(masses)]
        return np.concatenate([moving.sum(axis=0), np.cross(places, moving).sum(axis=0)])

    change = derivative(momentum, 0.0, 1e-5)
    return found + change, change


def test_a_piston_in_space_pushes_its_block_as_its_points_do():
    """What equations of first order in the tilt miss falls to a quarter with its half."""
    sizes = [1e-4, 5e-3, 3e-3, 1e-1, 8e-2, 0.3, 2.0, 4.0, 60.0, 40.0]
    direction = np.random.default_rng(3).standard_normal(10) * sizes
    (coarse, _), (fine, change) = (missed_in_space(size, direction) for size in (4e-2, 2e-2))
    assert (np.abs(coarse / fine) > 3.9).all()
    assert (np.abs(fine) < 2e-3 * np.abs(change)).all()
