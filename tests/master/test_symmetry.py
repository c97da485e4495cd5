"""Symmetry about the thrust plane: each thing that breaks it in a shipped symmetric case."""

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.master.api.cases import open_case
from piston_cosim.master.case.ahead import ahead, faults_ahead
from piston_cosim.master.case.check import check
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.symmetry import groups, half_films
from piston_cosim.master.commands.fmu import export
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.fmi.symmetry import odd_part, thrust_image

from ..command import call

PATH = find_case("numerical_example")
BUILD, BODIES = "participants.bodies.build", "participants.bodies.parameters"
FILM = "participants.ehd"
SHEET = {"mass": "0.1 kg", "centre": ["0 mm", "5 mm"], "inertia": "5e-5 kg*m^2", "radius": "28 mm"}
RIGID = {
    f"{BUILD}.piston": {"rigid": SHEET, "skirt_lower": "-16 mm", "skirt_upper": "11 mm"},
    f"{BUILD}.block": {
        "rigid": {"radius": "28.25 mm"},
        "bore_lower": "56 mm",
        "bore_upper": "152 mm",
    },
}
OUTSIDE = {f"{BUILD}.block": RIGID[f"{BUILD}.block"] | {"bore_from_outside": {}}}
HEAT = {
    "participants.heat": {"table": "heat.csv"},
    "coupling.order": ["heat", "ehd", "bodies"],
    f"{FILM}.build.inputs": ["oil_temperature"],
}


def changed_case(changes, path=PATH):
    """Return the case with changes, whose wires replace those to the same inputs."""
    wires = changes.get("wires", [])
    tree = read_tree(path, [(key, value) for key, value in changes.items() if key != "wires"])
    taken = {wire["to"] for wire in wires}
    tree["wires"] = [wire for wire in tree["wires"] if wire["to"] not in taken] + wires
    return check_case(tree, path)


def groups_of(changes, path=PATH):
    case = changed_case(changes, path)
    return [*groups(case, path.parent, ahead(case, path.parent))]


def profile(folder, values):
    """Return a measured shape at 0, 90, 180 and 270 deg."""
    file = folder / "profile.csv"
    rows = [f"{height}, {', '.join(map(str, values))}" for height in (-10, 0, 10)]
    file.write_text("\n".join(["0, 0, 90, 180, 270", *rows]) + "\n")
    units = {"angle_unit": "1 deg", "height_unit": "1 mm", "value_unit": "1 um"}
    return [{"file": str(file)} | units]


def mask(cells=()):
    found = np.ones((40, 40), dtype=int)
    for cell in cells:
        found[cell] = 0
    return found.tolist()


def array(cell, value):
    field = np.full((40, 40), "300 K", dtype=object)
    field[cell] = value
    return field.tolist()


def order(number, phase):
    return [{"order": number, "amplitude": "2 um", "phase": phase}]


SYMMETRIC = {
    "shipped": {},
    "bore order": {f"{BUILD}.block.orders": order(3, "90 deg")},
    "mask": {f"{FILM}.build.mask": mask([(9, 3), (11, 3)])},
    "scalars": {f"{BODIES}.ring_side_force": "5 N", f"{BODIES}.piston_temperature": "400 K"},
    "walls": {f"{BUILD}.temperatures": {"skirt": ["100 degC", "130 degC"], "bore": "120 degC"}},
    "temperature": HEAT | {f"{FILM}.parameters.oil_temperature": array((10, 5), "310 K")},
}
ASYMMETRIC = {
    "bodies.parameters.pin_tilt": {f"{BODIES}.pin_tilt": "0.15 mrad"},
    "bodies.build.block.orders": {f"{BUILD}.block.orders": order(3, "60 deg")},
    "ehd.build.mask (2 cells": {f"{FILM}.build.mask": mask([(9, 3)])},
    "bodies.build.motion_in_space": RIGID
    | {f"{BUILD}.motion_in_space": {"inertia_x": "5e-5 kg*m^2", "inertia_y": "5e-5 kg*m^2"}},
    "bodies.build.block.bore_from_outside": OUTSIDE | {f"{BUILD}.mounted": True},
    "bodies.build.temperatures.skirt (field": {
        f"{BUILD}.temperatures": {"skirt": "input", "bore": "120 degC"}
    },
    "ehd.oil_temperature (from heat.t": HEAT
    | {"wires": [{"from": "heat.t", "to": "ehd.oil_temperature"}]},
    "ehd.oil_temperature[2,3] (from heat.t": HEAT
    | {"wires": [{"from": "heat.t", "to": "ehd.oil_temperature[2,3]"}]},
    "ehd.parameters.oil_temperature": HEAT
    | {f"{FILM}.parameters.oil_temperature": array((9, 5), "310 K")},
    "bodies.nodal_pressure_force (from heat.force": HEAT
    | {"wires": [{"from": "heat.force", "to": "bodies.nodal_pressure_force"}]},
}


