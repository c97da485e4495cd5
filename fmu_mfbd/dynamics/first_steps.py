"""The first steps of the bodies: backward Euler, which remembers nothing of a start under load.

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

    What is known at the start are the forces of a film that was not squeezed yet. Under a load, as
    of friction at the pin at top dead centre, they ask for an acceleration that the film takes back
    within a microsecond or so; remembered over a step it rings, and passes for an impact
    (Eq. (N7)). Backward Euler remembers nothing: after one step of it velocities are those that the
    film allows, after two so are accelerations, and order 2 of the steps that follow is kept
    [Rannacher1984].

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
