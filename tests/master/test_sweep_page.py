"""The page of a sweep: its front, its links, and what stands in it in a browser."""

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.engine.measures import directions
from piston_cosim.master.results.sweep_page import SweptPoint, write_sweep_page


def front(points):
    """Return the mask of the points that no other point dominates.

    A point dominates if it is smaller or equal in every column and smaller in one.

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
CONSTANT = ("same", "none", "rounding", "noise", "not_there")
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
            "none": None,
            "rounding": 1e-15 * c,
            "noise": 1.0 + 1e-9 * c,
            "iterations": c + o,
        }
        for c in (10, 20, 30)
        for o in (1, 2)
    ]
    failed = {"bodies.clearance": "40 um", "ovality": 1, "status": "failed", "message": "no"}
    points = [SweptPoint(row, f"reports/{k}/report.html") for k, row in enumerate(rows)]
    return [*points, SweptPoint(failed, "")]


RINGED = """const red = "[stroke='var(--red)']";
const places = group => [...document.querySelectorAll(`#pareto [aria-label=dot]${group} circle`)]
  .map(one => `${one.getAttribute("cx")} ${one.getAttribute("cy")}`);
const rings = new Set(places(red));
const ringed = () => places(`:not(${red})`).map(place => rings.has(place));
"""


def test_every_point_links_to_its_report_and_the_front_is_that_of_the_table(browser, tmp_path):
    points = swept()
    axes, directions = (
        ["bodies.clearance", "ovality"],
        dict.fromkeys([*ENTRIES, *CONSTANT], "lower"),
    )
    path = write_sweep_page(points, axes, directions, tmp_path / "sweep.html")
    browser.open(path)
    told = browser.run("""
      const links = name => [...document.querySelectorAll(`#${name} a`)]
        .map(one => one.getAttribute("href"));
      return { pareto: links("pareto"), parallel: links("parallel"), points: links("points"),
        response: links("response"), outputs: data.outputs.map(output => output.name),
        inputs: data.inputs.map(input => input.name),
        shown: ["x", "y", "z"].map(name => byId(name).selectedOptions[0].textContent),
        cells: [...document.querySelectorAll("#response [aria-label=text] text")]
          .map(one => one.textContent),
        best: [...document.querySelectorAll("#points tr.best a")]
          .map(one => one.getAttribute("href")),
        wide: document.documentElement.scrollWidth - window.innerWidth };""")
    assert browser.said() == [] and browser.asked() == []
    all_three = browser.run(RINGED + "return ringed();")
    browser.run("byId('z').value = byId('x').value; byId('z').onchange();")
    two = browser.run(RINGED + "return ringed();")
    links = [point.report for point in points[:-1]]
    assert told["pareto"] == told["parallel"] == told["response"] == links
    assert sorted(told["points"]) == sorted(links)
    # what does not vary is left out, and what has no declaration
    names = ["mean friction power [W]", "slap energy [mJ]", "contact share"]
    assert told["outputs"] == told["shown"] == names
    assert told["inputs"] == ["clearance [\N{MICRO SIGN}m]", "ovality"]
    values = np.array([[point.row[name] for name in ENTRIES] for point in points[:-1]])
    assert all_three == front(values).tolist() and two == front(values[:, :2]).tolist()
    assert told["best"] == [link for link, best in zip(links, front(values)) if best]
    assert not all(two)
    assert [float(text) for text in told["cells"]] == pytest.approx(values[:, 0], rel=5e-3)
    assert told["wide"] <= 0


def test_no_dominated_point_is_ringed_whatever_the_directions(browser, tmp_path):
    """Friction is to be small and the film thick; the page changes both directions."""
    points = swept()
    axes = ["bodies.clearance", "ovality"]
    values = np.array([[point.row[name] for name in (ENTRIES[0], FILM)] for point in points[:-1]])
    given = {ENTRIES[0]: "lower", FILM: "raise"}
    path = write_sweep_page(points, axes, given, tmp_path / "sweep.html")
    signs = {"lower": 1, "raise": -1, "none": 0}
    browser.open(path)
    for ways in (("lower", "raise"), ("lower", "lower"), ("raise", "raise"), ("none", "raise")):
        browser.run(f"""
          document.querySelectorAll("#directions select").forEach((select, k) => {{
            select.value = {list(ways)}[k];
            select.onchange();
          }});""")
        ringed = browser.run(RINGED + "return ringed();")
        wanted = front(values * [signs[way] for way in ways]).tolist()
        assert ringed == wanted and not all(ringed), ways
    browser.run("""document.querySelectorAll("#directions select").forEach(select => {
      select.value = "none"; select.onchange(); });""")
    assert not any(browser.run(RINGED + "return ringed();"))
    assert "none of these outputs has a direction" in browser.run(
        "return byId('front').textContent"
    )


def test_directions_are_declared_and_errors_of_the_solution_are_not_drawn():
    path = find_case("data_sheet")
    declared = directions(check_case(read_tree(path), path))
    assert declared[FILM] == "raise" and declared["maximum_pressure_pa"] == "lower"
    assert declared["lateral_displacement_min_m"] == "none"
    assert "mass_imbalance_max" not in declared
