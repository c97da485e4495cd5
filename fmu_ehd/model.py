"""The lubrication model: film, oil, contact and friction of one skirt, one step at a time."""

from dataclasses import dataclass, replace

import numpy as np

from . import asperity, coating, friction, storage
from .cavitation import NotConverged
from .film_step import FilmStep
from .films import FlowFilm, rough_film, smooth_film, thin
from .grid import Grid
from .roughness import factor_table
from .summary import halves, summarise
from .surroundings import Surroundings, surroundings

BATCH = 64  # directions at once: bounds the memory of a large Jacobian


@dataclass(frozen=True)
class State:
    """All that a step needs from the past; arrays of shape (n_c, n_a).

    Parameters
    ----------
    unknown, unknown_before : ndarray
        Signed unknown at the end of the last two steps: its extrapolation starts the next one, so a
        repeat takes the same path.
    content, content_before : ndarray
        film_fraction x stored film at the end of the last two steps [m], `storage`.
    deflection : ndarray
        Of the coating [m].
    step_before : float
        Length of the last step [s]; 0 at the start.
    """

    unknown: np.ndarray
    unknown_before: np.ndarray
    content: np.ndarray
    content_before: np.ndarray
    deflection: np.ndarray
    step_before: float


@dataclass(frozen=True)
class Film:
    """A solved film; arrays of shape (n_c, n_a).

    Parameters
    ----------
    sliding_velocity : ndarray
        [m/s].
    values, slopes : ndarray, shape (7, n_c, n_a)
        `films.FlowFilm` quantities and their derivatives to film thickness.
    velocity_slopes : ndarray, shape (7, n_c, n_a), or (0, n_c, n_a) if all zero
        Their derivatives to sliding velocity.
    pressure, fraction : ndarray
        Above cavitation pressure [Pa], film fraction [-].
    ratio, dratio : ndarray
        mu/mu_0 = dp/dq of thickening by pressure [-] and its derivative to the pressure [1/Pa];
        None without.
    surroundings : surroundings.Surroundings
    """

    sliding_velocity: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    velocity_slopes: np.ndarray
    pressure: np.ndarray
    fraction: np.ndarray
    ratio: np.ndarray | None
    dratio: np.ndarray | None
    surroundings: Surroundings


