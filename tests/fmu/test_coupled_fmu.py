"""The coupled system as one FMU gives what a run gives, at any communication step."""

import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.participants.fmi2 import FmuParticipant

from .runs import EXAMPLE, build_of, coarse, export, run_tree, small_tree, values_of

SHEET = find_case("data_sheet")
STEPS = 12
WATCHED = ("lateral_displacement", "minimum_film_thickness", "side_force", "friction_power")
TREE = small_tree(("time.stop", f"{STEPS} deg"))


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """Return the watched outputs after every macro step, (STEPS + 1, 4), and the macro step [s]."""
    results = run_tree(EXAMPLE, TREE, tmp_path_factory.mktemp("run") / "run.h5")
    ports = [next(port for port in results.ports if port.endswith(f".{n}")) for n in WATCHED]
    return np.transpose(values_of(results, *ports)), results.time[-1] / STEPS


@pytest.fixture(scope="module")
def coupled():
    return export(TREE)


def started(path):
    participant = FmuParticipant("coupled", path)
    participant.start({}, 0.0, 1.0)
    return participant


def watched(participant):
    return [participant.get(name) for name in WATCHED]


def test_inputs_are_those_without_a_wire(coupled):
    inputs = {
        v.name
        for v in fmpy.read_model_description(str(coupled)).modelVariables
        if v.causality == "input"
    }
    rings = {"ring_side_force", "ring_axial_force", "ring_moment"}
    assert inputs == {
        *("crank_speed", "load_torque", "gas_pressure", "crankcase_pressure", "land_pressure"),
        *("piston_temperature", "bore_temperature"),
        *rings,
    }


def test_participants_have_the_code_of_their_own_fmus(coupled):
    """So that what is compiled of a participant serves both."""
    inside = codes_in(coupled)
    for name in ("ehd", "bodies"):
        own = codes_in(build_fmu(*build_of(TREE, EXAMPLE, name)))
        assert len(own) == 1 and own < inside
    assert len(inside) == 3


def test_only_a_first_start_reports_that_it_compiles(coupled):
    """Participants report it. The code that couples them has nothing to compile."""
    started(coupled).close()
    assert not [text for _, text in started(coupled).log if "compiling" in text]


def codes_in(fmu):
    """Names of the packages of code that an FMU carries."""
    with zipfile.ZipFile(fmu) as archive:
        paths = [Path(name).parts for name in archive.namelist()]
    return {path[1] for path in paths if len(path) > 2 and path[1].startswith("code_")}


def test_same_results_as_run_at_the_macro_step(coupled, reference):
    values, step = reference
    participant = started(coupled)
    rows = [watched(participant)]
    for k in range(STEPS):
        participant.step(k * step, step)
        rows.append(watched(participant))
    assert np.array_equal(rows, values)  # the same steps at the same times by the same code


def advanced(coupled, step, factor, end):
    """Return the watched outputs after each communication step, shape (end / factor, 4).

    A communication step has `factor` macro steps; `end` is the number of macro steps.
    """
    participant, rows = started(coupled), []
    for k in range(round(end / factor)):
        participant.step(k * factor * step, factor * step)
        rows.append(watched(participant))
    return np.array(rows)


def test_steps_between_a_tenth_and_ten_times_the_case_s(coupled, reference):
    """Steps of any length end within the error of the macro step.

    The error is the largest difference until then between the run and one in tenths of the macro
    step. The FMU cuts longer steps into whole macro steps. Steps of two, five and ten macro steps
    give the run's own values.
    """
    values, step = reference
    end = 10
    fine = advanced(coupled, step, 0.1, end)
    error = np.abs(values[1 : end + 1] - fine[9::10]).max(axis=0)
    assert np.all(error > 0)
    for factor in (0.2, 0.4, 0.5, 1.25, 2.5):
        apart = np.abs(advanced(coupled, step, factor, end)[-1] - fine[-1])
        assert np.all(apart <= error), factor
    for factor in (1, 2, 5, 10):
        np.testing.assert_allclose(advanced(coupled, step, factor, end)[-1], values[end], rtol=1e-6)


POWERS = ("film_power", "ehd.received_power", "bodies.received_power", "heat_generated")


