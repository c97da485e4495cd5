"""The coupled problem in one system of equations, as a textbook writes it.

Each step solves bodies and film at once. The code shares no line and no method with the FMUs.

| | FMUs | here |
|---|---|---|
| bodies | minimal coordinates | Newton-Euler with the force at the pin as unknown |
| elasticity | modes with inertia in a floating frame | the static compliance of the whole mesh |
| time | generalised-alpha for the bodies | BDF2 for everything |
| coupling | exchange until the wires agree | one Newton iteration over all unknowns |
| film | kernels, elimination downstream | sparse operators of scipy |

A Newtonian oil, edges at cavitation pressure, a crank at constant speed; smooth surfaces and
flooded edges, or contact and scarce oil by `mixed_film`.
Axes: x to the thrust side, y to the head, z along the pin; the crank turns about +z and leaves top
dead centre towards -x. Angles of the film from +z towards +x; a cell's centre lies on the thrust
line.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import LinearOperator, gmres, splu

from .mixed_film import LOWER, POINTS, UPPER, Asperities, BoreOil, Contact, Roughness, Supply

PRESSURE_SCALE = 1e6
"""Pa: what a signed unknown of 1 is worth as a pressure."""
ITERATIONS = 60
LIMITED = 8
"""Iterations in which the limiter looks again; it has kinks, between which Newton would wander."""
EMPTIEST = 1e-6
"""Film fraction that an unknown never passes."""
POSITION_SCALE = np.array([1e-6, 1e-5])
"""m and rad."""
CONVERGED = 1e-7
"""Newton's step, by the scales of the unknowns."""
ACCURATE = 1e-4
"""Residual of a linear system of the loads, which Newton's iteration corrects."""


@dataclass(frozen=True)
class Engine:
    """All that the problem is made of, in SI units.

    Parameters
    ----------
    grid : (int, int)
        Cells around and along the skirt.
    bore_radius, skirt_lower, skirt_upper : float
        Edges above pin point A [m].
    radial_clearance, barrel, ovality : float
        Radial at the thrust faces; drop at the edges; difference of diameters [m].
    viscosity : float
        [Pa s]
    crank_radius, rod_length, crank_offset, pin_offset : float
        x of the crank from the bore's axis, of A from the skirt's [m].
    rod_mass, rod_inertia, rod_centre, pin_mass : float
        [kg]; about the rod's centre of mass [kg m2]; its distance from the big end [m]; [kg].
    piston_mass, piston_inertia : float
        [kg], about A [kg m2].
    piston_centre : ndarray, shape (2,)
        x, y of the centre of mass from A [m].
    crank_speed : float
        Of the crank [rad/s].
    gas : callable
        Crank angle [rad] to the force of the gas on the crown [N].
    roughness : Roughness, optional
        Smooth if omitted.
    film_fraction_lower_edge, initial_film_fraction : float
        Film fraction that enters at both edges, and at the start [-].
    supply : Supply, optional
        Of the oil on the bore instead of the edges. The run then starts at top dead centre.
    """

    grid: tuple[int, int]
    bore_radius: float
    skirt_lower: float
    skirt_upper: float
    radial_clearance: float
    barrel: float
    ovality: float
    viscosity: float
    crank_radius: float
    rod_length: float
    crank_offset: float
    pin_offset: float
    rod_mass: float
    rod_inertia: float
    rod_centre: float
    pin_mass: float
    piston_mass: float
    piston_inertia: float
    piston_centre: np.ndarray
    crank_speed: float
    gas: Callable[[float], float] = lambda angle: 0.0
    roughness: Roughness | None = None
    film_fraction_lower_edge: float = 1.0
    initial_film_fraction: float = 1.0
    supply: Supply | None = None


