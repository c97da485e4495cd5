"""Case files: every fault at once, units at the edge, variants and changes by dotted key."""

from types import SimpleNamespace

import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.given import masks
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.case.times import times
from piston_cosim.master.commands.common import parse_change, parse_grid, variant_trees
from piston_cosim.master.fmi.errors import BadInput

GOOD = """
title = "two"
[time]
stop = "720 deg"
step = "1 deg"
angular_speed = "a.speed"
[participants.a]
fmu = "a.fmu"
parameters = { speed = "3000 rpm" }
[participants.b]
fmu = "b.fmu"
[[wires]]
from = "a.y"
to = "b.u"
tolerance = "1 nm"
[coupling]
order = ["a", "b"]
[variants.slow]
"participants.a.parameters.speed" = "300 rpm"
"""


@pytest.fixture
def case_file(tmp_path):
    def write(text):
        path = tmp_path / "case.toml"
        path.write_text(text)
        return path

    return write


def faults_of(path):
    with pytest.raises(BadInput) as caught:
        check_case(read_tree(path), path)
    return caught.value.faults


def test_unknown_participant_is_named(case_file):
    assert (
        "participants: expected one of a, b, got"
        in faults_of(case_file(GOOD.replace('to = "b.u"', 'to = "c.u"')))[0]
    )


def test_broken_toml_says_where(case_file):
    with pytest.raises(BadInput, match="line 2"):
        read_tree(case_file("title = 1\nstop = = 3"))


CRANK = {
    "title": "A crank",
    "time": {"stop": "720 deg", "step": "1 deg", "angular_speed": "bodies.crank_speed"},
    "wires": [],
    "coupling": {"order": ["bodies", "ehd"]},
}


@pytest.mark.parametrize(
    "build, time, period",
    [
        ({}, {}, "360 deg"),
        ({"gas": {"file": "gas.csv"}}, {}, "720 deg"),
        ({"gas": {"file": "gas.csv", "strokes": 2}}, {}, "360 deg"),
        ({"speed": {"file": "speed.csv"}}, {}, "720 deg"),
        ({"gas": {"file": "gas.csv"}}, {"period": "1440 deg"}, "1440 deg"),
        ({}, {"angular_speed": None}, None),
    ],
)
def test_the_period_is_that_of_the_machine(build, time, period):
    parts = {name: {"fmu": f"{name}.fmu", "build": build} for name in ("bodies", "ehd")}
    case = check_case(CRANK | {"time": CRANK["time"] | time, "participants": parts}, "case.toml")
    assert case.period == period


@pytest.mark.parametrize(
    "time, fault",
    [
        (
            {"step": "7 deg"},
            r"period: expected a multiple of time\.step =",
        ),
        ({"angular_speed": None, "step": "1 s"}, "period: expected a time with"),
        ({"period": "-1 deg"}, "period: expected a positive value, got '-1"),
    ],
)
def test_a_period_that_cannot_be_is_refused(time, fault):
    given = {**CRANK["time"], "until_periodic": 1e-3, "stop": None, **time}
    parts = {name: {"fmu": f"{name}.fmu"} for name in ("bodies", "ehd")}
    case = check_case(CRANK | {"time": given, "participants": parts}, "")
    with pytest.raises(BadInput, match=fault):
        times(case, 1.0 if case.time.angular_speed else None)


def test_variants_are_changed_cases(case_file):
    path = case_file(GOOD.replace("[time]", 'beside = ["slow"]\n[time]', 1))
    trees = variant_trees(path, [("time.step", "2 deg")], None)
    assert list(trees) == ["base", "slow"]
    assert trees["slow"]["participants"]["a"]["parameters"]["speed"] == "300 rpm"
    assert trees["base"]["participants"]["a"]["parameters"]["speed"] == "3000 rpm"
    assert trees["slow"]["time"]["step"] == "2 deg"


def test_a_change_wins_over_a_variant_and_says_so(case_file):
    path = case_file(GOOD)
    said = []
    set_ = [("speed", "900 rpm"), ("time.step", "2 deg")]
    trees = variant_trees(path, set_, "slow", said.append)
    assert trees["slow"]["participants"]["a"]["parameters"]["speed"] == "900 rpm"
    key = "participants.a.parameters.speed"
    assert said == [f"slow: {key} = '900 rpm' replaces the variant's value '300 rpm'"]


