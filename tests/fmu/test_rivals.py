"""`compare CASE --lubrication ...`: two models on one case, as a user calls it."""

import numpy as np
import pytest

from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.rivals import Exchange, distance, rivals_of

from ..command import call

SMALL = [
    f"--set={change}"
    for change in (
        "participants.bodies.build.grid=[12,10]",
        "participants.ehd.build.grid=[12,10]",
        "time.stop=10 deg",
        "participants.bodies.build.piston.modes=0",
        "participants.bodies.build.block.modes=0",
    )
]


def compare(folder, *words):
    return call("compare", "numerical_example", *words, folder=folder)


def test_cavitation_models_differ_and_a_model_not_from_itself(tmp_path, fmu):
    (tmp_path / "same.fmu").write_bytes(fmu.read_bytes())
    done = compare(
        tmp_path,
        *SMALL,
        "--set=participants.ehd.build.mask=none",  # the FMU was built without the case's mesh
        "--lubrication=jfo",
        "--lubrication=same.fmu",
        "--lubrication=gumbel",
        "--output=out",
    )
    assert done.returncode == 0, done.stdout + done.stderr
    lines = {line.split("  ")[0].strip(): line for line in done.stdout.splitlines()}
    apart = [float(word) for word in lines["film, rms difference [um]"].split("]")[1].split()]
    assert apart[:2] == [0.0, 0.0] and apart[2] > 1e-4
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"models.png", "motion.png", "film.png", "jfo.h5", "same.h5", "gumbel.h5"} <= written


def test_every_fault_is_listed(tmp_path):
    done = compare(tmp_path, "--lubrication=none.fmu")
    assert done.returncode == 2
    assert "no such file 'none.fmu'" in done.stderr and "expected at least two" in done.stderr


def test_only_common_instants_are_compared():
    whole = Exchange(np.array([0.0, 1.0, 2.0]), {"film": np.zeros((3, 1, 1))}, {})
    films = np.array([0.0, 0.0, 9.0, 2.0]).reshape(4, 1, 1)
    halved = Exchange(np.array([0.0, 1.0, 1.5, 2.0]), {"film": films}, {})
    shared, apart = distance(halved, whole, "film")
    assert shared.tolist() == [0.0, 1.0, 2.0] and apart.tolist() == pytest.approx([0.0, 0.0, 2.0])


def test_trees_record_what_crosses_the_interface():
    tree = read_tree(find_case("numerical_example"), [])
    rivals = rivals_of(tree, "lubrication", ["jfo", "reynolds"])
    assert rivals.left_out == {} and rivals.common["pictures"]
    parameters = [each["participants"]["ehd"]["parameters"] for each in rivals.trees.values()]
    assert [values["cavitation_model"] for values in parameters] == ["jfo", "reynolds"]
    assert {"bodies.film_thickness", "ehd.nodal_friction_force"} <= set(
        rivals.trees["jfo"]["record"]["fields"]
    )


def two_films():
    """The numerical example's tree with a second film, fed by fields of other names."""
    tree = read_tree(find_case("numerical_example"), [])
    participants = tree["participants"] | {"pin": {"fmu": "pin.fmu", "role": "lubrication"}}
    wires = [
        {"from": "bodies.pin_gap", "to": "pin.film_thickness"},
        {"from": "bodies.pin_slip", "to": "pin.sliding_velocity"},
    ]
    return tree | {"participants": participants, "wires": [*tree["wires"], *wires]}


def test_with_two_films_the_one_to_replace_is_named():
    tree = two_films()
    with pytest.raises(
        BadInput, match="expected one of ehd, pin, got several; write --lubrication ehd=jfo"
    ):
        rivals_of(tree, "lubrication", ["jfo", "reynolds"])
    with pytest.raises(BadInput, match="expected models of one participant, got ehd and pin"):
        rivals_of(tree, "lubrication", ["ehd=jfo", "pin=jfo"])
    with pytest.raises(
        BadInput, match="expected one of ehd, pin, got unknown participant 'bodies'"
    ):
        rivals_of(tree, "lubrication", ["bodies=jfo", "ehd=jfo"])
    rivals = rivals_of(tree, "lubrication", ["pin=jfo", "pin=gumbel"])
    assert rivals.ports == {
        "film_thickness": "bodies.pin_gap",
        "sliding_velocity": "bodies.pin_slip",
        "nodal_pressure_force": "pin.nodal_pressure_force",
        "nodal_friction_force": "pin.nodal_friction_force",
    }
    chosen = rivals.trees["gumbel"]["participants"]
    assert chosen["pin"]["parameters"] == {"cavitation_model": "gumbel"}
    assert chosen["ehd"] == tree["participants"]["ehd"]
