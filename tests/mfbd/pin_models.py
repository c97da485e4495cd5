"""Models for the tests of a floating pin.

There are rigid and elastic bodies, a pin that bends and films of the crank. Helpers apply rough
inputs and replace films by springs.
"""

import dataclasses

import numpy as np

from piston_cosim.fmu_mfbd.dynamics.assembly import (
    ReducedBodies,
    model_of,
)
from piston_cosim.fmu_mfbd.dynamics.build_options import (
    BlockOptions,
    BoreGrid,
    BuildOptions,
    CrankBearing,
    FloatingPin,
    PistonOptions,
)
from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import (
    AxisParameters,
    BigEndParameters,
    MainBearingParameters,
    Parameters,
    PinParameters,
)
from piston_cosim.fmu_mfbd.dynamics.pin_shells import shell_of
from piston_cosim.fmu_mfbd.dynamics.system import RingForce
from piston_cosim.fmu_mfbd.geometry.pin import PinForces, shell_angles
from piston_cosim.fmu_mfbd.geometry.pin_shapes import HollowPin
from piston_cosim.fmu_mfbd.mechanism.motion import chain_motion
from piston_cosim.fmu_mfbd.reduction.reduced_body import (
    ReducedBlock,
    ReducedBosses,
    ReducedPiston,
    ReducedShell,
    no_modes,
    no_modes_in_motion,
)

GRID = (16, 12)
PIN_GRID = (24, 4)
SPEED = 176.0
STEP = np.pi / 180 / SPEED
PARAMETERS = Parameters(
    radial_clearance=50e-6,
    barrel=40e-6,
    ovality=200e-6,
    crank_radius=72e-3,
    rod_length=223e-3,
    crank_offset=2e-3,
    rod_mass=1.7,
    rod_inertia=0.017,
    rod_centre=72e-3,
    pin_mass=0.5,
    pin_radius=18e-3,
    pin_friction_coefficient=0.0,
)
OFFSET = 1e-3
"""Of the pin from the skirt's axis."""
CENTRE = np.array([1.5e-3, 26.5e-3])
CRITICAL = dataclasses.replace(PARAMETERS, damping_ratio=1.0, high_frequency_damping_ratio=1.0)


def bodies():
    """Return the rigid piston of data_sheet in its bore, with its centre of mass off its axis."""
    piston = ReducedPiston(
        mass=1.39,
        S=1.39 * CENTRE,
        I0=0.003 + 1.39 * float(CENTRE @ CENTRE),
        radius=54.95e-3,
        skirt_lower=-45.5e-3,
        skirt_upper=37.3e-3,
        pin_offset=0.0,
        **no_modes_in_motion(GRID[0] * GRID[1]),
    )
    heights = np.linspace(90e-3, 360e-3, 64)
    block = ReducedBlock(heights=heights, radius=55e-3, **no_modes(GRID[0], len(heights)))
    return ReducedBodies(piston, block)


def options(floating):
    return BuildOptions(
        GRID,
        PistonOptions("", 0, OFFSET),
        BlockOptions("", 0),
        floating_pin=FloatingPin(PIN_GRID, 25e-3, 36e-3) if floating else None,
    )


def floating_model(parameters=PARAMETERS, **pin):
    own = [PinParameters(**pin)]
    return model_of(bodies(), options(True), parameters, own)


MODES = 3
"""Of the piston."""


def yielding_bodies(young=1.0):
    """Return the bodies with three modes, `young` times as stiff.

    No two classes of their matrices are alike. The modes also have values in the bosses.
    """
    rng = np.random.default_rng(7)
    piston, block, *_ = bodies()
    cells = GRID[0] * GRID[1]
    half = rng.standard_normal((2, MODES, MODES))
    piston = dataclasses.replace(
        piston,
        T=0.2 * rng.standard_normal((2, MODES)),
        b=5e-3 * rng.standard_normal(MODES),
        B=0.3 * (half[0] + half[0].T) + np.eye(MODES),
        g=5e-3 * rng.standard_normal(MODES),
        G=0.2 * (half[1] - half[1].T),
        omega=np.sqrt(young) * np.array([2.1e4, 3.3e4, 9e4]),
        kind=np.full(MODES, -1),
        gas_force=rng.standard_normal(MODES),
        radial=rng.standard_normal((cells, MODES)),
        axial=0.3 * rng.standard_normal((cells, MODES)),
    )
    a = shell_angles(PIN_GRID[0])
    wave = np.array([np.cos(n * a + p) for n, p in ((2, 0.3), (1, 1.1), (3, -0.4))]).T
    along = 1 + 0.2 * rng.standard_normal((2, PIN_GRID[1], MODES))
    outward = wave[None, :, None, :] * along[:, None]
    onward = 0.4 * np.roll(outward, 3, axis=1)
    stations = np.array([[-1.0], [1.0]]) * np.linspace(0.03, 0.05, PIN_GRID[1])
    return ReducedBodies(piston, block, ReducedBosses(outward, onward, stations, 18e-3))


