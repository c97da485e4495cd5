"""The plane mechanism against a multibody program in absolute coordinates (`multibody`).

Piston, block and pin are mass points with modes, films are springs and dampers. The model of the
FMU takes equal steps, and its error falls with their square.
"""

import dataclasses
from functools import partial

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble, model_of
from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import AxisParameters, PinParameters
from piston_cosim.fmu_mfbd.dynamics.pin_shells import shell_modes_of
from piston_cosim.fmu_mfbd.geometry.pin import PinForces
from piston_cosim.fmu_mfbd.geometry.pin_shapes import free_beam
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED, BlockMotion
from piston_cosim.fmu_mfbd.mechanism.cylinder import EYE
from piston_cosim.fmu_mfbd.reduction.reduced_body import (
    ReducedBosses,
    ReducedPiston,
)

from .multibody import (
    Body,
    Driven,
    Gas,
    Joint,
    Journal,
    Multibody,
    Point,
    Skirt,
    motion,
    plain,
    rotation,
)
from .pin_models import (
    GRID,
    OFFSET,
    OWN,
    PARAMETERS,
    PIN,
    PIN_GRID,
    RADII,
    bodies,
    crank_options,
    options,
    small_end,
)
from .pin_models import GRIDS as CRANK_GRIDS

SPEED = 176.0
START, LATERAL, TILT = 0.3, 2e-6, 1e-4
"""Crank angle [rad], x_A [m], rocking angle [rad]."""
GAS = 2e5
OMEGA, BLOCK_OMEGA = np.array([3e3, 5e3, 8e3]), np.array([4e3, 7e3])
SOFT = 0.05
"""Young's modulus of the small end, as a share of that of `pin_models`."""

RATIO = 0.05
STIFF, DRAG = 2e7, 30.0
UNBALANCE = -0.12
P = dataclasses.replace(
    PARAMETERS,
    barrel=0.0,
    ovality=0.0,
    damping_ratio=RATIO,
    high_frequency_damping_ratio=RATIO,
    crank_unbalance=UNBALANCE,
    pin_friction_coefficient=0.0,
)
SHAPES, SOFT_PIN = 3, PIN._replace(young=4e9)
AXIS = AxisParameters(
    pin_length=PIN.length, pin_bore_radius=PIN.bore_radius, pin_young=SOFT_PIN.young
)
CONCENTRIC = OFFSET - P.crank_offset
BORE, EDGES = 55e-3, (-45.5e-3, 37.3e-3)
ANGLES = 2 * np.pi * np.arange(GRID[0]) / GRID[0]


def gas(time):
    """Return the gauge pressure [Pa]: a smooth pulse."""
    return GAS * np.sin(1.2e3 * time) ** 2


def piston_body():
    """Return nine mass points with three modes that share their momentum."""
    rng = np.random.default_rng(5)
    points = np.array([1.5e-3, 26.5e-3]) + 0.03 * rng.standard_normal((9, 2))
    masses = 1.39 * (w := 0.5 + rng.random(9)) / w.sum()
    shapes = rng.standard_normal((27, 3))
    weight = np.tile(masses, 3)
    lower = np.linalg.cholesky(shapes.T @ (weight[:, None] * shapes))
    shapes = np.linalg.solve(lower, shapes.T).T.reshape(3, 9, 3)
    return Body(points, masses, shapes, OMEGA, RATIO)


def reduced(body, fields):
    """Return the integrals of a body of mass points, Eqs. (J7), for the FMU."""
    x, y = body.points.T
    m, (u, v, _) = body.masses, body.shapes
    return ReducedPiston(
        mass=m.sum(),
        S=m @ body.points,
        I0=m @ (x * x + y * y),
        T=np.array([m @ u, m @ v]),
        b=m @ (x[:, None] * u + y[:, None] * v),
        B=np.einsum("n,nk,nl->kl", m, u, u) + np.einsum("n,nk,nl->kl", m, v, v),
        g=m @ (x[:, None] * v - y[:, None] * u),
        G=np.einsum("n,nl,nk->kl", m, u, v) - np.einsum("n,nl,nk->kl", m, v, u),
        omega=body.omega,
        kind=np.full(len(body.omega), -1),
        radius=54.95e-3,
        skirt_lower=EDGES[0],
        skirt_upper=EDGES[1],
        pin_offset=OFFSET,
        **fields,
    )


