"""Friction between the piston and a pin that turns with the rod."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled


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
    """Moment of the pin on the piston, and how it changes.

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
