"""One time step of the film on a grid: balance, cavitation, linear solver and tangent put
together.
"""

from dataclasses import dataclass

import numpy as np

from . import cavitation, reynolds
from .coating import soften
from .sparse import linear_solver

REFINE_ABOVE = 2e-13  # mass imbalance above which the solution is refined once


@dataclass(frozen=True)
class FilmSolution:
    """Film at the end of a step.

    Parameters
    ----------
    unknown, pressure, film_fraction, content : ndarray, shape (n_c, n_a)
        Signed unknown u, pressure above cavitation pressure [Pa], film fraction [-], content f s
        [m].
    full : ndarray of bool, shape (n_c, n_a)
        True where the film is full.
    edge_flow : ndarray, shape (4,)
        Flow into the film over lower, upper, first, last edge [m3/s].
    mass_imbalance : float
        |inflow - growth| / throughput [-], rates at the end of the step, growth by Eq. (T1);
        throughput = edge flows + growth, at least 0.1 % of the film volume a step.
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
class _Step:
    """What the last step leaves behind for its balance and its tangent."""

    film: tuple
    velocity_c: np.ndarray
    velocity_a: np.ndarray
    faces: tuple
    content: np.ndarray
    rate: float
    edges: object
    full: np.ndarray


class FilmStep:
    """Steps of one grid; keeps the factorisation of the last one for its tangent.

    Parameters
    ----------
    grid : grid.Grid
    model : str
        Name of the cavitation model, a key of `cavitation.CAVITATION`.
    open_cells : ndarray of bool, shape (n_c, n_a), optional
        Cells without a film (cut-outs), which hold the pressure and film fraction of the lower
        edge.
    solver : object, optional
        Linear solver with `factorise` and `solve`; `sparse.linear_solver` by default.
    """

    def __init__(self, grid, model="jfo", open_cells=None, solver=None):
        self.grid = grid
        self.model = cavitation.CAVITATION[model]
        self.open_cells = np.zeros(grid.shape, dtype=bool) if open_cells is None else open_cells
        self.solver = solver or linear_solver(grid.shape)
        self._everywhere = np.ones(grid.shape, dtype=bool)
        self._has_openings = bool(self.open_cells.any())
        self._right = np.empty(0)

    def solve(self, film, velocity_c, velocity_a, edges, content, full, step, softness=None):
        """Solve Eqs. (E1)-(E5) for one step.

        Parameters
        ----------
        film : films.FlowFilm
            At the end of the step.
        velocity_c, velocity_a : ndarray, shape (n_c, n_a)
            Entrainment velocity along i and j at the end of the step [m/s].
        edges : grid.Edges
            At the end of the step.
        content : ndarray, shape (n_c, n_a)
            c_e that the step starts from [m], Eq. (T1); with backward Euler the content f s at its
            beginning.
        full : ndarray of bool, shape (n_c, n_a)
            Guess of the full cells.
        step : float
            H_e [s], Eq. (T1); inf for a steady film.
        softness : tuple of ndarray, optional
            slopes, weight, offset of `coating.soften`.

        Returns
        -------
        FilmSolution

        Raises
        ------
        cavitation.NotConverged
        """
        grid, model = self.grid, self.model
        faces = reynolds.faces(
            film.conductivity_c,
            film.conductivity_a,
            film.transport,
            velocity_c,
            velocity_a,
            *grid.spacing,
            grid.ring,
        )
        rate = grid.cell_area / step
        held = edges.pressure[0] if edges.film_fraction[0] >= 1.0 else edges.film_fraction[0] - 1.0
        if self._has_openings:
            full = np.where(self.open_cells, edges.film_fraction[0] >= 1.0, full)
        guess = model.first_guess(full)

        def assemble(pattern):
            stencil, right = reynolds.assemble(
                pattern if model.conserving else self._everywhere,
                *faces,
                film.stored,
                content,
                rate,
                edges.pressure,
                edges.film_fraction,
                grid.ring,
            )
            if model.switching and not model.conserving:
                cavitation.without_pressure(pattern, *stencil)
            if softness is not None:
                soften(pattern, *softness, *stencil, right)
            if self._has_openings:
                reynolds.hold(self.open_cells, held, *stencil, right)
            return stencil, right

        unknown, full, iterations = cavitation.settle(
            model, assemble, self.solver, guess, self.open_cells
        )
        self._step = _Step(film, velocity_c, velocity_a, faces, content, rate, edges, full)
        pressure, fraction, now, residual, edge_flow, imbalance = self._balance(unknown)
        if model.conserving and softness is None and imbalance > REFINE_ABOVE:
            unknown = unknown + self.solver.solve(residual[None])[0]
            pressure, fraction, now, residual, edge_flow, imbalance = self._balance(unknown)
        self._unknown, self._fraction = unknown, fraction
        self._pressure = (
            unknown if model.clipping else pressure
        )  # the pressure that the balance was solved with
        return FilmSolution(
            unknown, pressure, fraction, now, full, edge_flow, imbalance, iterations
        )

    def _balance(self, unknown):
        """Pressure, and what `reynolds.balance` says, for a signed unknown."""
        s = self._step
        pressure, deficit = self.model.interpret(unknown, s.full)
        return pressure, *reynolds.balance(
            pressure,
            deficit,
            s.faces,
            s.film.stored,
            s.content,
            s.rate,
            s.edges.pressure,
            s.edges.film_fraction,
            self.grid.ring,
            self.open_cells,
        )

    def slopes(
        self, film, by_film, by_velocity, velocities, dvelocities, pressure, fraction, edges, step
    ):
        """Derivative of the film balance to film thickness and sliding velocity, as from
        `reynolds.linearise`.

        Parameters
        ----------
        film : films.FlowFilm
        by_film, by_velocity : ndarray, shape (7, n_c, n_a)
            Derivatives of the film's quantities to film thickness and to sliding velocity; shape
            (0, n_c, n_a) if all zero.
        velocities, dvelocities : pair of ndarray, shape (n_c, n_a)
            Entrainment velocities along i and j [m/s], and their derivatives to the sliding
            velocity [-].
        pressure, fraction : ndarray, shape (n_c, n_a)
            [Pa], [-].
        edges : grid.Edges
        step : float
            [s].

        Returns
        -------
        ndarray, shape (2, 5, n_c, n_a)
        """
        stencil = reynolds.linearise(
            (film.conductivity_c, film.transport, velocities[0]),
            (film.conductivity_a, film.transport, velocities[1]),
            by_film,
            by_velocity,
            *dvelocities,
            pressure,
            fraction,
            *self.grid.spacing,
            self.grid.cell_area / step,
            edges.pressure,
            edges.film_fraction,
            self.grid.ring,
        )
        if self._has_openings:
            stencil[:, :, self.open_cells] = 0.0
        return stencil

    def linearise(self, by_film, by_velocity, *dvelocities):
        """Prepare the tangent of the last step, Eq. (E6).

        Parameters
        ----------
        by_film, by_velocity : ndarray, shape (7, n_c, n_a)
            Derivatives of `films.FlowFilm` quantities to film thickness and to sliding velocity, as
            in `slopes`.
        *dvelocities : ndarray, shape (n_c, n_a)
            Derivatives of the entrainment velocities along i and j to the sliding velocity [-].

        Returns
        -------
        by_pressure, by_fraction : ndarray, shape (n_c, n_a)
            Derivatives of pressure and film fraction to the signed unknown.
        """
        s = self._step
        self._stencil = self.slopes(
            s.film,
            by_film,
            by_velocity,
            (s.velocity_c, s.velocity_a),
            dvelocities,
            self._pressure,
            self._fraction,
            s.edges,
            self.grid.cell_area / s.rate,
        )
        return self.model.shares(self._unknown, s.full)

    def tangent(self, dfilm, dvelocity):
        """Change of the signed unknown of the last step, Eq. (E6), after `linearise`.

        Parameters
        ----------
        dfilm, dvelocity : ndarray, shape (m, n_c, n_a)
            m changes of film thickness [m] and sliding velocity [m/s].

        Returns
        -------
        ndarray, shape (m, n_c, n_a)
            Overwritten by the next call.
        """
        if self._right.size < dfilm.size:  # kept, as in `blocks`
            self._right = np.empty(dfilm.size)
        right = self._right[: dfilm.size].reshape(dfilm.shape)
        reynolds.apply_stencils(self._stencil, dfilm, dvelocity, right)
        return self.solver.solve(right)  # Eq. (E6)
