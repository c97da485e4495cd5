"""Bearings of published studies: rows of `piston-cosim verify literature`."""

import re

import numpy as np
import pytest
from rich.console import Console

from piston_cosim.models.measured.piston_friction import study
from piston_cosim.tests.verification.cases import measured


def shares(name, **only):
    """Return the differences over the largest published value by quantity."""
    return {one.quantity: one.share for one in measured.figures(name, **only)}


@pytest.mark.parametrize("speed", ["3000", pytest.param("1000", marks=pytest.mark.slow)])
def test_the_torque_without_much_contact_is_that_of_sander(speed):
    """3 % of the largest torque, the bar of the comparison."""
    only = dict(load="8000", speed=speed)
    assert abs(shares("sander_2016", **only)["friction_torque"]) < 0.03


@pytest.mark.slow
def test_elastic_rough_bearings_have_the_torque_at_low_speed():
    """Within 15 % of the largest torque, the bar, which smooth flow or rigid journals miss."""
    only = dict(load="8000", speed="150")
    found = shares("sander_2016", **only)
    assert found["friction_torque"] == pytest.approx(0.086, abs=0.01)
    assert abs(found["minimum_film_thickness"]) < 0.05
    smooth = shares("sander_2016", film={"flow_factors": "none"}, **only)["friction_torque"]
    assert smooth == pytest.approx(0.367, abs=0.01)
    # with contact at the mean plane of the surfaces, the torque is seven times too low
    low = shares("sander_2016", film={"summit_height": "0 um"}, **only)["friction_torque"]
    assert low == pytest.approx(-0.859, abs=0.01)


@pytest.mark.slow
def test_the_torque_is_least_between_400_and_600_rpm():
    torque = {
        speed: next(measured.figures("sander_2016", load="8000", speed=speed)).computed
        for speed in ("1000", "500", "400")
    }
    assert min(torque, key=torque.get) == "500"


def test_a_step_bearing_is_that_of_nicholas():
    found = {one.quantity: one for one in measured.figures("nicholas_1980", pocket_depth="88.9")}
    eccentricity = found.pop("eccentricity")
    # printed with two digits, and computed on a grid of 1980
    assert eccentricity.computed == pytest.approx(eccentricity.published, abs=0.015)
    # the cross stiffness xy is a difference of large parts
    assert abs(found.pop("stiffness_xy").difference) < 0.2
    assert all(abs(one.difference) < 0.05 for one in found.values()) and len(found) == 3


@pytest.mark.slow
def test_an_elastic_diaphragm_has_the_pressure_of_freund():
    """15 % at worst and 5 % in the mean, the bars, in all rows; a rigid bearing misses both."""
    found = {"pressure": [], "deflection": []}
    for one in measured.figures("freund_1995", shell="elastic"):
        found[one.quantity].append(one)
    pressure, deflection = ([abs(one.share) for one in series] for series in found.values())
    assert len(pressure) == 19 and max(pressure) < 0.15 and sum(pressure) / 19 < 0.05
    rigid = [abs(one.share) for one in measured.figures("freund_1995", shell="rigid")]
    assert len(rigid) == 19 and max(rigid) > 0.2 and sum(rigid) / 19 > 0.08
    # the free edge, whose error falls with the size of a cell, is the first row
    assert len(deflection) == 13 and 0.15 < deflection[0] < 0.2
    assert max(deflection[1:]) < 0.1 and sum(deflection[1:]) / 12 < 0.04


def test_a_plain_bearing_has_a_band_over_four_supplies():
    """Mean differences of the supplies to 1 %; the trend with speed needs conserved mass."""
    series = measured.bands("plain_bearing")
    means = {key: sum(one.difference for one in rows) / 9 for key, rows in series.items()}
    expected = {"groove on top at 0 kPa": -0.19, "sides at 6 kPa": 0.03}
    assert len(means) == 4 and means | expected == pytest.approx(means, abs=0.01)
    inside = [
        min(one.difference for one in row) <= 0.0 <= max(one.difference for one in row)
        for row in zip(*series.values())
    ]
    assert sum(inside) == 4
    supply = measured.case_of("plain_bearing")["supplies"]["sides at 6 kPa"]
    models = {"jfo": series["sides at 6 kPa"]}
    for model in ("reynolds", "gumbel"):
        film = {"cavitation_model": model}
        models[model] = [*measured.figures("plain_bearing", film, supply)]
    for model, rows in models.items():
        for slow, fast in ((rows[0], rows[2]), (rows[3], rows[5])):
            assert fast.published > slow.published
            assert (fast.computed > slow.computed) == (model == "jfo")


def test_the_fit_of_piston_friction_and_its_film_by_hand():
    """56.5 x 49.5 mm at 6000 rpm: c = 9.9 m/s, 294 * 9.9 / 56.5 and 40600 * 7 / 6 / 56.5^2 kPa.

    A film of 20 um under 6 mPa s on 27 mm, with the velocity pi/2 c sin(a): integrated numerically.
    """
    piston, rings = study.fit(56.5e-3, 49.5e-3, 200.0 * np.pi)
    assert (piston, rings) == pytest.approx((51.515e3, 14.838e3), rel=1e-4)
    velocity = np.pi / 2.0 * 9.9 * np.sin(2.0 * np.pi * (np.arange(720) + 0.5) / 360.0)
    force = 6e-3 * velocity / 20e-6 * np.pi * 56.5e-3 * 27e-3
    work = (force * velocity).mean() * 0.02
    pressure = work / (np.pi / 4.0 * 56.5e-3**2 * 49.5e-3)
    film = study.uniform_film(pressure, 6e-3, 27e-3, 56.5e-3, 9.9)
    assert film == pytest.approx(20e-6, rel=1e-12)


def test_the_table_is_printed_and_written(tmp_path, monkeypatch, capsys):
    row = list(measured.figures("nicholas_1980", pocket_depth="0", clearance="45.72"))
    wider = [row[0]._replace(computed=0.032, status="measured")]
    monkeypatch.setattr(measured, "bands", lambda name: {"a": row, "b": wider})
    page = tmp_path / "measured.md"
    measured.verify_measured(Console(width=200), page)
    assert len(page.read_text().strip().split("\n")) == 2 + len(measured.names())
    printed = capsys.readouterr().out
    assert re.search(r"66.278 N, 8000 rpm, 45.72 um.* \[1\] +0.03 +0.02949 to 0.032 ", printed)
    assert "band over 2 assumed supplies" in printed


@pytest.mark.slow
def test_the_pages_of_the_cases_show_what_is_computed(tmp_path):
    page = tmp_path / "measured.md"
    measured.verify_measured(Console(width=200), page)
    for line in page.read_text().strip().split("\n")[2:]:
        name = line.split()[1]
        assert line in (measured.FOLDER / name / "README.md").read_text()
