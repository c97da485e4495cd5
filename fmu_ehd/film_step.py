"""One time step of the film on a grid: balance, cavitation, linear solver and tangent put together."""

from dataclasses import dataclass

import numpy as np

from . import cavitation, reynolds
from .blocks import BlockTridiagonal


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
        pressure, fraction = np.where(full, unknown, 0.0), np.where(full, 1.0, 1.0 + unknown)  # Eq. (E4)
        _, edge_flow, gross = reynolds.outflow(pressure, fraction, *faces, *ends)
        now = fraction * film.stored
        growth = rate * (now - content)
        throughput = max(np.abs(edge_flow).sum() + np.abs(growth).sum(), 1e-3 * gross, np.finfo(float).tiny)
        imbalance = abs(edge_flow.sum() - growth.sum()) / throughput
        self._last = film, velocity_c, velocity_a, rate, ends, pressure, fraction
        return FilmSolution(unknown, pressure, fraction, now, full, edge_flow, imbalance, iterations)

    def tangent(self, dfilm, dvelocity_c, dvelocity_a, full):
        """Change of pressure and film fraction of the last step, Eq. (E6).

        Parameters
        ----------
        dfilm : films.FlowFilm
            Change of the film.
        dvelocity_c, dvelocity_a : ndarray, shape (n_c, n_a)
            Change of the entrainment velocity [m/s].
        full : ndarray of bool, shape (n_c, n_a)
            Pattern of the last step.

        Returns
        -------
        dpressure, dfraction : ndarray, shape (n_c, n_a)
            [Pa], [-].
        """
        film, velocity_c, velocity_a, rate, ends, pressure, fraction = self._last
        out = reynolds.outflow_change((film.conductivity_c, film.transport, velocity_c),
                                      (film.conductivity_a, film.transport, velocity_a),
                                      (dfilm.conductivity_c, dfilm.transport, dvelocity_c),
                                      (dfilm.conductivity_a, dfilm.transport, dvelocity_a),
                                      pressure, fraction, *self.grid.spacing, *ends)
        unknown = self.solver.solve((-out - rate * fraction * dfilm.stored)[None])[0]  # Eq. (E6)
        return np.where(full, unknown, 0.0), np.where(full, 0.0, unknown)
