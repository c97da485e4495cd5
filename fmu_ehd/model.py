"""The lubrication model: film, contact and friction of one skirt, one step at a time."""

from dataclasses import dataclass

import numpy as np

from . import asperity, friction
from .film_step import FilmStep
from .films import FlowFilm, smooth_film
from .grid import Edges, Grid


@dataclass(frozen=True)
class Parameters:
    """What is fixed for a run; names, units and ranges in `variables.py`.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    bore_radius, skirt_length, minimum_flow_film, roughness_rms : float
        [m].
    viscosity : float
        [Pa s].
    pressure_lower_edge, pressure_upper_edge, cavitation_pressure, contact_modulus : float
        [Pa], pressures on one datum, edges not below cavitation.
    film_fraction_lower_edge, film_fraction_upper_edge : float
        [-].
    asperity_product, asperity_slope : float
        eta beta sigma and sigma/beta of `asperity` [-].
    boundary_friction_coefficient : float
        [-].
    friction_rounding_velocity : float
        [m/s].
    """

    shape: tuple = (40, 40)
    bore_radius: float = 28.25e-3
    skirt_length: float = 27e-3
    viscosity: float = 0.01
    pressure_lower_edge: float = 0.0
    pressure_upper_edge: float = 0.0
    cavitation_pressure: float = 0.0
    film_fraction_lower_edge: float = 1.0
    film_fraction_upper_edge: float = 1.0
    minimum_flow_film: float = 5e-8
    roughness_rms: float = 0.0
    asperity_product: float = 0.04
    asperity_slope: float = 1e-3
    contact_modulus: float = 6e10
    boundary_friction_coefficient: float = 0.12
    friction_rounding_velocity: float = 1e-3


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
    return [f"pressure_{edge}_edge = {pressure:g} Pa: must not be below cavitation_pressure = {p.cavitation_pressure:g} Pa"
            for edge, pressure in (("lower", p.pressure_lower_edge), ("upper", p.pressure_upper_edge))
            if pressure < p.cavitation_pressure]


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


