"""The report in a browser shows the results file.

There is no console message and no network request.
Every number, line and colour on the screen equals the file's.
"""

import base64
import re
from dataclasses import replace

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.engine.answer import answer
from piston_cosim.master.engine.overview import overview
from piston_cosim.master.engine.sections import special
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.compare import agreement, read_measured
from piston_cosim.master.results.fields_export import cylinder_cells
from piston_cosim.master.results.packing import Columns
from piston_cosim.master.results.report import Special, write_report
from piston_cosim.master.results.solids import Solid, solids_data

from .browser import Browser, pace
from .by_hand import coupling, write_results

AROUND, ALONG, INSTANTS = 8, 5, 19
TREE = read_tree(find_case("data_sheet"))
MASK = [[0 if i == 4 and j == 0 else 1 for j in range(ALONG)] for i in range(AROUND)]
SERIES = {
    "bodies/crank_angle": ("rad", lambda angle: angle),
    "bodies/cylinder_pressure": ("Pa", lambda angle: 1e6 * (1 + np.cos(angle / 2))),
    "bodies/side_force": ("N", lambda angle: 1e3 * np.sin(angle)),
    "bodies/lateral_displacement": ("m", lambda angle: 1e-5 * np.sin(angle)),
    "bodies/rocking_angle": ("rad", lambda angle: 1e-3 * np.cos(angle)),
    "bodies/piston_velocity": ("m/s", lambda angle: 10 * np.sin(angle)),
}
FILM = {
    "ehd/minimum_film_thickness": ("m", lambda turn: 2e-6 * turn),
    "ehd/maximum_pressure": ("Pa", lambda turn: 1e6 * turn),
    "ehd/friction_power": ("W", lambda turn: 100 * turn),
}
"""Outputs of the film, which belong to its fields."""


LOADED = np.linspace(0.0, 90.0, INSTANTS) * 1e6
"""Stress of the plate at every instant [Pa]."""
PLATE = Solid(
    "piston",
    np.array([[-0.02, -0.01, 0.0], [0.02, -0.01, 0.0], [0.02, 0.01, 0.0], [-0.02, 0.01, 0.0]]),
    np.array([[0, 1, 2], [0, 2, 3]]),
    np.full((4, 3, 1), 1.0),
    np.linspace(-1e-6, 2e-6, INSTANTS)[:, None],
    np.zeros((INSTANTS, 3)),
    stress=np.tile(LOADED[:, None], (1, 4)),
)
"""A square in z = 0 that is stressed evenly."""


