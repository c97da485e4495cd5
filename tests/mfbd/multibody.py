"""A multibody program in absolute coordinates, the reference of the plane mechanism.

Bodies are mass points with mode shapes. Every body has its position, its angle and its modal
coordinates, joints are constraints with multipliers, and forces act by virtual power. Nothing is
taken from `fmu_mfbd.mechanism`: neither its minimal coordinates nor its integrals over bodies.

    M q'' + c = Q + J^T m,   J q'' = g      m the multipliers, g from the velocities

The films are springs and dampers on grids whose kinematics are those of the interface between the
FMUs (docs/interface.md).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])


def rotation(angle):
    """Return the matrix from axes that are rotated by an angle to space."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


@dataclass
class Body:
    """Body of n mass points and k modes.

    points (n, 2) and shapes (3, n, k) are in the body's axes, in [m] and [kg^-1/2]. The shapes are
    orthonormal with the masses (n,). Modes along z alone have no momentum in the plane.
    """

    points: np.ndarray
    masses: np.ndarray
    shapes: np.ndarray
    omega: np.ndarray
    damping_ratio: float = 0.0
    first: int = 0

    @property
    def size(self):
        return 3 + len(self.omega)

    def inertia(self, q, v):
        """Return M and c of Newton's law of all points, by virtual power."""
        R, turning = rotation(q[2]), v[2]
        across = self.shapes[:2]
        inside = self.points + np.einsum("ink,k->ni", across, q[3:])
        by = np.zeros((3, len(self.masses), self.size))
        by[0, :, 0] = by[1, :, 1] = 1.0
        by[:2, :, 2] = QUARTER @ R @ inside.T
        by[:2, :, 3:] = np.einsum("ij,jnk->ink", R, across)
        by[2, :, 3:] = self.shapes[2]
        moving = np.einsum("ink,k->in", across, v[3:])
        bias = 2 * turning * QUARTER @ R @ moving - turning**2 * R @ inside.T
        mass = np.einsum("inj,n,ink->jk", by, self.masses, by)
        forces = np.einsum("inj,n,in->j", by[:2], self.masses, bias)
        return mass, forces

    def elastic(self, q, v):
        """Return the forces of the springs and dampers of the modes."""
        out = np.zeros(self.size)
        out[3:] = -(self.omega**2) * q[3:] - 2 * self.damping_ratio * self.omega * v[3:]
        return out


def plain(points, masses, omega=(), damping_ratio=0.0):
    """Return a rigid body, with modes along z if they have frequencies.

    A pair of opposite masses at the first point carries each mode. Together they have no momentum
    in the plane, and the modal mass is one.
    """
    k = len(omega)
    points, masses = np.array(points, float), np.array(masses, float)
    points = np.concatenate([points, np.repeat(points[:1], 2 * k, axis=0)])
    masses = np.concatenate([masses, np.tile([1.0, -1.0], k)])
    shapes = np.zeros((3, len(masses), k))
    for j in range(k):
        shapes[2, 2 * j - 2 * k, j] = 1.0
    return Body(points, masses, shapes, np.array(omega, float), damping_ratio)


class Point(NamedTuple):
    """A point of a body, in its axes."""

    body: Body
    place: tuple[float, float] = (0.0, 0.0)


class PointMotion(NamedTuple):
    """Position and velocity of a point, derivatives (2, n), and acceleration at q'' = 0."""

    place: np.ndarray
    velocity: np.ndarray
    by: np.ndarray
    bias: np.ndarray


def motion(point, q, v):
    """Return the motion of a point of the undeformed body."""
    first = point.body.first
    R = rotation(q[first + 2])
    arm = R @ np.array(point.place)
    by = np.zeros((2, len(q)))
    by[0, first] = by[1, first + 1] = 1.0
    by[:, first + 2] = QUARTER @ arm
    return PointMotion(q[first : first + 2] + arm, by @ v, by, -(v[first + 2] ** 2) * arm)


class Joint(NamedTuple):
    """Two points that coincide; the multipliers are the force on the first one."""

    one: Point
    other: Point

    def rows(self, time, q, v):
        a, b = motion(self.one, q, v), motion(self.other, q, v)
        return a.by - b.by, b.bias - a.bias


