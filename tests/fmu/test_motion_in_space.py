"""The rigid piston of `data_sheet` moving in space on its film: the plane as the symmetric case,
work and oil of a lopsided one, the built FMU, what is refused.
"""

from functools import partial

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from piston_cosim.master.case.check import check
from piston_cosim.master.case.contract import check_fmu
from piston_cosim.master.case.reading import find_case, read_tree

from .runs import build_of, coarse, is_sound, make, run_tree

PATH = find_case("data_sheet")
computed = partial(run_tree, PATH)
SPACE = "participants.bodies.build.motion_in_space"
MOMENTS = {"inertia_x": "0.0033 kg*m^2", "inertia_y": "0.0029 kg*m^2"}
TILT = ("participants.bodies.parameters.pin_tilt", "0.5 mrad")
ACROSS = ("pin_axis_displacement", "roll_angle", "yaw_angle")


def small(*changes, stop):
    """The case on a coarse grid, nothing drawn."""
    tree = read_tree(PATH, coarse(("time.stop", stop), *changes, grid=(24, 12), modes=None))
    return {**tree, "record": {"every": 100}, "pictures": []}


def test_symmetric_loads_move_the_piston_in_its_plane(tmp_path):
    """60 deg, in as many iterations: accelerations are solved to 1e-11, and a film makes 1e-7 of a
    force of what that is of its thickness; 5e-7 of each range. The film is even about z = 0 to some
    1e-4 N of a thousand, so that shift, roll and yaw stay within 2e-12 m or rad; allowed 2e-11.
    """
    flat = computed(small(stop="60 deg"), tmp_path / "flat.h5")
    space = computed(small((SPACE, MOMENTS), stop="60 deg"), tmp_path / "space.h5")
    assert flat.summary["mean_iterations"] == space.summary["mean_iterations"]
    for name in ("lateral_displacement", "rocking_angle", "side_force", "crank_torque"):
        one, other = (each.series(f"bodies.{name}").values for each in (flat, space))
        np.testing.assert_allclose(other, one, rtol=0, atol=5e-7 * np.ptp(one), err_msg=name)
    for name in ACROSS:
        assert np.abs(space.series(f"bodies.{name}").values).max() < 2e-11


@pytest.fixture(scope="module")
def lopsided(tmp_path_factory):
    """A pin that is not square and a centre of mass 1 mm beside the plane, over the firing."""
    table = MOMENTS | {"centre_z": "1 mm"}
    tree = small((SPACE, table), TILT, stop="400 deg")
    return computed(tree, tmp_path_factory.mktemp("space") / "space.h5")


def test_work_and_oil_of_a_lopsided_piston(lopsided):
    """Work of the film on the grid is that in the coordinates, to round-off."""
    is_sound(lopsided)
    assert lopsided.series("bodies.interface_work_error").values.max() < 1e-13
    summary = lopsided.summary
    print({key: summary[key] for key in summary if "iterations" in key or "imbalance" in key})


def test_a_tilted_pin_moves_and_pushes_its_piston_along(lopsided):
    """The pin's inertia forces and its film's, of kilonewtons, lean by half a mrad, on a film that
    gives way where the skirt is oval; roll leaves where the eye holds it by what its play allows.
    """
    shift, roll, yaw = (lopsided.series(f"bodies.{name}").values for name in ACROSS)
    print([(one.min(), one.max()) for one in (shift, roll, yaw)])
    assert all(np.isfinite(one).all() for one in (shift, roll, yaw))
    assert 1e-6 < np.ptp(shift) < 200e-6
    assert 1e-5 < np.ptp(roll) < 3e-3
    assert np.ptp(yaw) < 3e-3
    force = lopsided.series("bodies.pin_axis_side_force").values
    assert np.abs(force).max() > 5.0


def test_the_built_fmu_keeps_the_contract():
    fmu = make(*build_of(small((SPACE, MOMENTS), stop="1 deg"), PATH, "bodies"))
    assert validate_fmu(str(fmu)) == []
    assert check_fmu(fmu)[:2] == ("bodies", [])


def test_what_cannot_move_in_space_is_refused():
    crank = ("participants.bodies.parameters.crank_free", 1)
    told = check("data_sheet", [(SPACE, MOMENTS), crank]).faults
    assert any("crank_free: expected 0 with motion in space" in fault for fault in told)
    (fault,) = check("data_sheet", [(SPACE, {"inertia_x": "0.0033 kg*m^2"})]).faults
    assert "inertia_y: expected a value" in fault
    assert check("data_sheet", [(SPACE, MOMENTS), TILT]).faults == []
