"""Cases that extend others, participants like others, and the wires of films."""

import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.fmi.errors import BadInput

CHILD = """
extends = "../base"
without = ["summary", "participants.a.parameters.x"]
title = "child"

[participants.a.parameters]
y = "2 m"

[[wires]]
to = "a.u"
tolerance = "1 N"

[[wires]]
from = "a.v"
to = "b.w"

[coupling]
order = ["a"]
"""
BASE = """
title = "base"
summary = { s = "max a.z" }

[participants.a]
table = "data.csv"
build = { files = ["data.csv", "none.csv", "model.py:Class"] }
parameters = { x = "1 m", y = "1 m" }

[variants.v]
"participants.a.table" = "data.csv"

[[wires]]
from = "b.t"
to = "a.u"
tolerance = "2 N"
conjugate = "a.p"

[coupling]
order = ["b"]
method = "aitken"
"""


@pytest.fixture
def child(tmp_path):
    for name, text in (("base", BASE), ("child", CHILD)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "case.toml").write_text(text)
    for name in ("data.csv", "model.py"):
        (tmp_path / "base" / name).touch()
    return tmp_path / "child" / "case.toml"


def test_a_case_has_the_tables_of_the_case_that_it_extends(child):
    tree = read_tree(child)
    assert tree["title"] == "child" and "extends" not in tree and "without" not in tree
    assert tree["participants"]["a"]["parameters"] == {"y": "2 m"} and "summary" not in tree
    assert tree["coupling"] == {"order": ["a"], "method": "aitken"}
    assert tree["wires"] == [
        {"from": "b.t", "to": "a.u", "tolerance": "1 N", "conjugate": "a.p"},
        {"from": "a.v", "to": "b.w"},
    ]


def test_files_of_the_extended_case_are_those_of_its_folder(child):
    tree = read_tree(child)
    files = ["../base/data.csv", "none.csv", "../base/model.py:Class"]
    assert tree["participants"]["a"]["build"]["files"] == files
    assert tree["variants"]["v"] == {"participants.a.table": "../base/data.csv"}


@pytest.mark.parametrize(
    "old, new, fault",
    [
        ("../base", "../child", "extends: expected another case, got '../child'"),
        ('["summary"', '["monitor.film"', "without: expected a key of ../base, got 'monitor.film'"),
        (
            'y = "2 m"',
            '[participants.c]\nlike = "d"',
            "participants.c.like: expected a, got unknown participant 'd'",
        ),
    ],
)
def test_faults_of_parts(child, old, new, fault):
    child.write_text(CHILD.replace(old, new))
    with pytest.raises(BadInput, match=fault):
        read_tree(child)


def test_a_change_cannot_extend_a_case():
    path = find_case("data_sheet")
    for key in ("extends", "participants.ehd.body"):
        with pytest.raises(BadInput, match="expected a case file for this key, got a change"):
            check_case(read_tree(path, [(key, "bodies")]), path)


def test_a_change_of_a_participant_leaves_those_like_it():
    changes = [("participants.left_film.build.grid", [36, 8])]
    tree = read_tree(find_case("floating_pin"), changes)
    grids = [tree["participants"][f"{side}_film"]["build"]["grid"] for side in ("left", "right")]
    assert grids == [[36, 8], [72, 8]]


def test_participants_like_others_and_the_wires_of_their_films():
    tree = read_tree(find_case("floating_pin"))
    left, right = (tree["participants"][f"{side}_film"] for side in ("left", "right"))
    assert left == right and not {"like", "body"} & {*left}
    assert tree["participants"]["small_end_film"]["parameters"] == {
        **left["parameters"],
        "skirt_length": "36 mm",
    }
    assert [wire for wire in tree["wires"] if "right_film" in f"{wire['from']} {wire['to']}"] == [
        {
            "from": "bodies.boss_right.film_thickness",
            "to": "right_film.film_thickness",
            "tolerance": "10 nm",
            "largest_decrease": 0.3,
            "conjugate": "right_film.nodal_pressure_force",
        },
        {
            "from": "bodies.boss_right.circumferential_velocity",
            "to": "right_film.circumferential_velocity",
            "tolerance": 1e-5,
            "conjugate": "right_film.nodal_circumferential_force",
        },
        *(
            {"from": f"right_film.{force}", "to": f"bodies.boss_right.{force}"}
            for force in ("nodal_pressure_force", "nodal_circumferential_force")
        ),
    ]
    skirt = {wire["to"] for wire in tree["wires"] if wire["from"].startswith("skirt_film.")}
    assert skirt == {"bodies.skirt.nodal_pressure_force", "bodies.skirt.nodal_friction_force"}
