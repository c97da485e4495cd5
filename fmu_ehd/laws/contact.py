"""Asperity contact of a cell: the mean over the cell, in which the gap varies.

Contact decreases to zero within a fraction of the roughness, and the profile of a skirt changes
the gap by as much within one cell. The gap inside a cell is a parabola in both directions. It
contains the film thickness of the cell and of its neighbours. x and y are in cells from the centre:

Eq. (A7):  h(x, y) = h_c + x (h_e - h_w)/2 + x^2 (h_e - 2 h_c + h_w)/2
                         + y (h_n - h_s)/2 + y^2 (h_n - 2 h_c + h_s)/2
Eq. (A8):  p = sum_q w_q p(h(x_q, y_q)),   dp/dh_k = sum_q w_q p'(h(x_q, y_q)) dh(x_q, y_q)/dh_k

at Gauss points q with weights w_q; area fraction, boundary stress and energy likewise. Ovality and
barrel are parabolas within a cell. Beyond an edge, an opening or a step of the profile the gap
continues linearly, h_n = 2 h_c - h_s. Between two of them it is constant. There is a step between
two cells if the gap changes by at least a quarter of the roughness, and by four times its changes
before and behind. The weight w of a step is 1 there, 0 where the gap is smooth, and once
differentiable between:

Eq. (A12):  w_i = S(8 |J_i|/sigma - 1) S(2 - 4 J_{i-1}/J_i) S(2 - 4 J_{i+1}/J_i)
            J_i = h_{i+1} - h_i,   S(x) = x^2 (3 - 2 x), 0 below 0 and 1 above 1
Eq. (A15):  d_n = (1 - w_n) D_n - w_n (1 - w_s) D_s,   d_s likewise,   D_n = h_n - h_c

d replaces D in Eq. (A7); beyond an edge and an opening w = 1. The changes J of a parabola grow
linearly, so none of them is a step, and neither are those of a wave that is longer than 6 cells.
Extrema of a smooth gap remain parabolas, because contact happens there. A step of a quarter of the
roughness changes the contact by less than 1 %, so w may rise gradually below it.
Steps belong to the profile, so they are located at the start of a run. Bending bodies cause no
steps. If each iteration located them, contact would depend on more cells than its neighbours.

The pressure of a cell deflects its coating alone, so the deflection shifts the whole cell.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..common.grid import CENTRE, EAST, NORTH, SOUTH, WEST, Array, Cells, Flags, row_at
from .asperity import TABLE_END, ContactConstants, point_contact

# Eq. (A12): J over the roughness, and adjacent J over that of the step, of weights 0 and 1
SMOOTH_JUMP, STEP_JUMP = 0.125, 0.25
SMOOTH_RATIO, STEP_RATIO = 0.5, 0.25
OPPOSITE = (CENTRE, NORTH, SOUTH, EAST, WEST)

# Gauss-Legendre along a cell of length 1 about its centre: contact that fades by exp(6) from the
# middle of a cell to its end is integrated to 1 %, ovality on 40 cells to 0.1 %
POINTS, WEIGHTS = (0.5 * each for each in np.polynomial.legendre.leggauss(4))


class Contact(NamedTuple):
    """Contact of each cell, means over it.

    pressure : p [Pa]; area_fraction : A_c/A [-], up to 1; shear_stress : tau_b [Pa]; each ndarray
    of shape (n_c, n_a);
    pressure_slope, shear_stress_slope : ndarray, shape (5, n_c, n_a), their derivatives to the
    film thickness of the cell and of its neighbours, `grid` [Pa/m];
    energy : e [J/m2], ndarray of shape (n_c, n_a).
    """

    pressure: Array
    area_fraction: Array
    shear_stress: Array
    pressure_slope: Array
    shear_stress_slope: Array
    energy: Array


@compiled(forceinline=True)
def neighbour(k, i, j, n_c, n_a):
    """Return the cell of entry k of the stencil of cell (i, j) of a ring, or (i, j) at an edge."""
    if k == WEST:
        return (i - 1) % n_c, j
    if k == EAST:
        return (i + 1) % n_c, j
    if k == SOUTH:
        return i, max(j - 1, 0)
    if k == NORTH:
        return i, min(j + 1, n_a - 1)
    return i, j


@compiled(forceinline=True)
def _shares(x, before, after):
    """Return the shares of both neighbours in the gap at x of a cell, Eqs. (A7), (A15).

    `before` and `after` are the weights of the steps to them. The rest is the share of the cell.
    """
    near = 0.5 * x * (x - 1.0)
    far = 0.5 * x * (x + 1.0)
    # Eq. (A15)
    return (1.0 - before) * (near - far * after), (1.0 - after) * (far - near * before)


@compiled(forceinline=True)
def _cell_towards(k, steps, i, j, open_cells, cells):
    """Return the cell so many steps from cell (i, j) towards entry k of its stencil.

    Its row is -1 if there is no film.
    """
    n_c, n_a = open_cells.shape
    if k == SOUTH or k == NORTH:
        b = j - steps if k == SOUTH else j + steps
        return (i if 0 <= b < n_a and not open_cells[i, b] else -1), b
    a = row_at(cells, i - steps if k == WEST else i + steps, n_c)
    return (-1 if n_c == 1 or a < 0 or open_cells[a, j] else a), j


@compiled(forceinline=True)
def _smooth(value, zero, one):
    """Return S of Eq. (A12), which is 0 at `zero` and 1 at `one`."""
    x = min(max((value - zero) / (one - zero), 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@compiled(forceinline=True)
def _step_weight(before, jump, after, roughness_rms):
    """Return the weight of a step of the gap by `jump`, Eq. (A12)."""
    weight = _smooth(abs(jump) / roughness_rms, SMOOTH_JUMP, STEP_JUMP)
    if weight > 0.0:
        weight *= _smooth(before / jump, SMOOTH_RATIO, STEP_RATIO)
        weight *= _smooth(after / jump, SMOOTH_RATIO, STEP_RATIO)
    return weight


@compiled
def step_to(k, i, j, film_thickness, open_cells, roughness_rms, cells):
    """Return the jump of the gap from cell (i, j) to entry k of its stencil times its weight.

    See Eq. (A12). It is 0 if the change is smooth, or if a jump before or behind is missing.

    Returns
    -------
    jump, weight : float
        [m], [-].
    """
    p, q = _cell_towards(OPPOSITE[k], 1, i, j, open_cells, cells)
    a, b = _cell_towards(k, 1, i, j, open_cells, cells)
    c, d = _cell_towards(k, 2, i, j, open_cells, cells)
    if p < 0 or a < 0 or c < 0:
        return 0.0, 0.0
    own = film_thickness[i, j]
    jump = film_thickness[a, b] - own
    before = own - film_thickness[p, q]
    after = film_thickness[c, d] - film_thickness[a, b]
    return jump, _step_weight(before, jump, after, roughness_rms)


@compiled
def profile_steps(film_thickness: Array, open_cells: Flags, roughness_rms: float, cells: Cells):
    """Return the weights of the steps of the gap, Eq. (A12).

    Parameters
    ----------
    film_thickness : ndarray, shape (n_c, n_a)
        h at the start of a run, without the deflection of a coating [m].
    open_cells : ndarray of bool, shape (n_c, n_a)
        Cells without a film.
    roughness_rms : float
        sigma [m].
    cells : grid.Cells

    Returns
    -------
    ndarray, shape (2, n_c, n_a)
        Weights from a cell to its neighbour before it along j, and along i.
    """
    n_c, n_a = film_thickness.shape
    steps = np.zeros((2, n_c, n_a))
    if roughness_rms <= 0.0:
        return steps
    for i in range(n_c):
        for j in range(n_a):
            if open_cells[i, j]:
                continue
            for row, k in enumerate((SOUTH, WEST)):
                _, weight = step_to(k, i, j, film_thickness, open_cells, roughness_rms, cells)
                steps[row, i, j] = weight
    return steps


@compiled
def has_narrow_steps(film_thickness: Array, open_cells: Flags, roughness_rms: float, cells: Cells):
    """Return whether a land or groove is one cell wide.

    The gap then steps by more than the roughness to both sides of a cell, Eq. (A12).
    """
    n_c, n_a = film_thickness.shape
    if roughness_rms <= 0.0:
        return False
    for i in range(n_c):
        for j in range(n_a):
            if open_cells[i, j]:
                continue
            for k in (SOUTH, WEST):
                one, at_one = step_to(k, i, j, film_thickness, open_cells, roughness_rms, cells)
                other, at_other = step_to(
                    OPPOSITE[k], i, j, film_thickness, open_cells, roughness_rms, cells
                )
                narrow = min(abs(one), abs(other)) > roughness_rms and one * other > 0.0
                if narrow and min(at_one, at_other) > 0.5:
                    return True
    return False


@compiled
def contact(
    film_thickness: Array,
    deflection: Array,
    steps: Array,
    open_cells: Flags,
    constants: ContactConstants,
    cells: Cells,
):
    """Return pressure, area fraction, boundary shear stress and elastic energy of the asperities.

    They are means over each cell, Eqs. (A7), (A8).

    Parameters
    ----------
    film_thickness : ndarray, shape (n_c, n_a)
        h without the deflection [m], any sign.
    deflection : ndarray, shape (n_c, n_a)
        Deflection of the coating [m].
    steps : ndarray, shape (2, n_c, n_a)
        Result of `profile_steps`.
    open_cells : ndarray of bool, shape (n_c, n_a)
        Cells without a film, which touch nothing.
    constants : asperity.ContactConstants
    cells : grid.Cells

    Returns
    -------
    Contact
    """
    n_c, n_a = film_thickness.shape
    pressure = np.zeros((n_c, n_a))
    area = np.zeros((n_c, n_a))
    stress = np.zeros((n_c, n_a))
    energy = np.zeros((n_c, n_a))
    slope = np.zeros((5, n_c, n_a))
    stress_slope = np.zeros((5, n_c, n_a))
    of_cells = Contact(
        pressure=pressure,
        area_fraction=area,
        shear_stress=stress,
        pressure_slope=slope,
        shear_stress_slope=stress_slope,
        energy=energy,
    )
    if constants.roughness_rms <= 0.0:
        return of_cells
    reach = constants.summit_height + TABLE_END * constants.roughness_rms
    higher = np.zeros(5)  # gaps of the neighbours minus that of the cell
    step = np.zeros(5)  # weights of the steps to the neighbours
    share = np.zeros(5)
    for i in range(n_c):
        for j in range(n_a):
            if open_cells[i, j]:
                continue
            centre = film_thickness[i, j] + deflection[i, j]
            lowest = centre
            for k in (SOUTH, NORTH, WEST, EAST):
                a, b = _cell_towards(k, 1, i, j, open_cells, cells)
                step[k] = 0.0 if a >= 0 else 1.0
                higher[k] = film_thickness[a, b] - film_thickness[i, j] if a >= 0 else 0.0
                lowest -= 0.5 * abs(higher[k])
            if not lowest < reach:
                continue
            step[SOUTH] = max(step[SOUTH], steps[0, i, j])
            step[NORTH] = max(step[NORTH], steps[0, i, min(j + 1, n_a - 1)])
            step[WEST] = max(step[WEST], steps[1, i, j])
            next_step = i if cells.mirrored and i == n_c - 1 else (i + 1) % n_c
            step[EAST] = max(step[EAST], steps[1, next_step, j])
            for x, weight_x in zip(POINTS, WEIGHTS):
                share[WEST], share[EAST] = _shares(x, step[WEST], step[EAST])
                across = share[WEST] * higher[WEST] + share[EAST] * higher[EAST]
                for y, weight_y in zip(POINTS, WEIGHTS):
                    share[SOUTH], share[NORTH] = _shares(y, step[SOUTH], step[NORTH])
                    along = share[SOUTH] * higher[SOUTH] + share[NORTH] * higher[NORTH]
                    gap = centre + across + along  # Eq. (A7)
                    if gap >= reach:
                        continue
                    at = point_contact(gap, constants)
                    share[CENTRE] = 1.0 - share[SOUTH] - share[NORTH] - share[WEST] - share[EAST]
                    # Eq. (A8)
                    weight = weight_x * weight_y
                    pressure[i, j] += weight * at.pressure
                    area[i, j] += weight * at.area_fraction
                    stress[i, j] += weight * at.shear_stress
                    energy[i, j] += weight * at.energy
                    for k in range(5):
                        slope[k, i, j] += weight * share[k] * at.pressure_slope
                        stress_slope[k, i, j] += weight * share[k] * at.shear_stress_slope
    if cells.mirrored:
        for each in (slope, stress_slope):  # both neighbours of an end are the same row
            for j in range(n_a):
                each[EAST, 0, j] += each[WEST, 0, j]
                each[WEST, 0, j] = 0.0
                each[WEST, n_c - 1, j] += each[EAST, n_c - 1, j]
                each[EAST, n_c - 1, j] = 0.0
    return of_cells


@compiled
def contact_changes(slope: Array, film_thickness: Array, deflection: Array):
    """Return the changes of a pressure or stress of contact with film thickness and deflection.

    Parameters
    ----------
    slope : ndarray, shape (5, n_c, n_a)
        `slope` of `Contact` [Pa/m], or values that replace it.
    film_thickness, deflection : ndarray, shape (m, n_c, n_a)
        m changes of each [m].

    Returns
    -------
    ndarray, shape (m, n_c, n_a)
    """
    m, n_c, n_a = film_thickness.shape
    out = np.zeros((m, n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            if slope[CENTRE, i, j] == 0.0:
                continue
            for k in range(5):
                a, b = neighbour(k, i, j, n_c, n_a)
                by = slope[k, i, j]
                for q in range(m):
                    out[q, i, j] += by * (film_thickness[q, a, b] + deflection[q, i, j])
    return out