def test_a_variant_runs_on_demand_alone(case_file):
    path = case_file(GOOD)
    assert list(variant_trees(path, [], None)) == ["base"]
    assert list(variant_trees(path, [], "slow")) == ["slow"]
    wrong = GOOD.replace("[time]", 'beside = ["fast"]\n[time]', 1)
    assert "beside: expected slow, got unknown variant" in faults_of(case_file(wrong))[0]


def test_command_line_values():
    assert parse_change("a.b=3") == ("a.b", 3)
    assert parse_change("a.b='12 mPa s'") == ("a.b", "12 mPa s")
    assert parse_change("a.b=12 mPa s") == ("a.b", "12 mPa s")
    assert parse_grid("60x30") == [60, 30]
    with pytest.raises(BadInput):
        parse_grid("60")


def test_a_picture_lacks_what_its_kind_needs(case_file):
    path = case_file(
        GOOD + '[[pictures]]\nfile = "a.png"\ntitle = "A"\nkind = "section"\nfields = ["a.h"]\n'
    )
    with pytest.raises(BadInput, match="0: expected time in a picture of kind"):
        check_case(read_tree(path), path)


def test_a_picture_shows_the_coupling_over_time(case_file):
    """Only outputs of participants are looked up in the FMUs."""
    lines = '[[pictures]]\nfile = "a.png"\ntitle = "A"\nkind = "lines"\nx = "time"\n'
    path = case_file(GOOD + lines + 'y = [["coupling.iterations", "a.y"]]\n')
    (picture,) = check_case(read_tree(path), path).pictures
    assert picture.outputs == ["a.y"]
    with pytest.raises(BadInput, match="pictures.0.x"):
        check_case(read_tree(case_file(GOOD + lines.replace('"time"', '"tim"'))), path)


@pytest.mark.parametrize(
    "given, lower, ends, title",
    [
        ('length_of_it = "40 mm"', "0 mm", (0.0, 20.0), "height [mm]"),
        ('length_of_it = "40 mm"', "-1 cm", (-10.0, 10.0), "height [mm]"),
        ('length_of_it = "40 mm"', "b.build.edge.low", (-7.0, 13.0), "height [mm]"),
        ("", "0 mm", (0.0, 0.5), "height / length of it"),
        ('length_of_it = "40 s"', "0 mm", (0.0, 0.5), "height / length of it"),
    ],
)
def test_an_axis_in_shares_of_a_length(case_file, given, lower, ends, title):
    """A length that is missing or none leaves shares: its fault is told where it is checked."""
    axes = (
        '[participants.b.parameters]\n{}\n[[axes]]\nparticipants = ["b"]\n'
        'second = {{ label = "height", unit = "mm", range = [0, 0.5], length = "b.length_of_it", '
        'lower = "{}" }}\n[participants.b.build]\nedge = {{ low = "-7 mm" }}\n'
    )
    text = axes.format(given, lower)
    path = case_file(GOOD.replace("[variants.slow]", f"{text}\n[variants.slow]"))
    second = check_case(read_tree(path), path).axes_of("b.y").second
    assert second.range == pytest.approx(ends) and second.title == title


def test_masks_of_what_the_contract_gives_one(tmp_path):
    """Rows as they are or from a file; none of a participant without the role or without any."""
    (tmp_path / "skirt.csv").write_text("1,0\n1,1\n")
    roles = {"a": "lubrication", "b": "lubrication", "c": "lubrication", "d": None, "e": "bodies"}
    given = {"a": [[1, 0]], "b": "skirt.csv", "c": "none", "d": [[0, 0]], "e": [[0, 0]]}
    case = SimpleNamespace(
        participants={name: SimpleNamespace(role=role) for name, role in roles.items()}
    )
    found = masks(case, {name: {"mask": mask} for name, mask in given.items()}, tmp_path)
    assert found == {"a": [[1, 0]], "b": [[1, 0], [1, 1]]}
    assert masks(case, {"a": {}}, tmp_path) == {}
