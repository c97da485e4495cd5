"""What the modes leave out at the film forces of a run, beside the whole body."""

import json

import h5py
import numpy as np
import pytest

from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres, film_rows
from piston_cosim.fmu_mfbd.options import read_options
from piston_cosim.fmu_mfbd.reduction.bases import Elastic
from piston_cosim.fmu_mfbd.reduction.film_loads import (
    FORCES,
    FilmLoads,
    NotRecorded,
    RecordedLoads,
    on_stations,
    recorded_loads,
)
from piston_cosim.fmu_mfbd.reduction.reduce import film_surface, full_model
from piston_cosim.fmu_mfbd.reduction.reduced_body import (
    Probes,
    ReducedBlock,
    ReducedPiston,
    load,
)
from piston_cosim.fmu_mfbd.reduction.truncation import (
    PROBES,
    StaticModes,
    probes,
    static_modes,
    truncation,
)
from piston_cosim.fmu_mfbd.truncations import truncations
from piston_cosim.master.engine.truncation import state_truncation

GRID = (16, 12)
ROWS = np.linspace(-10e-3, 10e-3, 5)


def film_forces(shape, seed=0, instants=4):
    """A patch on the thrust side that wanders and grows, with friction."""
    angle, _ = cell_centres(*shape, 0.0, 1.0)
    height = np.linspace(0, 1, shape[1])
    middle = np.linspace(0.2, 0.8, instants)[:, None, None]
    patch = np.maximum(0, np.sin(angle))[:, None] ** 3 * np.exp(-(((height - middle) / 0.2) ** 2))
    noise = np.random.default_rng(seed).normal(size=patch.shape)
    strength = np.linspace(1, 3, instants)[:, None, None]
    return FilmLoads(strength * patch, 0.05 * strength * (patch + 0.1 * noise))


@pytest.fixture(scope="module")
def skirt(coarse):
    """The small piston whole: its elastic body and how its skirt is read."""
    folder, options = coarse
    piston = read_options(options, folder).piston
    mesh, K, M = full_model(piston, ("skirt", "crown", "pin_bore"), lambda text: None)
    heights = mesh.points[mesh.nodes("skirt"), 1]
    angle, height = cell_centres(*GRID, heights.min(), heights.max())
    reading = film_surface(mesh, "skirt", angle, height).reading
    return Elastic(K, M, mesh.nodes("pin_bore")), reading


@pytest.fixture(scope="module")
def files(coarse, kept_bodies):
    folder, options = coarse
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PISTON_COSIM_CACHE", str(kept_bodies))
        yield reduced_bodies(options, folder, lambda text: None)


def missing(skirt, modes, film):
    """Radial deflection that the modes miss at each instant and point, by the whole body."""
    elastic, reading = skirt
    radial, axial = (one[:, elastic.free] for one in reading)
    pressure, friction = (force.reshape(len(force), -1) for force in film)
    whole = radial @ elastic.solve(radial.T @ pressure.T - axial.T @ friction.T)
    modal = modes.radial.T @ pressure.T - modes.axial.T @ friction.T
    kept = modes.radial @ (modal / modes.omega[:, None] ** 2)
    return (whole - kept).T, kept.T


def rms(values):
    return np.sqrt(np.mean(values**2))


def test_with_a_pattern_for_each_point_it_is_the_missing_deflection(skirt, files):
    """Patterns sqrt(n) e_i make the mean of Eq. (J17) the sum of squares itself: to round-off of
    the whole answer, 1e-12 of it, in a difference of some per cent.
    """
    modes = static_modes(load(ReducedPiston, files["piston"]))
    points = len(modes.radial)
    film = film_forces(GRID)
    left, kept = missing(skirt, modes, film)
    found = truncation(probes(*skirt, np.sqrt(points) * np.eye(points)), modes, film)
    assert 1e-3 < found.error < 0.5
    assert found.error == pytest.approx(rms(left) / rms(kept), rel=1e-9)
    worst = max(rms(one) / rms(all_of_it) for one, all_of_it in zip(left, kept))
    assert found.largest == pytest.approx(worst, rel=1e-9)
    assert found.largest > 1.02 * found.error


