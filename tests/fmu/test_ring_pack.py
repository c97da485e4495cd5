"""The ring pack in models/ring_pack: numbers by hand, and coupled with film and bodies."""

from math import exp, pi, sqrt

import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

from .runs import coarse, module_of

PATH = find_case("ring_pack")
VALUES = dict(
    cylinder_pressure=2e6,
    piston_velocity=-3.0,
    lateral_velocity=0.05,
    rocking_velocity=-2.0,
    bore=0.08,
    height=0.02,
    elastic_load=900.0,
    gas_width=1.2e-3,
    gas_depth=2.5e-3,
    viscosity=8e-3,
    boundary_friction=0.12,
    groove_friction=0.09,
    mixed_velocity=1.5,
    creep_velocity=1e-6,
    groove_creep_velocity=1e-6,
)


def forces(**changed):
    """Return the outputs of the pack."""
    return module_of(PATH.parent / "ring_pack.py")._forces(VALUES | changed)


def test_numbers_by_hand():
    """The forces and the power of the pack equal values computed by hand.

    W' = 900 + 1.2e-3 2e6 = 3300 N/m; grooves move at 0.05 + 0.02 2 = 0.09 m/s; flanks carry
    pi 0.08 2.5e-3 2e6 = 1256.6 N. The tolerance of 1e-9 is due to creep velocities of 1e-6 m/s.
    """
    o = forces()
    rubbing = 0.12 * exp(-2.0) * 3300.0
    shear = 0.7726 / sqrt(0.1589) * sqrt(8e-3 * 3.0 * 3300.0)
    assert o["axial_force"] == pytest.approx(
        pi * 0.08 * (rubbing + shear), rel=2e-3
    )  # C is rounded
    assert o["side_force"] == pytest.approx(-0.09 * pi * 0.08 * 2.5e-3 * 2e6, rel=1e-9)
    assert o["moment"] == pytest.approx(-0.02 * o["side_force"], rel=1e-12)
    power = 3.0 * o["axial_force"] - 0.09 * o["side_force"]
    assert o["friction_power"] == pytest.approx(power, rel=1e-12)


def test_friction_turns_with_the_motion_and_takes_energy():
    back = forces(piston_velocity=3.0, lateral_velocity=-0.05, rocking_velocity=2.0)
    forth = forces()
    for name in ("axial_force", "side_force", "moment"):
        assert back[name] == -forth[name]
    assert back["friction_power"] == forth["friction_power"] > 0.0


def test_without_gas_only_tension_rubs():
    o = forces(cylinder_pressure=-2e4)
    assert o["side_force"] == 0.0 and o["axial_force"] > 0.0


def test_the_pack_acts_on_the_piston_in_the_same_macro_step(tmp_path):
    """The forces of the pack are those of the motion at the end of the same step.

    They slow the piston in a dozen degrees after firing, and agree to the tolerance of the wires.
    In creep, 4.5 kN on the flanks rub with 0.1/2e-3 N s/m per newton. The wires let 1e-6 m/s pass,
    and 1e-4 rad/s at 23 mm: 0.75 N.
    """
    start = ("participants.bodies.parameters.start_crank_angle", "5 deg")
    small = coarse(start, ("time.stop", "12 deg"), modes=None)
    speeds = {}
    for label, changes in (("rings", []), *read_tree(PATH)["variants"].items()):
        tree = read_tree(PATH, [*small, *dict(changes).items()])
        case, output = check_case(tree, PATH), tmp_path / f"{label}.h5"
        system = open_system(case, PATH.parent, print)
        assert run(system, case, tree, output)["unconverged_steps"] == 0
        results = Results(output)
        speeds[label] = results.series("bodies.lateral_velocity").values
        moving = ("piston_velocity", "lateral_velocity", "rocking_velocity", "cylinder_pressure")
        given = {n: v for n, v in system.parameters["rings"].items() if n in VALUES}
        given |= {"boundary_friction": 0.1, "groove_friction": 0.1, "mixed_velocity": 0.5}
        given |= {"creep_velocity": 0.1, "groove_creep_velocity": 2e-3}
        for k in range(1, 13):
            now = {name: results.series(f"bodies.{name}").values[k] for name in moving}
            want = forces(**given, **now)
            for name, apart in (("side_force", 0.75), ("axial_force", 0.1), ("moment", 0.02)):
                got = results.series(f"rings.{name}").values[k]
                assert got == pytest.approx(want[name], rel=1e-3, abs=apart)
    assert abs(speeds["rings"][-1]) < abs(speeds["without"][-1])