class Driven(NamedTuple):
    """A coordinate with a given acceleration; the multiplier is the force on it."""

    coordinate: int
    acceleration: Callable[[float], float]

    def rows(self, time, q, v):
        row = np.zeros((1, len(q)))
        row[0, self.coordinate] = 1.0
        return row, np.array([self.acceleration(time)])


class Rates(NamedTuple):
    """What a film's forces do work on: derivatives by velocities, (cells, n), and the film itself.

    Pressure works on `closing`, friction on `onward`. thickness [m] and speed [m/s] are of the
    cells.
    """

    closing: np.ndarray
    onward: np.ndarray
    thickness: np.ndarray
    speed: np.ndarray


@dataclass
class Film:
    """Springs and dampers of a film, in sum over its cells, or given forces.

    stiffness : of pressure against the change of the film thickness [N/m].
    friction : of friction against the sliding velocity [N s/m].
    given : forces of pressure and friction on all cells, which replace them [N].
    """

    stiffness: float
    friction: float
    given: tuple[np.ndarray, np.ndarray] | None = field(default=None, kw_only=True)

    def rates(self, time, q, v) -> Rates:
        raise NotImplementedError

    def forces(self, time, q, v):
        """Return generalised forces, and those that separate the surfaces, by cell."""
        at = self.rates(time, q, v)
        push = -self.stiffness / len(at.thickness) * at.thickness
        drag = -self.friction / len(at.speed) * at.speed
        if self.given is not None:
            push, drag = self.given
        return push @ at.closing + drag @ at.onward, push


@dataclass
class Journal(Film):
    """A pin or a journal in a shell, on a grid of cells fixed to the shell.

    pin, shell : points on both axes. radius : of the pin [m]. grid : cells around and along.
    modes : of the shell's body on the grid, outward and onward, (cells, k) each; its last ones.
    axis : shapes of the pin at the rows, (rows, n). Its modes are their coordinates in space, along
    x and then along y.
    """

    pin: Point
    shell: Point
    radius: float
    grid: tuple[int, int]
    modes: tuple[np.ndarray, np.ndarray] | None = None
    axis: np.ndarray | None = None

    def _position(self, q, v):
        """Return pin from shell by row in the shell's axes, and its derivatives (rows, 2, n)."""
        pin, shell = motion(self.pin, q, v), motion(self.shell, q, v)
        rows = self.grid[1]
        apart = np.repeat((pin.place - shell.place)[None], rows, axis=0)
        by = np.repeat((pin.by - shell.by)[None], rows, axis=0)
        if self.axis is not None:
            n = self.axis.shape[1]
            first = self.pin.body.first + 3
            apart = apart + self.axis @ q[first : first + 2 * n].reshape(2, n).T
            for way in range(2):
                by[:, way, first + way * n : first + (way + 1) * n] += self.axis
        turn = self.shell.body.first + 2
        R = rotation(q[turn])
        by[:, :, turn] -= apart @ QUARTER.T
        return apart @ R, np.einsum("ki,jkn->jin", R, by)

    def rates(self, time, q, v):
        around, along = self.grid
        a = 2 * np.pi * np.arange(around) / around
        e, t = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
        apart, by = self._position(q, v)
        turning = np.zeros(len(q))
        turning[self.pin.body.first + 2] += 1.0
        turning[self.shell.body.first + 2] -= 1.0
        aside, out = apart @ t, apart @ e
        closing = -np.einsum("ia,jin->ajn", e, by) - aside.T[:, :, None] * turning
        onward = np.einsum("ia,jin->ajn", t, by) + (self.radius - out.T)[:, :, None] * turning
        thickness = -out.T.ravel()
        cells = around * along
        closing, onward = closing.reshape(cells, -1), onward.reshape(cells, -1)
        if self.modes is not None:
            outward, along_ = self.modes
            k = outward.shape[1]
            last = self.shell.body.first + self.shell.body.size
            own = slice(last - k, last)
            field_ = outward.reshape(around, along, k)
            slope = (np.roll(field_, -1, axis=0) - np.roll(field_, 1, axis=0)) * around / 4 / np.pi
            closing[:, own] += outward
            closing += np.outer(slope.reshape(cells, k) @ q[own], turning)
            onward[:, own] -= along_
            thickness = thickness + outward @ q[own]
        speed = np.full(cells, self.radius * (turning @ v))
        return Rates(closing, onward, thickness, speed)


