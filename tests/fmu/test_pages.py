"""Reports of computed runs in a browser: a flexible piston, a rigid one, a bearing, a pin on four
films, two cylinders. The page is gone through by keys; what it draws is what the results hold.
"""

import csv
import re
from pathlib import Path
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
from scipy.spatial import cKDTree

from piston_cosim.fmu_mfbd.offline import recover
from piston_cosim.master.api.bodies import build_table
from piston_cosim.master.case.schema import check_case, find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.commands import sweep
from piston_cosim.master.commands.common import body_skins, page_of
from piston_cosim.master.commands.results import movie
from piston_cosim.master.engine.impacts import impacts
from piston_cosim.master.fmi.quantities import pint_unit, registry
from piston_cosim.master.results.file import Results
from piston_cosim.master.results.pictures import names_of
from piston_cosim.master.runs.run import run

from ..master.browser import Browser, found

SMALL = [("participants.bodies.build.grid", [20, 16]), ("participants.ehd.build.grid", [20, 16])]
CASES = {
    # bodies as they are, for other tests have reduced them
    "flexible": ("numerical_example", [("time.stop", "20 deg"), ("time.step", "2 deg")]),
    "rigid": ("data_sheet", [*SMALL, ("time.stop", "40 deg"), ("time.step", "2 deg")]),
    "bearing": ("journal_bearing", [("time.stop", "8 ms")]),
    "pin": ("floating_pin", [("time.stop", "16 deg")]),
    "twin": ("twin", [("time.stop", "12 deg")]),
}
"""A case, and what is changed for it to be short."""
SLOW = {"twin": pytest.mark.slow, "pin": pytest.mark.slow}


@pytest.fixture(
    scope="module", params=[pytest.param(name, marks=SLOW.get(name, ())) for name in CASES]
)
def seen(request, tmp_path_factory):
    """A run, its results and its page, the results in a folder that is not named after the case."""
    if not found():
        pytest.skip("no chromium: no page was looked at")
    name, changes = CASES[request.param]
    folder = tmp_path_factory.mktemp(request.param)
    path = find_case(name)
    tree = read_tree(path, changes)
    case = check_case(tree, path)
    system = open_system(case, path.parent, lambda text: None)
    run(system, case, tree, folder / "run.h5")
    results = Results(folder / "run.h5")
    runs = {"run": results}
    page = page_of(check_case(results.case, path), runs, folder / "report", figures=False)
    with Browser(folder / "profile", 1400, 900) as browser:
        browser.open(page)
        yield SimpleNamespace(
            kind=request.param, case=case, path=path, runs=runs, results=results, browser=browser
        )
    results.close()


# cells of every map of a field by the nearest colour of its legend, at every fourth instant; no
# chart is drawn yet, which would be drawn anew each time
READ = """
for (const box of document.querySelectorAll("#fields label input"))
  if (box.parentElement.textContent.includes("contours") && box.checked) box.click();
const read = [], picture = canvas => {
  const copy = document.createElement("canvas");
  copy.width = canvas.width; copy.height = canvas.height;
  const pen = copy.getContext("2d", { willReadFrequently: true });
  pen.drawImage(canvas, 0, 0);
  return pen.getImageData(0, 0, copy.width, copy.height);
};
for (let k = 0; k < positions.length; k += 4) {
  go(k); repainters.forEach(paint => paint());
  for (const canvas of document.querySelectorAll("#fields canvas")) {
    const map = canvas.map;
    if (!map || map.difference) continue;
    const legend = document.querySelector(`[data-legend="${map.field.name}"]`);
    const scale = legend.scale, ratio = canvas.ratio;
    const bar = picture(legend), own = picture(canvas), colours = [], shares = [], there = [];
    const dot = (image, x, y) => {
      const at = 4 * (Math.floor(y * ratio) * image.width + Math.floor(x * ratio));
      return image.data.subarray(at, at + 4);
    };
    const wide = Math.floor(scale.right - scale.left);
    for (let x = 0; x < wide; x++) colours.push(dot(bar, scale.left + x + .5, 6));
    const [n, m] = map.run.shape, box = map.box;
    for (let i = 0; i < n; i++) for (let j = 0; j < m; j++) {
      const x = box.left + (i + .5) / n * box.width, y = box.top + (1 - (j + .5) / m) * box.height;
      const [r, g, b, a] = dot(own, x, y);
      let best = 0, least = Infinity;
      colours.forEach((c, k) => {
        const apart = Math.abs(c[0] - r) + Math.abs(c[1] - g) + Math.abs(c[2] - b);
        if (apart < least) { least = apart; best = k; }
      });
      shares.push((best + .5) / wide); there.push(a > 0);
    }
    read.push({ name: map.field.name, unit: map.field.unit, frame: map.frame(), low: scale.low,
      high: scale.high, log: scale.logarithmic, shares, there });
  }
}
return read;
"""


