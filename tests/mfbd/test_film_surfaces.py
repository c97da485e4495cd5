"""Several film surfaces on one piston: the same motion as with one, each with its own fields."""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.build_options import SurfaceOptions
from piston_cosim.fmu_mfbd.dynamics.model import MOTION, Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.options import read_options
from piston_cosim.master.fmi.errors import BadInput

from .differences import products_by_differences, rough_change
from .test_model import SPEED, STEP

AROUND, ALONG = 16, 12
BANDS = (SurfaceOptions("lower", 0, 5), SurfaceOptions("upper", 5, ALONG))
GROOVE = (SurfaceOptions("lower", 0, 5), SurfaceOptions("upper", 6, ALONG))


@pytest.fixture
def built(reduced):
    """Maker of the small bodies with given surfaces, an offset crank and a machined profile."""
    options, piston, block = reduced

    def make(surfaces):
        parameters = Parameters(crank_offset=1e-3, barrel=15e-6, ovality=20e-6)
        return assemble(piston, block, dataclasses.replace(options, surfaces=surfaces), parameters)

    return make


def loads(seed):
    """Pressure and friction forces on the whole skirt, most of them on the thrust side."""
    rng = np.random.default_rng(seed)
    theta = np.pi / 2 + (np.arange(AROUND) - AROUND // 4) * 2 * np.pi / AROUND
    push = np.maximum(np.sin(theta)[:, None] + 0.3, 0.0) * rng.random((AROUND, ALONG))
    return 2.0 * push, -0.2 * push


def stacked(field, surfaces):
    """Return the rows of a field of several surfaces, one surface after another."""
    return np.concatenate([field[:, one.first : one.last].ravel() for one in surfaces])


def steps(model, surfaces, count=8, rows=slice(None)):
    loaded = np.zeros(ALONG)
    loaded[rows] = 1.0
    """Outputs after some steps under `loads`."""
    nothing = stacked(np.zeros((AROUND, ALONG)), surfaces)
    state, out = model.start(0.3, 2e-6, 1e-4, Inputs(SPEED, 0.0, nothing, nothing))
    for k in range(count):
        push, drag = (stacked(field * loaded, surfaces) for field in loads(k))
        state, out = model.advance(state, Inputs(SPEED, 5e5, push, drag), STEP)
    return state, out


@pytest.mark.parametrize("surfaces", [BANDS, GROOVE])
def test_surfaces_are_the_skirt_without_forces_between_them(built, surfaces):
    """The sums over both run in another order: round-off, some 1e-13 of each output's size."""
    rows = np.concatenate([np.arange(one.first, one.last) for one in surfaces])
    whole = steps(built(()), (SurfaceOptions("", 0, ALONG),), rows=rows)[1]
    parts = steps(built(surfaces), surfaces)[1]
    for name in ("film_thickness", "sliding_velocity"):
        joined = np.concatenate([parts[f"{one.name}.{name}"] for one in surfaces], axis=1)
        np.testing.assert_allclose(joined, whole[name][:, rows], rtol=1e-12, atol=0.0)
    for name in ("rocking_angle", "side_force", "pin_force_y", "crank_torque", "film_power"):
        assert parts[name] == pytest.approx(whole[name], rel=1e-11)
    np.testing.assert_allclose(
        parts["modal_coordinate"],
        whole["modal_coordinate"],
        rtol=0.0,
        atol=1e-12 * np.abs(whole["modal_coordinate"]).max(),
    )


@pytest.mark.parametrize("surfaces", [BANDS, GROOVE])
def test_derivative_of_all_films_against_differences(built, surfaces):
    """Central differences of the step, smooth and nearly affine: 1e-7 holds with unit changes."""
    model = built(surfaces)
    state, _ = steps(model, surfaces)
    base = Inputs(SPEED, 5e5, *(stacked(field, surfaces) for field in loads(50)))
    change = rough_change(model, base)
    products = products_by_differences(model, state, base, change, STEP, 1e-7)
    fields = {f"{s.name}.{f}" for s in surfaces for f in ("film_thickness", "sliding_velocity")}
    assert products.keys() == fields | set(MOTION)


def test_work_of_every_film_is_the_same_on_its_grid_and_in_the_coordinates(built):
    _, out = steps(built(GROOVE), GROOVE)
    for one in GROOVE:
        assert out[f"{one.name}.interface_work_error"] <= 1e-13
    assert "interface_work_error" not in out


def table(*surfaces, grid=(16, 12)):
    material = {"density": "2700 kg/m^3", "young": "75 GPa", "poisson": 0.3}
    bodies = {name: {"mesh": f"{name}.msh"} | material for name in ("piston", "block")}
    films = [{"name": name, "rows": rows} for name, rows in surfaces]
    return {"grid": list(grid), "film_surfaces": films} | bodies


def faults(options, folder):
    with pytest.raises(BadInput) as error:
        read_options(options, folder)
    return "\n".join(error.value.faults)


def test_surfaces_that_cannot_be_are_refused(tmp_path):
    told = faults(table(("a", [1, 5]), ("b", [5, 9])), tmp_path)
    assert "film_surfaces.1.rows: expected rows above 5," in told and "got [5, 9]" in told
    assert "film_surfaces.1.name: expected a new name, got 'a'" in faults(
        table(("a", [1, 5]), ("a", [6, 9])), tmp_path
    )
    assert "film_surfaces.1.rows: expected at most 12 rows, got [6, 13]" in faults(
        table(("a", [1, 5]), ("b", [6, 13])), tmp_path
    )
    assert "film_surfaces.0.rows: expected at least 4 rows, got 3" in faults(
        table(("a", [1, 3])), tmp_path
    )
    assert "film_surfaces.0.name" in faults(table(("Upper band", [1, 5])), tmp_path)