def test_what_a_reduction_keeps_estimates_it(skirt, files):
    """A hundred random patterns: standard error 7 %, so four of them."""
    modes = static_modes(load(ReducedPiston, files["piston"]))
    kept = load(Probes, files["piston"])
    assert kept.probe.shape == (PROBES, len(modes.radial))
    film = film_forces(GRID)
    left, deflection = missing(skirt, modes, film)
    found = truncation(kept, modes, film)
    assert found.error == pytest.approx(rms(left) / rms(deflection), rel=4 / np.sqrt(2 * PROBES))


def test_all_answers_in_the_modes_leave_nothing():
    """One spring a point: modes that are its whole compliance."""
    points, stiffness = 6, 2.0
    modes = StaticModes(
        np.full(points, np.sqrt(stiffness)), np.eye(points), np.zeros((points,) * 2)
    )
    patterns = np.random.default_rng(0).normal(size=(3, points))
    kept = Probes(patterns, patterns / stiffness, np.zeros((3, points)))
    film = FilmLoads(np.ones((2, 3, 2)), np.ones((2, 3, 2)))
    assert truncation(kept, modes, film).error <= 1e-15
    # half as stiff as the modes say: as much is missing as is there, 1 but for the estimate
    softer = Probes(patterns, 2 * patterns / stiffness, np.zeros((3, points)))
    expected = np.sqrt(np.mean(patterns.sum(axis=1) ** 2) / points)
    assert truncation(softer, modes, film).error == pytest.approx(expected, rel=1e-12)
    # an instant with a twentieth of the load counts little, and for the worst one not at all
    rare = FilmLoads(np.array([np.ones((3, 2)), 0.05 * np.eye(3, 2)]), np.zeros((2, 3, 2)))
    weak = truncation(softer, modes, rare)
    assert weak.largest == pytest.approx(expected, rel=1e-12)
    assert weak.error == pytest.approx(expected, rel=1e-2)
    nothing = FilmLoads(np.zeros((2, 3, 2)), np.zeros((2, 3, 2)))
    assert truncation(kept, modes, nothing) == (0.0, 0.0)


def test_forces_reach_the_stations_with_their_resultant_and_moment():
    """A natural spline reproduces a line, so that both are kept to round-off."""
    stations = np.linspace(0.05, 0.15, 9)
    force = np.random.default_rng(1).normal(size=(3, 4, 5))
    height = np.array([0.08, 0.1, 0.12])
    table = on_stations(RecordedLoads(FilmLoads(force, 2 * force), height), ROWS, stations)
    np.testing.assert_allclose(table.pressure.sum(axis=2), force.sum(axis=2), rtol=1e-12)
    moment = (force * (height[:, None, None] + ROWS)).sum(axis=2)
    np.testing.assert_allclose((table.pressure * stations).sum(axis=2), moment, rtol=1e-11)
    np.testing.assert_allclose(table.friction, 2 * table.pressure, atol=1e-12)


def results(path, tree, film, without=()):
    """A results file of a run that has recorded its nodal forces, A midway on the bore."""
    with h5py.File(path, "w", libver="latest") as file:
        file.attrs.update(case=json.dumps(tree), title="", summary=json.dumps({"steps": 3}))
        file["time"] = np.linspace(0.0, 3e-3, 7)
        file["bodies/piston_position"] = np.linspace(0.08, 0.12, 7)
        file["fields/time"] = np.linspace(0.0, 3e-3, len(film.pressure))
        for name, values in zip(("nodal_pressure_force", "nodal_friction_force"), film):
            if name not in without:
                file[f"fields/ehd/{name}"] = values
    return path


