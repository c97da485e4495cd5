"""Oil temperature of a film from the walls of its body: its wire, and contradictions in `check`."""

from copy import deepcopy

import pytest

from piston_cosim.master.case.ahead import ahead
from piston_cosim.master.case.check import check
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.fmi.errors import BadInput

WALLS = {"skirt": ["110 degC", "150 degC"], "bore": ["100 degC", "140 degC"]}
TEMPERATURES = "participants.bodies.build.temperatures"
WIRE = ("bodies.oil_temperature", "ehd.oil_temperature")


def case_with(*changes, name="data_sheet"):
    """Return a shipped case with changes, checked."""
    path = find_case(name)
    return check_case(read_tree(path, changes), path), path.parent


def ends(case):
    return [(wire.source, wire.target) for wire in case.wires]


def test_given_temperatures_add_the_wire_and_the_input_of_the_film():
    case, folder = case_with((TEMPERATURES, WALLS))
    (wire,) = [one for one in case.wires if one.target == WIRE[1]]
    assert (wire.source, wire.tolerance) == (WIRE[0], "0.01 K")
    assert case.participants["ehd"].build["inputs"] == ["oil_temperature"]
    assert ahead(case, folder).faults == []


def test_without_temperatures_there_is_no_wire():
    case, _ = case_with()
    assert WIRE not in ends(case) and "inputs" not in case.participants["ehd"].build


@pytest.mark.parametrize("key", ["oil_temperature_lower_edge", "oil_temperature_upper_edge"])
def test_a_temperature_of_the_film_replaces_the_wire(key):
    case, _ = case_with((TEMPERATURES, WALLS), (f"participants.ehd.parameters.{key}", "90 degC"))
    assert WIRE not in ends(case)


def test_a_wire_of_the_case_replaces_that_of_the_walls(tmp_path):
    path = find_case("data_sheet")
    (tmp_path / "t.csv").write_text("time [s], t [K]\n0, 350\n1, 350\n")
    tree = deepcopy(read_tree(path, [(TEMPERATURES, WALLS)]))
    tree["participants"]["heat"] = {"table": str(tmp_path / "t.csv")}
    tree["participants"]["ehd"]["build"]["inputs"] = ["oil_temperature"]
    tree["coupling"]["order"] = ["heat", *tree["coupling"]["order"]]
    tree["wires"].append({"from": "heat.t", "to": "ehd.oil_temperature[1,1]"})
    assert WIRE not in ends(check_case(tree, path))


def test_every_film_of_a_skirt_has_its_own_wire():
    """The films of pin and crank have none."""
    case, _ = case_with((TEMPERATURES, WALLS), name="grooved_skirt")
    films = [name for name, one in case.participants.items() if one.role == "lubrication"]
    targets = [target for source, target in ends(case) if "oil_temperature" in source]
    assert len(films) > 1 and targets == [f"{name}.oil_temperature" for name in films]
    case, _ = case_with((TEMPERATURES, WALLS), name="floating_pin")
    found = [pair for pair in ends(case) if "oil_temperature" in pair[0]]
    assert found == [("bodies.skirt.oil_temperature", "skirt_film.oil_temperature")]


def test_check_prints_temperatures_and_the_hot_clearance():
    """Free growth by hand: 20e-6/K at 120 K and the bore 11e-6/K at 100 K, even temperatures."""
    even = {"skirt": "413.15 K", "bore": "393.15 K"}
    found = check("data_sheet", [(TEMPERATURES, even), ("radial_clearance", "120 um")])
    assert found.faults == []
    value = {
        name: found.figure(f"bodies.{name}").value
        for name in ("clearance_cold", "clearance_hot", "skirt_radius", "bore_radius")
    }
    grown = 20e-6 * value["skirt_radius"] * 120.0 - 11e-6 * value["bore_radius"] * 100.0
    change = value["clearance_cold"] - value["clearance_hot"]
    assert change == pytest.approx(grown, rel=1e-9)
    assert found.figure("bodies.oil_temperature_lower_edge").value == pytest.approx(403.15)


def test_check_of_a_variant_has_the_hot_clearance_of_its_tables():
    """The tables of temperature take half of the clearance of the shipped engine."""
    found = check("fired_motorcycle", variant="hot")
    cold, hot = (found.figure(f"bodies.clearance_{one}").value for one in ("cold", "hot"))
    assert found.faults == [] and cold == pytest.approx(12.0e-6, abs=0.1e-6)
    assert hot == pytest.approx(5.9e-6, abs=0.1e-6)
    with pytest.raises(BadInput, match="--only: expected one of flexible"):
        check("fired_motorcycle", variant="warm")


def test_check_prints_where_values_contradict():
    """The oil of the film, and a growth that replaces that of the temperatures."""
    found = check(
        "data_sheet",
        [
            (TEMPERATURES, {"skirt": "413.15 K", "bore": "393.15 K"}),
            ("participants.ehd.parameters.oil_temperature_lower_edge", "363.15 K"),
            ("participants.bodies.parameters.skirt_growth_upper", "30 um"),
        ],
    )
    lines = [line for line in found.warnings if "give 403.1 K, -40 K" in line]
    assert lines and "ehd.parameters.oil_temperature_lower_edge = 363.1 K" in lines[0]
    (line,) = [line for line in found.warnings if "skirt_growth_lower" in line]
    assert "skirt_growth_upper = 30 \N{MICRO SIGN}m: replace the free growth" in line


def test_check_prints_the_temperatures_of_the_edges():
    """Not those of the first and last row of cells, which are inside."""
    edges = {"skirt": ["388.15 K", "413.15 K"], "bore": "393.15 K"}
    found = check("data_sheet", [(TEMPERATURES, edges), ("radial_clearance", "150 um")])
    for edge, skirt in (("lower", 388.15), ("upper", 413.15)):
        value = found.figure(f"bodies.skirt_temperature_{edge}_edge").value
        assert value == pytest.approx(skirt, rel=1e-12)
        value = found.figure(f"bodies.oil_temperature_{edge}_edge").value
        assert value == pytest.approx((skirt + 393.15) / 2, rel=1e-12)


def test_check_warns_of_a_temperature_field_without_a_value():
    """Its start value is the reference temperature, 20 degC."""
    changes = [(TEMPERATURES, {"skirt": "input", "bore": "390 K"})]
    text = "bodies.skirt_temperature_field: expected a wire or a value in parameters, got neither"
    assert [one for one in check("data_sheet", changes).warnings if text in one]
    changes.append(("participants.bodies.parameters.skirt_temperature_field", "400 K"))
    assert not [one for one in check("data_sheet", changes).warnings if text in one]


@pytest.mark.parametrize("key", ["piston_temperature", "skirt_temperature_rise"])
def test_a_temperature_that_is_given_twice_is_a_fault(key):
    twice = f"participants.bodies.parameters.{key}", "250 K"
    found = check("data_sheet", [(TEMPERATURES, WALLS), twice])
    text = f"parameters.{key}: expected nothing with build.temperatures.skirt, got 250 K"
    assert any(text in line for line in found.faults), found.faults
