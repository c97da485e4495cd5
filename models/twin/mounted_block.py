"""Rigid cylinder block on its mounts, under the forces of any number of cylinders.

Eq. (U20):  M q'' + C q' + K q = F,   q = (u, rotation) of the middle of the crank axis O, by the
            trapezoidal rule
Eq. (U21):  M = [m 1, -m c~; m c~, J + m c~^T c~],   c~ v = c x v,  c the centre of mass from O
Eq. (U22):  K = sum_j G_j^T k_j G_j,  C = tau K,   G_j = [1, -r_j~],  r_j mount j from O
Eq. (U23):  F = sum_k (f_k, z_k x f_k + M_k z/|z|),   f_k = R(b_k) (force_x, force_y)
Eq. (U24):  a_k = R(b_k)^T (u'' + rotation'' x z_k),   motion of cylinder k

x, y are as in a cylinder with bank angle 0, z is along the crank. R(b) rotates about z by the
bank angle. Motions of the block are small. It starts at rest with its mounts unloaded, and
forces act from the first step on.
"""

from dataclasses import dataclass

import numpy as np

from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import constant, input_variable, output_variable, parameter

CYLINDERS, MOUNTS = 2, 4
AXES = ("x", "y", "z")
FORCES = {"force_x": "N", "force_y": "N", "moment": "N.m"}
MOTIONS = {
    "acceleration_x": ("m/s2", 1.0),
    "acceleration_y": ("m/s2", 1.0),
    "angular_acceleration": ("rad/s2", 10.0),
    "angular_velocity": ("rad/s", 0.1),
}
VECTORS = (
    ("displacement", "m", "rotation", "rad", "of the block at O", 1e-5),
    ("velocity", "m/s", "rotation_velocity", "rad/s", "of the block at O", 1e-3),
    ("shaking_force", "N", "shaking_moment", "N.m", "of all cylinders about O", 1e3),
    ("mount_force", "N", "mount_moment", "N.m", "of the block on its mounts", 1e2),
)


@dataclass(frozen=True)
class MountedBlockState:
    """State of the block.

    position, velocity, acceleration of q [m, rad], force F [N, N m], each (6,); step : length of
    the last one [s].
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray
    step: float


@dataclass(frozen=True)
class Engine:
    """Matrices M, C, K (6, 6) of Eq. (U20); z [m] and bank angle [rad] of each cylinder."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    along: np.ndarray
    bank: np.ndarray

    def total(self, force_x, force_y, moment) -> np.ndarray:
        """Return F, shape (6,), of all cylinders' forces, each (cylinders,)."""
        cosine, sine = np.cos(self.bank), np.sin(self.bank)
        x, y = cosine * force_x - sine * force_y, sine * force_x + cosine * force_y
        # Eq. (U23)
        turning = (-(self.along @ y), self.along @ x, np.sum(moment))
        return np.array([np.sum(x), np.sum(y), 0.0, *turning])

    def at_cylinder(self, acceleration, velocity) -> np.ndarray:
        """Return the motion of each cylinder in the order of `MOTIONS`, (4, cylinders)."""
        cosine, sine = np.cos(self.bank), np.sin(self.bank)
        across, up, _, pitch, yaw, roll = acceleration
        *_, rolling = velocity
        # Eq. (U24)
        x = across + yaw * self.along
        y = up - pitch * self.along
        alike = np.ones_like(self.along)
        turned = cosine * x + sine * y, cosine * y - sine * x
        return np.array([*turned, roll * alike, rolling * alike])

    def effective(self, step) -> np.ndarray:
        """Return M + h C/2 + h^2 K/4, the effective mass for accelerations at the end of a step."""
        return self.mass + step / 2 * self.damping + step**2 / 4 * self.stiffness