BLOCK_MODES = 4


def flexible_block(young=1.0):
    """Return a block with four modes of no symmetry, `young` times as stiff."""
    rng = np.random.default_rng(5)
    heights = np.linspace(90e-3, 360e-3, 64)
    a = shell_angles(GRID[0])
    wave = np.array([np.cos(n * a + p) for n, p in ((2, 0.7), (1, -0.5), (3, 0.1), (0, 0))]).T
    along = np.array([1 + 0.4 * np.sin(20 * heights + p) for p in rng.random(BLOCK_MODES)]).T
    radial = 0.5 * wave[:, None] * along
    return ReducedBlock(
        omega=np.sqrt(young) * np.array([1.3e4, 2.2e4, 4.1e4, 8e4]),
        kind=np.full(BLOCK_MODES, -1),
        radial=radial,
        axial=0.2 * np.roll(radial, 3, axis=0),
        heights=heights,
        radius=55e-3,
    )


RINGS = dict(top_ring_height=60e-3, second_ring_height=50e-3, land_pressure_share=0.3)
"""Gas on the bore."""


def block_model(young=1.0, parameters=PARAMETERS):
    """Return a model of a rigid piston and a floating pin in a flexible block."""
    reduced = bodies()._replace(block=flexible_block(young))
    parameters = dataclasses.replace(parameters, **RINGS)
    return model_of(reduced, options(True), parameters, [PinParameters()])


def yielding_model(young=1.0, parameters=PARAMETERS):
    own = [PinParameters()]
    return model_of(yielding_bodies(young), options(True), parameters, own)


# ---- a pin that tilts and bends

STEEL = {"young": 206e9, "poisson": 0.3}
PIN = HollowPin(mass=0.5, length=86e-3, radius=18e-3, bore_radius=9.4e-3, **STEEL)
"""Of data_sheet, with the bore that leaves its mass to steel."""
AXIS = AxisParameters(pin_bore_radius=PIN.bore_radius)


def bending_options(shapes):
    plain = options(True)
    assert plain.floating_pin
    pin = dataclasses.replace(plain.floating_pin, pin_shapes=shapes)
    return dataclasses.replace(plain, floating_pin=pin)


def bending_model(shapes=4, parameters=PARAMETERS, **axis):
    own = [PinParameters(), dataclasses.replace(AXIS, **axis)]
    return model_of(bodies(), bending_options(shapes), parameters, own)


def bending_in_bosses(parameters=PARAMETERS, **shells):
    """Return a model of a bending pin in elastic bosses."""
    own = [PinParameters(), AXIS]
    yielding = yielding_bodies()._replace(shells=shells)
    return model_of(yielding, bending_options(3), parameters, own)


# ---- an eye that yields

SHELL_MODES = 4


def small_end(young=1.0, grid=PIN_GRID, radius=18e-3):
    """Four modes of no symmetry, `young` times as stiff."""
    rng = np.random.default_rng(11)
    a = shell_angles(grid[0])
    wave = np.array([np.cos(n * a + p) for n, p in ((2, 0.5), (1, -0.8), (3, 0.2), (0, 0))]).T
    along = 1 + 0.2 * rng.standard_normal((grid[1], SHELL_MODES))
    outward = wave[:, None] * along
    omega = np.sqrt(young) * np.array([1.7e4, 2.6e4, 4e4, 9e4])
    return ReducedShell(omega, outward, 0.3 * np.roll(outward, 2, axis=0), radius)


def eye_model(young=1.0, parameters=PARAMETERS):
    """Return a model of a rigid piston and pin with an elastic eye."""
    yielding = bodies()._replace(shells={"small_end": small_end(young)})
    return model_of(yielding, options(True), parameters, [PinParameters()])


def all_that_yields(parameters=PARAMETERS):
    """Return a model of a bending pin in elastic bosses and an elastic eye."""
    return bending_in_bosses(parameters, small_end=small_end())


# ---- films of the crank