class Elasticity(NamedTuple):
    """What loads do to the film thickness, by compliance alone; n grid cells.

    Parameters
    ----------
    compliance : callable, optional
        Height of A [m] to a matrix C (m, m): the film thickness on each of the m cells of
        `mirrored` per nodal pressure force [m/N] on them and on their mirror images. Rigid if None.
    inertia : ndarray, shape (n,)
        Film thickness per acceleration of the piston along y [s2].
    gas : ndarray, shape (n,)
        Film thickness per force of the gas on the crown [m/N].
    """

    compliance: Callable[[float], np.ndarray] | None
    inertia: np.ndarray | float
    gas: np.ndarray | float


RIGID = Elasticity(None, 0.0, 0.0)


class Jacobian(NamedTuple):
    """What Newton's step needs beside the balance of the oil.

    by_force : x_A'' and b' per lateral force and moment (2, 2); compliance : C;
    pushing, rubbing : lateral force and moment per pressure of the film and of the asperities
    (2, n) [m2], [m3]; contact : of the cells.
    """

    by_force: np.ndarray
    compliance: np.ndarray | None
    pushing: np.ndarray
    rubbing: np.ndarray
    contact: Contact


class Curves(NamedTuple):
    """A run: each of shape (steps + 1,).

    Parameters
    ----------
    crank_angle, lateral_displacement, rocking_angle : ndarray
        [rad], x_A [m], about +z [rad].
    side_force : ndarray
        Of the film on the bore along x: what the piston leans on it with [N].
    minimum_film_thickness, maximum_pressure : ndarray
        Of the cells [m], [Pa].
    friction_force_asperity : ndarray
        Of the asperities on the skirt along y [N].
    friction_power : ndarray
        [W]
    oil_in_film : ndarray
        [m3]
    """

    crank_angle: np.ndarray
    lateral_displacement: np.ndarray
    rocking_angle: np.ndarray
    side_force: np.ndarray
    minimum_film_thickness: np.ndarray
    maximum_pressure: np.ndarray
    friction_force_asperity: np.ndarray
    friction_power: np.ndarray
    oil_in_film: np.ndarray


class FilmForce(NamedTuple):
    """Of the film on the piston: along x and y [N], about A and +z [N m]."""

    lateral: float
    axial: float
    moment: float


NO_FORCE = FilmForce(0.0, 0.0, 0.0)


class Faces(NamedTuple):
    """Sparse operators between n cells k = i n_axial + j and f faces.

    Axial faces i (n_axial + 1) + j come first, from the lower edge up. Circumferential faces
    follow, each behind its cell.

    before, behind : cells next to a face, at an edge both are the edge's cell (f, n);
    gradient : across a face, pressure 0 at an edge, half a cell away (f, n) [1/m];
    outflow : out of a cell per flow of a width (n, f) [m].
    """

    before: sp.csr_matrix
    behind: sp.csr_matrix
    gradient: sp.csr_matrix
    outflow: sp.csr_matrix


class Conductance(NamedTuple):
    """Conductance K of the faces per width and gradient [m3/(Pa s)], and its slopes.

    The slopes are against the film before and behind a face.
    """

    value: np.ndarray
    by_before: np.ndarray
    by_behind: np.ndarray


class OilBalance(NamedTuple):
    """Oil balance of the cells (n,) [m3/s], and its slopes (m, n).

    The slopes are those of the cells of `mirrored` (m,), against the unknowns of all cells and
    against the film thickness.
    """

    value: np.ndarray
    by_unknown: sp.csr_matrix
    by_film: sp.csr_matrix


def faces_of(around: int, along: int, dx: float, dy: float) -> Faces:
    """Operators of a ring of columns."""
    cells = np.arange(along)
    one_before = _taking(np.concatenate([[0], cells]), along)
    one_behind = _taking(np.concatenate([cells, [along - 1]]), along)
    one_gradient = (one_behind - one_before).tolil()
    one_gradient[0, 0] = 2.0
    one_gradient[along, along - 1] = -2.0
    one_outflow = _taking(cells + 1, along + 1) - _taking(cells, along + 1)
    column = sp.identity(around)
    row = sp.identity(along)
    following = _taking(np.roll(np.arange(around), -1), around)

    def stacked(axial, circumferential) -> sp.csr_matrix:
        return sp.csr_matrix(sp.vstack([sp.kron(*axial), sp.kron(*circumferential)]))

    return Faces(
        before=stacked((column, one_before), (column, row)),
        behind=stacked((column, one_behind), (following, row)),
        gradient=stacked((column, one_gradient / dy), ((following - column) / dx, row)),
        outflow=stacked((column, dx * one_outflow.T), (dy * (column - following), row)).T.tocsr(),
    )


