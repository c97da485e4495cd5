"""What a film thickness means for flow: stored and transported film, conductivity, and their derivatives.

Eq. (E7):  s = t = max(h, h_min),  g = s^3 / (12 mu)                            smooth surfaces
"""

from dataclasses import dataclass

import numpy as np
from numba import njit


@dataclass(frozen=True)
class FlowFilm:
    """Film seen by the flow, each field an ndarray of shape (n_c, n_a).

    Parameters
    ----------
    stored, transport : ndarray
        s and t of `reynolds` [m].
    conductivity_c, conductivity_a : ndarray
        g across i and j [m3/(Pa s)].
    """

    stored: np.ndarray
    transport: np.ndarray
    conductivity_c: np.ndarray
    conductivity_a: np.ndarray


@njit(cache=True)
def smooth_film(film_thickness, viscosity, minimum_flow_film):
    """Flow film of smooth surfaces with its derivative to the film thickness, Eq. (E7).

    Parameters
    ----------
    film_thickness : ndarray, shape (n_c, n_a)
        h [m], any sign: where surfaces overlap the floor holds.
    viscosity : float
        mu [Pa s], > 0.
    minimum_flow_film : float
        h_min [m], > 0.

    Returns
    -------
    stored, conductivity, dstored, dconductivity : ndarray, shape (n_c, n_a)
        [m], [m3/(Pa s)], [-], [m2/(Pa s)].
    """
    stored, conductivity = np.empty_like(film_thickness), np.empty_like(film_thickness)
    dstored, dconductivity = np.empty_like(film_thickness), np.empty_like(film_thickness)
    for cell in np.ndindex(film_thickness.shape):
        h = film_thickness[cell]
        slope = 1.0 if h > minimum_flow_film else 0.0
        h = max(h, minimum_flow_film)
        stored[cell] = h  # Eq. (E7)
        conductivity[cell] = h * h * h / (12.0 * viscosity)
        dstored[cell] = slope
        dconductivity[cell] = slope * h * h / (4.0 * viscosity)
    return stored, conductivity, dstored, dconductivity
