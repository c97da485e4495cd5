"""models/floating_pin: four films on one piston, three of them of its pin; forces against closed
forms, powers, oil, the tied pin as the limit, a film's model among several.
"""

from functools import partial

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp

from piston_cosim.fmu_mfbd.geometry.pin import (
    PinForces,
    opening_of,
    pin_surface,
    resultants_on,
    turned,
)
from piston_cosim.master.case.check import check
from piston_cosim.master.case.contract import check_fmu, interface, swap_all
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.tests.verification.cases.bearings import (
    CLEARANCE,
    RADIUS,
    SPEED,
    VISCOSITY,
    bearing,
    short_load,
    steady,
)

from .runs import build_of, coarse, is_sound, make, pin_case, run_tree, values_of

PATH, DATA_SHEET = find_case("floating_pin"), find_case("data_sheet")
computed = partial(run_tree, PATH)
BEFORE_FIRING = ("participants.bodies.parameters.start_crank_angle", "-60 deg")
PINS = {"left_film": "boss_left", "right_film": "boss_right", "small_end_film": "small_end"}


small = partial(pin_case, PATH, PINS)


@pytest.mark.parametrize("eccentricity", [pytest.param(0.3, marks=pytest.mark.slow), 0.6])
def test_a_side_load_on_a_pin_is_that_of_the_short_bearing(eccentricity):
    """The lubrication model under the body's film thickness, in a shell turned by 0.3 rad, the pin
    off its axis along 1.1 rad: load, attitude angle and moments of Ocvirk's bearing as in
    `verify ehd`, 5e-3 for the same reasons; on the shell half the load's lever less. The load is
    that of pressure: Ocvirk's has no share of the shear, which in so short a bearing is as large.
    """
    shape, length = (180, 24), 2 * RADIUS * 0.02
    surface = pin_surface(RADIUS, CLEARANCE, shape)
    axes = turned(0.3)
    way = np.array([np.cos(1.1), np.sin(1.1)])
    place = eccentricity * CLEARANCE * way
    gap = surface.clearance + opening_of(surface, axes.T @ place)
    model = bearing(shape, length, cavitation_model="gumbel", cavity_shear="full_film")
    out = steady(model, np.ascontiguousarray(gap))
    forces = PinForces(out["nodal_pressure_force"], out["nodal_circumferential_force"])
    found = resultants_on(surface, forces, place, axes)
    alone = forces._replace(circumferential=np.zeros(shape))
    pressed = resultants_on(surface, alone, place, axes).force
    s = np.sqrt(1 - eccentricity**2)
    angle = np.arctan2(np.pi * s, 4 * eccentricity)
    load = short_load(length, eccentricity)
    assert np.hypot(*pressed) == pytest.approx(load, rel=5e-3)
    # the film carries against the load, which the pin's place leads by the attitude angle
    along, ahead = -pressed @ way, -pressed @ np.array([-way[1], way[0]])
    assert np.arctan2(-ahead, along) == pytest.approx(angle, rel=5e-3)
    couette = 2 * np.pi * VISCOSITY * SPEED * RADIUS**2 * length / CLEARANCE / s
    lever = load * eccentricity * CLEARANCE * np.sin(angle) / 2
    assert -found.on_pin == pytest.approx(couette + lever, rel=5e-3)
    assert found.on_shell == pytest.approx(couette - lever, rel=5e-3)


def squeezed(length, load, viscosity, clearance, time):
    """Eccentricity [-] of a short bearing that a load squeezes from its middle, pressure below zero
    cut off: e' = W c^2/(mu R L^3 I),  I = int_(-pi/2)^(pi/2) cos^2 a/(1 - e cos a)^3 da.
    """
    angle = np.linspace(-np.pi / 2, np.pi / 2, 2001)

    def rate(_, e):
        shape = np.cos(angle) ** 2 / (1 - e * np.cos(angle)) ** 3
        return load * clearance**2 / (viscosity * 0.018 * length**3 * np.trapezoid(shape, angle))

    return solve_ivp(rate, (0.0, time[-1]), [0.0], t_eval=time, rtol=1e-8).y[0]


