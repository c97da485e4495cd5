"""Vector of all wires, in Python and in machine code: layout, evaluation, limits, extrapolation."""

from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..fmi.compiled import compilable, standing_for

Array = NDArray[np.float64]
Positions = NDArray[np.int64]

MOST_STEPS = 1e6
"""Largest number of macro steps in a communication step: 1400 cycles of the shipped cases."""
STEP_TOLERANCE = 1e-3
"""Relative difference of steps that is ignored; clocks that count whole nanoseconds have 1e-5."""
TOO_LONG = "step size = {a} s: more than {b} macro steps of {c} s"


class Layout(NamedTuple):
    """Layout of the vector, whose elements are those of all wires in order.

    ends : end of each wire's elements; unknowns : positions of the elements that are unknowns;
    half, images : positions of those that represent themselves and their mirror images on mirrored
    wires, and of these images, which are the same positions elsewhere;
    nominal, tolerance : by element; largest_decrease : by wire, infinite if not limited.
    """

    ends: Annotated[Positions, "wires"]
    unknowns: Annotated[Positions, "unknowns"]
    half: Annotated[Positions, "represented"]
    images: Annotated[Positions, "represented"]
    nominal: Annotated[Array, "size"]
    tolerance: Annotated[Array, "size"]
    largest_decrease: Annotated[Array, "wires"]


class Evaluation(NamedTuple):
    """Result of one step of every participant from an iterate.

    used, outputs, residual : ndarray, shape (size,)
        Values that the inputs were set to, outputs at the end of the step, and outputs - iterate.
    """

    used: Array
    outputs: Array
    residual: Array


@compilable
def _put(to: Array, positions: Positions, what: Array):
    for k in range(len(positions)):
        to[positions[k]] = what[k]


@standing_for(_put)
def put(to: Array, positions: Positions, what: Array):
    """Set elements of an array; in kernels by a loop, as `block.keep`."""
    to[positions] = what


@compilable
def largest(measures: Sequence[float] | Array):
    """Return the largest of some numbers not below 0, NaN if one is NaN."""
    maximum = 0.0
    for measure in measures:
        if not measure <= maximum:
            maximum = measure
            if maximum != maximum:
                break
    return maximum


END_TOLERANCE = 1e-6
"""Share of a macro step by which hosts may miss its end."""


@compilable
def macro_step_end(time: float, step: float, share: float, length: float):
    """Return the time after a share of a communication step [s], on the grid of the macro steps.

    A host that adds up its times misses the multiples of a macro step by some last digits, with
    which an iteration may end earlier.

    Eq. (Y6):  t = n H  if  |t - n H| <= END_TOLERANCE H

    Parameters
    ----------
    time, step : float
        Begin and length of the communication step [s].
    share : float
        0 to 1.
    length : float
        H, macro step of the case [s]; shorter communication steps are not moved.

    >>> print(macro_step_end(0.1, 0.1 + 1e-12, 1.0, 0.1), macro_step_end(0.0, 0.1, 0.5, 0.1))
    0.2 0.05
    """
    end = time + step * share
    near = np.floor(end / length + 0.5) * length
    is_near = abs(end - near) <= END_TOLERANCE * length and step >= (1.0 - END_TOLERANCE) * length
    return near if is_near else end  # Eq. (Y6)


@compilable
def is_longer(step: float, limit: float):
    """Return whether a step exceeds a limit by more than round-off of clocks [s]."""
    return step > limit * (1.0 + STEP_TOLERANCE)


@compilable
def joined(done: int, depth: int):
    """Return the number of finished parts and their halvings, with parts as long as possible.

    >>> joined(6, 3)
    (3, 2)
    """
    while depth > 0 and done % 2 == 0:
        done //= 2
        depth -= 1
    return done, depth


@compilable
def step_length(layout: Layout, x: Array, change: Array):
    """Return the largest share <= 1 of `change` that respects `largest_decrease` of every wire.

    The smallest element m of such a wire may go down to m - s max(m, nominal/10), s =
    largest_decrease.
    """
    share = 1.0
    for w, limit in enumerate(layout.largest_decrease):
        if limit < np.inf:
            begin, end = layout.ends[w - 1] if w > 0 else 0, layout.ends[w]
            values, moves = x[begin:end], change[begin:end]
            smallest = values.min()  # np.min takes longer in Python
            floor = smallest - limit * max(smallest, layout.nominal[begin] / 10)
            if moves.min() < floor - smallest:  # else no element can pass the floor
                down = moves < 0.0
                share = min(share, np.min((values[down] - floor) / -moves[down]))
    return share


@compilable
def moved(layout: Layout, x: Array, change: Array):
    """Return x + share * change with the share of `step_length`."""
    return x + step_length(layout, x, change) * change


@compilable
def lagrange(times: Sequence[float], time: float, weights: Any):
    """Write the weights of the values at distinct times in their polynomial at `time` [s]."""
    for k, own in enumerate(times):
        weight = 1.0
        for other in times:
            if other != own:
                weight *= (time - other) / (own - other)
        weights[k] = weight


@compilable
def extrapolate(times: Sequence[float], past: Sequence[Array], time: float):
    """Return the polynomial through vectors of distinct times at `time` [s] (Lagrange).

    >>> extrapolate([0.0, 1.0, 2.0], [np.array([t**2]) for t in (0.0, 1.0, 2.0)], 3.0)
    array([9.])
    """
    guess = np.zeros(len(past[0]))
    weights = np.empty(len(times))
    lagrange(times, time, weights)
    for a in range(len(times)):
        guess += past[a] * weights[a]
    return guess
