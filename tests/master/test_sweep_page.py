"""The page of a sweep: its front, its links, and what stands in it in a browser."""

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.engine.answer import worst_check
from piston_cosim.master.engine.measures import directions
from piston_cosim.master.engine.verdicts import Verdict
from piston_cosim.master.fmi.quantities import numbers_text
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
        outputs: data.outputs.map(output => output.name),
        inputs: data.inputs.map(input => input.name),
        shown: ["x", "y", "z"].map(name => byId(name).selectedOptions[0].textContent),
        panels: [...document.querySelectorAll("#response section")].map(panel => ({
          output: panel.querySelector("select").selectedOptions[0].textContent,
          links: [...panel.querySelectorAll("a")].map(one => one.getAttribute("href")),
          values: [...panel.querySelectorAll("[aria-label=text] text")]
            .map(one => one.textContent) })),
        best: [...document.querySelectorAll("#points tr.best a")]
          .map(one => one.getAttribute("href")),
        wide: document.documentElement.scrollWidth - window.innerWidth };""")
    assert browser.said() == [] and browser.asked() == []
    all_three = browser.run(RINGED + "return ringed();")
    browser.run("byId('z').value = byId('x').value; byId('z').onchange();")
    two = browser.run(RINGED + "return ringed();")
    links = [point.report for point in points[:-1]]
    assert told["pareto"] == told["parallel"] == links
    assert sorted(told["points"]) == sorted(links)
    # what does not vary is left out, and what has no declaration
    names = ["mean friction power [W]", "slap energy [mJ]", "contact share"]
    assert told["outputs"] == told["shown"] == names
    assert told["inputs"] == ["clearance [\N{MICRO SIGN}m]", "ovality"]
    values = np.array([[point.row[name] for name in ENTRIES] for point in points[:-1]])
    assert all_three == front(values).tolist() and two == front(values[:, :2]).tolist()
    assert told["best"] == [link for link, best in zip(links, front(values)) if best]
    assert not all(two)
    for panel, k in zip(told["panels"], (0, 1, 2, 2), strict=True):  # three outputs vary
        assert panel["output"] == names[k] and panel["links"] == links
        scale = 1e3 if k == 1 else 1.0
        read = [float(text) for text in panel["values"]]
        assert read == pytest.approx(scale * values[:, k], rel=5e-3)  # three digits
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


NAMES = ["cold.csv", "measured/profile_of_the_cold_skirt.csv", "d_with_a_rather_long_name.csv"]
CHECKS = ["pass", "warning: periodicity", "fail: grid, mass balance"]


def named(reports=("", "", "")):
    """Three profiles by three clearances in two units, with checks and uncertainties."""
    rows = [
        {
            "clearance": clearance,
            "file": name,
            "status": "done",
            "worst_check": CHECKS[k],
            ENTRIES[0]: 105.0 + 0.01 * k + 0.001 * n,
            f"{ENTRIES[0]}_uncertainty": (0.5, None, "does not converge with the grid")[k],
            ENTRIES[1]: 1e-3 * (1 + k * n),
        }
        for n, clearance in enumerate(("20 um", "0.03 mm", "40 um"))
        for k, name in enumerate(NAMES)
    ]
    return [SweptPoint(row, reports[k % 3]) for k, row in enumerate(rows)]


def opened(browser, points, axes, folder):
    """Open the page of points in a browser."""
    directions = dict.fromkeys([*ENTRIES, FILM], "lower")
    browser.open(write_sweep_page(points, axes, directions, folder / "sweep.html"))


LABELS = """const boxes = (selector, parent = document) => [...parent.querySelectorAll(selector)]
  .map(one => ({ text: one.textContent, ...one.getBoundingClientRect().toJSON() }));
const meet = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom - 3
  && b.top < a.bottom - 3;
