"""Two cylinders in one flexible block, built as FMUs: the rigid block as its limit, momentum and
work, a run that was cut in two.
"""

from functools import cache

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedMonoblock, load
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.fmi.builder import import_part

from .runs import run_tree, stopped
from .shipped import FLEXIBLE_TWIN as PATH
from .shipped import TWIN, flexible_twin
from .test_resume import compare

NAMES = ("front", "rear")


def computed(tree, out, path=PATH):
    """Results of a tree, every step converged."""
    results = run_tree(path, tree, out)
    assert results.summary["unconverged_steps"] == 0
    return results


def of(results, name):
    return results.series(name).values


@cache
def block():
    """The case's block, reduced."""
    build = read_tree(PATH)["participants"]["block"]["build"]
    prepare = import_part("fmu_mfbd.monoblock.build").prepare
    _, (file,) = prepare(build, PATH.parent, lambda text: None)
    return load(ReducedMonoblock, file)


def test_interface_newton_and_what_it_leaves(results_of):
    """All five participants by their own derivatives: as many iterations as a rigid block's twin
    takes, one more while the modes ring after the start; what film and bodies say of their work.
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


def test_a_stiff_block_is_the_rigid_twin(tmp_path):
    """A million times the modulus against the case `twin` with the same mass, centre, inertia and
    mounts: what 2 um of deflection over a million leave, and Newton's tolerance of 1 nm on films
    that move by micrometres.
    """
    tree = flexible_twin("6 deg")
    own = tree["participants"]["block"]
    own["build"]["young"] = "110000000 GPa"
    rigid = flexible_twin("6 deg", TWIN)
    for wire in (*tree["wires"], *rigid["wires"]):
        if wire["to"].endswith("film_thickness"):
            wire["tolerance"] = "1e-3 nm"
    stiff = computed(tree, tmp_path / "stiff.h5")
    mass = block().rigid_mass
    weight = float(mass[0, 0])
    height = float(-mass[0, 5] / weight)
    about = np.diag(mass)[3:] - weight * height**2 * np.array([1.0, 0.0, 1.0])
    parameters = {
        "mass": f"{weight!r} kg",
        "centre_x": "0 m",
        "centre_y": f"{height!r} m",
        "centre_z": "0 m",
        **{f"inertia_{axis}": f"{one!r} kg*m^2" for axis, one in zip("xyz", about.tolist())},
        "cylinder_z": own["build"]["cylinder_z"],
        **{
            f"mount_{axis}": [f"{one!r} m" for one in column.tolist()]
            for axis, column in zip("xyz", block().mount_place.T)
        },
        **{
            f"stiffness_{axis}": [
                own["parameters"][f"mount_{k}_stiffness_{axis}"] for k in (1, 2, 3, 4)
            ]
            for axis in "xyz"
        },
        "damping_time": own["parameters"]["damping_time"],
    }
    rigid["participants"]["block"]["parameters"] = parameters
    for name in NAMES:
        for key in ("bore_lower", "bore_upper"):
            given = tree["participants"][name]["build"]["block"][key]
            rigid["participants"][name]["build"]["block"][key] = given
    wanted = computed(rigid, tmp_path / "rigid.h5", TWIN)
    for name in (
        "front.lateral_displacement",
        "rear.rocking_angle",
        "front.side_force",
        "block.displacement_x",
        "block.rotation_x",
        "block.mount_force_y",
    ):
        a, b = of(stiff, name), of(wanted, name)
        assert np.abs(a - b).max() < 1e-5 * np.abs(b).max(), name


@pytest.mark.slow
def test_a_run_that_was_stopped_goes_on_with_the_same_bits(results_of, tmp_path):
    """With five participants, stopped in the middle."""
    tree, output = flexible_twin("24 deg"), tmp_path / "run.h5"
    tree["record"] |= {"checkpoint_every": 2}
    kept = stopped(PATH, tree, output, 1.2e-3)
    run_tree(PATH, tree, output, begin_at=kept)
    assert compare(results_of("flexible_twin").path, output) == []
