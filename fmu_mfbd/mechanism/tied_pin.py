"""Crank, rod and piston on a tied pin as a chain of bodies, and the loads on it."""

import numpy as np

from ...master.fmi.compiled import compilable
from ..dynamics.floating_frame import FlexibleBody, X, Y
from ..dynamics.generalised_alpha import Motion
from ..dynamics.pin_friction import put_pin_friction
from ..dynamics.piston_motion import LATERAL, ROCKING, Load
from ..dynamics.slider_crank import CrankMotion, Mechanism
from .chain import BLOCK, NONE, Bodies, Chain, Elements, Joints, Loads
from .equations import ChainForces, chain_forces

CRANK, ROD, PISTON = range(3)
"""Numbers of the bodies."""

SKIRT, GAS = range(2)
"""Numbers of the force elements: films and rings on the skirt, and gas on the axis of the bore."""


@compilable
def tied_pin(piston: FlexibleBody, mechanism: Mechanism, crank_unbalance: float) -> Chain:
    """Return the chain of a crank, a rod with its pin, and a piston.

    The coordinates are [x_A, rocking angle, modal coordinates]. The crank has no mass, which counts
    among that of the block.

    Parameters
    ----------
    piston : FlexibleBody
        About A.
    mechanism : Mechanism
    crank_unbalance : float
        Mass times distance from the axis towards the crank pin [kg m].

    Returns
    -------
    Chain
    """
    length, mass, k = mechanism.rod_length, mechanism.rod_mass, len(piston.stiffness)
    centre = mechanism.rod_centre * length
    S = np.zeros((3, 2))
    S[CRANK, Y] = crank_unbalance
    S[ROD, Y] = mass * centre + mechanism.pin_mass * length
    S[PISTON, X], S[PISTON, Y] = piston.S[X], piston.S[Y]
    inertia = mechanism.rod_inertia + mass * centre**2 + mechanism.pin_mass * length**2
    coupling = np.empty((2, k, k))
    for i in range(k):
        for j in range(k):
            coupling[0, i, j] = piston.B[i, j]
            coupling[1, i, j] = piston.G[i, j]
    marker, tip = np.zeros((3, 2)), np.zeros((3, 2))
    marker[ROD, Y], marker[PISTON, Y] = mechanism.crank_radius, length
    tip[ROD, LATERAL] = 1.0
    friction = np.zeros((3, 3))
    put_pin_friction(friction[PISTON], mechanism.friction)
    return Chain(
        Bodies(
            mass=np.array((0.0, mass + mechanism.pin_mass, piston.mass)),
            I0=np.array((0.0, inertia, piston.I0)),
            S=S,
            first_mode=np.array((0, 0, 0, k)),
            first_entry=np.array((0, 0, 0, 2 * k * k)),
            T=piston.T,
            b=piston.b,
            g=piston.g,
            coupling=coupling.reshape(2 * k * k),
            stiffness=piston.stiffness,
            damping=piston.damping,
        ),
        Joints(
            parent=np.array((BLOCK, CRANK, ROD)),
            play=np.array((NONE, NONE, NONE)),
            angle=np.array((NONE, NONE, ROCKING)),
            marker=marker,
            sign=np.ones(3),
            driven=np.array((1.0, 0.0, 0.0)),
            rod_length=np.array((0.0, length, 0.0)),
            offset=np.array((0.0, mechanism.offset, 0.0)),
            tip=tip,
            friction=friction,
        ),
        Elements(
            acts=np.full(2, PISTON),
            reacts=np.full(2, BLOCK),
            carrier=np.array((PISTON, BLOCK)),
            axes=np.full(2, BLOCK),
            play=np.full(2, NONE),
            mode=np.zeros(2, np.int64),
            modes=np.zeros(2, np.int64),
            shape=np.zeros(2, np.int64),
            shapes=np.zeros(2, np.int64),
            marker=np.zeros((2, 2)),
            point=np.array(((0.0, 0.0), (mechanism.offset, 0.0))),
            at_point=np.array((0.0, 1.0)),
        ),
        NONE,
        np.zeros((3, 3, 3)),
    )


@compilable
def loads_of(load: Load) -> Loads:
    """Return the loads of all force elements and modes, or their change."""
    wrench = np.zeros((2, 4))
    wrench[SKIRT, X] = load.lateral
    wrench[SKIRT, Y] = load.axial + load.guided
    wrench[SKIRT, 2] = load.moment
    wrench[GAS, Y] = -load.guided
    return Loads(wrench, load.modal, np.zeros(0), np.zeros((2, 0, 2)))


@compilable
def tied_forces(chain: Chain, load: Load, now: Motion, crank: CrankMotion) -> ChainForces:
    """Return all forces in the chain under a load of its piston."""
    return chain_forces(chain, loads_of(load), now, crank, load.carrier)