def test_loads_of_a_results_file(tmp_path):
    film = film_forces(GRID)
    found = recorded_loads(results(tmp_path / "run.h5", {}, film), GRID)
    np.testing.assert_array_equal(found.film.pressure, film.pressure)
    np.testing.assert_array_equal(found.film.friction, film.friction)
    np.testing.assert_allclose(found.height_of_A, [0.08, 0.28 / 3, 0.32 / 3, 0.12], rtol=1e-12)


def test_what_is_not_recorded_is_said(tmp_path):
    film = film_forces(GRID)
    lacking = results(tmp_path / "a.h5", {}, film, without=("nodal_friction_force",))
    with pytest.raises(NotRecorded, match="a.h5 has not recorded nodal_pressure_force and nodal"):
        recorded_loads(lacking, GRID)
    other = results(tmp_path / "b.h5", {}, film)
    with pytest.raises(NotRecorded, match=r"shape \(16, 12\), the film grid is \(42, 40\)"):
        recorded_loads(other, (42, 40))
    (tmp_path / "c.h5").write_text("nothing")
    with pytest.raises(NotRecorded, match="c.h5 is no results file of a run"):
        recorded_loads(tmp_path / "c.h5", GRID)
    two = results(tmp_path / "d.h5", {}, film)
    with h5py.File(two, "a") as file:
        file["fields/rings/nodal_pressure_force"] = film.pressure
    with pytest.raises(NotRecorded, match="of ehd, rings, and its case has no wire that tells"):
        recorded_loads(two, GRID)


def case_text(wires, surfaces=()):
    """A run's case: wires, and film surfaces of its bodies."""
    return json.dumps(
        {
            "wires": [{"from": source, "to": target} for source, target in wires],
            "participants": {"bodies": {"build": {"film_surfaces": list(surfaces)}}, "other": {}},
        }
    )


def test_wires_tell_which_film_acts_on_the_skirt(tmp_path):
    """A second film that records forces, of rings, has no part in it."""
    film = film_forces(GRID)
    path = results(tmp_path / "run.h5", {}, film)
    wires = [(f"ehd.{name}", f"bodies.{name}") for name in FORCES]
    with h5py.File(path, "a") as file:
        for name in FORCES:
            file[f"fields/rings/{name}"] = 7.0 * film.pressure
        file.attrs["case"] = case_text([("rings.nodal_pressure_force", "other.force"), *wires])
    found = recorded_loads(path, GRID)
    np.testing.assert_array_equal(found.film.pressure, film.pressure)
    with h5py.File(path, "a") as file:
        file.attrs["case"] = case_text(
            [*wires, ("rings.nodal_pressure_force", f"other.{FORCES[0]}")]
        )
    with pytest.raises(NotRecorded, match="on bodies and other: of one piston"):
        recorded_loads(path, GRID)


def test_forces_of_several_films_are_those_of_the_skirt(tmp_path):
    """Rows 1 to 5 and 7 to 12; on row 6, a groove, there is nothing."""
    film = film_forces(GRID)
    path = results(tmp_path / "run.h5", {}, film)
    bands = {"lower": (1, 5), "upper": (7, 12)}
    with h5py.File(path, "a") as file:
        for name in FORCES:
            whole = file[f"fields/ehd/{name}"][:]
            del file[f"fields/ehd/{name}"]
            for band, (first, last) in bands.items():
                file[f"fields/{band}/{name}"] = whole[:, :, first - 1 : last]
        wires = [(f"{b}.{name}", f"bodies.{b}.{name}") for b in bands for name in FORCES]
        surfaces = [{"name": name, "rows": rows} for name, rows in bands.items()]
        file.attrs["case"] = case_text(wires, surfaces)
    found = recorded_loads(path, GRID)
    there = np.arange(12) != 5
    np.testing.assert_array_equal(found.film.friction, np.where(there, film.friction, 0.0))
    with h5py.File(path, "a") as file:
        del file["fields/upper/nodal_pressure_force"]
    with pytest.raises(NotRecorded, match="has not recorded"):
        recorded_loads(path, GRID)


