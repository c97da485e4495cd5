"""All pairs of build options of the bodies: which are rejected, and the reason in the message."""

import itertools

import pytest
from pydantic import ValidationError

from piston_cosim.fmu_mfbd.force_elements import SLIDES
from piston_cosim.fmu_mfbd.force_elements.element import ForceElement
from piston_cosim.fmu_mfbd.force_elements.land_contact import (
    LandParameters,
    land_change,
    land_force,
)
from piston_cosim.fmu_mfbd.options import Build

from .conftest import sheets

MATERIAL = {"density": "2700 kg/m^3", "young": "75 GPa", "poisson": 0.33}
MESH = {"mesh": "body.msh", **MATERIAL}
PIN = {"boss_length": "2 cm", "small_end_length": "3 cm"}
BEARING = {"length": "3 cm"}
RING = {"ring": {"inside": "24 mm", "outside": "30 mm"}, **MATERIAL}
POINTS = {"points": [[0.0, 0.0], [1.0, 1.0]]}
PISTON = {"piston": MESH | {"modes": 60}}
CHOICES = {
    "flexible piston": PISTON,
    "an error as modes": {"piston": MESH | {"modes": "1 %"}},
    "trained": {"piston": MESH | {"modes": 60, "basis": "trained", "train_on": "run.h5"}},
    "flexible block": {"block": MESH | {"modes": 60}},
    "floating_pin": {"floating_pin": PIN},
    "boss_modes": PISTON | {"floating_pin": PIN | {"boss_modes": 24}},
    "pin_shapes": {"floating_pin": PIN | {"pin_shapes": 3}},
    "small_end": {"floating_pin": PIN | {"small_end": MESH | {"modes": 20}}},
    "big_end": {"big_end": BEARING},
    "main_bearing": {"main_bearing": BEARING},
    "shells": {name: BEARING | {"shell": RING} for name in ("big_end", "main_bearing")},
    "mounted": {"mounted": True},
    "bore_from_outside": {"mounted": True, "block": {"bore_from_outside": {}}},
    "motion_in_space": {
        "motion_in_space": {"inertia_x": "0.003 kg*m^2", "inertia_y": "0.003 kg*m^2"}
    },
    "start": {"start": "start.json"},
    "gas": {"gas": POINTS | {"angle_unit": "deg", "pressure_unit": "bar"}},
    "speed": {"speed": POINTS | {"time_unit": "s", "speed_unit": "rpm"}},
    "film_surfaces": {"film_surfaces": [{"name": "low", "rows": [1, 5]}]},
    "slides": {"slides": ["rod_stretch"]},
}
"""Changes of the build table of two data sheets."""

OF_SKIRT = "modes of the skirt alone miss the deflection of the bosses"
IN_PLANE = "its equations are those of a rigid piston on a tied pin in a block at rest"
OF_OUTSIDE = "rigid: expected a table with bore_from_outside"
FLOATING = ("floating_pin", "pin_shapes", "small_end")
FLEXIBLE = ("flexible piston", "an error as modes", "trained")
REJECTED = (
    {(piston, pin): OF_SKIRT for piston in FLEXIBLE for pin in FLOATING}
    | {(one, "motion_in_space"): IN_PLANE for one in (*FLEXIBLE, *FLOATING, "flexible block")}
    | {(one, "motion_in_space"): IN_PLANE for one in ("boss_modes", "big_end", "main_bearing")}
    | {(one, "motion_in_space"): IN_PLANE for one in ("shells", "mounted", "bore_from_outside")}
    | {("motion_in_space", one): IN_PLANE for one in ("start", "slides")}
    | {(one, "slides"): "rod_stretch with floating_pin" for one in (*FLOATING, "boss_modes")}
    | {("flexible block", "bore_from_outside"): OF_OUTSIDE}
)
"""Pairs, in the order of `CHOICES`, and the reason why they do not exist."""


def merged(first, second):
    """Return a table with the keys of another, its tables merged."""
    out = dict(first)
    for key, value in second.items():
        both = isinstance(value, dict) and isinstance(out.get(key), dict)
        out[key] = merged(out[key], value) if both else value
    return out


def table(*names):
    """Return the build table with these choices; a mesh replaces a data sheet."""
    out = sheets()
    for name in names:
        for body in ("piston", "block"):
            if "mesh" in CHOICES[name].get(body, {}):
                lower = {key: one for key, one in out[body].items() if key != "rigid"}
                out[body] = {**lower, "bore_from_outside": lower.get("bore_from_outside")}
                if body == "piston":
                    del out[body]["bore_from_outside"]
        out = merged(out, CHOICES[name])
    return out


SLIDER = ForceElement(
    LandParameters, land_force, land_change, reacts="rod", frees={"rod_stretch": (0.0, 1.0)}
)
"""Element that lets the small end slide along the rod."""


def test_all_pairs_of_options(monkeypatch):
    """Every pair that is not listed is valid, and the message of every other names the reason."""
    monkeypatch.setitem(SLIDES, "rod_stretch", SLIDER)
    assert REJECTED.keys() <= {*itertools.combinations(CHOICES, 2)}
    for pair in itertools.combinations(CHOICES, 2):
        if pair in REJECTED:
            with pytest.raises(ValidationError) as told:
                Build.model_validate(table(*pair))
            assert REJECTED[pair] in str(told.value), pair
        else:
            Build.model_validate(table(*pair))


@pytest.mark.parametrize(
    "names, text",
    [
        (["rod_stretch"], "slides: expected one of none, got rod_stretch"),
        (["rod_stretch"] * 2, "slides: expected each once, got rod_stretch, rod_stretch"),
    ],
)
def test_slides_that_no_element_frees_are_rejected(names, text):
    with pytest.raises(ValidationError) as raised:
        Build.model_validate(sheets() | {"slides": names})
    assert text in str(raised.value)
