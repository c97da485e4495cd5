"""models/floating_pin with a pin that tilts and bends: oil and work to round-off on the built FMUs,
where the films bear, which way the pin leans.
"""

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.build import declared_variables
from piston_cosim.master.case.check import check
from piston_cosim.master.case.reading import find_case

from .runs import is_sound, values_of
from .test_floating_pin import PINS, computed, small

PIN = "participants.bodies.build.floating_pin"
BORE = ("participants.bodies.parameters.pin_bore_radius", "9.4 mm")
START = ("participants.bodies.parameters.start_crank_angle", "-40 deg")


def run_of(path, shapes, *changes):
    """Through the firing, with shapes of the pin or none."""
    tree = small(START, *changes, stop="80 deg")
    if shapes:
        tree["participants"]["bodies"]["build"]["floating_pin"]["pin_shapes"] = shapes
        tree["participants"]["bodies"]["parameters"]["pin_bore_radius"] = "9.4 mm"
    fields = ["left_film.pressure", *(f"bodies.{one}.film_thickness" for one in PINS.values())]
    return computed(tree | {"record": {"fields": fields, "every": 10}}, path)


@pytest.fixture(scope="module")
def bending(tmp_path_factory):
    return run_of(tmp_path_factory.mktemp("bending") / "bending.h5", 5)


@pytest.fixture(scope="module")
def rigid(tmp_path_factory):
    return run_of(tmp_path_factory.mktemp("rigid") / "rigid.h5", 0)


def test_oil_and_work_of_four_films_to_round_off(bending, rigid):
    is_sound(bending)
    assert bending.series("bodies.elastic_energy").values.max() > 1e-3
    # from rest 40 deg before the firing, in films a tenth of a micrometre thin: 3.6, rigid 2.8
    assert bending.summary["mean_iterations"] <= rigid.summary["mean_iterations"] + 1.2


def rows(results, film):
    """Load by row of a film 40 deg after firing top dead centre [Pa]."""
    pressure = results.dataset(f"{film}.pressure")[-1]
    lift = np.sin(2 * np.pi * np.arange(pressure.shape[0]) / pressure.shape[0])
    return np.abs(lift @ pressure)


def thinnest(results, surface):
    """Thinnest film by row at that instant [m]."""
    return results.dataset(f"bodies.{surface}.film_thickness")[-1].min(axis=0)


def test_a_pin_that_bends_bears_at_the_edges(bending, rigid):
    """Pushed up in the middle by the eye, held at both ends by the bosses: its films are thinnest
    at the ends of the eye and at the inner ends of the bosses, which carry the same load there. A
    rigid pin is parallel to its shells and bears amid each, both halves alike.
    """
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
    # up in the middle, and no tilt where all is symmetric: of 1 mrad that the play would allow
    assert bending.series("bodies.pin_bending_y").values.max() > 1e-6
    assert np.abs(bending.series("bodies.pin_tilt_y").values).max() < 1e-8


def test_a_pin_tilts_towards_the_thinner_oil(tmp_path):
    """Oil of the left boss three times as thick: under the gas the right end of the pin gives way
    more. The pin goes up in its bosses, on the right by more than on the left.
    """
    thick = ("participants.left_film.parameters.viscosity", "16.8 mPa s")
    results = run_of(tmp_path / "lopsided.h5", 1, thick)
    names = ("pin_tilt_y", "pin_displacement_y", "cylinder_pressure")
    tilt, shift, pressure = values_of(results, *(f"bodies.{name}" for name in names))
    firing = pressure > 2e6
    assert (shift[firing] > 0.0).all()
    assert tilt[firing].max() > 1e-6
    assert tilt[firing].mean() > 0.0
    is_sound(results)


def test_the_variant_is_sound_and_what_cannot_bend_is_told():
    def told(*changes):
        return " ".join(check("floating_pin", [(f"{PIN}.pin_shapes", 5), *changes]).faults)

    assert told(BORE) == ""
    assert "pin_bore_radius: expected less" in told((BORE[0], "18 mm"))
    assert "pin_length: expected 0 or at least the length of all films, 86 mm, got 80 mm" in told(
        ("participants.bodies.parameters.pin_length", "80 mm")
    )
    assert "floating_pin.pin_shapes" in told((f"{PIN}.pin_shapes", 12))
    # a pin that stays parallel has no such parameters
    (fault,) = check("floating_pin", [BORE]).faults
    assert "pin_bore_radius" in fault


def test_variables_of_a_pin_without_shapes_are_as_ever():
    build = small()["participants"]["bodies"]["build"]
    folder = find_case("floating_pin").parent
    plain = [one.name for one in declared_variables(build, folder)]
    build["floating_pin"] |= {"pin_shapes": 2}
    bent = [one.name for one in declared_variables(build, folder)]
    more = {"pin_tilt_x", "pin_tilt_y", "pin_bending_x", "pin_bending_y"}
    more |= {"pin_length", "pin_bore_radius", "pin_young", "pin_poisson"}
    more |= {"boss_relief", "small_end_relief"}
    assert set(bent) - set(plain) == more
    assert [name for name in bent if name not in more] == plain