@dataclasses.dataclass
class Case:
    """Engine of a test: what has films, and whether its block moves."""

    floats: bool = False
    crank: bool = False
    bends: bool = False
    block_modes: bool = False
    moves: bool = False


def single(values):
    """Return values that single precision represents, as the FMU stores those of modes."""
    return values.astype(np.float32).astype(float)


class Fields:
    """Modes of piston and block on the films, by random numbers."""

    def __init__(self):
        rng = np.random.default_rng(6)
        cells = GRID[0] * GRID[1]
        self.radial = single(0.5 * rng.standard_normal((cells, 3)))
        self.axial = single(0.3 * rng.standard_normal((cells, 3)))
        self.gas_force = 0.5 * rng.standard_normal(3)
        around, along = PIN_GRID
        a = 2 * np.pi * np.arange(around) / around
        wave = np.array([np.cos(n * a + p) for n, p in ((2, 0.3), (1, 1.1), (3, -0.4))]).T
        rows = 1 + 0.2 * rng.standard_normal((2, along, 3))
        self.outward = wave[None, :, None, :] * rows[:, None]
        self.onward = 0.4 * np.roll(self.outward, 3, axis=1)
        self.bore = 0.5 * rng.standard_normal((GRID[0], 2))
        self.growth = 5.0 * rng.standard_normal((GRID[0], 2))
        self.along = 0.3 * rng.standard_normal((GRID[0], 2))


FIELDS = Fields()


def block_of(case):
    """Return the reduced block; its modes vary linearly with height."""
    block = bodies().block
    if not case.block_modes:
        return block
    heights = np.ones(len(block.heights))
    level, along = (np.einsum("ck,s->csk", one, heights) for one in (FIELDS.bore, FIELDS.along))
    radial = level + np.einsum("ck,s->csk", FIELDS.growth, block.heights)
    return dataclasses.replace(
        block, radial=radial, axial=along, omega=BLOCK_OMEGA, kind=np.full(2, -1)
    )


def fmu_model(case, parameters=P, elements=()):
    """Return the model of the FMU; `elements` are parameters of force elements."""
    named = {"radial": FIELDS.radial, "axial": FIELDS.axial, "gas_force": FIELDS.gas_force}
    piston = reduced(piston_body(), named)
    block = block_of(case)
    parts = bodies()._replace(piston=piston, block=block)
    if not case.floats:
        built = dataclasses.replace(options(False), mounted=case.moves)
        return assemble(piston, block, built, parameters, elements)
    stations = np.array([[-1.0], [1.0]]) * np.linspace(0.03, 0.05, PIN_GRID[1])
    parts = parts._replace(bosses=ReducedBosses(FIELDS.outward, FIELDS.onward, stations, 18e-3))
    names = tuple(OWN) if case.crank else ()
    built, axis = dataclasses.replace(crank_options(names), mounted=case.moves), []
    if case.bends:
        parts = parts._replace(shells={"small_end": small_end(SOFT)})
        pin = dataclasses.replace(built.floating_pin, pin_shapes=SHAPES)
        built, axis = dataclasses.replace(built, floating_pin=pin), [AXIS]
    own = [PinParameters(), *axis, *(OWN[name] for name in names), *elements]
    return model_of(parts, built, parameters, own)


def stepped(case, step, end):
    """Return outputs of the FMU's model by name, (steps + 1,), with springs in place of films."""
    model = fmu_model(case)
    films = (*model.films, *model.grids)
    cells = [int(np.prod(one.shape)) for one in films]
    even = [P.radial_clearance, *(one.clearance.mean() for one in model.pins)]
    velocities = ["sliding_velocity", *["circumferential_velocity"] * len(model.grids)]

    def demanded(out):
        """Return the forces of the springs and dampers, by film."""
        return [
            (
                STIFF / n * (rest - out[f"{one.prefix}film_thickness"]),
                -DRAG / n * out[f"{one.prefix}{name}"],
            )
            for one, n, rest, name in zip(films, cells, even, velocities)
        ]

    def inputs(time, forces):
        (push, drag), *pins = forces
        return Inputs(
            SPEED, gas(time), push, drag, pins=tuple(PinForces(*one) for one in pins),
            carrier=carrier(time) if case.moves else FIXED,
        )  # fmt: skip

    zero = [(np.zeros(one.shape), np.zeros(one.shape)) for one in films]
    forces = demanded(model.start(START, LATERAL, TILT, inputs(0.0, zero))[1])
    state, out = model.start(START, LATERAL, TILT, inputs(0.0, forces))
    if case.bends:
        out["eye"] = shell_modes_of(model.chain.elements, state.position, EYE)
    way = [out]
    for k in range(round(end / step)):
        for _ in range(40):
            after, out = model.advance(state, inputs((k + 1) * step, forces), step)
            before, forces = forces, demanded(out)
            missing = [np.abs(a - b).max() for p, q in zip(before, forces) for a, b in zip(p, q)]
            if max(missing) <= 1e-10:
                break
        else:
            raise AssertionError(f"forces of springs: {max(missing):.3g} N are missing")
        state = after
        if case.bends:
            out["eye"] = shell_modes_of(model.chain.elements, state.position, EYE)
        way.append(out)
    return way


