"""Pictures of runs, also of fields that are the same everywhere."""

from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import Normalize, to_rgb

from piston_cosim.master.case.shown import NEUTRAL, Axes, Axis, Picture
from piston_cosim.master.results.charts import line_charts
from piston_cosim.master.results.figures import subplots
from piston_cosim.master.results.maps import (
    STYLE,
    FieldMap,
    Layer,
    contour_levels,
    field_map,
    map_row,
    masked,
)
from piston_cosim.master.results.pictures import (
    PALETTE,
    PALETTE_DARK,
    draw,
    draw_lines,
    draw_map,
    draw_maps,
    draw_sections,
    figures,
    left_out,
)
from piston_cosim.master.results.recorded import Envelope, RecordedField, Series
from piston_cosim.master.results.words import unit_shown

from .by_hand import InMemory

FIELD = np.eye(4)


def run(field=FIELD, there=None, **more):
    """Return a run that has recorded a field."""
    usual = {"recorded": ["ehd.pressure"], "ports": [], "time": np.array([0.0, 0.5, 1.0])}
    given = {"case": {"participants": {}}, "existing_cells": lambda port: there}
    given["field"] = lambda port, instant: RecordedField(field, 0.0, "Pa", "")
    return SimpleNamespace(**usual | given | more)


def case_of(*pictures, axes=NEUTRAL):
    time = SimpleNamespace(angular_speed=None)
    return SimpleNamespace(pictures=pictures, axes_of=lambda port: axes, window={}, time=time)


def map_of(results, axes=NEUTRAL, time="0 s"):
    """Draw the map of a run's pressure and return its panel."""
    picture = Picture(file="a.png", title="", kind="map", fields=["ehd.pressure"], time=time)
    return draw_maps(case_of(axes=axes), picture, {"base": results}).axes[0]


def lines_of(y, x="b.crank_angle", units=None, **runs):
    """Draw the figure of curves {port: (values, unit)} of runs."""
    picture = Picture(file="a.png", title="", kind="lines", x=x, y=y, units=units or {})
    return draw_lines(case_of(), picture, {label: InMemory([], own) for label, own in runs.items()})


def test_a_map_of_an_envelope_says_of_which_steps_it_is():
    for every_step, words in ((True, "all steps"), (False, "recorded instants")):
        envelope = Envelope(3e6 * np.eye(4), "max", "Pa", "", every_step)
        panel = map_of(run(envelope=lambda port, one=envelope: one), time="envelope")
        assert panel.get_title() == f"base, extremes of {words} of the last period"
        assert panel.images[0].get_array().max() == 3e6


@pytest.mark.parametrize("kind", ["section", "map"])
def test_an_envelope_belongs_to_a_map(kind):
    given = dict(file="a.png", title="", kind=kind, fields=["ehd.pressure"], time="envelope")
    if kind == "map":
        assert Picture(**given).marker == ""
        return
    with pytest.raises(ValueError, match="expected an instant in a picture of kind 'section'"):
        Picture(**given)


SKIRT = Axes(
    participants=["ehd"],
    first={"label": "angle", "unit": "deg", "range": [0, 360], "marks": {"thrust": 90}},
    second={"label": "height / skirt length"},
)


@pytest.mark.parametrize("axes", [SKIRT, NEUTRAL])
def test_axes_say_what_the_case_says_and_nothing_else(axes):
    results = run(np.arange(20.0).reshape(5, 4))
    panel = map_of(results, axes)
    picture = SimpleNamespace(
        fields=["heat.flux"], time="0 s", units={}, angles=("0 deg", "180 deg"), height=0.5
    )
    words = " ".join(label.get_text() for label in panel.get_xticklabels())
    section = draw_sections(case_of(axes=axes), picture, {"base": results}).axes[0]
    along = section.lines[0].get_xdata()
    if axes is SKIRT:
        assert (panel.get_xlabel(), panel.get_ylabel()) == ("angle [deg]", "height / skirt length")
        assert panel.images[0].get_extent() == [0, 360, 0, 1] and "90\nthrust" in words
        assert section.get_xlabel() == "angle [deg]"
        assert "90\nthrust" in [label.get_text() for label in section.get_xticklabels()]
        assert along == pytest.approx([36.0, 108.0, 180.0])
    else:
        assert panel.get_xlabel() == "first index / its number" and "thrust" not in words
        assert panel.images[0].get_extent() == [0, 1, 0, 1]
        assert along == pytest.approx([0.1, 0.3, 0.5])