def test_every_recorded_instant_is_reached_by_arrow_keys(seen):
    browser, count = seen.browser, len(seen.results.instants)
    browser.run("byId('instant').focus(); go(0);")
    places = []
    for _ in range(count):
        places.append(browser.run("return byId('place').textContent"))
        browser.key("ArrowRight")
    told = [re.search(r"\((\d+) of (\d+)\)", place) for place in places]
    assert [(int(one[1]), int(one[2])) for one in told if one] == [
        (k + 1, count) for k in range(count)
    ]


def test_colours_of_every_map_are_the_values_of_the_file(seen):
    read = seen.browser.run(READ)
    ports = [
        port
        for port in seen.case.record.fields
        if port in seen.results.recorded and seen.results.dataset(port).ndim == 3
    ]
    named = {name: port for port, name in names_of(ports).items()}
    assert {one["name"] for one in read} <= {*named} and read
    for one in read:
        port = named[one["name"]]
        dataset = seen.results.dataset(port)
        si = registry().Quantity(1.0, pint_unit(dataset.attrs["unit"]))
        factor = si.to(one["unit"] or "1").magnitude if one["unit"] else 1.0
        held = dataset[one["frame"]].ravel() * factor
        there = np.array(one["there"])
        cells = seen.results.there(port)
        assert (there == (True if cells is None else cells.ravel())).all(), one["name"]
        limits = np.array([one["low"], one["high"]])
        own = held[there].clip(*limits)
        if one["log"]:
            own, limits = np.log(own), np.log(limits)
        shown = limits[0] + np.array(one["shares"])[there] * np.ptp(limits)
        assert shown == pytest.approx(own, abs=0.01 * np.ptp(limits)), one["name"]


def test_tables_hold_the_numbers_of_the_file(seen):
    shown = seen.browser.run(
        "return [...document.querySelectorAll('td[data-value]')].map(one => +one.dataset.value)"
    )
    expected = []
    for text in seen.case.summary.values():
        kind, _, port = text.partition(" ")
        if kind in ("min", "max"):
            values = seen.results.series(port).values
            expected.append(values.min() if kind == "min" else values.max())
    assert shown == expected and shown


def test_bodies_are_where_recover_puts_them(seen, tmp_path):
    """Displacements of all corners at the last instant, those of modes and of the rigid motion."""
    if seen.kind == "bearing":
        assert not seen.browser.run("return data.solids.runs.some(run => run.length)")
        return
    frame = len(seen.results.instants) - 1
    solids = seen.browser.run(f"""
      const meshes = await Promise.all(data.solids.meshes.map(unpackMesh));
      return data.solids.runs[0].map(solid => {{
        const mesh = meshes[solid.mesh], moved = displaced(solid, mesh, {frame});
        return {{ name: solid.name, owner: solid.owner, held: solid.held, count: solid.count,
          points: [...mesh.points], moved: [...moved], moves: Boolean(solid.motion),
          places: [...placed(solid, mesh, moved, {frame}, 1)] }};
      }});""")
    assert all(one["held"] for one in solids)
    if seen.kind == "flexible":
        modal = seen.results.dataset("bodies.modal_coordinate")[frame]
        table = build_table(seen.results.case)
        recover(table, seen.path.parent, modal, tmp_path / "at", lambda text: None)
    for one in solids:
        points = np.reshape(one["points"], (-1, 3))
        moved = np.reshape(one["moved"], (-1, 3))
        if seen.kind == "flexible":
            mesh = meshio.read(tmp_path / f"at-{one['name']}.vtu")
            away, nearest = cKDTree(mesh.points).query(points)
            assert away.max() < 1e-7  # single precision of 0.1 m
            name = next(name for name in mesh.point_data if name.startswith("displacement"))
            whole = mesh.point_data[name][nearest]
            assert moved == pytest.approx(whole, abs=1e-6 * np.abs(whole).max())
        else:
            assert one["count"] == 0 and not moved.any()
        if one["moves"]:
            ports = ("lateral_displacement", "piston_position", "rocking_angle")
            owner = one["owner"] or "bodies"
            at = seen.results.instants[frame]
            across, along, turn = (
                np.interp(at, seen.results.time, seen.results.series(f"{owner}.{name}").values)
                for name in ports
            )
            c, s = np.cos(turn), np.sin(turn)
            turned = (points + moved) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
            # single precision of up to 0.4 m
            expected = turned + [across, along, 0]
            assert np.reshape(one["places"], (-1, 3)) == pytest.approx(expected, abs=1e-7)


