"""Interface of a film's step: inputs, memory, data for derivatives, and declared outputs.

The annotations determine the layout of a memory in machine code, and the outputs of the FMU.
"""

from typing import Annotated, NamedTuple

from . import step_parts as parts
from .balance.flows import Filling
from .balance.oil_layer import OilLayer
from .common.grid import Array, Edges, Field, Flags, Stencil
from .common.quantities import FilmSlopes, Quantities
from .laws.circumferential import CircumferentialInputs
from .laws.friction import ShearInputs
from .laws.piezoviscosity import TruePressure
from .surroundings import Surroundings


class Inputs(NamedTuple):
    """Inputs of a film at the end of a step.

    hard_film : ndarray, shape (n_c, n_a), film thickness without the deflection of a coating [m];
    velocity, turning : ndarray, shape (n_c, n_a), V and W, 0 on a skirt [m/s];
    around : surroundings.Surroundings; length : of the step, H [s].
    """

    hard_film: Array
    velocity: Array
    turning: Array
    around: Surroundings
    length: float


class Memory(NamedTuple):
    """Memory of a film between steps; steps : `contact.profile_steps` of the film at the start."""

    film: parts.PreviousFilm
    totals: parts.Totals
    layer: OilLayer
    steps: Annotated[Array, "2, n_c, n_a"]

    def __repr__(self) -> str:
        return (
            f"<Memory of a film: {self.film.content.shape[0]} x {self.film.content.shape[1]} cells>"
        )


class LastStep(NamedTuple):
    """Data of the last step for the tangent.

    film : ndarray, shape (6, n_c, n_a), quantities of `films`; slopes, slopes_around : of these,
    `flow_film.FlowFilm`; under : piezoviscosity.TruePressure; filling : flows.Filling of the
    solved balance; edges : grid.Edges; length : H_e [s];
    unknown, full, stencil : as in `film_step.FilmSolution`; shear : friction.ShearInputs;
    pressure_slope, stress_slope : of `contact.Contact`; touching : whether any cell is in contact;
    turning : circumferential.CircumferentialInputs.
    """

    film: Quantities
    slopes: FilmSlopes
    slopes_around: FilmSlopes
    under: TruePressure
    filling: Filling
    edges: Edges
    length: float
    unknown: Field
    full: Annotated[Flags, "n_c, n_a"]
    stencil: Stencil
    shear: ShearInputs
    pressure_slope: Stencil
    stress_slope: Stencil
    touching: bool
    turning: CircumferentialInputs


class Fields(NamedTuple):
    """Outputs of each cell with unit and nominal value; the last one of a bearing."""

    nodal_pressure_force: Annotated[Array, "N", 1.0]
    """Sum of hydrodynamic and asperity pressure, times the cell area."""
    nodal_friction_force: Annotated[Array, "N", 0.1]
    """Axial force of film and asperities on the skirt; the opposite force acts on the bore."""
    pressure: Annotated[Array, "Pa", 1e6]
    """Hydrodynamic pressure, gauge."""
    asperity_pressure: Annotated[Array, "Pa", 1e6]
    """Asperity contact pressure."""
    film_fraction: Annotated[Array, "1", 1.0]
    """Fraction of the film that is filled with oil."""
    nodal_circumferential_force: Annotated[Array, "N", 0.1]
    """Circumferential force of film and asperities on the journal, positive with ascending i; the
    opposite force acts on the shell.
    """


class Scalars(NamedTuple):
    """Scalar outputs of a film with unit and nominal value.

    The sides are those of a skirt, the torque that of a bearing.
    """

    minimum_film_thickness: Annotated[float, "m", 1e-5]
    """Minimum film thickness."""
    maximum_pressure: Annotated[float, "Pa", 1e6]
    """Maximum hydrodynamic pressure, gauge."""
    friction_force_hydrodynamic: Annotated[float, "N", 10.0]
    """Axial force of the film on the skirt; the opposite force acts on the bore."""
    friction_force_asperity: Annotated[float, "N", 10.0]
    """Axial force of the asperities on the skirt; the opposite force acts on the bore."""
    friction_power: Annotated[float, "W", 100.0]
    """Friction power: minus the force times the sliding velocity."""
    boundary_friction_share: Annotated[float, "1"]
    """Fraction of the friction work since the start that is due to asperities."""
    minimum_film_thickness_thrust_side: Annotated[float, "m", 1e-5]
    """Minimum film thickness of the thrust half."""
    radial_force_thrust_side: Annotated[float, "N", 100.0]
    """Force of the thrust half towards the thrust side; positive separates skirt and bore."""
    friction_force_thrust_side: Annotated[float, "N", 10.0]
    """Axial force on the thrust half of the skirt."""
    minimum_film_thickness_anti_thrust_side: Annotated[float, "m", 1e-5]
    """Minimum film thickness of the anti-thrust half."""
    radial_force_anti_thrust_side: Annotated[float, "N", 100.0]
    """Force of the anti-thrust half towards the anti-thrust side; positive separates skirt and
    bore.
    """
    friction_force_anti_thrust_side: Annotated[float, "N", 10.0]
    """Axial force on the anti-thrust half of the skirt."""
    flow_lower_edge: Annotated[float, "m3/s", 1e-6]
    """Oil flow into the film through the lower edge at the end of the step."""
    flow_upper_edge: Annotated[float, "m3/s", 1e-6]
    """Oil flow into the film through the upper edge at the end of the step."""
    stored_energy: Annotated[float, "J", 1e-3]
    """Elastic energy of asperities and coating."""
    received_power: Annotated[float, "W", 100.0]
    """Power received from the bodies, mean over the step: stored and dissipated, minus that of the
    pressure around the film.
    """
    flow_openings: Annotated[float, "m3/s", 1e-6]
    """Oil flow into the film from openings at the end of the step."""
    oil_in_film: Annotated[float, "m3", 1e-8]
    """Oil volume in the film."""
    oil_on_bore: Annotated[float, "m3", 1e-8]
    """Oil volume on the bore and at the edges of the skirt; 0 for oil_supply = edges."""
    oil_supplied: Annotated[float, "m3", 1e-8]
    """Oil volume supplied by ring and splash since the start, minus the oil that ran off."""
    mass_imbalance: Annotated[float, "1"]
    """Relative mass imbalance at the end of the step: |inflow - growth of film content| /
    throughput.
    """
    contact_area_fraction: Annotated[float, "1"]
    """Ratio of the real contact area to the skirt area."""
    friction_power_hydrodynamic: Annotated[float, "W", 100.0]
    """Part of the friction power due to the film."""
    friction_power_asperity: Annotated[float, "W", 100.0]
    """Part of the friction power due to asperities."""
    heat_generated: Annotated[float, "W", 100.0]
    """Heat of sliding and squeezing in the film, mean over the step; surfaces of equal temperature
    receive half each.
    """
    outflow_upper_edge: Annotated[float, "m3/s", 1e-6]
    """Oil flow out of the film at the upper edge, over the cells where it leaves; at the end of the
    step.
    """
    friction_torque: Annotated[float, "N.m", 1.0]
    """Moment of the circumferential forces on the journal about the axis of the shell."""
