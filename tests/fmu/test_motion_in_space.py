"""The rigid piston of `data_sheet` moves in space on its film, symmetric and lopsided."""

import numpy as np

from .runs import run_tree
from .shipped import DATA_SHEET, MOMENTS, SPACE, tied

ACROSS = ("pin_axis_displacement", "roll_angle", "yaw_angle")

CONVERGED = ("wires.0.tolerance", "0.1 nm"), ("wires.1.tolerance", 1e-7)


def test_symmetric_loads_move_the_piston_in_its_plane(tmp_path):
    """Symmetric loads give the plane motion to 5e-7 of each range, in as many iterations.

    The run takes 30 deg. Accelerations are solved to 1e-11; a film turns that error in its
    thickness into 1e-7 of its force. The film is even about z = 0 to some 1e-4 N of a thousand.
    Shift, roll and yaw therefore stay within 2e-12 m or rad; the test allows 2e-11.
    """
    stop = ("time.stop", "30 deg"), *CONVERGED
    flat = run_tree(DATA_SHEET, tied(*stop), tmp_path / "flat.h5")
    space = run_tree(DATA_SHEET, tied(*stop, (SPACE, MOMENTS)), tmp_path / "space.h5")
    assert flat.summary["mean_iterations"] == space.summary["mean_iterations"]
    for name in ("lateral_displacement", "rocking_angle", "side_force", "crank_torque"):
        one, other = (each.series(f"bodies.{name}").values for each in (flat, space))
        np.testing.assert_allclose(other, one, rtol=0, atol=5e-7 * np.ptp(one), err_msg=name)
    for name in ACROSS:
        assert np.abs(space.series(f"bodies.{name}").values).max() < 2e-11


def test_a_tilted_pin_moves_and_pushes_its_piston_along(results_of):
    """A tilted pin shifts, rolls and yaws its piston.

    The pin's inertia forces and those of its film, of kilonewtons, lean by half a mrad. The film
    gives way where the skirt is oval. The roll leaves the position held by the eye as far as play
    allows.
    """
    lopsided = results_of("piston_in_space")
    # work of the film on the grid is that in the coordinates, to round-off
    assert lopsided.series("bodies.interface_work_error").values.max() < 1e-13
    shift, roll, yaw = (lopsided.series(f"bodies.{name}").values for name in ACROSS)
    print([(one.min(), one.max()) for one in (shift, roll, yaw)])
    assert all(np.isfinite(one).all() for one in (shift, roll, yaw))
    assert 1e-6 < np.ptp(shift) < 200e-6
    assert 1e-5 < np.ptp(roll) < 3e-3
    assert np.ptp(yaw) < 3e-3
    force = lopsided.series("bodies.pin_axis_side_force").values
    assert np.abs(force).max() > 5.0