"""


@pytest.mark.parametrize("reports", [("", "", ""), ("", "one.html", ""), ("a", "b", "c")])
def test_parallel_coordinates_have_a_line_for_each_point(browser, tmp_path, reports):
    points = named(reports)
    opened(browser, points, ["clearance", "file"], tmp_path)
    lines = "document.querySelectorAll('#parallel [aria-label=line] path').length"
    assert browser.run(f"return {lines};") == len(points)
    assert browser.run("return document.querySelectorAll('#pareto circle[r=\"7\"]').length") == 9
    links = browser.run(
        "return [...document.querySelectorAll('#parallel a')].map(a => a.getAttribute('href'));"
    )
    assert links == [point.report or f"#point{k}" for k, point in enumerate(points)]
    assert browser.said() == []


def test_labels_of_axes_are_whole_different_and_apart(browser, tmp_path):
    """Names are names, lengths are in one unit, and values that differ have different labels."""
    opened(browser, named(), ["clearance", "file"], tmp_path)
    told = browser.run(
        LABELS
        + """return {
      ends: boxes("#parallel .ends text"), names: boxes("#parallel [aria-label=text] text"),
      svg: document.querySelector("#parallel > svg").getBoundingClientRect().toJSON(),
      overlaps: (all => all.flatMap((a, k) => all.slice(k + 1).filter(b => meet(a, b))
        .map(b => [a.text, b.text])))(boxes("#parallel > svg text")),
      ticks: [...document.querySelectorAll("[aria-label*='tick label'], .ramp svg")]
        .map(axis => [...axis.querySelectorAll("text")].map(one => one.textContent)) };"""
    )
    assert told["overlaps"] == []
    texts = [one["text"] for one in told["ends"]]
    assert texts == ["20", "30", "40", *NAMES, "105", "105.022", "1", "5"]
    for one in told["ends"] + told["names"]:
        assert one["left"] >= told["svg"]["left"] and one["right"] <= told["svg"]["right"]
        assert one["top"] >= told["svg"]["top"] - 1 and one["bottom"] <= told["svg"]["bottom"]
    assert len(told["ticks"]) >= 6
    for ticks in told["ticks"]:
        assert len({*ticks}) == len(ticks)


def test_each_row_has_its_worst_check_and_the_uncertainties(browser, tmp_path):
    opened(browser, named(), ["clearance", "file"], tmp_path)
    rows = browser.run("""return [...document.querySelectorAll("#points tr")].slice(1).map(row =>
      [row.id, ...[...row.children].map(cell => cell.textContent)]);""")
    table = {row[0]: row[1:] for row in rows}
    assert table["point0"] == ["20", NAMES[0], "✓ pass", "105.0 ± 0.5", "1"]
    assert table["point4"][2:4] == ["! warning: periodicity", "105.011 (uncertainty unknown)"]
    assert table["point8"][2:4] == [
        "✕ fail: grid, mass balance",
        "105.022 (does not converge with the grid)",
    ]
    read = browser.run("""const output = {
        values: [2.1714, 12345, 0.5, 7, 2e-10, 2.8e-5, 3.02, 542],
        uncertainties: [0.0814, 1534, 0.148, 0, 4e-7, 1.64e-5, 2.43, 458] };
      return output.values.map((_, design) => reading(output, design));""")
    large = "2.17 ± 0.08", "12300 ± 1500", "0.50 ± 0.15"
    as_terminal = [numbers_text(*one).replace("+-", "±") for one in ((3.02, 2.43), (542.0, 458.0))]
    assert as_terminal == ["3.0 ± 2.4", "540 ± 460"]
    assert read == [*large, "7", "0 ± 4e-7", "2.8e-5 ± 1.6e-5", *as_terminal]


def test_a_point_without_checks_says_so_and_constant_inputs_are_drawn(browser, tmp_path):
    points = [SweptPoint({"a": 1, ENTRIES[0]: 1.0 + k, "status": "done"}, "") for k in range(2)]
    opened(browser, points, ["a"], tmp_path)
    told = browser.run("""return [...document.querySelectorAll("#points tr")].slice(1).map(row =>
      [...row.children].map(cell => cell.textContent));""")
    assert told == [["1", "not known", "1"], ["1", "not known", "2"]]
    lines = "return document.querySelectorAll('#parallel [aria-label=line] path').length;"
    assert browser.run(lines) == 2 and browser.said() == []


def test_a_map_over_two_numbers_is_linear_between_its_points(browser, tmp_path):
    """Of 3 x 2 points one is missing: its cell is blank; the other has the mean in its middle."""
    points = swept()[1:]
    opened(browser, points, ["bodies.clearance", "ovality"], tmp_path)
    told = browser.run("""const [across, up] = inputs;
      const value = surface(outputs[0], designs, across, up);
      return { middle: value(25, 1.5), blank: Number.isNaN(value(15, 1.5)),
        corners: designs.map(k => value(across.values[k], up.values[k])),
        ticks: [...document.querySelectorAll("#drawn0 [aria-label='x-axis tick label'] text")]
          .map(one => one.textContent),
        drawn: document.querySelectorAll("#response [aria-label=raster] image").length };""")
    values = np.array([point.row[ENTRIES[0]] for point in points[:-1]])
    assert told["blank"] and told["drawn"] == 4
    assert told["middle"] == pytest.approx(values[1:].mean(), rel=1e-12)  # linear along both
    assert told["corners"][1:] == pytest.approx(values[1:], rel=1e-9)
    assert told["ticks"] == ["10", "20", "30"]


@pytest.mark.parametrize(
    "axes, drawn",
    [
        (["clearance", "file"], "#drawn0 [aria-label=line] path"),
        (["file"], "#drawn0 circle"),
        (["file", "status"], "#drawn0 [aria-label=cell] rect"),
    ],
)
def test_names_are_curves_points_or_cells(browser, tmp_path, axes, drawn):
    """Three names: a curve for each, a point for each, or a row for each."""
    points = named()
    points = points if len(axes) == 2 and axes[0] == "clearance" else points[:3]
    opened(browser, points, axes, tmp_path)
    found = browser.run(f"return document.querySelectorAll({drawn!r}).length;")
    assert found == 3 and browser.said() == []


@pytest.mark.parametrize(
    "key, words",
    [
        ("participants.bodies.build.piston.profiles.0.file", "profiles file"),
        ("participants.bodies.build.gas.file", "gas file"),
        ("participants.bodies.parameters.crank_speed", "crank speed"),
        ("file", "file"),
    ],
)
def test_a_varied_file_is_named_by_what_it_contains(browser, tmp_path, key, words):
    points = [SweptPoint({key: "a.csv", ENTRIES[0]: k, "status": "done"}, "") for k in (1, 2)]
    opened(browser, points, [key], tmp_path)
    assert browser.run("return inputs.map(input => input.name);") == [words]


def test_the_worst_check_of_a_run_has_its_names():
    fine, warned, failed = (
        [Verdict(colour, what, "") for what in names]
        for colour, names in (("green", "ab"), ("amber", "c"), ("red", "dde"))
    )
    assert worst_check([*fine, *warned, *failed]) == "fail: d, e"
    assert worst_check([*warned, *fine]) == "warning: c"
    assert worst_check(fine) == "pass" and worst_check([]) == ""


def test_the_page_of_two_points_has_their_comparison(tmp_path):
    for sentence, shown in (("Oil a lowers b by 2 +- 1 µm.", True), ("", False)):
        path = write_sweep_page(swept()[:2], ["ovality"], {FILM: "raise"}, tmp_path / "a", sentence)
        assert ("<p>Oil a lowers b by 2 \N{PLUS-MINUS SIGN} 1 µm.</p>" in path.read_text()) == shown
