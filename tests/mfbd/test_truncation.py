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
    on_rows,
    on_stations,
    recorded_film_thickness,
    recorded_loads,
)
from piston_cosim.fmu_mfbd.reduction.interpolation import SurfaceReading, covered
from piston_cosim.fmu_mfbd.reduction.reduce import film_surface, full_model, read_body
from piston_cosim.fmu_mfbd.reduction.reduced_body import (
    MissingShapes,
    ReducedBlock,
    ReducedPiston,
    load,
)
from piston_cosim.fmu_mfbd.reduction.smooth_prior import (
    ALONG,
    SurfaceAnswers,
    edge_patches,
    pressure_root,
)
from piston_cosim.fmu_mfbd.reduction.truncation import (
    THIN_FILM,
    StaticModes,
    left_out,
    share_of_film,
    static_modes,
    truncation,
)
from piston_cosim.fmu_mfbd.truncations import truncations
from piston_cosim.master.engine.truncation import state_truncation

from .conftest import quiet

GRID = (16, 12)
ROWS = np.linspace(-10e-3, 10e-3, 5)


def film_forces(shape, seed=0, instants=4):
    """Return a patch on the thrust side that moves and grows, with friction."""
    angle, _ = cell_centres(*shape, 0.0, 1.0)
    height = np.linspace(0, 1, shape[1])
    middle = np.linspace(0.2, 0.8, instants)[:, None, None]
    patch = np.maximum(0, np.sin(angle))[:, None] ** 3 * np.exp(-(((height - middle) / 0.2) ** 2))
    noise = np.random.default_rng(seed).normal(size=patch.shape)
    strength = np.linspace(1, 3, instants)[:, None, None]
    return FilmLoads(strength * patch, 0.05 * strength * (patch + 0.1 * noise))


@pytest.fixture(scope="module")
def skirt(coarse):
    """Return the small piston's elastic body, the reading of its skirt and S of Eq. (J31)."""
    folder, options = coarse
    piston = read_options(options, folder).piston
    mesh = read_body(piston, quiet)
    _, K, M = full_model(mesh, piston, quiet)
    heights = mesh.points[mesh.nodes("skirt"), 1]
    angle, height = cell_centres(*GRID, heights.min(), heights.max())
    surface = film_surface(mesh, "skirt", angle, height)
    there = covered(mesh.points, mesh.faces["skirt"], angle, height, surface.radius).ravel()
    root = pressure_root(angle, height, ALONG["skirt"], there)
    elastic = Elastic(K, M, mesh.nodes("pin_bore"))
    reading = SurfaceReading(*(one[:, elastic.free].tocsr() for one in surface.reading))
    return elastic, reading, root


@pytest.fixture(scope="module")
def files(coarse, kept):
    folder, options = coarse
    return reduced_bodies(options, folder, quiet)


def missing(skirt, modes, film):
    """Radial deflection that the modes miss at each instant and point, by the whole body."""
    elastic, (radial, axial), root = skirt
    pressure, friction = (force.reshape(len(force), -1) for force in film)
    whole = radial @ elastic.solve(radial.T @ pressure.T - axial.T @ friction.T)
    modal = modes.radial.T @ pressure.T - modes.axial.T @ friction.T
    kept = modes.radial @ (modal / modes.omega[:, None] ** 2)
    there = root.any(axis=1)
    return (whole - kept).T * there, whole.T * there


def rms(values):
    return np.sqrt(np.mean(values**2))


def test_pressure_of_the_prior_is_missed_exactly(skirt, files):
    """The missing deflection under any sum of the patterns of Eq. (J31) is exact.

    The tolerance is the single precision of the file, 6e-8 of the deflection, of which some per
    cent are missing. A hundred summed terms allow 1e-5.
    """
    modes = static_modes(load(ReducedPiston, files["piston"]))
    left = load(MissingShapes, files["piston"])
    assert left.left_radial.dtype == np.float32
    *_, root = skirt
    force = root @ np.random.default_rng(4).normal(size=(root.shape[1], 3))
    film = FilmLoads(force.T.reshape(3, *GRID), np.zeros((3, *GRID)))
    lost, whole = missing(skirt, modes, film)
    found = truncation(left, modes, film)
    np.testing.assert_allclose(found.missing, lost, atol=1e-5 * np.abs(lost).max())
    assert found.error == pytest.approx(rms(lost) / rms(whole), rel=1e-5)
    worst = max(rms(one) / rms(all_of_it) for one, all_of_it in zip(lost, whole))
    assert found.largest == pytest.approx(worst, rel=1e-5)


