"""Every parameter and input of each mechanism has an effect, or is rejected.

A mechanism that ignores what a user sets would give a wrong result silently.
"""

import json
import shutil

import numpy as np
import pytest
from pythonfmu.enums import Fmi2Status

from piston_cosim.fmu_mfbd.build import prepare
from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.geometry.pin import PinForces
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED
from piston_cosim.fmu_mfbd.slave import Mfbd

from .conftest import quiet, sheets

MECHANISM = dict(
    crank_radius=72e-3,
    rod_length=223e-3,
    crank_offset=2e-3,
    rod_mass=1.7,
    rod_inertia=0.017,
    rod_centre=72e-3,
    pin_mass=0.5,
    pin_radius=18e-3,
    radial_clearance=50e-6,
    barrel=40e-6,
    ovality=200e-6,
    crank_speed=176.0,
    start_crank_angle=0.6,
    top_ring_height=60e-3,
    second_ring_height=50e-3,
)
LAND = dict(land_stiffness=1e6, land_damping=1.0, land_clearance=1e-9, land_height=30e-3)
"""Contact of the top land, which a motion in space does not have."""
PIN = {"grid": [24, 4], "boss_length": "25 mm", "small_end_length": "36 mm"}
BEARING = {"length": "20 mm", "grid": [24, 4]}
INERTIA = {"inertia_x": "0.003 kg*m^2", "inertia_y": "0.003 kg*m^2"}
BORE = {"bore_from_outside": {"around": 12, "axial": 10}}
MECHANISMS = {
    "tied": {},
    "free": {},
    "floating": {"floating_pin": PIN},
    "bending": {"floating_pin": PIN | {"pin_shapes": 3}},
    "crank": {"floating_pin": PIN, "big_end": BEARING, "main_bearing": BEARING},
    "tied crank": {"big_end": BEARING, "main_bearing": BEARING},
    "free crank": {"floating_pin": PIN, "big_end": BEARING},
    "mounted crank": {"floating_pin": PIN, "main_bearing": BEARING, "mounted": True},
    "space": {"motion_in_space": INERTIA},
    "mounted": {"mounted": True},
    "outside": {"block": BORE, "mounted": True},
    "outside floating": {"block": BORE, "mounted": True, "floating_pin": PIN},
}
FREE = {"crank_free": 1}

RIGID = {
    "damping_ratio",
    "high_frequency_damping_ratio",
    "damping_transition_frequency",
    "quasi_static_frequency",
}
"""Parameters of modes. Bodies of data sheets have none."""
ON_BORE = {"land_pressure", "top_ring_height", "second_ring_height", "land_pressure_share"}
"""Pressure on the bore, which a rigid bore takes without an effect."""
STOPS = {"pin_axial_play", "pin_axial_stiffness", "pin_tilt_play", "pin_tilt_stiffness"}
"""Stops that a piston in the middle of its play does not touch."""
WARNED = {"load_torque"}
"""Without effect on a crank of prescribed speed, with a warning."""
AXIAL = {f"{name}.nodal_friction_force" for name in ("boss_left", "boss_right", "small_end")}
AXIAL |= {f"{name}.nodal_friction_force" for name in ("big_end", "main_bearing")}
"""Documented as without effect: pin and crank do not move along their axes."""
NONE = {
    "tied": RIGID | ON_BORE | WARNED,
    "free": RIGID | ON_BORE | {"crank_speed"},  # of the start
    "floating": RIGID | ON_BORE | WARNED | AXIAL,
    # its shapes are damped
    "bending": RIGID - {"damping_ratio", "high_frequency_damping_ratio"} | ON_BORE | WARNED | AXIAL,
    "crank": RIGID | ON_BORE | WARNED | AXIAL,
    "tied crank": RIGID | ON_BORE | WARNED | AXIAL,
    "free crank": RIGID | ON_BORE | AXIAL | {"crank_speed"},
    "mounted crank": RIGID | ON_BORE | WARNED | AXIAL,
    "space": RIGID | ON_BORE | WARNED | STOPS | LAND.keys() - {"land_stiffness"},
    "mounted": RIGID | ON_BORE | WARNED,
    "outside": RIGID | WARNED,
    "outside floating": RIGID | WARNED | AXIAL,
}
FRICTION = {"pin_friction_coefficient", "pin_friction_speed", "pin_friction_damping"}
FLOATING = ("floating", "bending", "crank", "free crank", "mounted crank", "outside floating")
REJECTED = dict.fromkeys(FLOATING, FRICTION)
REJECTED["space"] = {"crank_free", "land_stiffness"}

SIZE = {"Pa": 1e5, "N": 10.0, "N.m": 3.0, "m/s2": 50.0, "rad/s2": 100.0, "m": 1e-6}
"""Sizes of inputs, and of parameters whose default is 0."""
OTHER = {"m": 1e-5, "rad": 1e-3, "kg.m": 1e-3, "1": 0.3, "kg.m2": 1e-3, "N.m.s/rad": 0.1}
SPECIAL = {
    "crank_free": 1,
    "start_lateral_displacement": 1e-6,
    "pin_length": 0.2,
    "impact_resolution": 1.0,
}