def test_films_of_a_floating_pin_are_none_of_the_skirt(tmp_path):
    """On a grid of the same size, whose forces would pass for the skirt's."""
    film = film_forces(GRID)
    path = results(tmp_path / "run.h5", {}, film)
    wires = [(f"ehd.{name}", f"bodies.skirt.{name}") for name in FORCES]
    with h5py.File(path, "a") as file:
        for name in FORCES:
            file[f"fields/boss/{name}"] = 7.0 * film.pressure
        wires += [(f"boss.{FORCES[0]}", f"bodies.boss_left.{FORCES[0]}")]
        file.attrs["case"] = case_text(wires)
    found = recorded_loads(path, GRID)
    np.testing.assert_array_equal(found.film.pressure, film.pressure)


@pytest.fixture
def kept(kept_bodies, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(kept_bodies))


def case_tree(options):
    return {"participants": {"bodies": {"package": "fmu_mfbd", "build": options}, "ehd": {}}}


def test_a_run_states_it_of_both_bodies(coarse, files, kept, tmp_path):
    folder, options = coarse
    film = film_forces(GRID)
    path = results(tmp_path / "run.h5", case_tree(options), film)
    piston = load(ReducedPiston, files["piston"])
    block = load(ReducedBlock, files["block"])
    rows = film_rows(piston.skirt_lower, piston.skirt_upper, GRID)
    on_bore = on_stations(recorded_loads(path, GRID), rows, block.heights)
    expected = {
        "piston": truncation(load(Probes, files["piston"]), static_modes(piston), film),
        "block": truncation(load(Probes, files["block"]), static_modes(block), on_bore),
    }
    assert truncations(options, folder, path) == expected
    added = state_truncation(case_tree(options), folder, path, lambda text: None)
    assert added == {
        "truncation_error_piston": expected["piston"].error,
        "truncation_error_piston_largest": expected["piston"].largest,
        "truncation_error_block": expected["block"].error,
        "truncation_error_block_largest": expected["block"].largest,
    }
    with h5py.File(path) as file:
        assert json.loads(file.attrs["summary"]) == {"steps": 3} | added


def test_a_run_that_cannot_state_it_says_why(coarse, kept, tmp_path):
    folder, options = coarse
    tree = case_tree(options)
    path = results(tmp_path / "run.h5", tree, film_forces(GRID), ("nodal_pressure_force",))
    added = state_truncation(tree, folder, path, lambda text: None)
    assert list(added) == ["truncation_error"]
    assert added["truncation_error"].startswith("not known: run.h5 has not recorded nodal_pressure")
    with h5py.File(path) as file:
        assert json.loads(file.attrs["summary"]) == {"steps": 3} | added


def test_rigid_and_foreign_bodies_have_none(coarse, kept, tmp_path):
    folder, options = coarse
    path = results(tmp_path / "run.h5", {}, film_forces(GRID))
    rigid = options | {name: options[name] | {"modes": 0} for name in ("piston", "block")}
    assert state_truncation(case_tree(rigid), folder, path, print) == {}
    half = options | {"block": rigid["block"]}
    found = state_truncation(case_tree(half), folder, path, lambda text: None)
    assert list(found) == ["truncation_error_piston", "truncation_error_piston_largest"]
    foreign = {"participants": {"bodies": {"fmu": "own.fmu"}}}
    assert state_truncation(foreign, folder, path, print) == {}


def test_a_body_without_probes_says_so(coarse, files, kept, tmp_path):
    """As earlier versions wrote it."""
    folder, options = coarse
    with np.load(files["piston"]) as whole:
        older = {name: whole[name] for name in whole.files if name not in Probes.__annotations__}
    np.savez(tmp_path / "older.npz", **older)
    table = options | {"piston": {"reduced": str(tmp_path / "older.npz")}}
    path = results(tmp_path / "run.h5", {}, film_forces(GRID))
    with pytest.raises(ValueError, match="older.npz lacks probe, answer_radial, answer_axial"):
        truncations(table, folder, path)
