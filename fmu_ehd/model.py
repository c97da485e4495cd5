"""The lubrication model: film, oil, contact and friction of one surface, one step at a time."""

from typing import Any

import numpy as np

from ..master.fmi.noted import none_yet, remark_of
from . import constants, step, step_nearby, step_tangent
from .balance import film_step
from .balance.nearby import SolvedBalance
from .common.faults import FAULT, FAULTS, raise_noted
from .common.grid import Array, Entrainment
from .contradictions import is_fed
from .parameters import Parameters, chosen_of, has_image, is_of, numbers_of
from .solvers.sparse import linear_solver
from .state import Fields, Inputs, LastStep, Memory, Scalars
from .step_tangent import Directions, Linearisation
from .surroundings import Surroundings, surroundings


class LubricationModel:
    """Transient film, asperity contact and friction between skirt and bore, or journal and shell.

    Parameters
    ----------
    parameters : Parameters
    """

    def __init__(self, parameters: Parameters):
        self.parameters = parameters
        self._bearing = parameters.surface == "bearing"
        self.remark = ""  # warning of the last start or step, empty without one
        # of the last step: what the tangent needs
        self._last: LastStep | None = None
        self._linear: Linearisation | None = None
        self._set_grid(parameters.film_symmetry == "thrust_plane")

    def _set_grid(self, mirrored: bool) -> None:
        """Compute the whole film, or one half."""
        p = self.parameters
        x, chosen = numbers_of(p), chosen_of(p)
        open_cells = np.zeros(p.shape, dtype=bool) if p.open_cells is None else p.open_cells
        self._tables = constants.tables_of(open_cells, self._bearing, mirrored)
        constants.fill(x, chosen, self._tables)
        self.fixed = constants.fixed_of(x, chosen, self._tables, True)
        self._cells = self._tables.open_cells
        self.solver = linear_solver(self._cells.shape)
        self.area = self.fixed.surfaces.area
        self._images = constants.images_of(self._tables)
        self._given = surroundings(p, {}, self._images)

    def set_lift(self, is_lifted: bool) -> None:
        """Let the film fraction have its lift (`transport`) in later steps, or omit it."""
        has_lift = is_lifted and self.fixed.domain.model.rounding == 0.0
        self.fixed = self.fixed._replace(domain=self.fixed.domain._replace(is_lifted=has_lift))

    # ---- steps

    def start(
        self,
        film_thickness: Array,
        sliding_velocity: Array,
        circumferential_velocity: Array | None = None,
        **conditions: Any,
    ) -> tuple[Memory, dict[str, Any]]:
        """Return state and outputs at the start.

        The film is full, with the reduced pressure linear between the edges; or it is filled in
        part and has no pressure.

        Parameters
        ----------
        film_thickness, sliding_velocity : ndarray, shape (n_c, n_a)
            h [m], V [m/s].
        circumferential_velocity : ndarray, shape (n_c, n_a), optional
            W of a bearing [m/s]; 0 by default.
        **conditions
            As for `advance`.

        Returns
        -------
        state : step.Memory
        outputs : dict
            As from `advance`.
        """
        motion = film_thickness, sliding_velocity, circumferential_velocity
        p = self.parameters
        faults = none_yet()
        if p.film_symmetry == "automatic":
            self._set_grid(has_image(p.shape, p.open_cells, p.surface))
            self._inputs(motion, 0.0, conditions, faults)
            if faults[0]:
                self._set_grid(False)
                faults = none_yet()
        inputs = self._inputs(motion, 0.0, conditions, faults)
        filled = p.initial_film_fraction
        memory, fields, scalars = step.start(self.fixed, inputs, filled, faults)
        self._raise(faults)
        self.remark = remark_of(faults, FAULTS)
        return memory, self._outputs(fields, scalars, 0)

    def advance(
        self,
        state: Memory,
        film_thickness: Array,
        sliding_velocity: Array,
        length: float,
        circumferential_velocity: Array | None = None,
        **conditions: Any,
    ) -> tuple[Memory, dict[str, Any]]:
        """Take one step from `state` to the given film and velocity, of second order in time.

        Parameters
        ----------
        state : step.Memory
            At the beginning of the step.
        film_thickness, sliding_velocity : ndarray, shape (n_c, n_a)
            At the end of the step [m], [m/s].
        length : float
            H [s], > 0.
        circumferential_velocity : ndarray, shape (n_c, n_a), optional
            W of a bearing at the end of the step [m/s]; 0 by default.
        **conditions
            At the end of the step, as for `surroundings.surroundings`.

        Returns
        -------
        state : step.Memory
            At the end of the step.
        outputs : dict
            Output variable name -> value, `variables.py`.

        Raises
        ------
        cavitation.NotConverged
        """
        self._last = None  # a refused step has no tangent
        self._linear = None
        motion = film_thickness, sliding_velocity, circumferential_velocity
        faults, odd = none_yet(), none_yet()
        inputs = self._inputs(motion, length, conditions, odd)
        fixed = self.fixed
        begun = step.begin(fixed, state, inputs, faults)
        self._raise(faults)
        solved = step.solve(fixed, state, inputs, begun, self.solver, faults)
        self._raise(faults)
        ended = step.end(fixed, state, inputs, begun, solved, faults)
        self._raise(faults)
        self._raise(odd)  # what an odd part stems from is reported first
        self.remark = remark_of(faults, FAULTS)
        self._last = ended.last
        outputs = self._outputs(ended.fields, ended.scalars, ended.iterations)
        return ended.memory, outputs

    def advance_nearby(
        self,
        base: "LubricationModel",
        state: Memory,
        film_thickness: Array,
        sliding_velocity: Array,
        length: float,
        circumferential_velocity: Array | None = None,
        **conditions: Any,
    ) -> tuple[Memory, dict[str, Any]]:
        """Take a step next to the last one of `base`, with its matrix and its full cells.

        The error is of second order in the differences (Eq. (T30)). The base keeps its last step.

        Parameters
        ----------
        base : LubricationModel
            Without a coating, on the same grid.
        state, film_thickness, sliding_velocity, length, circumferential_velocity, **conditions
            As for `advance`.

        Returns
        -------
        state : step.Memory
        outputs : dict
        """
        last = base._last
        assert last is not None
        motion = film_thickness, sliding_velocity, circumferential_velocity
        faults = none_yet()
        inputs = self._inputs(motion, length, conditions, faults)
        solved = SolvedBalance(last.unknown, last.full, last.stencil, last.filling.lift)
        arguments = self.fixed, state, inputs, solved, base.solver, faults
        ended = film_step.run(step_nearby.advance, *arguments)
        self._raise(faults)
        return ended.memory, self._outputs(ended.fields, ended.scalars, 0)

    def tangent(
        self,
        dfilm_thickness: Array,
        dsliding_velocity: Array | None = None,
        dcircumferential_velocity: Array | None = None,
    ) -> tuple[Array, ...]:
        """Return the change of the forces at the end of the last step for changed inputs there.

        The state at its beginning is constant.

        Parameters
        ----------
        dfilm_thickness : ndarray, shape (n_c, n_a) or (m, n_c, n_a)
            [m].
        dsliding_velocity, dcircumferential_velocity : ndarray, of the same shape, optional
            [m/s], the second of a bearing; 0 by default.

        Returns
        -------
        dnodal_pressure_force, dnodal_friction_force : ndarray, shape as given
            [N].
        dnodal_circumferential_force : ndarray, shape as given
            Of a bearing alone [N].

        Raises
        ------
        RuntimeError
            If no step was taken, or the last one was refused.
        """
        last = self._last
        if last is None:
            raise RuntimeError(
                "the last step was refused, or there was none: it has no directional derivative"
            )
        if self._linear is None:
            self._linear = step_tangent.linearise(self.fixed, last)
        film = self._on_grid(dfilm_thickness)
        still = np.zeros(film.shape)
        velocities = (dsliding_velocity, dcircumferential_velocity)
        directions = Directions(
            film, *(still if one is None else self._on_grid(one) for one in velocities)
        )
        right = np.empty(film.shape)
        forces = np.empty((3 if self._bearing else 2, *right.shape))
        step_tangent.changes(self.fixed, last, self._linear, directions, self.solver, right, forces)
        shape = np.shape(dfilm_thickness)
        return tuple(
            constants.on_film(self._tables, forces[k], True).reshape(shape)
            for k in range(len(forces))
        )

    def is_fed(
        self,
        film_thickness: Array,
        sliding_velocity: Array,
        circumferential_velocity: Array | None = None,
        **conditions: Any,
    ) -> bool:
        """Return whether a steady film has oil: it does not conserve oil, or oil enters it.

        The inputs are those of `advance`.
        """
        domain, share = self.fixed.domain, self.fixed.share
        is_closed = domain.cells.ring or domain.cells.mirrored
        motion = film_thickness, sliding_velocity, circumferential_velocity
        inputs = self._inputs(motion, 0.0, conditions, none_yet())
        moved = Entrainment(share * inputs.turning, share * inputs.velocity)
        return not domain.model.conserving or is_fed(
            inputs.around.edges, moved, domain.open_cells, is_closed
        )

    # ---- what goes in and out

    def _inputs(
        self,
        motion: tuple[Array, Array, Array | None],
        length: float,
        conditions: dict[str, Any],
        faults: Array,
    ) -> Inputs:
        """Return the inputs of a step on the grid; note where they are not symmetric."""
        film, sliding, turning = motion
        around = self._surroundings(conditions, faults) if conditions else self._given
        still = np.zeros(self._cells.shape)
        return Inputs(
            self._input(film, FAULT.odd_film_thickness, faults),
            self._input(sliding, FAULT.odd_sliding_velocity, faults),
            still if turning is None else self._on_grid(turning)[0],
            around,
            length,
        )

    def _surroundings(self, conditions: dict[str, Any], faults: Array) -> Surroundings:
        """Return the surroundings, without temperatures in cells that have no film."""
        field = conditions.get("oil_temperature")
        if field is not None and np.ndim(field):
            on_grid = self._input(field, FAULT.odd_oil_temperature, faults)
            conditions = conditions | dict(oil_temperature=on_grid)
        return surroundings(self.parameters, conditions, self._images)

    def _input(self, field: Any, fault: float, faults: Array) -> Array:
        """Return an input on the grid; note the fault of this number if it is not symmetric."""
        constants.check_even(self._tables, np.asarray(field, float), fault, faults)
        return self._on_grid(field)[0]

    def _on_grid(self, fields: Any) -> Array:
        """Return fields of the film, (n_f, n_a) or (m, n_f, n_a), as (m, n_c, n_a) on the grid."""
        stacked = np.ascontiguousarray(fields, dtype=float).reshape(-1, *self.parameters.shape)
        return constants.on_grid(self._tables, self.fixed.domain.has_openings, stacked)

    def _raise(self, faults: Array) -> None:
        """Raise `NotConverged` with the noted faults."""
        raise_noted(faults, constants.first_row(self._tables))

    def _outputs(self, fields: Fields, scalars: Scalars, iterations: int) -> dict[str, Any]:
        """Return the outputs by name on the whole film, without those of the other surface."""
        on_film = {
            name: constants.on_film(self._tables, field[None], name.startswith("nodal_"))[0]
            for name, field in fields._asdict().items()
        }
        outputs = on_film | scalars._asdict() | dict(solver_iterations=iterations)
        surface = self.parameters.surface
        return {name: value for name, value in outputs.items() if is_of(surface, name)}
