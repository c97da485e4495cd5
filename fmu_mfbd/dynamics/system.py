"""Bodies, mechanism and films of the skirt together, and what acts on them besides the films."""

from typing import NamedTuple

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Vector
from ..geometry.pin_shapes import AxisShapes
from ..mechanism.carrier import FIXED, BlockMotion
from ..mechanism.chain import Chain
from ..mechanism.floating_frame import ArrowMatrix, Y
from ..mechanism.generalised_alpha import Coefficients, Motion
from ..mechanism.impact import Inertia
from ..mechanism.slider_crank import CrankMotion, Mechanism
from .gas_on_bore import BoreWall, WallPressures


class BodySystem(NamedTuple):
    """All bodies of a cylinder and the geometry of all films.

    Fields of all films of the skirt are stacked: the cells of the first, (c, a) in C order, then
    those of the second. Fields of pin and crank are stacked in the same way.

    Parameters
    ----------
    chain : Chain
        Chain of `mechanism.cylinder`.
    kinds : ndarray, shape (n,)
        Time integrator of each coordinate, as of `bdf2.reach_of`.
    inertia, with_rod : ArrowMatrix
        `cylinder.motion_across` without and with the rod.
    shapes : AxisShapes
        Shapes of the pin.
    mechanism : Mechanism
    surfaces, pin_surfaces : ndarray
        Films of the skirt, and of pin and crank, each a block of `geometry.surfaces`.
    pin_offset : float
        x of A from the skirt's axis [m].
    gas_force : ndarray, shape (k,)
        Modal force of a unit gas force on the crown, of all modes of the piston [kg^-1/2].
    wall : BoreWall
        With all modes of the block.
    resolution : float
        r of Eq. (N12), the displacement in a step that impacts do not resolve [m].
    """

    chain: Chain
    kinds: Vector
    inertia: ArrowMatrix
    with_rod: ArrowMatrix
    shapes: AxisShapes
    mechanism: Mechanism
    surfaces: Vector
    pin_surfaces: Vector
    pin_offset: float
    gas_force: Vector
    wall: BoreWall
    resolution: float


@compilable
def skirt_modes(system: BodySystem) -> int:
    """Return the number of modes of piston and block."""
    return len(system.gas_force) + system.wall.above.shape[1]


@compilable
def rigid_piston(system: BodySystem) -> Inertia:
    """Return the inertia of piston and pin."""
    bodies = system.chain.bodies
    mass = bodies.mass[-1] + system.mechanism.pin_mass
    return Inertia(mass, bodies.S[-1, Y], bodies.I0[-1])


class RingForce(NamedTuple):
    """Actions of the rings on the piston.

    lateral : float
        Along x, towards the thrust side [N].
    axial : float
        Along y, towards the head, on the bore's axis [N].
    moment : float
        About A and +z, in addition to that of `axial` [N m].
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
        Pressures of the gas on the bore.
    carrier : BlockMotion
        Motion of the block.
    """

    gas: float
    rings: RingForce
    wall: WallPressures
    carrier: BlockMotion = FIXED


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