def written(path, factor=1.0, grid=(AROUND, ALONG), instants=INSTANTS):
    """Write a run with pressure over four decades, a ramp as film, and one cell without film."""
    steps = 4 * (instants - 1)
    angle = np.linspace(0, 4 * np.pi, steps + 1)
    at = angle[::4]
    around, along = grid
    cells = np.arange(around * along).reshape(around, along) / (around * along - 1)
    turn = (1.5 + np.sin(at))[:, None, None] * factor
    mask = np.ones(grid, int)
    mask[around // 2, 0] = 0
    fields = {
        "ehd/pressure": (turn * 1e6 * 10.0 ** (-4 * cells), "Pa"),
        "ehd/film_fraction": ((1.2 - 0.3 * cells) * np.ones((instants, 1, 1)), "1"),
        "bodies/film_thickness": (turn * 1e-6 * (2 + 18 * cells), "m"),
    }
    for values, _ in fields.values():
        values[:, around // 2, 0] *= 50  # of the cut-out, which nothing may look at
    series = {name: (of(angle), unit) for name, (unit, of) in SERIES.items()}
    swell = (1.5 + np.sin(angle)) * factor
    series |= {name: (of(swell), unit) for name, (unit, of) in FILM.items()}
    return write_results(
        path,
        angle / 300.0,
        series | coupling(steps + 1),
        fields,
        at / 300.0,
        title="t",
        case=TREE,
        versions={"piston-cosim": "0"},
        summary={"steps": steps, "halved_steps": 0, "thinnest": 2e-6},
        masks={"ehd": mask.tolist()},
    )


def page_of_runs(case, runs, folder, **changes):
    """Write the report of runs with the first screen and the checks."""
    answers = {label: answer(case, results) for label, results in runs.items()}
    tables = {label: one.table for label, one in answers.items()}
    own = replace(special(case, runs), overview=overview(runs, tables), **changes)
    return write_report(case, runs, folder, answers, own)


def tube(name, radius, height, motion=None):
    """Return a tube of about the size of the shipped bodies.

    It has 2300 points, 4600 triangles and 60 modes, waves around and along; the stress is a wave.
    """
    instants, modes = 361, 60
    points, cells = cylinder_cells((64, 36), radius, (-height / 2, height / 2))
    triangles = np.vstack([cells[:, :3], cells[:, [0, 2, 3]]])
    around_points = np.arctan2(points[:, 0], points[:, 2])
    waves = np.stack([np.cos(m * around_points + points[:, 1]) for m in range(modes)], axis=-1)
    outwards = points * [1, 0, 1] / radius
    at = np.linspace(0, 4 * np.pi, instants)
    coordinates = 1e-6 * np.sin(np.outer(at, 1 + np.arange(modes) % 7))
    stress = 5e7 * (1 + np.sin(at[:, None] + around_points))
    shapes = outwards[:, :, None] * waves[:, None, :]
    film = None if motion is None else (-height / 2, height / 2)
    return Solid(name, points, triangles, shapes, coordinates, motion, film, stress)


def large_page(folder):
    """Write a report of two runs: two cycles, 361 instants, a grid of 40 x 40, and bodies."""
    grid, instants = (40, 40), 361
    runs = {
        label: written(folder / f"{label}.h5", factor, grid, instants)
        for label, factor in (("one", 1.0), ("two", 2.0))
    }
    case = check_case(TREE, "case.toml")
    at = np.linspace(0, 4 * np.pi, instants)
    motion = np.column_stack([1e-5 * np.sin(at), 0.03 * np.cos(at), 1e-3 * np.cos(at)])
    bodies = [tube("piston", 0.0365, 0.05, motion), tube("block", 0.04, 0.12)]
    page = page_of_runs(case, runs, folder / "report", solids=dict.fromkeys(runs, bodies))
    for results in runs.values():
        results.close()
    return page


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    runs = {"one": written(folder / "one.h5"), "two": written(folder / "two.h5", 2.0)}
    case = check_case(TREE, "case.toml")
    yield page_of_runs(case, runs, folder / "report", solids={"one": [PLATE]}), runs
    for results in runs.values():
        results.close()


@pytest.fixture(scope="module")
def window(page, tmp_path_factory):
    """Yield the page in a browser.

    Tests do not restore the instant and the choices.
    """
    with Browser(tmp_path_factory.mktemp("profile"), 1440) as shown:
        shown.open(page[0])
        yield shown
        assert shown.said() == [] and shown.asked() == []


def test_a_page_that_asks_the_network_is_noticed(page, browser):
    """The page forbids requests, so an attempt is a message on the console."""
    assert "Content-Security-Policy\" content=\"default-src 'none'" in page[0].read_text()
    browser.open(page[0])
    browser.run("""const image = document.createElement("img");
      image.src = "http://127.0.0.1:9/x.png"; document.body.appendChild(image);
      await new Promise(done => setTimeout(done, 200));""")
    assert any("Content Security Policy" in line for line in browser.said())


def test_every_recorded_instant_is_reached(window):
    seen = window.run("""const seen = [];
      for (let k = 0; k < positions.length; k++) { go(k); seen.push(byId("place").textContent); }
      return seen;""")
    assert seen == [f"{angle:g} deg" for angle in np.linspace(0, 720, INSTANTS)]


def test_the_three_figures_and_the_sentence_are_those_of_the_file(window, page):
    shown = window.run("""return {
      sentence: document.querySelector("h1").textContent,
      figures: [...document.querySelectorAll(".figure")].map(one =>
        [...one.querySelectorAll("[data-run]")].map(text => text.textContent.trim())),
      rows: [...document.querySelectorAll("#comparison tr")].map(row =>
        [...row.children].map(cell => cell.textContent)) };""")
    ports = ("minimum_film_thickness", "maximum_pressure", "friction_power")
    factors, reductions, units = (1e6, 1e-6, 1), (np.min, np.max, None), ("µm", "MPa", "W")
    for port, factor, reduction, unit, texts in zip(
        ports, factors, reductions, units, shown["figures"]
    ):
        series = [results.series(f"ehd.{port}").values * factor for results in page[1].values()]
        # of equal steps; a row counts for the step that ends there
        values = [reduction(own) if reduction else own[1:].mean() for own in series]
        read = [float(re.findall(r"[\d.]+", text)[0]) for text in texts]
        assert read == pytest.approx(values, rel=6e-3)  # three digits
        assert unit in texts[0] and "−50 %" in texts[1]
    # film and pressure change by less than their uncertainties
    sentence = "One instead of two lowers the mean friction power by 150 ± 70 W."
    assert shown["sentence"] == sentence
    assert shown["rows"][0] == ["", "one", "two", "one less two"]
    # 0.3 of the bend of the film, which is 5 across the step of this film, is 1.5 of its minimum
    row = "20.0 ± 1.5", "20.0 ± 3.0", "+0 %, not distinguishable"
    assert ["range of lateral displacement [µm]", *row] in shown["rows"]


MAPS = """
byId("run").value = -1; byId("run").onchange({ target: byId("run") });
const read = [];
for (const kind of ["thickness", "fraction", "pressure"]) {
  chosen.colour = kind;
  await showFilm();
  for (const k of [3, 14]) {
    go(k);
    for (const canvas of document.querySelectorAll("#maps canvas")) {
      const { map } = canvas, around = canvas.getBoundingClientRect();
      const frame = map.svg.node().querySelector(".frame").getBoundingClientRect();
      read.push({ kind, k, run: map.label.textContent, low: map.layer.low, high: map.layer.high,
        apart: ["left", "top", "width", "height"].map(name => around[name] - frame[name]),
        cuts: map.svg.node().querySelectorAll(".cut rect").length,
        marks: map.marks.selectAll(".marker").nodes().map(one => one.getAttribute("transform")),
        box: BOX, lines: map.lines.selectAll(".thickness").nodes()
          .map(one => [+one.dataset.level, one.getAttribute("d")]) });
    }
  }
}
return read;
"""


@pytest.fixture(scope="module")
def maps(window):
    return window.run(MAPS)


LAYERS = {
    "pressure": ("ehd.pressure", 1e-6),
    "thickness": ("bodies.film_thickness", 1e6),
    "fraction": ("ehd.film_fraction", 1.0),
}


def field(page, kind, label, k):
    """Return a field of the file in the unit of the page."""
    port, factor = LAYERS[kind]
    return page[1][label].dataset(port)[k] * factor


def cells_of(one, points):
    """Points of the drawing in cells of the grid."""
    box = one["box"]
    across = (points[:, 0] - box["left"]) / box["w"] * AROUND
    return across, (box["top"] + box["h"] - points[:, 1]) / box["h"] * ALONG


def test_colours_of_the_maps_are_of_all_runs_and_instants(maps, page):
    assert len(maps) == 3 * 2 * 2  # layers, instants, runs
    there = np.array(MASK, bool)
    for one in maps:
        every = np.array(
            [[field(page, one["kind"], run, k)[there] for k in range(INSTANTS)] for run in page[1]]
        )
        limits = every.min(), every.max()
        assert (one["low"], one["high"]) == pytest.approx(limits, rel=1e-6)
        assert np.abs(one["apart"]).max() < 1.5  # [px]: the drawing covers the canvas
        assert one["cuts"] == (~there).sum()


def test_marks_are_at_the_thinnest_film_and_the_highest_pressure(maps, page):
    hidden = ~np.array(MASK, bool)
    for one in maps:
        film, pressure = (
            np.ma.array(field(page, kind, one["run"], one["k"]), mask=hidden)
            for kind in ("thickness", "pressure")
        )
        cells = [film.argmin(), pressure.argmax()]
        points = np.array([re.findall(r"[\d.]+", text) for text in one["marks"]], float)
        across, up = cells_of(one, points)
        wanted = np.array(np.unravel_index(cells, film.shape)) + 0.5
        assert np.array([across, up]) == pytest.approx(wanted, abs=1e-3)


def test_contours_go_through_their_film_thickness(maps, page):
    """Bilinear interpolation of the file between cells gives the level on the line."""
    checked = 0
    for one in maps:
        values = field(page, "thickness", one["run"], one["k"])
        for level, path in one["lines"]:
            points = np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", path), float)
            across, up = (own - 0.5 for own in cells_of(one, points))
            inner = (across > 0) & (across < AROUND - 1) & (up > 0) & (up < ALONG - 1)
            i, j = across[inner].astype(int), up[inner].astype(int)
            u, v = across[inner] - i, up[inner] - j
            lower = (1 - u) * values[i, j] + u * values[i + 1, j]
            upper = (1 - u) * values[i, j + 1] + u * values[i + 1, j + 1]
            # coordinates have one decimal: 0.05 of 47 px a cell, whose film grows by a quarter
            step = np.abs(np.diff(values, axis=0)).max()
            assert (1 - v) * lower + v * upper == pytest.approx(level, abs=0.01 * step)
            checked += inner.sum()
    assert checked > 100


def test_curves_and_exports_are_those_of_the_file(window, page):
    window.run("go(13);")
    shown = window.run("""const charts = [...document.querySelectorAll("#curves .chart")];
      return { heads: charts.map(one => one.querySelector("figcaption").textContent),
        csv: tableOf(charts[2].chart.drawn),
        picture: (await picture()).size };""")
    titles = ("Minimum film thickness [µm]", "Maximum pressure [MPa]", "Lateral displacement")
    for title, head in zip((*titles, "Rocking angle [mrad]"), shown["heads"], strict=True):
        assert head.startswith(title)
    thickness = [r.series("ehd.minimum_film_thickness").values[52] * 1e6 for r in page[1].values()]
    read = re.findall(r"(?:one|two) ([\d.]+)", shown["heads"][0])
    assert [float(text) for text in read] == pytest.approx(thickness, rel=6e-3)  # three digits
    head, *rows = shown["csv"].splitlines()
    table = np.array([[float(text) for text in row.split(",")] for row in rows])
    shift = page[1]["one"].series("bodies.lateral_displacement").values * 1e6
    assert head.startswith('"one: crank angle [deg]"')
    assert table[:, 1] == pytest.approx(shift, abs=1e-6 * np.abs(shift).max())  # single precision
    assert shown["picture"] > 50_000  # bytes of a PNG that shows maps and curves


def test_a_click_on_a_curve_moves_the_cursor_there(window):
    at = window.run("""const svg = document.querySelector("#curves svg");
      svg.scrollIntoView();
      const box = svg.getBoundingClientRect(), x = svg.scale("x").apply(440);
      return [box.left + x * box.width / svg.viewBox.baseVal.width, box.top + box.height / 2];""")
    for kind in ("mousePressed", "mouseReleased"):
        given = {"x": at[0], "y": at[1], "button": "left", "clickCount": 1}
        window.ask("Input.dispatchMouseEvent", type=kind, **given)
    assert window.run("return byId('place').textContent") == "440 deg"


def test_keys_and_address_hold_instant_and_run(page, browser):
    browser.open(page[0])
    browser.run("go(5); byId('run').value = 1; byId('run').onchange({ target: byId('run') });")
    browser.run("document.body.focus();")
    browser.key("ArrowRight")
    hashed = browser.run("return location.hash")
    assert hashed == "#at=240&run=two"
    browser.reset()
    browser.open(page[0], hashed)
    place, *titles = browser.run("""return [byId("place"),
      ...document.querySelectorAll("#maps .map figcaption")].map(one => one.textContent);""")
    assert place == "240 deg" and len(titles) == 1 and titles[0].startswith("two")


def test_details_are_folded_and_every_chart_in_them_is_drawn(window, page):
    window.open(page[0])
    assert window.run("return document.documentElement.scrollHeight") <= 3600
    titles = window.run("""byId("details").open = true; await showDetails();
      await new Promise(done => setTimeout(done, 500));
      return [...document.querySelectorAll("#sections h2")].map(one => one.textContent);""")
    charts = window.run("return document.querySelectorAll('#sections .chart svg path').length")
    assert charts > 20
    assert {"Motion of the piston", "Over crank angle and height"} <= {*titles}


def test_stress_on_a_body_has_the_colour_of_its_legend(window):
    """The shader darkens a colour by the normal of the plate under the first angles of the page."""
    told = window.run("""
      byId("bodies").open = true; await showSolids();
      const plate = document.querySelector(".scene canvas").scene, painted = [];
      const [coloured, over] = document.querySelectorAll("#solids select");
      const names = [...coloured.options].map(one => one.textContent);
      coloured.value = names.indexOf("von Mises stress"); await coloured.onchange();
      for (const choice of ["all", "now"]) for (const k of [4, 18]) {
        over.value = choice; go(k); await over.onchange();
        const { scale } = document.querySelector(".scenes");
        const gl = plate.gl, dot = new Uint8Array(4);
        const middle = [gl.drawingBufferWidth >> 1, gl.drawingBufferHeight >> 1];
        gl.readPixels(...middle, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, dot);
        painted.push({ k, choice, dot: [...dot], ...scale });
      }
      return { painted, names, table: data.colours };""")
    assert told["names"] == ["von Mises stress", "displacement of the piston"]
    table = np.array(told["table"])
    turned, up = -0.45, 0.3
    normal = [np.sin(turned), -np.sin(up) * np.cos(turned), np.cos(up) * np.cos(turned)]
    lamp = np.array([0.3, 0.5, 0.9])
    light = 0.45 + 0.55 * abs(lamp @ normal) / np.linalg.norm(lamp)
    for one in told["painted"]:
        held = LOADED[one["k"]] * 1e-6
        whole = (0.0, 90.0) if one["choice"] == "all" else (held, held)
        assert (one["low"], one["high"]) == pytest.approx(whole, abs=90 * 2.0**-16)
        share = (held - one["low"]) / ((one["high"] - one["low"]) or 1.0)
        colour = [np.interp(255 * share, np.arange(256), table[:, c]) for c in range(3)]
        # 8 bits of a colour, twice: of the table and of the screen; 8 bits between its entries
        assert one["dot"][:3] == pytest.approx(np.array(colour) * light, abs=2.5), one


def test_equal_bodies_are_stored_once():
    given = solids_data([[PLATE], [PLATE]], Columns())
    ((one,), (same,)) = given["runs"]
    assert len(given["meshes"]) == 1 and one == same


@pytest.mark.slow
def test_first_picture_and_frames_a_second(tmp_path):
    """The first picture takes 2 s, and the page's thread 33 ms for a frame at 30 a second.

    Processor time is measured, because other work on the machine hardly changes it.
    """
    page = large_page(tmp_path)
    assert page.stat().st_size < 5e6
    with Browser(tmp_path / "profile") as window:
        window.ask("Page.navigate", url=page.as_uri())
        window.run(
            "while (!performance.getEntriesByName('first picture').length)"
            " await new Promise(done => setTimeout(done, 5));"
        )
        first = window.metrics()["TaskDuration"]
        window.open(page)
        played = pace(window, 60)
        assert first < 2.0
        assert played.page < 33.0 and played.all < 99.0
        assert window.said() == [] and window.asked() == []


def test_two_runs_of_181_instants_without_bodies_take_two_megabytes(tmp_path):
    runs = {
        label: written(tmp_path / f"{label}.h5", factor, (40, 40), 181)
        for label, factor in (("one", 1.0), ("two", 2.0))
    }
    page = page_of_runs(check_case(TREE, "case.toml"), runs, tmp_path / "report")
    for results in runs.values():
        results.close()
    assert page.stat().st_size <= 2e6


@pytest.mark.parametrize("scheme, width", [("dark", 1200), ("light", 390)])
def test_dark_and_narrow(page, browser, scheme, width):
    browser.resize(width)
    feature = {"name": "prefers-color-scheme", "value": scheme}
    browser.ask("Emulation.setEmulatedMedia", features=[feature])
    browser.open(page[0])
    wide, paper = browser.run("""
      return [document.documentElement.scrollWidth - window.innerWidth,
        getComputedStyle(document.body).backgroundColor];""")
    assert browser.said() == []
    assert wide <= 0
    assert (paper == "rgb(255, 255, 255)") == (scheme == "light")


@pytest.mark.parametrize("width", [1440, 900, 500])
def test_caption_and_cursor_agree_on_paper(page, browser, width):
    """The paper is narrower than the screen, and the browser reports no new size for it."""
    browser.resize(width)
    browser.open(page[0])
    browser.run("go(13); window.dispatchEvent(new Event('beforeprint'));")
    browser.ask("Emulation.setEmulatedMedia", media="print")
    told = browser.run("""
      document.body.style.width = "700px";
      const svg = document.querySelector("#curves svg");
      const at = node => {
        const box = node.getBoundingClientRect();
        return box.left + box.width / 2;
      };
      const ends = what => {
        const all = [...svg.querySelectorAll(`[aria-label='x-axis tick${what}`)];
        return [all[0], all[all.length - 1]];
      };
      const [first, last] = ends("'] path").map(at);
      const [from, to] = ends(" label'] text").map(one => parseFloat(one.textContent));
      const share = (at(svg.querySelector(".now")) - first) / (last - first);
      return { caption: parseFloat(byId("place").textContent), wide: svg.clientWidth,
        cursor: from + (to - from) * share };""")
    pdf = browser.ask("Page.printToPDF", preferCSSPageSize=True)["data"]
    assert told["wide"] <= 350
    assert told["cursor"] == pytest.approx(told["caption"], abs=1.0)
    sheets = len(re.findall(rb"/Type\s*/Page\b", base64.b64decode(pdf)))
    assert 1 <= sheets <= 3


def test_labels_on_paper_are_whole_and_apart(page, browser):
    browser.resize(1200)
    browser.open(page[0])
    browser.run("go(13); window.dispatchEvent(new Event('beforeprint'));")
    browser.ask("Emulation.setEmulatedMedia", media="print")
    faults = browser.run("""document.body.style.width = "700px";
      const meet = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom - 3
        && b.top < a.bottom - 3;  // a box has a margin above and below the letters
      const faults = [];
      const drawings = document.querySelectorAll(".map svg, .side svg, #curves svg");
      for (const svg of drawings) {
        const frame = svg.getBoundingClientRect();
        const all = [...svg.querySelectorAll("text")].filter(text => text.textContent)
          .map(text => ({ text: text.textContent, ...text.getBoundingClientRect().toJSON() }));
        all.forEach((a, k) => {
          if (a.right > frame.right + 1 || a.left < frame.left - 1) faults.push(["cut", a.text]);
          for (const b of all.slice(k + 1)) if (meet(a, b)) faults.push([a.text, b.text]);
        });
      }
      return [drawings.length, faults];""")
    assert faults == [7, []]  # two maps, a section and four charts


def test_measured_values_have_a_table_and_charts_with_bands(window, page, tmp_path):
    """One run is in the band in the first half; so does the other, as its forces are the same."""
    _, runs = page
    file = tmp_path / "measured.csv"
    port, at = "bodies.side_force", np.linspace(10, 710, 71)
    force = np.sin(np.radians(at))
    low, high = force - 0.1, np.where(at <= 360, force + 0.1, force - 0.05)
    head = f"bodies.crank_angle [deg],{port} [kN],{port} low [kN],{port} high [kN]"
    table = np.column_stack([at, force, low, high])
    np.savetxt(file, table, delimiter=",", header=head, comments="")
    compared = agreement(runs, read_measured(file))
    case = check_case(TREE, "case.toml")
    path = write_report(case, runs, tmp_path / "report", special=Special(measured=compared))
    window.open(path)
    told = window.run("""const [chart] = data.measured.drawn, section = byId("measured");
      return { names: chart.curves.map(one => one.name),
        low: [...column(chart.corridor.low)], high: [...column(chart.corridor.high)],
        rows: [...section.querySelectorAll("tr")]
          .map(row => [...row.cells].map(one => one.textContent)),
        cursors: section.querySelectorAll("svg .now").length,
        heads: [...section.querySelectorAll("figcaption .values")].map(one => one.textContent),
        areas: section.querySelectorAll("svg [aria-label=area]").length };""")
    assert told["areas"] == told["cursors"] == 1 and "grey: measured band" in told["heads"][0]
    inside = np.interp(at, np.linspace(0, 720, 73), np.sin(np.linspace(0, 4 * np.pi, 73)))
    share = np.mean((inside >= low) & (inside <= high))
    assert share == pytest.approx(36 / 71)  # at <= 360 deg
    assert told["names"] == ["one", "two", "measured"]
    for label, row, scored in zip(("one", "two"), told["rows"][1:], compared.rows, strict=True):
        assert row == [
            "side force",
            label,
            f"{scored.score.amplitude:.3f}",
            f"{100 * scored.score.rms:.1f} %",
            f"{scored.score.phase:+.3g} deg",
            f"{share:.0%}".replace("%", " %"),
        ]
    assert told["low"] == pytest.approx(low, rel=1e-6)
    assert told["high"] == pytest.approx(high, rel=1e-6)


@pytest.mark.parametrize(
    "head, said",
    [
        ("a.x [s],a.y low [N],a.y high [N]", r"csv: expected a column 'a\.y' with 'a\.y"),
        ("a.x [s],a.y [N],a.y low [N]", r"csv: expected a column 'a\.y high' with 'a\.y"),
        ("a.x [s],a.y [N],a.y low [kN],a.y high [N]", "low: expected unit N, got kN"),
        ("a.x [s],a.y [N],a.y high [N],a.y low [N]", r"low: expected values up to a\.y high, got"),
        ("x,a.y [N],what", r"'x'(.|\n)*column 3: expected 'participant.variable \[unit\]', got"),
    ],
)
def test_faulty_columns_are_refused(tmp_path, head, said):
    file = tmp_path / "measured.csv"
    count = head.count(",") + 1
    file.write_text(
        "\n".join([head, *(",".join(f"{k + n}" for k in range(count)) for n in (1, 2))])
    )
    with pytest.raises(BadInput, match=said):
        read_measured(file)
