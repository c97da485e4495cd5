"""A moving cylinder block, the carrier of the mechanism, and the accelerations that it adds.

All coordinates of the mechanism are relative to the block. The block moves in the plane of the
cylinder: its acceleration at the crank axis, its angular acceleration and velocity.
"""

from typing import NamedTuple

from ...master.fmi.compiled import compilable, packed


class BlockMotion(NamedTuple):
    """Motion of the block in the plane of the cylinder, in the block's axes.

    Parameters
    ----------
    ax, ay : float
        Acceleration of the crank axis [m/s2].
    alpha, w : float
        Angular acceleration [rad/s2] and velocity [rad/s] about +z.
    """

    ax: float
    ay: float
    alpha: float
    w: float


_, block_motion_from = packed(BlockMotion)

FIXED = BlockMotion(0.0, 0.0, 0.0, 0.0)
"""A block that does not move."""


@compilable
def transport(
    carrier: BlockMotion, x: float, y: float, vx: float, vy: float
) -> tuple[float, float]:
    """Return the part of a point's acceleration by the motion of the block.

    The point is at (x, y) from the crank axis and moves in the block at (vx, vy).

    Eq. (K14):  a_O + alpha Z r - w^2 r + 2 w Z v        Z = [0, -1; 1, 0]

    >>> transport(FIXED._replace(w=10.0), 0.1, 0.0, 0.0, 0.0)
    (-10.0, 0.0)
    """
    w = carrier.w
    # Eq. (K14)
    return (
        carrier.ax - carrier.alpha * y - w * w * x - 2 * w * vy,
        carrier.ay + carrier.alpha * x - w * w * y + 2 * w * vx,
    )
