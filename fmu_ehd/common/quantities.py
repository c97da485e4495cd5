"""Quantities of a film for flow and shear, in one array of shape (6, n_c, n_a).

The names below are its first axis. `balance.films` computes them from film thickness and viscosity.
"""

from typing import Annotated, NamedTuple

from .grid import Array

# first axis of the quantities of a film:
# s, h_U [m];  kappa across j and i [m3/(Pa s)];  c_v [Pa s/m];  b_p [m]
STORED, TRANSPORT, CONDUCTIVITY_A, CONDUCTIVITY_C, COUETTE, POISEUILLE = range(6)
QUANTITIES = 6
CARRIERS = (
    3  # what `transport` needs of the past: the first ones, with the conductivity along its rows
)
CONDUCTIVITY = 2
Quantities = Annotated[Array, f"{QUANTITIES}, n_c, n_a"]
Carriers = Annotated[Array, f"{CARRIERS}, n_c, n_a"]


class FilmSlopes(NamedTuple):
    """Derivatives of the quantities of a film.

    by_film : ndarray, shape (6, n_c, n_a)
        To film thickness [unit of the quantity/m].
    by_velocity : ndarray, shape (6, n_c, n_a), or (0, n_c, n_a) if all zero
        To sliding velocity [unit of the quantity s/m].
    """

    by_film: Quantities
    by_velocity: Quantities
