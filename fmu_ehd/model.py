"""The lubrication model: film, oil, contact and friction of one skirt, one step at a time."""

from dataclasses import dataclass, field

import numpy as np

from . import asperity, friction
from .cavitation import NotConverged
from .film_step import FilmStep
from .films import FlowFilm, rough_film, smooth_film
from .grid import Edges, Grid
from .oil import Oil
from .roughness import factor_table
from .summary import halves, summarise

BATCH = 64  # directions at once: bounds the memory of a large Jacobian
HIGHEST_PRESSURE = 1e10  # [Pa]; no viscosity law means anything beyond


@dataclass(frozen=True)
class Parameters:
    """What is fixed for a run; names, units and ranges in `variables.py`.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    oil : oil.Oil
    cavitation_model, flow_factors, contact_law, cavity_shear : str
        Chosen laws, keys of `variables.CHOICES`.
    bore_radius, skirt_length, minimum_flow_film, roughness_rms : float
        [m].
    pressure_lower_edge, pressure_upper_edge, cavitation_pressure, contact_modulus, boundary_shear_strength : float
        [Pa], pressures on one datum, edges not below cavitation.
    film_fraction_lower_edge, film_fraction_upper_edge : float
        [-].
    oil_temperature_lower_edge, oil_temperature_upper_edge : float
        [K], linear between.
    asperity_product, asperity_slope, boundary_friction_coefficient : float
        eta beta sigma, sigma/beta, mu_b of `asperity` [-].
    peklenik_number, roughness_share_skirt : float
        gamma and Y of `roughness` and `films` [-].
    friction_rounding_velocity : float
        [m/s].
    open_cells : ndarray of bool, shape (n_c, n_a), optional
        Cut-outs.
    """

    shape: tuple = (40, 40)
    oil: Oil = field(default_factory=Oil)
    cavitation_model: str = "jfo"
    flow_factors: str = "none"
    contact_law: str = "greenwood_tripp_1970"
    cavity_shear: str = "film_fraction"
    bore_radius: float = 28.25e-3
    skirt_length: float = 27e-3
    pressure_lower_edge: float = 0.0
    pressure_upper_edge: float = 0.0
    cavitation_pressure: float = 0.0
    film_fraction_lower_edge: float = 1.0
    film_fraction_upper_edge: float = 1.0
    oil_temperature_lower_edge: float = 373.15
    oil_temperature_upper_edge: float = 373.15
    minimum_flow_film: float = 5e-8
    roughness_rms: float = 0.0
    peklenik_number: float = 1.0
    roughness_share_skirt: float = 0.8
    asperity_product: float = 0.04
    asperity_slope: float = 1e-3
    contact_modulus: float = 6e10
    boundary_friction_coefficient: float = 0.12
    boundary_shear_strength: float = 0.0
    friction_rounding_velocity: float = 1e-3
    open_cells: np.ndarray | None = None


CONDITIONS = ("pressure_lower_edge", "pressure_upper_edge", "film_fraction_lower_edge", "film_fraction_upper_edge",
              "oil_temperature_lower_edge", "oil_temperature_upper_edge")


def faults(parameters):
    """What is wrong between parameters that are each in range.

    Parameters
    ----------
    parameters : Parameters

    Returns
    -------
    list of str
        One sentence a fault.
    """
    p = parameters
    found = [f"pressure_{edge}_edge = {pressure:g} Pa: must not be below cavitation_pressure = {p.cavitation_pressure:g} Pa"
             for edge, pressure in (("lower", p.pressure_lower_edge), ("upper", p.pressure_upper_edge))
             if pressure < p.cavitation_pressure]
    if p.oil.viscosity_law == "two_point" and p.oil.viscosity_40 <= p.oil.viscosity_100:
        found.append(f"viscosity_40 = {p.oil.viscosity_40:g} Pa.s: must be above viscosity_100 = {p.oil.viscosity_100:g} Pa.s")
    if p.flow_factors != "none" and p.roughness_rms <= 0.0:
        found.append(f"flow_factors = {p.flow_factors}: needs roughness_rms > 0 m")
    return found


@dataclass(frozen=True)
class State:
    """All that a step needs from the past, each an ndarray of shape (n_c, n_a).

    Parameters
    ----------
    unknown, unknown_before : ndarray
        Signed unknown of the last two steps: its extrapolation starts the next step, so a repeat takes the same path.
    content : ndarray
        film_fraction x film of the flow [m].
    """

    unknown: np.ndarray
    unknown_before: np.ndarray
    content: np.ndarray


