"""Temperatures of skirt and bore: growth of both walls, the oil between them, work, and faults."""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.build_options import WallTemperature, WallTemperatures
from piston_cosim.fmu_mfbd.dynamics.parameters import (
    BoreTemperatureParameters,
    Parameters,
    SkirtTemperatureParameters,
)
from piston_cosim.fmu_mfbd.geometry.profile import MeasuredShape
from piston_cosim.fmu_mfbd.input_tables import read_temperatures
from piston_cosim.fmu_mfbd.options import read_options
from piston_cosim.master.fmi.errors import BadInput

from .conftest import sheets
from .test_changes_between_steps import COUNTS, same
from .test_model import STEP, inputs

SKIRT, BORE, REFERENCE = 403.15, 383.15, 293.15
FIELD = WallTemperature(REFERENCE, varies=True)
EVEN = WallTemperatures(WallTemperature(SKIRT), WallTemperature(BORE), 0)


def built(reduced, walls, *rises, **values):
    """Return the small bodies with temperatures, rises of walls and parameters."""
    options, piston, block = reduced
    options = dataclasses.replace(options, temperatures=walls)
    return assemble(piston, block, options, Parameters(**values), rises)


def taken(model, steps=4, size=2.0, **given):
    """Return state and outputs after some steps with these inputs."""
    given = dict(piston_temperature=SKIRT, bore_temperature=BORE) | given
    begin = dataclasses.replace(inputs(model, size=0.0), **given)
    state, out = model.start(0.3, 2e-6, 1e-4, begin)
    for k in range(steps):
        state, out = model.advance(
            state, dataclasses.replace(inputs(model, k, size=size), **given), STEP
        )
    return state, out


def table_over(angle, height, seed):
    """Return differences of some kelvins from a level, over angle and height."""
    rng = np.random.default_rng(seed)
    value = 8.0 * rng.standard_normal((len(height), len(angle)))
    return MeasuredShape(angle, height, value - value.mean())


def lines_of(reduced):
    """Return angles and heights of the skirt's cells, and heights of the bore's table."""
    _, _, block = reduced
    skirt = built(reduced, None).film_surfaces[0].skirt
    return skirt.angle, skirt.height, block.heights


def tables(reduced):
    """Return temperatures of both walls as tables on their own grids."""
    angle, rows, heights = lines_of(reduced)
    return WallTemperatures(
        WallTemperature(SKIRT, table=table_over(angle, rows, 1)),
        WallTemperature(BORE, table=table_over(angle, heights, 2)),
        len(heights),
    )


def fields(walls):
    """Return the field inputs of tables."""
    names = {"skirt_field": walls.skirt, "bore_field": walls.bore}
    return {name: (wall.level + wall.table.value.T).ravel() for name, wall in names.items()}


def test_even_temperatures_have_the_bits_of_the_inputs(reduced):
    """The oil has the mean of both, everywhere and always."""
    _, given = taken(built(reduced, None))
    _, out = taken(built(reduced, EVEN))
    oil = out.pop("oil_temperature")
    same(given, out)
    np.testing.assert_array_equal(oil, (SKIRT + BORE) / 2)


def test_an_even_growth_by_parameters_replaces_that_of_the_temperature(reduced):
    """The bits of the growth alone; without given temperatures both add up."""
    grown = dict(skirt_growth_lower=5e-6, skirt_growth_upper=5e-6, bore_growth_lower=2e-6)
    _, cold = taken(
        built(reduced, None, **grown), piston_temperature=REFERENCE, bore_temperature=REFERENCE
    )
    _, out = taken(built(reduced, EVEN, **grown))
    del out["oil_temperature"]
    same(cold, out)
    _, both = taken(built(reduced, None, **grown))
    assert both["thermal_opening"] < -1e-6