@dataclass
class Skirt(Film):
    """Skirt of a piston in the bore of the block.

    piston, block : bodies, whose origins are pin point A and the crank axis.
    offsets : x of A from the crank axis where the skirt is concentric, and from the skirt's axis.
    radius : of the bore [m]. angle, height : (c,), (a,). radial, axial : modes of the piston on the
    cells, (c a, k). bore : modes of the block, (c, k), and their growth with height above the crank
    axis [kg^-1/2], [kg^-1/2 m^-1]. guided : height of A for a skirt in the middle of the bore, and
    its derivative by the crank's angle, by time. crank : its angle's coordinate.
    """

    piston: Body
    block: Body
    offsets: tuple[float, float]
    radius: float
    angle: np.ndarray
    height: np.ndarray
    radial: np.ndarray
    axial: np.ndarray
    bore: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
    guided: Callable[[float], tuple[float, float]] | None = None
    crank: int = 0

    def rates(self, time, q, v):
        R = rotation(q[self.block.first + 2])
        a, o = motion(Point(self.piston), q, v), motion(Point(self.block), q, v)
        by = a.by - o.by
        by[:, self.block.first + 2] -= QUARTER @ (a.place - o.place)
        by, apart = R.T @ by, R.T @ (a.place - o.place)
        tilt = np.zeros(len(q))
        tilt[self.piston.first + 2], tilt[self.block.first + 2] = 1.0, -1.0
        sine = np.repeat(np.sin(self.angle), len(self.height))
        height = np.tile(self.height, len(self.angle))
        modes = slice(self.piston.first + 3, self.piston.first + self.piston.size)
        rolled = np.outer(height * sine, tilt)
        closing = rolled - np.outer(sine, by[0])
        closing[:, modes] -= self.radial
        onward = by[1] + np.outer(self.radius * sine - self.offsets[1], tilt)
        onward[:, modes] += self.axial
        thickness = sine * (height * (tilt @ q) - (apart[0] - self.offsets[0]))
        thickness -= self.radial @ q[modes]
        if self.bore is not None:
            level, growth, along = (np.repeat(one, len(self.height), axis=0) for one in self.bore)
            of_block = slice(self.block.first + 3, self.block.first + self.block.size)
            guided, lever = self.guided(time)
            field_ = level + growth * (guided + height)[:, None]
            closing[:, of_block] += field_
            onward[:, of_block] -= along
            # the bore that is read moves with the crank
            closing[:, self.crank] += lever * growth @ q[of_block]
            closing[:, self.block.first + 2] -= lever * growth @ q[of_block]
            thickness += field_ @ q[of_block]
        return Rates(closing, onward, thickness, onward @ v)

    def axial_push(self, time, q, v):
        """Return the force of pressure on the slope of the bore, along the piston [N]."""
        if self.bore is None:
            return 0.0
        slope = self.bore[1] @ q[self.block.first + 3 : self.block.first + self.block.size]
        _, push = self.forces(time, q, v)
        return np.repeat(slope, len(self.height)) @ push


@dataclass
class Gas:
    """Gas force on the crown along the bore's axis, its opposite on the deck [N].

    rings : their force on the piston across and along the bore's axis [N], and moment about A
    beside that of the latter [N m]; the bore has the opposite.
    """

    piston: Body
    block: Body
    offsets: tuple[float, float]
    modal: np.ndarray
    force: Callable[[float], float]
    rings: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def forces(self, time, q, v):
        R = rotation(q[self.block.first + 2])
        a, o = motion(Point(self.piston), q, v), motion(Point(self.block), q, v)
        apart = R.T @ (a.place - o.place)
        axis = self.offsets[0] - self.offsets[1]
        on_axis = R @ np.array([axis, apart[1]]) + o.place
        out = np.zeros(len(q))
        size = self.force(time)
        lateral, axial, moment = self.rings
        for body, sign in ((self.piston, 1.0), (self.block, -1.0)):
            first = body.first
            # the lateral force of the rings acts at the height of A
            for place, push in (
                (on_axis, (axial - size) * R[:, 1]),
                (a.place, lateral * R[:, 0]),
            ):
                arm = place - q[first : first + 2]
                out[first : first + 2] += sign * push
                out[first + 2] += sign * (arm[0] * push[1] - arm[1] * push[0])
            out[first + 2] += sign * moment
        out[self.piston.first + 3 : self.piston.first + self.piston.size] += size * self.modal
        return out, None