class Bodies:
    """Body FMUs of a mechanism with different values."""

    def __init__(self, kind, folder):
        self.options, files = prepare(sheets(**MECHANISMS[kind]), folder, quiet)
        for file in files:
            shutil.copy(file, folder)
        (folder / "build.json").write_text(json.dumps(self.options))
        self.folder, self.start = folder, FREE if kind.startswith("free") else {}
        self.sizes = MECHANISM if kind == "space" else MECHANISM | LAND
        self.variables = {one.name: one for one in Mfbd.variables(self.options)}

    def slave(self, values):
        one = Mfbd(instance_name="bodies", resources=str(self.folder))
        for name, value in (self.sizes | self.start | values).items():
            one.views[name][...] = value
        one.exit_initialization_mode()
        return one

    def outputs(self, values, change=None):
        """Return all outputs after three steps of rough inputs, None if the FMU rejects values."""
        one = self.slave(values)
        if one.fault:
            return None
        rough = np.random.default_rng(2)
        for _ in range(3):
            for name, variable in self.variables.items():
                if variable.causality == "input":
                    part = rough.random(variable.shape or ())
                    least = {"K": 350.0}.get(variable.unit, 0.0)
                    least = MECHANISM.get(name, least)
                    one.views[name][...] = least + SIZE.get(variable.unit, 1.0) * part
            if change:
                one.views[change][...] *= 1.1
            assert one.do_step(0.0, 1e-4)
        return {
            name: np.array(one.views[name])
            for name, variable in self.variables.items()
            if variable.causality == "output"
        }


def changed(variable, sizes):
    """Return another value of a parameter in its range."""
    if variable.name in SPECIAL:
        return SPECIAL[variable.name]
    if variable.name in sizes:
        return 1.001 * sizes[variable.name]
    value = 1.5 * variable.start or OTHER.get(variable.unit, 0.5)
    high = np.inf if variable.maximum is None else variable.maximum
    return min(value, high)


@pytest.mark.parametrize("kind", MECHANISMS)
def test_everything_has_an_effect_or_is_rejected(kind, tmp_path):
    bodies = Bodies(kind, tmp_path)
    usual = bodies.outputs({})
    ignored, rejected = set(), set()
    for name, variable in bodies.variables.items():
        if variable.causality == "input":
            found = bodies.outputs({}, name)
        elif variable.causality == "parameter" and not variable.choices:
            if name in bodies.start:
                continue
            found = bodies.outputs({name: changed(variable, bodies.sizes)})
        else:
            continue
        if found is None:
            rejected.add(name)
        elif all(np.array_equal(found[output], usual[output]) for output in usual):
            ignored.add(name)
    assert rejected == REJECTED.get(kind, set())
    assert ignored == NONE[kind] & bodies.variables.keys()


def test_a_load_torque_on_a_prescribed_crank_is_a_warning(tmp_path):
    bodies = Bodies("tied", tmp_path)
    for values, count in (({}, 1), (FREE, 0)):
        one = bodies.slave(values)
        one.views["load_torque"][...] = 5.0
        for _ in range(2):
            assert one.do_step(0.0, 1e-4)
        _, said = one.verdict()
        texts = [text for status, _, text in said if status == Fmi2Status.warning]
        assert len(texts) == count
        assert all(text.startswith("load_torque: it has no effect on a crank") for text in texts)


@pytest.mark.parametrize("kind", ["tied", "floating", "space"])
def test_a_body_load_by_the_carrier_acts_or_is_rejected(kind, tmp_path):
    """Gravity as an acceleration of the block, and films or a bore that a mechanism lacks."""
    bodies = Bodies(kind, tmp_path)
    model = bodies.slave({}).model
    cells = np.zeros(16 * 12)
    rest = PinForces(*np.zeros((2, 24, 4)))
    pins = (rest,) * 3 if kind == "floating" else ()
    given = dict(crank_speed=176.0, gas_pressure=0.0, pressure_force=cells, friction_force=cells)
    usual = Inputs(**given, pins=pins)
    state, _ = model.start(0.6, 0.0, 0.0, usual)
    gravity = Inputs(**given, pins=pins, carrier=FIXED._replace(ay=9.81))
    way = [0.0, 1.0, 0.0, 0.0]
    if kind != "space":
        still, _ = model.advance(state, usual, 1e-4)
        loaded, _ = model.advance(state, gravity, 1e-4)
        assert (still.position != loaded.position).any()
        assert model.directional_derivative(cells, cells, carried=np.array(way), pins=pins)
    else:
        model.advance(state, usual, 1e-4)
        with pytest.raises(ValueError, match=r"carrier: expected a fixed block .* ay=9\.81"):
            model.advance(state, gravity, 1e-4)
        with pytest.raises(ValueError, match="carrier: expected a fixed block"):
            model.directional_derivative(cells, cells, carried=np.array(way), pins=pins)
    one_more = Inputs(**given, pins=(*pins, rest))
    with pytest.raises(ValueError, match=f"pins: expected {len(pins)} films, got"):
        model.advance(state, one_more, 1e-4)
    bore = Inputs(**given, pins=pins, bore_deflection=np.ones((2, 2)))
    with pytest.raises(ValueError, match="bore_deflection: expected none"):
        model.advance(state, bore, 1e-4)
