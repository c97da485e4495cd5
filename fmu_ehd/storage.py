"""The storage term of the film, of second order in time: variable-step BDF2 in the shape of a
backward Euler step.

At the end of the step:

Eq. (T1):  dc/dt = (c - c_e) / H_e,   c_e = c_n + beta (c_n - c_{n-1}),   H_e = H - beta H_n
Eq. (T2):  beta = w^2 / (1 + 2 w),   w = min(H / H_n, 2)
Eq. (T3):  beta = 0  where c_e < 0 in any cell

c = f s content of a cell [m] (film fraction x stored film), c_n and c_{n-1} at the beginning of the
step and one step before, H and H_n this step and the last one [s].

Eq. (T1) is exact for a content linear in time whatever beta is, and for a quadratic one with that
of Eq. (T2), which makes it BDF2; beta = 0 is backward Euler. The balance of a cell is that of a
backward Euler step of length H_e from the content c_e, so matrix, cavitation and tangent are what
they are there. BDF2 is A-stable with constant steps, and zero-stable while steps grow by less than
1 + sqrt(2) [Hairer1993]: from w = 2 on beta stays what it is there, and such a step is of first
order. The first step is backward Euler (H_n = 0, c_{n-1} = c_n), which costs no order.

A cell that lost more than 3/4 of its oil in one of two equal steps would owe oil: such a step is
backward Euler, Eq. (T3). With c_e >= 0 no film fraction becomes negative, since the matrix is an
M-matrix. No bound from above is needed: a cell that is given more than its film holds fills, and
its pressure passes the surplus on. The choice looks at the past alone, so the step remains a smooth
function of its inputs.

Full films, film fractions and the positions of moving fronts come out of second order. The pressure
of a film on a grid jumps whenever a cell fills, and at such an instant no step is. After a whole
cavity has closed between surfaces on a given path, the pressure of one step is too high, by up to a
fifth of the highest: BDF2 presses half of what last flowed in out again. A piston free to move
gives way: there the highest pressure errs no more than with backward Euler. Backward Euler for the
step after a closing was tried: it mends half of the cases, spoils the squeeze pressure of others,
and a free piston gains nothing.

beta is one number for the whole film. With one for each cell, what flows through a face would count
differently on its two sides, and oil would get lost. As it is, oil is conserved to round-off
whatever the steps: the growth of the oil in the film during a step is G = beta G_n + H_e Q [m3],
with G_n that of the step before and Q the inflow over all edges at its end [m3/s]. Without flow
over the edges it stays constant, and over many steps it grows by the sum of the inflows Q, each
times H_e (1 + beta' + beta' beta'' + ...) with the beta of the steps that follow; these weights add
up to the time that has passed.

References
----------
[Hairer1993] E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd
ed., Springer 1993, section III.5 (variable-step BDF and their stability).
"""

from typing import NamedTuple

from ..master.fmi.compiled import compiled
from .grid import Array

LARGEST_RATIO = 2.0  # of H / H_n in Eq. (T2), below 1 + sqrt(2)
# [m] content that is round-off in an empty cell: a film of 10 um times the rounding of film
# fractions
NEGLIGIBLE = 1e-20


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
def euler_step(content: Array, content_before: Array, step: float, step_before: float):
    """Content and length of the backward Euler step that equals the step of second order, Eqs. (T1)
    to (T3).

    Parameters
    ----------
    content, content_before : ndarray, shape (n_c, n_a)
        c_n at the beginning of the step, c_{n-1} one step before [m], >= 0.
    step, step_before : float
        H > 0, H_n >= 0 [s]; H_n = 0 where there was no step before, with c_{n-1} = c_n.

    Returns
    -------
    EulerStep
    """
    ratio = min(step / step_before, LARGEST_RATIO)
    share = ratio * ratio / (1.0 + 2.0 * ratio)  # Eq. (T2)
    extrapolated = content + share * (content - content_before)
    if extrapolated.min() < -NEGLIGIBLE:
        return EulerStep(content, step)  # Eq. (T3)
    return EulerStep(extrapolated, step - share * step_before)  # Eq. (T1)
