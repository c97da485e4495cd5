"""Every key of a case is found, with short names and suggestions for unknown names.

The keys come from the option classes and from the declarations of the FMUs.
"""

import json
import tomllib

import pytest
from jsonschema import Draft202012Validator

from piston_cosim.master.case.changes import key_parts, whole_key
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.keys import case_keys, chosen_keys, json_schema
from piston_cosim.master.case.reading import case_names, find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.commands.keys import command
from piston_cosim.master.fmi.errors import BadInput

PATH = find_case("numerical_example")
FOLDER = PATH.parent


@pytest.fixture(scope="module")
def found():
    return case_keys(read_tree(PATH), FOLDER)


def test_every_key_has_a_meaning(found):
    assert [key.path for key in found if not key.meaning] == []


def test_keys_of_the_file_of_the_parts_and_of_their_parameters(found):
    known = {key.path: key for key in found}
    assert known["coupling.max_iterations"].default == "20"
    assert known["coupling.max_iterations"].allowed == "1 or more"
    assert known["wires.N.interpolation"].allowed == "held, mean, linear, hermite"
    assert known["time.step"].required and not known["time.start"].required
    density = known["participants.bodies.build.piston.density"]
    assert (density.unit, density.allowed) == ("kg/m^3", "500 to 25000")
    assert known["participants.bodies.build.piston.rigid.centre"].unit == "m"
    clearance = known["participants.bodies.parameters.radial_clearance"]
    assert (clearance.unit, clearance.default) == ("m", "2.5e-05 m")
    assert clearance.allowed == "1e-06 to 0.001"
    speed = known["participants.bodies.parameters.crank_speed"]  # an input with a start value
    assert speed.allowed == "0 to 3000"
    assert known["participants.ehd.parameters.cavitation_model"].allowed.startswith("jfo, ")


def test_schema_takes_the_shipped_cases_and_refuses_a_wrong_key():
    schemas = []
    for name in case_names():
        path = find_case(name)
        schema = json_schema(read_tree(path), path.parent)
        if schema not in schemas:  # several cases have the same
            Draft202012Validator.check_schema(schema)
            schemas.append(schema)
        validator = Draft202012Validator(schema)
        for tree in (read_tree(path), tomllib.loads(path.read_text())):
            tree = json.loads(json.dumps(tree))
            assert [error.message for error in validator.iter_errors(tree)] == []
    tree["coupling"] = {"max_iteration": 3}
    assert any("max_iteration" in error.message for error in validator.iter_errors(tree))
    tree = read_tree(PATH)
    tree["participants"]["bodies"]["parameters"]["radial_clearence"] = "20 um"
    tree["participants"]["bodies"]["build"]["piston"]["mode"] = 20
    messages = [
        error.message
        for error in Draft202012Validator(json_schema(read_tree(PATH), FOLDER)).iter_errors(tree)
    ]
    assert any("radial_clearence" in text for text in messages)
    assert any("'mode'" in text for text in messages)


def test_a_path_chooses_a_table_and_a_word_what_contains_it(found):
    chosen, is_table = chosen_keys(found, "ehd.parameters")
    assert is_table and all("ehd.parameters" in key.path for key in chosen)
    chosen, is_table = chosen_keys(found, "piston.modes")
    assert not is_table and chosen[0].path == "participants.bodies.build.piston.modes"
    chosen, is_table = chosen_keys(found, "clearance")
    assert not is_table and chosen[0].name == "radial_clearance"
    assert all("clearance" in f"{key.path} {key.meaning}".lower() for key in chosen)
    assert "ovality" in {key.name for key in chosen_keys(found, "profile")[0]}  # a synonym


def test_the_command_prints_tables_matches_and_oils(capsys):
    command("piston.rigid")
    printed = capsys.readouterr().out
    assert "participants.bodies.build.piston.rigid" in printed and "kg*m^2" in printed
    command("oil")
    printed = capsys.readouterr().out
    assert "participants.ehd.parameters.viscosity_law" in printed
    assert all(name in printed for name in ("heavy_machine_oil", "sae_5w_30", "SAE J300"))
    command("5W-30")
    printed = capsys.readouterr().out
    assert "sae_5w_30" in printed and "heavy_machine_oil" not in printed
    command(json_schema_=True)
    assert json.loads(capsys.readouterr().out)["title"] == "Case"


