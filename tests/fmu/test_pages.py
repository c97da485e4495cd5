"""Reports of computed runs in a browser.

The runs are a flexible piston, a rigid one, a bearing, a pin on four films, and two cylinders.
The tests go through the page by keys and compare what it draws with the results.
"""

import re
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
from scipy.spatial import cKDTree

from piston_cosim.fmu_mfbd.offline import recover
from piston_cosim.master.api.bodies import build_table
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.contract import envelope_kinds, players
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.commands.common import body_skins, page_of
from piston_cosim.master.engine.crank_drive import AROUND
from piston_cosim.master.engine.sections import special
from piston_cosim.master.fmi.quantities import pint_unit, registry
from piston_cosim.master.results.report import views

from ..master.browser import Browser
from .runs import coarse, run_tree

SMALL = coarse(grid=(20, 16), modes=None)
CASES = {
    # bodies as they are, for other tests have reduced them
    "flexible": ("numerical_example", [("time.stop", "20 deg"), ("time.step", "2 deg")]),
    "rigid": (
        "data_sheet",
        [*SMALL, ("time.stop", "40 deg"), ("time.step", "2 deg"), ("record.every", 1)],
    ),
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
    """Yield a run, its results and its page.

    The folder of the results is not named after the case.
    """
    name, changes = CASES[request.param]
    folder = tmp_path_factory.mktemp(request.param)
    path = find_case(name)
    with Browser(folder / "profile", 1400, 900) as browser:  # first: without one, nothing is run
        tree = read_tree(path, changes)
        case, results = check_case(tree, path), run_tree(path, tree, folder / "run.h5")
        runs = {"run": results}
        browser.open(page_of(check_case(results.case, path), runs, folder / "report"))
        yield SimpleNamespace(
            kind=request.param, case=case, path=path, runs=runs, results=results, browser=browser
        )
    results.close()


def test_envelopes_are_the_extremes_of_all_steps(seen):
    """The rigid run records every step, the others few of them."""
    results = seen.results
    kinds = {port: one for port in envelope_kinds(results.case) if (one := results.envelope(port))}
    # no participant of the bearing has a role
    assert bool(kinds) == (seen.kind != "bearing")
    assert all(one.every_step for one in kinds.values())
    for port in {*kinds} & {*seen.results.recorded}:
        recorded = seen.results.dataset(port)[:]
        extreme = recorded.min(axis=0) if kinds[port].kind == "min" else recorded.max(axis=0)
        if seen.kind == "rigid":
            assert (kinds[port].values == extreme).all()
        sign = 1 if kinds[port].kind == "max" else -1
        assert (sign * kinds[port].values >= sign * extreme).all()
    for film in players(seen.results.case, "lubrication"):
        highest = seen.results.series(f"{film}.maximum_pressure").values.max()
        assert kinds[f"{film}.pressure"].values.max() == pytest.approx(highest, rel=1e-12)


SHOW = """byId("film").value = chosen.film = %d; chosen.colour = "%s"; await showFilm(); go(%d);"""
# the middle pixel of every cell of the map, and the paths of the section or the orbit
READ = """
const canvas = document.querySelector("#maps canvas"), { map, cell: [kx, ky] } = canvas;
const [n, m] = map.run.shape, cells = [], copy = document.createElement("canvas");
copy.width = canvas.width; copy.height = canvas.height;
const pen = copy.getContext("2d", { willReadFrequently: true });
pen.drawImage(canvas, 0, 0);
for (let i = 0; i < n; i++) for (let j = 0; j < m; j++)
  cells.push([...pen.getImageData((i + .5) * kx, canvas.height - (j + .5) * ky, 1, 1).data]);
return { cells, low: map.layer.low, high: map.layer.high, unit: map.layer.unit,
  ramp: [...new Uint8Array(rampOf(map.kind).buffer)], frame: data.cursor.frames[0][instant],
  lines: [...document.querySelectorAll("#maps .side [data-run]")].map(one =>
    ({ ...one.dataset, kind: one.classList[0], path: one.getAttribute("d") })) };
"""


def scale(unit, wanted):
    """Factor from a unit of the file to one of the page."""
    return registry().Quantity(1.0, pint_unit(unit)).to(wanted or "1").magnitude


def points_of(path):
    return np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", path), float)


def test_colours_of_every_map_are_the_values_of_the_file(seen):
    """The centre of a cell has the colour of its value, without interpolation."""
    films = views(seen.case, seen.runs, special(seen.case, seen.runs))
    assert len(films) == {"twin": 2, "pin": 3, "bearing": 3}.get(seen.kind, 1)
    for number, film in enumerate(films):
        for kind, port in film.layers.items():
            if port not in seen.results.recorded:
                continue
            dataset, there = seen.results.dataset(port), seen.results.existing_cells(port)
            there = np.ones(dataset.shape[1:], bool) if there is None else there.astype(bool)
            for k in (1, len(dataset) - 1):
                one = seen.browser.run(SHOW % (number, kind, k) + READ)
                factor = scale(dataset.attrs["unit"], one["unit"])
                spread = np.array([dataset[:][:, there].min(), dataset[:][:, there].max()]) * factor
                assert [one["low"], one["high"]] == pytest.approx(spread, rel=1e-6, abs=1e-12)
                share = (dataset[one["frame"]][there] * factor - spread[0]) / (np.ptp(spread) or 1)
                ramp = np.array(one["ramp"], float).reshape(-1, 4)
                wanted = ramp[np.round(share * (len(ramp) - 1)).astype(int)]
                cells = np.array(one["cells"], float)[there.ravel()]
                # half a colour of the table, 16 bits of the field
                assert np.abs(cells - wanted).max() <= 2, (port, k)


def test_the_section_shows_gaps_and_pressures_of_the_file(seen):
    films = views(seen.case, seen.runs, special(seen.case, seen.runs))
    for number, film in enumerate(films):
        k = len(seen.results.instants) - 1
        one = seen.browser.run(SHOW % (number, "pressure", k) + READ)
        assert bool(one["lines"]) == (seen.kind != "bearing"), film.title
        for line in one["lines"]:
            points = points_of(line["path"])
            if film.orbit:
                ((x, y),) = film.orbit.paths
                drawn = np.column_stack([x, -np.asarray(y)]) * float(line["gain"])
                assert points - points[0] == pytest.approx(drawn - drawn[0], abs=0.011)
                continue
            kind = {"gap": "thickness", "load": "pressure"}[line["kind"]]
            dataset = seen.results.dataset(film.layers[kind])
            column = {"thrust": 90, "anti-thrust": 270}[line["side"]] * dataset.shape[1] // 360
            unit = {"gap": "um", "load": "MPa"}[line["kind"]]
            own = dataset[one["frame"]][column] * scale(dataset.attrs["unit"], unit)
            points = points[1:-1] if line["kind"] == "load" else points  # without its ends
            read = (points[:, 0] - float(line["wall"])) / float(line["gain"])
            assert read == pytest.approx(own[: len(read)], abs=0.006 / abs(float(line["gain"])))
            heights = (8 + 256 - points[:, 1]) / 256
            assert heights == pytest.approx((np.arange(len(own)) + 0.5) / len(own), abs=1e-4)


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
          schematic: solid.schematic,
          points: [...mesh.points], moved: [...moved], moves: Boolean(solid.motion),
          places: [...placed(solid, mesh, moved, {frame}, 1)] }};
      }});""")
    assert all(one["held"] for one in solids)
    drive, solids = ([one for one in solids if one["schematic"] is flag] for flag in (True, False))
    # single precision of 0.4 m; the clearances of pin and rod, 15 um each, are not drawn
    check_joints(drive, 3e-5 if seen.kind == "pin" else 1e-6)
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
            size = np.abs(whole).max()
            assert moved == pytest.approx(whole, abs=1e-4 * size)  # 16 bits of its modes
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


def check_joints(drive, tolerance):
    """Pin, rod and crank of every cylinder share the axes of their joints.

    The first cylinder of the rod is its small end and the last its big end; the first one of the
    crank is the crank pin.
    """
    for owner in {one["owner"] for one in drive}:
        points = {
            one["name"]: np.reshape(one["places"], (-1, 3))
            for one in drive
            if one["owner"] == owner
        }
        assert [*points] == ["pin", "rod", "crank"]
        first, last = slice(2 * AROUND), slice(-2 * AROUND, None)
        pin, small, big, throw = (
            points[name][part, :2].mean(axis=0)
            for name, part in (("pin", first), ("rod", first), ("rod", last), ("crank", first))
        )
        assert small == pytest.approx(pin, abs=tolerance)
        assert big == pytest.approx(throw, abs=tolerance)


REACHED = """const one = document.activeElement;
  return one.dataset.stop || "";"""


def test_every_control_is_reached_by_keys(seen):
    """Tab goes from control to control, space plays and stops, arrow keys turn the bodies."""
    browser = seen.browser
    controls = browser.run("""
      for (const one of document.querySelectorAll("details")) one.open = true;
      await showDetails();
      if (byId("bodies")) await showSolids();
      const all = document.querySelectorAll(
        "button, select, input, summary, a[href], canvas[tabindex]");
      const shown = [...all].filter(one => one.checkVisibility() && !one.disabled);
      shown.forEach((one, k) => { one.dataset.stop = k; });
      document.activeElement.blur(); window.scrollTo(0, 0);
      return shown.map(one => one.dataset.stop + " " + one.outerHTML.slice(0,90));""")
    reached = set()
    browser.key("Tab")
    for _ in range(2 * len(controls)):  # also over tables that scroll
        stop = browser.run(REACHED)
        if stop in reached:
            break
        reached |= {stop} - {""}
        browser.key("Tab")
    assert [one for one in controls if one.split()[0] not in reached] == []
    browser.run("byId('play').focus();")
    browser.key(" ")
    assert browser.run("return playing")
    browser.key(" ")
    assert not browser.run("return playing")
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
