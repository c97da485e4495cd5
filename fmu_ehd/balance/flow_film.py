"""Quantities of flow and shear of a film between smooth or rough surfaces, with shear thinning.

Shear thinning lowers the viscosity of a cell to that at its shear rate gamma' = S/h, with h not
below the floor h_min. With flow factors h is h_s of Eq. (R9), the mean over the local films, which
needs no floor. A bearing slides in both directions, V along the axis and W around it, with S^2 =
V^2 + W^2. The Couette stress decreases by mu/mu_0. The viscosity for pressure flow along the
sliding direction is the slope mu_t of the stress, Eq. (O10). For flow across this direction it is
mu:

Eq. (E13):  kappa_a = kappa_a0 mu_0 (c^2/mu_t + s^2/mu)
            kappa_c = kappa_c0 mu_0 (s^2/mu_t + c^2/mu)

c = V/S and s = W/S, at rest 0 and 1. kappa_a0 and kappa_c0 are the conductivities with mu_0. Eq.
(E13) is the generalised-Newtonian average across the film to first order in the pressure gradient.
If a surface slides in both directions, it omits the flow at right angles to the pressure gradient.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..common.grid import Array
from ..common.quantities import CONDUCTIVITY_A, CONDUCTIVITY_C, COUETTE, FilmSlopes
from ..laws.oil import SHEAR_THINNING_LAWS, Thinning, tangent_thinning, thinning
from ..laws.roughness import sheared_gap
from .films import rough_film, smooth_film


class FilmLaws(NamedTuple):
    """Laws that make a film from a film thickness.

    minimum_flow_film : h_min [m]; roughness_rms : composite sigma [m];
    factors : ndarray, of `roughness.factor_table`, of shape (0, 0) between smooth surfaces;
    thinning : oil.Thinning.
    """

    minimum_flow_film: float
    roughness_rms: float
    factors: Array
    thinning: Thinning


class ShearedOil(NamedTuple):
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
    quantities.FilmSlopes, their velocity the axial and the circumferential one.
    """

    quantities: Array
    slopes: FilmSlopes
    slopes_around: FilmSlopes


@compilable
def flow_film(film_thickness: Array, sheared: ShearedOil, laws: FilmLaws) -> FlowFilm:
    """Return the film of a film thickness, shape (n_c, n_a) [m].

    Parameters
    ----------
    film_thickness : ndarray, shape (n_c, n_a)
        h [m], any sign.
    sheared : ShearedOil
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
    if laws.thinning.kind == SHEAR_THINNING_LAWS.none:
        n_c, n_a = film_thickness.shape
        slopes = FilmSlopes(by_film, np.zeros((0, n_c, n_a)))
        return FlowFilm(quantities, slopes, slopes)
    return _thinned(quantities, by_film, film_thickness, sheared, laws)


@compiled(forceinline=True)
def _sheared_film(film_thickness, laws):
    """Return the film of the shear rate [m] and its slope to the film thickness [-]."""
    if laws.factors.size > 0:
        local = sheared_gap(film_thickness / laws.roughness_rms)
        return laws.roughness_rms * local.value, local.slope
    if film_thickness > laws.minimum_flow_film:
        return film_thickness, 1.0
    return laws.minimum_flow_film, 0.0


@compiled
def _thinned(quantities, by_film, film_thickness, sheared, laws):
    """Return the `FlowFilm` of thinned oil, Eq. (E13); change `quantities` and `by_film`."""
    n_c, n_a = film_thickness.shape
    by_velocity = np.zeros(by_film.shape)
    by_turning = np.zeros(by_film.shape)
    for i in range(n_c):
        for j in range(n_a):
            v = sheared.velocity[i, j]
            w = sheared.turning[i, j]
            speed = np.hypot(v, w)
            h, dh = _sheared_film(film_thickness[i, j], laws)
            rate = speed / h
            kelvin = sheared.temperature[i, j]
            factor, slope = thinning(laws.thinning, rate, kelvin)
            tangent, tangent_slope = tangent_thinning(laws.thinning, rate, kelvin)
            to_film = -rate / h * dh
            cosine = v / speed if speed > 0.0 else 0.0
            sine = w / speed if speed > 0.0 else 0.0
            along = 1.0 / tangent
            across = 1.0 / factor
            along_slope = -tangent_slope * along * along
            across_slope = -slope * across * across
            # derivative of c^2 to V and to W, times (along - across)
            turning = (along - across) * 2.0 * cosine * sine / speed if speed > 0.0 else 0.0
            for name in (CONDUCTIVITY_C, CONDUCTIVITY_A, COUETTE):
                if name == COUETTE:
                    scale = factor
                    by_rate = slope
                    turned = 0.0
                else:
                    share = cosine * cosine if name == CONDUCTIVITY_A else sine * sine
                    scale = share * along + (1.0 - share) * across  # Eq. (E13)
                    by_rate = share * along_slope + (1.0 - share) * across_slope
                    turned = turning if name == CONDUCTIVITY_A else -turning
                quantity = quantities[name, i, j]
                by_velocity[name, i, j] = quantity * (by_rate * cosine / h + turned * sine)
                by_turning[name, i, j] = quantity * (by_rate * sine / h - turned * cosine)
                by_film[name, i, j] = by_film[name, i, j] * scale + quantity * by_rate * to_film
                quantities[name, i, j] = quantity * scale
    return FlowFilm(quantities, FilmSlopes(by_film, by_velocity), FilmSlopes(by_film, by_turning))
