"""One time step of the film on a grid: balance, cavitation, linear solver and tangent put together."""

from dataclasses import dataclass

import numpy as np

from . import cavitation, reynolds
from .blocks import BlockTridiagonal

REFINE_ABOVE = 2e-13  # mass imbalance above which the solution is refined once


@dataclass(frozen=True)
class FilmSolution:
    """Film at the end of a step.

    Parameters
    ----------
    unknown, pressure, film_fraction, content : ndarray, shape (n_c, n_a)
        Signed unknown u, pressure above cavitation pressure [Pa], film fraction [-], content f s [m].
    full : ndarray of bool, shape (n_c, n_a)
        True where the film is full.
    edge_flow : ndarray, shape (4,)
        Flow into the film over lower, upper, first, last edge [m3/s].
    mass_imbalance : float
        |inflow - growth of content| / throughput [-].
    iterations : int
        Number of factorisations.
    """

    unknown: np.ndarray
    pressure: np.ndarray
    film_fraction: np.ndarray
    content: np.ndarray
    full: np.ndarray
    edge_flow: np.ndarray
    mass_imbalance: float
    iterations: int


@dataclass(frozen=True)
class Balance:
    """Terms of the film balance: pressure [Pa], film fraction [-], residual and edge flow [m3/s]."""

    pressure: np.ndarray
    fraction: np.ndarray
    residual: np.ndarray
    edge_flow: np.ndarray


class FilmStep:
    """Steps of one grid; keeps the factorisation and the faces of the last one for its tangent.

    Parameters
    ----------
    grid : grid.Grid
    edges : grid.Edges
    solver : object, optional
        Linear solver with `factorise` and `solve`; block-tridiagonal by default.
    """

    def __init__(self, grid, edges, solver=None):
        self.grid = grid
        self.edges = edges
        self.solver = solver or BlockTridiagonal(grid.shape)

    def solve(self, film, velocity_c, velocity_a, content, full, step):
        """Solve Eqs. (E1)-(E5) for one step.

        Parameters
        ----------
        film : films.FlowFilm
            At the end of the step.
        velocity_c, velocity_a : ndarray, shape (n_c, n_a)
            Entrainment velocity along i and j at the end of the step [m/s].
        content : ndarray, shape (n_c, n_a)
            Content f s at the beginning of the step [m].
        full : ndarray of bool, shape (n_c, n_a)
            Guess of the full cells.
        step : float
            H [s]; inf for a steady film.

        Returns
        -------
        FilmSolution

        Raises
        ------
        cavitation.NotConverged
        """
        grid, edges = self.grid, self.edges
        faces = reynolds.faces(film.conductivity_c, film.conductivity_a, film.transport, velocity_c, velocity_a,
                               *grid.spacing, grid.ring)
        rate = grid.cell_area / step
        ends = edges.pressure, edges.film_fraction, grid.ring

        def assemble(pattern):
            return reynolds.assemble(pattern, *faces, film.stored, content, rate, *ends)

        unknown, full, iterations = cavitation.settle(assemble, self.solver, full)
        self._last = film, velocity_c, velocity_a, faces, content, rate, ends, full
        balance, imbalance = self._balance(unknown)
        if imbalance > REFINE_ABOVE:
            unknown = unknown + self.solver.solve(balance.residual[None])[0]
            balance, imbalance = self._balance(unknown)
        self._pressure, self._fraction = balance.pressure, balance.fraction
        return FilmSolution(unknown, balance.pressure, balance.fraction, balance.fraction * film.stored, full,
                            balance.edge_flow, imbalance, iterations)

    def _balance(self, unknown):
        """Terms of Eq. (E1) for a signed unknown, and the mass imbalance of the whole film."""
        film, _, _, faces, content, rate, ends, full = self._last
        pressure, deficit = np.where(full, unknown, 0.0), np.where(full, 0.0, unknown)  # Eq. (E4)
        out, edge_flow, gross = reynolds.outflow(pressure, 1.0 + deficit, *faces, *ends)
        growth = rate * (film.stored - content + deficit * film.stored)
        throughput = max(np.abs(edge_flow).sum() + np.abs(growth).sum(), 1e-3 * gross, np.finfo(float).tiny)
        imbalance = abs(edge_flow.sum() - growth.sum()) / throughput
        return Balance(pressure, 1.0 + deficit, -out - growth, edge_flow), float(imbalance)

    def tangent(self, dfilm, dvelocity_c, dvelocity_a):
        """Change of pressure and film fraction of the last step, Eq. (E6).

        Parameters
        ----------
        dfilm : films.FlowFilm
            Change of the film.
        dvelocity_c, dvelocity_a : ndarray, shape (n_c, n_a)
            Change of the entrainment velocity [m/s].

        Returns
        -------
        dpressure, dfraction : ndarray, shape (n_c, n_a)
            [Pa], [-].
        """
        film, velocity_c, velocity_a, _, _, rate, ends, full = self._last
        pressure, fraction = self._pressure, self._fraction
        out = reynolds.outflow_change((film.conductivity_c, film.transport, velocity_c),
                                      (film.conductivity_a, film.transport, velocity_a),
                                      (dfilm.conductivity_c, dfilm.transport, dvelocity_c),
                                      (dfilm.conductivity_a, dfilm.transport, dvelocity_a),
                                      pressure, fraction, *self.grid.spacing, *ends)
        unknown = self.solver.solve((-out - rate * fraction * dfilm.stored)[None])[0]  # Eq. (E6)
        return np.where(full, unknown, 0.0), np.where(full, 0.0, unknown)