@pytest.mark.parametrize("changes", SYMMETRIC.values(), ids=SYMMETRIC)
def test_a_symmetric_case_has_no_reasons(changes):
    (group,) = groups_of(changes)
    assert group.body == "bodies" and not group.unknown
    assert group.reasons == []
    keys = [f"{BUILD}.{name}.symmetric_film" for name in ("piston", "block")]
    assert group.claims == keys


@pytest.mark.parametrize("reason, changes", ASYMMETRIC.items(), ids=ASYMMETRIC)
def test_each_reason_is_found_and_rejects_what_assumes_symmetry(reason, changes):
    (group,) = groups_of(changes)
    assert any(line.startswith(f"participants.{reason}") for line in group.reasons)
    faults = [
        one for one in faults_ahead(changed_case(changes), PATH.parent) if "symmetric_film: " in one
    ]
    assert len(faults) == len(group.claims) and all(reason in one for one in faults)


def half_films_of(changes):
    """Return the films of which a case computes one half, and the faults."""
    case, faults = changed_case(changes), []
    found = half_films(case, PATH.parent, ahead(case, PATH.parent), builds_of(case), faults)
    return found, faults


def builds_of(case):
    return {name: dict(table.build) for name, table in case.participants.items()}


def halves(choice):
    """Return the parameters of the participants that compute one half."""
    return {name: {"film_symmetry": choice} for name in ("ehd", "bodies")}


@pytest.mark.parametrize("changes", SYMMETRIC.values(), ids=SYMMETRIC)
def test_half_of_a_symmetric_film_is_computed(changes):
    """An input field that no wire feeds may become uneven in an exported FMU."""
    is_free = changes is SYMMETRIC["temperature"]
    assert half_films_of(changes) == ({} if is_free else halves("automatic"), [])
    assert half_films_of(changes | {"symmetric": True}) == (halves("thrust_plane"), [])
    assert half_films_of(changes | {"symmetric": False}) == ({}, [])


@pytest.mark.parametrize("reason, changes", ASYMMETRIC.items(), ids=ASYMMETRIC)
def test_half_of_an_asymmetric_film_is_rejected(reason, changes):
    assert half_films_of(changes) == ({}, [])
    _, (fault,) = half_films_of(changes | {"symmetric": True})
    assert fault.startswith("symmetric: ") and reason in fault
    assert fault.endswith("set symmetric = false")
    assert fault in faults_ahead(changed_case(changes | {"symmetric": True}), PATH.parent)


def test_half_of_a_film_is_not_demanded_where_a_parameter_chooses_the_whole_one():
    """The parameter decides if the case demands nothing."""
    whole = {f"{FILM}.parameters.film_symmetry": "none"}
    assert half_films_of(whole) == (halves("automatic"), [])
    _, (fault,) = half_films_of(whole | {"symmetric": True})
    assert "got participants.ehd.parameters.film_symmetry (none); set symmetric = false" in fault


def test_an_ssp_is_not_made_of_a_case_that_demands_other_films():
    """A fault that only reduced bodies show is reported as well."""
    demanded = RIGID | {"symmetric": True}
    for changes, reason in (
        (TILT, "pin_tilt"),
        ({f"{FILM}.parameters.film_symmetry": "none"}, "film_symmetry"),
    ):
        with pytest.raises(BadInput, match=rf"symmetric: .*\.{reason} \("):
            export.open_python(changed_case(demanded | changes), PATH.parent, "2.0")


def test_a_film_with_an_odd_number_of_cells_around_is_computed_whole():
    changes = RIGID | {f"{BUILD}.grid": [39, 40], f"{FILM}.build.grid": [39, 40]}
    assert half_films_of(changes) == ({}, [])
    _, (fault,) = half_films_of(changes | {"symmetric": True})
    assert fault.startswith("symmetric: ")


