"""Storage term of the film, of second order in time.

It is variable-step BDF2, written as a step of backward Euler.

At the end of the step:

Eq. (T1):  dc/dt = (c - c_e) / H_e,   c_e = c_n + beta_t H_n r_n,   H_e = H - beta_t H_n
Eq. (T2):  beta_t = m w^2 / (1 + 2 w),   w = min(H / H_n, 2)
Eq. (T3):  beta_t = 0  where c_e < 0 in any cell
Eq. (T4):  m = 4 r_n.r_{n-1} / max(r_n.r_n, r_{n-1}.r_{n-1}),   not below 0, not above 1

c = f s content of a cell [m] (film fraction x stored film), c_n at the beginning of the step, r_n
and r_{n-1} its growth in the last step and in the one before [m/s], H and H_n this step and the
last one [s]. The dot is a sum over all cells, m the memory of the film [-].

Eq. (T1) is exact for a content linear in time whatever beta_t is, and for a quadratic one with that
of Eq. (T2) with m = 1, which makes it BDF2; beta_t = 0 is backward Euler. The balance of a cell is
that of a backward Euler step of length H_e from the content c_e, so matrix, cavitation and tangent
are what they are there. BDF2 is A-stable with constant steps, and zero-stable while steps grow by
less than 1 + sqrt(2) [Hairer1993]: from w = 2 on beta_t stays what it is there, and such a step is
of first order. The first steps are backward Euler (r = 0), which costs no order.

Memory is for a film that goes on as it went. BDF2 presses half of what last flowed in out again
where a motion stops, and gives 3/2 of the pressure where one sets in: a full film that is squeezed
in one step and then held would end with a void, and plates that close on a cavity would carry half
as much again as they should. Eq. (T4) drops the memory where the last growth is unlike the one
before: after a jump, and when all oil that moved stands still. In smooth motion both are alike but
for O(H), and m = 1: the factor 4 keeps it there until one growth is less than a quarter of the
other. Only where the oil turns round a step or two are of first order, which costs no order. Where
nothing moves but round-off, m = 0.

What m cannot see is the step to come. A film squeezed evenly for two steps or more and then stopped
within one still gives up a third of its last growth there.

A cell that lost more than 3/4 of its oil in one of two equal steps would owe oil: such a step is
backward Euler, Eq. (T3). With c_e >= 0 no film fraction becomes negative, since the matrix is an
M-matrix. No bound from above is needed: a cell that is given more than its film holds fills, and
its pressure passes the surplus on. The choice looks at the past alone, so the step remains a smooth
function of its inputs.

Full films, film fractions and the positions of moving fronts come out of second order. The pressure
of a film on a grid jumps whenever a cell fills, and at such an instant no step is.

beta_t is one number for the whole film. With one for each cell, what flows through a face would
count differently on its two sides, and oil would get lost. As it is, oil is conserved to round-off
whatever the steps: the growth of the oil in the film during a step is G = beta_t G_n + H_e Q [m3],
with G_n that of the step before and Q the inflow over all edges at its end [m3/s]. Without flow
over the edges it stays constant, and over many steps it grows by the sum of the inflows Q, each
times H_e (1 + beta_t' + beta_t' beta_t'' + ...) with the beta_t of the steps that follow; these
weights add up to the time that has passed.

References
----------
[Hairer1993] E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd
ed., Springer 1993, section III.5 (variable-step BDF and their stability).
"""

from typing import NamedTuple

from ...master.fmi.compiled import compiled
from ..common.grid import Array, Cells, images

LARGEST_RATIO = 2.0  # of H / H_n in Eq. (T2), below 1 + sqrt(2)
# [m] content that is round-off in an empty cell: a film of 10 um times the rounding of film
# fractions
NEGLIGIBLE = 1e-20
# change of the content in a step, over the content, below which nothing moves: far above the
# round-off of film fractions, and that of a plate that closes at 1 mm/s on 100 um in 1 us is 1e-5
STANDSTILL = 1e-10
WHOLE_MEMORY = 4.0  # the factor of Eq. (T4)


class ContentHistory(NamedTuple):
    """Past of a film.

    content : ndarray, shape (n_c, n_a)
        c_n at the beginning of the step [m], >= 0.
    growth, growth_before : ndarray, shape (n_c, n_a)
        r_n and r_{n-1}, change of the content over the last step and the one before, a second
        [m/s]; 0 where there was none.
    step : float
        H_n [s], >= 0; 0 where there was no step before.
    """

    content: Array
    growth: Array
    growth_before: Array
    step: float


class EulerStep(NamedTuple):
    """The backward Euler step that stands for a step of second order.

    content : ndarray, shape (n_c, n_a)
        c_e that it starts from [m], >= 0 but for round-off.
    length : float
        H_e [s], 0.6 H to H; inf for a steady film.
    """

    content: Array
    length: float


@compiled
def memory(past: ContentHistory, cells: Cells):
    """Memory m of a film [-], 0 to 1, by how alike its last two growths are, Eq. (T4)."""
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
