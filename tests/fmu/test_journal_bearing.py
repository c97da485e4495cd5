"""The shaft in models/journal_bearing: numbers by hand, and coupled with its film."""

import subprocess
import sys

import numpy as np
import pytest

from piston_cosim.master.case.reading import find_case, read_tree

from ..shown import ROOT, check, rounds_to, table, written
from .runs import module_of, run_tree

PATH = find_case("journal_bearing")


def test_forces_by_hand():
    """A pressure force of 2 N to the right pushes to the left; 3 N of friction there pull up."""
    model = module_of(PATH.parent / "shaft.py")
    pressure = np.zeros(model.GRID)
    around = np.zeros(model.GRID)
    pressure[0, 4] = 2.0
    around[0, 7] = 3.0
    assert np.allclose(model.film_force(pressure, around), [-2.0, 3.0], atol=1e-15)
    quarter = model.GRID[0] // 4
    around = np.roll(around, quarter, axis=0)
    assert np.allclose(model.film_force(0.0 * pressure, around), [-3.0, 0.0], atol=1e-15)


def ran(tmp_path, *changes):
    """Results of the case, changed, every step converged."""
    tree = read_tree(PATH, list(changes))
    results = run_tree(PATH, tree, tmp_path / "shaft.h5")
    assert results.summary["unconverged_steps"] == 0
    return results


def test_motion_forces_and_power_of_the_coupled_shaft(tmp_path):
    """Film and shaft obey Newton's law, conserve oil and agree on power over 5 ms.

    The power of the drive equals that of the film. The case is the shipped one.
    """
    results = ran(tmp_path, ("time.stop", "5 ms"))

    def of(name):
        return results.series(name).values

    step = 0.2e-3
    speed = 100.0 * np.pi
    time = step * np.arange(len(of("shaft.horizontal_force")))
    across = of("shaft.horizontal_force") + 1e-3 * speed**2 * np.cos(speed * time)
    x = of("shaft.horizontal_displacement")
    # trapezoidal rule twice: m (x2 - 2 x1 + x0) / h^2 = (f2 + 2 f1 + f0) / 4
    acceleration = 20.0 * np.diff(x, 2) / step**2
    mean = 0.25 * (across[2:] + 2.0 * across[1:-1] + across[:-2])
    # a tolerance of 1 nm on the film is 4 m / h^2 times as much of a force: 2 N
    assert np.allclose(acceleration[1:], mean[1:], atol=2.0)
    assert of("film.mass_imbalance").max() < 1e-12
    # full at the start: what lies between two cylinders without the groove, a sixtieth by 10 of 12
    gap = 2 * np.pi * 25e-3 * 40e-6 * 25e-3 * (1 - 10 / 720)
    assert np.isclose(of("film.oil_in_film")[0], gap, rtol=1e-12)
    # moments about the shaft's axis: differences over two of 60 cells, and C/R of the friction
    power = of("shaft.drive_torque")[1:] * speed
    assert np.allclose(power, of("film.friction_power")[1:], rtol=5e-3)


def test_a_film_named_first_starts_after_its_shaft_all_the_same(tmp_path, capsys):
    """A film that comes first starts with the shaft's gap of 40 um, and full.

    Its own start value of 10 um would fill a quarter of the gap. The motion is the same to the bit.
    """
    tree = read_tree(PATH, [("time.stop", "1 ms")])
    places = []
    for name, names in (("as_is", ("shaft", "film")), ("film_first", ("film", "shaft"))):
        turned = tree | {"participants": {one: tree["participants"][one] for one in names}}
        results = run_tree(PATH, turned, tmp_path / f"{name}.h5")
        said = "start in the order shaft, film: films after their bodies" in capsys.readouterr().out
        assert said == (name == "film_first")
        assert results.dataset("film.film_fraction")[0].min() == 1.0
        places.append(results.series("shaft.vertical_displacement").values)
    assert np.array_equal(*places)


def test_an_elastic_shell_opens_the_film_and_takes_its_load(tmp_path):
    """An elastic shell opens the film and carries its load in every step, and the power agrees.

    The run takes 8 ms of the variant `elastic`, with a steel ring that hangs at its upper quarter.
    Without the slope of the ring the drive misses 4 % of power.
    """
    variant = read_tree(PATH)["variants"]["elastic"]
    del variant["title"]
    build = "participants.shell.build"
    own = {f"{build}.young": "206 GPa", f"{build}.ring.held": "90 deg", "time.stop": "8 ms"}
    results = ran(tmp_path, *(variant | own).items())

    def of(name):
        return results.series(name).values[1:]

    assert results.summary["mean_iterations"] < 2.5
    assert of("shell.largest_deflection").max() > 5e-6
    # thinnest between the journal and a shell that moves outwards there
    moved = np.hypot(of("shaft.horizontal_displacement"), of("shaft.vertical_displacement"))
    opened = of("film.minimum_film_thickness") - (40e-6 - moved)
    assert opened.max() > 2e-6
    assert np.all((opened > -1e-7) & (opened < of("shell.largest_deflection") + 1e-7))
    for axis, way in (("x", "horizontal"), ("y", "vertical")):
        assert np.allclose(of(f"shell.force_{axis}"), -of(f"shaft.{way}_force"), rtol=1e-9)
    power = of("shaft.drive_torque") * 100.0 * np.pi
    assert np.allclose(power, of("film.friction_power"), rtol=1e-3)


