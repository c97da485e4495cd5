"""The step of native bodies with a floating pin compared with that of their Python implementation.

Both are interpreted. The test of a tied pin is `test_native_bodies`.
"""

import dataclasses
import json

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.build_options import (
    BlockOptions,
    BuildOptions,
    CrankBearing,
    FloatingPin,
    PistonOptions,
)
from piston_cosim.fmu_mfbd.dynamics.start_state import StartState
from piston_cosim.fmu_mfbd.native import INTEGERS, setup_row
from piston_cosim.fmu_mfbd.reduction.reduced_body import save
from piston_cosim.fmu_mfbd.slave import Mfbd
from piston_cosim.master.fmi.compiled import Kernel

from .pin_models import (
    BLOCK_MODES,
    GRID,
    MODES,
    PARAMETERS,
    PIN_GRID,
    RINGS,
    SHELL_MODES,
    flexible_block,
    small_end,
    yielding_bodies,
)
from .test_native_bodies import held, side_by_side

VALUES = {
    name: value
    for name, value in vars(
        dataclasses.replace(
            PARAMETERS,
            crank_unbalance=-0.12,
            start_crank_angle=0.3,
            start_lateral_displacement=2e-6,
            start_rocking_angle=1e-4,
            **RINGS,
        )
    ).items()
    if name not in INTEGERS  # choices, by their numbers
}
"""Offsets of pin and crank, and every body with a mass."""
CRANK = {"big_end": (10, 3), "main_bearing": (8, 4)}


def built(folder, eye_radius=18e-3, shell_radii=(24e-3, 27e-3), floats=True, start=None, shapes=0):
    """Folder of a slave's resources; bosses, block, eye and shells of the crank yield."""
    piston, _, bosses, _ = yielding_bodies()
    parts = {"piston": piston, "block": flexible_block(), "bosses": bosses}
    parts["eye"] = small_end(radius=eye_radius)
    for (name, grid), radius in zip(CRANK.items(), shell_radii):
        parts[name] = small_end(1.0, grid, radius)
    for name, part in parts.items():
        save(folder / f"{name}.npz", part)
    pin = FloatingPin(
        PIN_GRID,
        25e-3,
        36e-3,
        bosses="bosses.npz",
        small_end="eye.npz",
        small_end_modes=SHELL_MODES,
        pin_shapes=shapes,
    )
    crank = tuple(
        CrankBearing(name, grid, 30e-3, shell=f"{name}.npz", modes=SHELL_MODES)
        for name, grid in CRANK.items()
    )
    options = BuildOptions(
        GRID,
        PistonOptions("piston.npz", MODES, 1e-3),
        BlockOptions("block.npz", BLOCK_MODES),
        floating_pin=pin if floats else None,
        crank_bearings=crank,
        mounted=True,
        start=start,
    )
    (folder / "build.json").write_text(json.dumps(options.to_json()))
    return folder


def test_bosses_and_shells_that_yield_are_those_of_the_model(tmp_path):
    """Both call numpy's products here, and each with the same numbers."""
    held(side_by_side(built(tmp_path), VALUES), 1e-12)
    free = dict(crank_free=1, load_torque=30.0, crank_inertia=0.02, quasi_static_frequency=4e3)
    held(side_by_side(tmp_path, VALUES | free), 1e-12)


def test_films_of_the_crank_with_a_tied_pin_are_those_of_the_model(tmp_path):
    """Other parameters of pin and eye do not exist."""
    rubbing = VALUES | {"pin_friction_coefficient": 0.05}
    held(side_by_side(built(tmp_path, floats=False), rubbing), 1e-12)


def test_a_pin_that_bends_is_that_of_the_model(tmp_path):
    """With relieved shells and a bore; then with faults of both in the words of the slave."""
    bends = dict(pin_bore_radius=9.4e-3, pin_young=206e9, pin_poisson=0.3, pin_length=0.12)
    relief = dict(boss_relief=3e-6, small_end_relief=2e-6)
    folder = built(tmp_path, shapes=4)
    held(side_by_side(folder, VALUES | bends | relief), 1e-12)
    of_python, of_machine = side_by_side(
        folder, VALUES | bends | {"pin_bore_radius": 0.02, "pin_length": 0.02}
    )
    assert of_machine == of_python and len(of_python) == 2


def test_a_start_in_motion_is_that_of_the_model(tmp_path):
    rng = np.random.default_rng(3)
    modal = 1e-7 * rng.standard_normal((2, MODES + BLOCK_MODES))
    bearings = 1e-6 * rng.standard_normal((2, 5 + SHELL_MODES + 2 * (2 + SHELL_MODES)))
    start = StartState(0.4, 280.0, 3e-6, -1e-4, 0.01, 0.3, *modal, *bearings)
    held(side_by_side(built(tmp_path, start=start), VALUES), 1e-12)


def test_parameters_that_do_not_fit_are_told_in_the_words_of_the_slave(tmp_path):
    folder = built(tmp_path, 17.5e-3, (25e-3, 25e-3))
    zeros = dict.fromkeys(("pin_mass", "rod_mass", "rod_inertia"), 0.0)
    friction = ("pin_friction_coefficient", "pin_friction_speed", "pin_friction_damping")
    wrong = zeros | dict.fromkeys(friction, 0.5) | dict(pin_radius=19e-3)
    of_python, of_machine = side_by_side(folder, VALUES | wrong)
    assert of_machine == of_python and len(of_python) == 10


@pytest.mark.parametrize("floats", [True, False])
def test_a_native_start_calls_no_kernel_from_python(tmp_path, monkeypatch, floats):
    """A release contains the library, and not the kernels that Python calls."""
    slave = Mfbd(instance_name="one", resources=built(tmp_path, floats=floats, shapes=4 * floats))
    called = property(lambda kernel: pytest.fail(f"compiles {kernel.__name__}"))
    monkeypatch.setattr(Kernel, "dispatcher", called)
    assert len(setup_row(slave)) > 0
