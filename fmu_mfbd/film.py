"""The film's geometry: thickness and sliding velocity on the skirt grid from the motion, and forces back by virtual work.

Points (i, j) of the grid ride on the skirt; arrays are (n_circumferential, n_axial). theta counts from +z towards +x.
"""

from typing import NamedTuple

import numpy as np
from numba import njit


class Skirt(NamedTuple):
    """Skirt side of the film, c x a grid cells and k modes.

    Parameters
    ----------
    angle : ndarray, shape (c,)
        theta [rad].
    height : ndarray, shape (a,)
        y' above A [m].
    gap : ndarray, shape (c, a)
        Clearance and profile: film thickness in the concentric, undeformed place [m].
    radius, pin_offset : float
        Skirt radius; x of A from the skirt's axis [m].
    radial, axial : ndarray, shape (c a, k)
        Modal displacement outwards and along y at the grid points [kg^-1/2].
    """

    angle: np.ndarray
    height: np.ndarray
    gap: np.ndarray
    radius: float
    pin_offset: float
    radial: np.ndarray
    axial: np.ndarray


class Bore(NamedTuple):
    """Bore side of the film: spline coefficients of its modes on a table of heights.

    Parameters
    ----------
    lowest, spacing : float
        Height of the first coefficient's knot and distance of knots [m].
    radial, axial : ndarray, shape (s, c, k')
        Coefficients of a uniform cubic B-spline in height, at the angles of the grid, for k' modes [kg^-1/2].
    """

    lowest: float
    spacing: float
    radial: np.ndarray
    axial: np.ndarray


class FilmForces(NamedTuple):
    """Generalised forces of the film.

    Parameters
    ----------
    lateral, axial, moment : float
        On the piston along x and y, and about A [N], [N], [N m].
    piston, block : ndarray
        Modal forces [kg^-1/2 N].
    """

    lateral: float
    axial: float
    moment: float
    piston: np.ndarray
    block: np.ndarray


def bore_splines(heights, radial, axial):
    """Cubic spline through tabulated bore modes.

    Eq. (H3):  (c_(i-1) + 4 c_i + c_(i+1))/6 = value_i, second derivative zero at both ends

    Twice continuously differentiable in height, so that a moving skirt sees no kinks.

    Parameters
    ----------
    heights : ndarray, shape (s,)
        Equally spaced [m].
    radial, axial : ndarray, shape (c, s, k)

    Returns
    -------
    Bore
    """
    s, (c, _, k) = len(heights), radial.shape
    rule = np.zeros((s + 2, s + 2))
    rule[0, :3] = rule[-1, -3:] = 1.0, -2.0, 1.0
    for i in range(s):
        rule[i + 1, i:i + 3] = 1 / 6, 4 / 6, 1 / 6                                                              # Eq. (H3)
    values = [np.pad(v.transpose(1, 0, 2).reshape(s, c * k), ((1, 1), (0, 0))) for v in (radial, axial)]
    spacing = float(heights[1] - heights[0])
    return Bore(float(heights[0]) - spacing, spacing, *(np.linalg.solve(rule, v).reshape(s + 2, c, k) for v in values))


@njit(cache=True)
def spline_taps(lowest, spacing, height):
    """First knot of the window that covers `height`, and the matrices (a, window) of the spline's value and slope in it."""
    a = len(height)
    first = int(np.floor((height[0] - lowest) / spacing)) - 1
    width = int(np.floor((height[-1] - lowest) / spacing)) + 3 - first
    value, slope = np.zeros((a, width)), np.zeros((a, width))
    for j in range(a):
        x = (height[j] - lowest) / spacing
        k = int(np.floor(x))
        t, i = x - k, k - 1 - first
        value[j, i], slope[j, i] = (1 - t) ** 3 / 6, -((1 - t) ** 2) / 2
        value[j, i + 1], slope[j, i + 1] = (4 - 6 * t * t + 3 * t**3) / 6, (-12 * t + 9 * t * t) / 6
        value[j, i + 2], slope[j, i + 2] = (1 + 3 * t + 3 * t * t - 3 * t**3) / 6, (3 + 6 * t - 9 * t * t) / 6
        value[j, i + 3], slope[j, i + 3] = t**3 / 6, t * t / 2
    return first, value, slope / spacing


