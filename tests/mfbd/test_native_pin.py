"""The step of native bodies with a floating pin beside that of their slave in Python, both
interpreted, as `test_native_bodies` has it of a tied one.
"""

import dataclasses
import json
from dataclasses import replace

import pytest

from piston_cosim.fmu_mfbd.dynamics.build_options import (
    BlockOptions,
    BuildOptions,
    CrankBearing,
    FloatingPin,
    PistonOptions,
)
from piston_cosim.fmu_mfbd.reduction.reduced_body import save

from .pin_models import (
    GRID,
    MODES,
    PARAMETERS,
    PIN_GRID,
    SHELL_MODES,
    bodies,
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
        )
    ).items()
    if name not in ("crank_free", "gas_source")  # a choice, by its number
}
"""Offsets of pin and crank, and every body with a mass."""
CRANK = (CrankBearing("big_end", (10, 3), 30e-3), CrankBearing("main_bearing", (8, 4), 30e-3))
SHELL_RADII = {"big_end": 24e-3, "main_bearing": 27e-3}
SETS = {"big_end": CRANK[:1], "main_bearing": CRANK[1:], "both": CRANK}


@pytest.fixture
def built(tmp_path):
    """Folder of a slave's resources; bosses and eye may yield, the crank have films."""

    def make(yields=False, crank=(), eye_radius=None, shell_radii=SHELL_RADII):
        piston, block, *_ = bodies()
        pin = FloatingPin(PIN_GRID, 25e-3, 36e-3)
        if yields:
            piston, block, bosses, _ = yielding_bodies()
            crank = tuple(replace(one, shell=f"{one.name}.npz", modes=SHELL_MODES) for one in crank)
            for one in crank:
                save(tmp_path / one.shell, small_end(1.0, one.grid, shell_radii[one.name]))
            eye = small_end()
            if eye_radius:
                eye = dataclasses.replace(eye, radius=eye_radius)
            save(tmp_path / "bosses.npz", bosses)
            save(tmp_path / "eye.npz", eye)
            pin = dataclasses.replace(
                pin, bosses="bosses.npz", small_end="eye.npz", small_end_modes=len(eye.omega)
            )
        save(tmp_path / "piston.npz", piston)
        save(tmp_path / "block.npz", block)
        options = BuildOptions(
            GRID,
            PistonOptions("piston.npz", MODES if yields else 0, 1e-3),
            BlockOptions("block.npz", 0),
            floating_pin=pin,
            crank_bearings=crank,
        )
        (tmp_path / "build.json").write_text(json.dumps(options.to_json()))
        return tmp_path

    return make


def test_a_rigid_pin_has_the_bits_of_the_model(built):
    """Uneven steps on rough loads, one taken back, with derivatives: no product of matrices."""
    held(side_by_side(built(), VALUES), 0.0)


@pytest.mark.parametrize("films", SETS)
def test_films_of_the_crank_have_the_bits_of_the_model(built, films):
    held(side_by_side(built(crank=SETS[films]), VALUES), 0.0)


@pytest.mark.parametrize("crank", [(), CRANK], ids=["without", "with films of the crank"])
def test_bosses_and_eye_that_yield_are_those_of_the_model(built, crank):
    """Both call numpy's products here, and each with the same numbers."""
    held(side_by_side(built(True, crank), VALUES), 1e-12)


def test_parameters_that_do_not_fit_are_told_in_the_words_of_the_slave(built):
    folder = built(True, CRANK, eye_radius=17.5e-3)
    wrong = dict(pin_mass=0.0, pin_friction_coefficient=0.05, pin_friction_speed=3.0, rod_mass=0.0)
    of_python, of_machine = side_by_side(folder, VALUES | wrong)
    assert of_machine == of_python and len(of_python) == 5
    folder = built(True, CRANK, shell_radii={"big_end": 25e-3, "main_bearing": 25e-3})
    of_python, of_machine = side_by_side(folder, VALUES)
    assert of_machine == of_python and len(of_python) == 2
    folder = built(True, CRANK, eye_radius=17.5e-3)
    wrong = dict(pin_radius=19e-3, pin_friction_damping=1.0, rod_inertia=0.0)
    of_python, of_machine = side_by_side(folder, VALUES | wrong)
    assert of_machine == of_python and len(of_python) == 4


@pytest.mark.parametrize("films", ["big_end", "main_bearing"])
def test_a_rod_without_mass_is_refused_by_the_film_that_it_has(built, films):
    of_python, of_machine = side_by_side(built(crank=SETS[films]), VALUES | dict(rod_mass=0.0))
    assert of_machine == of_python
    assert of_python == [f"rod_mass: expected more than 0 kg with a film in {films}, got 0 kg"]
