"""Bore whose deflection comes from another participant, as a field on a fixed grid.

It is read under the moving skirt like the bore's own modes. Forces return to that grid by virtual
work.

Both directions are one linear map and its transpose. So the forces on both grids do the same work,
to round-off. The deflection is radial. The bore also moves along its axis, by some mm/s compared
with the piston's m/s. The film ignores this motion, and friction does not drive it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..geometry.film import FilmSurface, by_rows, knot_rule, on_knots, on_rows
from ..geometry.grid import cell_centres
from ..geometry.surfaces import surface_at
from .gas_on_bore import BoreWall, WallPressures, bore_wall, wall_forces
from .skirt_films import window_of
from .system import BodySystem


class OutsideBore(NamedTuple):
    """Interpolation of a field (n, s) on the bore, at n angles as of `cell_centres` and s heights.

    Parameters
    ----------
    around : ndarray, shape (c, n)
        Matrix A_theta from its angles to those of the film grid [-].
    along : ndarray, shape (s + 2, s)
        Matrix A_y from its heights to spline coefficients [-].
    wall : BoreWall
        Loads of gas on the bore. Every height is a mode with a deflection of 1 m.
    """

    around: np.ndarray
    along: np.ndarray
    wall: BoreWall

    def knots(self, field: np.ndarray) -> np.ndarray:
        """Return the spline coefficients at the angles of the film grid, (s + 2, c).

        Eq. (H20):  w(theta_i, y) = sum_k b_k(y) (A_y W^T A_theta^T)_ki    b_k of Eq. (H5)
        """
        return np.ascontiguousarray(self.along @ field.T @ self.around.T)  # Eq. (H20)

    def transpose(self, on_all_knots: np.ndarray) -> np.ndarray:
        """Return the forces on the bore's grid, (n, s), from those on all knots, (s + 2, c) [N].

        Eq. (H21):  F_W = A_theta^T f^T A_y,   the transpose of Eq. (H20)
        """
        return self.around.T @ on_all_knots.T @ self.along  # Eq. (H21)


def outside_bore(
    shape: tuple[int, int], film_angles: int, heights: np.ndarray, radius: float, rings: BoreWall
) -> OutsideBore:
    """Return the interpolation of a field on the bore.

    Parameters
    ----------
    shape : (int, int)
        n angles and s heights of the field.
    film_angles : int
        c of the film grid.
    heights : ndarray, shape (s,)
        Equally spaced, above the crank axis [m].
    radius : float
        Radius of the bore [m].
    rings : BoreWall
        Heights of the rings and the share of the land.
    """
    around, along = shape
    one_each = np.eye(along)[None]
    return OutsideBore(
        around=periodic_rule(around, film_angles),
        along=knot_rule(along),
        wall=bore_wall(
            heights, one_each, radius, rings.top_ring, rings.second_ring, rings.land_share
        ),
    )


def periodic_rule(angles: int, film_angles: int) -> np.ndarray:
    """Return the matrix from values at `angles` to those at `film_angles`, (film_angles, angles).

    Both are numbers of angles as of `cell_centres`. The matrix is that of the periodic cubic spline
    through all values.

    Eq. (H22):  (c_(i-1) + 4 c_i + c_(i+1))/6 = value_i,   i modulo n;   read by Eq. (H5)
    """
    from scipy.interpolate import CubicSpline  # slow to import, and few bores are from outside

    at, _ = cell_centres(angles, 1, 0.0, 1.0)
    to, _ = cell_centres(film_angles, 1, 0.0, 1.0)
    values = np.eye(angles)[np.arange(angles + 1) % angles]
    closed = np.append(at, at[0] + 2 * np.pi)
    return CubicSpline(closed, values, bc_type="periodic")(to)  # Eq. (H22)


def deflected(system: BodySystem, bore: OutsideBore, field: np.ndarray) -> BodySystem:
    """Return the system with its bore widened further by a field (n, s) [m]."""
    surfaces = system.surfaces.copy()
    widening = surface_at(surfaces, 0).bore.shape  # of the one bore that all share
    widening += bore.knots(field)
    return system._replace(surfaces=surfaces)


def opening_changes(
    bore: OutsideBore, surfaces: Sequence[FilmSurface], guide_height: float, field: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the change of thickness and slope of all films with a field (n, s) on the bore.

    Both are stacked, (cells,) [m], [-]. The bore is read at the height `guide_height` [m].
    """
    knots = bore.knots(field)
    parts = []
    for surface in surfaces:
        window = window_of(surface, guide_height)
        below = knots[window.first : window.first + window.knots]
        weights = window.value, window.slope
        parts.append([by_rows(on_rows(window, one, below)).ravel() for one in weights])
    thickness, slope = (np.concatenate(one) for one in zip(*parts))
    return thickness, slope


def film_on_bore(
    bore: OutsideBore,
    surfaces: Sequence[FilmSurface],
    guide_height: float,
    pressure_force: np.ndarray,
) -> np.ndarray:
    """Return the radial forces of all films on the bore's grid, (n, s) [N], outwards.

    Parameters
    ----------
    bore : OutsideBore
    surfaces : sequence of FilmSurface
    guide_height : float
        Height at which the bore is read [m].
    pressure_force : ndarray, shape (cells,)
        Pressure forces on the cells of all surfaces, stacked [N].
    """
    angles, knots = len(bore.around), len(bore.along)
    on_all = np.zeros((knots, angles))
    begin = 0
    for surface in surfaces:
        window = window_of(surface, guide_height)
        size = surface.skirt.gap.size
        push = pressure_force[begin : begin + size].reshape(surface.skirt.gap.shape)
        on_all[window.first : window.first + window.knots] += on_knots(
            window, window.value, by_rows(push)
        )
        begin += size
    return bore.transpose(on_all)


def gas_on_wall(bore: OutsideBore, guide_height: float, pressures: WallPressures) -> np.ndarray:
    """Return the radial forces of gas on the bore's grid, (n, s) [N], constant around.

    Eq. (H23):  F_ij = f_j/n,   f_j of Eq. (D18) for a deflection of height j alone
    """
    angles = bore.around.shape[1]
    by_height = wall_forces(bore.wall, guide_height, pressures)
    return np.tile(by_height / angles, (angles, 1))  # Eq. (H23)