class MountedBlock(FieldSlave):
    """Mounted block by Eqs. (U20) to (U24); build options `cylinders` and `mounts` are numbers."""

    name, description, state_type = (
        "mounted_block",
        "Rigid cylinder block on its mounts",
        MountedBlockState,
    )

    @property
    def derivative_inputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        return ports(cylinders_of(self.options), FORCES)

    @property
    def derivative_outputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        return ports(cylinders_of(self.options), MOTIONS)

    @staticmethod
    def variables(options):
        cylinders, mounts = cylinders_of(options), int(options.get("mounts", MOUNTS))
        each = [f"cylinder_{k}" for k in range(1, cylinders + 1)]
        return [
            *(
                input_variable(f"{one}.{name}", unit, f"{words(name)} on the block", 0.0, 1e3)
                for one in each
                for name, unit in FORCES.items()
            ),
            parameter("mass", "kg", "Mass of block, head, crank and fixed parts", 60.0, 0.1, 1e5),
            *by_axes("inertia", "kg.m2", "Moment of inertia", 2.0, 1e-4, 1e5),
            *by_axes("centre", "m", "Centre of mass", 0.0, -5.0, 5.0),
            *by_axes("mount", "m", "Position", 0.0, -5.0, 5.0, (mounts,)),
            *by_axes("stiffness", "N/m", "Stiffness of each mount", 0.0, 0.0, 1e40, (mounts,)),
            parameter("damping_time", "s", "tau: mounts' damping / stiffness", 0.0, 0.0, 1.0),
            parameter("cylinder_z", "m", "Position", 0.0, -5.0, 5.0, (cylinders,)),
            parameter("bank_angle", "rad", "Bank angle about z", 0.0, -7.0, 7.0, (cylinders,)),
            *(
                output_variable(f"{one}.{name}", unit, f"{words(name)} of the block", nominal)
                for one in each
                for name, (unit, nominal) in MOTIONS.items()
            ),
            *(
                output_variable(f"{name}_{axis}", unit, f"{words(name)} {what}", nominal)
                for first, unit_1, second, unit_2, what, nominal in VECTORS
                for name, unit in ((first, unit_1), (second, unit_2))
                for axis in AXES
            ),
            output_variable("kinetic_energy", "J", "Kinetic energy of the block", 1e-3),
            output_variable("mount_power", "W", "Power dissipated by the mounts", 1.0),
            output_variable(
                "power_error",
                "W",
                "Power of all forces minus that stored and lost, mean over the step",
                1.0,
            ),
            constant("cylinders", cylinders, "Cylinders"),
            constant("mounts", mounts, "Mounts"),
        ]

    def start(self, values):
        self.engine = engine = engine_of(values)
        eigenvalues = np.linalg.eigvalsh(engine.stiffness)
        if 0.0 < eigenvalues[-1] and eigenvalues[0] <= 1e-12 * eigenvalues[-1]:
            raise BadInput(
                [
                    "mount_x, .. stiffness_z: expected mounts that hold all six directions or "
                    "none, got others"
                ]
            )
        still = np.zeros(6)
        state = MountedBlockState(still, still, still, still, 0.0)
        return state, self._shown(state, state, 0.0) | shaking(self._force(values))

    def advance(self, state, values, time, step):
        engine = self.engine
        force = self._force(values)
        # Eq. (U20) at the end of the step
        velocity = state.velocity + step / 2 * state.acceleration
        position = state.position + step * state.velocity + step**2 / 4 * state.acceleration
        residual = force - engine.damping @ velocity - engine.stiffness @ position
        acceleration = np.linalg.solve(engine.effective(step), residual)
        end = MountedBlockState(
            position + step**2 / 4 * acceleration,
            velocity + step / 2 * acceleration,
            acceleration,
            force,
            step,
        )
        return end, self._shown(state, end, step)

    def directional_derivative(self, seeds):
        change = self._force(seeds)
        step = self.state.step
        acceleration = np.linalg.solve(self.engine.effective(step), change)
        return named(self.engine.at_cylinder(acceleration, step / 2 * acceleration))

    def _force(self, values):
        cylinders = cylinders_of(self.options)
        return self.engine.total(
            *(
                np.array([values[f"cylinder_{k}.{name}"] for k in range(1, cylinders + 1)], float)
                for name in FORCES
            )
        )

    def _shown(self, before, now, step):
        engine = self.engine
        on_mounts = engine.stiffness @ now.position + engine.damping @ now.velocity
        travel, mean = now.position - before.position, (before.velocity + now.velocity) / 2
        energies = [
            (
                one.velocity @ engine.mass @ one.velocity,
                one.position @ engine.stiffness @ one.position,
            )
            for one in (before, now)
        ]
        (kinetic_0, elastic_0), (kinetic_1, elastic_1) = energies
        lost = travel @ engine.damping @ mean
        per_second = 1.0 / step if step > 0.0 else 0.0
        stored = (kinetic_1 - kinetic_0 + elastic_1 - elastic_0) / 2
        six = {
            ("displacement", "rotation"): now.position,
            ("velocity", "rotation_velocity"): now.velocity,
            ("mount_force", "mount_moment"): on_mounts,
        }
        return {
            **named(engine.at_cylinder(now.acceleration, now.velocity)),
            **shaking(now.force),
            **{one: value for names, q in six.items() for one, value in by_axis(names, q).items()},
            "kinetic_energy": kinetic_1 / 2,
            "mount_power": now.velocity @ engine.damping @ now.velocity,
            "power_error": per_second * (travel @ (before.force + now.force) / 2 - stored - lost),
        }


def cylinders_of(options):
    """Return the number of cylinders in the build options."""
    return int(options.get("cylinders", CYLINDERS))


def by_axes(name, *row):
    """Return a parameter along each axis."""
    return [parameter(f"{name}_{axis}", *row) for axis in AXES]


def words(name):
    """Return a variable's name as words."""
    return name.replace("_", " ").capitalize()


def ports(cylinders, names):
    """Return the variables of all cylinders."""
    return tuple(f"cylinder_{k}.{name}" for k in range(1, cylinders + 1) for name in names)


def named(motions):
    """Return values (4, cylinders) by variable."""
    return {
        f"cylinder_{k}.{name}": value
        for name, row in zip(MOTIONS, motions)
        for k, value in enumerate(row, 1)
    }


def by_axis(names, values):
    """Return the six numbers of two vectors by variable."""
    parts = zip(names, np.reshape(values, (2, 3)))
    return {f"{name}_{axis}": one for name, three in parts for axis, one in zip(AXES, three)}


def shaking(force):
    """Return F by variable."""
    return by_axis(("shaking_force", "shaking_moment"), force)


def cross(vector):
    """Return the matrix of v -> vector x v."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def engine_of(values):
    """Return the matrices of the block from its parameters."""
    mass = values["mass"]
    centre = cross([values[f"centre_{axis}"] for axis in AXES])
    inertia = np.diag([values[f"inertia_{axis}"] for axis in AXES])
    # Eq. (U21)
    first = mass * centre
    whole = np.block([[mass * np.eye(3), -first], [first, inertia + mass * centre.T @ centre]])
    stiffness = np.zeros((6, 6))
    places = np.array([values[f"mount_{axis}"] for axis in AXES]).T
    springs = np.array([values[f"stiffness_{axis}"] for axis in AXES]).T
    for place, spring in zip(places, springs):
        # Eq. (U22)
        lever = np.hstack([np.eye(3), -cross(place)])
        stiffness += lever.T @ np.diag(spring) @ lever
    damping = values["damping_time"] * stiffness
    return Engine(whole, damping, stiffness, values["cylinder_z"], values["bank_angle"])