def test_a_standing_engine_squeezes_its_pin_as_a_short_bearing(tmp_path):
    """Crank at rest at bottom dead centre, gas on the crown: each boss carries half of its force,
    the eye all of it. L/D of 1/9 and 1/6: the short bearing carries (L/D)^2 or so too much, and the
    piston's inertia delays the way by some microseconds of 3 ms.
    """
    parameters = "participants.bodies.parameters"
    films = {"left_film": 4e-3, "right_film": 4e-3, "small_end_film": 6e-3}
    changes = [
        (f"{parameters}.crank_speed", "0 rad/s"),
        (f"{parameters}.start_crank_angle", "180 deg"),
        (f"{parameters}.boss_clearance", "20 um"),
        (f"{parameters}.small_end_clearance", "20 um"),
        ("time.step", "50 us"),
    ]
    for name, length in films.items():
        own = f"participants.{name}.parameters"
        changes += [(f"{own}.skirt_length", f"{length} m"), (f"{own}.viscosity", "1 Pa s")]
        changes += [(f"{own}.cavitation_model", "gumbel"), (f"{own}.cavitation_pressure", "0 Pa")]
        changes += [(f"{own}.roughness_rms", "0 um")]
    tree = small(*changes, pin=(72, 8), stop="3 ms")
    del tree["time"]["angular_speed"]
    results = computed(tree, tmp_path / "standing.h5")
    force = np.pi * 0.055**2 * results.series("bodies.cylinder_pressure").values[-1]
    time = results.time
    boss = squeezed(4e-3, force / 2, 1.0, 20e-6, time)
    eye = squeezed(6e-3, force, 1.0, 20e-6, time)
    # the piston presses the pin's bosses down onto it, and the pin the eye
    found = {
        "boss": results.series("bodies.pin_displacement_y").values / 20e-6,
        "eye": -results.series("bodies.small_end_displacement_y").values / 20e-6,
    }
    assert boss[-1] > 0.3 and eye[-1] > 0.2
    assert found["boss"][-1] == pytest.approx(boss[-1], rel=2e-2)
    assert found["eye"][-1] == pytest.approx(eye[-1], rel=3e-2)
    sideways = results.series("bodies.pin_displacement_x").values
    assert np.abs(sideways).max() < 1e-3 * 20e-6


@pytest.fixture(scope="module")
def four(tmp_path_factory):
    tree = small(BEFORE_FIRING, stop="120 deg")
    return computed(tree, tmp_path_factory.mktemp("four") / "four.h5")


def test_oil_and_work_of_four_films_to_round_off(four):
    is_sound(four)


def test_what_pin_and_films_say_of_friction(four):
    """The moments on the pin times its speed in each shell, against what the films tell (Eq. (F8)):
    the same but for C/R and second order in cells of 7.5 deg; pressure of asperities has a lever on
    the pin, and none in Eq. (F8).
    """
    told = sum(four.series(f"{film}.friction_power").values for film in PINS)
    seen = four.series("bodies.pin_friction_power").values
    assert seen[1:].mean() == pytest.approx(told[1:].mean(), rel=2e-2)
    assert (told[1:] > 0.0).all()


def test_what_the_films_take_the_bodies_give(four):
    """By their motion bodies lose what passes over the wires. What the wires do not see, the work
    of pressure as the pin turns, is part of the pin's friction and no larger; time integration errs
    by less.
    """
    friction = float(np.diff(four.time) @ four.series("bodies.pin_friction_power").values[1:])
    taken = four.summary["energy_taken_bodies_j"]
    assert taken < 0.0
    assert abs(taken - four.summary["interface_work_j"]) <= friction


def tied(folder, *changes):
    """Results of the piston of the data sheet, whose pin is tied, on the same grid."""
    tree = read_tree(DATA_SHEET, coarse(*changes, grid=(24, 12), modes=None))
    tree |= {"record": {"every": 100}, "pictures": []}
    return run_tree(DATA_SHEET, tree, folder / "tied.h5")