BIG_END = BigEndParameters(big_end_radius=24e-3, big_end_clearance=25e-6)
MAIN = MainBearingParameters(
    main_bearing_radius=27e-3, main_bearing_clearance=30e-6, crank_mass=4.0
)
OWN = {"big_end": BIG_END, "main_bearing": MAIN}
RADII = {"big_end": 24e-3, "main_bearing": 27e-3}
GRIDS = {"big_end": (20, 5), "main_bearing": (16, 4)}
UNBALANCE = -0.12
SETS = [("big_end",), ("main_bearing",), ("big_end", "main_bearing")]


def crank_options(names, modes=0):
    bearings = tuple(CrankBearing(name, GRIDS[name], 30e-3, modes=modes) for name in names)
    return dataclasses.replace(options(True), crank_bearings=bearings)


def crank_model(names=SETS[-1], yielding=False, young=1.0, shapes=0, **changes):
    """Return a model with films of the crank; with shapes of the pin also in a flexible block."""
    parameters = dataclasses.replace(PARAMETERS, crank_unbalance=UNBALANCE, **changes)
    reduced = bodies()
    if yielding:
        shells = {name: small_end(young, GRIDS[name], RADII[name]) for name in names}
        reduced = yielding_bodies()._replace(shells={"small_end": small_end()} | shells)
    own = [PinParameters(), *[AXIS] * bool(shapes), *(OWN[name] for name in names)]
    built = crank_options(names, SHELL_MODES if yielding else 0)
    if shapes:
        reduced = reduced._replace(block=flexible_block())
        bent = dataclasses.replace(built.floating_pin, pin_shapes=shapes)
        built = dataclasses.replace(built, floating_pin=bent)
    return model_of(reduced, built, parameters, own)


def tied_crank_model(names=SETS[-1], yielding=False, parameters=PARAMETERS):
    """Return a model with a tied pin and films of the crank, if it yields in a flexible block."""
    parameters = dataclasses.replace(parameters, crank_unbalance=UNBALANCE)
    reduced, built = bodies(), options(False)
    if yielding:
        piston, *_ = yielding_bodies()
        shells = {name: small_end(1.0, GRIDS[name], RADII[name]) for name in names}
        reduced = ReducedBodies(piston, flexible_block(), None, shells)
    modes = SHELL_MODES if yielding else 0
    bearings = tuple(CrankBearing(name, GRIDS[name], 30e-3, modes=modes) for name in names)
    built = dataclasses.replace(built, crank_bearings=bearings)
    own = [OWN[name] for name in names]
    return model_of(reduced, built, parameters, own)


def outside_model(parameters=PARAMETERS, elements=()):
    """Return a model of a floating pin in a mounted block whose bore deflects from outside.

    `elements` are parameters of force elements.
    """
    block = BlockOptions("", 0, bore_from_outside=BoreGrid(24, 64))
    built = dataclasses.replace(options(True), block=block, mounted=True)
    parameters = dataclasses.replace(parameters, **RINGS)
    own = [PinParameters(), *elements]
    return model_of(bodies(), built, parameters, own)


RUBBING = dataclasses.replace(PARAMETERS, pin_friction_coefficient=0.05)

MODELS = {
    "rigid": floating_model,
    "bosses": yielding_model,
    "bending": bending_model,
    "bending in bosses": bending_in_bosses,
    "eye": eye_model,
    "bending, bosses, eye": all_that_yields,
    "block": block_model,
    "all flexible": lambda: crank_model(yielding=True, shapes=3),
    "tied": tied_crank_model,
    "tied, rubbing, all flexible": lambda: tied_crank_model(yielding=True, parameters=RUBBING),
    "static": lambda: crank_model(yielding=True, shapes=3, quasi_static_frequency=4e3),
} | {
    "+".join(names) + " that yield" * yielding: lambda n=names, y=yielding: crank_model(n, y)
    for names in SETS
    for yielding in (False, True)
}
"""Makers of all models with a floating pin."""


# ---- their steps


def shells_of(model):
    """Return the shells of all films of pin and crank at the end of the last step."""
    last, chain = model._last, model.chain
    at = chain_motion(chain.joints, last.now, last.crank)
    return [shell_of(chain.elements, at, last.now, e) for e in range(len(model.pins))]