def test_one_cell_by_hand(reduced):
    """A skirt that is 12 K hotter above, a bore that is 20 K hotter above.

    Cell 0 of the lowest row is at 1/(2 rows) of the skirt's height. Its wall has
    T = 403.15 K - 6 K + 12 K/(2 rows), and the bore the line between its ends.
    """
    options, piston, block = reduced
    even = built(reduced, EVEN)
    rises = SkirtTemperatureParameters(12.0), BoreTemperatureParameters(20.0)
    model = built(reduced, EVEN, *rises)
    state, out = taken(model, 0, 0.0)
    _, before = taken(even, 0, 0.0)
    rows = options.grid[1]
    skirt = 403.15 - 6.0 + 12.0 / (2 * rows)
    low, high = block.heights[0], block.heights[-1]
    y = out["piston_position"] + piston.skirt_lower
    y += (piston.skirt_upper - piston.skirt_lower) / (2 * rows)
    bore = 383.15 - 10.0 + 20.0 * (y - low) / (high - low)
    # the bore is read at the height of A for x_A = 0, here 0.3 um below: 2e-5 K, or 1e-11 m
    assert out["oil_temperature"][0, 0] == pytest.approx((skirt + bore) / 2, abs=2e-5)
    opened = 11e-6 * block.radius * (bore - 383.15) - 20e-6 * piston.radius * (skirt - 403.15)
    change = out["film_thickness"][0, 0] - before["film_thickness"][0, 0]
    assert change == pytest.approx(opened, abs=2e-11)
    p = built(reduced, None).model.settings
    growth = 11e-6 * block.radius * 90.0 - 20e-6 * piston.radius * 110.0
    assert p.reference_temperature == 293.15
    assert before["thermal_opening"] == pytest.approx(growth, rel=1e-12)


@pytest.mark.parametrize("wall", ["skirt", "bore"])
def test_a_hot_shape_does_not_grow(reduced, wall):
    """It has the bits of a wall at the reference temperature; the oil is hot all the same."""
    options, piston, block = reduced
    part = {"skirt": "piston", "bore": "block"}[wall]
    hot = dataclasses.replace(getattr(options, part), is_hot=True)
    given = tables(reduced)
    still = {part: hot}
    model = built((dataclasses.replace(options, **still), piston, block), given)
    flat = dataclasses.replace(getattr(given, wall), table=None)
    other = built(reduced, dataclasses.replace(given, **{wall: flat}))
    cool = {"skirt": "piston_temperature", "bore": "bore_temperature"}[wall]
    ends = taken(model)[1], taken(other, **{cool: REFERENCE})[1]
    same(*ends, ("oil_temperature",))
    oil = [end["oil_temperature"] for end in ends]
    assert np.abs(oil[0] - oil[1]).max() > 40.0


def test_a_table_equals_the_field_input(reduced):
    """Motion, gap, oil and account at every step, to a few roundings."""
    walls = tables(reduced)
    _, out = taken(built(reduced, walls))
    moving = WallTemperatures(FIELD, FIELD, walls.stations)
    _, other = taken(built(reduced, moving), **fields(walls))
    assert np.ptp(out["oil_temperature"]) > 5.0
    for name, value in out.items():
        if name not in (*COUNTS, "power_error", "interface_work_error"):
            scale = np.abs(value).max()
            np.testing.assert_allclose(other[name], value, rtol=0, atol=1e-12 * scale, err_msg=name)


def test_walls_that_grow_unevenly_do_the_work_of_every_cell(reduced):
    """Eq. (D55) by cells: force times change of the gap at the same motion, once.

    A cold and a hot step from one state have the same motion to first order in their shape, because
    forces are inputs. The hot step repeated from its end does no more work.
    """
    walls = tables(reduced)
    model = built(reduced, WallTemperatures(FIELD, FIELD, walls.stations))
    warm = fields(walls)
    cold = {name: np.full_like(value, REFERENCE) for name, value in warm.items()}
    state, _ = taken(model, 3, **cold)
    last = inputs(model, 3)
    steps = [
        model.advance(state, dataclasses.replace(last, **given), STEP) for given in (cold, warm)
    ]
    (_, before), (after, out) = steps
    work = np.sum(last.pressure_force * (out["film_thickness"] - before["film_thickness"]))
    added = STEP * (out["film_power"] - before["film_power"])
    slope = abs(STEP * before["piston_velocity"]) * np.abs(last.pressure_force).sum() * 1e-3
    assert abs(work) > 1e-6
    assert added == pytest.approx(work, abs=slope)
    again = model.advance(after, dataclasses.replace(last, **warm), STEP)[1]
    forgot = after._replace(thermal_opening=0.0, field_growth=np.zeros_like(after.field_growth))
    lost = model.advance(forgot, dataclasses.replace(last, **warm), STEP)[1]
    once = STEP * (lost["film_power"] - again["film_power"])
    assert once == pytest.approx(work, rel=0.02)


