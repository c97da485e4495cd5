"""Calibration: numbers of a case for which its curves agree best with measured values.

Eq. (V6):  minimise  sum of r_i^2,   r_i = (y(x_i) - m_i) / sigma_i
Eq. (V7):  C = s^2 (J^T J)^-1,   J = dr/dp,   s^2 = max(1, sum of r_i^2 / (n - number of p))

y is a curve of the last period, m_i one of n measured values at x_i, and sigma_i its standard
deviation, a quarter of the band of the file. Without a band it is unknown: then sigma_i is the
range of the curve, and s^2 has no lower bound. The interval of a parameter at 95 % is the quantile
t of Student times the root of the diagonal of C. Parameters whose correlation in C exceeds
`LARGEST_CORRELATION` cannot be told apart.

The steps are those of Gauss and Newton in a trust region, with bounds [Branch1999]. J is by
differences of runs, which all run at the same time.

References
----------
[Branch1999] M. A. Branch, T. F. Coleman, Y. Li, A subspace, interior, and conjugate gradient method
for large-scale bound-constrained minimization problems, SIAM J. Sci. Comput. 21 (1999) 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from ..fmi.errors import BadInput, Stopped
from .optimisation import Values, differences

LARGEST_CORRELATION = 0.95
"""Correlation above which two parameters cannot be told apart: our own choice."""
END_TOLERANCE = 1e-4
"""Relative change of the sum of squares, and of the shares, at which the search ends."""
LEAST_SINGULAR_VALUE = 1e-10
"""Smallest share of the largest singular value of J that determines a combination of parameters."""


@dataclass(frozen=True)
class Calibration:
    """Result of a calibration.

    shares : of the parameters; half_widths : of their intervals at 95 %, in shares, inf for
    parameters that the values do not determine; alike : pairs that cannot be told apart, with their
    correlation; before, after : root mean square of r for the case and for the result.
    """

    shares: np.ndarray
    half_widths: np.ndarray
    alike: list[tuple[int, int, float]]
    before: float
    after: float


def calibrate(
    residuals: Values, bounds: Sequence[tuple[float, float]], has_bands: bool
) -> Calibration:
    """Return the parameters that agree best with measured values.

    Parameters
    ----------
    residuals : callable
        Residuals of designs, Eq. (V6).
    bounds : sequence of (float, float)
        Lower and upper share of each parameter.
    has_bands : bool
        Whether the residuals are in standard deviations.

    Raises
    ------
    BadInput
        With fewer values than parameters, or if the case itself fails.
    Stopped
        If a run fails in the search.
    """
    count = len(bounds)
    (first,) = residuals([np.zeros(count)])
    if first is None:
        raise BadInput("the case itself: its run fails")
    if first.size <= count:
        raise BadInput(
            f"measured: expected more than {count} values within the run, got {first.size}"
        )

    def values(designs):
        values = residuals(designs)
        for x, one in zip(designs, values):
            if one is None:
                raise Stopped(f"a run fails at the shares {np.round(x, 3).tolist()} of the ranges")
            if one.size != first.size:
                raise BadInput(
                    f"measured: expected values within all runs, got {first.size} within the case "
                    f"and {one.size} within another run"
                )
        return values

    def at(x):
        return values([x])[0]

    done = least_squares(
        at,
        np.zeros(count),
        jac=lambda x: differences(values, x, at(x), bounds),  # pyright: ignore[reportArgumentType]  # its stubs know the texts alone
        bounds=np.array(bounds).T,
        xtol=END_TOLERANCE,
        ftol=END_TOLERANCE,
    )
    # Eq. (V7)
    variance = float(done.fun @ done.fun) / (first.size - count)
    scale = max(variance, 1.0) if has_bands else variance
    _, sizes, directions = np.linalg.svd(done.jac, full_matrices=False)
    determined = sizes > LEAST_SINGULAR_VALUE * max(sizes.max(), 1e-300)
    inverse = np.divide(1.0, sizes, out=np.zeros(count), where=determined)
    covariance = scale * (directions.T * inverse**2) @ directions
    spread = np.sqrt(np.diag(covariance))
    half_widths = student.ppf(0.975, first.size - count) * spread
    lost = np.abs(directions[~determined]).max(axis=0, initial=0.0) > LEAST_SINGULAR_VALUE
    half_widths[lost] = np.inf
    with np.errstate(invalid="ignore", divide="ignore"):
        related = covariance / np.outer(spread, spread)
    return Calibration(
        shares=done.x,
        half_widths=half_widths,
        alike=[
            (i, k, float(related[i, k]))
            for i in range(count)
            for k in range(i + 1, count)
            if abs(related[i, k]) > LARGEST_CORRELATION
        ],
        before=float(np.sqrt(np.mean(first**2))),
        after=float(np.sqrt(np.mean(done.fun**2))),
    )
