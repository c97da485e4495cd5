"""Two cylinders in one flexible block, built as FMUs: momentum and work."""

from functools import cache

import numpy as np

from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedMonoblock, load
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.fmi.builder import import_part

from .shipped import FLEXIBLE_TWIN as PATH

NAMES = ("front", "rear")


def of(results, name):
    return results.series(name).values


@cache
def block():
    """Return the case's block, reduced."""
    build = read_tree(PATH)["participants"]["block"]["build"]
    prepare = import_part("fmu_mfbd.monoblock.build").prepare
    _, (file,) = prepare(build, PATH.parent, lambda text: None)
    return load(ReducedMonoblock, file)


def test_interface_newton_and_what_it_leaves(results_of):
    """Interface Newton converges with the derivatives of all five participants.

    It takes as many iterations as with a rigid block, and one more while the modes ring after the
    start. Film and bodies report the error of their work.
    """
    flexible = results_of("flexible_twin")
    assert flexible.summary["unconverged_steps"] == 0
    assert not flexible.summary.get("derivatives_by_differences")
    iterations = of(flexible, "coupling.iterations")[1:]
    assert iterations.max() <= 6
    assert iterations.mean() <= 4
    assert abs(flexible.summary["interface_work_imbalance"]) < 1e-6
    for name in NAMES:
        assert np.abs(of(flexible, f"{name}.interface_work_error")).max() < 1e-13
    assert of(flexible, "block.largest_bore_deflection").max() > 1e-6


def test_momentum_of_the_block(results_of):
    """What the block does not keep its mounts take, by the trapezoidal rule; modes have none."""
    flexible = results_of("flexible_twin")
    mass = block().rigid_mass
    step = np.diff(flexible.time)
    force = of(flexible, "block.shaking_force_y") - of(flexible, "block.mount_force_y")
    names = [f"block.{kind}_{axis}" for kind in ("velocity", "rotation_velocity") for axis in "xyz"]
    momentum = mass[1] @ np.array([of(flexible, name) for name in names])
    impulse = step * (force[1:] + force[:-1]) / 2
    impulse[0] = step[0] * force[1] / 2  # forces begin to act in the first step
    np.testing.assert_allclose(np.diff(momentum), impulse, atol=1e-8 * np.abs(impulse).max())