class LubricationModel:
    """Transient film, asperity contact and friction between skirt and bore.

    Parameters
    ----------
    parameters : Parameters
    """

    def __init__(self, parameters):
        p = self.parameters = parameters
        self.grid = Grid(p.shape, 2.0 * np.pi * p.bore_radius, p.skirt_length)
        edge_pressure = np.array([p.pressure_lower_edge, p.pressure_upper_edge, 0.0, 0.0]) - p.cavitation_pressure
        edge_fraction = np.array([p.film_fraction_lower_edge, p.film_fraction_upper_edge, 1.0, 1.0])
        self.film_step = FilmStep(self.grid, Edges(edge_pressure, edge_fraction))
        self._contact = (p.roughness_rms,
                         asperity.pressure_scale(p.asperity_product, p.asperity_slope, p.contact_modulus),
                         np.pi**2 * p.asperity_product**2, asperity.contact_table())
        self._no_velocity = np.zeros(p.shape)

    def start(self, film_thickness, sliding_velocity):
        """State and outputs at the start: a full film, pressure linear between the edges.

        Parameters
        ----------
        film_thickness, sliding_velocity : ndarray, shape (n_c, n_a)
            h [m], V [m/s].

        Returns
        -------
        state : State
        outputs : dict
            As from `advance`.
        """
        p = self.parameters
        lower, upper = self.film_step.edges.pressure[:2]
        along = (np.arange(p.shape[1]) + 0.5) / p.shape[1]
        pressure = np.broadcast_to(lower + (upper - lower) * along, p.shape).copy()
        stored = smooth_film(film_thickness, p.viscosity, p.minimum_flow_film)[0]
        state = State(pressure, pressure, stored)
        forces = self._forces(film_thickness, sliding_velocity, pressure, np.ones(p.shape), stored)
        outputs = self._outputs(forces, film_thickness, sliding_velocity, pressure, np.ones(p.shape))
        return state, outputs | dict(flow_lower_edge=0.0, flow_upper_edge=0.0, mass_imbalance=0.0, solver_iterations=0)

    def advance(self, state, film_thickness, sliding_velocity, step):
        """One step from `state` to the given film and velocity.

        Parameters
        ----------
        state : State
            At the beginning of the step.
        film_thickness, sliding_velocity : ndarray, shape (n_c, n_a)
            At the end of the step [m], [m/s].
        step : float
            H [s], > 0.

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
        p = self.parameters
        stored, conductivity, dstored, dconductivity = smooth_film(film_thickness, p.viscosity, p.minimum_flow_film)
        film = FlowFilm(stored, stored, conductivity, conductivity)
        guess = 2.0 * state.unknown - state.unknown_before > 0.0
        solution = self.film_step.solve(film, self._no_velocity, -0.5 * sliding_velocity, state.content, guess, step)
        forces = self._forces(film_thickness, sliding_velocity, solution.pressure, solution.film_fraction, stored)
        self._last = sliding_velocity, stored, dstored, dconductivity, solution, forces
        outputs = self._outputs(forces, film_thickness, sliding_velocity, solution.pressure, solution.film_fraction)
        outputs |= dict(flow_lower_edge=float(solution.edge_flow[0]), flow_upper_edge=float(solution.edge_flow[1]),
                        mass_imbalance=float(solution.mass_imbalance), solver_iterations=solution.iterations)
        return State(solution.unknown, state.unknown, solution.content), outputs

    def tangent(self, dfilm_thickness, dsliding_velocity):
        """Change of the forces at the end of the last step for changed inputs there, its state at the beginning held.

        Parameters
        ----------
        dfilm_thickness, dsliding_velocity : ndarray, shape (n_c, n_a)
            [m], [m/s].

        Returns
        -------
        dnodal_pressure_force, dnodal_friction_force : ndarray, shape (n_c, n_a)
            [N].
        """
        velocity, stored, dstored, dconductivity, solution, (asperity_pressure, slope, *_) = self._last
        dstored = dstored * dfilm_thickness
        dconductivity = dconductivity * dfilm_thickness
        dfilm = FlowFilm(dstored, dstored, dconductivity, dconductivity)
        dpressure, dfraction = self.film_step.tangent(dfilm, self._no_velocity, -0.5 * dsliding_velocity, solution.full)
        dasperity = slope * dfilm_thickness
        dfriction = friction.shear_force_changes(*self._shear_inputs(solution.pressure, solution.film_fraction, stored, velocity,
                                                                     asperity_pressure),
                                                 dpressure, dfraction, dstored, dsliding_velocity, dasperity)
        return (dpressure + dasperity) * self.grid.cell_area, dfriction

    def _shear_inputs(self, pressure, fraction, stored, velocity, asperity_pressure):
        """Arguments of the friction kernels."""
        p, (lower, upper) = self.parameters, self.film_step.edges.pressure[:2]
        return (pressure, fraction, stored, velocity, p.viscosity, lower, upper, self.grid.spacing[1], asperity_pressure,
                p.boundary_friction_coefficient, p.friction_rounding_velocity, self.grid.cell_area)

    def _forces(self, film_thickness, velocity, pressure, fraction, stored):
        """Asperity pressure, its slope, contact area fraction, viscous and boundary shear force."""
        asperity_pressure, slope, area_fraction = asperity.contact(film_thickness, *self._contact)
        shear = friction.shear_forces(*self._shear_inputs(pressure, fraction, stored, velocity, asperity_pressure))
        return asperity_pressure, slope, area_fraction, *shear

    def _outputs(self, forces, film_thickness, velocity, pressure, fraction):
        """Fields and scalars that every lubrication FMU has, except flows and counters."""
        asperity_pressure, _, area_fraction, viscous, boundary = forces
        absolute = pressure + self.parameters.cavitation_pressure
        friction_force = viscous + boundary
        return dict(nodal_pressure_force=(absolute + asperity_pressure) * self.grid.cell_area,
                    nodal_friction_force=friction_force, pressure=absolute, asperity_pressure=asperity_pressure,
                    film_fraction=fraction, minimum_film_thickness=float(film_thickness.min()),
                    maximum_pressure=float(absolute.max()), friction_force_hydrodynamic=float(viscous.sum()),
                    friction_force_asperity=float(boundary.sum()),
                    friction_power=-float((friction_force * velocity).sum()), contact_area_fraction=float(area_fraction))
