"""`run` with native participants takes the same steps as with those in Python.

The master is the same. It rejects in advance what machine code does not support.
"""

import importlib

import numpy as np
import pytest

from piston_cosim.master.api.fmus import build_fmu as build_of_case
from piston_cosim.master.case import export as exporting
from piston_cosim.master.case.ahead import faults_ahead
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.machine_code import native_choice
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.engine.measures import measures
from piston_cosim.master.engine.verdicts import verdicts
from piston_cosim.master.fmi import builder_native
from piston_cosim.master.fmi.builder_native import build_native_fmu, library_name
from piston_cosim.master.fmi.compiler import this_platform
from piston_cosim.master.fmi.errors import BadInput

from .films import PATH as DATA_SHEET
from .films import several_films
from .runs import EXAMPLE, needs_compiler, run_tree, small_tree, tight

COUNTS = ("steps", "residual_evaluations", "jacobian_evaluations")
ROUND_OFF_BY_ITSELF = ("interface_work_error", "mass_imbalance", "block.power_error")
"""The last one of the rigid block of the twin, 1e-17 J."""
AGREES = 1e-6
"""Of each curve's range. Where in the wires' tolerance an iteration ends follows the last digits of
the bodies' products, so the tolerance is a hundredth of the case's or less.
"""
PRODUCTS, RESIDUAL = "coupling.derivative_products", "coupling.residual"
"""A Krylov space ends some products earlier or later where its goal is near their round-off, and
leaves another residual. This follows the last digits, and they depend on numpy's BLAS. With the
kernels for Haswell all steps are equal. With others the sums differ by 1 %.
"""


def hard():
    """Flexible, beside the axis, little oil, surfaces that touch; no parts of slaps.

    Parts amplify differences by their factor of length, see `test_native_coupled`.
    """
    tree = small_tree(
        ("participants.bodies.parameters.impact_resolution", "1 m"),
        ("time.stop", "30 deg"),
        ("participants.bodies.parameters.crank_offset", "1 mm"),
        ("participants.ehd.parameters.film_fraction_lower_edge", 0.6),
        ("participants.ehd.parameters.roughness_rms", "1.5 um"),
        ("wires.0.tolerance", "0.001 nm"),
        ("wires.1.tolerance", 1e-9),
        modes=4,
    )
    return tree, EXAMPLE


def twin():
    """Two cylinders on a mounted block, whose file stays in Python; small grids, no parts."""
    path = find_case("twin")
    names = ("front", "front_film", "rear", "rear_film")
    small = [(f"participants.{name}.build.grid", [12, 10]) for name in names]
    values = ("crank_offset", "1 mm"), ("impact_resolution", "1 m")
    beside = [(f"participants.{n}.parameters.{key}", v) for n in names[::2] for key, v in values]
    tree = read_tree(path, [*small, *beside, ("time.stop", "20 deg")])
    tree = tight(tree, "0.01 nm")
    return tree | {"record": {}, "summary": {}, "monitor": {}, "pictures": []}, path


def two_films():
    """Two bands of one skirt, rows between them without a film."""
    return several_films((12, 12), "20 deg", [(1, 5), (7, 12)]), DATA_SHEET


@pytest.mark.parametrize("make, scalars", [(hard, 30), (twin, 60), (two_films, 60)])
def test_a_run_takes_as_many_evaluations_and_its_curves_agree(make, scalars, tmp_path):
    needs_compiler()
    tree, path = make()
    coupling = tree["coupling"]
    on_wires = coupling | {"advanced": coupling.get("advanced", {}) | {"coordinates": False}}
    tree = tree | {"coupling": on_wires}
    native, python = (
        run_tree(path, tree | {"native": native}, tmp_path / f"{native}.h5")
        for native in (True, False)
    )
    assert native.summary["unconverged_steps"] == 0
    assert {name: native.summary[name] for name in COUNTS} == {
        name: python.summary[name] for name in COUNTS
    }
    curves, other = (one.structured() for one in (python, native))
    names = curves.dtype.names
    assert other.dtype.names == names and len(names) > scalars
    for name in names:
        a, b = other[name], curves[name]
        if name == PRODUCTS:
            assert a.sum() == pytest.approx(b.sum(), rel=0.03)
        elif name == RESIDUAL:
            assert max(a.max(), b.max()) <= 1.0
        elif not name.endswith(ROUND_OFF_BY_ITSELF):
            size = max(np.ptp(b), np.abs(b).max())
            assert np.abs(a - b).max() <= AGREES * size, name


