"""Bodies with half of a film that is its own mirror image equal those with the whole film."""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.build import prepare
from piston_cosim.fmu_mfbd.dynamics.assembly import ReducedBodies, model_of
from piston_cosim.fmu_mfbd.dynamics.build_options import BuildOptions
from piston_cosim.fmu_mfbd.dynamics.model import Inputs, MotionNotSolved
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.geometry.modal_field import EVEN, ODD_X, SIGNS, mirrors
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedBlock, ReducedPiston, load
from piston_cosim.master.fmi.symmetry import odd_part

from .conftest import quiet

SPEED = 314.0
STEP = np.pi / 180 / SPEED
SHAPED = dict(
    barrel=20e-6,
    ovality=50e-6,
    bore_growth_upper=6e-6,
    quasi_static_frequency=20e3,
    top_ring_height=18e-3,
    second_ring_height=14e-3,
)
BANDS = [{"name": name, "rows": rows} for name, rows in (("low", [1, 4]), ("up", [6, 10]))]


def classed(values, kind):
    """Return the parts of modes, (angles, rows, k), in their symmetry classes."""
    out = np.empty_like(values)
    image = mirrors(len(values))
    part = (values[image] * SIGNS[kind].T[:, None, None, :]).mean(axis=0)
    for sign, at in zip(SIGNS[kind].T, image):
        out[at] = sign * part
    return out


def even(values, kind):
    """Return the parts of modes that are even about the thrust plane; `kind` is not needed."""
    return values - odd_part(values)


def mirrored(body, around, classes):
    """Return a body whose surface is its own mirror image, with or without symmetry classes."""
    count = len(body.omega)
    kind = np.array([EVEN, ODD_X])[np.arange(count) % 2]
    part = classed if classes else even
    fields = {
        name: part(getattr(body, name).reshape(around, -1, count), kind)
        for name in ("radial", "axial")
    }
    shapes = {name: one.reshape(getattr(body, name).shape) for name, one in fields.items()}
    return dataclasses.replace(body, **shapes, kind=kind if classes else np.full(count, -1))


UNITS = {"angle_unit": "deg", "height_unit": "mm", "temperature_unit": "degC"}
WALLS = {"skirt": {"file": "even.csv"} | UNITS, "bore": ["90 degC", "120 degC"]}


@pytest.fixture(scope="module", params=[([8, 6], True, [], WALLS), ([10, 10], False, BANDS, None)])
def symmetric(request, coarse, kept):
    """Return options and bodies that are their own mirror image, and a maker of models."""
    grid, classes, bands, walls = request.param
    folder, build = coarse
    (folder / "even.csv").write_text(
        "0, 0, 90, 180, 270\n-99, 90, 99, 90, 95\n99, 120, 130, 120, 140"
    )
    build = build | {"grid": grid, "film_surfaces": bands, "temperatures": walls}
    prepared, files = prepare(build, folder, quiet)
    options = BuildOptions.from_json(prepared)
    piston, block = (load(k, f) for k, f in zip((ReducedPiston, ReducedBlock), files))
    bodies = [mirrored(one, grid[0], classes) for one in (piston, block)]

    def model(symmetry, **parameters):
        values = Parameters(**SHAPED | parameters, film_symmetry=symmetry)
        return model_of(ReducedBodies(*bodies), options, values)

    return model


def forces(model, seed, size=2.0):
    """Return random forces on all films that are their own mirror image, stacked."""
    rng = np.random.default_rng(seed)
    fields = [size * rng.random((2, *film.shape)) for film in model.films]
    pairs = [one - odd_part(one, 1) for one in fields]
    return [np.concatenate([pair[k].ravel() for pair in pairs]) for k in range(2)]


def test_half_of_the_films_gives_the_motion_of_whole_films(symmetric):
    """All outputs and derivatives agree to round-off, and the film is exactly its own image.

    Tables without classes are means of two numbers in single precision, hence 1e-7.
    """
    found = []
    for symmetry in ("none", "automatic"):
        model = symmetric(symmetry)
        state, outputs = model.start(0.3, 2e-6, 1e-4, Inputs(SPEED, 0.0, *forces(model, 0, 0.0)))
        seen = [outputs]
        for k in range(5):
            given = Inputs(SPEED, 5e5, *forces(model, k))
            state, outputs = model.advance(state, given, STEP * (1 + k % 2))
            seeds = model.directional_derivative(*forces(model, 20 + k))
            seen.append(outputs | {f"of {name}": one for name, one in seeds.items()})
        rows = {len(one.skirt.angle) for one in model.film_surfaces}
        found.append((seen, rows, model.films))
    (whole, rows, films), (half, half_rows, _) = found
    (around,), round_off = rows, 1e-11 if len(films) == 1 else 1e-7
    assert half_rows == {around // 2 + 1}
    bend = np.ptp(whole[-1]["modal_coordinate"])
    assert bend > 1e-9
    for expected, got in zip(whole, half):
        assert got.keys() == expected.keys()
        for name, value in expected.items():
            size = np.abs(value).max()
            if name.endswith(("work_error", "power_error", "_evaluations")):
                assert np.abs(got[name] - value).max() <= (1e-12 if "error" in name else 0), name
            else:
                assert np.abs(got[name] - value).max() <= round_off * size, name
            if name.endswith(("film_thickness", "sliding_velocity")):
                assert not odd_part(got[name]).any()


def test_forces_that_are_not_symmetric_discard_a_step(symmetric):
    """With a tilted pin, half of a film cannot be demanded, and whole films are the default."""
    model = symmetric("thrust_plane")
    push, drag = forces(model, 0)
    state, _ = model.start(0.3, 2e-6, 1e-4, Inputs(SPEED, 0.0, push, drag))
    push[1] *= 1.01  # row 1 of the first film, cell 2
    with pytest.raises(MotionNotSolved, match=r"nodal_pressure_force\[1,2\]: .* film_symmetry"):
        model.advance(state, Inputs(SPEED, 0.0, push, drag), STEP)
    assert model.half_faults() == []
    (fault,) = symmetric("thrust_plane", pin_tilt=1e-4).half_faults()
    assert fault.startswith("film_symmetry: ") and "pin_tilt = 0.0001 rad" in fault
    tilted = symmetric("automatic", pin_tilt=1e-4)
    assert len(tilted.film_surfaces[0].skirt.angle) == tilted.films[0].shape[0]


def test_bodies_that_are_not_symmetric_have_no_half(coarse, kept):
    folder, build = coarse
    prepared, files = prepare(build | {"grid": [8, 6]}, folder, quiet)
    bodies = ReducedBodies(*(load(k, f) for k, f in zip((ReducedPiston, ReducedBlock), files)))
    options = BuildOptions.from_json(prepared)
    values = Parameters(film_symmetry="thrust_plane")
    (fault,) = model_of(bodies, options, values).half_faults()
    assert fault.startswith("film_symmetry: expected none for films or bodies")