def test_newton_needs_no_more_iterations_than_with_one_film(four, tmp_path):
    """Mean of the tied piston on the same grid, and a half: the pin's films are far thinner."""
    one = tied(tmp_path, ("time.stop", "120 deg"), BEFORE_FIRING)
    assert four.summary["mean_iterations"] <= one.summary["mean_iterations"] + 0.5


@pytest.mark.slow
def test_the_tied_pin_is_the_limit_of_small_clearances(tmp_path):
    """Motion of the piston against that of data_sheet without friction at the pin, by clearance c
    of the pin's films. Their viscosity goes with c^2: the pin then takes the same place in c, and
    play and friction both fall with c.
    """
    stop = ("time.stop", "60 deg")
    names = ("lateral_displacement", "rocking_angle", "side_force")

    def motion(results):
        return values_of(results, *(f"bodies.{name}" for name in names))

    smooth = ("participants.bodies.parameters.pin_friction_coefficient", 0.0)
    limit = motion(tied(tmp_path, stop, smooth))
    apart = []
    for clearance in (20, 10, 5):
        loose = [
            (f"participants.bodies.parameters.{name}_clearance", f"{clearance} um")
            for name in ("boss", "small_end")
        ]
        viscosity = f"{5.6 * (clearance / 10) ** 2} mPa s"
        loose += [(f"participants.{film}.parameters.viscosity", viscosity) for film in PINS]
        near = motion(computed(small(*loose, stop="60 deg"), tmp_path / f"{clearance}.h5"))
        apart.append([np.abs(a - b).max() / np.ptp(b) for a, b in zip(near, limit, strict=True)])
        print(f"{clearance} um: " + ", ".join(f"{n} {a:.2e}" for n, a in zip(names, apart[-1])))
    apart = np.array(apart)
    assert (apart[1:] < 0.6 * apart[:-1]).all()


def test_lengths_are_held_against_the_body():
    told = check("floating_pin", [("participants.left_film.parameters.skirt_length", "24 mm")])
    (fault,) = told.faults
    assert "expected 25 mm, the skirt length of bodies.boss_left" in fault
    told = check("floating_pin", [("participants.bodies.parameters.pin_radius", "17 mm")])
    assert sum("the bore radius of bodies." in fault for fault in told.faults) == 3


def test_what_cannot_float_is_refused():
    told = check("floating_pin", [("participants.bodies.parameters.crank_free", 1)])
    assert any("crank_free: expected 0 with a floating pin" in fault for fault in told.faults)
    pin = "participants.bodies.build.floating_pin"
    told = check("floating_pin", [(pin, {"boss_length": "0 mm", "small_end_length": "36 mm"})])
    assert any("floating_pin.boss_length" in fault for fault in told.faults)


def test_the_built_fmu_keeps_the_contract():
    fmu = make(*build_of(small(skirt=(8, 6), pin=(12, 4)), PATH, "bodies"))
    assert validate_fmu(str(fmu)) == []
    assert check_fmu(fmu)[:2] == ("bodies", [])
    wires = read_tree(PATH)["wires"]
    assert interface(wires, "right_film", "lubrication") == ("bodies", "boss_right.")


def test_models_of_one_film_among_four(tmp_path):
    tree = small(stop="10 deg")
    models = {"lubrication": ["small_end_film=jfo", "small_end_film=gumbel"]}
    changed = swap_all({"one": tree}, models, print)["gumbel"]["participants"]
    assert changed["small_end_film"]["parameters"]["cavitation_model"] == "gumbel"
    assert "cavitation_model" not in changed["left_film"]["parameters"]
    own = make(*build_of(tree, PATH, "small_end_film"))
    given = {"lubrication": [f"small_end_film={own}"]}
    swapped = swap_all({"one": tree}, given, print)["one"]
    results = [computed(one, tmp_path / f"{k}.h5") for k, one in enumerate((tree, swapped))]
    ways = [one.series("bodies.small_end_displacement_y").values for one in results]
    assert np.array_equal(*ways)