def test_symmetric_modes_miss_the_odd_part_of_the_film(skirt, coarse, kept):
    """The check counts what the assumption of a symmetric film drops, exactly as above.

    An odd load deflects the skirt, and the modes of an even film do not answer.
    """
    folder, options = coarse
    even = {name: options[name] | {"symmetric_film": True} for name in ("piston", "block")}
    path = reduced_bodies(options | even, folder, quiet)["piston"]
    modes = static_modes(load(ReducedPiston, path))
    *_, root = skirt
    force = (root @ np.random.default_rng(4).normal(size=root.shape[1])).reshape(1, *GRID)
    image = (GRID[0] // 2 - np.arange(GRID[0])) % GRID[0]
    film = FilmLoads((force - force[:, image]) / 2, np.zeros((1, *GRID)))
    lost, whole = missing(skirt, modes, film)
    assert rms(lost) == pytest.approx(rms(whole), rel=1e-6)
    found = truncation(load(MissingShapes, path), modes, film)
    np.testing.assert_allclose(found.missing, lost, atol=1e-5 * np.abs(lost).max())
    assert found.error == pytest.approx(1.0, rel=1e-5)


def test_selected_modes_are_those_that_smooth_pressures_deflect_most(skirt, coarse, kept):
    """`modes_from` leaves the 6 of 24 modes whose deflections are largest, in ascending frequency.

    The deflection of mode k is R phi_k phi_k^T R^T S z/omega_k^2 with white noise z (Eq. (J31)).
    All patterns give its rms. The file has single precision, 6e-8.
    """
    folder, options = coarse
    *_, root = skirt

    def reduced(**more):
        piston = options["piston"] | {"basis": "craig_bampton"} | more
        file = reduced_bodies(options | {"piston": piston}, folder, quiet)["piston"]
        left = load(MissingShapes, file)
        return load(ReducedPiston, file), left.smooth_error

    lowest, error_of_lowest = reduced(modes=6)
    all_modes, error_of_all = reduced(modes=24)
    selected, error = reduced(modes=6, modes_from=24)
    radial = static_modes(all_modes).radial
    under_all = [np.outer(one, one @ root) for one in radial.T]
    size = np.array([rms(one) for one in under_all]) / all_modes.omega**2
    chosen = np.array([np.argmin(abs(all_modes.omega - omega)) for omega in selected.omega])
    np.testing.assert_allclose(selected.omega, all_modes.omega[chosen], rtol=1e-6)
    assert np.all(np.diff(chosen) > 0)
    assert size[chosen].min() > (1 - 1e-6) * np.delete(size, chosen).max()
    assert chosen.max() > 5  # otherwise the lowest would do
    assert error_of_all < error < error_of_lowest


def test_errors_under_smooth_and_narrow_patches(skirt, files):
    """The file holds Eq. (J33) of its modes, and the missing share under every patch at an edge."""
    elastic, reading, root = skirt
    body, left = (load(part, files["piston"]) for part in (ReducedPiston, MissingShapes))
    modes = static_modes(body)
    there = root.any(axis=1)

    def shares(loads):
        radial, _ = reading
        whole = radial @ elastic.solve(radial.T @ loads)
        kept = modes.radial @ (modes.radial.T @ loads / modes.omega[:, None] ** 2)
        return np.linalg.norm(whole - kept, axis=0), np.linalg.norm(whole, axis=0)

    lost, whole = shares(root @ root[there].T)
    assert left.smooth_error == pytest.approx((lost / whole).max(), rel=1e-6)
    angle, height = cell_centres(*GRID, body.skirt_lower, body.skirt_upper)
    for patches, error in zip(
        edge_patches(angle, height, ALONG["skirt"], there, False), left.edge_errors
    ):
        lost, whole = shares(patches)
        counted = whole / patches.sum(axis=0) >= 0.1 * (whole / patches.sum(axis=0)).max()
        assert error == pytest.approx((lost / whole)[counted].max(), rel=1e-6)
    assert left.smooth_error < left.edge_errors.min()


def test_missing_deflection_under_a_film_at_each_point(skirt, files):
    """The error of the surface's deflection at any point is known to a tenth of the largest one.

    Pressure and friction of a film have edges that the prior lacks, but they change the deflection
    little.
    """
    modes = static_modes(load(ReducedPiston, files["piston"]))
    film = film_forces(GRID)
    lost, whole = missing(skirt, modes, film)
    found = truncation(load(MissingShapes, files["piston"]), modes, film)
    assert rms(lost) > 0.01 * rms(whole)
    np.testing.assert_allclose(found.missing, lost, atol=0.1 * np.abs(lost).max())
    assert found.error == pytest.approx(rms(lost) / rms(whole), rel=0.05)


def test_the_shape_left_out_is_the_mode_left_out():
    """Of two modes of two points one is kept: the other one over omega is left out, Eq. (J16).

    The patterns of the prior excite both.
    """
    omega = np.array([3.0, 5.0])
    radial, axial = np.eye(2), np.array([[0.3, 0.1], [0.2, -0.4]])
    root = np.array([[1.0, 1.0], [0.0, 1.0]])
    displacement = radial.T @ root / omega[:, None] ** 2
    answers = SurfaceAnswers(root, radial @ displacement, axial @ displacement, displacement)
    kept = StaticModes(omega[:1], radial[:, :1], axial[:, :1])
    left = left_out(answers, kept, np.ones(2, dtype=bool))
    sign = np.sign(left.left_radial[1, 0])
    # float32
    np.testing.assert_allclose(sign * left.left_radial[:, 0], [0.0, 1 / 5.0], atol=1e-7)
    np.testing.assert_allclose(sign * left.left_axial[:, 0], [0.1 / 5.0, -0.4 / 5.0], atol=1e-7)


def test_all_answers_in_the_modes_leave_nothing():
    """One spring a point, n of them: modes that are its whole compliance, or half of it."""
    points, stiffness = 6, 2.0
    answer = np.eye(points) / stiffness
    whole = SurfaceAnswers(np.eye(points), answer, np.zeros((points,) * 2), answer)
    there = np.ones(points, dtype=bool)

    def modes(stiffness):
        return StaticModes(
            np.full(points, np.sqrt(stiffness)), np.eye(points), np.zeros((points,) * 2)
        )

    film = FilmLoads(np.ones((2, 3, 2)), np.ones((2, 3, 2)))
    exact = modes(stiffness)
    assert truncation(left_out(whole, exact, there), exact, film)[:2] == (0.0, 0.0)
    # twice as stiff: half of the deflection, 1/4 m at each point, is missing
    stiff = modes(2 * stiffness)
    left = left_out(whole, stiff, there)
    found = truncation(left, stiff, film)
    assert found[:2] == pytest.approx((0.5, 0.5), rel=1e-6)
    np.testing.assert_allclose(found.missing, 0.25, rtol=1e-6)
    # an instant with a twentieth of the load is not compared
    rare = FilmLoads(np.array([np.ones((3, 2)), 0.05 * np.eye(3, 2)]), np.zeros((2, 3, 2)))
    assert truncation(left, stiff, rare).largest == pytest.approx(0.5, rel=1e-6)
    # points without a film neither count nor miss anything
    some = truncation(left_out(whole, stiff, there & (np.arange(points) < 4)), stiff, film)
    np.testing.assert_array_equal(some.missing[:, 4:], 0.0)
    assert some.error == pytest.approx(0.5, rel=1e-6)
    nothing = FilmLoads(np.zeros((2, 3, 2)), np.zeros((2, 3, 2)))
    assert truncation(left, stiff, nothing)[:2] == (0.0, 0.0)


def test_the_gap_is_compared_with_the_film_at_the_same_point():
    missed = np.array([[[1e-8, -3e-8], [2e-9, 5e-7]]])
    film = np.array([[[1e-6, 2e-6], [THIN_FILM / 10, np.inf]]])
    assert share_of_film(missed, film) == pytest.approx(2e-9 / THIN_FILM)  # 1, 1.5, 2 and 0 %


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
    """Write a results file of a run with recorded nodal forces and A midway on the bore."""
    with h5py.File(path, "w", libver="latest") as file:
        file.attrs.update(case=json.dumps(tree), title="", summary=json.dumps({"steps": 3}))
        file["time"] = np.linspace(0.0, 3e-3, 7)
        file["bodies/piston_position"] = np.linspace(0.08, 0.12, 7)
        file["fields/time"] = np.linspace(0.0, 3e-3, len(film.pressure))
        if "film_thickness" not in without:
            file["fields/bodies/film_thickness"] = np.full(film.pressure.shape, 1e-5)
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
    """Return a run's case with wires and with film surfaces of its bodies."""
    return json.dumps(
        {
            "wires": [{"from": source, "to": target} for source, target in wires],
            "participants": {"bodies": {"build": {"film_surfaces": list(surfaces)}}, "other": {}},
        }
    )


@pytest.mark.parametrize(
    "skirt, other",
    [("bodies", f"other.{FORCES[1]}s"), ("bodies.skirt", f"bodies.boss_left.{FORCES[0]}")],
)
def test_wires_tell_which_film_acts_on_the_skirt(tmp_path, skirt, other):
    """A second film with recorded forces on a grid of the same size has no effect.

    It is the film of rings or of a floating pin.
    """
    film = film_forces(GRID)
    path = results(tmp_path / "run.h5", {}, film)
    wires = [(f"ehd.{name}", f"{skirt}.{name}") for name in FORCES]
    with h5py.File(path, "a") as file:
        for name in FORCES:
            file[f"fields/second/{name}"] = 7.0 * film.pressure
        file.attrs["case"] = case_text([(f"second.{FORCES[0]}", other), *wires])
    found = recorded_loads(path, GRID)
    np.testing.assert_array_equal(found.film.pressure, film.pressure)
    with h5py.File(path, "a") as file:
        file.attrs["case"] = case_text([*wires, (f"second.{FORCES[0]}", f"other.{FORCES[0]}")])
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
    assert recorded_film_thickness(path, GRID) is None
    with h5py.File(path, "a") as file:
        for band, (first, last) in bands.items():
            file[f"fields/bodies/{band}.film_thickness"] = 1e-6 * whole[:, :, first - 1 : last]
    thickness = recorded_film_thickness(path, GRID)
    np.testing.assert_array_equal(thickness, np.where(there, 1e-6 * film.friction, np.inf))
    with h5py.File(path, "a") as file:
        del file["fields/upper/nodal_pressure_force"]
    with pytest.raises(NotRecorded, match="has not recorded"):
        recorded_loads(path, GRID)


def case_tree(options):
    return {"participants": {"bodies": {"package": "fmu_mfbd", "build": options}, "ehd": {}}}


def test_a_run_states_it_of_both_bodies(coarse, files, kept, tmp_path):
    folder, options = coarse
    film = film_forces(GRID)
    path = results(tmp_path / "run.h5", case_tree(options), film)
    piston = load(ReducedPiston, files["piston"])
    block = load(ReducedBlock, files["block"])
    rows = film_rows(piston.skirt_lower, piston.skirt_upper, GRID)
    loads = recorded_loads(path, GRID)
    on_bore = on_stations(loads, rows, block.heights)
    skirt = truncation(load(MissingShapes, files["piston"]), static_modes(piston), film)
    bore = truncation(load(MissingShapes, files["block"]), static_modes(block), on_bore)
    of_bore = on_rows(
        bore.missing.reshape(on_bore.pressure.shape), loads.height_of_A, rows, block.heights
    )
    gap = skirt.missing.reshape(film.pressure.shape) + of_bore
    added = state_truncation(case_tree(options), folder, path, quiet)
    assert added == {
        "truncation_error_piston": skirt.error,
        "truncation_error_piston_largest": skirt.largest,
        "truncation_error_block": bore.error,
        "truncation_error_block_largest": bore.largest,
        "truncation_error_film": np.abs(gap).max() / 1e-5,
        "truncation_error_edge": load(MissingShapes, files["piston"]).edge_errors.max(),
    }
    with h5py.File(path) as file:
        assert json.loads(file.attrs["summary"]) == {"steps": 3} | added
    without = results(tmp_path / "other.h5", {}, film, ("film_thickness",))
    assert truncations(options, folder, without).share_of_film is None


def test_a_run_that_cannot_state_it_says_why(coarse, kept, tmp_path):
    folder, options = coarse
    tree = case_tree(options)
    path = results(tmp_path / "run.h5", tree, film_forces(GRID), ("nodal_pressure_force",))
    added = state_truncation(tree, folder, path, quiet)
    assert list(added) == ["truncation_error"]
    assert added["truncation_error"].startswith("unknown: run.h5 has not recorded nodal_pressure")
    with h5py.File(path) as file:
        assert json.loads(file.attrs["summary"]) == {"steps": 3} | added
    once = results(tmp_path / "once.h5", tree, film_forces(GRID, instants=1))
    assert state_truncation(tree, folder, once, quiet) == {
        "truncation_error": "unknown: the last period has one recorded instant (record.every)"
    }


def test_the_odd_part_of_a_recorded_film_is_measured(coarse, kept, tmp_path):
    """Eq. (J49): film thickness and missing deflection are odd, modes of both bodies are even.

    Recorded is 10 um, and 1 um less on one side of the thrust plane. Loads without an odd part
    leave 0.5 um of 9 um.
    """
    folder, options = coarse
    even = options | {
        name: options[name] | {"symmetric_film": True} for name in ("piston", "block")
    }
    film = FilmLoads(*(np.zeros((2, *GRID)) for _ in FORCES))
    path = results(tmp_path / "run.h5", case_tree(even), film)
    for odd in (0.0, 1e-6):
        with h5py.File(path, "a") as file:
            file["fields/bodies/film_thickness"][:, 1:4] = 1e-5 - odd  # 0 to 90 deg
        added = state_truncation(case_tree(even), folder, path, quiet)
        assert added["odd_part_film"] == pytest.approx(odd / 2 / (1e-5 - odd), abs=1e-15)
    pushed = film._replace(pressure=film_forces(GRID).pressure[:2] * (np.arange(16) < 4)[:, None])
    path = results(tmp_path / "pushed.h5", case_tree(even), pushed)
    added = state_truncation(case_tree(even), folder, path, quiet)
    assert 0 < added["odd_part_film"] <= added["truncation_error_film"]
    assert "odd_part_film" not in state_truncation(case_tree(options), folder, path, quiet)


def test_rigid_and_foreign_bodies_have_none(coarse, kept, tmp_path):
    folder, options = coarse
    path = results(tmp_path / "run.h5", {}, film_forces(GRID))
    rigid = options | {name: options[name] | {"modes": 0} for name in ("piston", "block")}
    assert state_truncation(case_tree(rigid), folder, path, print) == {}
    half = options | {"block": rigid["block"]}
    found = state_truncation(case_tree(half), folder, path, quiet)
    assert list(found) == [
        *("truncation_error_piston", "truncation_error_piston_largest"),
        "truncation_error_film",
        "truncation_error_edge",
    ]
    foreign = {"participants": {"bodies": {"fmu": "own.fmu"}}}
    assert state_truncation(foreign, folder, path, print) == {}


def test_a_body_without_what_is_left_out_says_so(coarse, files, kept, tmp_path):
    """As earlier versions wrote it."""
    folder, options = coarse
    with np.load(files["piston"]) as whole:
        older = {
            name: whole[name] for name in whole.files if name not in MissingShapes.__annotations__
        }
    np.savez(tmp_path / "older.npz", **older)
    table = options | {"piston": {"reduced": str(tmp_path / "older.npz")}}
    path = results(tmp_path / "run.h5", {}, film_forces(GRID))
    with pytest.raises(ValueError, match="expected left_radial, .* in older.npz, got"):
        truncations(table, folder, path)
