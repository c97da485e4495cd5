from pathlib import Path

import numpy as np
import pytest

from piston_cosim.fmu_ehd.build import prepare
from piston_cosim.fmu_ehd.slave import Ehd
from piston_cosim.master.fmi.errors import BadInput

from ..forged import outcomes
from .fuzz import made_slave


@pytest.fixture
def slave(tmp_path):
    """Return the slave on a small grid, as the FMU's host uses it."""
    return made_slave(tmp_path, grid=[8, 6])


def test_every_output_is_declared_and_every_declared_output_is_set(slave):
    slave.exit_initialization_mode()
    assert slave.fault is None
    declared = {v.name for v in slave.table if v.causality == "output"}
    state, outputs = slave.advance(slave.state, slave._values(), 0.0, 1e-4)
    assert set(outputs) == declared
    assert isinstance(state, Ehd.state_type)


@pytest.mark.parametrize("supply", ["edges", "bore_and_ring"])
def test_restored_state_repeats_the_bytes(slave, supply):
    choose(slave, "oil_supply", supply)
    slave.exit_initialization_mode()
    slave.views["sliding_velocity"][...] = 3.0
    film = 1e-5 - 3e-6 * np.linspace(0.0, 1.0, 48).reshape(8, 6)
    slave.views["film_thickness"][...] = film
    assert slave.do_step(0.0, 5e-5)  # the next step remembers this one
    saved = slave._get_fmu_state()
    slave.views["film_thickness"][...] = 1.1 * film
    assert slave.do_step(5e-5, 1e-4)
    first = slave._fmu_state_to_bytes(slave._get_fmu_state())
    for restored in (saved, slave._fmu_state_from_bytes(slave._fmu_state_to_bytes(saved))):
        slave._set_fmu_state(restored)
        slave.views["film_thickness"][...] = 1.1 * film
        assert slave.do_step(5e-5, 1e-4)
        assert slave._fmu_state_to_bytes(slave._get_fmu_state()) == first


def test_a_state_of_another_grid_is_refused(slave, tmp_path):
    """A grid of 6 x 8 cells has as many numbers as one of 8 x 6."""
    (tmp_path / "other").mkdir()
    other = made_slave(tmp_path / "other", grid=[6, 8])
    log = []
    slave.log = lambda text, *_: log.append(text)
    for one in (slave, other):
        one.exit_initialization_mode()
    state = slave._fmu_state_from_bytes(other._fmu_state_to_bytes(other._get_fmu_state()))
    slave._set_fmu_state(state)
    assert "expected a state of this FMU, got one of another grid" in log[0]
    assert not slave.do_step(0.0, 1e-4)


@pytest.mark.parametrize("count", [300, pytest.param(5000, marks=pytest.mark.slow)])
def test_forged_states_give_a_sentence(slave, count):
    choose(slave, "oil_supply", "bore_and_ring")
    slave.exit_initialization_mode()
    slave.views["sliding_velocity"][...] = 3.0
    assert slave.do_step(0.0, 5e-5)
    seen = outcomes(slave, count, 5e-5, 5e-5)
    assert min(seen[name] for name in ("not read", "rejected", "taken")) > 0.05 * count, seen


@pytest.mark.parametrize("cells, warns", [(1, True), (2, False)])
def test_a_land_of_one_cell_is_warned_of(slave, cells, warns):
    """A land between grooves of 10 um, one or two of six cells wide, on a skirt 1 um rough."""
    slave.views["roughness_rms"][...] = 1e-6
    film = np.full((8, 6), 12e-6)
    film[:, 2 : 2 + cells] = 2e-6
    slave.views["film_thickness"][...] = film
    slave.show_start()
    slave.exit_initialization_mode()
    texts = [message.msg for message in slave.log_queue]
    assert sum("one cell wide" in text and "--smooth" in text for text in texts) == warns


@pytest.mark.parametrize("law", ["barus_1893", "roelands_1966"])
@pytest.mark.parametrize("closed, warns", [(8e-6, True), (1e-8, False)])
def test_pressure_beyond_the_law_is_warned_of_once(slave, law, closed, warns):
    """A pressure beyond the range of the law gives one warning.

    A film of 10 um that closes to 2 um in 1 us has GPa, beyond the range of both laws.
    If it closes by 10 nm, it has MPa.
    """
    choose(slave, "pressure_viscosity_law", law)
    slave.exit_initialization_mode()
    for step in range(2):
        slave.views["film_thickness"][...] = 1e-5 - closed * (step + 1) / 2
        assert slave.do_step(1e-6 * step, 1e-6)
    assert (slave.views["maximum_pressure"] > 1e9) == warns
    assert slave.views["maximum_pressure"] < np.inf
    texts = [message.msg for message in slave.log_queue]
    assert sum("exceeds the range of the law" in text for text in texts) == warns


