"""What is said of the bodies before they are reduced, beside the reduced ones and closed forms."""

import numpy as np
import pytest

from piston_cosim.fmu_mfbd import preview_picture
from piston_cosim.fmu_mfbd.preview import (
    preview,
)
from piston_cosim.fmu_mfbd.preview_remarks import remarks_on_gas, runs

SHEET = {
    "grid": [40, 41],  # a row of cells at mid skirt, where the barrel is widest
    "piston": {
        "rigid": {
            "mass": "0.4 kg",
            "centre": ["1 mm", "12 mm"],
            "inertia": "300 kg mm^2",
            "radius": "42.95 mm",
        },
        "skirt_lower": "-25 mm",
        "skirt_upper": "20 mm",
        "pin_offset": "0.5 mm",
    },
    "block": {"rigid": {"radius": "43 mm"}, "bore_lower": "60 mm", "bore_upper": "220 mm"},
}
CRANK = {"crank_radius": 43e-3, "rod_length": 143e-3, "radial_clearance": 40e-6, "barrel": 40e-6}


def test_mass_of_a_mesh_is_that_of_the_reduced_body(coarse, reduced):
    folder, table = coarse
    options, piston, _ = reduced
    seen = preview(table, {}, folder)
    assert seen.faults == []
    # the reduced body's is 1^T M 1, of a rule of higher degree in elements with curved faces
    assert seen.figure("mass").value == pytest.approx(piston.mass, rel=1e-4)
    centre = piston.S / piston.mass
    assert seen.figure("centre_above_pin").value == pytest.approx(centre[1], rel=1e-4)
    assert seen.figure("centre_from_pin").value == pytest.approx(np.hypot(*centre), rel=1e-4)
    assert 1.0 < seen.figure("worst_aspect_ratio").value < 20.0
    about = piston.I0 - piston.mass * centre @ centre
    assert seen.figure("inertia").value == pytest.approx(about, rel=1e-3)
    assert seen.figure("skirt_length").value == piston.skirt_upper - piston.skirt_lower
    assert seen.figure("covered_share").value == 1.0 and options.skirt is None


def test_sheet_stroke_and_clearance_by_hand(tmp_path):
    growth = {"skirt_growth_lower": 10e-6, "skirt_growth_upper": 10e-6, "bore_growth_lower": 4e-6}
    growth["bore_growth_upper"] = 4e-6
    seen = preview(SHEET, {**CRANK, **growth, "crank_speed": 200.0}, tmp_path)
    assert seen.faults == []
    # stroke with offset e: sqrt((l + r)^2 - e^2) - sqrt((l - r)^2 - e^2)
    offset = 0.5e-3
    stroke = np.sqrt(0.186**2 - offset**2) - np.sqrt(0.1**2 - offset**2)
    assert seen.figure("stroke").value == pytest.approx(stroke, rel=1e-12)
    area = np.pi * 0.043**2
    assert seen.figure("swept_volume").value == pytest.approx(area * stroke, rel=1e-12)
    assert seen.figure("mean_piston_speed").value == pytest.approx(stroke * 200 / np.pi, rel=1e-12)
    assert seen.figure("bore_radius").value == pytest.approx(0.043, rel=1e-12)
    cold, hot = seen.figure("clearance_cold"), seen.figure("clearance_hot")
    assert cold.value == pytest.approx(40e-6, rel=1e-9) and "at 90 deg" in cold.note
    assert hot.value == pytest.approx(34e-6, rel=1e-9)  # 40 - 10 + 4


def test_an_interference_when_hot_is_told(tmp_path):
    growth = dict.fromkeys(("skirt_growth_lower", "skirt_growth_upper"), 55e-6)
    seen = preview(SHEET, {**CRANK, **growth}, tmp_path)
    assert any(
        "wider than the bore by 15 \N{MICRO SIGN}m when hot" in line for line in seen.remarks
    )


@pytest.mark.parametrize(
    "given, message",
    [
        ({"rod_length": 40e-3}, "rod_length: expected more than"),
        ({"crank_radius": 75e-3}, "expected a skirt within the bore"),
        ({"rod_centre": 0.2}, "rod_centre: expected at most"),
    ],
)
def test_geometry_that_does_not_go_together(given, message, tmp_path):
    assert any(message in line for line in preview(SHEET, {**CRANK, **given}, tmp_path).faults)


def test_faults_of_a_mesh_and_of_its_modes(coarse):
    folder, table = coarse
    turned = table | {"piston": table["piston"] | {"axes": ["y", "x", "-z"]}}
    assert "expected an axis along y" in preview(turned, {}, folder).faults[0]
    count = {"modes": 60, "basis": "pressure_modes"}
    many = table | {"grid": [4, 4], "piston": table["piston"] | count}
    many["block"] = table["block"] | {"mesh": "no.msh"}
    assert "got 'no.msh'" in preview(many, {}, folder).faults[0]
    many["block"] = table["block"]
    assert any("at most 14" in line for line in preview(many, {}, folder).faults)


def test_runs_on_a_ring():
    assert runs(np.array([1, 0, 0, 1, 1, 0, 1], dtype=bool)) == [2, 2]  # 1 at the end goes on
    assert runs(np.ones(3, dtype=bool)) == [] and runs(np.zeros(3, dtype=bool)) == []


@pytest.mark.parametrize(
    "low, high, words",
    [
        (0.0, 7e6, []),
        (0.0, 40e6, ["less than 30 MPa"]),
        (0.0, 7e9, ["check pressure_unit"]),
        (0.0, 7e3, ["check pressure_unit"]),
        (1e5, 7e6, ["seems absolute"]),
    ],
)
def test_unusual_gas_pressures_are_remarked(low, high, words):
    remarks = remarks_on_gas(np.array([low, high, low]))
    assert len(remarks) == len(words) and all(w in r for w, r in zip(words, remarks))


def test_the_picture_shows_the_clearance_of_the_text(tmp_path, monkeypatch):
    drawn = {}
    developed = preview_picture.draw_developed

    def noted(figure, panel, angle, height, value):
        drawn.setdefault("clearance", value)  # the first panel is that of the skirt
        developed(figure, panel, angle, height, value)
        left, right, *_ = panel.images[0].get_extent()
        assert panel.get_xlim() == (0, 360) and left <= 0 and right >= 360  # no white strip

    monkeypatch.setattr(preview_picture, "draw_developed", noted)
    growth = {"skirt_growth_lower": 70e-6, "skirt_growth_upper": 70e-6}
    growth |= {"bore_growth_lower": 60e-6, "bore_growth_upper": 50e-6}
    seen = preview(SHEET, {**CRANK, **growth}, tmp_path)
    seen.draw(tmp_path / "shape.png")
    assert (tmp_path / "shape.png").stat().st_size > 10_000
    hot = seen.figure("clearance_hot").value
    # the skirt alone would overlap by 30 um; the bore grows by 50 to 60 um over its length
    assert 20e-6 < hot < 30e-6
    assert drawn["clearance"].min() == pytest.approx(hot, rel=1e-12)
