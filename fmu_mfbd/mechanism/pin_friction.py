"""Friction between the piston and a pin that turns with the rod.

How large it is. Pin bosses of a running engine are in mixed lubrication: friction measured in them
peaks twice a cycle at high load and is not that of a fluid [Suhara1997], and a slippery coating of
the pin changes the piston's motion and its friction on the bore [Kohashi2013]. No coefficient of a
pin in its bosses could be read in the open literature. The open paper behind the case `data_sheet`
gives asperities that rub in oil 0.1; that bounds it from above. A full film bounds it from below,
and next to nothing: Petroff's 2 pi^2 mu N R/(P c) is 1e-4 at 18 kN on the pin of the fired case, in
10 um; the three films of `models/floating_pin`, with oil at hand all around, make the heat of 6e-4
on the pin of `data_sheet`, half of it by asperities. The default, 0.01, has asperities carry a
tenth of the load: our own choice, the largest of 0.01, 0.02 and 0.05 with which the fired case,
flooded, tilts by no more than the 0.1 deg published of motorcycle pistons (0.093, 0.166, 0.268
deg).

Where it turns round. The skirt's clearance lets the piston tilt by a tenth of a degree or two while
the rod swings by 13 to 19: the pin slips with the rod, whose angular velocity has the amplitude
w r/L (crank speed, crank radius, rod length), and turns round twice a turn. At the default w_0 = 5
rad/s the passage from -w_0 to w_0 takes 2 w_0 L/(w r) of crank angle: 10 deg at 1680 rpm and 223/72
(`data_sheet`), 4 deg at 6000 rpm and 100/24.75 (`numerical_example`), some steps of 1 deg.

References
----------
[Kohashi2013], [Suhara1997]
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled, packed


class PinFriction(NamedTuple):
    """Friction in the pin bores.

    Parameters
    ----------
    lever : float
        Coefficient of friction times pin radius [m], >= 0.
    speed : float
        Relative angular velocity w_0 at which dry friction has reached 76 % of its full size
        [rad/s], > 0.
    viscous : float
        Moment by relative angular velocity [N m s/rad], >= 0.
    """

    lever: float
    speed: float
    viscous: float


put_pin_friction, pin_friction_from = packed(PinFriction)


class PinMoment(NamedTuple):
    """Moment of the pin on the piston, and how it changes.

    Parameters
    ----------
    moment : float
        About +z [N m].
    by_x, by_y : float
        Slopes against the pin force along x and y [m].
    by_slip : float
        Slope against the relative angular velocity [N m s/rad].
    """

    moment: float
    by_x: float
    by_y: float
    by_slip: float


@compiled
def friction_moment(friction: PinFriction, pin_x: float, pin_y: float, slip: float) -> PinMoment:
    """Return the moment of the pin on the piston, and its slopes.

    Eq. (K7):  M = -lever |F| tanh(slip/w_0) - viscous slip

    Regularised dry friction: below about w_0 the pin creeps instead of sticking.

    Parameters
    ----------
    friction : PinFriction
    pin_x, pin_y : float
        Pin force F on the piston [N].
    slip : float
        Angular velocity of the piston minus that of the pin [rad/s].

    Returns
    -------
    PinMoment
    """
    size = np.hypot(pin_x, pin_y)
    share = np.tanh(slip / friction.speed)
    moment = -friction.lever * size * share - friction.viscous * slip  # Eq. (K7)
    by_size = -friction.lever * share / size if size > 0.0 else 0.0
    by_slip = -friction.lever * size * (1 - share * share) / friction.speed - friction.viscous
    return PinMoment(moment, by_size * pin_x, by_size * pin_y, by_slip)