def carrier(time):
    """Return the motion of the block of a case that moves: it shakes and turns."""
    x, y, turn = block_motion(time)
    c, s = np.cos(turn[0]), np.sin(turn[0])
    return BlockMotion(c * x[2] + s * y[2], c * y[2] - s * x[2], turn[2], turn[1])


def block_motion(time):
    """Return x, y and angle of the block, each with its derivatives."""
    sizes = ((1e-3, 700.0), (-2e-3, 500.0), (4e-3, 600.0))
    return tuple(
        (
            a * np.sin(w * time) ** 2,
            a * w * np.sin(2 * w * time),
            2 * a * w**2 * np.cos(2 * w * time),
        )
        for a, w in sizes
    )


def guided(time):
    """Return the height of A for a skirt in the middle of the bore, and its slope by the angle."""
    angle = START + SPEED * time
    r, aside = P.crank_radius, CONCENTRIC + P.crank_radius * np.sin(angle)
    rise = np.sqrt(P.rod_length**2 - aside**2)
    return r * np.cos(angle) + rise, -r * np.sin(angle) - aside / rise * r * np.cos(angle)


def reference_bodies(case):
    """Return the bodies of a case by name."""
    p, arm = P, 0.05
    swing = np.sqrt(p.rod_inertia / p.rod_mass)
    eye, bending, gyration = (), (), 0.0
    if case.floats:
        gyration = np.hypot(p.pin_radius, AXIS.pin_bore_radius * case.bends) / np.sqrt(2)
    if case.bends:
        eye = small_end(SOFT).omega
        bending = np.tile(free_beam(SOFT_PIN, SHAPES).omega, 2)
    rod = [[0.0, p.rod_centre - swing], [0.0, p.rod_centre + swing]]
    unbalance = [UNBALANCE / arm / 2, -UNBALANCE / arm / 2]
    crank = OWN["main_bearing"].crank_mass * case.crank, *unbalance
    return {
        "block": plain([[0.0, 0.0]], [0.0], BLOCK_OMEGA if case.block_modes else (), RATIO),
        "crank": plain([[0.0, 0.0], [0.0, arm], [0.0, -arm]], crank),
        "rod": plain(rod, [p.rod_mass / 2] * 2, eye, RATIO),
        "pin": plain([[-gyration, 0.0], [gyration, 0.0]], [p.pin_mass / 2] * 2, bending, RATIO),
        "piston": piston_body(),
    }


CRANK_PIN, TIP = (0.0, P.crank_radius), (0.0, P.rod_length)


