"""Forces of a cylinder on its block, the sum of bore, deck and main bearings.

Gas acts equally on crown and deck, film and rings equally on skirt and bore. The drive of the crank
is outside the block and applies a torque only. The sum is therefore the inertia of moving parts.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..mechanism.floating_frame import TURN, X, Y
from ..mechanism.piston_motion import Load


class BlockForce(NamedTuple):
    """Forces on the block in its axes, declared as `drive.Scalars`."""

    force_on_block_x: Annotated[float, "N", 1e3]
    """Force of bore, deck and main bearings on the block along x."""
    force_on_block_y: Annotated[float, "N", 1e3]
    """Force of bore, deck and main bearings on the block along y."""
    moment_on_block: Annotated[float, "N.m", 1e2]
    """Moment of bore, deck and friction of the main bearing on the block about the crank axis."""
    main_bearing_force_x: Annotated[float, "N", 1e3]
    """Force of the crank on its main bearings along x."""
    main_bearing_force_y: Annotated[float, "N", 1e3]
    """Force of the crank on its main bearings along y."""


NO_FORCE = BlockForce(0.0, 0.0, 0.0, 0.0, 0.0)


@compilable
def block_force(load: Load, from_walls: np.ndarray, on_block: np.ndarray) -> BlockForce:
    """Return the forces on the block, or their change.

    Eq. (D24):  main bearings:  F_b = F + F_l
    Eq. (D25):  all:  F, M of Eq. (D63)
               F_l the load on the piston, film, gas and rings, and of laws and slopes of the bore

    Parameters
    ----------
    load : Load
        On the piston.
    from_walls : ndarray, shape (2,)
        As of `laws.from_block`, and of pressure on the slopes of the bore (Eq. (H24)) [N].
    on_block : ndarray, shape (3,)
        F [N] and M [N m], as of `ChainForces`.

    Returns
    -------
    BlockForce
    """
    # Eqs. (D24), (D25)
    x, y = on_block[X], on_block[Y]
    bearing_x, bearing_y = x + load.lateral + from_walls[X], y + load.axial + from_walls[Y]
    return BlockForce(x, y, on_block[TURN], bearing_x, bearing_y)