def test_several_cylinders_and_films_have_their_names(seen):
    told = seen.browser.run("""return {
      words: document.body.innerText, colours: [...document.querySelectorAll(
        "#solids select")].slice(0, 1).flatMap(one => [...one.options].map(o => o.textContent)),
      fields: data.fields.map(one => one.name), strip: data.strip.map(one => one.name) };""")
    assert len({*told["fields"]}) == len(told["fields"]) > 0
    if seen.kind == "twin":
        for name in ("front", "rear"):
            assert f"side force, {name}" in told["strip"]
            for words in ("slap, {}", "side force of {}", "Motion of the piston: {}", "run, {}: "):
                assert words.format(name) in told["words"]
    if seen.kind == "pin":
        # what lies in the pin's bearings is not painted on the skirt
        assert any("skirt" in name for name in told["colours"])
        assert not any("left" in name or "end" in name for name in told["colours"])


def test_a_series_holds_every_cylinder_and_film_at_its_place(seen, tmp_path):
    """Cylinders of 55 mm at z = -65 and 65 mm; of the pin's films the eye in the middle, the left
    boss beside it.
    """
    if seen.kind not in ("twin", "pin"):
        return
    target = tmp_path / "run.pvd"
    movie.command(seen.results.path, frames=2, case=str(seen.path), output=target)
    files = {file.stem[:-6]: file for file in sorted((tmp_path / "run").iterdir())}
    ends = {}
    for name, file in files.items():
        z = 1e3 * meshio.read(file).points[:, 2]
        ends[name] = (z.min(), z.max())
    cylinder = {"piston": (-54.95, 54.95), "film": (-55, 55)}
    expected = {
        "twin": {
            f"{owner}_{part}": (low + z, high + z)
            for owner, z in (("front", -65), ("rear", 65))
            for part, (low, high) in cylinder.items()
        },
        "pin": {
            "piston": cylinder["piston"],
            "skirt_film": cylinder["film"],
            "left_film": (-43, -18),
            "small_end_film": (-18, 18),
        },
    }[seen.kind]
    assert {name.replace("block", "") for name in files} - {"", "front_", "rear_"} == {*expected}
    for name, wanted in expected.items():
        # the outermost corners of 40 cells around are 0.2 mm within the circle
        assert ends[name] == pytest.approx(wanted, abs=0.2), name


REACHED = """const one = document.activeElement;
  return one === document.body ? "" : one.dataset.stop || one.tagName;"""


def test_every_control_is_reached_by_keys(seen):
    """Tab goes from control to control, arrow keys along the buttons of a chart, turn the bodies
    and go over a map; space plays and stops.
    """
    browser = seen.browser
    controls = browser.run("""
      waiting.forEach(([, draw]) => draw());
      await new Promise(done => setTimeout(done, 300));
      const all = document.querySelectorAll(
        "button, select, input, summary, a[href], canvas[tabindex], .chart");
      const shown = [...all].filter(one => one.checkVisibility() && !one.disabled);
      shown.forEach((one, k) => { one.dataset.stop = k; });
      document.activeElement.blur(); window.scrollTo(0, 0);
      return shown.map(one => ({ stop: one.dataset.stop,
        bar: one.closest(".modebar") ? one.closest(".chart").dataset.stop : null }));""")
    reached = set()
    browser.key("Tab")
    for _ in range(len(controls) + 5):
        stop = browser.run(REACHED)
        if stop in reached:
            break
        if stop:  # nothing between the last one and the first
            reached.add(stop)
        browser.key("Tab")
    bars = {one["bar"] for one in controls if one["bar"] is not None}
    for bar in list(bars)[:2]:
        first = browser.run(f"""const bar = document.querySelector(
          '[data-stop="{bar}"] .modebar');
          bar.querySelector('[tabindex="0"]').focus(); return bar.querySelectorAll("button").length;
        """)
        for _ in range(first):
            reached.add(browser.run(REACHED))
            browser.key("ArrowRight")
    wanted = {one["stop"] for one in controls if one["bar"] is None or one["bar"] in list(bars)[:2]}
    assert wanted - reached == set()
    browser.run("byId('play').focus();")
    browser.key(" ")
    assert browser.run("return playing")
    browser.key(" ")
    assert not browser.run("return playing")
    browser.run("document.querySelector('#fields canvas[tabindex]').focus();")
    browser.key("ArrowRight")
    told = browser.run("return tip.style.display === 'block' && tip.textContent")
    assert "angle" in told or "along" in told
    if seen.kind != "bearing":
        browser.run("document.querySelector('.scene canvas').focus();")
        view = "return { ...document.querySelector('.scene canvas').scene.controls.view };"
        before = browser.run(view)
        browser.key("ArrowRight")
        browser.key("+")
        after = browser.run(view)
        assert after["round"] != before["round"] and after["half"] < before["half"]
    assert browser.said() == [] and browser.asked() == []