class LubricationModel:
    """Transient film, asperity contact and friction between skirt and bore.

    Parameters
    ----------
    parameters : Parameters
    """

    def __init__(self, parameters):
        p = self.parameters = parameters
        self.grid = Grid(p.shape, 2.0 * np.pi * p.bore_radius, p.skirt_length)
        self.film_step = FilmStep(self.grid, p.cavitation_model, p.open_cells)
        self.area = np.where(self.film_step.open_cells, 0.0, self.grid.cell_area)
        self._contact = (
            p.roughness_rms,
            asperity.pressure_scale(p.asperity_product, p.asperity_slope, p.contact_modulus),
            np.pi**2 * p.asperity_product**2,
            p.boundary_friction_coefficient,
            p.boundary_shear_strength,
            asperity.contact_table(p.contact_law),
        )
        self._factors = (
            factor_table(p.peklenik_number) if p.flow_factors == "patir_cheng_1978" else None
        )
        self._thins = p.oil.shear_thinning_law != "none"
        self._compliance = coating.compliance(
            p.coating_thickness, p.coating_modulus, p.coating_poisson
        )
        self._no_velocity = np.zeros(p.shape)
        self._no_slopes = np.zeros((0, *p.shape))
        self._half_back = np.full(
            p.shape, -0.5
        )  # entrainment velocity of the grid, which rides on the skirt
        self._halves = halves(p.shape[0])
        self._given = surroundings(p, {})
        self._last = self._linear = None  # of the last step: what the tangent needs

    # ---- steps
    # ------------------------------------------------------------------------------------------------------

    def start(self, film_thickness, sliding_velocity, **conditions):
        """State and outputs at the start: a full film, reduced pressure linear between the edges.

        Parameters
        ----------
        film_thickness, sliding_velocity : ndarray, shape (n_c, n_a)
            h [m], V [m/s].
        **conditions
            As for `advance`.

        Returns
        -------
        state : State
        outputs : dict
            As from `advance`.
        """
        around = surroundings(self.parameters, conditions)
        lower, upper = around.edges.pressure[:2]
        along = (np.arange(self.grid.shape[1]) + 0.5) / self.grid.shape[1]
        unknown = np.broadcast_to(lower + (upper - lower) * along, self.grid.shape).copy()
        values, slopes, velocity_slopes = self._flow_film(film_thickness, sliding_velocity, around)
        film = self._film(
            sliding_velocity,
            values,
            slopes,
            velocity_slopes,
            unknown,
            np.ones(self.grid.shape),
            around,
        )
        _, outputs = self._outputs(film, film_thickness)
        outputs |= dict(
            flow_lower_edge=0.0, flow_upper_edge=0.0, mass_imbalance=0.0, solver_iterations=0
        )
        content = values[0].copy()
        return State(unknown, unknown, content, content, np.zeros(self.grid.shape), 0.0), outputs

    def advance(self, state, film_thickness, sliding_velocity, step, **conditions):
        """One step from `state` to the given film and velocity, of second order in time, `storage`.

        Parameters
        ----------
        state : State
            At the beginning of the step.
        film_thickness, sliding_velocity : ndarray, shape (n_c, n_a)
            At the end of the step [m], [m/s].
        step : float
            H [s], > 0.
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
        self._last = self._linear = None  # a refused step has no tangent
        if not film_thickness.max() > 0.0:
            raise NotConverged(
                f"film_thickness[1,1] = {film_thickness[0, 0]:g} m, and nowhere above 0 m: there is no film"
            )
        around = surroundings(self.parameters, conditions) if conditions else self._given
        ratio = step / state.step_before if state.step_before > 0.0 else 0.0
        guess = state.unknown + ratio * (state.unknown - state.unknown_before) > 0.0
        content, euler_step = storage.euler_step(
            state.content, state.content_before, step, state.step_before
        )
        find = self._coated if self._compliance > 0.0 else self._bare
        film_thickness, parts, solution, deflection = find(
            state, content, film_thickness, sliding_velocity, guess, around, euler_step
        )
        film = self._film(
            sliding_velocity, *parts, solution.pressure, solution.film_fraction, around
        )
        self._last, outputs = self._outputs(film, film_thickness)
        outputs |= dict(
            flow_lower_edge=float(solution.edge_flow[0]),
            flow_upper_edge=float(solution.edge_flow[1]),
            mass_imbalance=solution.mass_imbalance,
            solver_iterations=solution.iterations,
        )
        return State(
            solution.unknown, state.unknown, solution.content, state.content, deflection, step
        ), outputs

    def tangent(self, dfilm_thickness, dsliding_velocity):
        """Change of the forces at the end of the last step for changed inputs there, its state at
        the beginning held.

        Parameters
        ----------
        dfilm_thickness, dsliding_velocity : ndarray, shape (n_c, n_a) or (m, n_c, n_a)
            [m], [m/s]; m directions at once cost less than m single ones.

        Returns
        -------
        dnodal_pressure_force, dnodal_friction_force : ndarray, shape as given
            [N].

        Raises
        ------
        RuntimeError
            If no step was taken, or the last one was refused.
        """
        if self._last is None:
            raise RuntimeError(
                "the last step was refused, or there was none: it has no directional derivative"
            )
        if self._linear is None:
            self._linear = self._linearise()
        shape = (-1, *self.grid.shape)
        dfilm = np.ascontiguousarray(dfilm_thickness).reshape(shape)
        dvelocity = np.ascontiguousarray(dsliding_velocity).reshape(shape)
        normal, shear = np.empty(
            (2, *dfilm.shape)
        )  # in one piece: malloc gives two back to the system and asks again each time
        for k in range(0, len(dfilm), BATCH):
            some = slice(k, k + BATCH)
            self._force_changes(dfilm[some], dvelocity[some], normal[some], shear[some])
        return normal.reshape(np.shape(dfilm_thickness)), shear.reshape(np.shape(dfilm_thickness))

    def _force_changes(self, dfilm, dvelocity, normal, shear):
        """`tangent` for stacked directions; a coating yields to the change of pressure, Eq.
        (L3).
        """
        if not self._compliance:
            friction.force_changes(
                *self._linear,
                dfilm,
                dvelocity,
                self.film_step.tangent(dfilm, dvelocity),
                normal,
                shear,
            )
            return
        yielding = 1.0 / (1.0 - self._compliance * self._last[1][1])
        dunknown = self.film_step.tangent(yielding * dfilm, dvelocity)
        to_pressure = self._linear[5]
        dfilm = yielding * (dfilm + self._compliance * to_pressure * dunknown)
        friction.force_changes(*self._linear, dfilm, dvelocity, dunknown, normal, shear)

    def _linearise(self):
        """Derivatives of the forces of the last step that every direction shares."""
        film, contact, shear_inputs = self._last
        by_film, by_velocity = film.slopes, film.velocity_slopes
        to_pressure, to_fraction = self.film_step.linearise(
            by_film, by_velocity, self._no_velocity, self._half_back
        )
        by_pressure = self._no_velocity
        shear_by_film, shear_by_velocity = by_film[4:], by_velocity[4:]
        if film.ratio is not None:
            scale = np.stack([film.ratio, film.ratio, np.ones_like(film.ratio)])
            shear_by_film, shear_by_velocity = (
                shear_by_film * scale,
                shear_by_velocity * scale[: len(shear_by_velocity)],
            )
            by_pressure = (
                -self.area
                * shear_inputs[1]
                * film.sliding_velocity
                * (film.values[4] - film.values[5])
                * film.dratio
            )
            to_pressure = to_pressure * film.ratio  # dp/dq, Eq. (O6)
        slopes = friction.shear_slopes(*shear_inputs, shear_by_film, shear_by_velocity, contact[4])
        if self.parameters.cavity_shear == "full_film":
            to_fraction = self._no_velocity
        return (
            slopes,
            by_pressure,
            contact[1],
            self.area,
            self.grid.spacing[1],
            to_pressure,
            to_fraction,
        )

    # ---- ways to a film
    # ---------------------------------------------------------------------------------------------

    def _bare(self, state, content, film_thickness, sliding_velocity, guess, around, step):
        """Film thickness, `_flow_film`, solution of the film balance, deflection: of hard
        surfaces.
        """
        parts = self._flow_film(film_thickness, sliding_velocity, around)
        solution = self.film_step.solve(
            FlowFilm(*parts[0]),
            self._no_velocity,
            -0.5 * sliding_velocity,
            around.edges,
            content,
            guess,
            step,
        )
        return film_thickness, parts, solution, state.deflection

    def _coated(self, state, content, film_thickness, sliding_velocity, guess, around, step):
        """The same with a coating that yields to the pressure, by Newton's method, `coating`."""
        c, law, velocities = (
            self._compliance,
            around.thickening,
            (self._no_velocity, -0.5 * sliding_velocity),
        )
        deflection, unknown, full, factorisations = (
            state.deflection,
            state.unknown,
            state.unknown > 0.0,
            0,
        )
        for _ in range(coating.LIMIT):
            film = film_thickness + deflection
            parts = self._flow_film(film, sliding_velocity, around)
            reduced, deficit = self.film_step.model.interpret(unknown, full)
            pressure = law.pressure(reduced) if law else reduced
            ratio = law.ratio(pressure)[0] if law else 1.0
            slopes = self.film_step.slopes(
                FlowFilm(*parts[0]),
                *parts[1:],
                velocities,
                (self._no_velocity, self._half_back),
                reduced,
                1.0 + deficit,
                around.edges,
                step,
            )
            touching, touching_slope, *_ = asperity.contact(film, *self._contact)
            weight, offset = coating.linear_deflection(
                c, deflection, touching, touching_slope, pressure, ratio, reduced
            )
            solution = self.film_step.solve(
                FlowFilm(*parts[0]),
                *velocities,
                around.edges,
                content,
                guess,
                step,
                (slopes[0], weight, offset),
            )
            factorisations += solution.iterations
            change = weight * solution.pressure + offset
            if coating.settled(change, deflection):
                return film, parts, replace(solution, iterations=factorisations), deflection
            deflection, unknown, full, guess = (
                deflection + change,
                solution.unknown,
                solution.full,
                solution.full,
            )
        worst = np.unravel_index(np.argmax(np.abs(change)), change.shape)
        raise NotConverged(
            f"deflection of the coating did not settle in {coating.LIMIT} iterations: last change "
            f"{change[worst]:g} m at [{worst[0] + 1},{worst[1] + 1}]"
        )

    # ---- parts of a step
    # --------------------------------------------------------------------------------------------

    def _flow_film(self, film_thickness, sliding_velocity, around):
        """`FlowFilm` quantities stacked to (7, n_c, n_a), and their derivatives to film and
        velocity, as in `Film`.
        """
        p = self.parameters
        if self._factors is None:
            values, slopes = smooth_film(film_thickness, around.viscosity, p.minimum_flow_film)
        else:
            values, slopes = rough_film(
                film_thickness,
                around.viscosity,
                p.minimum_flow_film,
                p.roughness_rms,
                2.0 * p.roughness_share_skirt - 1.0,
                self._factors,
            )
        if not self._thins:
            return values, slopes, self._no_slopes
        thickness = np.maximum(film_thickness, p.minimum_flow_film)
        thinning = p.oil.thinning(np.abs(sliding_velocity) / thickness, around.temperature)
        return thin(
            values,
            slopes,
            *thinning,
            thickness,
            film_thickness > p.minimum_flow_film,
            sliding_velocity,
        )

    def _film(self, sliding_velocity, values, slopes, velocity_slopes, reduced, fraction, around):
        """The film with true pressure; thickening by pressure enters the shear stress here."""
        pressure, ratio, dratio = reduced, None, None
        if around.thickening:
            pressure = around.thickening.pressure(reduced)
            ratio, dratio = around.thickening.ratio(pressure)
        return Film(
            sliding_velocity,
            values,
            slopes,
            velocity_slopes,
            pressure,
            fraction,
            ratio,
            dratio,
            around,
        )

    def _outputs(self, film, film_thickness):
        """What the tangent needs, and fields and scalars that every lubrication FMU has, except
        flows and counters.
        """
        p = self.parameters
        contact = asperity.contact(film_thickness, *self._contact)
        asperity_pressure = contact[0]
        couette, drag, poiseuille = film.values[4:]
        if film.ratio is not None:
            couette, drag = couette * film.ratio, drag * film.ratio
        shearing = (
            film.fraction if p.cavity_shear == "film_fraction" else np.ones_like(film.fraction)
        )
        shear_inputs = (
            film.pressure,
            shearing,
            film.sliding_velocity,
            couette,
            drag,
            poiseuille,
            film.surroundings.lower,
            film.surroundings.upper,
            self.grid.spacing[1],
            contact[3],
            p.friction_rounding_velocity,
            self.area,
        )
        viscous, boundary, power = friction.shear_forces(*shear_inputs)
        absolute = film.pressure + p.cavitation_pressure
        pressure_force = (absolute + asperity_pressure) * self.area
        thinnest, highest, radial, axial, hydrodynamic, rubbing, power, contact_area = summarise(
            film_thickness,
            absolute,
            pressure_force,
            viscous,
            boundary,
            power,
            contact[2],
            *self._halves,
        )
        friction_force = viscous + boundary
        if not np.isfinite(sum(radial) + sum(axial)):
            i, j = np.argwhere(~np.isfinite(pressure_force + friction_force))[0]
            raise NotConverged(
                f"forces are not finite at [{i + 1},{j + 1}], film_thickness {film_thickness[i, j]:g} m, "
                f"sliding_velocity {film.sliding_velocity[i, j]:g} m/s"
            )
        outputs = dict(
            nodal_pressure_force=pressure_force,
            nodal_friction_force=friction_force,
            pressure=absolute,
            asperity_pressure=asperity_pressure,
            film_fraction=film.fraction,
            minimum_film_thickness=min(thinnest),
            maximum_pressure=highest,
            friction_force_hydrodynamic=hydrodynamic,
            friction_force_asperity=rubbing,
            friction_power=power,
            contact_area_fraction=contact_area,
        )
        for k, side in enumerate(("thrust", "anti_thrust")):
            outputs[f"minimum_film_thickness_{side}_side"] = thinnest[k]
            outputs[f"radial_force_{side}_side"] = radial[k]
            outputs[f"friction_force_{side}_side"] = axial[k]
        return (film, contact, shear_inputs), outputs
