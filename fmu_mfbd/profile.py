"""The skirt's machined shape: how much further from the bore it stands than its nominal cylinder."""

import numpy as np


def barrel(height, lower, upper, drop):
    """Parabolic barrel: no gap at mid skirt, `drop` at both ends.

    Eq. (P1):  gap = drop ((2 y - y_l - y_u)/(y_u - y_l))^2

    Parameters
    ----------
    height : ndarray
        y' above A [m].
    lower, upper : float
        Skirt edges [m].
    drop : float
        [m], >= 0.

    Returns
    -------
    ndarray
        Radial gap [m].
    """
    return drop * ((2 * height - lower - upper) / (upper - lower)) ** 2                                         # Eq. (P1)


def ovality(angle, difference):
    """Oval section: full size across the thrust faces, smaller along the pin.

    Eq. (P2):  gap = difference/4 (1 + cos 2 theta)

    Parameters
    ----------
    angle : ndarray
        theta from the pin axis +z towards the thrust side +x [rad].
    difference : float
        Diameter across the thrust faces minus diameter along the pin [m], >= 0.

    Returns
    -------
    ndarray
        Radial gap [m]: difference/2 at the pin ends, 0 at the thrust faces.
    """
    return difference / 4 * (1 + np.cos(2 * angle))                                                             # Eq. (P2)