def reference_films(case, model, of):
    """Return the force elements of a case by name, `of` its bodies."""
    size = (EDGES[1] - EDGES[0]) / GRID[1]
    heights = EDGES[0] + size * (np.arange(GRID[1]) + 0.5)
    piston, block, offsets = of["piston"], of["block"], (CONCENTRIC, OFFSET)
    bore = (FIELDS.bore, FIELDS.growth, FIELDS.along) if case.block_modes else None
    own = BORE, ANGLES, heights, FIELDS.radial, FIELDS.axial, bore, guided, of["crank"].first + 2
    out = {
        "skirt": Skirt(STIFF, DRAG, piston, block, offsets, *own),
        "gas": Gas(piston, block, offsets, FIELDS.gas_force, lambda t: gas(t) * np.pi * BORE**2),
    }
    if case.floats:
        axis = [one.axis if case.bends else None for one in model.pins]
        film = STIFF, DRAG, Point(of["pin"])
        for side, fields in enumerate(zip(FIELDS.outward, FIELDS.onward)):
            modes = tuple(one.reshape(-1, len(OMEGA)) for one in fields)
            bore = Point(piston), P.pin_radius, PIN_GRID, modes
            out[f"boss_{side}"] = Journal(*film, *bore, axis[side])
        eye = small_end(SOFT)
        modes = tuple(one.reshape(-1, len(eye.omega)) for one in (eye.outward, eye.onward))
        bore = Point(of["rod"], TIP), P.pin_radius, PIN_GRID, modes if case.bends else None
        out["small_end"] = Journal(*film, *bore, axis[2])
    if case.crank:
        for name, place, shell in (
            ("big_end", CRANK_PIN, "rod"),
            ("main_bearing", (0, 0), "block"),
        ):
            own = Point(of["crank"], place), Point(of[shell]), RADII[name], CRANK_GRIDS[name]
            out[name] = Journal(STIFF, DRAG, *own)
    return out


def reference_joints(case, of):
    """Return the constraints of a case by name, `of` its bodies."""

    def block(time, k):
        return block_motion(time)[k][2] * case.moves

    out: dict = {f"block_{k}": Driven(k, partial(block, k=k)) for k in range(3)}
    out["drive"] = Driven(of["crank"].first + 2, partial(block, k=2))
    if not case.floats:
        out["small_end"] = Joint(Point(of["pin"]), Point(of["rod"], TIP))
        out["boss"] = Joint(Point(of["pin"]), Point(of["piston"]))
        out["turn"] = Driven(of["pin"].first + 2, lambda time: 0.0)
    if not case.crank:
        out["main_bearing"] = Joint(Point(of["crank"]), Point(of["block"]))
        out["big_end"] = Joint(Point(of["crank"], CRANK_PIN), Point(of["rod"]))
    return out


class Reference:
    """The engine of a case in absolute coordinates."""

    def __init__(self, case):
        self.case = case
        model = fmu_model(case)
        self.of = reference_bodies(case)
        self.system = Multibody(list(self.of.values()))
        self.system.elements = reference_films(case, model, self.of)
        joints = reference_joints(case, self.of)
        self.system.constraints = list(joints.values())
        self.rows, first = {}, 0
        for name, one in joints.items():
            rows = 2 if isinstance(one, Joint) else 1
            self.rows[name], first = slice(first, first + rows), first + rows

    def start(self):
        """Return position and velocity at the start: no play, only the crank and the rod move."""
        p, n = P, self.system.size
        q, v = np.zeros(n), np.zeros(n)
        crank_pin = p.crank_radius * np.array([-np.sin(START), np.cos(START)])
        xi = CONCENTRIC + LATERAL - crank_pin[0]
        rise = np.sqrt(p.rod_length**2 - xi**2)
        A = np.array([CONCENTRIC + LATERAL, crank_pin[1] + rise])
        speed = SPEED * np.array([-crank_pin[1], crank_pin[0]])
        turn = -np.arcsin(xi / p.rod_length)
        turning = speed[0] / rise
        up = speed[1] + turning * xi
        for name, place, angle, velocity, spin in (
            ("crank", (0, 0), START, (0, 0), SPEED),
            ("rod", crank_pin, turn, speed, turning),
            ("pin", A, 0.0, (0, up), 0.0),
            ("piston", A, TILT, (0, up), 0.0),
        ):
            first = self.of[name].first
            q[first : first + 3] = (*place, angle)
            v[first : first + 3] = (*velocity, spin)
        return q, v

    def outputs(self, time, q, v, held):
        """Return the outputs of the FMU by name."""
        case, by_name = self.case, self.rows
        first = {name: body.first for name, body in self.of.items()}
        R = rotation(q[first["block"] + 2])
        roll = q[first["block"] + 2]

        def place(body, point=(0.0, 0.0)):
            return motion(Point(self.of[body], point), q, v).place

        def on(element, body):
            total = self.system.elements[element].forces(time, q, v)[0]
            return R.T @ total[first[body] : first[body] + 2]

        def multiplier(name):
            return R.T @ held[by_name[name]]

        A = R.T @ (place("piston") - place("block"))
        k = first["piston"]
        out = {
            "lateral_displacement": A[0] - CONCENTRIC,
            "rocking_angle": q[k + 2] - roll,
            "modal_coordinate": np.concatenate([q[k + 3 : k + 6], q[3 : self.of["block"].size]]),
            "side_force": -on("skirt", "piston")[0],
            "crank_torque": held[by_name["drive"]][0],
            "moment_on_block": -held[by_name["block_2"]][0],
        }
        on_block = -R.T @ np.concatenate([held[by_name["block_0"]], held[by_name["block_1"]]])
        vectors = {"force_on_block": on_block}
        # pressure on a bore that is not straight pushes the piston, and all joints pass it on
        slope = np.array([0.0, self.system.elements["skirt"].axial_push(time, q, v)])
        if case.floats:
            vectors["pin_displacement"] = R.T @ (place("pin") - place("piston"))
            vectors["small_end_displacement"] = R.T @ (place("pin") - place("rod", TIP))
            vectors["small_end_force"] = slope - on("small_end", "pin")
            vectors["pin_force"] = -on("boss_0", "pin") - on("boss_1", "pin") - slope
            if case.bends:
                out["eye"] = q[first["rod"] + 3 :][: self.of["rod"].size - 3]
            out["pin_angle"] = q[first["pin"] + 2] - roll
        else:
            vectors["pin_force"] = -multiplier("boss") - slope
        if case.crank:
            vectors["big_end_displacement"] = R.T @ (place("crank", CRANK_PIN) - place("rod"))
            vectors["main_bearing_displacement"] = R.T @ (place("crank") - place("block"))
            vectors["big_end_force"] = -on("big_end", "crank") - slope
            vectors["main_bearing_force"] = slope - on("main_bearing", "crank")
        else:
            vectors["main_bearing_force"] = slope - multiplier("main_bearing")
        for name, (x, y) in vectors.items():
            out |= {f"{name}_x": x, f"{name}_y": y}
        return out


