"""Film alone, stepped by hand in Python: `piston_cosim.Film`.

Units are converted here; the model inside is that of the FMU.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..master.fmi.errors import BadInput, Discard, unknown
from ..master.fmi.quantities import to_si
from ..master.fmi.variables import Variable
from . import journal
from .balance.grid import Array, Flags
from .contradictions import FULL_TURN
from .laws.cavitation import NotConverged
from .model import LubricationModel
from .parameters import SURFACES, faults, parameters_of
from .state import Memory
from .variables import CONDITION_VARIABLES, FILM_VARIABLES, OIL_VARIABLES

KNOWN = {v.name: v for v in (*FILM_VARIABLES, *OIL_VARIABLES, *CONDITION_VARIABLES)}
"""Every parameter of a film, as its FMU declares it."""

LONGEST, SHORTEST, AFTERWARDS = 1e9, 1e-9, 1e-6
"""Lengths of the steps to a steady film, and of the one whose outputs `steady` returns [s]."""
MOST_STEPS = 100
SCALE = 1.0  # pressure below which a change counts as absolute [Pa]


class Film:
    """The oil film between a skirt and its bore, without bodies: arrays in, arrays out, SI.

    The grid lies on the developed skirt: index i around it, which closes on itself, j along the
    axis from the lower edge to the upper one. Film thickness and sliding velocity are those at the
    end of a step, as in the interface of the FMU.

    Parameters
    ----------
    grid : tuple of int
        Cells around and along.
    open_cells : ndarray of bool, shape `grid`, optional
        Where there is no skirt, and no film.
    surface : str
        "skirt", or "bearing": a journal in its shell, on which the grid rests then.
    **parameters
        Parameters of the lubrication FMU by their names: text with a unit, or a number in SI;
        `Film.parameters()` lists them.

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
        **parameters: str | float,
    ):
        if surface not in SURFACES:
            raise BadInput(f"surface: {unknown('surface', surface, SURFACES)}")
        values = _read(parameters)
        cells = _cells(grid, open_cells)
        chosen = parameters_of(values, shape=_grid(grid), open_cells=cells, surface=surface)
        if contradictions := faults(chosen):
            raise BadInput(contradictions)
        self.grid = chosen.shape
        self.model = LubricationModel(chosen)
        self.state: Memory | None = None
        """All that the next step needs of the past; setting it back repeats a step, bit for bit."""

    def __repr__(self) -> str:
        around, along = self.grid
        return f"<Film of a {self.model.parameters.surface}: {around} x {along} cells>"

    @staticmethod
    def parameters() -> dict[str, Variable]:
        """Every parameter by its name: unit, default (`start`), allowed range, description."""
        return dict(KNOWN)

    def start(
        self,
        film_thickness: Array | float,
        *,
        sliding_velocity: Array | float | None = None,
        circumferential_velocity: Array | float | None = None,
        **conditions: Any,
    ) -> dict[str, Any]:
        """Begin with a full film at rest.

        Parameters
        ----------
        film_thickness : float or ndarray, shape `grid`
            Bore minus skirt [m].
        sliding_velocity : float or ndarray, shape `grid`
            Axial velocity of skirt minus bore [m/s]. A skirt needs it; default of a bearing: 0.
        circumferential_velocity : float or ndarray, shape `grid`
            Velocity of journal minus shell, positive with ascending i [m/s]. A bearing needs it; a
            skirt has none.
        **conditions
            What holds at the edges, in place of the parameter of that name [SI], and
            `oil_temperature` [K], a number or of shape `grid`.

        Returns
        -------
        dict
            Outputs by their names, as those of the FMU: `pressure` [Pa], `film_fraction`,
            `nodal_pressure_force` [N], `friction_power` [W], `minimum_film_thickness` [m], ...

        Raises
        ------
        BadInput
            If the velocity that the surface needs is missing, an array has another shape, or what
            holds at the edges is impossible.
        """
        film = self._field(film_thickness)
        sliding, turning = self._velocities(sliding_velocity, circumferential_velocity)
        try:
            self.state, outputs = self.model.start(film, sliding, turning, **conditions)
        except NotConverged as trouble:
            raise BadInput(str(trouble)) from None
        return outputs

    def step(
        self,
        film_thickness: Array | float,
        step: float,
        *,
        sliding_velocity: Array | float | None = None,
        circumferential_velocity: Array | float | None = None,
        **conditions: Any,
    ) -> dict[str, Any]:
        """One step of length `step` [s] to the given film and velocity; otherwise as `start`.

        Raises
        ------
        BadInput
            Before `start`, for another shape, or a step that is not positive.
        Discard
            If the film has no solution; the state is as before then.
        """
        if self.state is None:
            raise BadInput("film: expected a call of start before step, got none")
        if not 0.0 < step < np.inf:
            raise BadInput(f"step: expected a positive finite time, got {step:g} s")
        film = self._field(film_thickness)
        sliding, turning = self._velocities(sliding_velocity, circumferential_velocity)
        try:
            self.state, outputs = self.model.advance(
                self.state, film, sliding, float(step), turning, **conditions
            )
        except NotConverged as trouble:
            raise Discard(str(trouble)) from None
        return outputs

    def steady(
        self,
        film_thickness: Array | float,
        *,
        sliding_velocity: Array | float | None = None,
        circumferential_velocity: Array | float | None = None,
        tolerance: float = 1e-9,
        **conditions: Any,
    ) -> dict[str, Any]:
        """Return the outputs of the steady film for a fixed film thickness and velocity.

        The film starts full. Steps of 1e9 s follow until pressure and film fraction stay. A step
        without solution is repeated with a shorter one, which then grows again.

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
        self._check_steady()
        before = self.state
        velocities: dict[str, Any] = dict(
            sliding_velocity=sliding_velocity, circumferential_velocity=circumferential_velocity
        )
        try:
            outputs = self.start(film_thickness, **velocities, **conditions)
            self._settle(outputs, tolerance, film_thickness, velocities | conditions)
            assert self.state is not None
            totals = self.state.totals._replace(friction_work=0.0, boundary_work=0.0)
            self.state = self.state._replace(totals=totals)
            return self.step(film_thickness, AFTERWARDS, **velocities, **conditions)
        except Discard:
            self.state = before
            raise

    def equilibrium(
        self,
        load: tuple[float, float] | Array | None,
        clearance: Array | float,
        *,
        circumferential_velocity: Array | float,
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
        load : (float, float), or None
            Force on the journal along x, to the cell i = 0, and y, a quarter of a revolution
            further [N]. None: the journal does not move, and only its shells yield.
        clearance : float or ndarray, shape `grid`
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
            Outputs as those of `steady`, `position` of the journal [m], its `stiffness`, shape
            (2, 2) [N/m], `deflection` of the shells [m], and `film_thickness` [m].

        Raises
        ------
        BadInput
            As `steady`, for a skirt, a partial bearing, a load of zero, or shells without modes.
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
        self._check_steady()
        surface, sector = self.model.parameters.surface, self.model.parameters.sector_angle
        if not self._is_bearing:
            raise BadInput(f"surface: expected bearing for an equilibrium, got {surface}")
        if sector != FULL_TURN:
            raise BadInput(
                f"sector_angle: expected a full revolution for an equilibrium, got {sector:.4g} rad"
            )
        wanted = None if load is None else np.asarray(load, dtype=float)
        if wanted is not None and (
            wanted.shape != (2,) or not 0.0 < np.hypot.reduce(wanted) < np.inf
        ):
            raise BadInput(f"load: expected two finite forces [N] that are not both 0, got {load}")
        for shell in shells:
            if not all(hasattr(shell, name) for name in ("omega", "outward", "onward")):
                raise BadInput(
                    "shells: expected modes such as elastic_shell of fmu_mfbd.shell.build returns "
                    f"them, got {type(shell).__name__}; FMUs are not supported"
                )
            if shell.outward.shape != (*self.grid, len(shell.omega)):
                raise BadInput(
                    f"shells: expected modes on {self.grid} cells, got {shell.outward.shape}"
                )
        free = self._field(clearance)
        if not free.min() > 0.0:
            raise BadInput(f"clearance: expected more than 0 m, got {free.min():g} m")
        inputs: dict[str, Any] = conditions | dict(
            circumferential_velocity=circumferential_velocity
        )
        before = self.state
        try:
            outputs = self.start(free, **inputs)

            def settled(film_thickness: Array) -> dict[str, Any]:
                return self._settle(outputs, tolerance, film_thickness, inputs)

            rms = self.model.parameters.roughness_rms
            shapes = journal.shapes_of(shells, self.grid, wanted)
            carried = journal.carrying(settled, self.tangent, shapes, free, rms, tolerance)
            thickness = free + carried.deflection
            if wanted is not None:
                thickness = journal.gap(thickness, carried.position, self.grid)
            outputs = self.steady(thickness, tolerance=tolerance, **inputs)
        except (Discard, NotConverged) as trouble:
            self.state = before
            raise Discard(str(trouble)) from None
        return outputs | carried._asdict() | dict(film_thickness=thickness)

    def _check_steady(self) -> None:
        """Raise BadInput if the oil supply follows the stroke."""
        supply = self.model.parameters.oil_supply
        if supply != "edges":
            raise BadInput(f"oil_supply: expected edges for a steady film, got {supply}")

    def _settle(
        self,
        outputs: dict[str, Any],
        tolerance: float,
        film_thickness: Array | float,
        inputs: dict[str, Any],
    ) -> dict[str, Any]:
        """Step until the film stays, and return its outputs; Discard if it does not."""
        length, change = LONGEST, np.inf
        for _ in range(MOST_STEPS):
            last = outputs
            try:
                outputs = self.step(film_thickness, length, **inputs)
            except Discard as trouble:
                length /= 1e3
                if length < SHORTEST:
                    raise Discard(f"the film does not become steady: {trouble}") from None
                continue
            change = _change(last, outputs)
            if change <= tolerance and length == LONGEST:
                return outputs
            length = min(10.0 * length, LONGEST)
        raise Discard(
            f"the film does not become steady: expected a change of at most {tolerance:g}, got "
            f"{change:g} in the last of {MOST_STEPS} steps; try a larger tolerance or another grid"
        )

    def tangent(
        self,
        dfilm_thickness: Array | float,
        *,
        dsliding_velocity: Array | float = 0.0,
        dcircumferential_velocity: Array | float | None = None,
    ) -> tuple[Array, ...]:
        """Return the exact change of the nodal forces for a change of the inputs of the last step.

        The inputs change at its end [m], [m/s]. The result holds `nodal_pressure_force` and
        `nodal_friction_force` [N], of a bearing also `nodal_circumferential_force`.
        """
        turning = dcircumferential_velocity
        if turning is None and self._is_bearing:
            turning = 0.0
        velocities = self._velocities(dsliding_velocity, turning)
        return self.model.tangent(self._field(dfilm_thickness), *velocities)

    @property
    def _is_bearing(self) -> bool:
        return self.model.parameters.surface == "bearing"

    def _velocities(
        self, sliding: Array | float | None, turning: Array | float | None
    ) -> tuple[Array, Array | None]:
        """Axial and circumferential velocity; BadInput unless they fit the surface."""
        if self._is_bearing:
            if turning is None:
                raise BadInput(
                    "circumferential_velocity: expected the velocity of journal minus shell [m/s], "
                    "got nothing; a journal at rest has 0.0"
                )
            return self._field(0.0 if sliding is None else sliding), self._field(turning)
        if sliding is None:
            raise BadInput(
                "sliding_velocity: expected the velocity of skirt minus bore [m/s], got nothing"
            )
        if turning is not None:
            raise BadInput("circumferential_velocity: expected nothing for a skirt, got a value")
        return self._field(sliding), None

    def _field(self, values: Array | float) -> Array:
        """Return an array of the grid."""
        array = np.asarray(values, dtype=float)
        if array.shape not in ((), self.grid):
            raise BadInput(f"array: expected shape {self.grid}, got {array.shape}")
        if not np.isfinite(array).all():
            raise BadInput("array: expected finite values, got others")
        return np.ascontiguousarray(np.broadcast_to(array, self.grid))


def _change(before: Mapping[str, Any], after: Mapping[str, Any]) -> float:
    """Return the larger change of film fraction and of pressure over its maximum [-]."""
    largest = max(np.abs(after["pressure"]).max(), SCALE)
    pressure = np.abs(after["pressure"] - before["pressure"]).max() / largest
    return max(pressure, np.abs(after["film_fraction"] - before["film_fraction"]).max())


def _read(parameters: Mapping[str, str | float]) -> dict[str, Any]:
    """Parameters in SI; BadInput with every fault."""
    values, sentences = {}, []
    for name, given in parameters.items():
        variable = KNOWN.get(name)
        if variable is None:
            sentences.append(f"{name}: {unknown('parameter', name, KNOWN)}")
            continue
        try:
            is_quantity = isinstance(given, str) and not variable.choices
            values[name] = to_si(given, variable.unit) if is_quantity else given
        except ValueError as error:
            sentences.append(f"{name}: {error}")
            continue
        if fault := variable.fault(values[name]):
            sentences.append(fault)
    if sentences:
        raise BadInput(sentences)
    return values


def _grid(grid: tuple[int, int]) -> tuple[int, int]:
    """Numbers of cells, checked."""
    if len(grid) != 2 or not all(isinstance(n, (int, np.integer)) and n >= 1 for n in grid):
        raise BadInput(f"grid: expected two numbers of cells, around and along, got {grid}")
    around, along = grid
    return int(around), int(along)


def _cells(grid: tuple[int, int], open_cells: Flags | None) -> Flags | None:
    """Cut-outs, checked."""
    if open_cells is None:
        return None
    cells = np.asarray(open_cells, dtype=bool)
    if cells.shape != tuple(grid):
        raise BadInput(f"open_cells: expected shape {tuple(grid)}, got {cells.shape}")
    return cells