def _scaled(matrix: sp.csr_matrix, rows, columns=None) -> sp.csr_matrix:
    """Multiply rows, and columns, by numbers."""
    data = matrix.data * np.repeat(rows, np.diff(matrix.indptr))
    if columns is not None:
        data = data * columns[matrix.indices]
    return sp.csr_matrix((data, matrix.indices, matrix.indptr), shape=matrix.shape)


def _taking(number, of):
    """Matrix that takes entry number[k] of a vector of length `of`."""
    ones = np.ones(len(number))
    return sp.csr_matrix((ones, (np.arange(len(number)), number)), shape=(len(number), of))


def conductance(faces: Faces, h: np.ndarray, viscosity: float) -> Conductance:
    """Eq. (Z6):  K = 2 g g'/(g + g'),  g = h^3/(12 mu)         two half cells in series"""
    before = faces.before @ h
    behind = faces.behind @ h
    g = before**3 / (12 * viscosity)
    g_behind = behind**3 / (12 * viscosity)
    both = g + g_behind
    return Conductance(
        2 * g * g_behind / both,  # Eq. (Z6)
        2 * (g_behind / both) ** 2 * 3 * before**2 / (12 * viscosity),
        2 * (g / both) ** 2 * 3 * behind**2 / (12 * viscosity),
    )


class Bodies:
    """Piston, pin and rod on a crank that turns at constant speed.

    Eq. (Z3):  m (a_A + b' x s - b^2 s) + m_p a_A = F + P             piston and pin, s from A to
                                                                     the centre of mass
               I_A b' + m s x a_A = M
               J psi' + k l x m_r a_R = -l x P                       rod, about the crank pin
               l . (a_A - a_C) = -|l'|^2                             l from crank pin to A, |l| = L
    """

    def __init__(self, engine: Engine):
        self.engine = engine

    def crank_pin(self, angle: float) -> np.ndarray:
        """Position, velocity and acceleration of the crank pin from the bore's axis, (3, 2)."""
        e = self.engine
        sine = np.sin(angle)
        cosine = np.cos(angle)
        r = e.crank_radius
        w = e.crank_speed
        return np.array(
            [
                [e.crank_offset - r * sine, r * cosine],
                [-r * w * cosine, -r * w * sine],
                [r * w**2 * sine, -r * w**2 * cosine],
            ]
        )

    def height(self, angle: float, lateral: float, lateral_velocity: float) -> tuple[float, float]:
        """Of A above the crank axis [m], and its rate [m/s]."""
        place, velocity, _ = self.crank_pin(angle)
        across = self.engine.pin_offset + lateral - place[0]
        upright = np.sqrt(self.engine.rod_length**2 - across**2)
        rate = velocity[1] - across / upright * (lateral_velocity - velocity[0])
        return place[1] + upright, rate

    def accelerations(self, angle, motion, force: FilmForce) -> np.ndarray:
        """x_A'' and b' under a force of the film, and Y''; (3,) [m/s2], [rad/s2], [m/s2].

        motion : lateral displacement and rocking angle and their velocities.
        """
        e = self.engine
        lateral, rocking, lateral_velocity, rocking_velocity = motion
        place, velocity, acceleration = self.crank_pin(angle)
        height, rate = self.height(angle, lateral, lateral_velocity)
        rod = np.array([e.pin_offset + lateral, height]) - place
        rod_rate = np.array([lateral_velocity, rate]) - velocity
        # psi' = (l x l')/L^2; as |l| is constant, psi'' = l x (a_A - a_C)/L^2
        sx, sy = _turned(e.piston_centre, rocking)
        k = e.rod_centre / e.rod_length
        m = e.piston_mass
        all_mass = m + e.pin_mass
        lx, ly = rod
        # rod: a_R = a_C + k (a_A - a_C)
        spin = e.rod_inertia / e.rod_length**2 + e.rod_mass * k**2
        ax, ay = acceleration
        # Eq. (Z3) in a_A x, a_A y, b', P x, P y
        matrix = np.array(
            [
                [all_mass, 0, -m * sy, -1, 0],
                [0, all_mass, m * sx, 0, -1],
                [-m * sy, m * sx, e.piston_inertia, 0, 0],
                [-ly * spin, lx * spin, 0, -ly, lx],
                [lx, ly, 0, 0, 0],
            ]
        )
        right = np.array(
            [
                force.lateral + m * rocking_velocity**2 * sx,
                force.axial + m * rocking_velocity**2 * sy,
                force.moment,
                (spin - e.rod_mass * k) * (lx * ay - ly * ax),
                lx * ax + ly * ay - rod_rate @ rod_rate,
            ]
        )
        ax, ay, turning, _, _ = np.linalg.solve(matrix, right)
        return np.array([ax, turning, ay])