DEGREE = np.pi / 180 / SPEED
SPAN = 12
"""Length of the runs [deg]."""

CASES = {
    "tied": Case(),
    "tied, block": Case(block_modes=True),
    "tied, block, moving": Case(block_modes=True, moves=True),
    "floating": Case(floats=True),
    "floating, crank": Case(floats=True, crank=True),
    "floating, crank, bending": Case(floats=True, crank=True, bends=True),
    "floating, crank, block, moving": Case(True, True, False, True, True),
    "all": Case(True, True, True, True, True),
}
QUICK = "tied, block, moving", "floating, crank, bending", "all"
"""Cases that contain the parts of all others."""


def by_steps(case, per_degree):
    """Return outputs of the FMU's model every degree, with so many equal steps in one."""
    way = stepped(case, DEGREE / per_degree, SPAN * DEGREE)
    return way[::per_degree]


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=() if one in QUICK else pytest.mark.slow) for one in CASES],
)
def test_motion_and_forces_are_those_of_a_multibody_program(name):
    """All outputs agree to 1e-3 of their range, and the error falls with the square of the step.

    Without the error of the step, 1e-4 of each range is left at most. It is the next order of the
    step: the light pin turns by 0.08 rad a step on its springs, 9 rad in the run. With `all`, half
    of it is the rotation of the block, in whose axes the shapes of the pin have no Coriolis force.
    """
    case = CASES[name]
    reference = Reference(case)
    times = np.arange(SPAN + 1) * DEGREE
    way = reference.system.run(*reference.start(), times)
    known = [reference.outputs(*one) for one in zip(times, *way)]
    steps = 10, 20
    coarse, fine = (by_steps(case, n) for n in steps)
    for output in known[0]:
        exact, first, second = (
            np.array([out[output] for out in run]) for run in (known, coarse, fine)
        )
        size = np.ptp(exact)
        errors = [np.abs(one - exact).max() / size for one in (first, second)]
        left = np.abs((4 * second - first) / 3 - exact).max() / size
        print(f"{name}: {output} {size:.3g}: {errors[0]:.2e} {errors[1]:.2e} {left:.2e}")
        assert errors[1] < 1e-3, output
        assert left < 1e-4, output
        assert name == "all" or errors[0] / errors[1] == pytest.approx(4.0, rel=0.1), output