@dataclass(frozen=True)
class Surroundings:
    """What holds around and in the oil during a step.

    Parameters
    ----------
    edges : grid.Edges
        With reduced pressures, Eq. (O6).
    lower, upper : float
        Edge pressures above cavitation pressure [Pa].
    temperature, viscosity : ndarray, shape (n_c, n_a)
        T [K], low-shear mu_0 [Pa s].
    thickening : object or None
        Pressure-viscosity law of `oil`.
    """

    edges: Edges
    lower: float
    upper: float
    temperature: np.ndarray
    viscosity: np.ndarray
    thickening: object


@dataclass(frozen=True)
class Film:
    """A solved film with all that depends on it; arrays of shape (n_c, n_a).

    values, slopes, velocity_slopes: `FlowFilm` quantities stacked to (7, n_c, n_a), derivatives to h and V; pressure above
    cavitation pressure [Pa], its derivative to the reduced pressure dp [-] (1 without thickening), derivative of
    mu/mu_0 to it dratio [1/Pa] and mu/mu_0 ratio [-] (None without); fraction [-].
    """

    sliding_velocity: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    velocity_slopes: np.ndarray | None
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
        self._contact = (p.roughness_rms,
                         asperity.pressure_scale(p.asperity_product, p.asperity_slope, p.contact_modulus),
                         np.pi**2 * p.asperity_product**2, p.boundary_friction_coefficient, p.boundary_shear_strength,
                         asperity.contact_table(p.contact_law))
        self._factors = factor_table(p.peklenik_number) if p.flow_factors == "patir_cheng_1978" else None
        self._thins = p.oil.shear_thinning_law != "none"
        self._no_velocity = np.zeros(p.shape)
        self._no_slopes = np.zeros((7, *p.shape))
        self._half_back = np.full(p.shape, -0.5)  # entrainment velocity of the grid, which rides on the skirt
        self._halves = halves(p.shape[0])
        self._given = self._surroundings({})

    # ---- steps ------------------------------------------------------------------------------------------------------

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
        around = self._surroundings(conditions)
        lower, upper = around.edges.pressure[:2]
        along = (np.arange(self.grid.shape[1]) + 0.5) / self.grid.shape[1]
        unknown = np.broadcast_to(lower + (upper - lower) * along, self.grid.shape).copy()
        values, slopes, velocity_slopes = self._flow_film(film_thickness, sliding_velocity, around)
        film = self._film(sliding_velocity, values, slopes, velocity_slopes, unknown, np.ones(self.grid.shape), around)
        _, outputs = self._outputs(film, film_thickness)
        outputs |= dict(flow_lower_edge=0.0, flow_upper_edge=0.0, mass_imbalance=0.0, solver_iterations=0)
        return State(unknown, unknown, values[0].copy()), outputs

    def advance(self, state, film_thickness, sliding_velocity, step, **conditions):
        """One step from `state` to the given film and velocity.

        Parameters
        ----------
        state : State
            At the beginning of the step.
        film_thickness, sliding_velocity : ndarray, shape (n_c, n_a)
            At the end of the step [m], [m/s].
        step : float
            H [s], > 0.
        **conditions
            Any of `CONDITIONS` at the end of the step in place of the parameter of that name, and `oil_temperature` [K],
            float or ndarray of shape (n_c, n_a), in place of both edge temperatures.

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
        if not film_thickness.max() > 0.0:
            raise NotConverged(f"film_thickness[1,1] = {film_thickness[0, 0]:g} m, and nowhere above 0 m: there is no film")
        around = self._surroundings(conditions) if conditions else self._given
        values, slopes, velocity_slopes = self._flow_film(film_thickness, sliding_velocity, around)
        guess = 2.0 * state.unknown - state.unknown_before > 0.0
        solution = self.film_step.solve(FlowFilm(*values), self._no_velocity, -0.5 * sliding_velocity, around.edges,
                                        state.content, guess, step)
        film = self._film(sliding_velocity, values, slopes, velocity_slopes, solution.pressure, solution.film_fraction, around)
        self._last, outputs = self._outputs(film, film_thickness)
        self._linear = None
        outputs |= dict(flow_lower_edge=float(solution.edge_flow[0]), flow_upper_edge=float(solution.edge_flow[1]),
                        mass_imbalance=solution.mass_imbalance, solver_iterations=solution.iterations)
        return State(solution.unknown, state.unknown, solution.content), outputs

    def tangent(self, dfilm_thickness, dsliding_velocity):
        """Change of the forces at the end of the last step for changed inputs there, its state at the beginning held.

        Parameters
        ----------
        dfilm_thickness, dsliding_velocity : ndarray, shape (n_c, n_a) or (m, n_c, n_a)
            [m], [m/s]; m directions at once cost less than m single ones.

        Returns
        -------
        dnodal_pressure_force, dnodal_friction_force : ndarray, shape as given
            [N].
        """
        if self._linear is None:
            self._linear = self._linearise()
        shape = (-1, *self.grid.shape)
        dfilm = np.ascontiguousarray(dfilm_thickness).reshape(shape)
        dvelocity = np.ascontiguousarray(dsliding_velocity).reshape(shape)
        forces = [friction.force_changes(*self._linear, h, v, self.film_step.tangent(h, v))
                  for h, v in ((dfilm[k:k + BATCH], dvelocity[k:k + BATCH]) for k in range(0, len(dfilm), BATCH))]
        joined = forces[0] if len(forces) == 1 else [np.concatenate(parts) for parts in zip(*forces)]
        return tuple(force.reshape(np.shape(dfilm_thickness)) for force in joined)

    def _linearise(self):
        """Derivatives of the forces of the last step that every direction shares."""
        film, contact, shear_inputs = self._last
        by_film = film.slopes
        by_velocity = film.velocity_slopes if film.velocity_slopes is not None else self._no_slopes
        to_pressure, to_fraction = self.film_step.linearise(FlowFilm(*by_film), FlowFilm(*by_velocity), self._no_velocity,
                                                            self._half_back)
        by_pressure = self._no_velocity
        shear_by_film, shear_by_velocity = by_film[4:], by_velocity[4:]
        if film.ratio is not None:
            scale = np.stack([film.ratio, film.ratio, np.ones_like(film.ratio)])
            shear_by_film, shear_by_velocity = shear_by_film * scale, shear_by_velocity * scale
            by_pressure = -self.area * shear_inputs[1] * film.sliding_velocity * (film.values[4] - film.values[5]) * film.dratio
            to_pressure = to_pressure * film.ratio  # dp/dq, Eq. (O6)
        slopes = friction.shear_slopes(*shear_inputs, shear_by_film, shear_by_velocity, contact[4])
        if self.parameters.cavity_shear == "full_film":
            to_fraction = self._no_velocity
        return slopes, by_pressure, contact[1], self.area, self.grid.spacing[1], to_pressure, to_fraction

    # ---- parts of a step --------------------------------------------------------------------------------------------

    def _surroundings(self, conditions):
        """Edges, temperature and viscosity for the conditions given, the parameters for those that are not."""
        p = self.parameters
        given = {name: conditions.get(name, getattr(p, name)) for name in CONDITIONS}
        lower, upper = (given[f"pressure_{edge}_edge"] - p.cavitation_pressure for edge in ("lower", "upper"))
        if min(lower, upper) < 0.0:
            raise NotConverged(f"edge pressure {min(lower, upper):g} Pa below cavitation pressure: must not be below it")
        along = (np.arange(p.shape[1]) + 0.5) / p.shape[1]
        profile = (given["oil_temperature_lower_edge"] * (1.0 - along) + given["oil_temperature_upper_edge"] * along)
        temperature = np.broadcast_to(np.asarray(conditions.get("oil_temperature", profile), dtype=float), p.shape)
        viscosity = np.ascontiguousarray(p.oil.low_shear_viscosity(temperature))
        law = p.oil.thickening(viscosity.mean()) if p.oil.pressure_viscosity_law != "none" else None
        pressure = np.array([lower, upper, 0.0, 0.0])
        fraction = np.array([given["film_fraction_lower_edge"], given["film_fraction_upper_edge"], 1.0, 1.0])
        return Surroundings(Edges(law.reduced(pressure) if law else pressure, fraction), lower, upper, temperature,
                            viscosity, law)

    def _flow_film(self, film_thickness, sliding_velocity, around):
        """`FlowFilm` quantities stacked to (7, n_c, n_a), and their derivatives to film and velocity (None if all zero)."""
        p = self.parameters
        if self._factors is None:
            values, slopes = smooth_film(film_thickness, around.viscosity, p.minimum_flow_film)
        else:
            values, slopes = rough_film(film_thickness, around.viscosity, p.minimum_flow_film, p.roughness_rms,
                                        2.0 * p.roughness_share_skirt - 1.0, self._factors)
        if not self._thins:
            return values, slopes, None
        # shear thinning scales conductivities by mu_0/mu and stresses by mu/mu_0; shear rate |V|/h, Eqs. (O7), (O8)
        thickness = np.maximum(film_thickness, p.minimum_flow_film)
        rate = np.abs(sliding_velocity) / thickness
        factor, slope = p.oil.thinning(rate, around.temperature)
        by_film = np.where(film_thickness > p.minimum_flow_film, -slope * rate / thickness, 0.0)
        by_velocity = slope * np.sign(sliding_velocity) / thickness
        velocity_slopes = np.zeros_like(slopes)
        for rows, power in ((slice(2, 4), -1.0), (slice(4, 6), 1.0)):
            scale, dscale = factor**power, power * factor ** (power - 1.0)
            velocity_slopes[rows] = values[rows] * dscale * by_velocity
            slopes[rows] = slopes[rows] * scale + values[rows] * dscale * by_film
            values[rows] *= scale
        return values, slopes, velocity_slopes

    def _film(self, sliding_velocity, values, slopes, velocity_slopes, reduced, fraction, around):
        """The film with true pressure; thickening by pressure enters the shear stress here."""
        pressure, ratio, dratio = reduced, None, None
        if around.thickening:
            pressure = around.thickening.pressure(reduced)
            if not np.all(pressure < HIGHEST_PRESSURE):
                i, j = np.unravel_index(np.argmax(reduced), reduced.shape)
                raise NotConverged(f"no pressure answers a reduced pressure of {reduced[i, j]:g} Pa at [{i + 1},{j + 1}] under "
                                   f"{self.parameters.oil.pressure_viscosity_law}")
            ratio, dratio = around.thickening.ratio(pressure)
        return Film(sliding_velocity, values, slopes, velocity_slopes, pressure, fraction, ratio, dratio, around)

    def _outputs(self, film, film_thickness):
        """What the tangent needs, and fields and scalars that every lubrication FMU has, except flows and counters."""
        p = self.parameters
        contact = asperity.contact(film_thickness, *self._contact)
        asperity_pressure = contact[0]
        couette, drag, poiseuille = film.values[4:]
        if film.ratio is not None:
            couette, drag = couette * film.ratio, drag * film.ratio
        shearing = film.fraction if p.cavity_shear == "film_fraction" else np.ones_like(film.fraction)
        shear_inputs = (film.pressure, shearing, film.sliding_velocity, couette, drag, poiseuille, film.surroundings.lower,
                        film.surroundings.upper, self.grid.spacing[1], contact[3], p.friction_rounding_velocity, self.area)
        viscous, boundary, power = friction.shear_forces(*shear_inputs)
        absolute = film.pressure + p.cavitation_pressure
        pressure_force = (absolute + asperity_pressure) * self.area
        thinnest, highest, radial, axial, hydrodynamic, rubbing, power, contact_area = summarise(
            film_thickness, absolute, pressure_force, viscous, boundary, power, contact[2], *self._halves)
        friction_force = viscous + boundary
        if not np.isfinite(sum(radial) + sum(axial)):
            i, j = np.argwhere(~np.isfinite(pressure_force + friction_force))[0]
            raise NotConverged(f"forces are not finite at [{i + 1},{j + 1}], film_thickness {film_thickness[i, j]:g} m, "
                               f"sliding_velocity {film.sliding_velocity[i, j]:g} m/s")
        outputs = dict(nodal_pressure_force=pressure_force, nodal_friction_force=friction_force, pressure=absolute,
                       asperity_pressure=asperity_pressure, film_fraction=film.fraction,
                       minimum_film_thickness=min(thinnest), maximum_pressure=highest,
                       friction_force_hydrodynamic=hydrodynamic, friction_force_asperity=rubbing, friction_power=power,
                       contact_area_fraction=contact_area)
        for k, side in enumerate(("thrust", "anti_thrust")):
            outputs[f"minimum_film_thickness_{side}_side"] = thinnest[k]
            outputs[f"radial_force_{side}_side"] = radial[k]
            outputs[f"friction_force_{side}_side"] = axial[k]
        return (film, contact, shear_inputs), outputs