@dataclass
class Touching:
    """Contact of a point of a body with a line of the block, by a spring with [Hunt1975]'s damping.

    height : of the point above the body's origin [m]. offset : x of the line in the block [m].
    clearance : between them at rest [m]. stiffness : [N/m]. damping : [s/m].
    """

    body: Body
    block: Body
    height: float
    offset: float
    clearance: float
    stiffness: float
    damping: float

    def forces(self, time, q, v):
        """Return the generalised forces, and the power."""
        out = np.zeros(len(q))
        point, origin = motion(Point(self.body, (0.0, self.height)), q, v), Point(self.block)
        frame, spin = motion(origin, q, v), v[self.block.first + 2]
        R = rotation(q[self.block.first + 2])
        apart = point.place - frame.place
        sliding = R.T @ (point.velocity - frame.velocity - spin * QUARTER @ apart)
        x = (R.T @ apart)[0] - self.offset
        side, depth = np.sign(x), max(abs(x) - self.clearance, 0.0)
        size = self.stiffness * depth * max(1 + self.damping * side * sliding[0], 0.0)
        push = -side * size * R[:, 0]
        for body, sign in ((self.body, 1.0), (self.block, -1.0)):
            arm = point.place - q[body.first : body.first + 2]
            out[body.first : body.first + 2] += sign * push
            out[body.first + 2] += sign * (arm[0] * push[1] - arm[1] * push[0])
        return out, -side * size * sliding[0]


@dataclass
class Rubbing:
    """Friction between two bodies that a joint presses together.

    one, other : bodies. lever : friction coefficient times radius [m]. speed : relative angular
    velocity at which dry friction has reached tanh(1) of its full size [rad/s]. viscous : moment by
    relative angular velocity [N m s/rad]. load : force of the joint [N].
    """

    one: Body
    other: Body
    lever: float
    speed: float
    viscous: float
    load: float = 0.0

    def forces(self, time, q, v):
        out = np.zeros(len(q))
        slip = v[self.one.first + 2] - v[self.other.first + 2]
        moment = -self.lever * self.load * np.tanh(slip / self.speed) - self.viscous * slip
        out[self.one.first + 2] += moment
        out[self.other.first + 2] -= moment
        return out, None


@dataclass
class Multibody:
    """A system of bodies, constraints and force elements."""

    bodies: list[Body]
    constraints: list[Any] = field(default_factory=list)
    elements: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self):
        self.size = 0
        for body in self.bodies:
            body.first = self.size
            self.size += body.size

    def solve(self, time, q, v):
        """Return accelerations and multipliers."""
        n = self.size
        mass, right = np.zeros((n, n)), np.zeros(n)
        for body in self.bodies:
            own = slice(body.first, body.first + body.size)
            mass[own, own], bias = body.inertia(q[own], v[own])
            right[own] = body.elastic(q[own], v[own]) - bias
        for element in self.elements.values():
            right += element.forces(time, q, v)[0]
        rows, accelerations = zip(*(one.rows(time, q, v) for one in self.constraints))
        J = np.vstack(rows)
        m = len(J)
        whole = np.block([[mass, J.T], [J, np.zeros((m, m))]])
        found = np.linalg.solve(whole, np.concatenate([right, *accelerations]))
        return found[:n], -found[n:]

    def run(self, q, v, times, tolerance=1e-10):
        """Return positions, velocities and multipliers at the times, (steps, n) each."""
        n = self.size

        def rate(time, y):
            acceleration, _ = self.solve(time, y[:n], y[n:])
            return np.concatenate([y[n:], acceleration])

        # micrometres matter beside decimetres
        found = solve_ivp(
            rate,
            (times[0], times[-1]),
            np.concatenate([q, v]),
            method="DOP853",
            t_eval=times,
            rtol=tolerance,
            atol=1e-13,
        )
        assert found.success, found.message
        q, v = found.y[:n].T, found.y[n:].T
        held = np.array([self.solve(*one)[1] for one in zip(times, q, v)])
        return q, v, held
