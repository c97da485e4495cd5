"""The lubrication model: film, oil, contact and friction of one surface, one step at a time."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from . import asperity, circumferential, coated_film, coating, friction, openings
from . import step_parts as parts
from .asperity import ContactConstants
from .circumferential import Changes, Turning, TurningSlopes
from .coated_film import Layer, Pressed
from .contact import contact_changes
from .faults import none_yet, raise_noted
from .film_step import HARD, NO_FILM, NO_LIFT, FilmSolution, FilmStep, Given
from .films import COUETTE, STORED, FilmSlopes
from .flow_film import FilmLaws, FlowFilm, Sheared, flow_film
from .friction import ForceSlopes
from .grid import BOTH_AXIAL_EDGES, Array, Entrainment, Flags, Grid
from .oil_layer import Bore, OilLayer, Passed
from .parameters import FULL_TURN, Parameters
from .piezoviscosity import TruePressure, raised, true_pressure
from .roughness import factor_table
from .storage import EulerStep
from .summary import halves
from .surroundings import Surroundings, surroundings
from .transport import Lift

# where oil outside the film is not followed
NOTHING = np.zeros((0, 0))
NO_LAYER = OilLayer(NOTHING, NOTHING, NOTHING, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
BATCH = 64  # directions at once: bounds the memory of a large Jacobian


@dataclass(frozen=True)
class State:
    """All that a step needs from the past; arrays of shape (n_c, n_a).

    Parameters
    ----------
    unknown, unknown_before : ndarray
        Signed unknown at the end of the last two steps: its extrapolation starts the next one, so a
        repeat takes the same path.
    content, growth, growth_before : ndarray
        film_fraction x stored film [m], and its growth over the last step and the one before [m/s],
        `storage.Past`.
    deflection : ndarray
        Of the coating [m].
    step_before : float
        Length of the last step [s]; 0 at the start.
    film, film_before : ndarray, shape (7, n_c, n_a)
        Quantities of `films` at the end of the last two steps.
    passed, travel : ndarray, shape (n_c, n_a + 1)
        Volume that passed the axial faces [m3], and travel of the entrainment there [m], in the
        last step, `transport`.
    layer : oil_layer.OilLayer
        Oil outside the film; without it no cells of the bore.
    friction_work, boundary_work : float
        What sliding has cost since the start, and the asperities' part of it [J].
    stored, volume : float
        Elastic energy [J], and volume between the surfaces [m3].
    """

    unknown: Array
    unknown_before: Array
    content: Array
    growth: Array
    growth_before: Array
    deflection: Array
    step_before: float
    film: Array
    film_before: Array
    passed: Array
    travel: Array
    layer: OilLayer
    friction_work: float
    boundary_work: float
    stored: float
    volume: float

    @property
    def before(self) -> parts.Before:
        """What the film remembers."""
        return parts.Before(
            self.unknown,
            self.unknown_before,
            self.content,
            self.growth,
            self.growth_before,
            self.film,
            self.film_before,
            self.passed,
            self.travel,
            self.step_before,
        )

    @property
    def totals(self) -> parts.Totals:
        """Sums that go on."""
        return parts.Totals(self.friction_work, self.boundary_work, self.stored, self.volume)


class Inputs(NamedTuple):
    """What a film is given at the end of a step.

    hard_film, deflection : ndarray, shape (n_c, n_a), film thickness without the deflection of a
    coating, and that [m];
    sliding_velocity, circumferential_velocity : ndarray, shape (n_c, n_a), V and W [m/s];
    surroundings : surroundings.Surroundings.
    """

    hard_film: Array
    deflection: Array
    sliding_velocity: Array
    circumferential_velocity: Array
    surroundings: Surroundings

    @property
    def film_thickness(self) -> Array:
        """Of the film, Eq. (L2) [m]."""
        return self.hard_film + self.deflection  # Eq. (L2)


@dataclass(frozen=True)
class Film:
    """A solved film; arrays of shape (n_c, n_a).

    Parameters
    ----------
    inputs : Inputs
    flow : FlowFilm
    fraction : ndarray
        Film fraction [-].
    under : piezoviscosity.TruePressure
    """

    inputs: Inputs
    flow: FlowFilm
    fraction: Array
    under: TruePressure


class Last(NamedTuple):
    """What the tangent needs of the last step; turning : None on a skirt."""

    film: Film
    forces: parts.Forces
    turning: Turning | None


class Linear(NamedTuple):
    """What every direction of a tangent shares.

    film : friction.ForceSlopes; weight : ndarray, shape (n_c, n_a), c k of Eq. (L3) [m/Pa], of
    shape (0, 0) without a coating; around : circumferential.TurningSlopes, None on a skirt;
    touching : whether any cell is in contact;
    contact_pressure, contact_shear, contact_around : ndarray, shape (5, n_c, n_a), derivatives of
    the contact's forces to the film thickness of a cell and its neighbours, as of
    `contact.Contact` [N/m]; none where nothing touches.
    """

    film: ForceSlopes
    weight: Array
    around: TurningSlopes | None
    touching: bool
    contact_pressure: Array
    contact_shear: Array
    contact_around: Array


class StepFilm(NamedTuple):
    """Outcome of one of the ways to the film of a step; deflection of the coating [m]."""

    inputs: Inputs
    flow: FlowFilm
    solution: FilmSolution
    deflection: Array


class LubricationModel:
    """Transient film, asperity contact and friction between skirt and bore, or journal and shell.

    Parameters
    ----------
    parameters : Parameters
    """

    def __init__(self, parameters: Parameters):
        p = self.parameters = parameters
        n_circumferential, _ = p.shape
        ring = p.sector_angle == FULL_TURN
        self.grid = Grid(p.shape, p.sector_angle * p.bore_radius, p.skirt_length, ring)
        self._bearing = p.surface == "bearing"
        self.film_step = FilmStep(self.grid, p.cavitation_model, p.open_cells)
        self._open_cells = self.film_step.domain.open_cells
        self._has_openings = self.film_step.domain.has_openings
        cells = self.grid.cells
        self._beside = openings.nearest(self._open_cells, cells.dx, cells.dy)
        self.area = np.where(self._open_cells, 0.0, self.grid.cell_area)
        self._contact_constants = ContactConstants(
            p.roughness_rms,
            asperity.pressure_scale(p.asperity_product, p.asperity_slope, p.contact_modulus),
            np.pi**2 * p.asperity_product**2,
            p.boundary_friction_coefficient,
            p.boundary_shear_strength,
            asperity.contact_table(p.contact_law),
        )
        factors = NOTHING
        if p.flow_factors == "patir_cheng_1978":
            factors = factor_table(
                p.roughness_share_skirt, p.peklenik_number_skirt, p.peklenik_number_bore
            )
        self._laws = FilmLaws(p.minimum_flow_film, p.roughness_rms, factors, p.oil.thinning)
        self._compliance = coating.compliance(
            p.coating_thickness, p.coating_modulus, p.coating_poisson
        )
        self._zero = np.zeros(p.shape)
        self._no_deflection = np.zeros((BATCH, *p.shape))
        # entrainment velocity in the frame of the grid to the sliding velocity: along, around
        self._share = 0.5 if self._bearing else -0.5
        share = np.full(p.shape, self._share)
        self._dentrainment = Entrainment(self._zero, share)
        self._dentrainment_around = Entrainment(share, self._zero)
        self._surfaces = parts.Surfaces(
            self.area,
            self._contact_constants,
            halves(n_circumferential),
            self._compliance,
            p.cavitation_pressure,
            p.friction_rounding_velocity,
            p.cavity_shear == "film_fraction",
        )
        self._bore = Bore(p, self.grid) if p.oil_supply != "edges" else None
        self._given = surroundings(p, {})
        # of the last step: what the tangent needs
        self._last: Last | None = None
        self._linear: Linear | None = None

    # ---- steps

    def start(
        self,
        film_thickness: Array,
        sliding_velocity: Array,
        circumferential_velocity: Array | None = None,
        **conditions: Any,
    ) -> tuple[State, dict[str, Any]]:
        """State and outputs at the start: a full film, reduced pressure linear between the edges;
        or one filled in part, without pressure.

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
        state : State
        outputs : dict
            As from `advance`.
        """
        around = self._surroundings(conditions)
        film_thickness = self._filled(film_thickness)
        sliding_velocity = self._filled(sliding_velocity)
        turning = self._turning(circumferential_velocity)
        inputs = Inputs(film_thickness, self._zero, sliding_velocity, turning, around)
        shape = self.grid.shape
        _, n_axial = shape
        lower, upper = around.edges.pressure[BOTH_AXIAL_EDGES]
        along = (np.arange(n_axial) + 0.5) / n_axial
        fraction = np.full(shape, self.parameters.initial_film_fraction)
        pressure = np.where(fraction < 1.0, 0.0, lower + (upper - lower) * along)
        unknown = np.where(fraction < 1.0, fraction - 1.0, pressure)
        flow = self._flow_film(inputs)
        film = self._film(inputs, flow, pressure, fraction)
        last, _, outputs = self._outputs(film)
        outputs |= dict(
            stored_energy=last.forces.stored,
            energy_gain=0.0,
            flow_lower_edge=0.0,
            flow_upper_edge=0.0,
            flow_openings=0.0,
            mass_imbalance=0.0,
            solver_iterations=0,
            boundary_friction_share=0.0,
        )
        content = fraction * flow.quantities[STORED]
        layer = NO_LAYER if self._bore is None else self._bore.start(float(sliding_velocity.mean()))
        outputs |= self._oil(parts.oil_in(content, self.area), layer)
        still = self._zero
        no_flow = np.zeros((shape[0], n_axial + 1))
        state = State(
            unknown,
            unknown,
            content,
            still,
            still,
            np.zeros(shape),
            0.0,
            flow.quantities,
            flow.quantities,
            no_flow,
            no_flow,
            layer,
            0.0,
            0.0,
            last.forces.stored,
            last.forces.volume,
        )
        return state, outputs

    def advance(
        self,
        state: State,
        film_thickness: Array,
        sliding_velocity: Array,
        step: float,
        circumferential_velocity: Array | None = None,
        **conditions: Any,
    ) -> tuple[State, dict[str, Any]]:
        """One step from `state` to the given film and velocity, of second order in time, `storage`.

        Parameters
        ----------
        state : State
            At the beginning of the step.
        film_thickness, sliding_velocity : ndarray, shape (n_c, n_a)
            At the end of the step [m], [m/s].
        step : float
            H [s], > 0.
        circumferential_velocity : ndarray, shape (n_c, n_a), optional
            W of a bearing at the end of the step [m/s]; 0 by default.
        **conditions
            At the end of the step, as for `surroundings.surroundings`.

        Returns
        -------
        state : State
            At the end of the step.
        outputs : dict
            Output variable name -> value, `variables.py`.

        Raises
        ------
        cavitation.NotConverged
        """
        self._last = None  # a refused step has no tangent
        self._linear = None
        film_thickness = self._filled(film_thickness)
        sliding_velocity = self._filled(sliding_velocity)
        faults = none_yet()
        parts.check_film(film_thickness, faults)
        raise_noted(faults)
        around = self._surroundings(conditions) if conditions else self._given
        before = state.before
        begun = parts.begin(before, step)
        begin = begun.start
        pace = begun.pace
        layer = state.layer
        covered = layer
        if self._bore is not None:
            covered = self._bore.covered(
                layer, step, state.step_before, around.ring_layer, around.splash
            )
            limit = self._bore.limit(covered, self._bore.inflow(pace.share * state.passed), begin)
            around = replace(around, edges=around.edges._replace(limit=limit))
        turning = self._turning(circumferential_velocity)
        inputs = Inputs(film_thickness, self._zero, sliding_velocity, turning, around)
        lift = NO_LIFT  # around a bearing oil is carried on without
        if not self._bearing:
            lift = parts.lift(before, pace, around.edges, step, self.film_step.domain)
        step_film = self._coated if self._compliance > 0.0 else self._bare
        inputs, flow, solution, deflection = step_film(state, begin, inputs, begun.guess, lift)
        film = self._film(inputs, flow, solution.pressure, solution.film_fraction)
        self._last, powers, outputs = self._outputs(film)
        axial = self._entrainment(inputs).axial
        went = parts.passage(before, begun, solution, axial, step, self.film_step.domain)
        outside = parts.Outside(
            self.parameters.cavitation_pressure, around.lower, around.upper, around.opening
        )
        acted = self._last.forces
        account = parts.account(state.totals, acted, powers, solution, went.passed, outside, step)
        totals = account.totals
        lower, upper = solution.edge_flow[BOTH_AXIAL_EDGES]
        outputs |= dict(
            flow_lower_edge=float(lower),
            flow_upper_edge=float(upper),
            flow_openings=solution.from_openings,
            mass_imbalance=solution.mass_imbalance,
            solver_iterations=solution.iterations,
            boundary_friction_share=account.boundary_share,
            stored_energy=totals.stored,
            energy_gain=account.energy_gain,
        )
        if self._bore is not None:
            spilled = pace.share * layer.spilled  # Eq. (T28)
            if self._has_openings:
                spilled = spilled + begin.length * solution.spilled
            layer = self._bore.left(
                covered,
                layer,
                Passed(self._bore.inflow(went.passed), spilled),
                self._bore.gaps(inputs.film_thickness),
                float(sliding_velocity.mean()),
                step,
            )
        outputs |= self._oil(account.oil, layer)
        state = State(
            solution.unknown,
            state.unknown,
            solution.content,
            went.growth,
            state.growth,
            deflection,
            step,
            flow.quantities,
            state.film,
            went.passed,
            went.travel,
            layer,
            *totals,
        )
        return state, outputs

    def tangent(
        self,
        dfilm_thickness: Array,
        dsliding_velocity: Array,
        dcircumferential_velocity: Array | None = None,
    ) -> tuple[Array, ...]:
        """Change of the forces at the end of the last step for changed inputs there, its state at
        the beginning held.

        Parameters
        ----------
        dfilm_thickness, dsliding_velocity : ndarray, shape (n_c, n_a) or (m, n_c, n_a)
            [m], [m/s]; m directions at once cost less than m single ones.
        dcircumferential_velocity : ndarray, of the same shape, optional
            Of a bearing [m/s]; 0 by default.

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
            self._linear = self._linearise(last)
        linear = self._linear
        shape = (-1, *self.grid.shape)
        dfilm = self._filled(np.ascontiguousarray(dfilm_thickness).reshape(shape))
        dvelocity = self._filled(np.ascontiguousarray(dsliding_velocity).reshape(shape))
        dturning = None
        if dcircumferential_velocity is not None:
            dturning = np.ascontiguousarray(dcircumferential_velocity).reshape(shape)
            dturning = self._filled(dturning)
        # in one piece: malloc gives two back to the system and asks again each time
        forces = np.empty((2 if linear.around is None else 3, *dfilm.shape))
        normal = forces[0]
        shear = forces[1]
        for k in range(0, len(dfilm), BATCH):
            some = slice(k, k + BATCH)
            hard = dfilm[some]
            turning = None if dturning is None else dturning[some]
            deflection, unknown = self._film_changes(last, linear, hard, dvelocity[some], turning)
            film = hard + deflection if self._compliance else hard
            friction.force_changes(
                linear.film, film, dvelocity[some], unknown, normal[some], shear[some]
            )
            if linear.touching:
                add = parts.add_contact_changes
                add(linear.contact_pressure, hard, deflection, normal[some])
                add(linear.contact_shear, hard, deflection, shear[some])
            if linear.around is None or last.turning is None:
                continue
            turned = np.zeros_like(film) if turning is None else turning
            changes = Changes(film, dvelocity[some], turned, unknown)
            forces[2, some] = circumferential.force_changes(
                linear.around, linear.film, last.turning, changes, shear[some]
            )
            if linear.touching:
                parts.add_contact_changes(linear.contact_around, hard, deflection, forces[2, some])
        shape = np.shape(dfilm_thickness)
        return tuple(forces[k].reshape(shape) for k in range(len(forces)))

    def _film_changes(
        self, last: Last, linear: Linear, dfilm: Array, dvelocity: Array, dturning: Array | None
    ) -> tuple[Array, Array]:
        """Changes of the coating's deflection and of the signed unknown for stacked directions; the
        coating yields to the change of pressure, Eq. (L3).
        """
        if not self._compliance:
            unknown = self.film_step.tangent(dfilm, dvelocity, dturning)
            return self._no_deflection[: len(dfilm)], unknown
        by_contact = contact_changes(
            last.forces.contact.pressure_slope, dfilm, np.zeros_like(dfilm)
        )
        moved = coating.pushed(linear.weight, by_contact, dfilm)
        dunknown = self.film_step.tangent(moved, dvelocity, dturning)
        share = linear.film.pressure_share
        return coating.deflection_changes(linear.weight, by_contact, share, dunknown), dunknown

    def _linearise(self, last: Last) -> Linear:
        """Derivatives of the forces of the last step that every direction shares."""
        film, acted, turning = last
        shear = acted.shear
        contact = acted.contact
        slopes = film.flow.slopes
        slopes_around = film.flow.slopes_around
        shares = self.film_step.linearise(slopes, self._dentrainment)
        if turning is not None:
            self.film_step.linearise_around(slopes_around, self._dentrainment_around)
        contact_pressure = contact_shear = contact_around = NOTHING
        if acted.touching:
            contact_pressure, contact_shear = parts.contact_slopes(
                shear, contact.pressure_slope, contact.shear_stress_slope
            )
        around = None
        along = shear
        if turning is not None:
            axial, across = circumferential.boundary_shares(shear, turning)
            contact_shear = axial * contact.shear_stress_slope
            contact_around = across * contact.shear_stress_slope
            quantities = film.flow.quantities
            ratio = film.under.ratio
            by_pressure = self._zero
            if ratio.size:
                by_pressure = (
                    -self.area * shear.shearing * turning.velocity * quantities[COUETTE]
                ) * film.under.slope
            both = _raised_slopes(slopes, ratio), _raised_slopes(slopes_around, ratio)
            around = circumferential.force_slopes(shear, turning, both, by_pressure)
            along = shear._replace(boundary_stress=self._zero)  # stands in `around`
        of_film = parts.force_slopes(
            along, film.flow.quantities, slopes, shares, film.under, self._surfaces.by_oil
        )
        weight = NOTHING
        if self._compliance:
            weight = self._compliance * coating.yielding(self._compliance, contact.pressure_slope)
        return Linear(
            of_film, weight, around, acted.touching, contact_pressure, contact_shear, contact_around
        )

    # ---- ways to a film

    def _entrainment(self, inputs: Inputs) -> Entrainment:
        """In the frame of the grid, which rides on the skirt or rests on the shell of a bearing."""
        axial = self._share * inputs.sliding_velocity
        if not self._bearing:
            return Entrainment(self._zero, axial)
        return Entrainment(self._share * inputs.circumferential_velocity, axial)

    def _turning(self, circumferential_velocity: Array | None) -> Array:
        """W of a step, 0 where none is given."""
        if circumferential_velocity is None:
            return self._zero
        return self._filled(circumferential_velocity)

    def _bare(
        self, state: State, begin: EulerStep, inputs: Inputs, guess: Flags, lift: Lift
    ) -> StepFilm:
        """Film of hard surfaces."""
        flow = self._flow_film(inputs)
        solution = self.film_step.solve(
            flow.quantities,
            self._entrainment(inputs),
            inputs.surroundings.edges,
            begin,
            guess,
            HARD,
            lift,
        )
        return StepFilm(inputs, flow, solution, state.deflection)

    def _coated(
        self, state: State, begin: EulerStep, inputs: Inputs, guess: Flags, lift: Lift
    ) -> StepFilm:
        """Film under a coating that yields to the pressure."""
        around = inputs.surroundings
        layer = Layer(
            self._compliance,
            self._contact_constants,
            self._laws,
            around.pressure_law,
            self._share,
        )
        pressed = Pressed(inputs.hard_film, state.deflection, state.unknown, self._sheared(inputs))
        given = Given(NO_FILM, self._entrainment(inputs), around.edges, begin, guess, HARD, lift)
        found = self.film_step.run(coated_film.solve, pressed, layer, given)
        self.film_step.keep(found.given, found.solution)
        inputs = inputs._replace(deflection=found.deflection)
        return StepFilm(inputs, found.flow, found.solution, found.deflection)

    # ---- parts of a step

    def _oil(self, in_film: float, layer: OilLayer) -> dict[str, float]:
        """Where the oil is."""
        # the three terms of Eq. (T27)
        return dict(
            oil_in_film=in_film,
            oil_on_bore=self._bore.volume(layer) if self._bore is not None else 0.0,
            oil_supplied=layer.supplied,
        )

    def _sheared(self, inputs: Inputs) -> Sheared:
        """Oil that is sheared."""
        around = inputs.surroundings
        return Sheared(
            inputs.sliding_velocity,
            inputs.circumferential_velocity,
            around.viscosity,
            np.ascontiguousarray(around.temperature),
        )

    def _flow_film(self, inputs: Inputs) -> FlowFilm:
        """Film seen by flow and shear."""
        return flow_film(inputs.film_thickness, self._sheared(inputs), self._laws)

    def _surroundings(self, conditions: dict[str, Any]) -> Surroundings:
        """What is around the skirt, whatever the temperature in cells without a film."""
        field = conditions.get("oil_temperature")
        if field is not None:
            conditions = conditions | dict(oil_temperature=self._filled(field))
        return surroundings(self.parameters, conditions)

    def _filled(self, field: Array) -> Array:
        """A field (..., n_c, n_a), whatever it says in cells without a film."""
        if not self._has_openings:
            return field
        given = np.ascontiguousarray(field, dtype=float)
        stacked = given.reshape(-1, *self.grid.shape)
        return openings.filled(self._beside, stacked).reshape(given.shape)

    def _film(self, inputs: Inputs, flow: FlowFilm, reduced: Array, fraction: Array) -> Film:
        """The film with true pressure."""
        return Film(
            inputs, flow, fraction, true_pressure(inputs.surroundings.pressure_law, reduced)
        )

    def _outputs(self, film: Film) -> tuple[Last, parts.Powers, dict[str, Any]]:
        """What the tangent needs, powers, and fields and scalars that every lubrication FMU has,
        except flows and counters.
        """
        p = self.parameters
        inputs = film.inputs
        around = inputs.surroundings
        seen = parts.Film(
            inputs.hard_film,
            inputs.deflection,
            inputs.sliding_velocity,
            inputs.circumferential_velocity,
            raised(film.flow.quantities, film.under.ratio),
            film.under.pressure,
            film.fraction,
            around.lower,
            around.upper,
        )
        faults = none_yet()
        acted = parts.forces(seen, self._surfaces, self.film_step.domain, faults)
        raise_noted(faults)
        summary = acted.summary
        outputs = dict(
            nodal_pressure_force=acted.pressure,
            nodal_friction_force=acted.friction,
            pressure=acted.absolute,
            asperity_pressure=acted.contact.pressure,
            film_fraction=film.fraction,
            minimum_film_thickness=min(summary.thinnest),
            maximum_pressure=summary.highest,
            friction_force_hydrodynamic=summary.hydrodynamic,
            friction_force_asperity=summary.asperity,
            friction_power=summary.power,
            contact_area_fraction=summary.contact_area,
        )
        power = summary.power
        boundary_power = acted.boundary_power
        rubbing_power = acted.rubbing_power
        turning = None
        if not self._bearing:
            outputs |= dict(
                minimum_film_thickness_thrust_side=summary.thinnest.thrust,
                radial_force_thrust_side=summary.radial.thrust,
                friction_force_thrust_side=summary.friction.thrust,
                minimum_film_thickness_anti_thrust_side=summary.thinnest.anti_thrust,
                radial_force_anti_thrust_side=summary.radial.anti_thrust,
                friction_force_anti_thrust_side=summary.friction.anti_thrust,
            )
        else:
            cells = self.grid.cells
            shear = acted.shear
            turning = Turning(inputs.circumferential_velocity, around.opening, cells.dx, cells.ring)
            around_forces = circumferential.shear_forces(shear, turning)
            turned = around_forces.viscous + around_forces.boundary
            thickness = np.maximum(inputs.film_thickness, p.minimum_flow_film)
            carried = circumferential.carried_power(shear, turning, thickness)
            boundary_power -= float(np.vdot(around_forces.boundary, turning.velocity))
            # of what pressure carries half shears the journal back: what turns it is heat, Eq. (F8)
            rubbing_power += circumferential.rubbing_power(shear, turning) + carried / 2
            power = power - float(np.vdot(turned, turning.velocity)) + carried  # Eq. (F8)
            outputs |= dict(
                nodal_circumferential_force=turned,
                friction_torque=p.bore_radius * float(turned.sum()),
                friction_power=power,
            )
        powers = parts.Powers(power, boundary_power, rubbing_power + boundary_power)
        return Last(film, acted, turning), powers, outputs


def _raised_slopes(slopes: FilmSlopes, ratio: Array) -> FilmSlopes:
    """Derivatives of `raised` quantities."""
    return FilmSlopes(raised(slopes.by_film, ratio), raised(slopes.by_velocity, ratio))