def test_results_in_any_folder_find_their_bodies(seen):
    skins = body_skins(seen.runs, None)
    assert ("run" in skins) == (seen.kind != "bearing")


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A sweep of two by two short runs and its reports, as the command makes them."""
    if not found():
        pytest.skip("no chromium: the sweep's page was not looked at")
    folder = tmp_path_factory.mktemp("sweep")
    # the first impact is about 90 deg after the start
    changes = [*SMALL, ("time.stop", "120 deg"), ("time.step", "4 deg"), ("record.every", "40 deg")]
    given = {
        "vary": ["radial_clearance=40um;60um", "barrel=20um;40um"],
        "set_": [f"{key}={value!r}" for key, value in changes],
        "output": folder,
        "workers": 2,
    }
    sweep.command("data_sheet", **given)
    assert not (folder / "reports").exists()  # only when asked for
    sweep.command("data_sheet", **given, reports=True)
    return folder


def test_each_point_of_a_sweep_leads_to_its_report(swept, tmp_path):
    with open(swept / "sweep.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["status"] for row in rows] == ["done"] * 4
    with Browser(tmp_path / "profile") as browser:
        browser.open(swept / "sweep.html")
        told = browser.run("""return {
          links: Object.fromEntries(["pareto", "parallel", "response", "points"].map(name =>
            [name, [...document.querySelectorAll(`#${name} a`)].map(a => a.getAttribute("href"))])),
          entries: data.entries, said: data.said, values: data.points.map(one => one.values),
          axes: data.axes.map(one => one.name), shown: ["x", "y", "z"].map(name =>
            byId(name).selectedOptions[0].textContent) };""")
        pages = [f"reports/{Path(row['results']).stem}/report.html" for row in rows]
        assert all(told["links"][name] == pages for name in told["links"])
        assert told["axes"] == ["radial clearance [um]", "barrel [um]"]
        assert {text.partition(" [")[0] for text in told["shown"]} >= {"slap energy"}
        for k, row in enumerate(rows):
            with Results(swept / "runs" / f"{Path(row['results']).stem}.h5") as results:
                slap = max(impact.loss for impact in impacts(results.last, "bodies"))
            values = dict(zip(told["entries"], told["values"][k]))
            assert float(row["slap_energy_j"]) == slap
            for name in ("slap_energy_j", "largest_rocking_angle_rad", "minimum_film_thickness_m"):
                unit = told["said"][told["entries"].index(name)].partition("[")[2].strip("]")
                shown = registry().Quantity(values[name], unit).to_base_units().magnitude
                assert shown == pytest.approx(float(row[name]), rel=1e-9)
        # by keys alone: Tab to the first point of the front, Enter opens its report
        for _ in range(20):
            browser.key("Tab")
            if browser.run("return document.activeElement.closest('#pareto') !== null"):
                break
        browser.key("Enter")
        browser.run(
            "while (!location.pathname.endsWith('report.html') ||"
            " document.body?.dataset.page !== 'ready')"
            " await new Promise(done => setTimeout(done, 50));"
        )
        assert browser.run("return data.solids.runs[0].length") == 2
        assert browser.said() == [] and browser.asked() == []
