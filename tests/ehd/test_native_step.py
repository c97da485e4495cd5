"""The step of the native FMU equals the model's, both interpreted.

Compiled steps, with each choice of physics, are compared in tests/fmu/test_native_fmu.py.
"""

import json
import os

import pytest

from ..command import script

SCRIPT = """
import json, sys
import numpy as np
from piston_cosim.fmu_ehd import native
from piston_cosim.fmu_ehd.slave import Ehd
from piston_cosim.master.fmi.symmetry import odd_part
from piston_cosim.tests.twins import Twins
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

folder, changes = sys.argv[1], json.loads(sys.argv[2])
mask = np.array(json.loads(sys.argv[3]) or np.ones((6, 8)), dtype=int)
grid = mask.shape
surface = sys.argv[4]
options = dict(grid=grid, inputs=[], oil={}, mask=None, surface=surface)
if not mask.all():
    options["mask"] = mask.tolist()
open(folder + "/build.json", "w").write(json.dumps(options))
twins = Twins(Ehd, native, folder)
python = twins.python
table = {v.name: v for v in python.table}

def give(time):
    film, velocity = motored_film(grid, time)
    if not mask.all():  # where no film is anything may stand, and each neighbour differs
        velocity = velocity * (1.0 + 0.01 * np.arange(mask.size).reshape(grid))
        if "film_symmetry" in changes:
            velocity -= odd_part(velocity)
        film[mask == 0] = 0.1
        velocity[mask == 0] = -1e3
    twins.give(dict(film_thickness=film - 4e-6, sliding_velocity=velocity))
    if surface == "bearing":
        around = 4.0 + 0.3 * velocity + 0.05 * np.arange(mask.size).reshape(grid)
        twins.give(dict(circumferential_velocity=around))

twins.give({name: table[name].number(value) for name, value in changes.items()})
is_even = "film_symmetry" in changes and grid[0] % 4 == 0  # as the film of the motion is then
expected_rows = grid[0] // 2 + 1 if is_even else grid[0]
give(0.0)
twins.start()
assert not python.fault, python.fault
assert len(python.state.film.content) == expected_rows
rng = np.random.default_rng(0)
twins.compare()
for k in range(1, 9):
    give(k * 30 * DEGREE)
    twins.advance((5 + k % 3) * DEGREE)
    twins.compare()
    seeds = rng.standard_normal((3, *grid)) * [[[1e-6]], [[1.0]], [[1.0]]]
    twins.compare_derivatives(dict(zip(python.derivative_inputs, seeds)))
touched = float(python.views["contact_area_fraction"])
emptiest = float(python.views["film_fraction"][mask == 1].min())
noted = (twins.largest[n] for n in ("flow_openings", "oil_on_bore"))
print(json.dumps([twins.shares(), twins.largest["solver_iterations"], emptiest, touched, *noted]))
"""

WINDOWS = [
    [1, 1, 0, 0, 1, 1, 1, 0],
    [1, 0, 1, 0, 1, 1, 1, 1],
    [1, 1, 0, 1, 1, 0, 1, 1],
    [0, 1, 1, 1, 1, 1, 1, 1],
    [1, 1, 1, 1, 1, 0, 0, 1],
    [1, 1, 0, 0, 1, 0, 0, 1],
]
"""Cut-outs across the first row, at both edges and single; a film cell with none beside it."""
MIRRORED = [WINDOWS[k] for k in (2, 1, 0, 1, 2, 3, 4, 3)]
HALF = dict(film_symmetry="automatic")


FED = dict(opening_supply="own", pressure_openings=2e5)
ROELANDS = dict(
    viscosity_law="vogel_1921",
    pressure_viscosity_law="roelands_1966",
    pressure_viscosity_coefficient=3e-8,
)

ROUGH = dict(
    roughness_rms=3e-6,
    flow_factors="patir_cheng_1978",
    peklenik_number_skirt=4.0,
    roughness_share_skirt=0.2,
)
COATED = dict(coating_thickness=2e-5, coating_modulus=1e9, roughness_rms=3e-6)
ON_BORE = dict(
    oil_supply="bore", initial_oil_layer=5e-6, initial_film_fraction=0.5, roughness_rms=3e-6
)
RING = dict(
    oil_supply="bore_and_ring",
    initial_oil_layer=4e-6,
    oil_splash=1e-3,
    chamfer_capacity=1e-8,
    cavitation_pressure=-5e4,
    pressure_lower_edge=-5e4,
    pressure_upper_edge=-5e4,
)


def compared(changes, mask, surface, folder):
    """Return the output of the script."""
    given = [folder, json.dumps(changes), json.dumps(mask), surface]
    return json.loads(script(SCRIPT, *given, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}))


@pytest.mark.parametrize(
    "changes, mask",
    [
        (dict(COATED | ROELANDS | ROUGH, shear_thinning_law="carreau_1972"), WINDOWS),
        (dict(RING | HALF, roughness_rms=2e-6, summit_height=1e-6, contact_law="power_fit"), None),
        (dict(ON_BORE, **ROUGH, coating_thickness=2e-5), WINDOWS),
        (dict(HALF | ON_BORE, **ROUGH), MIRRORED),
        (dict(HALF | ON_BORE, cavitation_rounding=5.0), MIRRORED),
    ],
)
def test_the_step_has_the_bits_of_the_model(changes, mask, tmp_path):
    """Eight uneven steps of a film that ruptures, with tangents; also beside cut-outs."""
    off, iterations, emptiest, touched, from_openings, on_bore = compared(
        changes, mask, "skirt", tmp_path
    )
    assert off == {}
    assert bool(on_bore) == ("oil_supply" in changes)
    assert bool(from_openings) == bool(mask)
    assert iterations > 2 and emptiest < 0.9  # cells did switch, and the film ruptured
    assert touched > 0.0 or "roughness_rms" not in changes


@pytest.mark.parametrize(
    "changes, mask",
    [
        (
            dict(
                FED,
                roughness_rms=4e-6,
                summit_height=3e-6,
                sector_angle=2.5,
                cavitation_model="gumbel",
            ),
            None,
        ),
        (dict(FED | COATED | ROELANDS, shear_thinning_law="cross_1965"), WINDOWS),
    ],
)
def test_a_bearing_has_the_bits_of_the_model(changes, mask, tmp_path):
    """Both velocities differ from cell to cell; a ring, a groove and holes, a sector."""
    off, iterations, emptiest, touched, from_openings, _ = compared(
        changes, mask, "bearing", tmp_path
    )
    assert off == {}
    assert bool(from_openings) == ("opening_supply" in changes or bool(mask))
    assert emptiest < 0.9 or "cavitation_model" in changes
    assert touched > 0.0 or "roughness_rms" not in changes