def test_a_cut_out_stays_blank_and_colours_are_linear():
    """Also if one cell has most of the pressure, as in the map of a report."""
    field = 10.0 ** np.arange(20.0).reshape(5, 4)[::-1]
    there = np.ones((5, 4), bool)
    there[0, 3] = False  # the largest: it must not set the scale either
    panel = map_of(run(field, there))
    image = panel.images[0]
    assert image.get_array().mask.T.tolist() == (~there).tolist()
    assert type(image.norm) is Normalize
    assert (image.norm.vmin, image.norm.vmax) == (1.0, 1e18)
    assert [text.get_text() for text in panel.texts] == ["1e+18 Pa"]  # the mark


def film(**layers):
    """Return a map of the first layer, 8 x 4 cells, with the others of the same film."""
    made = {kind: Layer(masked(values, None), "um") for kind, values in layers.items()}
    return FieldMap("p [MPa]", next(iter(layers)), SKIRT, "8 ms", made)


def drawn_map(one):
    """Return the panel of a map."""
    _, panel = subplots(figsize=(6, 4))
    draw_map(panel, one, map_row([one]))
    return panel


def test_extremes_are_marked_by_a_ring_and_a_cross_with_their_values():
    thickness, pressure = np.full((8, 4), 20.0), np.zeros((8, 4))
    thickness[2, 1], pressure[5, 3] = 9.2, 4.61
    panel = drawn_map(film(pressure=pressure, thickness=thickness))
    marks = {line.get_marker(): line.get_xydata()[0].tolist() for line in panel.lines}
    assert marks == {"o": [112.5, 0.375], "+": [247.5, 0.875]}  # centres of cells of 45 deg
    values = {text.get_text(): text for text in panel.texts}
    assert values["9.2 um"].get_position()[1] < 0 < values["4.61 um"].get_position()[1]
    without = drawn_map(film(pressure=0 * pressure))
    assert not without.lines and not without.texts  # no pressure, no cross


def test_the_film_has_labelled_contours_and_a_line_where_it_ruptures():
    """The film grows along the height from 2 to 5 um, and is ruptured above the middle."""
    height = np.tile(np.arange(4.0), (8, 1))
    panel = drawn_map(film(pressure=1 + height, thickness=2 + height, fraction=1.2 - 0.14 * height))
    film_lines, rupture = panel.collections
    assert film_lines.levels.tolist() == [2.5, 3.0, 4.0]
    for level, path in zip(film_lines.levels, film_lines.get_paths()):
        assert path.vertices[:, 1] == pytest.approx((level - 1.5) / 4)  # of cells
    assert rupture.levels.tolist() == [STYLE["rupture"]] and rupture.get_linestyles()[0][1]
    assert rupture.get_paths()[0].vertices[:, 1] == pytest.approx(0.125 + 1.5 / 4)
    labels = [text for text in panel.texts if " " not in text.get_text()]
    assert [float(text.get_text()) for text in labels] == [2.5, 3.0, 4.0]
    full = drawn_map(film(pressure=1 + height, fraction=np.ones((8, 4))))
    assert not full.collections  # neither contours nor a rupture


def test_labels_of_contours_are_apart_from_marks_and_each_other():
    around, along = np.meshgrid(np.linspace(-1, 1, 8), np.linspace(-1, 1, 4), indexing="ij")
    thickness = 5 + 40 * (around**2 + along**2)
    panel = drawn_map(film(thickness=thickness))
    labels = [text.get_position() for text in panel.texts if " " not in text.get_text()]
    (mark,) = [line.get_xydata()[0] for line in panel.lines]
    places = np.array([*labels, mark]) / [360.0, 1.0]
    assert len(labels) >= 4
    for a, b in combinations(places, 2):
        assert (np.abs(a - b) > [0.1, 0.06]).any()
    assert (places > 0.04).all() and (places < 0.96).all()


