"""What a user passes to `Film`: conditions, quantities with units, oils, warnings."""

import warnings

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_ehd.build import declared_variables

GRID = (12, 10)
MOVING = dict(sliding_velocity=1.0)


def started(**parameters):
    """Return a film that has started."""
    film = pc.Film(GRID, **parameters)
    film.start(1e-5, **MOVING)
    return film


@pytest.mark.parametrize(
    "name, value, words",
    [
        ("oil_temperature", 0.0, "oil_temperature: expected 233.15 to 573.15 K, got 0 K"),
        ("oil_temperature", "900 degC", "oil_temperature: expected 233.15 to 573.15 K, got 1173"),
        ("oil_temperature", "3 m", "oil_temperature: expected a quantity in K, got '3 m'"),
        ("oil_temperature", np.full((3, 3), 350.0), r"oil_temperature: expected shape \(12, 10\)"),
        ("oil_temperature", None, "oil_temperature: expected a quantity in K, got None"),
        ("pressure_lower_edge", np.zeros(3), r"pressure_lower_edge: expected one number, got"),
        ("pressure_lower_edge", np.nan, "pressure_lower_edge: expected finite values"),
        ("pressure_lower_edge", -1e4, "pressure_lower_edge: expected at least cavitation_pressure"),
        ("film_fraction_upper_edge", 1.5, "film_fraction_upper_edge: expected 0 to 1, got 1.5"),
        ("viscosity", -1.0, "viscosity: expected 1e-05 to 1000 Pa.s, got -1"),
        ("pressure_low_edge", 0.0, "did you mean 'pressure_lower_edge'"),
        ("roughness_rms", 1e-6, "roughness_rms: expected a condition, got a parameter"),
        ("circumferential_velocity", 1.0, "circumferential_velocity: expected nothing for a skirt"),
    ],
)
def test_a_wrong_condition_is_rejected_by_name(name, value, words):
    film = started()
    state = film.state
    for call in (film.start, film.steady, lambda *h, **inputs: film.step(*h, 1e-4, **inputs)):
        with pytest.raises(pc.BadInput, match=words):
            call(1e-5, **MOVING, **{name: value})
    assert film.state is state


def test_every_condition_of_the_fmu_is_one_of_a_film_and_all_faults_are_listed(tmp_path):
    table = declared_variables(dict(grid=list(GRID), inputs=["oil_temperature"]), tmp_path)
    changing = {v.name for v in table if v.causality == "input" or v.tunable}
    film = started()
    with pytest.raises(pc.BadInput) as trouble:
        film.step(step=1e-4, **dict.fromkeys(changing, "1 cd"))
    # in "1 cd" no condition has its unit
    assert {fault.split(":")[0] for fault in trouble.value.faults} == changing


def test_a_quantity_with_a_unit_is_its_number_in_si():
    numbers, quantities = (started(viscosity_law="vogel_1921") for _ in range(2))
    expected = numbers.step(
        np.full(GRID, 9e-6), 1e-3, sliding_velocity=2.0, oil_temperature=353.15, oil_ring_layer=3e-6
    )
    outputs = quantities.step(
        "9 um", "1 ms", sliding_velocity="2 m/s", oil_temperature="80 degC", oil_ring_layer="3 um"
    )
    # round-off of the conversion of micrometres
    assert outputs["friction_power"] == pytest.approx(expected["friction_power"], rel=1e-12)
    quantities.step(9e-6, 1e-3, sliding_velocity=2.0, oil_temperature="120 degC")
    film = pc.Film((24, 6), surface="bearing", cavitation_pressure="-1 bar")
    by_unit = film.equilibrium(
        ("0.1 kN", "-1 kN"), "25 um", circumferential_velocity="5 m/s", tolerance=1e-9
    )
    by_number = film.equilibrium((100.0, -1000.0), 25e-6, circumferential_velocity=5.0)
    assert by_unit["position"] == pytest.approx(by_number["position"], rel=1e-7)
    for load in ("1 kN", (1.0, "2 m"), (1.0, None), (1.0, 2.0, 3.0), (np.nan, 1.0)):
        with pytest.raises(pc.BadInput, match="load: expected"):
            film.equilibrium(load, 25e-6, circumferential_velocity=5.0)


def test_an_oil_of_the_library_gives_the_defaults():
    film = pc.Film(GRID, oil="sae_0w_20", viscosity="3 mPa s")
    assert film.model.parameters.oil.viscosity_law == "walther_1931"
    assert film.model.parameters.oil.viscosity == 3e-3
    with pytest.raises(pc.BadInput, match="oil: expected one of .* did you mean 'sae_0w_20'"):
        pc.Film(GRID, oil="sae_0w_2")


def test_a_film_without_any_cell_is_rejected():
    with pytest.raises(pc.BadInput, match="open_cells: expected a film in at least one cell"):
        pc.Film(GRID, open_cells=np.ones(GRID, dtype=bool))


def test_what_an_fmu_logs_is_a_warning_once():
    film = pc.Film(GRID, roughness_rms=1e-6, pressure_viscosity_law="barus_1893")
    thickness = np.full(GRID, 1e-5)
    thickness[:, 4] += 2e-5
    with pytest.warns(UserWarning, match="a land or groove is one cell wide") as noted:
        film.steady(thickness, **MOVING)
    assert noted[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        film.start(thickness, **MOVING)
    with pytest.warns(UserWarning, match="exceeds the range of the law"):
        film.step(thickness - 9e-6, 1e-7, **MOVING)


def test_the_steady_film_of_a_soft_loaded_bearing_is_approached_from_thicker_films():
    """It ends at the film of the balance, which its own start does not reach."""
    film = pc.Film(
        (24, 5),
        surface="bearing",
        bore_radius="37 mm",
        skirt_length="61.8 mm",
        viscosity="0.18 Pa s",
        pressure_viscosity_law="roelands_1966",
        pressure_viscosity_coefficient="17 1/GPa",
        coating_thickness="28 um",
        coating_modulus="3.8 GPa",
    )
    inputs = dict(circumferential_velocity=-2.2, pressure_lower_edge=3e4)
    outputs = film.equilibrium((4.6e4, 1.77e5), 21e-6, **inputs)
    steady = film.steady(outputs["film_thickness"], **inputs)
    highest = outputs["maximum_pressure"]
    assert highest > 3e8
    assert np.abs(steady["pressure"] - outputs["pressure"]).max() <= 1e-8 * highest  # tolerance
