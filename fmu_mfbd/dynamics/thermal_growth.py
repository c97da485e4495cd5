"""Thermal growth of piston and bore with one temperature each, which may change between steps."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from .parameters import Settings


class Radii(NamedTuple):
    """Radii of skirt and bore at the reference temperature [m]."""

    skirt: float
    bore: float


@compiled
def thermal_opening(
    radii: Radii, piston_temperature: float, bore_temperature: float, p: Settings
) -> float:
    """Return the change of the film thickness on the skirt with temperatures [K].

    Eq. (I12):  w = alpha_b R_b (T_b - T_0) - alpha_p R_p (T_p - T_0)

    Piston and bore grow freely and evenly: shapes along the height, films of pin and crank, and the
    mechanism stay as they are.
    """
    bore = p.bore_expansion * radii.bore * (bore_temperature - p.reference_temperature)
    skirt = p.piston_expansion * radii.skirt * (piston_temperature - p.reference_temperature)
    return bore - skirt  # Eq. (I12)


@compiled
def growth_work(pressure_force: np.ndarray, change: float) -> float:
    """Return the work of the films on walls that grow [J].

    Eq. (D55):  W = sum F_i (w_1 - w_0)     as Eq. (D11), forces at the end along the way

    Heat pays for it, or receives it: no coordinate of the bodies moves.

    Parameters
    ----------
    pressure_force : ndarray, shape (cells,)
        F of all films of the skirt [N].
    change : float
        w_1 - w_0 of Eq. (I12) [m].
    """
    total = 0.0
    for k in range(len(pressure_force)):
        total += pressure_force[k]
    return total * change  # Eq. (D55)
