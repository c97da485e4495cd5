"""Film alone, stepped by hand in Python: `piston_cosim.Film`.

Units are converted here; the model inside is that of the FMU.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..master.fmi.errors import BadInput, Discard, collecting, unknown
from ..master.fmi.variables import Variable
from . import journal
from .common.faults import NotConverged
from .common.grid import Array, Flags
from .contradictions import FULL_TURN
from .model import LubricationModel
from .parameters import SURFACES, faults, parameters_of
from .state import Memory
from .surroundings import changed_numbers
from .user_input import cells_of, openings_of, read
from .variables import CONDITION_VARIABLES, FILM_VARIABLES, OIL_VARIABLES, variables

KNOWN = {v.name: v for v in (*FILM_VARIABLES, *OIL_VARIABLES, *CONDITION_VARIABLES)}
"""Every parameter of a film, as its FMU declares it."""

LONGEST_STEP, SHORTEST_STEP, OUTPUT_STEP = 1e9, 1e-9, 1e-6
"""Lengths of the steps to a steady film, and of the one whose outputs `steady` returns [s]."""
MOST_STEPS, MOST_SHORT_STEPS = 100, 1000
CELLS_PER_STEP = 4.0
"""Cells that oil travels in a step if long steps do not settle."""
LIFTS = np.append(0.5 ** np.arange(1, 9), 0.0)  # of thicker films, over the largest thickness
PRESSURE_SCALE = 1.0  # pressure below which a change counts as absolute [Pa]
NO_SUPPLY = (
    "oil supply: expected an edge or opening that feeds a steady film, got none; it drains. Set "
    "pressure_lower_edge or pressure_upper_edge above cavitation_pressure, add an opening with oil "
    "(open_cells), or set cavitation_pressure below ambient"
)
NEEDED = {
    "skirt": ("sliding_velocity", "skirt minus bore"),
    "bearing": ("circumferential_velocity", "journal minus shell"),
}
"""Velocity that each surface needs, and its meaning."""
MOTIONS = ("film_thickness", "sliding_velocity", "circumferential_velocity")
LENGTH = Variable("step", "s", "input", "Length of a step")
LOAD = Variable("load", "N", "input", "Force on a journal along x and y", shape=(2,))


class Film:
    """The oil film between a skirt and its bore, without bodies: arrays in, arrays out, SI.

    The grid is on the developed skirt: index i is around it, and j along the axis from the lower
    to the upper edge. Film thickness and sliding velocity are those at the
    end of a step, as in the interface of the FMU.

    Parameters
    ----------
    grid : tuple of int
        Cells around and along.
    open_cells : ndarray of bool, shape `grid`, optional
        True for cells without skirt, which have no film.
    surface : str
        "skirt", or "bearing": a journal in its shell, to which the grid is fixed.
    oil : str, optional
        Oil of the library, as in a case: `piston-cosim keys oil` lists them. Its values are the
        defaults of `parameters`.
    **parameters
        Parameters of the lubrication FMU by their names: text with a unit, or a number in SI;
        `Film.parameters()` lists them.

    Warns
    -----
    UserWarning
        For what the FMU logs as a warning, such as a land of one cell. Each is issued once.

    Raises
    ------
    BadInput
        With every parameter that is unknown, of another unit or out of its range.

    Examples
    --------
    An infinite inclined pad, h = h0 (1 + K (1 - y/L)) with K = 1, has the load
    W = 6 mu U (L/h0)^2 (ln 2 - 2/3) per width:

    >>> film = pc.Film(
    ...     (4, 80), bore_radius="28.25 mm", skirt_length="27 mm", viscosity="20 mPa s"
    ... )
    >>> y = (np.arange(80) + 0.5) / 80
    >>> thickness = np.broadcast_to(10e-6 * (2.0 - y), (4, 80))
    >>> outputs = film.start(thickness, sliding_velocity=-8.0)
    >>> outputs = film.step(thickness, 1e-3, sliding_velocity=-8.0)
    >>> load = outputs["nodal_pressure_force"].sum() / (2 * np.pi * 28.25e-3)
    >>> exact = 6 * 0.02 * 8.0 * (27e-3 / 10e-6) ** 2 * (np.log(2) - 2 / 3)
    >>> print(f"{load / exact:.3f}")
    1.000
    """

    def __init__(
        self,
        grid: tuple[int, int] = (40, 40),
        *,
        open_cells: Flags | None = None,
        surface: str = "skirt",
        oil: str | None = None,
        **parameters: str | float,
    ):
        if surface not in SURFACES:
            raise BadInput(f"surface: {unknown('surface', surface, SURFACES)}")
        values: dict[str, Any] = {}
        if oil is not None:
            from .build import library_oil  # it imports pydantic

            oil_faults: list[str] = []
            values |= library_oil(oil, oil_faults)
            if oil_faults:
                raise BadInput(oil_faults)
        values |= read(parameters, KNOWN, "parameter")
        shape = cells_of(grid)
        cells = openings_of(shape, open_cells)
        chosen = parameters_of(values, shape=shape, open_cells=cells, surface=surface)
        if contradictions := faults(chosen):
            raise BadInput(contradictions)
        self.grid = chosen.shape
        self.model = LubricationModel(chosen)
        self._inputs = {
            v.name: v
            for v in variables(self.grid, ("oil_temperature",), surface=surface)
            if v.causality == "input" or v.tunable
        }
        self._remark = ""  # of the last start
        self._warned: set[str] = set()
        self.state: Memory | None = None
        """State of the film. Set an earlier one to repeat a step with the same bits."""

    def __repr__(self) -> str:
        around, along = self.grid
        return f"<Film of a {self.model.parameters.surface}: {around} x {along} cells>"

    @staticmethod
    def parameters() -> dict[str, Variable]:
        """Return every parameter by its name: unit, default (`start`), allowed range, description.

        `film_symmetry` is missing. It is for a film between bodies, and changes no result.
        """
        return {name: known for name, known in KNOWN.items() if name != "film_symmetry"}

    def start(
        self,
        film_thickness: Array | float | str,
        *,
        sliding_velocity: Array | float | str | None = None,
        circumferential_velocity: Array | float | str | None = None,
        **conditions: Any,
    ) -> dict[str, Any]:
        """Begin with a full film at rest.

        Parameters
        ----------
        film_thickness : float, str or ndarray, shape `grid`
            Bore minus skirt [m].
        sliding_velocity : float, str or ndarray, shape `grid`
            Axial velocity of skirt minus bore [m/s]. A skirt needs it; default of a bearing: 0.
        circumferential_velocity : float, str or ndarray, shape `grid`
            Velocity of journal minus shell, positive with ascending i [m/s]. A bearing needs it; a
            skirt has none.
        **conditions
            Conditions at the edges and of the oil, which replace the parameter of that name, and
            `oil_temperature` [K], a number or of shape `grid`. These are the inputs and tunable
            parameters of the FMU. Text has a unit, and numbers are in SI.

        Returns
        -------
        dict
            Outputs by their names, as those of the FMU: `pressure` [Pa], `film_fraction`,
            `nodal_pressure_force` [N], `friction_power` [W], `minimum_film_thickness` [m], ...

        Raises
        ------
        BadInput
            With every input that is unknown, missing, of another unit or shape, or out of its
            range, or if the conditions at the edges contradict each other.
        """
        inputs = self._read(film_thickness, sliding_velocity, circumferential_velocity, conditions)
        return self._warn(self._start(inputs))

    def step(
        self,
        film_thickness: Array | float | str,
        step: float | str,
        *,
        sliding_velocity: Array | float | str | None = None,
        circumferential_velocity: Array | float | str | None = None,
        **conditions: Any,
    ) -> dict[str, Any]:
        """Take a step of length `step` [s] to a film thickness and velocity; inputs as of `start`.

        Raises
        ------
        BadInput
            As `start`, if `start` was not called, or if the step is not positive.
        Discard
            If the film has no solution. The state remains as it was.
        """
        if self.state is None:
            raise BadInput("film: expected a call of start before step, got none")
        length = read(dict(step=step), dict(step=LENGTH), "input")["step"]
        if not length > 0.0:
            raise BadInput(f"step: expected a positive finite time, got {length:g} s")
        inputs = self._read(film_thickness, sliding_velocity, circumferential_velocity, conditions)
        try:
            return self._warn(self._step(inputs, length))
        except NotConverged as trouble:
            raise Discard(str(trouble)) from None

    def steady(
        self,
        film_thickness: Array | float | str,
        *,
        sliding_velocity: Array | float | str | None = None,
        circumferential_velocity: Array | float | str | None = None,
        tolerance: float = 1e-9,
        **conditions: Any,
    ) -> dict[str, Any]:
        """Return the outputs of the steady film for a fixed film thickness and velocity.

        The film starts full. Steps of 1e9 s follow until pressure and film fraction do not
        change. A step without solution is repeated with a shorter one, which then grows again.

        Parameters
        ----------
        film_thickness, sliding_velocity, circumferential_velocity, **conditions
            As for `start`.
        tolerance : float
            Largest change in the last step: of `film_fraction`, and of `pressure` as a fraction of
            its maximum. Default: 1e-9.

        Returns
        -------
        dict
            Outputs as those of `step`. The next step begins with the steady film.

        Raises
        ------
        BadInput
            As `start`, and if the oil supply follows the stroke.
        Discard
            If the film does not become steady. The state remains as it was.

        Examples
        --------
        >>> film = pc.Film((60, 20), surface="bearing", bore_radius="25 mm", skirt_length="25 mm")
        >>> theta = np.arange(60) * 2 * np.pi / 60
        >>> thickness = np.repeat(25e-6 * (1 + 0.5 * np.cos(theta))[:, None], 20, axis=1)
        >>> outputs = film.steady(
        ...     thickness, circumferential_velocity=5.0,
        ...     pressure_lower_edge=1e5, pressure_upper_edge=1e5,
        ... )
        >>> bool(outputs["pressure"].max() > 1e5)
        True
        """
        inputs = self._read(film_thickness, sliding_velocity, circumferential_velocity, conditions)
        self._check_steady(inputs)
        before = self.state
        try:
            self._approach(inputs, tolerance)
            return self._warn(self._at_rest(inputs))
        except NotConverged as trouble:
            self.state = before
            raise Discard(str(trouble)) from None
        finally:
            self.model.set_lift(True)

    def equilibrium(
        self,
        load: tuple[float, float] | Array | None,
        clearance: Array | float | str,
        *,
        circumferential_velocity: Array | float | str,
        shells: Sequence[journal.ElasticShell] = (),
        tolerance: float = 1e-9,
        **conditions: Any,
    ) -> dict[str, Any]:
        """Return the steady outputs of a bearing whose journal carries a load.

        Eq. (E16) gives the position of the journal, which is parallel to its shell, and the
        deflection of elastic shells. The torque that drives the journal is `friction_power` over
        the angular speed.

        Parameters
        ----------
        load : (float or str, float or str), or None
            Force on the journal along x, to the cell i = 0, and y, a quarter of a revolution
            further [N]. None: the journal does not move, and only its shells deflect.
        clearance : float, str or ndarray, shape `grid`
            Film thickness of a centred journal and rigid shells [m]. If `load` is None, of the
            journal in its position.
        shells : sequence of ElasticShell
            Elastic shells on the grid of the film, such as `fmu_mfbd.shell.build.elastic_shell`
            returns them. Default: rigid. FMUs are not supported.
        circumferential_velocity, **conditions
            As for `start`.
        tolerance : float
            Largest force out of balance over the load, and of the film as for `steady`.

        Returns
        -------
        dict
            Outputs as those of `steady`, which are in balance, and `position` of the journal [m],
            its `stiffness` [N/m] and `damping` [N s/m], shape (2, 2), Eq. (E18), `deflection` of
            the shells [m], and `film_thickness` [m].

        Raises
        ------
        BadInput
            As `steady`, for a skirt, a partial bearing, a load of zero, shells without modes, or a
            smooth journal at rest under one pressure.
        Discard
            If no position carries the load. The state remains as it was.

        Examples
        --------
        A load downwards moves the journal downwards, and in the direction of rotation:

        >>> film = pc.Film((60, 12), surface="bearing", bore_radius="25 mm", skirt_length="25 mm")
        >>> outputs = film.equilibrium(
        ...     (0.0, -1000.0), 25e-6, circumferential_velocity=5.0,
        ...     pressure_lower_edge=1e5, pressure_upper_edge=1e5,
        ... )
        >>> x, y = outputs["position"]
        >>> bool(y < 0.0 < x)
        True
        """
        self._check_bearing(shells)
        if load is not None and np.shape(load) != (2,):
            raise BadInput(f"load: expected two forces [N], got {load!r}")
        loads = {} if load is None else dict(load=load)
        gap = replace(self._inputs["film_thickness"], name="clearance")
        values = read(dict(clearance=clearance) | loads, dict(clearance=gap, load=LOAD), "input")
        centred, force = values["clearance"], values.get("load")
        if force is not None and not np.any(force):
            raise BadInput("load: expected two forces [N] that are not both 0, got 0 and 0 N")
        if not centred.min() > 0.0:
            raise BadInput(f"clearance: expected more than 0 m, got {centred.min():g} m")
        sliding = conditions.pop("sliding_velocity", None)
        inputs = self._read(centred, sliding, circumferential_velocity, conditions)
        self._check_steady(inputs)
        if force is not None and self._is_idle(inputs):
            raise BadInput(
                "circumferential_velocity: expected another value than 0 m/s for a smooth journal "
                "under one pressure, got 0 m/s; its film carries no load"
            )
        before = self.state
        try:
            return self._warn(self._balance(inputs, force, shells, tolerance))
        except NotConverged as trouble:
            self.state = before
            raise Discard(str(trouble)) from None
        finally:
            self.model.set_lift(True)

    def _balance(
        self,
        inputs: dict[str, Any],
        load: Array | None,
        shells: Sequence[journal.ElasticShell],
        tolerance: float,
    ) -> dict[str, Any]:
        """Return the outputs of `equilibrium`; the film thickness of `inputs` is the clearance."""
        clearance = inputs["film_thickness"]
        shapes = journal.shapes_of(shells, self.grid, load)
        first = self._start(inputs)

        def by_shapes() -> Array:
            return journal.by_shapes(self.model.tangent, shapes, self.grid)

        def settled(film_thickness: Array, state: Memory) -> journal.SettledFilm:
            now = inputs | dict(film_thickness=film_thickness)
            self._settle_from(state, first, tolerance, now)
            steady, by_shape = self._memory, by_shapes()
            return journal.SettledFilm(self._at_rest(now), by_shape, steady)

        rms = self.model.parameters.roughness_rms
        search = journal.Search(settled, shapes, clearance, rms, tolerance)
        at = search.balance(self._memory)
        self.state = at.film.state
        outputs = self._at_rest(inputs | dict(film_thickness=at.thickness))
        by_shape = at.film.by_shape
        squeezed = OUTPUT_STEP * (by_shape - by_shapes())
        free = shapes.stiffness == 0.0
        return outputs | dict(
            position=at.coordinates[free],
            stiffness=journal.condensed(-by_shape, by_shape, shapes),
            damping=journal.condensed(squeezed, by_shape, shapes),
            deflection=shapes.thickness(np.where(free, 0.0, at.coordinates), self.grid),
            film_thickness=at.thickness,
        )

    def _check_bearing(self, shells: Sequence[journal.ElasticShell]) -> None:
        """Raise BadInput unless the surface is a whole bearing, and the shells are on its grid."""
        surface, sector = self.model.parameters.surface, self.model.parameters.sector_angle
        if not self._is_bearing:
            raise BadInput(f"surface: expected bearing for an equilibrium, got {surface}")
        if sector != FULL_TURN:
            raise BadInput(
                f"sector_angle: expected a full revolution for an equilibrium, got {sector:.4g} rad"
            )
        for shell in shells:
            if fault := journal.shell_fault(shell, self.grid):
                raise BadInput(fault)

    def _check_steady(self, inputs: dict[str, Any]) -> None:
        """Raise BadInput if the oil supply follows the stroke, or if there is none."""
        supply = self.model.parameters.oil_supply
        if supply != "edges":
            raise BadInput(f"oil_supply: expected edges for a steady film, got {supply}")
        if not self.model.is_fed(**inputs):
            raise BadInput(NO_SUPPLY)

    def _is_idle(self, inputs: dict[str, Any]) -> bool:
        """Return whether smooth surfaces at rest have the same pressure on all sides."""
        named = {name: value for name, value in inputs.items() if name not in MOTIONS}
        x, _ = changed_numbers(self.model.parameters, named)
        at_rest = not any(np.any(inputs[name]) for name in MOTIONS[1:])
        pressures = {x.pressure_lower_edge, x.pressure_upper_edge}
        if self.model.parameters.opening_supply == "own" and self.model.fixed.domain.has_openings:
            pressures.add(x.pressure_openings)
        return at_rest and x.roughness_rms == 0.0 and len(pressures) == 1

    def _approach(self, inputs: dict[str, Any], tolerance: float) -> None:
        """Settle a film from its start, in short steps or from thicker ones if that fails."""
        try:
            first = self._start(inputs)
            self._settle_from(self._memory, first, tolerance, inputs)
        except NotConverged as trouble:
            longest = self._short_step(inputs)
            if longest < LONGEST_STEP:
                try:
                    return self._settle(self._start(inputs), tolerance, inputs, longest)
                except NotConverged:
                    pass
            thickness = inputs["film_thickness"]
            first = self._start(inputs)
            try:
                for lift in LIFTS * float(np.abs(thickness).max()):
                    now = inputs | dict(film_thickness=thickness + lift)
                    self._settle(first, tolerance, now)
            except NotConverged:
                raise trouble from None

    def _short_step(self, inputs: dict[str, Any]) -> float:
        """Return the step in which oil travels `CELLS_PER_STEP` cells along a skirt [s].

        The lift of the film fraction (`balance.transport`) is that of the step before. In long
        steps it may alternate.
        """
        fixed = self.model.fixed
        velocity = 0.0 if fixed.domain.bearing else float(np.abs(inputs["sliding_velocity"]).max())
        if velocity == 0.0:
            return LONGEST_STEP
        travel = CELLS_PER_STEP * fixed.domain.cells.dy
        return min(LONGEST_STEP, travel / (abs(fixed.share) * velocity))

    def _settle_from(
        self, state: Memory, outputs: dict[str, Any], tolerance: float, inputs: dict[str, Any]
    ) -> None:
        """Settle a film from a state; a bearing without lift if it does not settle with it."""
        self.state = state
        try:
            self._settle(outputs, tolerance, inputs)
        except NotConverged:
            if not (self._is_bearing and self.model.fixed.domain.is_lifted):
                raise
            self.model.set_lift(False)
            self.state = state
            self._settle(outputs, tolerance, inputs)

    def _settle(
        self,
        outputs: dict[str, Any],
        tolerance: float,
        inputs: dict[str, Any],
        longest: float = LONGEST_STEP,
    ) -> None:
        """Step until the film does not change; raise NotConverged if it does not settle."""
        length, change = longest, np.inf
        most = MOST_STEPS if longest == LONGEST_STEP else MOST_SHORT_STEPS
        for _ in range(most):
            last = outputs
            try:
                outputs = self._step(inputs, length)
            except NotConverged as trouble:
                length /= 1e3
                if length < SHORTEST_STEP:
                    raise NotConverged(f"the film does not become steady: {trouble}") from None
                continue
            change = _change(last, outputs)
            if change <= tolerance and length == longest:
                return
            length = min(10.0 * length, longest)
        raise NotConverged(
            f"the film does not become steady: expected a change of at most {tolerance:g}, got "
            f"{change:g} in the last of {most} steps; try a larger tolerance or another grid"
        )

    def _at_rest(self, inputs: dict[str, Any]) -> dict[str, Any]:
        """Return the outputs of a steady film, whose work counts from now on."""
        totals = self._memory.totals._replace(friction_work=0.0, boundary_work=0.0)
        self.state = self._memory._replace(totals=totals)
        return self._step(inputs, OUTPUT_STEP)

    def tangent(
        self,
        dfilm_thickness: Array | float | str,
        *,
        dsliding_velocity: Array | float | str = 0.0,
        dcircumferential_velocity: Array | float | str | None = None,
    ) -> tuple[Array, ...]:
        """Return the exact change of the nodal forces for a change of the inputs of the last step.

        The inputs change at its end [m], [m/s]. The result contains `nodal_pressure_force` and
        `nodal_friction_force` [N], of a bearing also `nodal_circumferential_force`.
        """
        turning = dcircumferential_velocity
        if turning is None and self._is_bearing:
            turning = 0.0
        changes = self._read(dfilm_thickness, dsliding_velocity, turning, {})
        return self.model.tangent(*changes.values())

    @property
    def _is_bearing(self) -> bool:
        return self.model.parameters.surface == "bearing"

    @property
    def _memory(self) -> Memory:
        """State of a film that has started."""
        assert self.state is not None
        return self.state

    def _read(
        self, film: Any, sliding: Any, turning: Any, conditions: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Return the inputs of a step in SI; BadInput with every fault."""
        faults: list[str] = []
        inputs: dict[str, Any] = dict(film_thickness=film)
        if self._is_bearing:
            inputs["sliding_velocity"] = 0.0 if sliding is None else sliding
            inputs["circumferential_velocity"] = turning
        else:
            inputs["sliding_velocity"] = sliding
            if turning is not None:
                faults.append("circumferential_velocity: expected nothing for a skirt, got a value")
        missing, meaning = NEEDED[self.model.parameters.surface]
        if inputs[missing] is None:
            faults.append(f"{missing}: expected the velocity of {meaning} [m/s], got nothing")
            del inputs[missing]
        for name, value in conditions.items():
            if name in self._inputs or name not in KNOWN:
                inputs[name] = value
            else:
                faults.append(f"{name}: expected a condition, got a parameter; pass it to pc.Film")
        with collecting(faults):
            values = read(inputs, self._inputs, "condition")
            named = {name: values[name] for name in conditions if name in values}
            faults += changed_numbers(self.model.parameters, named)[1] if named else []
            if not faults:
                return values
        raise BadInput(faults)

    def _start(self, inputs: dict[str, Any]) -> dict[str, Any]:
        """Return the outputs at the start; BadInput if its numbers are out of all proportion."""
        try:
            self.state, outputs = self.model.start(**inputs)
        except NotConverged as trouble:
            raise BadInput(str(trouble)) from None
        self._remark = self.model.remark
        return outputs

    def _step(self, inputs: dict[str, Any], length: float) -> dict[str, Any]:
        """Return the outputs of a step; NotConverged if there is no solution."""
        self.state, outputs = self.model.advance(self._memory, length=length, **inputs)
        return outputs

    def _warn(self, outputs: dict[str, Any]) -> dict[str, Any]:
        """Return outputs after the warnings of the last start and step, each once."""
        for text in {self._remark, self.model.remark} - {"", *self._warned}:
            self._warned.add(text)
            warnings.warn(text, stacklevel=3)
        return outputs


def _change(before: Mapping[str, Any], after: Mapping[str, Any]) -> float:
    """Return the larger change of film fraction and of pressure over its maximum [-]."""
    largest = max(np.abs(after["pressure"]).max(), PRESSURE_SCALE)
    pressure = np.abs(after["pressure"] - before["pressure"]).max() / largest
    return max(pressure, np.abs(after["film_fraction"] - before["film_fraction"]).max())
