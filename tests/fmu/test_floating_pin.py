"""models/floating_pin: four films on one piston, three of them on its pin.

The pin may tilt and bend. The tests compare forces with closed forms, and powers with each
other. They check the tied pin as the limit, and where the films carry load.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from .runs import is_sound, run_tree, values_of
from .shipped import DATA_SHEET, FLOATING_PIN, PARAMETERS, PINS, firing_pin, small_pin, tied


def squeezed(length, load, viscosity, clearance, time):
    """Return the eccentricity [-] of a short bearing that a load squeezes from its middle.

    Pressure below zero is cut off:
    e' = W c^2/(mu R L^3 I),  I = int_(-pi/2)^(pi/2) cos^2 a/(1 - e cos a)^3 da.
    """
    angle = np.linspace(-np.pi / 2, np.pi / 2, 2001)

    def rate(_, e):
        shape = np.cos(angle) ** 2 / (1 - e * np.cos(angle)) ** 3
        return load * clearance**2 / (viscosity * 0.018 * length**3 * np.trapezoid(shape, angle))

    return solve_ivp(rate, (0.0, time[-1]), [0.0], t_eval=time, rtol=1e-8).y[0]


def test_a_standing_engine_squeezes_its_pin_as_a_short_bearing(tmp_path):
    """A crank at rest at bottom dead centre squeezes its pin as a short bearing.

    Gas acts on the crown: each boss carries half of its force, the eye all of it. At L/D of 1/9 and
    1/6 the short bearing carries about (L/D)^2 too much. The piston's inertia delays the motion by
    some microseconds of 3 ms.
    """
    films = {"left_film": 4e-3, "right_film": 4e-3, "small_end_film": 6e-3}
    changes = [
        (f"{PARAMETERS}.crank_speed", "0 rad/s"),
        (f"{PARAMETERS}.start_crank_angle", "180 deg"),
        (f"{PARAMETERS}.boss_clearance", "20 um"),
        (f"{PARAMETERS}.small_end_clearance", "20 um"),
        ("time.step", "50 us"),
    ]
    for name, length in films.items():
        own = f"participants.{name}.parameters"
        changes += [(f"{own}.skirt_length", f"{length} m"), (f"{own}.viscosity", "1 Pa s")]
        changes += [(f"{own}.cavitation_model", "gumbel"), (f"{own}.cavitation_pressure", "0 Pa")]
        changes += [(f"{own}.roughness_rms", "0 um")]
    tree = small_pin(*changes, pin=(72, 8), stop="3 ms")
    del tree["time"]["angular_speed"]
    results = run_tree(FLOATING_PIN, tree, tmp_path / "standing.h5")
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


def test_what_pin_and_films_say_of_friction(results_of):
    """The moments on the pin times its speed equal the friction power of the films (Eq. (F8)).

    The speed is that in each shell. The rest is C/R and second order in cells of 7.5 deg. Pressure
    of asperities has a lever on the pin, and none in Eq. (F8).
    """
    four = results_of("floating_pin")
    told = sum(four.series(f"{film}.friction_power").values for film in PINS)
    seen = four.series("bodies.pin_friction_power").values
    assert seen[1:].mean() == pytest.approx(told[1:].mean(), rel=2e-2)
    assert (told[1:] > 0.0).all()


def test_newton_needs_no_more_iterations_than_with_one_film(results_of):
    """The mean number of iterations is at most that of the tied piston plus a half.

    The grid is the same, but the pin's films are far thinner. A pin that bends from rest in films a
    tenth of a micrometre thin takes 3.6, a rigid one 2.8.
    """
    one, four, bending = (
        results_of(name).summary["mean_iterations"]
        for name in ("tied_pin", "floating_pin", "bending_pin")
    )
    assert four <= one + 0.5
    assert bending <= four + 1.2


@pytest.mark.slow
def test_the_tied_pin_is_the_limit_of_small_clearances(tmp_path):
    """The piston's motion approaches that of a tied pin without friction as the clearance c falls.

    The tied case is data_sheet. The viscosity of the pin's films goes with c^2: the pin's position
    in units of c then stays the same, and play and friction both fall with c.
    """
    stop = ("time.stop", "60 deg")
    names = ("lateral_displacement", "rocking_angle", "side_force")

    def motion(results):
        return values_of(results, *(f"bodies.{name}" for name in names))

    smooth = (f"{PARAMETERS}.pin_friction_coefficient", 0.0)
    limit = motion(run_tree(DATA_SHEET, tied(stop, smooth), tmp_path / "tied.h5"))
    apart = []
    for clearance in (20, 10, 5):
        loose = [
            (f"{PARAMETERS}.{name}_clearance", f"{clearance} um") for name in ("boss", "small_end")
        ]
        viscosity = f"{5.6 * (clearance / 10) ** 2} mPa s"
        loose += [(f"participants.{film}.parameters.viscosity", viscosity) for film in PINS]
        tree = small_pin(*loose, stop="60 deg")
        near = motion(run_tree(FLOATING_PIN, tree, tmp_path / f"{clearance}.h5"))
        apart.append([np.abs(a - b).max() / np.ptp(b) for a, b in zip(near, limit, strict=True)])
        print(f"{clearance} um: " + ", ".join(f"{n} {a:.2e}" for n, a in zip(names, apart[-1])))
    apart = np.array(apart)
    assert (apart[1:] < 0.6 * apart[:-1]).all()


def rows(results, film):
    """Load by row of a film 30 deg after firing top dead centre [Pa]."""
    pressure = results.dataset(f"{film}.pressure")[-2]
    lift = np.sin(2 * np.pi * np.arange(pressure.shape[0]) / pressure.shape[0])
    return np.abs(lift @ pressure)


def thinnest(results, surface):
    """Thinnest film by row at that instant [m]."""
    return results.dataset(f"bodies.{surface}.film_thickness")[-2].min(axis=0)


def test_a_pin_that_bends_bears_at_the_edges(results_of):
    """A bending pin loads the ends of the eye and the inner ends of the bosses.

    The eye pushes the pin up in the middle, and the bosses hold both ends. The films are thinnest
    at these edges; the bosses carry the same load. A rigid pin is parallel to its shells and loads
    the middle of each, both halves alike.
    """
    bending, rigid = results_of("bending_pin"), results_of("floating_pin")
    assert bending.series("bodies.elastic_energy").values.max() > 1e-3
    even = rows(rigid, "left_film")
    np.testing.assert_allclose(even, even[::-1], rtol=1e-6)
    assert even[1] > even[0]
    outer, *_, inner = rows(bending, "left_film")
    assert inner > 2.0 * outer
    assert rows(bending, "left_film").sum() == pytest.approx(even.sum(), rel=5e-2)
    for surface in PINS.values():
        gap = thinnest(rigid, surface)
        np.testing.assert_allclose(gap, gap[0], rtol=1e-9)
    left, right, eye = (thinnest(bending, surface) for surface in PINS.values())
    assert (np.diff(left) < 0.0).all()
    np.testing.assert_allclose(right, left[::-1], rtol=1e-3)
    np.testing.assert_allclose(eye, eye[::-1], rtol=1e-3)
    assert eye[0] < eye[1]
    # up in the middle, and no tilt where all is symmetric: the play would allow 1 mrad, and the
    # coupling leaves 10 nm of the films in the bosses, which are 60 mm apart
    assert bending.series("bodies.pin_bending_y").values.max() > 1e-6
    assert np.abs(bending.series("bodies.pin_tilt_y").values).max() < 10e-9 / 60e-3


def test_a_pin_tilts_towards_the_thinner_oil(tmp_path):
    """If the left boss has thicker oil, the right end of the pin gives way more under the gas.

    The oil is three times as thick. The pin rises in its bosses, on the right by more than on the
    left.
    """
    thick = ("participants.left_film.parameters.viscosity", "16.8 mPa s")
    results = run_tree(FLOATING_PIN, firing_pin(1, thick), tmp_path / "lopsided.h5")
    names = ("pin_tilt_y", "pin_displacement_y", "cylinder_pressure")
    tilt, shift, pressure = values_of(results, *(f"bodies.{name}" for name in names))
    firing = pressure > 2e6
    assert (shift[firing] > 0.0).all()
    assert tilt[firing].max() > 1e-6
    assert tilt[firing].mean() > 0.0
    is_sound(results)