@pytest.mark.parametrize(
    "low, high, levels",
    [
        (0.5, 6.0, [0.7, 1, 1.2, 1.5, 2, 2.5, 3, 4, 5]),
        (9.2, 29.0, [10, 12, 15, 20, 25]),
        (1.0, 100.0, [2, 5, 10, 20, 50]),
        (0.001, 9e4, [0.003, *(a * 10.0**k for k in range(-2, 5) for a in (1, 3))]),
        (3.0, 3.0, []),
    ],
)
def test_contours_are_at_round_values(low, high, levels):
    """Those of the list of digits with fewer than ten values inside; the last list if none has."""
    assert contour_levels(low, high) == pytest.approx(levels)


def test_other_fields_of_a_film_are_those_with_its_axes():
    """Film and gap share axes in a case; of two films with the same axes the gap is unknown."""
    recorded = ["bodies.film_thickness", "ehd.pressure", "ehd.film_fraction", "other.pressure"]
    units = {"film_thickness": "m", "film_fraction": "1"}

    def field(port, instant):
        return RecordedField(FIELD, 0.0, units.get(port.partition(".")[2], "Pa"), "")

    def film_of(names):
        results = run(recorded=names)
        results.field = field
        return results

    results = film_of(recorded)
    known = field_map(case_of(axes=SKIRT), results, "ehd.pressure", "0 s", {"ehd.pressure": "MPa"})
    assert {kind: layer.unit for kind, layer in known.layers.items()} == {
        "pressure": "MPa",
        "thickness": "\N{MICRO SIGN}m",
        "fraction": "",
    }
    assert known.values.max() == 1e-6 and known.label == "pressure [MPa]"
    twice = film_of([*recorded, "twin.film_thickness"])
    known = field_map(case_of(axes=SKIRT), twice, "ehd.pressure", "0 s", {})
    assert set(known.layers) == {"pressure", "fraction"}
    alone = field_map(case_of(), results, "ehd.pressure", "0 s", {})
    assert set(alone.layers) == {"pressure", "fraction"}  # without axes only its own
    heat = film_of([*recorded, "ehd.heat"])
    assert set(field_map(case_of(axes=SKIRT), heat, "ehd.heat", "0 s", {}).layers) == {"field"}


def test_a_turn_is_closed():
    """Five cells from -36 deg: one is repeated at each end, so that no angle is blank."""
    axes = Axes(
        participants=["ehd"],
        first=Axis(label="angle", unit="deg", range=(0, 360), centred=0),
        second=Axis(label="height"),
    )
    figure, panel = subplots(figsize=(6, 4))
    values = masked(np.arange(20.0).reshape(5, 4), None)
    one = FieldMap("q", "field", axes, "", {"field": Layer(values, "Pa")})
    draw_map(panel, one, map_row([one]))
    figure.canvas.draw()
    left, bottom, right, top = np.array(panel.get_window_extent().extents).astype(int)
    pixels = np.array(figure.canvas.buffer_rgba())[::-1][bottom + 2 : top - 2, :, :3]
    edges = pixels[:, [left + 2, right - 3]]
    assert not (edges > 250).all(axis=2).all(axis=0).any()  # no white strip on either side
    shown = panel.images[0]
    assert shown.get_array()[0].tolist() == [16.0, 0.0, 4.0, 8.0, 12.0, 16.0, 0.0]
    assert shown.get_extent()[:2] == pytest.approx([-108.0, 396.0])
    assert panel.get_xlim() == (0.0, 360.0)


@pytest.mark.parametrize(
    "field, time, why",
    [
        ("ehd.pressure", "1 s", None),
        ("ehd.heat", "1 s", "base has not recorded ehd.heat; name it in record.fields"),
        ("ehd.pressure", "1.1 s", "base does not reach 1.1 s"),
        ("ehd.pressure", "24 deg", "base does not reach 24 deg"),  # it says no crank angle
        ("ehd.pressure", "envelope", None),
        ("ehd.film_fraction", "envelope", "base has no envelope of ehd.film_fraction"),
    ],
)
def test_pictures_that_cannot_be_drawn_are_left_out_with_a_word(field, time, why):
    picture = Picture(file="map.png", title="Map", kind="map", fields=[field], time=time)
    envelope = {"ehd.pressure": Envelope(np.eye(4), "max", "Pa", "", every_step=True)}.get
    recorded = ["ehd.pressure", "ehd.film_fraction"]
    runs = {"base": run(recorded=recorded, envelope=envelope, period=0.0)}
    case = case_of(picture)
    assert left_out(case, runs) == ({"map.png": why} if why else {})
    assert len(list(figures(case, runs))) == (why is None)