def rough_inputs(model, seed, size=50.0, speed=SPEED, gas=5e5):
    """Rough forces on all films, those of pin and crank ten times as large."""
    rng = np.random.default_rng(seed)
    push, drag = size * rng.random(GRID), -0.1 * size * rng.random(GRID)
    pins = tuple(
        PinForces(10 * size * rng.random(one.shape), size * rng.random(one.shape))
        for one in model.grids
    )
    bore = np.zeros((0, 0))
    if model.outside:
        bore = np.zeros((model.outside.around.shape[1], model.outside.along.shape[1]))
    rings = RingForce(40.0, -60.0, 0.3)
    return Inputs(speed, gas, push, drag, rings, pins=pins, bore_deflection=bore)


def rough_way(model, steps):
    """State and outputs after some steps under rough forces, from a small motion on."""
    state, out = model.start(0.3, 2e-6, 1e-4, rough_inputs(model, 0, 0.0))
    for k in range(steps):
        state, out = model.advance(state, rough_inputs(model, k), STEP)
    return state, out


class Springs:
    """A model on even springs in place of its films: F = -K d in every shell, and on the skirt.

    Each step is solved by Newton's method on the model's own derivative, in the directions of
    forces on which gaps depend: two of the skirt, two of every shell, or of each of its rows.

    model : PistonInBore of a tied or a floating pin; stiffness : K of each shell, or of all [N/m].
    """

    def __init__(self, model, stiffness=(), skirt=5e7, by_row=False):
        self.model = model
        self.grids = (*model.films, *model.grids)
        sizes = [np.prod(one.shape) for one in self.grids]
        of_shells = 2 * np.broadcast_to(stiffness, len(model.grids))
        self.per_cell = np.repeat(np.array([skirt, *of_shells]) / sizes, sizes)
        self.ends = np.cumsum(sizes)[:-1]
        even = [np.zeros(grid.shape) + pin.clearance for grid, pin in zip(model.grids, model.pins)]
        self.even = np.concatenate([np.full(sizes[0], 1e-4), *map(np.ravel, even)])
        self.seeds = []
        side = model.film_surfaces[0].skirt
        sine = np.sin(side.angle)[:, None] * np.ones(GRID)
        self._direct(0, sine, sine * side.height)
        for k, (grid, pin) in enumerate(zip(model.grids, model.pins), 1):
            _, along = grid.shape
            for row in np.eye(along) if by_row else np.ones((1, along)):
                self._direct(k, *(np.outer(axis, row) for axis in pin.outward))
        self.forces = np.zeros(len(self.per_cell))

    def _direct(self, film, *fields):
        """Add directions of forces on a film."""
        for field in fields:
            seed = np.zeros(len(self.per_cell))
            np.split(seed, self.ends)[film][:] = field.ravel()
            self.seeds.append(seed)

    def inputs(self, forces, gas=0.0, speed=0.0):
        """Return the model's inputs with forces on all cells, those of the skirt first."""
        push, *pins = (
            part.reshape(one.shape)
            for part, one in zip(np.split(forces, self.ends), self.grids, strict=True)
        )
        films = tuple(PinForces(one, 0 * one) for one in pins)
        return Inputs(speed, gas, push, 0 * push, pins=films)

    def gaps(self, out):
        """Film thickness of all cells, or its changes."""
        return np.concatenate([out[f"{one.prefix}film_thickness"].ravel() for one in self.grids])

    def lacks(self):
        """Return the imbalance of the springs for each direction, as columns."""
        columns = []
        for seed in self.seeds:
            given = self.inputs(seed)
            push, pins = given.pressure_force, given.pins
            got = self.model.directional_derivative(push, 0 * push, pins=pins)
            columns.append(seed + self.per_cell * self.gaps(got))
        return np.array(columns).T

    def run(self, steps, gas=6e5, speed=SPEED, start=(0.3, 2e-6, 1e-4), step=STEP):
        """Return the outputs of every step; `forces` are those at its end."""
        state, _ = self.model.start(*start, self.inputs(self.forces, gas, speed))
        way = []
        for _ in range(steps):
            for _ in range(12):
                end, out = self.model.advance(state, self.inputs(self.forces, gas, speed), step)
                lack = self.per_cell * (self.even - self.gaps(out)) - self.forces
                if np.abs(lack).max() <= 1e-9 * np.abs(self.forces).max():
                    break
                matrix = self.lacks()
                amounts, *_ = np.linalg.lstsq(matrix, lack, rcond=None)
                # what of the lack no gap depends on is taken as it is
                self.forces = self.forces + amounts @ self.seeds + (lack - matrix @ amounts)
            state = end
            way.append(out)
        return way
