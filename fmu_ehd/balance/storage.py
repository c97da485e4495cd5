"""Storage term of the film, of second order in time.

It is variable-step BDF2, written as a step of backward Euler.

At the end of the step:

Eq. (T1):  dc/dt = (c - c_e) / H_e,   c_e = c_n + beta_t H_n r_n,   H_e = H - beta_t H_n
Eq. (T2):  beta_t = m w^2 / (1 + 2 w),   w = min(H / H_n, 2)
Eq. (T3):  beta_t = 0  where c_e < 0 in any cell
Eq. (T4):  m = 4 r_n.r_{n-1} / max(r_n.r_n, r_{n-1}.r_{n-1}),   not below 0, not above 1

c = f s is the content of a cell [m], film fraction times stored film. c_n is the content at the
beginning of the step. r_n and r_{n-1} are its growth in the last step and in the one before [m/s].
H and H_n are the lengths of this step and of the last one [s]. The dot is a sum over all cells, and
m is the memory of the film [-].

For a content that is linear in time, Eq. (T1) is exact with any beta_t. For a quadratic one it is
exact with Eq. (T2) and m = 1, which is BDF2. With beta_t = 0 it is backward Euler. The balance of a
cell is that of a backward Euler step of length H_e from the content c_e. Matrix, cavitation and
tangent are therefore those of backward Euler.

BDF2 is A-stable with constant steps. It is zero-stable while steps grow by less than 1 + sqrt(2)
[Hairer1993]. From w = 2 on, beta_t remains constant, and such a step is of first order. The first
steps are backward Euler (r = 0), which does not reduce the order.

BDF2 assumes that the motion continues. Where a motion stops, it presses half of the last inflow out
again. Where a motion starts, its pressure is 3/2 of the correct one. A full film that is squeezed
in one step and then at rest would end with a void. Eq. (T4) therefore sets m = 0 if the last growth
is unlike the one before: after a jump, and when all moving oil stops. In smooth motion the two
differ by O(H), and m = 1. The factor 4 keeps it at 1 until one growth is less than a quarter of the
other. If the oil reverses its motion, a step or two are of first order, which does not reduce the
order. Where only round-off changes, m = 0.

m does not know the step to come. If a film is squeezed evenly for two steps or more, and is stopped
within one, it still returns a third of its last growth.

If a cell loses more than 3/4 of its oil in one of two equal steps, c_e would be negative. Such a
step is backward Euler, Eq. (T3). With c_e >= 0 no film fraction becomes negative, since the matrix
is an M-matrix. No upper bound is needed: a cell that receives more than it can hold fills, and
its pressure drives the surplus out. The choice depends on the past only, so the step remains a
smooth function of its inputs.

Full films, film fractions and positions of moving fronts are of second order. The pressure of a
film on a grid jumps whenever a cell fills.

beta_t is one number for the whole film. If each cell had its own, the flow through a face would
count differently on its two sides, and oil would be lost. With one number, oil is conserved to
round-off with any steps. The oil in the film grows during a step by G = beta_t G_n + H_e Q [m3].
G_n is the growth in the step before, and Q the inflow over all edges at the end of the step
[m3/s]. Without flow over the edges the oil stays constant. Over many steps it grows by the sum of
the inflows Q, each times H_e (1 + beta_t' + beta_t' beta_t'' + ...) with the beta_t of the steps
that follow. These weights add up to the elapsed time.

References
----------
[Hairer1993] E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd
ed., Springer 1993, section III.5 (variable-step BDF and their stability).
"""

from typing import NamedTuple

from ...master.fmi.compiled import compiled
from ..common.grid import Array, Cells, images

LARGEST_RATIO = 2.0  # of H / H_n in Eq. (T2), below 1 + sqrt(2)
# [m] content of an empty cell by round-off: a film of 10 um times the round-off of film fractions
NEGLIGIBLE = 1e-20
# relative change of the content in a step, below which the film is at rest. It is far above the
# round-off of film fractions. A plate that closes 100 um at 1 mm/s changes by 1e-5 in 1 us.
STANDSTILL = 1e-10
WHOLE_MEMORY = 4.0  # the factor of Eq. (T4)


class ContentHistory(NamedTuple):
    """History of the oil content of a film.

    content : ndarray, shape (n_c, n_a)
        c_n at the beginning of the step [m], >= 0.
    growth, growth_before : ndarray, shape (n_c, n_a)
        r_n and r_{n-1}, rates of change of the content in the last step and in the one before
        [m/s]; 0 if there was no such step.
    step : float
        H_n [s], >= 0; 0 if there was no step before.
    """

    content: Array
    growth: Array
    growth_before: Array
    step: float


class EulerStep(NamedTuple):
    """Backward Euler step that is equivalent to a step of second order.

    content : ndarray, shape (n_c, n_a)
        c_e at its start [m], >= 0 apart from round-off.
    length : float
        H_e [s], 0.6 H to H; inf for a steady film.
    """

    content: Array
    length: float


@compiled
def memory(past: ContentHistory, cells: Cells):
    """Return the memory m of a film [-], 0 to 1, Eq. (T4)."""
    content, growth, growth_before, step = past
    both = 0.0
    last = 0.0
    before = 0.0
    whole = 0.0
    for i in range(content.shape[0]):
        alike = images(cells.mirrored, i, content.shape[0])
        for j in range(content.shape[1]):
            both += alike * (growth[i, j] * growth_before[i, j])
            last += alike * (growth[i, j] * growth[i, j])
            before += alike * (growth_before[i, j] * growth_before[i, j])
            whole += alike * (content[i, j] * content[i, j])
    larger = max(last, before)
    if larger * step * step <= STANDSTILL * STANDSTILL * whole:
        return 0.0
    return min(max(WHOLE_MEMORY * both / larger, 0.0), 1.0)  # Eq. (T4)


@compiled
def euler_step(past: ContentHistory, step: float, cells: Cells):
    """Return the step of backward Euler that equals the step of second order.

    It has a content and a length, Eqs. (T1) to (T4).

    Parameters
    ----------
    past : ContentHistory
    step : float
        H [s], > 0.
    cells : grid.Cells

    Returns
    -------
    EulerStep
    """
    ratio = min(step / past.step, LARGEST_RATIO) if past.step > 0.0 else 0.0
    share = memory(past, cells) * ratio * ratio / (1.0 + 2.0 * ratio)  # Eq. (T2)
    extrapolated = past.content + share * past.step * past.growth
    if extrapolated.min() < -NEGLIGIBLE:
        return EulerStep(past.content, step)  # Eq. (T3)
    return EulerStep(extrapolated, step - share * past.step)  # Eq. (T1)
