"""Modal forces of gas on the bore, above the top ring and between the rings.

The pressure acts on the whole wall above the middle of a ring and is uniform around. The force of
the rings on the wall is neglected. The height of a ring follows from the crank alone, as if
x_A = 0. A displacement of 1 um changes it by 0.3 um. The force on the head goes through its studs
to the clamped part of the block, and the deck carries none of it.

On the piston, a uniform pressure in a land has no resultant. It pushes both rings, and so the
piston, along the axis of the bore with equal and opposite forces (Eq. (D8)). An uneven pressure
belongs in `ring_side_force` and `ring_moment`.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled


class WallPressures(NamedTuple):
    """Gauge pressures on the bore above the top ring and between the rings [Pa].

    The second one excludes the share in `BoreWall`.
    """

    chamber: float
    land: float


class BoreWall(NamedTuple):
    """Data of a bore with k modes for the forces of gas.

    Parameters
    ----------
    lowest, spacing : float
        First height of the table above the crank axis, and its step [m].
    above, at : ndarray, shape (s, k)
        W of Eq. (D17) at the heights of the table, and its slope [kg^-1/2 m2], [kg^-1/2 m].
    top_ring, second_ring : float
        Heights above A [m].
    land_share : float
        Share of the chamber's pressure that acts between the rings [-].
    """

    lowest: float
    spacing: float
    above: Annotated[np.ndarray, "heights, k"]
    at: Annotated[np.ndarray, "heights, k"]
    top_ring: float
    second_ring: float
    land_share: float = 0.0


def bore_wall(
    heights: np.ndarray,
    radial: np.ndarray,
    radius: float,
    top_ring: float,
    second_ring: float,
    land_share: float = 0.0,
) -> BoreWall:
    """Return the data of the bore's modes that the gas forces need.

    Eq. (D17):  W_k(y) = int_y^top int_0^2pi phi_k R dtheta dy

    by the mean over the angles of the table and its natural cubic spline in height.

    Parameters
    ----------
    heights : ndarray, shape (s,)
        Equally spaced, above the crank axis [m].
    radial : ndarray, shape (c, s, k)
        phi, outwards [kg^-1/2].
    radius : float
        R [m].
    top_ring, second_ring : float
        Heights above A [m]; no gas on the wall where `top_ring` is 0.
    land_share : float
        As of `BoreWall`.
    """
    around = 2 * np.pi * radius * radial.mean(axis=0)
    below = np.zeros_like(around)
    if top_ring > 0.0:
        from scipy.interpolate import CubicSpline  # slow to import, and few engines have gas there

        below = CubicSpline(heights, around, bc_type="natural").antiderivative()(heights)
    return BoreWall(
        lowest=float(heights[0]),
        spacing=float(heights[1] - heights[0]),
        above=np.ascontiguousarray(below[-1] - below),  # Eq. (D17)
        at=np.ascontiguousarray(-around),
        top_ring=top_ring,
        second_ring=second_ring,
        land_share=land_share,
    )


@compiled
def wall_forces(wall: BoreWall, height_of_A: float, pressures: WallPressures) -> np.ndarray:
    """Return the modal forces of gas on the bore, (k,) [kg^-1/2 N].

    Eq. (D18):  f_k = p_chamber W_k(Y + y_1) + p (W_k(Y + y_2) - W_k(Y + y_1)),
                p = p_land + share p_chamber

    Parameters
    ----------
    wall : BoreWall
    height_of_A : float
        Y [m]; y_1, y_2 the rings' heights above it.
    pressures : WallPressures
    """
    out = np.zeros(wall.above.shape[1])
    if wall.top_ring == 0.0:
        return out
    # Eq. (D18)
    land = pressures.land + wall.land_share * pressures.chamber
    _add_above(out, wall, height_of_A + wall.top_ring, pressures.chamber - land)
    _add_above(out, wall, height_of_A + wall.second_ring, land)
    return out


@compiled
def _add_above(out, wall, height, pressure):
    """Add a pressure's forces on the wall above a height: cubic between the table's heights."""
    if pressure == 0.0:
        return
    last = len(wall.above) - 1
    place = (height - wall.lowest) / wall.spacing
    place = min(max(place, 0.0), float(last))
    i = min(int(place), last - 1)
    t = place - i
    rest = 1 - t
    for k in range(len(out)):
        out[k] += pressure * (
            rest * rest * (1 + 2 * t) * wall.above[i, k]
            + t * t * (3 - 2 * t) * wall.above[i + 1, k]
            + t * rest * rest * wall.spacing * wall.at[i, k]
            - t * t * rest * wall.spacing * wall.at[i + 1, k]
        )