@pytest.mark.parametrize(
    "unit, wanted, shown",
    [
        ("m", "um", "\N{MICRO SIGN}m"),
        ("m", None, "m"),
        ("1", None, ""),
        ("Pa", "MPa", "MPa"),
        ("1", "us_cup", "us_cup"),
    ],
)
def test_units_have_one_micro_sign(unit, wanted, shown):
    assert unit_shown(unit, wanted) == shown


def test_a_long_title_goes_on_in_a_second_line():
    title = "Pressure, film thickness and film fraction where the side force is largest " * 2
    picture = Picture(file="map.png", title=title, kind="map", fields=["ehd.pressure"], time="1 s")
    ((_, figure),) = figures(case_of(picture), {"base": run()})
    figure.canvas.draw()
    drawn = figure._suptitle.get_window_extent()
    assert drawn.x0 >= 0.0 and drawn.x1 <= figure.bbox.width
    assert " ".join(figure._suptitle.get_text().split()) == title.strip()


@pytest.mark.parametrize(
    "kind, begins, paper",
    [("svg", b"<?xml", True), ("pdf", b"%PDF", True), (None, b"\x89PNG", False)],
)
def test_pictures_of_every_type_are_small(tmp_path, kind, begins, paper):
    """Two runs with two fields of 40 x 40 cells and an opening in a skirt, and 1441 steps."""
    around, along = np.meshgrid(
        np.linspace(0, 2 * np.pi, 40), np.linspace(-1, 1, 40), indexing="ij"
    )
    there = np.abs(np.sin(around)) + np.abs(along) > 0.4
    angle = np.radians(np.linspace(0.0, 720.0, 1441))
    held = {
        "b.crank_angle": Series(angle, "rad", ""),
        "b.force": Series(np.sin(angle) + 0.1 * np.sin(37 * angle), "N", ""),
    }
    field = np.cos(2 * around) + along**2
    results = run(field, there, recorded=["a.x", "a.y"], series=held.get, ports=[*held])
    pictures = [
        Picture(file="map.png", title="Map", kind="map", fields=["a.x", "a.y"], time="0 s"),
        Picture(file="line.png", title="Line", kind="lines", x="b.crank_angle", y=[["b.force"]]),
    ]
    files = draw(
        case_of(*pictures, axes=SKIRT),
        {"flexible": results, "rigid": results},
        tmp_path,
        kind,
        paper,
    )
    assert [file.name for file in files] == [f"{name}.{kind or 'png'}" for name in ("map", "line")]
    for file in files:
        assert file.read_bytes().startswith(begins)
        assert file.stat().st_size < (200_000 if kind else 300_000)


@pytest.mark.parametrize("y, to_scale", [("m", True), ("N", False)])
def test_a_way_in_a_plane_is_drawn_to_scale(y, to_scale):
    held = {"a.x": ([0.0, 2.0], "m"), "a.y": ([1.0, 1.0], y)}
    (panel,) = lines_of([["a.y"]], "a.x", r=held).axes
    assert (panel.get_aspect() == 1.0) == to_scale


def test_curves_of_one_variable_of_four_films_are_told_apart():
    """By their participants' names, each in a style of its own; a fourth one was left out."""
    films = ("skirt", "small_end", "big_end", "main")
    ports = [f"{film}.minimum_film_thickness" for film in films]
    held = {port: ([0.0, 1.0], "m") for port in ports} | {"main.time": ([0.0, 1.0], "s")}
    (panel,) = lines_of([ports], "main.time", r=held).axes
    legend = [text.get_text() for text in panel.get_legend().get_texts()]
    assert legend[2] == "big end" and panel.get_ylabel() == "minimum film thickness [m]"
    assert len({*legend}) == 4 and len({line.get_linestyle() for line in panel.get_lines()}) == 4


