"""What is said of the bodies before they are reduced, beside the reduced ones and closed forms."""

from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.fmu_mfbd import preview_picture
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.dynamics.tables import TableFault, gas_table, inline_numbers
from piston_cosim.fmu_mfbd.preview import (
    preview,
)
from piston_cosim.fmu_mfbd.preview_remarks import (
    _interference,
    messages_on_fit,
    messages_on_gas,
    runs,
)

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


def test_a_rigid_skirt_that_is_wider_than_the_bore_is_a_fault(tmp_path):
    growth = dict.fromkeys(("skirt_growth_lower", "skirt_growth_upper"), 55e-6)
    seen = preview(SHEET, {**CRANK, **growth}, tmp_path)
    assert "wider by 15 \N{MICRO SIGN}m when hot" in seen.faults[0]  # 40 - 55


def shapes_of(cold, hot):
    """Return shapes of one cell with a film, with these clearances [m]."""
    one = np.ones((1, 1))
    return SimpleNamespace(
        film=one > 0.0,
        angle=one[0],
        height=one[0],
        clearance=lambda is_hot: one * (hot if is_hot else cold),
    )


@pytest.mark.parametrize("fit, kinds", [(-173e-6, ["fault"]), (-10e-6, []), (0.4e-3, ["warning"])])
def test_a_mesh_of_a_skirt_wider_than_the_bore_is_a_fault(fit, kinds):
    radii = 43e-3, 43e-3 + fit
    piston, block = (SimpleNamespace(body=SimpleNamespace(radius=r, mass=0.3)) for r in radii)
    cold = {"is_hot": False}
    part = SimpleNamespace(modes=60, rigid=None, profiles=[], **cold)
    build = SimpleNamespace(piston=part, block=SimpleNamespace(**cold))
    chosen = Parameters(radial_clearance=25e-6, barrel=20e-6, skirt_growth_upper=1e-6)
    messages = messages_on_fit(build, piston, block, chosen, shapes_of(1e-6, 1e-6))
    assert [message.kind for message in messages] == kinds


@pytest.mark.parametrize(
    "hot, flexible, kind",
    [
        (-40e-6, True, "warning"),  # less than a thousandth of the radius, which yields
        (-50e-6, True, "fault"),
        (-40e-6, False, "fault"),
        (1e-6, False, None),
    ],
)
def test_a_flexible_skirt_yields_to_a_hot_interference(hot, flexible, kind):
    messages = _interference(shapes_of(1e-6, hot), 43e-3, flexible)
    assert [message.kind for message in messages] == ([kind] if kind else [])


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
    "exhaust, high, strokes, words",
    [
        (0.0, 7e6, 4, []),
        (0.0, 7e6, 2, []),
        (0.5e5, 7e6, 4, []),  # back pressure of a turbine, gauge
        (0.0, 40e6, 4, ["less than 30 MPa"]),
        (0.0, 7e3, 4, ["check pressure_unit"]),
        (0.0, 0.65e6, 4, ["650 kPa: expected above 0.7 MPa, which compression reaches; check"]),
        (1e5, 7e6, 4, ["mean gas pressure in the exhaust = 100 kPa: the table seems absolute"]),
        (1e5, 7e6, 2, ["seems absolute"]),
        (
            2.2e5,
            7e6,
            4,
            ["exhaust = 220 kPa: expected gauge pressure near 0; check that the table"],
        ),
        (-0.8e5, 7e6, 4, ["check that the table is neither absolute nor reduced twice"]),
    ],
)
def test_unusual_gas_pressures_give_messages(exhaust, high, strokes, words):
    half = 90.0 * strokes
    points = [[-half, 0.0], [0.0, high], [140.0, exhaust], [half - 10.0, exhaust], [half, 0.0]]
    if strokes == 2:
        points[0:1] = [[-180.0, exhaust], [-140.0, exhaust]]
        points[-1] = [180.0, exhaust]
    angles = np.arange(points[0][0], points[-1][0] + 5.0, 10.0)
    points = list(zip(angles, np.interp(angles, *np.transpose(points))))
    table = gas_table(inline_numbers("gas", points), strokes * np.pi, np.pi / 180, 1.0)
    messages = [message.text for message in messages_on_gas(table)]
    assert len(messages) == len(words) and all(w in r for w, r in zip(words, messages))


def test_a_gas_table_that_fires_elsewhere_is_a_warning():
    points = [[0.0, 0.0], [360.0, 7e6], [720.0, 0.0]]
    table = gas_table(inline_numbers("gas", points), 4 * np.pi, np.pi / 180, 1.0)
    elsewhere, coarse = messages_on_gas(table)
    assert "at -360 deg: expected near 0 deg" in elsewhere.text
    assert "at most 30 deg apart, got 360 deg after 0 deg" in coarse.text


@pytest.mark.parametrize("extreme", [1e9, -0.2e6])
def test_impossible_gas_pressures_are_a_fault(extreme):
    points = [[0.0, 0.0], [360.0, extreme], [720.0, 0.0]]
    with pytest.raises(TableFault, match="expected gauge pressures from -0.101325 to 100 MPa"):
        gas_table(inline_numbers("gas", points), 4 * np.pi, np.pi / 180, 1.0)


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


@pytest.mark.parametrize("growth, panels", [({}, 3), ({"bore_growth_upper": 50e-6}, 4)])
def test_every_panel_of_the_picture_has_something_drawn(tmp_path, monkeypatch, growth, panels):
    """A bore that is a cylinder has no panel; without growth no curve is dashed."""
    drawn = []
    saved = preview_picture.Figure.savefig

    def noted(figure, *given, **more):
        drawn.extend(panel for panel in figure.axes if panel.get_label() != "<colorbar>")
        saved(figure, *given, **more)

    monkeypatch.setattr(preview_picture.Figure, "savefig", noted)
    seen = preview(SHEET, {**CRANK, **growth}, tmp_path)
    seen.draw(tmp_path / "shape.png")
    assert len(drawn) == panels and all(panel.has_data() for panel in drawn)
    dashed = any(line.get_linestyle() == "--" for panel in drawn for line in panel.lines)
    assert dashed == bool(growth)
    assert ("dashed" in drawn[-1].get_title()) == bool(growth)
    smallest = seen.figure("clearance_hot").value
    (mark,) = drawn[0].texts[-1:]
    assert float(mark.get_text().split()[0]) == pytest.approx(1e6 * smallest, rel=5e-3)