@pytest.mark.parametrize("body", ["piston", "block"])
def test_a_measured_profile_is_compared_with_its_image(tmp_path, body):
    """0 and 180 deg are images of each other, 90 and 270 deg of themselves."""
    key = f"{BUILD}.{body}.profiles"
    (group,) = groups_of({key: profile(tmp_path, (3, 0, 3, 1))})
    assert group.reasons == []
    (group,) = groups_of({key: profile(tmp_path, (3, 0, 2, 1))})
    assert group.reasons == [f"participants.bodies.build.{body}.profiles (odd part of 500 nm)"]


def test_films_of_a_pin_are_compared_with_their_images():
    """A film in a boss needs the same film in the other one, and equal edges."""
    path = find_case("floating_pin")
    (group,) = groups_of({}, path)
    assert group.reasons == []
    changes = {
        "participants.right_film.parameters.viscosity": "6 mPa s",
        "participants.small_end_film.parameters.pressure_lower_edge": "1 bar",
    }
    (group,) = groups_of(changes, path)
    assert group.reasons == [
        "participants.small_end_film.parameters.pressure_lower_edge (differs from "
        "pressure_upper_edge)",
        "participants.right_film (differs from left_film, its mirror image)",
    ]


def test_films_of_both_bosses_need_the_same_wires_from_outside():
    """A viscosity from outside of one boss alone bends the piston across the thrust plane."""
    path, wires = find_case("floating_pin"), []
    changes = {
        "participants.heat": {"table": "heat.csv"},
        "coupling.order": ["heat", *open_case("floating_pin")["coupling.order"]],
        "wires": wires,
    }
    expected = ["participants.right_film (differs from left_film, its mirror image)"], []
    for film, reasons in zip(("left_film", "right_film"), expected):
        wires.append({"from": "heat.mu", "to": f"{film}.viscosity"})
        (group,) = groups_of(changes, path)
        assert group.reasons == reasons


def test_a_film_of_another_model_is_a_remark(tmp_path):
    film = tmp_path / "film.py"
    film.write_text("")
    changes = {FILM: {"file": f"{film}:Film", "role": "lubrication"}}
    changes["wires"] = [
        {"from": "bodies.film_thickness", "to": "ehd.film_thickness"},
        {"from": "ehd.nodal_pressure_force", "to": "bodies.nodal_pressure_force"},
    ]
    (group,) = groups_of(changes)
    assert group.unknown == ["ehd"] and group.reasons == []
    remarks = check(PATH, [*changes.items()]).remarks
    assert any("symmetry of ehd is not known" in line for line in remarks)


TILT = {f"{BODIES}.pin_tilt": "0.15 mrad"}


@pytest.mark.parametrize("command", ["check", "run --no-plots --only flexible", "reduce"])
def test_every_command_rejects_the_tilted_pin(command, tmp_path):
    name, *words = command.split()
    change = next(f"{key}={value}" for key, value in TILT.items())
    done = call(name, "numerical_example", *words, "--set", change, folder=tmp_path)
    assert done.returncode == 2
    said = " ".join((done.stdout + done.stderr).split())
    assert "piston.symmetric_film: expected a film symmetric about the thrust plane" in said
    assert "parameters.pin_tilt (0.00015 rad)" in said


def test_a_build_rejects_the_tilted_pin():
    with pytest.raises(BadInput, match=r"parameters\.pin_tilt \(0\.00015 rad\)"):
        pc.build_fmu(pc.open_case("numerical_example", TILT), "bodies")


def test_cells_and_their_images():
    """Eq. (I13) for even, odd and halved quarters: pi - theta by hand, from pi/2 at floor(n/4)."""
    for n in (8, 9, 10, 11):
        theta = np.pi / 2 + (np.arange(n) - n // 4) * 2 * np.pi / n
        image = theta[thrust_image(n)]
        np.testing.assert_allclose(np.sin(image), np.sin(theta), atol=1e-15)
        np.testing.assert_allclose(np.cos(image), -np.cos(theta), atol=1e-15)
        np.testing.assert_allclose(
            odd_part(np.cos(theta) + np.sin(theta)), np.cos(theta), atol=1e-15
        )


def test_the_variants_of_a_symmetric_case_stay_symmetric():
    for name in ("numerical_example", "fired_motorcycle"):
        case = open_case(name)
        for label in case.variants:
            tree = case.variant(label).tree
            checked = check_case(tree, case.path)
            assert not [
                group.reasons
                for group in groups(checked, case.path.parent, ahead(checked, case.path.parent))
                if group.reasons
            ]
