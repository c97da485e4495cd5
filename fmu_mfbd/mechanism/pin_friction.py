"""Friction between the piston and a pin that turns with the rod.

The coefficient is uncertain. In a running engine the pin bosses are in mixed lubrication.
Their measured friction has two peaks per cycle at high load, unlike that of a fluid [Suhara1997]. A
slippery coating of the pin changes the motion of the piston and its friction on the bore
[Kohashi2013]. The open literature has no coefficient of a pin in its bosses.

An upper bound is 0.1, the value of the open paper behind the case `data_sheet` for asperities that
rub in oil. A lower bound is that of a full film. On the pin of the fired case at 18 kN, in 10 um of
oil, Petroff's 2 pi^2 mu N R/(P c) is 1e-4. The three films of `models/floating_pin`, with oil
everywhere around, heat like a coefficient of 6e-4 on the pin of `data_sheet`, half of it by
asperities.

With the default, 0.01, asperities carry a tenth of the load. It is our own choice. For the fired,
flooded case, 0.01, 0.02 and 0.05 give a tilt of 0.093, 0.166 and 0.268 deg. Only the first one is
not above the 0.1 deg that are published for motorcycle pistons.

w_0 is far below the slip at the pin. The clearance of the skirt lets the piston tilt by 0.1 to 0.2
deg, while the rod swings by 13 to 19 deg. The pin therefore slips with the rod and reverses twice
per revolution. The angular velocity of the rod has the amplitude w r/L (crank speed, crank radius,
rod length). With the default w_0 = 5 rad/s, the passage from -w_0 to w_0 takes 2 w_0 L/(w r) of
crank angle. This is 10 deg at 1680 rpm and L/r = 223/72 (`data_sheet`), and 4 deg at 6000 rpm and
100/24.75 (`numerical_example`), a few steps of 1 deg.

References
----------
[Kohashi2013], [Suhara1997]
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, packed


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


@compilable
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
