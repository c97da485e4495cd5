"""The page of a sweep: its front, its links, and what stands in it in a browser."""

import numpy as np
import pytest

from piston_cosim.master.case.schema import check_case, find_case, read_tree
from piston_cosim.master.engine.headlines import larger_is_better
from piston_cosim.master.results import sweep_pictures
from piston_cosim.master.results.sweep_page import SweptPoint, write_sweep_page
from piston_cosim.master.results.sweep_pictures import draw_sweep
from piston_cosim.master.runs.sweep import Axis

from .browser import Browser, found


def front(points):
    """Mask of the points that no other is better than: smaller or equal in everything, and smaller
    in something.

    Parameters
    ----------
    points : ndarray, shape (n, k)
        Each column is to be small.
    """
    below = (points[None] <= points[:, None]).all(axis=2)
    better = below & (points[None] < points[:, None]).any(axis=2)
    return ~better.any(axis=1)


def test_a_front_is_what_no_other_point_is_better_than():
    points = np.array([[1, 5], [2, 2], [3, 3], [5, 1], [2, 2], [1, 6]])
    assert front(points).tolist() == [True, True, False, True, True, False]


ENTRIES = ["mean_friction_power_w", "slap_energy_j", "contact_share"]
FILM = "minimum_film_thickness_m"


def swept():
    """Clearance 10, 20, 30 um by ovality 1, 2: friction falls where slap grows."""
    rows = [
        {
            "bodies.clearance": f"{c} um",
            "ovality": o,
            "status": "done",
            "message": "",
            "mean_friction_power_w": 100.0 / c + o,
            "slap_energy_j": 1e-4 * c * o,
            "contact_share": 0.1 / c,
            FILM: 1e-6 * (c + o),
            "same": 1.0,
            "iterations": c + o,
        }
        for c in (10, 20, 30)
        for o in (1, 2)
    ]
    failed = {"bodies.clearance": "40 um", "ovality": 1, "status": "failed", "message": "no"}
    points = [SweptPoint(row, f"reports/{k}/report.html") for k, row in enumerate(rows)]
    return [*points, SweptPoint(failed, "")]


def test_pictures_have_handy_units_and_no_empty_axes(tmp_path, monkeypatch):
    """An entry without a number has no axes; a film in metres is drawn in micrometres."""
    seen = []
    monkeypatch.setattr(sweep_pictures, "save", lambda figure, path: seen.append(figure))
    rows = [
        {"gap": gap, "status": "done", "film_m": 1e-6 * k, "tilt_rad": 0.1, "none": None}
        | {"rounding": 1e-15}
        for k, gap in enumerate(("10 um", "20 um"))
    ]
    axis = Axis("gap", ("gap",), ("10 um", "20 um"))
    entries = ["film_m", "tilt_rad", "none", "not_there", "rounding"]
    draw_sweep(rows, [axis], entries, tmp_path / "sweep.png")
    draw_sweep(rows, [axis], entries[:1], tmp_path / "sweep.png")
    panels = [panel for figure in seen for panel in figure.axes]
    titles = [panel.get_title() for panel in panels]
    assert titles == ["film [\N{MICRO SIGN}m]", "tilt [deg]", "film [\N{MICRO SIGN}m]"]
    assert panels[0].lines[0].get_ydata() == pytest.approx([0.0, 1.0])
    assert panels[1].lines[0].get_ydata() == pytest.approx(np.degrees([0.1, 0.1]))
    assert {figure.get_supxlabel() for figure in seen} == {"gap [µm]"}


def test_every_point_links_to_its_report_and_the_front_is_that_of_the_table(tmp_path):
    if not found():
        pytest.skip("no chromium: the sweep's page was not looked at")
    points = swept()
    axes, weighed = ["bodies.clearance", "ovality"], [*ENTRIES, "same"]
    path = write_sweep_page(points, axes, weighed, tmp_path / "sweep.html")
    with Browser(tmp_path / "profile") as browser:
        browser.open(path)
        told = browser.run("""
          const links = name => [...document.querySelectorAll(`#${name} a`)]
            .map(one => one.getAttribute("href"));
          const marked = () => [...document.querySelectorAll("#pareto .dot")]
            .map(one => one.classList.contains("best"));
          const shown = ["x", "y", "z"].map(name => byId(name).selectedOptions[0].textContent);
          const all = marked();
          byId("z").value = byId("x").value; byId("z").onchange();
          return { all, two: marked(), shown, pareto: links("pareto"), parallel: links("parallel"),
            response: links("response"), points: links("points"), entries: data.entries,
            axes: data.axes.map(axis => axis.name),
            cells: [...document.querySelectorAll("#response a text")].map(one => one.textContent),
            wide: document.documentElement.scrollWidth - window.innerWidth };""")
        assert browser.said() == [] and browser.asked() == []
    links = [point.report for point in points[:-1]]
    assert told["pareto"] == told["parallel"] == told["points"] == links
    assert told["response"] == links  # of a grid of two keys, in its order
    # what does not vary is left out, and what nobody weighs designs by
    assert told["entries"] == ENTRIES
    assert told["shown"] == ["mean friction power [W]", "slap energy [mJ]", "contact share"]
    assert told["axes"] == ["clearance [um]", "ovality"]
    values = np.array([[point.row[name] for name in ENTRIES] for point in points[:-1]])
    assert told["all"] == front(values).tolist() and told["two"] == front(values[:, :2]).tolist()
    assert not all(told["two"])
    assert [float(text) for text in told["cells"]] == pytest.approx(values[:, 0], rel=1e-3)
    assert told["wide"] <= 0


def test_no_dominated_point_is_ringed_of_a_film_that_is_to_be_thick(tmp_path):
    """Friction is to be small and the film thick. Both directions can be changed by the case."""
    if not found():
        pytest.skip("no chromium: the sweep's page was not looked at")
    points = swept()
    axes, weighed = ["bodies.clearance", "ovality"], [ENTRIES[0], FILM]
    values = np.array([[point.row[name] for name in weighed] for point in points[:-1]])
    for larger, signs in (({FILM}, (1, -1)), ((), (1, 1)), (weighed, (-1, -1))):
        path = write_sweep_page(points, axes, weighed, tmp_path / "sweep.html", larger)
        with Browser(tmp_path / "profile") as browser:
            browser.open(path)
            ringed = browser.run("""
              byId("x").value = 0; byId("y").value = 1; byId("z").value = 0; byId("z").onchange();
              return [...document.querySelectorAll("#pareto .dot")]
                .map(one => one.classList.contains("best"));""")
        assert ringed == front(values * signs).tolist() and not all(ringed)


def test_a_thicker_minimum_film_is_better():
    path = find_case("data_sheet")
    case = check_case(read_tree(path), path)
    larger = larger_is_better(case)
    assert FILM in larger and "maximum_pressure_pa" not in larger
    assert "mean_friction_power_w" not in larger