def test_the_command_prints_equal_tables_once_and_numerical_settings_on_request(capsys):
    command()
    printed = capsys.readouterr().out
    assert "axes.N.first\naxes.N.second\n" in printed
    assert printed.count("\n centred ") == 1
    few = "halvings", "stations", "amplitude", "chamfer_capacity", "land_height", "timeout"
    assert "\n max_iterations " in printed and "\n grid " in printed
    assert not any(f"\n {name} " in printed for name in few)
    omitted = sum(key.advanced for key in case_keys(read_tree(PATH), FOLDER))
    assert f"keys that few cases need: {omitted} more, see --advanced" in printed
    command(advanced=True)
    printed = capsys.readouterr().out
    assert all(f"\n {name} " in printed for name in few) and "see --advanced" not in printed
    command("coupling.advanced")
    assert "\n halvings " in capsys.readouterr().out
    command("land")
    printed = capsys.readouterr().out
    assert "land_pressure" in printed and "land_height" not in printed
    command("land_height")
    assert "land_height" in capsys.readouterr().out


@pytest.mark.parametrize(
    "short, whole",
    [
        ("radial_clearance", "participants.bodies.parameters.radial_clearance"),
        ("ehd.viscosity", "participants.ehd.parameters.viscosity"),
        ("piston.modes", "participants.bodies.build.piston.modes"),
        ("skirt_growth_upper", "participants.bodies.parameters.skirt_growth_upper"),
        ("max_iterations", "coupling.max_iterations"),
        ("gas.file", "participants.bodies.build.gas.file"),
        ("bodies.isolated", "participants.bodies.isolated"),
        ("every", "record.every"),
        ("time.start", "time.start"),
        ("wires.0.tolerance", "wires.0.tolerance"),
    ],
)
def test_short_names(short, whole):
    assert whole_key(read_tree(PATH), short, FOLDER) == whole


def test_short_names_in_a_file(tmp_path):
    text = PATH.read_text().replace(
        '"participants.bodies.build.piston.modes" = 0', '"piston.modes" = 0', 1
    )
    (tmp_path / "case.toml").write_text(text)
    tree = read_tree(tmp_path / "case.toml")
    changes = list(tree["variants"]["rigid"].items())
    changed = read_tree(tmp_path / "case.toml", changes)
    assert changed["participants"]["bodies"]["build"]["piston"]["modes"] == 0


def test_tables_that_a_case_may_have_are_made(tmp_path):
    text = PATH.read_text()
    begin, end = text.index("[record]"), text.index("[monitor]")
    (tmp_path / "case.toml").write_text(text[:begin] + text[end:])
    assert read_tree(tmp_path / "case.toml", [("record.every", 3)])["record"] == {"every": 3}


@pytest.mark.parametrize(
    "key, message",
    [
        ("participants.bodies.parameters.radial_clearence", "radial_clearence: expected one of"),
        ("participants.bodies.build.piston.mode", "mode: expected one of density,"),
    ],
)
def test_what_is_wrong_shows_before_anything_is_reduced(key, message):
    def never(line):
        raise AssertionError(line)

    with pytest.raises(BadInput, match=message):
        open_system(check_case(read_tree(PATH, [(key, 3)]), PATH), FOLDER, never)


def test_a_short_key_may_be_one_of_a_list_entry(tmp_path):
    """A name that tables and entries of lists share is not unique."""
    build = {"gas": {"file": "gas.csv"}, "piston": {"profiles": [{"file": "a.csv"}]}}
    tree = {"participants": {"bodies": {"build": build}}}
    wanted = ["participants", "bodies", "build", "piston", "profiles", "0", "file"]
    assert key_parts(tree, "profiles.0.file", tmp_path) == wanted
    with pytest.raises(BadInput, match="name of several keys; write .*gas.file or .*profiles.0"):
        key_parts(tree, "file", tmp_path)