def _turned(vector, angle):
    x, y = vector
    return x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)


class Monolithic:
    """The problem in one system; `run` integrates it.

    Unknowns: one signed number a cell (pressure above 0, film fraction less 1 below), x_A and the
    rocking angle; velocities and accelerations follow from BDF2.

    Parameters
    ----------
    engine : Engine
    elasticity : Elasticity, optional
        Rigid without.
    """

    def __init__(self, engine: Engine, elasticity: Elasticity | None = None):
        self.engine = engine
        self.elasticity = elasticity or RIGID
        self.bodies = Bodies(engine)
        around, along = engine.grid
        self.dx = 2 * np.pi * engine.bore_radius / around
        self.dy = (engine.skirt_upper - engine.skirt_lower) / along
        self.area = self.dx * self.dy
        self.faces = faces_of(around, along, self.dx, self.dy)
        angle = np.pi / 2 + (np.arange(around) - around // 4) * 2 * np.pi / around
        height = engine.skirt_lower + (np.arange(along) + 0.5) * self.dy
        self.angle = np.repeat(angle, along)
        self.sine = np.sin(self.angle)
        self.height = np.tile(height, around)
        self.arm = engine.bore_radius * self.sine - engine.pin_offset
        self.gap, self.by_motion = self._clearance(self.angle, self.height)
        self.orbits, self.chosen = mirrored(around, along)
        self.chosen_outflow = self.faces.outflow[self.chosen]
        self.asperities = self._asperities() if engine.roughness else None
        self.inlet = np.full((2, around), engine.film_fraction_lower_edge)
        self.load = np.zeros(len(self.chosen))

    def _clearance(self, angle, height):
        """Gap at rest [m], and how x_A and the rocking angle change it, at angles and heights."""
        e = self.engine
        middle = (e.skirt_lower + e.skirt_upper) / 2
        half = (e.skirt_upper - e.skirt_lower) / 2
        gap = (
            e.radial_clearance
            + e.barrel * ((height - middle) / half) ** 2
            + e.ovality / 4 * (1 + np.cos(2 * angle))
        )
        sine = np.sin(angle)
        return gap, np.stack([-sine, height * sine], axis=-1)

    def _asperities(self):
        """Contact at Gauss points of the cells."""
        e = self.engine
        x, weight = np.polynomial.legendre.leggauss(POINTS)
        across = np.repeat(x, POINTS) / 2 * 2 * np.pi / e.grid[0]
        up = np.tile(x, POINTS) / 2 * self.dy
        gap, by_motion = self._clearance(self.angle[:, None] + across, self.height[:, None] + up)
        around, along = (np.add.outer(np.arange(cells), x / 2).ravel() for cells in e.grid)
        ring = np.vstack([np.eye(e.grid[0]), np.eye(1, e.grid[0])])
        self.around = CubicSpline(np.arange(len(ring)), ring, bc_type="periodic")(around)
        self.along = CubicSpline(np.arange(e.grid[1]), np.eye(e.grid[1]))(along)
        return Asperities(e.roughness, gap, by_motion, np.kron(weight, weight) / 4)

    def contact(self, position, h) -> Contact:
        """Contact of the cells, with the deflection that h leaves, cubic between the cells."""
        n = len(self.gap)
        if self.asperities is None:
            return Contact(np.zeros(n), np.zeros((n, 2)), np.zeros(n))
        deflection = (h - self.gap - self.by_motion @ position).reshape(self.engine.grid)
        points = self.around @ deflection @ self.along.T
        of_cells = points.reshape(len(deflection), POINTS, -1, POINTS).swapaxes(1, 2)
        return self.asperities.contact(position, of_cells.reshape(n, -1))

    def rubbing(self, sliding) -> float:
        """Boundary shear stress per contact pressure, along y [-]."""
        r = self.engine.roughness
        if r is None:
            return 0.0
        share = sliding / np.hypot(sliding, r.friction_rounding_velocity)
        return -r.boundary_friction_coefficient * share

    def thickness(self, position, angle, up):
        """Return h [m] at the cells without loads on them.

        h depends on the position, the crank angle (by gas) and the acceleration along y.
        """
        bodies = self.elasticity
        pushed = bodies.inertia * up + bodies.gas * self.engine.gas(angle)
        return self.gap + self.by_motion @ position + pushed

    def deflection(self, compliance, load):
        """Return the change of h [m] at the cells by loads."""
        return 0 * self.gap if compliance is None else self.orbits @ (compliance @ load)

    def carried(self, fraction, sliding):
        """Return the film fraction upstream of the axial faces, and its operator on the cells.

        The film fraction of the edges is `inlet`.
        """
        around, along = self.engine.grid
        upstream = self.faces.before if sliding < 0 else self.faces.behind
        inlet = np.zeros((around, along + 1))
        inside = np.ones((around, along + 1))
        face, edge = (0, LOWER) if sliding < 0 else (along, UPPER)
        inlet[:, face] = self.inlet[edge]
        inside[:, face] = 0.0
        upstream = _scaled(upstream, self._of_axial(inside))
        return upstream @ fraction + self._of_axial(inlet), upstream

    def _of_axial(self, axial):
        """Values of all faces, 0 of circumferential ones."""
        return np.concatenate([axial.ravel(), np.zeros(len(self.gap))])

    def sharpened(self, fraction, sliding):
        """Return the addition of van Leer's limiter to the upstream film fraction at inner faces.

        Eq. (Z7):  f = f_U + a b/(a + b) where a b > 0,  a = f_U - f_UU,  b = f_D - f_U
                   U, UU the cells upstream, D downstream
        """
        around, along = self.engine.grid
        f = fraction.reshape(around, along)
        edge = LOWER
        if sliding > 0:
            f = f[:, ::-1]
            edge = UPPER
        with_edge = np.column_stack([self.inlet[edge], f])
        rise = np.diff(with_edge, axis=1)
        before = rise[:, :-1]
        after = rise[:, 1:]
        product = before * after
        some = product > 0
        more = np.where(some, product / np.where(some, before + after, 1.0), 0.0)  # Eq. (Z7)
        faces = np.zeros((around, along + 1))
        faces[:, 1:-1] = more if sliding <= 0 else more[:, ::-1]
        return self._of_axial(faces)

    def force(self, pressure, fraction, h, sliding, contact: Any = 0.0) -> FilmForce:
        """On the piston: both pressures push inwards; along y minus what the bore feels.

        Eq. (Z5):  f_y = -(mu f V/h - h/2 dp/dy) - mu_b p_c V/|V|
        """
        push = (pressure + contact) * self.area
        gradient = self._cell_gradient(pressure)
        shear = -self.engine.viscosity * fraction * sliding / h + h / 2 * gradient
        drag = self.area * (shear + self.rubbing(sliding) * contact)  # Eq. (Z5)
        lateral = -np.sum(push * self.sine)
        moment = np.sum(self.height * push * self.sine) + np.sum(self.arm * drag)
        return FilmForce(lateral, float(np.sum(drag)), moment)

    def _cell_gradient(self, pressure):
        around, along = self.engine.grid
        p = pressure.reshape(around, along)
        at_face = np.zeros((around, along + 1))
        at_face[:, 1:-1] = (p[:, 1:] + p[:, :-1]) / 2
        return (np.diff(at_face, axis=1) / self.dy).ravel()

    def run(self, angles: np.ndarray, each: Callable[[float], None] = lambda angle: None) -> Curves:
        """From rest at the first crank angle, the gap of the undeformed bodies filled; equal steps.

        Parameters
        ----------
        angles : ndarray, shape (steps + 1,)
            Crank angles [rad], equally spaced.
        each : callable
            Told the crank angle of every finished step.

        Raises
        ------
        ArithmeticError
            Newton's iteration does not converge.
        """
        e = self.engine
        step = (angles[1] - angles[0]) / e.crank_speed
        n = len(self.gap)
        position = np.zeros(2)
        velocity = np.zeros(2)
        unknown = np.full(n, e.initial_film_fraction - 1)
        h = self.gap + self.by_motion @ position
        rows = [self._row(angles[0], unknown, h, position, velocity)]
        # values of the last step and of the one before
        past = [(position, velocity, e.initial_film_fraction * h)] * 2
        rates = (1.0, -1.0, 0.0)  # backward Euler, then BDF2
        oil = BoreOil(e.supply, e.grid[0], self.dy, 2 * e.crank_radius) if e.supply else None
        top = self.bodies.height(angles[0], 0.0, 0.0)[0]
        depth = 0.0
        for angle in angles[1:]:
            deeper = top - self.bodies.height(angle, 0.0, 0.0)[0]
            available = oil.available(depth, deeper, step) / step if oil else None
            unknown, h, position, velocity = self._step(
                angle, step, unknown, past, rates, available
            )
            pressure, fraction = _interpret(unknown)
            if oil:
                _, sliding = self.bodies.height(angle, position[0], velocity[0])
                inflow = step * self._edge_flows(pressure, fraction, h, sliding)
                oil.left(depth, deeper, inflow, self._at_edges(h))
            depth = deeper
            past = [(position, velocity, fraction * h), past[0]]
            rates = (1.5, -2.0, 0.5)
            rows.append(self._row(angle, unknown, h, position, velocity))
            each(angle)
        return Curves(angles, *np.array(rows).T)

    def _at_edges(self, cells):
        """Values of the cells at the lower and the upper edge, (2, around)."""
        return cells.reshape(self.engine.grid)[:, [0, -1]].T

    def _edge_flows(self, pressure, fraction, h, sliding):
        """Oil per width into the film over both edges [m2/s], (2, around)."""
        carried = self._at_edges(fraction)
        if sliding != 0:
            edge = LOWER if sliding < 0 else UPPER
            carried[edge] = self.inlet[edge]
        h = self._at_edges(h)
        squeezed = h**3 / (12 * self.engine.viscosity) * self._at_edges(pressure) * 2 / self.dy
        inward = np.array([[1.0], [-1.0]])
        return -inward * sliding / 2 * carried * h - squeezed

    def _row(self, angle, unknown, h, position, velocity):
        pressure, fraction = _interpret(unknown)
        _, sliding = self.bodies.height(angle, position[0], velocity[0])
        contact = self.contact(position, h)
        force = self.force(pressure, fraction, h, sliding, contact.pressure)
        rubbing = self.rubbing(sliding) * self.area * np.sum(contact.pressure)
        power = -force.axial * sliding
        oil = self.area * np.sum(fraction * h)
        return *position, -force.lateral, h.min(), pressure.max(), rubbing, power, oil

    def _step(self, angle, step, unknown, past, rates, available):
        """Unknowns, film thickness, position and velocity at the end of a step."""
        now, last, before = (rate / step for rate in rates)
        (position_1, velocity_1, content_1), (position_2, velocity_2, content_2) = past
        position_past = last * position_1 + before * position_2
        velocity_past = last * velocity_1 + before * velocity_2
        content_past = last * content_1 + before * content_2
        position = position_1 + step * velocity_1
        height, _ = self.bodies.height(angle, position[0], velocity_1[0])
        compliance = self.elasticity.compliance and self.elasticity.compliance(height)
        _, _, up = self.bodies.accelerations(angle, (*position, *velocity_1), NO_FORCE)
        more = 0.0
        size = np.inf
        for iteration in range(ITERATIONS):
            velocity = now * position + position_past
            motion = *position, *velocity
            _, sliding = self.bodies.height(angle, position[0], velocity[0])
            pressure, fraction = _interpret(unknown)
            h = self.thickness(position, angle, up) + self.deflection(compliance, self.load)
            contact = self.contact(position, h)
            force = self.force(pressure, fraction, h, sliding, contact.pressure)
            force = self._with_gas(force, self.engine.gas(angle), position)
            if available is not None and sliding != 0:
                most = np.abs(sliding) / 2 * self._at_edges(h)
                self.inlet = np.minimum(available / most, 1.0)
            *wanted, up = self.bodies.accelerations(angle, motion, force)
            balance = now * velocity + velocity_past - wanted
            if iteration < LIMITED:
                more = self.sharpened(fraction, sliding)
            oil = self.oil_balance(unknown, h, sliding, now, content_past, more)
            pushing = self.area * np.vstack([-self.sine, self.height * self.sine])
            rubbing = pushing.copy()
            rubbing[1] += self.area * self.arm * self.rubbing(sliding)
            by_force = self._by_force(angle, motion, force)
            jacobian = Jacobian(by_force, compliance, pushing, rubbing, contact)
            missing = self.load - self.area * (pressure + contact.pressure)[self.chosen]
            change, moved, added = self._newton(oil, unknown > 0, jacobian, now, balance, missing)
            change = np.clip(change, -0.5 - np.abs(unknown), 0.5 + np.abs(unknown))
            unknown = np.maximum(unknown + change, EMPTIEST - 1)
            position = position + moved
            self.load = self.load + added
            deflected = self.deflection(compliance, added) / POSITION_SCALE[0]
            scaled = change, moved / POSITION_SCALE, deflected
            size = max(np.abs(one).max() for one in scaled)
            if size < CONVERGED:
                velocity = now * position + position_past
                h = self.thickness(position, angle, up) + self.deflection(compliance, self.load)
                return unknown, h, position, velocity
        raise ArithmeticError(f"no solution at {np.degrees(angle):g} deg: last step {size:.1e}")

    def oil_balance(self, unknown, h, sliding, now, content_past, more) -> OilBalance:
        """Return the residual of the oil balance of each cell, and its slopes.

        Eq. (Z4):  d(f h)/dt + div q = 0,  q = -K dp/dy - V/2 f h along y,  q = -K dp/dx around

        Parameters
        ----------
        unknown, h : ndarray, shape (n,)
            Signed [-], [m].
        sliding : float
            V of the skirt along the bore [m/s].
        now, content_past
            BDF2's rate of f h: now f h + content_past, [1/s], (n,) [m/s].
        more : ndarray, shape (f,)
            Beside the upstream film fraction, `sharpened`.
        """
        faces = self.faces
        pressure, fraction = _interpret(unknown)
        full = unknown > 0
        passing = conductance(faces, h, self.engine.viscosity)
        gradient = faces.gradient @ pressure
        swept = sliding / 4 * (faces.before @ h + faces.behind @ h)
        carried, upstream = self.carried(fraction, sliding)
        carried = carried + more
        flow = -passing.value * gradient - swept * carried
        value = self.area * (now * fraction * h + content_past) + faces.outflow @ flow  # Eq. (Z4)

        by_unknown = _scaled(faces.gradient, -passing.value, PRESSURE_SCALE * full)
        by_unknown = by_unknown - _scaled(upstream, swept, 1.0 * ~full)
        kept = sp.csr_matrix(sp.diags(self.area * now * h * ~full))
        rows = self.chosen
        by_unknown = self.chosen_outflow @ by_unknown + kept[rows]
        by_before, by_behind = (by * gradient + sliding / 4 * carried for by in passing[1:])
        flow = _scaled(faces.before, by_before) + _scaled(faces.behind, by_behind)
        kept = sp.csr_matrix(sp.diags(self.area * now * fraction))
        return OilBalance(value, by_unknown, kept[rows] - self.chosen_outflow @ flow)

    def _with_gas(self, force, gas, position):
        """Add the gas, which acts along the bore's axis."""
        moment = (self.engine.pin_offset + position[0]) * gas
        return FilmForce(force.lateral, force.axial - gas, force.moment + moment)

    def _by_force(self, angle, motion, force):
        """x_A'' and b' per lateral force and moment, (2, 2)."""
        base = self.bodies.accelerations(angle, motion, force)[:2]
        pushed = force._replace(lateral=force.lateral + 1.0)
        turned = force._replace(moment=force.moment + 1.0)
        ends = [self.bodies.accelerations(angle, motion, load)[:2] for load in (pushed, turned)]
        return np.column_stack([end - base for end in ends])

    def _newton(self, oil, full, jacobian, now, balance, missing):
        """Return Newton's step of the cells, of the position and of the loads z on the bodies.

        The effects of the drag on the skirt and of the acceleration along y are left to the
        iteration.

        Eq. (Z11):  z = A (p + p_c),   deflection C z
        """
        by_force, compliance, pushing, rubbing, contact = jacobian
        as_pressure = PRESSURE_SCALE * full
        half = splu(sp.csc_matrix(oil.by_unknown @ self.orbits), permc_spec="MMD_AT_PLUS_A")
        from_position = self.orbits @ half.solve(oil.by_film @ self.by_motion)
        by_cells = -by_force @ (pushing * as_pressure)
        stiffness = now**2 * np.eye(2) - by_cells @ from_position
        stiffness -= by_force @ rubbing @ contact.by_motion

        def reply(load):
            """Change of cells and position, and of the loads that they make, to a change of z."""
            deflection = self.deflection(compliance, load)
            from_oil = self.orbits @ half.solve(oil.value[self.chosen] + oil.by_film @ deflection)
            touching = contact.by_deflection * deflection
            moved = np.linalg.solve(
                stiffness, by_cells @ from_oil - balance + by_force @ (rubbing @ touching)
            )
            change = -from_oil - from_position @ moved
            pressed = as_pressure * change + contact.by_motion @ moved + touching
            return change, moved, self.area * pressed[self.chosen]

        _, _, fixed = reply(0 * missing)
        added = fixed - missing  # Eq. (Z11)
        if compliance is not None:
            shape = compliance.shape
            operator = LinearOperator(shape, lambda load: load - (reply(load)[-1] - fixed))
            added, _ = gmres(operator, added, rtol=ACCURATE, restart=len(added))
        change, moved, _ = reply(added)
        return change, moved, added


def _interpret(unknown):
    """Pressure [Pa] and film fraction [-] of the signed unknown."""
    return PRESSURE_SCALE * np.maximum(unknown, 0), 1 + np.minimum(unknown, 0)


def mirrored(around, along):
    """Return the matrix (n, m) that spreads m cells over all n, and the numbers of the m cells.

    The problem is symmetric about the plane of motion, and the m cells are those of one side.
    """
    i = np.arange(around)
    partner = np.remainder(2 * (around // 4) - i, around)
    own = np.minimum(i, partner)
    cell = (own[:, None] * along + np.arange(along)).ravel()
    chosen, number = np.unique(cell, return_inverse=True)
    spread = sp.csr_matrix((np.ones(len(cell)), (np.arange(len(cell)), number)))
    return spread, chosen
