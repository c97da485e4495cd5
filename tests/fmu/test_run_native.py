"""`run` with participants of machine code: the same steps as with those in Python, by the same
master.
"""

import h5py
import numpy as np
import pytest

from piston_cosim.master.case.ahead import faults_ahead
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.machine_code import native_choice
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.fmi import builder_native
from piston_cosim.master.fmi.builder_native import library_name
from piston_cosim.master.fmi.compiler import compiler, this_platform
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.runs.run import run

from .films import PATH as DATA_SHEET
from .films import several_films

PATH = find_case("numerical_example")
SMALL = [
    *((f"participants.{name}.build.grid", [12, 10]) for name in ("bodies", "ehd")),
    *((f"participants.bodies.build.{body}.modes", 4) for body in ("piston", "block")),
    ("time.stop", "30 deg"),
    ("participants.bodies.parameters.crank_offset", "1 mm"),
    ("participants.ehd.parameters.film_fraction_lower_edge", 0.6),
    ("participants.ehd.parameters.roughness_rms", "1.5 um"),
    ("wires.0.tolerance", "0.01 nm"),
    ("wires.1.tolerance", 1e-8),
]
"""Flexible, beside the axis, little oil, surfaces that touch."""
SPEED = {"points": [[0.0, 6000.0], [360.0, 6000.0]], "angle_unit": "deg", "speed_unit": "rpm"}
"""A table of crank speed over angle."""
COUNTS = ("steps", "residual_evaluations", "jacobian_evaluations")
ROUND_OFF_BY_ITSELF = ("interface_work_error", "mass_imbalance", "block.energy_error")
"""The last one of the rigid block of the twin, 1e-17 J."""
AGREES = 1e-6
"""Of each curve's range. Where in the wires' tolerance an iteration ends follows the last digits of
the bodies' products, so the tolerance is a hundredth of the case's.
"""