def rigid(folder, coordinates, *changes):
    """Return the results of the rigid example in machine code, and its case."""
    still = [(f"participants.bodies.build.{body}.modes", 0) for body in ("piston", "block")]
    chosen = ("native", True), ("coupling.advanced.coordinates", coordinates)
    tree = read_tree(EXAMPLE, [*still, *chosen, *changes])
    return run_tree(EXAMPLE, tree, folder / f"{coordinates}.h5"), check_case(tree, EXAMPLE)


def test_a_settled_run_in_coordinates_passes_its_checks_as_on_wires(tmp_path):
    """Coordinates extrapolated from guesses drift: they accepted 16 and created 10 % energy.

    Both accept a few guesses at the start, and create 0.2 % in an impact. This energy differs by a
    third between iterations that differ by round-off.
    """
    needs_compiler()
    (one, case), (other, _) = (rigid(tmp_path, coordinates) for coordinates in (True, False))
    judged = verdicts(one, measures(case, one))
    assert [(check.what, check.text) for check in judged if check.outcome != "pass"] == []
    ours, theirs = one.summary, other.summary
    assert ours["periods"] == theirs["periods"]
    assert ours["residual_evaluations"] <= 1.02 * theirs["residual_evaluations"]
    assert ours["energy_created_share_max"] <= 2.0 * theirs["energy_created_share_max"]
    assert (one.series("coupling.iterations").values == 1).sum() <= 4


@pytest.mark.parametrize("coordinates", [True, False])
def test_short_steps_create_no_energy(coordinates, tmp_path):
    """A step corrects what accepted guesses have left, and the film is squeezed faster in it.

    With all guesses within the tolerance, the run on wires created 13 % energy, and 33 MPa instead
    of 4.4 MPa. With those within a tenth of it, it creates 0.2 %.
    """
    needs_compiler()
    grids = [(f"participants.{name}.build.grid", [12, 10]) for name in ("bodies", "ehd")]
    fine = ("time.step", "0.1 deg"), ("time.until_periodic", 1e-9), ("time.stop", "90 deg")
    results, _ = rigid(tmp_path, coordinates, *grids, *fine)
    assert results.summary["energy_created_share_max"] < 0.01
    assert results.summary["maximum_pressure_pa"] < 4.6e6


def test_participants_are_machine_code_where_the_case_says_so():
    needs_compiler()
    for native in (True, False):
        case = check_case(small_tree(("native", native)), EXAMPLE)
        participants = open_system(case, EXAMPLE.parent, print).participants.values()
        assert [("-native-" in one.path.name) for one in participants] == [native, native]


BODIES = {"motion_in_space": {}, "block.bore_from_outside": {}}
OF_BODIES = [
    "motion_in_space: expected nothing in a native FMU, got",
    "block.bore_from_outside: expected nothing in a native FMU, got",
]
CHANGES = [(f"participants.bodies.build.{name}", value) for name, value in BODIES.items()]
WIDE = [(f"participants.{name}.build.grid", [193, 10]) for name in ("bodies", "ehd")]


def rejected(make, *arguments, **named):
    with pytest.raises(BadInput) as refusal:
        make(*arguments, **named)
    return str(refusal.value)


