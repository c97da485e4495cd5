"""Pictures of runs, also of fields that are the same everywhere."""

from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import LogNorm, to_rgb

from piston_cosim.master.case.shown import NEUTRAL, Axes, Axis, Picture
from piston_cosim.master.results.figures import subplots
from piston_cosim.master.results.pictures import (
    PALETTE,
    PALETTE_DARK,
    colour_norm,
    draw,
    draw_lines,
    draw_map,
    draw_maps,
    draw_sections,
    figures,
    left_out,
    unit_shown,
)
from piston_cosim.master.results.recorded import Envelope, RecordedField, Series

from .by_hand import InMemory

FIELD = np.eye(4)


def run(field=FIELD, there=None, **more):
    """Return a run that has recorded a field."""
    usual = {"recorded": ["ehd.pressure"], "ports": [], "time": np.array([0.0, 0.5, 1.0])}
    given = {"case": {"participants": {}}, "there": lambda port: there}
    given["field"] = lambda port, instant: RecordedField(field, 0.0, "Pa", "")
    return SimpleNamespace(**usual | given | more)


def case_of(*pictures, axes=NEUTRAL):
    return SimpleNamespace(pictures=pictures, axes_of=lambda port: axes, window={})


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


@pytest.mark.parametrize(
    "field, lines", [(np.ones((5, 4)), False), (np.arange(20.0).reshape(5, 4), True)]
)
def test_a_map_has_contours_where_there_is_something_to_contour(field, lines):
    panel = map_of(run(field))
    drawn = [
        len(path.vertices) for collection in panel.collections for path in collection.get_paths()
    ]
    assert len(panel.images) == 1 and (sum(drawn) > 0) == lines


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


def test_a_cut_out_stays_blank_and_a_wide_range_is_logarithmic():
    field = 10.0 ** np.arange(20.0).reshape(5, 4)[::-1]
    there = np.ones((5, 4), bool)
    there[0, 3] = False  # the largest: it must not set the scale either
    image = map_of(run(field, there)).images[0]
    shown = image.get_array()
    assert shown.mask.T.tolist() == (~there).tolist()
    assert isinstance(image.norm, LogNorm)
    assert (image.norm.vmin, image.norm.vmax) == pytest.approx((1e14, 1e18))  # four decades


def test_colours_are_linear_without_a_single_high_cell():
    assert not isinstance(colour_norm([np.array([0.0, 1.0, 2.0, 30.0])]), LogNorm)  # 15 medians
    assert isinstance(colour_norm([np.array([0.0, 1.0, 1.0, 31.0])]), LogNorm)
    assert not isinstance(colour_norm([np.array([-1.0, 1.0, 1.0, 31.0])]), LogNorm)
    assert not isinstance(colour_norm([np.zeros(3)]), LogNorm)


def test_a_turn_is_closed():
    """Five cells from -36 deg: one is repeated at each end, so that no angle is blank."""
    axes = Axes(
        participants=["ehd"],
        first=Axis(label="angle", unit="deg", range=(0, 360), centred=0),
        second=Axis(label="height"),
    )
    figure, panel = subplots(figsize=(6, 4))
    draw_map(panel, np.ma.array(np.arange(20.0).reshape(5, 4)), colour_norm([np.ones(2)]), axes)
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
    results = run(field, there, recorded=["a.x", "a.y"], series=held.get)
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
