"""One time step of the film on a grid: balance, cavitation, linear solver and tangent put
together.
"""

from dataclasses import dataclass

import numpy as np

from . import cavitation, openings, reynolds, transport
from .coating import Softness, soften
from .films import STORED, FilmSlopes
from .grid import FIRST, OPENINGS, Array, Edges, Entrainment, Flags, Grid
from .openings import Openings
from .reynolds import Balance, Faces, Filling, Storage
from .sparse import LinearSolver, linear_solver
from .storage import EulerStep
from .transport import Lift

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
    axial_flow : ndarray, shape (n_c, n_a + 1)
        Flow through the axial faces, positive with ascending j [m3/s].
    edge_flow : ndarray, shape (4,)
        Flow into the film over lower, upper, first, last edge [m3/s].
    mass_imbalance : float
        |inflow - growth| / throughput [-], rates at the end of the step, growth by Eq. (T1);
        throughput = edge flows + growth, at least 0.1 % of the film volume a step.
    iterations : int
        Number of factorisations.
    """

    unknown: Array
    pressure: Array
    film_fraction: Array
    content: Array
    full: Flags
    axial_flow: Array
    edge_flow: Array
    mass_imbalance: float
    iterations: int


@dataclass(frozen=True)
class _Step:
    """What the last step leaves behind for its balance and its tangent."""

    film: Array
    entrainment: Entrainment
    faces: Faces
    storage: Storage
    edges: Edges
    full: Flags
    lift: Array


class FilmStep:
    """Steps of one grid; keeps the factorisation of the last one for its tangent.

    Parameters
    ----------
    grid : grid.Grid
    model : str
        Name of the cavitation model, a key of `cavitation.CAVITATION`.
    open_cells : ndarray of bool, shape (n_c, n_a), optional
        Cells without a film, `openings`.
    solver : sparse.LinearSolver, optional
        `sparse.linear_solver` by default.
    """

    def __init__(
        self,
        grid: Grid,
        model: str = "jfo",
        open_cells: Flags | None = None,
        solver: LinearSolver | None = None,
    ):
        self.grid = grid
        self.model = cavitation.CAVITATION[model]
        self.open_cells = np.zeros(grid.shape, dtype=bool) if open_cells is None else open_cells
        self.solver = solver or linear_solver(grid.shape)
        self._cells = grid.cells
        self._everywhere = np.ones(grid.shape, dtype=bool)
        self._has_openings = bool(self.open_cells.any())
        self.openings = Openings(self.open_cells, grid.cells)
        self._right = np.empty(0)
        self._step: _Step | None = None
        self._solution: FilmSolution | None = None
        self._solved_pressure = np.empty(0)
        self._stencil = np.empty(0)
        self._stencil_around = np.empty(0)

    def solve(
        self,
        film: Array,
        entrainment: Entrainment,
        edges: Edges,
        start: EulerStep,
        full: Flags,
        softness: Softness | None = None,
        lift: Lift | None = None,
    ) -> FilmSolution:
        """Solve Eqs. (E1)-(E5) for one step.

        Parameters
        ----------
        film : ndarray, shape (6, n_c, n_a)
            Quantities of `films` at the end of the step.
        entrainment : grid.Entrainment
            At the end of the step [m/s].
        edges : grid.Edges
            At the end of the step.
        start : storage.EulerStep
            Content that the step starts from, and its length; with backward Euler the content f s
            at its beginning.
        full : ndarray of bool, shape (n_c, n_a)
            Guess of the full cells.
        softness : coating.Softness, optional
        lift : transport.Lift, optional
            Of the film fraction at the axial faces; none by default.

        Returns
        -------
        FilmSolution

        Raises
        ------
        cavitation.NotConverged
        """
        model = self.model
        ring = self.grid.ring
        if self._has_openings:
            film = openings.freed(self.open_cells, film)
        faces = reynolds.faces(film, entrainment, self._cells)
        if self._has_openings:
            openings.close(self.open_cells, faces)
            self.openings.starve(faces, edges.limit)
        lift_a = self.lift_along(lift, entrainment)
        storage = Storage(film[STORED], start.content, self.grid.cell_area / start.length)
        supply = edges.film_fraction[OPENINGS]
        held = edges.pressure[OPENINGS] if supply >= 1.0 else supply - 1.0
        if self._has_openings:
            full = np.where(self.open_cells, supply >= 1.0, full)

        def assemble(pattern):
            full_of_oil = pattern if model.conserving else self._everywhere
            stencil, right = reynolds.assemble(full_of_oil, faces, lift_a, storage, edges, ring)
            if model.switching and not model.conserving:
                cavitation.without_pressure(pattern, stencil)
            if softness is not None:
                soften(pattern, softness, stencil, right)
            if self._has_openings:
                reynolds.hold(self.open_cells, held, stencil, right)
            return stencil, right

        unknown, full, iterations = cavitation.full_cells(
            model, assemble, self.solver, model.first_guess(full), self.open_cells
        )
        while lift_a.any():
            owing = transport.owing(unknown, full) & lift_a.any(axis=1)
            if not owing.any():
                break
            lift_a[owing] = 0.0  # film or velocity jumped: those rows go on without
            unknown, full, more = cavitation.full_cells(
                model, assemble, self.solver, full, self.open_cells
            )
            iterations += more
        step = self._step = _Step(film, entrainment, faces, storage, edges, full, lift_a)
        pressure, balance = self._balance(step, unknown)
        if model.conserving and softness is None and balance.imbalance > REFINE_ABOVE:
            unknown = unknown + self.solver.solve(balance.residual[None])[0]
            pressure, balance = self._balance(step, unknown)
        self._solution = FilmSolution(
            unknown,
            pressure,
            balance.film_fraction,
            balance.content,
            full,
            reynolds.axial_flow(Filling(pressure, balance.film_fraction, lift_a), faces, edges),
            balance.edge_flow,
            balance.imbalance,
            iterations,
        )
        # the pressure that the balance was solved with
        self._solved_pressure = unknown if model.clipping else pressure
        return self._solution

    def lift_along(self, lift: Lift | None, entrainment: Entrainment) -> Array:
        """Lift of the film fraction at the axial faces for the velocity at the end of a step, shape
        (n_c, n_a + 1); none without cavities that hold oil.
        """
        if lift is None or not self.model.conserving:
            n_c, n_a = self.grid.shape
            return np.zeros((n_c, n_a + 1))
        return transport.along(lift, entrainment.axial)

    def _balance(self, step: _Step, unknown: Array) -> tuple[Array, Balance]:
        """Pressure, and what `reynolds.balance` says, for a signed unknown."""
        pressure, deficit = self.model.interpret(unknown, step.full)
        return pressure, reynolds.balance(
            pressure,
            deficit,
            step.faces,
            step.lift,
            step.storage,
            step.edges,
            self.open_cells,
            self.grid.ring,
        )

    def spilled(self) -> Array:
        """Flow of the last step into each opening from both its sides, `openings.spilled`."""
        step = self._step
        solution = self._solution
        assert step is not None and solution is not None, "spilled before solve"
        filling = Filling(solution.pressure, solution.film_fraction, step.lift)
        return openings.spilled(self.open_cells, filling, step.faces)

    def flow_from_openings(self) -> float:
        """Flow of the last step into the film from all openings, or over both ends of a sector
        [m3/s].
        """
        solution = self._solution
        assert solution is not None, "flow_from_openings before solve"
        if not self.grid.ring:
            return float(solution.edge_flow[FIRST:OPENINGS].sum())
        if not self._has_openings:
            return 0.0
        along = np.diff(solution.axial_flow, axis=1)[self.open_cells]
        return float(along.sum() - self.spilled().sum())

    def slopes(
        self,
        film: Array,
        film_slopes: FilmSlopes,
        entrainment: Entrainment,
        dentrainment: Entrainment,
        filling: Filling,
        edges: Edges,
        length: float,
    ) -> Array:
        """Derivative of the film balance to film thickness and sliding velocity, as from
        `reynolds.linearise`.

        Parameters
        ----------
        film : ndarray, shape (6, n_c, n_a)
            Quantities of `films`.
        film_slopes : films.FilmSlopes
        entrainment, dentrainment : grid.Entrainment
            [m/s], and derivatives to the sliding velocity [-].
        filling : reynolds.Filling
        edges : grid.Edges
        length : float
            H_e [s].

        Returns
        -------
        ndarray, shape (2, 5, n_c, n_a)
        """
        if self._has_openings:
            film = openings.freed(self.open_cells, film)
            faces = reynolds.faces(film, entrainment, self._cells)
            bounded = self.openings.starve(faces, edges.limit)
            # a given inflow follows neither film nor velocity
            filling = filling._replace(lift=np.where(bounded, -1.0, filling.lift))
        stencil = reynolds.linearise(
            film,
            film_slopes,
            entrainment,
            dentrainment,
            filling,
            edges,
            self._cells,
            self.grid.cell_area / length,
        )
        if self._has_openings:
            stencil[:, :, self.open_cells] = 0.0
        return stencil

    def linearise(self, film_slopes: FilmSlopes, dentrainment: Entrainment) -> tuple[Array, Array]:
        """Prepare the tangent of the last step, Eq. (E6).

        Parameters
        ----------
        film_slopes : films.FilmSlopes
        dentrainment : grid.Entrainment
            Derivatives of the entrainment velocities to the sliding velocity [-].

        Returns
        -------
        by_pressure, by_fraction : ndarray, shape (n_c, n_a)
            Derivatives of pressure and film fraction to the signed unknown.
        """
        step = self._step
        solution = self._solution
        assert step is not None and solution is not None, "linearise before solve"
        self._stencil = self.slopes(
            step.film,
            film_slopes,
            step.entrainment,
            dentrainment,
            Filling(self._solved_pressure, solution.film_fraction, step.lift),
            step.edges,
            self.grid.cell_area / step.storage.area_per_step,
        )
        return self.model.shares(solution.unknown, step.full)

    def linearise_around(self, film_slopes: FilmSlopes, dentrainment: Entrainment) -> None:
        """The same for a second velocity, that around the circumference."""
        ours = self._stencil
        self.linearise(film_slopes, dentrainment)
        self._stencil_around = self._stencil
        self._stencil = ours

    def tangent(self, dfilm: Array, dvelocity: Array, daround: Array | None = None) -> Array:
        """Change of the signed unknown of the last step, Eq. (E6), after `linearise`.

        Parameters
        ----------
        dfilm, dvelocity : ndarray, shape (m, n_c, n_a)
            m changes of film thickness [m] and sliding velocity [m/s].
        daround : ndarray, shape (m, n_c, n_a), optional
            m changes of the circumferential velocity, after `linearise_around` [m/s].

        Returns
        -------
        ndarray, shape (m, n_c, n_a)
            Overwritten by the next call.
        """
        if self._right.size < dfilm.size:  # kept, as in `blocks`
            self._right = np.empty(dfilm.size)
        right = self._right[: dfilm.size].reshape(dfilm.shape)
        reynolds.apply_stencils(self._stencil, dfilm, dvelocity, right)
        if daround is not None:
            added = np.empty_like(right)
            still = np.zeros_like(dfilm)
            reynolds.apply_stencils(self._stencil_around, still, daround, added)
            right += added
        return self.solver.solve(right)  # Eq. (E6)
