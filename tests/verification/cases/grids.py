"""A film on a grid alone, without the physics around it."""

from dataclasses import dataclass

import numpy as np

from piston_cosim.fmu_ehd.balance.film_step import (
    HARD,
    NO_LIFT,
    BalanceInputs,
    Domain,
    FilmSolution,
    run,
    solve,
)
from piston_cosim.fmu_ehd.balance.storage import EulerStep
from piston_cosim.fmu_ehd.common.faults import raise_noted
from piston_cosim.fmu_ehd.common.grid import (
    Array,
    Cells,
    Edges,
    Entrainment,
    Flags,
    unlimited_supply,
)
from piston_cosim.fmu_ehd.laws import cavitation
from piston_cosim.fmu_ehd.solvers.sparse import linear_solver
from piston_cosim.master.fmi.noted import none_yet


@dataclass(frozen=True)
class Grid:
    """Cells on the developed surface, i circumferential and j axial.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    width, length : float
        Circumferential and axial extent of the whole grid [m].
    ring : bool
        True: i closes on itself. False: i ends at a first and a last edge.
    """

    shape: tuple[int, int]
    width: float
    length: float
    ring: bool = True

    @property
    def cells(self) -> Cells:
        """Cell size and closure."""
        n_c, n_a = self.shape
        return Cells(self.width / n_c, self.length / n_a, self.ring, mirrored=False)

    @property
    def cell_area(self) -> float:
        """Area of a cell [m2]."""
        cells = self.cells
        return cells.dx * cells.dy


def flooded_edges(shape: tuple[int, int], pressure: float = 0.0) -> Edges:
    """Oil in plenty at all edges of a grid, at one pressure above cavitation pressure [Pa]."""
    return Edges(np.full(5, pressure), np.ones(5), unlimited_supply(shape))


class FilmStep:
    """Steps of one grid; keeps the factorisation of the last one for its tangent.

    Parameters
    ----------
    grid : Grid
    model : str
        Name of the cavitation model, a key of `cavitation.CAVITATION`.
    open_cells : ndarray of bool, shape (n_c, n_a), optional
        Cells without a film, `openings`.
    """

    def __init__(self, grid: Grid, model: str = "jfo", open_cells: Flags | None = None):
        self.grid = grid
        if open_cells is None:
            open_cells = np.zeros(grid.shape, dtype=bool)
        self.domain = Domain(
            cells=grid.cells,
            open_cells=open_cells,
            has_openings=bool(open_cells.any()),
            model=cavitation.CAVITATION[model],
            together=cavitation.at_once(*grid.shape),
            bearing=False,
            is_lifted=True,
        )
        self.solver = linear_solver(grid.shape)

    def solve(
        self, film: Array, entrainment: Entrainment, edges: Edges, start: EulerStep, full: Flags
    ) -> FilmSolution:
        """Solve Eqs. (E1)-(E5) for one step between hard surfaces, as `solve`, without a lift.

        Parameters are those of `BalanceInputs`.

        Raises
        ------
        cavitation.NotConverged
        """
        given = BalanceInputs(film, entrainment, edges, start, full, HARD, NO_LIFT)
        faults = none_yet()
        found = run(solve, given, self.domain, self.solver, faults)
        raise_noted(faults)
        return found