def test_range_and_cross_faults_stop_the_start(slave):
    slave.views["pressure_upper_edge"][...] = -1e4
    slave.exit_initialization_mode()
    assert "pressure_upper_edge: expected at least" in slave.fault
    assert not slave.do_step(0.0, 1e-4)


def test_bad_build_options_are_reported_together():
    with pytest.raises(BadInput) as error:
        prepare({"grid": [40, 2], "grit": 1}, Path("."), print)
    assert len(error.value.faults) == 2


@pytest.mark.parametrize(
    "name, value, element, words",
    [
        ("film_thickness", np.nan, (0, 0), "expected a finite value, got nan m"),
        ("film_thickness", -1e-6, ..., "film_thickness[1,1]: expected more than 0 m"),
        ("film_thickness", 1e300, (2, 3), "not finite, first at [1,1]"),
        ("sliding_velocity", np.inf, (1, 2), "expected a finite value, got inf m/s"),
        ("sliding_velocity", 1e160, ..., "numbers overflow after a step of 0.0001 s"),
    ],
)
def test_senseless_input_is_refused_by_name_and_changes_nothing(slave, name, value, element, words):
    slave.exit_initialization_mode()
    log = []
    slave.log = lambda text, *_: log.append(text)
    slave.views[name][element] = value
    before = slave._fmu_state_to_bytes(slave._get_fmu_state())
    assert not slave.do_step(0.0, 1e-4)
    assert words in log[0]
    assert slave._fmu_state_to_bytes(slave._get_fmu_state()) == before


@pytest.mark.parametrize("step", [0.0, -1e-5, np.nan, np.inf])
def test_senseless_step_is_refused(slave, step):
    slave.exit_initialization_mode()
    assert not slave.do_step(0.0, step)


def choose(slave, name, law):
    """Choose a law as an importer does, by its number."""
    (variable,) = [v for v in slave.table if v.name == name]
    slave.set_integer([slave.first_references[name]], [1 + variable.choices.index(law)])


@pytest.mark.parametrize("number", [0, 5])
def test_unknown_law_is_a_fault_with_the_allowed_ones(slave, number):
    slave.set_integer([slave.first_references["cavitation_model"]], [number])
    slave.exit_initialization_mode()
    known = "1 jfo, 2 reynolds, 3 gumbel, 4 full_film"
    assert f"cavitation_model: expected {known}, got {number}" in slave.fault


def test_conditions_become_inputs(tmp_path):
    slave = made_slave(tmp_path, grid=[8, 6], inputs=["pressure_upper_edge", "oil_temperature"])
    assert {v.name for v in slave.table if v.causality == "input"} == {
        "film_thickness",
        "sliding_velocity",
        "pressure_upper_edge",
        "oil_temperature",
    }
    choose(slave, "viscosity_law", "vogel_1921")
    slave.exit_initialization_mode()
    slave.views["pressure_upper_edge"][...] = 2e5
    slave.views["oil_temperature"][...] = 400.0
    assert slave.do_step(0.0, 1e-4)
    assert slave.views["pressure"].max() > 1e5


def test_mask_and_library_faults_are_reported_together(tmp_path):
    (tmp_path / "mask.csv").write_text("1,1,2\n0,0,0\n")
    with pytest.raises(BadInput) as error:
        prepare({"grid": [8, 6], "mask": "mask.csv", "oil": "olive"}, tmp_path, print)
    assert len(error.value.faults) == 2 and "got 2 x 3" in "\n".join(error.value.faults)


def test_mask_cuts_cells_out(tmp_path):
    mask = np.ones((8, 6), dtype=int)
    mask[2:4, 1:4] = 0
    np.savetxt(tmp_path / "mask.csv", mask, fmt="%d", delimiter=",")
    slave = made_slave(tmp_path, grid=[8, 6], mask="mask.csv")
    slave.exit_initialization_mode()
    slave.views["film_thickness"][...] = 9e-6
    assert slave.do_step(0.0, 1e-4)
    assert np.array_equal(slave.views["nodal_pressure_force"] == 0.0, mask == 0)