def test_a_repeated_step_has_the_same_bits(reduced):
    """Fields of another step in between leave nothing behind."""
    walls = tables(reduced)
    model = built(reduced, WallTemperatures(FIELD, FIELD, walls.stations))
    warm = fields(walls)
    state, _ = taken(model, 2, **warm)
    last = dataclasses.replace(inputs(model, 2), **warm)
    first = model.advance(state, last, STEP)[1]
    other = {name: value + 10.0 * np.sin(np.arange(value.size)) for name, value in warm.items()}
    model.advance(state, dataclasses.replace(last, **other), STEP)
    same(first, model.advance(state, last, STEP)[1])


def test_the_derivative_does_not_depend_on_temperatures(reduced):
    """Forces at the end of a step open the film as before, and leave the oil as it is."""
    changes = []
    for walls in (None, EVEN):
        model = built(reduced, walls)
        taken(model)
        push = np.ones_like(inputs(model).pressure_force)
        changes.append(model.directional_derivative(push, 0.1 * push))
    assert np.all(changes[1].pop("oil_temperature") == 0.0)
    same(*changes)


# ---- faults


RANGE = "expected 233.15 to 573.15 K"
FAULTS = {
    "kelvin": (
        dict(skirt="120 K"),
        f"temperatures.skirt.value: {RANGE}, got 120 K = -153.15 degC",
    ),
    "celsius": (
        dict(skirt="400 degC"),
        f"temperatures.skirt.value: {RANGE}, got 673.15 K = 400 degC",
    ),
    "edge": (dict(bore=["380 degC", "100 degC"]), "temperatures.bore.edges.0"),
    "unit": (dict(bore="3 m"), "temperatures.bore.value: expected a quantity in K, got '3 m'"),
    "two forms": (
        dict(bore={"value": "100 degC", "input": True}),
        "temperatures.bore: expected one of value, edges, file and input, got value and input",
    ),
    "units": (
        dict(skirt={"file": "t.csv"}),
        "temperatures.skirt.angle_unit: expected a value with file",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_wrong_temperatures_are_rejected(name, tmp_path):
    given, text = FAULTS[name]
    (tmp_path / "t.csv").write_text("0,0\n0,100\n")
    walls = {"skirt": "120 degC", "bore": "110 degC"} | given
    with pytest.raises(BadInput) as error:
        read_options(sheets(temperatures=walls), tmp_path)
    assert any(line.startswith(text) for line in error.value.faults), error.value.faults


TABLE = {"file": "t.csv", "angle_unit": "deg", "height_unit": "mm", "temperature_unit": "degC"}


@pytest.mark.parametrize(
    "rows, unit, text",
    [
        ("-50, 120, 120\n50, 130, 140\n", "K", "got 120 K at 0 deg, -50 mm in"),
        ("-50, 400, 420\n50, 430, 440\n", "degC", "got 673.15 K at 0 deg, -50 mm in"),
        ("-50, 120\n50, 130, 140\n", "degC", "line 2: expected 3 numbers, a height and 2 values"),
        ("-50, 120, x\n50, 130, 140\n", "degC", "line 2: expected numbers, got 'x'"),
    ],
)
def test_wrong_tables_are_rejected(rows, unit, text, tmp_path):
    (tmp_path / "t.csv").write_text("0, 0, 180\n" + rows)
    walls = {"skirt": TABLE | {"temperature_unit": unit}, "bore": "110 degC"}
    build = read_options(sheets(temperatures=walls), tmp_path)
    with pytest.raises(BadInput, match="temperatures.skirt.file: ") as error:
        read_temperatures(build)
    assert text in str(error.value)