def case_of(*changes, path=PATH, small=SMALL):
    tree = read_tree(path, [*small, *changes])
    return check_case(tree, path), tree


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Runs with machine code and with Python: summary and recorded scalars."""
    if not compiler() or builder_native.too_old():
        pytest.skip("no C compiler, an old numba, or not Linux")

    def by(native):
        case, tree = case_of(("native", native))
        file = tmp_path_factory.mktemp("run") / "run.h5"
        system = open_system(case, PATH.parent, lambda text: None)
        names = [participant.path.name for participant in system.participants.values()]
        summary = run(system, case, tree, file)
        with h5py.File(file) as results:
            curves = {
                f"{owner}.{name}": values[()]
                for owner in ("bodies", "ehd")
                for name, values in results[owner].items()
                if isinstance(values, h5py.Dataset) and values.ndim == 1
            }
        return names, summary, curves

    return by(True), by(False)


def test_participants_are_machine_code_where_the_case_says_so(finished):
    (native, *_), (python, *_) = finished
    assert [("-native-" in name) for name in native] == [True, True]
    assert [("-native-" in name) for name in python] == [False, False]


def test_a_run_takes_as_many_evaluations(finished):
    (_, native, _), (_, python, _) = finished
    assert {name: native[name] for name in COUNTS} == {name: python[name] for name in COUNTS}


def test_curves_agree(finished):
    (_, _, native), (_, _, python) = finished
    assert native.keys() == python.keys()
    assert len(native) > 30
    for name in native.keys() - {"bodies.interface_work_error", "ehd.mass_imbalance"}:
        size = max(np.ptp(python[name]), np.abs(python[name]).max())
        assert np.abs(native[name] - python[name]).max() <= AGREES * size, name


def ended(tree, path, file):
    """Summary of a run, and its recorded scalars, by participant and name."""
    case = check_case(tree, path)
    summary = run(open_system(case, path.parent, lambda text: None), case, tree, file)
    with h5py.File(file) as results:
        curves = {
            f"{owner}.{name}": values[()]
            for owner in case.participants
            for name, values in results[owner].items()
            if isinstance(values, h5py.Dataset) and values.ndim == 1
        }
    return summary, curves


def twin():
    """Two cylinders on a mounted block, whose file stays in Python; on small grids."""
    path = find_case("twin")
    names = ("front", "front_film", "rear", "rear_film")
    small = [(f"participants.{name}.build.grid", [12, 10]) for name in names]
    offset = [(f"participants.{name}.parameters.crank_offset", "1 mm") for name in names[::2]]
    tree = read_tree(path, [*small, *offset, ("time.stop", "20 deg")])
    return tree | {"record": {}, "summary": {}, "monitor": {}, "pictures": []}, path


def two_films():
    """Two bands of one skirt, rows between them without a film."""
    return several_films((12, 12), "20 deg", [(1, 5), (7, 12)]), DATA_SHEET


@pytest.mark.parametrize("make", [twin, two_films])
def test_cases_of_more_than_one_film_run_as_in_python(make, tmp_path, finished):
    """The same steps and linearisations; curves as those of one film are."""
    tree, path = make()
    native = ended(tree | {"native": True}, path, tmp_path / "native.h5")
    python = ended(tree | {"native": False}, path, tmp_path / "python.h5")
    assert native[0]["unconverged_steps"] == 0
    assert {name: native[0][name] for name in COUNTS} == {name: python[0][name] for name in COUNTS}
    assert native[1].keys() == python[1].keys() and len(python[1]) > 60
    for name in native[1]:
        if name.endswith(ROUND_OFF_BY_ITSELF):
            continue
        a, b = native[1][name], python[1][name]
        size = max(np.ptp(b), np.abs(b).max())
        assert np.abs(a - b).max() <= AGREES * size, name


def test_what_is_not_covered_is_said_with_all_that_is_wrong():
    case, _ = case_of(
        ("native", ["bodies", "ehd", "piston"]),
        ("participants.ehd.build.grid", [193, 10]),
        ("participants.bodies.build.grid", [193, 10]),
        ("participants.bodies.build.motion_in_space", {}),
        ("participants.bodies.build.block.bore_from_outside", {}),
        ("participants.bodies.build.floating_pin.pin_shapes", 5),
    )
    faults = faults_ahead(case, PATH.parent)
    assert any("unknown participant 'piston'" in f for f in faults)
    assert any("participants.ehd.build.grid: expected at most 192" in fault for fault in faults)
    for name in ("motion_in_space", "block.bore_from_outside", "floating_pin.pin_shapes"):
        assert any(f"participants.bodies.build.{name}: expected" in fault for fault in faults)


def test_a_stroke_without_room_is_said_before_anything_is_built():
    stroke = ("participants.ehd.parameters.stroke", "0.5 m")
    case, _ = case_of(("native", True), stroke, ("participants.ehd.parameters.oil_supply", "bore"))
    with pytest.raises(
        BadInput, match="participants.ehd.parameters.stroke: expected at most .*, got 0.5 m"
    ):
        open_system(case, PATH.parent, print)
    plenty, _ = case_of(("native", True), stroke)
    assert not faults_ahead(plenty, PATH.parent)


def test_without_a_word_a_library_made_ahead_is_taken(tmp_path, monkeypatch):
    monkeypatch.setattr(builder_native, "AHEAD", tmp_path)
    assert chosen() == set()
    platform = this_platform()
    for package in ("fmu_ehd", "fmu_mfbd"):
        (tmp_path / library_name((package,), platform, "2.0")).touch()
    assert chosen() == {"bodies", "ehd"}
    assert chosen(("native", False)) == set()
    assert chosen(("participants.bodies.build.speed", SPEED)) == {"bodies", "ehd"}
    assert chosen(("participants.bodies.build.motion_in_space", {})) == {"ehd"}
    wide = [(f"participants.{name}.build.grid", [193, 8]) for name in ("bodies", "ehd")]
    assert chosen(*wide) == {"bodies"}


def chosen(*changes):
    case, _ = case_of(*changes)
    return native_choice(case, PATH.parent, {})[0]