def test_energy_of_a_motion_is_independent_of_the_step(coupled, reference):
    """Mean powers times the step sum to the same energy with half the communication step.

    Outputs that are sums over a step would give half of it. 8 %: power grows with the square of
    time from rest. By values at the ends, 12 and 24 steps differ by 5.8 %.
    """
    _, step = reference
    energies = []
    for count in (STEPS, 2 * STEPS):
        length = STEPS * step / count
        participant = started(coupled)
        total = np.zeros(len(POWERS))
        for k in range(count):
            participant.step(k * length, length)
            total += [length * participant.get(name) for name in POWERS]
        energies.append(total)
    assert np.all(energies[0] != 0.0)
    np.testing.assert_allclose(energies[1], energies[0], rtol=0.08)


def test_derivatives_are_those_of_the_step(coupled, reference):
    """Directional derivatives equal central differences of the repeated step and change no state.

    The seed has both inputs. The next step gives the same bits as without derivatives. The test
    uses the fourth step: in the second the piston is nearer to the middle than it is nudged, and
    the thinnest film changes sides.
    """
    _, step = reference
    last = 3
    one, two = started(coupled), started(coupled)
    for participant in (one, two):
        for k in range(last + 1):
            participant.step(k * step, step)
    seeds = {"crank_speed": 1.0, "gas_pressure": 2e4}
    products = one.derivative({k: np.array(v) for k, v in seeds.items()}, list(WATCHED))
    values = {name: one.get(name) for name in seeds}
    sides = []
    for sign in (1.0, -1.0):
        other = started(coupled)
        for k in range(last):
            other.step(k * step, step)
        for name, seed in seeds.items():
            other.set(name, values[name] + sign * seed)
        other.step(last * step, step)
        sides.append(np.array(watched(other)))
    expected = (sides[0] - sides[1]) / 2
    found = np.array([products[name] for name in WATCHED])
    # the motion is of 9e-9 m by then and changes by 4e-11 m over the nudge, of which a macro step
    # that agrees to 1e-11 m (1e-6 of its nominal value) at the latest knows some percent
    np.testing.assert_allclose(found, expected, rtol=3e-2)
    assert np.all(found != 0)
    for participant in (one, two):
        participant.step((last + 1) * step, step)
    assert watched(one) == watched(two)


@pytest.mark.parametrize("native", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_gas_table_outside_is_the_table_inside(native):
    """FMPy sets inputs and their derivatives at the beginning of a step, the FMU reads their end.

    With rows a step earlier, the values are those of the end but for round-off of interpolation.
    FMPy takes the slope before a row. With derivatives, rows a millionth of a step earlier are
    therefore off by a millionth of the slope. FMPy passes derivatives of exactly nine inputs. No
    step is repeated in parts, over which an input would be constant.
    """
    parameters = {"start_crank_angle": "-60 deg", "impact_resolution": "1 m"}
    changes = coarse(*((f"participants.bodies.parameters.{k}", v) for k, v in parameters.items()))
    trees = {
        source: read_tree(SHEET, [*changes, ("participants.bodies.parameters.gas_source", source)])
        for source in ("table", "input")
    }
    fmus = {source: export(tree, SHEET, native) for source, tree in trees.items()}
    description = fmpy.read_model_description(str(fmus["input"]))
    inputs = [v for v in description.modelVariables if v.causality == "input"]
    assert all("end of the step" in v.description for v in inputs)
    angle, pressure = np.loadtxt(SHEET.parent / "gas_pressure.csv", delimiter=",", skiprows=1).T
    step = float(description.defaultExperiment.stepSize)
    signals = np.zeros(len(angle), [("time", float), *((v.name, float) for v in inputs[:9])])
    for v in inputs[:9]:
        signals[v.name] = v.start
    signals["gas_pressure"] = 1e6 * pressure
    how = {"stop_time": 90 * step, "output_interval": step, "output": WATCHED}
    inside = fmpy.simulate_fmu(str(fmus["table"]), **how)

    def difference(early, derivatives):
        """Return the largest relative difference, with rows a share of a step earlier."""
        signals["time"] = (angle + 60 - early) * step  # 1 deg a step
        how_set = how | {"input": signals, "set_input_derivatives": derivatives}
        outside = fmpy.simulate_fmu(str(fmus["input"]), **how_set)
        return max(
            np.abs(outside[name] - inside[name]).max() / np.abs(inside[name]).max()
            for name in WATCHED
        )

    assert difference(1.0, False) < 1e-12
    assert difference(1e-6, True) < 1e-6 and difference(0.0, False) > 1e-2


def test_an_fmu_cannot_be_taken_inside(coupled):
    inside = TREE["participants"] | {"ehd": {"fmu": str(coupled)}}
    with pytest.raises(BadInput, match="participants.ehd"):
        export(TREE | {"participants": inside})
