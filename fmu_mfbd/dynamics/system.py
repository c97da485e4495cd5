"""Bodies, mechanism and films of the skirt together, and what acts on them besides the films."""

from typing import NamedTuple

from ..geometry.arrays import Vector
from ..mechanism.chain import Chain
from .carrier import FIXED, Carrier
from .floating_frame import FlexibleBody
from .gas_on_bore import BoreWall, WallPressures
from .generalised_alpha import Coefficients, Motion
from .modal_damping import ModalSprings
from .quasi_static import StaticModes
from .slider_crank import CrankMotion, Mechanism


class BodySystem(NamedTuple):
    """Both bodies, the mechanism and the geometry of all films.

    `chain` are the bodies on a tied pin (`mechanism.tied_pin`).

    Of each body, the modes that move and, after them, those that follow statically. gas_force (k +
    s,) is the modal force of a unit gas force on the crown [kg^-1/2], pin_offset x of A from the
    skirt's axis [m], resolution that of impacts (Eq. (N12)) [m]. All film surfaces are one block
    (`geometry.surfaces`). Fields of all of them are stacked: the cells of the first, (c, a) in C
    order, then those of the second.
    """

    piston: FlexibleBody
    piston_static: StaticModes
    block: ModalSprings
    block_static: StaticModes
    mechanism: Mechanism
    chain: Chain
    surfaces: Vector
    pin_offset: float
    gas_force: Vector
    wall: BoreWall
    resolution: float


class RingForce(NamedTuple):
    """Actions of the rings on the piston.

    lateral : float
        Along x, towards the thrust side [N].
    axial : float
        Along y, towards the head, on the bore's axis [N].
    moment : float
        About A, about +z, beside that of `axial` [N m].
    """

    lateral: float
    axial: float
    moment: float


NO_RINGS = RingForce(0.0, 0.0, 0.0)


class OtherForces(NamedTuple):
    """Forces on the piston other than those of film and pin.

    gas : float
        Along -y on the crown [N].
    rings : RingForce
    wall : WallPressures
        Of gas on the bore.
    carrier : Carrier
        Motion of the block.
    """

    gas: float
    rings: RingForce
    wall: WallPressures
    carrier: Carrier = FIXED


class StepProblem(NamedTuple):
    """Data that a step is solved with, n coordinates.

    Parameters
    ----------
    coefficients : Coefficients
    before : Motion
        At the start of the step.
    auxiliary : ndarray, shape (n,)
        Auxiliary acceleration at the start of the step.
    mean_velocity : ndarray, shape (n,)
        Over the last step.
    crank : CrankMotion
        At its end.
    others : OtherForces
        At its end.
    """

    coefficients: Coefficients
    before: Motion
    auxiliary: Vector
    mean_velocity: Vector
    crank: CrankMotion
    others: OtherForces
