"""Forces of a motion in space on the block: changes of momentum and angular momentum of points."""

import numpy as np

from piston_cosim.fmu_mfbd.dynamics.motion_in_space import forces_on_block, imbalance, tangent
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion

from .differences import derivative
from .pin_models import SPEED
from .test_motion_in_space import Points, load_on, space_bodies


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
