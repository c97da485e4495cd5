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


@compiled
def friction_moment(friction, pin_x, pin_y, slip):
    """Moment of the pin on the piston, and how it changes.

    Eq. (J1):  M = -lever |F| tanh(slip/w_0) - viscous slip

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
    moment, by_x, by_y, by_slip : float
        About +z [N m]; slopes against pin_x, pin_y [m] and slip [N m s/rad].
    """
    size, share = np.hypot(pin_x, pin_y), np.tanh(slip / friction.speed)
    moment = -friction.lever * size * share - friction.viscous * slip  # Eq. (J1)
    by_force = -friction.lever * share / size if size > 0.0 else 0.0
    by_slip = -friction.lever * size * (1 - share * share) / friction.speed - friction.viscous
    return moment, by_force * pin_x, by_force * pin_y, by_slip
