"""A piston on a tied pin as a chain, without a block, and the forces in it."""

import numpy as np

from piston_cosim.fmu_mfbd.dynamics.pin_films import forces_of
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED, BlockMotion
from piston_cosim.fmu_mfbd.mechanism.chain import Chain, Loads
from piston_cosim.fmu_mfbd.mechanism.cylinder import CylinderParts, cylinder_chain
from piston_cosim.fmu_mfbd.mechanism.equations import ChainForces, chain_forces
from piston_cosim.fmu_mfbd.mechanism.floating_frame import FlexibleBody
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.loads import loads_at
from piston_cosim.fmu_mfbd.mechanism.modal_damping import ModalSprings
from piston_cosim.fmu_mfbd.mechanism.motion import chain_motion
from piston_cosim.fmu_mfbd.mechanism.piston_motion import Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion, Mechanism

PISTON, SKIRT, GAS = 2, 0, 1
"""Number of the body, and numbers of the force elements on it."""
NONE = np.zeros(0)


def tied_pin(piston: FlexibleBody, mechanism: Mechanism, unbalance: float) -> Chain:
    """Return the chain of a cylinder with a tied pin; `unbalance` of the crank [kg m]."""
    return cylinder_chain(tied_parts(piston, mechanism, unbalance))


def tied_parts(piston: FlexibleBody, mechanism: Mechanism, unbalance: float) -> CylinderParts:
    """Return the parts of this chain."""
    return CylinderParts(
        piston=piston,
        moving=len(piston.stiffness),
        mechanism=mechanism,
        spin_inertia=0.0,
        crank_mass=0.0,
        unbalance=unbalance,
        floats=False,
        big_end=False,
        main_bearing=False,
        springs=ModalSprings(NONE, NONE),
        block_modes=0,
        block_static=0,
        shapes=0,
        big_end_modes=0,
        main_bearing_modes=0,
    )


def loads_of(chain: Chain, load: Load, now: Motion, crank: CrankMotion) -> Loads:
    """Return the loads of all elements."""
    at = chain_motion(chain.joints, now, crank)
    return loads_at(chain, forces_of(chain, load), at, now)


def tied_forces(
    chain: Chain, load: Load, now: Motion, crank: CrankMotion, carrier: BlockMotion = FIXED
) -> ChainForces:
    """Return all forces in the chain under a load of its piston and a motion of the block."""
    return chain_forces(chain, loads_of(chain, load, now, crank), now, crank, carrier)
