"""No key that has a unit accepts a bare number, in a case, in a table or in Python.

A number without its unit has several readings: "-360" is -360 deg for its author and -360 rad in
SI. pint counts an angle as no dimension, so that it must be compared separately.
"""

from math import pi

import pytest

from piston_cosim.fmu_ehd import user_input
from piston_cosim.fmu_ehd.variables import CONDITION_VARIABLES, OIL_VARIABLES
from piston_cosim.master.case.ahead import ahead
from piston_cosim.master.case.check import check
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.keys import case_keys, part_function
from piston_cosim.master.case.reading import case_names, find_case, read_tree
from piston_cosim.master.case.values import parameter_values, value_of
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.fmi.fields import Field, UnitDefinition
from piston_cosim.master.fmi.option_classes import ANY, EACH
from piston_cosim.master.fmi.quantities import from_si, to_si
from piston_cosim.master.participants.table import read_table

BARE = ("1", 1, 1.0, "0", ["1", "1"], ["1", "1", "1"])
"""Numbers without a unit, also for keys that are a list."""


def faults_of(function, *arguments):
    """Return the faults that a function raises."""
    try:
        function(*arguments)
    except BadInput as error:
        return error.faults
    return []


def packages():
    """Return a case and a participant of each package of the shipped cases."""
    places = {}
    for name in case_names():
        for owner, table in read_tree(find_case(name))["participants"].items():
            places.setdefault(table.get("package"), (name, owner))
    return {package: place for package, place in places.items() if package}


@pytest.mark.parametrize("package, place", packages().items())
def test_no_option_or_parameter_with_a_unit_is_a_bare_number(package, place):
    path, owner = find_case(place[0]), place[1]
    tree = read_tree(path)
    before = f"participants.{owner}."
    paths = [key.path.removeprefix(before) for key in case_keys(tree, path.parent) if key.unit]
    names = [one.removeprefix("parameters.") for one in paths if one.startswith("parameters.")]
    options = [one.removeprefix("build.") for one in paths if one.startswith("build.")]
    participant = ahead(check_case(tree, path), path.parent).participants[owner]
    declared = part_function(package, "declared_variables")
    for value in BARE:
        faults = []
        parameter_values(participant, dict.fromkeys(names, value), faults)
        assert len(faults) == len(names)
        for option in options:
            table = value
            for part in reversed(option.split(".")):
                table = [table] if part == EACH else {"x" if part == ANY else part: table}
            name = option.replace(f".{EACH}.", ".0.").replace(f".{ANY}.", ".x.")
            faults = faults_of(declared, table, path.parent)
            assert any(fault.startswith(name) for fault in faults), (option, value, faults)


@pytest.mark.parametrize(
    "key, value",
    [
        *((f"time.{key}", "720") for key in ("start", "stop", "step", "smallest_step", "period")),
        ("record.every", "4"),
        ("wires.0.tolerance", "1"),
        ("wires.0.local_error", "1"),
        ("participants.bodies.timeout", "9"),
        ("participants.bodies.step", "1"),
        ("pictures.1.time", "24"),
        ("pictures.1.angles", ["0", "360"]),
        ("window", {"max ehd.maximum_pressure": ["0", "5 MPa"]}),
        ("pictures.0.units", {"bodies.crank_angle": "Hz"}),
    ],
)
def test_no_time_or_limit_of_a_case_is_a_bare_number(key, value):
    path = find_case("data_sheet")
    assert any(key.split(".")[-1] in fault for fault in check(path, [(key, value)]).faults)


@pytest.mark.parametrize("variable", [*CONDITION_VARIABLES, *OIL_VARIABLES], ids=lambda v: v.name)
def test_no_text_in_python_is_a_bare_number(variable):
    given = {variable.name: "1"}
    faults = faults_of(user_input.read, given, {variable.name: variable}, "parameter")
    assert bool(faults) == (variable.unit != "1" or bool(variable.choices))


def test_no_time_of_a_table_is_a_bare_number(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("time,lift [mm]\n0,1\n1,2\n")
    assert faults_of(read_table, path) == [
        f"{path}: expected 'time [s]' as the first column, got 'time', no unit"
    ]


@pytest.mark.parametrize(
    "text, unit, value",
    [
        ("180 deg", "rad", pi),
        ("60 rpm", "rad/s", 2 * pi),
        ("\N{MINUS SIGN}5 mm", "m", -5e-3),  # pint drops this sign
        ("2 kg mm2", "kg.m2", 2e-6),
        ("3 g/cm3", "kg/m^3", 3e3),
        ("4 1/s", "s-1", 4.0),
        ("5 %", "1", 0.05),
        ("5 delta_degC", "K", 5.0),
        ("4mPas", "Pa.s", 4e-3),  # pint: 4 mPa
        ("20 \N{DEGREE SIGN}C", "K", 293.15),
    ],
)
def test_a_quantity_is_one_number_with_its_unit(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-14)  # round-off of two units


@pytest.mark.parametrize(
    "text, unit, hint",
    [
        ("0,045 mm", "m", "got '0,045 mm'; write for example '0.045 mm'"),  # pint: 0
        ("3 000 rpm", "rad/s", "'3000 rpm'"),  # pint: 0
        ("mm", "m", "'1 mm'"),  # pint: 1 mm
        ("-360", "rad", "'-360 deg'"),
        ("-360 Grad", "rad", "'10 deg'"),  # pint: -360e9 rad
        ("50 Hz", "rad/s", "'3000 rpm'"),  # 50 1/s is not 50 rad/s
        ("3000 1/min", "rad/s", "'3000 rpm'"),
        ("300 rpm", "Hz", "'1 Hz'"),
        ("3 um", "1", "'0.5'"),
        ("2*3 mm", "m", "'1 mm'"),
        ("4 MPas", "Pa", "'1 Pa'"),
        ("50", "%", "'50 %'"),  # a share of 50, or 50 %
        ("0.5", "ppm", "'0.5 ppm'"),
    ],
)
def test_what_is_no_quantity_of_the_unit(text, unit, hint):
    with pytest.raises(ValueError, match=hint):
        to_si(text, unit)


def test_a_shown_unit_has_the_angle_of_the_quantity():
    assert from_si(2 * pi, "rad/s", "rpm") == pytest.approx(60.0, rel=1e-14)
    with pytest.raises(ValueError, match="expected a unit of rad/s, got 'Hz'"):
        from_si(2 * pi, "rad/s", "Hz")


@pytest.mark.parametrize("angle", [(), (("rad", 1),)])
def test_an_fmu_may_omit_the_angle_in_its_base_unit(angle):
    unit = UnitDefinition((*angle, ("s", -1)), pi / 30, 0.0)
    none = (None,) * 4
    field = Field("speed", (), (0,), "Real", "parameter", "rpm", *none, "", definition=unit)
    assert value_of(field, "3000 rpm") == pytest.approx(3000.0, rel=1e-14)
    with pytest.raises(ValueError, match="expected a quantity"):
        value_of(field, "3000")


def test_the_end_of_a_range_is_in_the_range_in_every_unit():
    """100 / 1e9 is one last digit above 1e-7."""
    ends = 1e-10, 1e-7
    field = Field("alpha", (), (0,), "Real", "parameter", "1/Pa", None, *ends, None, "")
    assert to_si("100 1/GPa", "1/Pa") > 1e-7
    assert value_of(field, "100 1/GPa") == 1e-7
    with pytest.raises(ValueError, match="expected 1e-10 to 1e-07 1/Pa, got 100.0001 1/GPa"):
        value_of(field, "100.0001 1/GPa")
