"""A film as flow and shear see it: between smooth or rough surfaces, thinned by shear.

Shear thinning lowers the viscosity of a cell to that at its shear rate |V|/h, so conductivities
grow by mu_0/mu and Couette stress falls by mu/mu_0. A bearing slides both ways, V along and W
around: its shear rate is that of both together.
"""

from typing import NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable, compiled
from .films import CONDUCTIVITY_A, CONDUCTIVITY_C, COUETTE, FilmSlopes, rough_film, smooth_film
from .grid import Array
from .oil import NO_THINNING, Thinning, thinning


class FilmLaws(NamedTuple):
    """What makes a film of a film thickness.

    minimum_flow_film : h_min [m]; roughness_rms : composite sigma [m];
    factors : ndarray, of `roughness.factor_table`, of shape (0, 0) between smooth surfaces;
    thinning : oil.Thinning.
    """

    minimum_flow_film: float
    roughness_rms: float
    factors: Array
    thinning: Thinning


class Sheared(NamedTuple):
    """Oil that is sheared; each ndarray of shape (n_c, n_a).

    velocity, turning : V and W, 0 on a skirt [m/s]; viscosity : low-shear mu_0 [Pa s];
    temperature : T [K].
    """

    velocity: Array
    turning: Array
    viscosity: Array
    temperature: Array


class FlowFilm(NamedTuple):
    """A film as flow and shear see it.

    quantities : ndarray, shape (6, n_c, n_a), of `films`; slopes, slopes_around :
    films.FilmSlopes, their velocity the axial and the circumferential one.
    """

    quantities: Array
    slopes: FilmSlopes
    slopes_around: FilmSlopes


@compilable
def flow_film(film_thickness: Array, sheared: Sheared, laws: FilmLaws) -> FlowFilm:
    """Film of a film thickness, shape (n_c, n_a) [m].

    Parameters
    ----------
    film_thickness : ndarray, shape (n_c, n_a)
        h [m], any sign.
    sheared : Sheared
    laws : FilmLaws

    Returns
    -------
    FlowFilm
    """
    floor = laws.minimum_flow_film
    if laws.factors.size == 0:
        quantities, by_film = smooth_film(film_thickness, sheared.viscosity, floor)
    else:
        quantities, by_film = rough_film(
            film_thickness, sheared.viscosity, floor, laws.roughness_rms, laws.factors
        )
    if laws.thinning.kind == NO_THINNING:
        n_c, n_a = film_thickness.shape
        slopes = FilmSlopes(by_film, np.zeros((0, n_c, n_a)))
        return FlowFilm(quantities, slopes, slopes)
    return _thinned(quantities, by_film, film_thickness, sheared, laws)


@compiled
def _thinned(quantities, by_film, film_thickness, sheared, laws):
    """`FlowFilm` of thinned oil; `quantities` and `by_film` in place."""
    n_c, n_a = film_thickness.shape
    by_velocity = np.zeros(by_film.shape)
    by_turning = np.zeros(by_film.shape)
    for i in range(n_c):
        for j in range(n_a):
            v = sheared.velocity[i, j]
            w = sheared.turning[i, j]
            speed = np.hypot(v, w)
            h = max(film_thickness[i, j], laws.minimum_flow_film)
            factor, slope = thinning(laws.thinning, speed / h, sheared.temperature[i, j])
            above = film_thickness[i, j] > laws.minimum_flow_film
            to_film = -slope * speed / (h * h) if above else 0.0
            to_speed = slope / h
            along = v / speed if speed > 0.0 else 0.0
            across = w / speed if speed > 0.0 else 0.0
            for name in (CONDUCTIVITY_C, CONDUCTIVITY_A, COUETTE):
                raises = name != COUETTE
                scale = 1.0 / factor if raises else factor
                by_factor = -1.0 / (factor * factor) if raises else 1.0
                thick = quantities[name, i, j] * by_factor
                by_velocity[name, i, j] = thick * to_speed * along
                by_turning[name, i, j] = thick * to_speed * across
                by_film[name, i, j] = by_film[name, i, j] * scale + thick * to_film
                quantities[name, i, j] *= scale
    return FlowFilm(quantities, FilmSlopes(by_film, by_velocity), FilmSlopes(by_film, by_turning))
