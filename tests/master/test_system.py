"""Wiring faults are found before the run, all of them, in words a user can act on."""

from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.case.contract import starting_order
from piston_cosim.master.case.schema import WireTable
from piston_cosim.master.case.values import parameter_values
from piston_cosim.master.case.wires import wire_of
from piston_cosim.master.fmi.errors import BadInput

from .toys import variable

SEQUENTIAL = SimpleNamespace(order=["film", "body"], parallel=False)


@pytest.fixture
def participants():
    def participant(name, *fields):
        return SimpleNamespace(name=name, fields={f.name: f for f in fields}, declares_units=True)

    gap = {"shape": (4, 4), "unit": "m", "nominal": 1e-5}
    speed = variable("speed", "parameter", unit="rad/s", maximum=100.0)
    return {
        "body": participant("body", variable("film_thickness", "output", **gap), speed),
        "film": participant(
            "film",
            variable("film_thickness", "input", **gap),
            variable("coarse", "input", **gap | {"shape": (2, 4)}),
            variable("other", "input", **gap | {"unit": "Pa"}),
        ),
    }


def wired(participants, coupling=SEQUENTIAL, target="film.film_thickness", **given):
    """Return the wire from the body's film thickness, and its faults."""
    faults = []
    table = WireTable(**{"from": "body.film_thickness", "to": target}, **given)
    return wire_of(table, participants, coupling, faults), faults


@pytest.mark.parametrize(
    "target, words",
    [
        ("film.coarse", "coarse: expected equal shapes, got (4, 4)"),
        ("film.other", "other: expected units of one kind, got m"),
        ("film.film_thicknes", "film_thicknes: expected one of"),
        ("body.film_thickness", "film_thickness: expected nothing, because there is no input, got"),
    ],
)
def test_wiring_faults(participants, target, words):
    _, faults = wired(participants, target=target)
    assert len(faults) == 1
    assert words in faults[0]


def test_tolerances_in_the_field_s_unit_or_of_its_nominal(participants):
    for given, tolerance in (("1 nm", 1e-9), (1e-3, 1e-8)):
        wire, _ = wired(participants, tolerance=given)
        assert wire.tolerance == pytest.approx(tolerance, rel=1e-14)


@pytest.mark.parametrize(
    "order, parallel, tolerance",
    [
        (["film", "body"], False, 1e-11),  # against the order: 1e-6 nominals of 1e-5 m
        (["body", "film"], False, np.inf),  # along it: handed over as it is, not measured
        (["body", "film"], True, 1e-11),
    ],
)
def test_wires_along_the_order_are_measured_only_if_asked(participants, order, parallel, tolerance):
    coupling = SimpleNamespace(order=order, parallel=parallel)
    wire, _ = wired(participants, coupling)
    assert wire.tolerance == pytest.approx(tolerance, rel=1e-14)
    wire, _ = wired(participants, coupling, tolerance="2 nm")
    assert wire.tolerance == pytest.approx(2e-9, rel=1e-14)
    wire, _ = wired(participants, coupling, relative_tolerance=1e-3)
    assert (wire.tolerance, wire.relative_tolerance) == (0.0, 1e-3)


def test_parameter_faults_name_value_unit_and_range(participants):
    faults = []
    values = parameter_values(
        participants["body"],
        {"speed": "6000 rpm", "sped": "1 rad/s", "film_thickness": "1 m"},
        faults,
    )
    assert values == {}
    assert len(faults) == 3
    assert "speed: expected -inf to 100 rad/s, got 6000" in faults[0]
    assert "sped: expected speed, got unknown parameter" in faults[1]


@pytest.mark.parametrize(
    "tolerance, words",
    [
        *((one, "tolerance: expected a positive value, got") for one in (0.0, -1e-3, "-1 nm")),
        ("1 Pa", "tolerance: expected"),
    ],
)
def test_a_tolerance_that_nothing_can_meet_is_a_fault(participants, tolerance, words):
    _, faults = wired(participants, tolerance=tolerance)
    assert words in faults[0]


def fed(*ends):
    """Wires of (source, target)."""
    return [SimpleNamespace(source=source, target=target) for source, target in ends]


def test_films_start_after_what_gives_them_their_gap_and_others_as_the_case_names_them():
    gap = "film_thickness"
    wires = fed(
        (("body", f"upper.{gap}"), ("upper", gap)),
        (("body", f"lower.{gap}"), ("lower", gap)),
        (("upper", "nodal_pressure_force"), ("body", "upper.nodal_pressure_force")),
        (("table", "speed"), ("body", "crank_speed")),
    )
    names = ["upper", "probe", "body", "lower", "table"]
    assert starting_order(names, wires) == ["probe", "body", "upper", "lower", "table"]
    named_well = ["body", "upper", "table", "lower", "probe"]
    assert starting_order(named_well, wires) == named_well


def test_films_that_wait_for_one_another_are_refused():
    gap = "film_thickness"
    with pytest.raises(BadInput, match="wires: expected a participant that can"):
        starting_order(
            ["one", "two"],
            fed((("one", gap), ("two", gap)), (("two", f"land.{gap}"), ("one", gap))),
        )