def test_crank_angles_are_ticked_every_quarter_and_curves_of_zeros_left_out():
    """Two panels with the same runs share one legend. The second port of the first is zero."""
    held = {
        "b.crank_angle": ([0.0, 2 * np.pi], "rad"),
        "b.force": ([1.0, 2.0], "N"),
        "b.nothing": ([0.0, 0.0], "N"),
        "b.power": ([3.0, 4.0], "W"),
    }
    y = [["b.force", "b.nothing"], ["b.power"], ["b.nothing"]]
    units = {"b.crank_angle": "deg"}
    zero = held | {"b.power": held["b.nothing"]}
    figure = lines_of(y, units=units, r=held, zero=zero)
    assert [len(panel.lines) for panel in figure.axes] == [2, 1, 2]  # the last is zero in all runs
    figure = lines_of(y, units=units, r=held)
    assert [len(panel.lines) for panel in figure.axes] == [1, 1, 1]
    assert [panel.get_legend() is not None for panel in figure.axes] == [True, False, False]
    words = [label.get_text() for label in figure.axes[-1].get_xticklabels()]
    assert words == ["0\nTDC", "90", "180\nBDC", "270", "360\nTDC"]


def test_the_lowest_film_and_the_highest_pressure_of_curves_are_marked():
    film = ([9.0, 7.5, 8.0], "m")
    held = {"b.crank_angle": ([0.0, 1.0, 2.0], "rad"), "e.minimum_film_thickness": film}
    held |= {"e.maximum_pressure": ([1e6, 2e6, 5e6], "Pa"), "e.power": film}
    y = [["e.minimum_film_thickness"], ["e.maximum_pressure"], ["e.power"]]
    panels = lines_of(y, units={"e.maximum_pressure": "MPa"}, r=held).axes
    marks = [[line.get_xydata()[0].tolist() for line in panel.lines[1:]] for panel in panels]
    assert marks == [[[1.0, 7.5]], [[2.0, 5.0]], []]
    assert [[text.get_text() for text in panel.texts] for panel in panels] == [
        ["7.5 m"],
        ["5 MPa"],
        [],
    ]


@pytest.mark.parametrize(
    "points, anchors",
    [
        ([(50, 5), (52, 5.1)], ["end", "start"]),  # near: on both sides
        ([(52, 5), (50, 5)], ["start", "end"]),
        ([(50, 5), (50, 5)], ["end", "start"]),
        ([(50, 5), (52, 9)], ["middle", "middle"]),  # one below the other
        ([(2, 5), (98, 5)], ["start", "end"]),  # at the edges
    ],
)
def test_values_of_extremes_do_not_meet(points, anchors):
    """Each run has its highest value at a point; the chart is 100 wide and 10 high."""
    runs = {}
    for k, (x, y) in enumerate(points):
        held = {
            "b.crank_angle": ([0.0, x, 100.0], "rad"),
            "e.maximum_pressure": ([0.0, y, 0.0], "Pa"),
        }
        runs[f"r{k}"] = InMemory([], held)
    held = {"b.crank_angle": ([0.0, 100.0], "rad"), "e.maximum_pressure": ([-1.0, 10.0], "Pa")}
    runs["frame"] = InMemory([], held)
    y = [["e.maximum_pressure"]]
    picture = Picture(file="a.png", title="", kind="lines", x="b.crank_angle", y=y)
    (chart,) = line_charts(case_of(), picture, runs, None)
    assert [extreme.anchor for extreme in chart.extremes][:-1] == anchors


def deuteranopic(colour):
    """Lab colour as Machado et al. (2009) compute what a person without green cones sees."""
    values = np.array(to_rgb(colour))
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    seen = [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413]]
    seen.append([-0.011820, 0.042940, 0.968881])
    xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(xyz @ np.clip(seen @ linear, 0, 1) / [0.9505, 1.0, 1.089])
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("palette", [PALETTE, PALETTE_DARK])
def test_colours_of_runs_differ_for_colour_blind_readers(palette):
    """A colour difference of 10 is clear at a glance; red and green of equal light differ by 4."""
    seen = [deuteranopic(colour) for colour in palette]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 10