class Window:
    """The part of the bore that faces the skirt when A stands at a given height.

    Parameters
    ----------
    bore : Bore
    height : ndarray, shape (a,)
        Heights of the grid's rows above the crank axis now [m].
    """

    def __init__(self, bore, height):
        first, self.value, self.slope = spline_taps(bore.lowest, bore.spacing, height)
        width, (_, c, k) = self.value.shape[1], bore.radial.shape
        self.radial, self.axial = (m[first:first + width].reshape(width * c, k) for m in (bore.radial, bore.axial))

    def read(self, table, coordinates):
        """Modal sum on the window's knots, (knots, c)."""
        return (table @ coordinates).reshape(self.value.shape[1], -1)

    def spread(self, table, force):
        """Modal force of grid forces (c, a): the transpose of reading."""
        return (self.value.T @ force.T).ravel() @ table


class Film:
    """Film thickness and sliding velocity as functions of the motion, and the generalised forces that belong to them.

    Eq. (H1):  h = gap(theta, y') - (x_A - angle y') sin theta - u_r(skirt) + w_r(bore at Y_0(crank angle) + y')
    Eq. (H2):  v = Y_A' + angle' (R sin theta - pin offset) + u_y'(skirt) - w_y'(bore)

    Linear in the small motions. The bore is read at the height that A has when x_A = 0: the true one differs by less than
    x_A r/L, micrometres on a field that varies over millimetres.

    Parameters
    ----------
    skirt : Skirt
    bore : Bore
    """

    def __init__(self, skirt, bore):
        self.skirt, self.bore = skirt, bore
        self.shape = skirt.gap.shape
        self.sine = np.sin(skirt.angle)[:, None]
        self.arm = skirt.radius * self.sine - skirt.pin_offset

    def window(self, height_of_A):
        """The facing part of the bore, A at the given height [m]."""
        return Window(self.bore, height_of_A + self.skirt.height)

    def thickness(self, window, lateral, angle, piston, block):
        """Film thickness (c, a) [m] at x_A [m], rocking angle [rad] and modal coordinates."""
        return self.skirt.gap + self.opening(window, lateral, angle, piston, block)                                                                         # Eq. (H1)

    def opening(self, window, lateral, angle, piston, block):
        """Linear part of the film thickness (c, a) [m], or its rate [m/s] from the coordinates' rates."""
        rigid = (angle * self.skirt.height - lateral) * self.sine
        return rigid - (self.skirt.radial @ piston).reshape(self.shape) + (window.value @ window.read(window.radial, block)).T

    def opening_rate(self, window, height_rate, lateral_rate, angle_rate, piston_rate, block, block_rate):
        """Rate of film thickness at the moving skirt points (c, a) [m/s]; height_rate is that of A [m/s]."""
        steady = self.opening(window, lateral_rate, angle_rate, piston_rate, block_rate)
        return steady + height_rate * (window.slope @ window.read(window.radial, block)).T

    def sliding(self, window, height_rate, angle_rate, piston_rate, block_rate):
        """Sliding velocity (c, a) [m/s]: axial velocity of the skirt minus the bore's."""
        rigid = height_rate + angle_rate * self.arm
        return rigid + (self.skirt.axial @ piston_rate).reshape(self.shape) - (window.value @ window.read(window.axial, block_rate)).T  # (H2)

    def generalised(self, window, pressure_force, friction_force):
        """Forces on the coordinates by virtual work: Q_k = sum F dh/dq_k + sum f dv/dq'_k.

        Parameters
        ----------
        window : Window
        pressure_force, friction_force : ndarray, shape (c, a)
            [N]: pushing the surfaces apart; along y on the skirt.

        Returns
        -------
        FilmForces
        """
        around = pressure_force.sum(axis=1)
        lateral = -(self.sine[:, 0] @ around)
        moment = self.sine[:, 0] @ (pressure_force @ self.skirt.height) + self.arm[:, 0] @ friction_force.sum(axis=1)
        piston = friction_force.ravel() @ self.skirt.axial - pressure_force.ravel() @ self.skirt.radial
        block = window.spread(window.radial, pressure_force) - window.spread(window.axial, friction_force)
        return FilmForces(float(lateral), float(friction_force.sum()), float(moment), piston, block)

    def lift(self, window, pressure_force, block):
        """Force on the piston along y from pressure on a bore that is not straight [N]: sum F dh/dY."""
        return float(np.sum(pressure_force * (window.slope @ window.read(window.radial, block)).T))