PAGE = "models/journal_bearing/README.md"
TEXT = (PATH.parent / "README.md").read_text()


def variant_run(tmp_path, label):
    """Return the results of a variant."""
    changes = read_tree(PATH)["variants"].get(label, {})
    changes.pop("title", None)
    return ran(tmp_path, *changes.items())


def last(results, name, length):
    """Return an output over the last part of a run [s]."""
    series = results.series(name).values
    return series[results.time >= results.time[-1] - length + 1e-9]


def test_the_page_shows_the_run_of_the_unbalanced_shaft(tmp_path):
    found = variant_run(tmp_path, "unbalanced").summary
    shown = table(PAGE, "quantity")
    whirl = [row for row in shown if "whirl" in row]
    assert len(whirl) == 1
    power = [found["mean_friction_power_w"]]
    assert found["mass_imbalance_max"] < 1e-14
    check(
        {row: cells[:1] for row, cells in shown.items() if row not in whirl},
        {
            "largest and last eccentricity of `unbalanced`": [
                [found["eccentricity_max"], found["eccentricity_last"]]
            ],
            "mean friction power of `unbalanced`": [power],
            "mean flow from the groove of `unbalanced`": [[found["mean_supply_m3_s"]]],
            "largest mass imbalance of `unbalanced`": [[1e-14]],  # the bound
        },
    )


@pytest.mark.slow
def test_the_page_shows_the_run_that_whirls(tmp_path):
    results = variant_run(tmp_path, "whirl")
    x, y = (last(results, f"shaft.{way}_displacement", 0.05) for way in ("horizontal", "vertical"))
    angle = np.unwrap(np.arctan2(y, x))
    frequency = (angle[-1] - angle[0]) / 0.05 / (15000.0 * np.pi / 30.0)
    (shown,) = table(PAGE, "quantity")["frequency of `whirl` over shaft speed, last 50 ms"][0]
    assert rounds_to(frequency, shown)
    eccentricity = results.series("shaft.eccentricity").values
    peaks = [
        eccentricity[
            np.abs(results.time - instant) < 0.005
        ].max()  # a revolution of the orbit: 8 ms
        for instant in (0.004, 0.04, 0.098)
    ]
    shown = written(r"eccentricity is ([\d.]+) .*, ([\d.]+) after 40 ms and ([\d.]+) a", TEXT)
    assert all(map(rounds_to, peaks, shown))


@pytest.mark.slow
def test_the_page_shows_the_runs_with_and_without_an_elastic_liner(tmp_path):
    columns = {}
    for label in ("heavy", "elastic"):
        results = variant_run(tmp_path, label)
        of = {
            name: last(results, f"{name}", 0.02)
            for name in ("shaft.eccentricity", "film.maximum_pressure", "film.friction_power")
        }
        film = last(results, "film.minimum_film_thickness", 0.02)
        opened = (
            last(results, "shell.largest_deflection", 0.02) if label == "elastic" else np.zeros(1)
        )
        columns[label] = {
            "largest eccentricity": [of["shaft.eccentricity"].max()],
            "highest pressure": [1e-6 * of["film.maximum_pressure"].max()],
            "minimum film thickness": [1e6 * film.min()],
            "mean friction power": [of["film.friction_power"].mean()],
            "largest deflection of the liner": [1e6 * opened.max()],
        }
        force = results.series("shaft.vertical_force").values
        (shown,) = written(r"carry about ([\d.]+) kN upwards", TEXT)
        assert rounds_to(1e-3 * force[np.argmin(np.abs(results.time - 0.076))], shown)
    rows = {row: [one[row] for one in columns.values()] for row in columns["heavy"]}
    check(table(PAGE, "last 20 ms"), rows)


@pytest.mark.slow
def test_the_page_shows_the_steady_films_of_the_liner():
    run = subprocess.run(
        [sys.executable, ROOT / "tests/bench/bearing_shell.py"],
        capture_output=True,
        text=True,
        check=True,
    )
    rows = {line[:12].strip(): line[12:].split() for line in run.stdout.splitlines()}
    pattern = r"(\d+) N with at most ([\d.]+) MPa. .* (\d+) N with ([\d.]+) MPa, .* (\d+) N with"
    shown = written(pattern + r" ([\d.]+) MPa", TEXT)
    computed = [cell for shell in ("whole mesh", "60 modes", "rigid") for cell in rows[shell][:2]]
    assert all(rounds_to(float(value), text) for value, text in zip(computed, shown))
