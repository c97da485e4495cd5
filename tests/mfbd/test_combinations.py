"""Combinations of options: a floating pin with everything that a tied pin has, and the reverse.

Each combination has a limit that another test covers, and derivatives that central differences
confirm.
"""

import numpy as np

from piston_cosim.fmu_mfbd.dynamics.gas_on_bore import WallPressures, wall_forces
from piston_cosim.fmu_mfbd.dynamics.model import stacked
from piston_cosim.fmu_mfbd.dynamics.skirt_films import forces_by_film, together

from .pin_models import (
    BLOCK_MODES,
    CRITICAL,
    block_model,
    flexible_block,
    floating_model,
    rough_inputs,
    stiff_is_rigid,
)

# ---- a flexible block


def test_a_stiff_block_around_a_floating_pin_is_the_rigid_one():
    stiff_is_rigid(floating_model(), block_model, ["skirt.film_thickness"])


def test_a_block_around_a_floating_pin_yields_by_its_springs():
    """Each mode of the bore ends where its spring balances the forces of films and gas.

    The crank is at rest and damping is critical: in 600 us the start decays to 0.4 %.
    """
    model = block_model(parameters=CRITICAL)
    inputs = rough_inputs(model, 3, speed=0.0)
    state, _ = model.start(0.3, 0.0, 0.0, inputs)
    for _ in range(600):
        state, out = model.advance(state, inputs, 1e-6)
    guided = model._last.guided
    force = together(forces_by_film(model.system, guided, stacked(inputs).skirt)).block
    force = force + wall_forces(model.system.wall, guided, WallPressures(inputs.gas_pressure, 0.0))
    wanted = force / flexible_block().omega ** 2
    assert len(wanted) == BLOCK_MODES
    np.testing.assert_allclose(out["modal_coordinate"], wanted, rtol=2e-2)
    stored = float(force @ wanted) / 2
    np.testing.assert_allclose(out["elastic_energy"], stored, rtol=2e-2)
