"""The first steps of the bodies by backward Euler, which does not use the start acceleration.

References
----------
[Rannacher1984] R. Rannacher, Numer. Math. 43 (1984) 309-327.
"""

from ...master.fmi.compiled import compilable
from ..mechanism.generalised_alpha import Coefficients

FIRST_STEPS = 2
"""Steps of backward Euler at the start."""


@compilable
def first_steps(step: float) -> Coefficients:
    """Return the coefficients of a step of backward Euler with zero auxiliary acceleration.

    Eq. (N8):  q'_1 = q'_0 + h q''_1,  q_1 = q_0 + h q'_1

    The forces at the start are those of a film without squeeze. Under a load, for example pin
    friction at top dead centre, they give an acceleration that the film stops within about a
    microsecond. A method that uses this acceleration over a step oscillates, which looks like an
    impact (Eq. (N14)). Backward Euler does not use it. After one step the velocities agree with the
    film, and after two steps the accelerations. The following steps keep order 2 [Rannacher1984].

    Parameters
    ----------
    step : float
        h [s], > 0.

    Returns
    -------
    Coefficients

    References
    ----------
    [Rannacher1984]. Checked in tests/mfbd/test_first_steps.py.
    """
    # Eq. (N8)
    return Coefficients(
        step=step,
        alpha_m=0.0,
        alpha_f=0.0,
        beta=1.0,
        gamma=1.0,
        to_auxiliary=1.0,
        to_velocity=step,
        to_position=step**2,
        memory=0.0,
    )