def test_what_is_not_covered_is_rejected_before_anything_is_made(monkeypatch):
    """A build of one participant, an export and a run reject it with its position in the case.

    The mask of a film comes from the mesh of its body.
    """
    bodies = importlib.import_module("piston_cosim.fmu_mfbd.build")
    monkeypatch.setattr(bodies, "prepare", lambda *_: pytest.fail("a body was reduced"))
    monkeypatch.setattr(exporting, "open_system", lambda *_: pytest.fail("a system was opened"))
    for words, option in zip(OF_BODIES, BODIES.items()):
        head, _, last = option[0].partition(".")
        options = {head: {last: option[1]} if last else option[1]}
        build = dict(options=options, platforms=["linux64"])
        assert words in rejected(build_of_case, "numerical_example", "bodies", **build)
    for grid, platform, words in (
        ([193, 8], "linux64", "grid: expected at most 192"),
        ([8, 8], "beos", "platform: expected one of linux64"),
    ):
        build = dict(options={"grid": grid}, platforms=[platform])
        assert words in rejected(build_of_case, "numerical_example", "ehd", **build)
        film = ("fmu_ehd", {"grid": grid}, EXAMPLE.parent)
        assert words in rejected(build_native_fmu, *film, platforms=[platform])
    of_coupling = [
        ("coupling.method", "iqn_ils"),
        ("coupling.advanced.differences", True),
        ("wires.0.relative_tolerance", 1e-3),
    ]
    case = check_case(small_tree(*CHANGES, *of_coupling), EXAMPLE)
    said = rejected(export_fmu, case, EXAMPLE.parent, print, "2.0", ["linux64", "beos"])
    for words in (
        "platform: expected one of linux64",
        "coupling.method: expected newton in a native FMU",
        "coupling.advanced.differences: expected false in a native FMU",
        "relative_tolerance: expected 0 in a native FMU, got 0.001",
        *(f"participants.bodies.build.{words}" for words in OF_BODIES),
    ):
        assert words in said
    run = check_case(small_tree(*CHANGES, *WIDE, ("native", ["bodies", "ehd", "piston"])), EXAMPLE)
    faults = "\n".join(faults_ahead(run, EXAMPLE.parent))
    for words in (
        "unknown participant 'piston'",
        "participants.ehd.build.grid: expected at most 192",
        *(f"participants.bodies.build.{words}" for words in OF_BODIES),
    ):
        assert words in faults


def test_a_stroke_without_room_is_said_before_anything_is_compiled(monkeypatch):
    monkeypatch.setattr(exporting, "pack_native_fmu", lambda *_, **__: pytest.fail("compiled"))
    parameters = "participants.ehd.parameters"
    stroke, supply = (f"{parameters}.stroke", "0.3 m"), (f"{parameters}.oil_supply", "bore")
    case = check_case(small_tree(("native", True), stroke, supply), EXAMPLE)
    for said in (
        rejected(open_system, case, EXAMPLE.parent, print),
        rejected(export_fmu, case, EXAMPLE.parent, print, "2.0", ["linux64"]),
    ):
        assert "ehd.parameters.stroke: expected at most 0.162 m" in said and "got 0.3 m" in said
    plenty = check_case(small_tree(("native", True), stroke), EXAMPLE)
    assert not faults_ahead(plenty, EXAMPLE.parent)


SPEED = {"points": [[0.0, 6000.0], [360.0, 6000.0]], "angle_unit": "deg", "speed_unit": "rpm"}
"""A table of crank speed over angle."""


def test_without_a_word_a_library_made_ahead_is_taken(tmp_path, monkeypatch):
    monkeypatch.setattr(builder_native, "PREBUILT", tmp_path)
    assert chosen() == set()
    platform = this_platform()
    for package in ("fmu_ehd", "fmu_mfbd"):
        (tmp_path / library_name((package,), platform, "2.0")).touch()
    assert chosen() == {"bodies", "ehd"}
    assert chosen(("native", False)) == set()
    assert chosen(("participants.bodies.build.speed", SPEED)) == {"bodies", "ehd"}
    assert chosen(("participants.bodies.build.motion_in_space", {})) == {"ehd"}
    assert chosen(*WIDE) == {"bodies"}


def chosen(*changes):
    return native_choice(check_case(small_tree(*changes), EXAMPLE), EXAMPLE.parent, {})[0]
