"""Transient film of a skirt on a prescribed path, shared by verification, tests and benchmarks."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from piston_cosim.fmu_ehd.common.grid import Array, Flags
from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.fmu_ehd.state import Memory

DEGREE = 1.0 / 50.0 / 360.0  # one degree at 3000 rpm [s]
UNEVEN = 0.7 * DEGREE  # a step of another length than those before it [s]
FORCES = ("nodal_pressure_force", "nodal_friction_force", "nodal_circumferential_force")


class SkirtMotion(NamedTuple):
    """Film thickness [m] and sliding velocity [m/s], or their changes.

    Each is an ndarray of shape (n_c, n_a).
    """

    film_thickness: Array
    sliding_velocity: Array


class MotoredRun(NamedTuple):
    """Model and state after a run, and the outputs of each step."""

    model: LubricationModel
    state: Memory
    history: list[dict[str, Any]]


def motored_film(shape: tuple[int, int], time: float) -> SkirtMotion:
    """Return the motion of a skirt that shifts and tilts in its bore at 3000 rpm.

    The film ruptures and reforms, and the sliding reverses.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    time : float
        [s].
    """
    n_c, n_a = shape
    angle = np.arange(n_c) * 2.0 * np.pi / n_c
    y = (np.arange(n_a) + 0.5) / n_a - 0.5
    shift = 8e-6 * np.sin(2.0 * np.pi * 25.0 * time) + 3e-6 * np.sin(2.0 * np.pi * 75.0 * time)
    tilt = 6e-6 * np.sin(2.0 * np.pi * 50.0 * time + 1.0)
    film = 15e-6 - (shift + tilt * y) * np.sin(angle)[:, None] + 10e-6 * (2.0 * y) ** 4
    velocity = 8.0 * np.sin(2.0 * np.pi * 50.0 * time + 0.1)
    return SkirtMotion(film, np.full(shape, velocity))


class FilmRun(NamedTuple):
    """Model, state and outputs after the last step."""

    model: LubricationModel
    state: Memory
    outputs: dict[str, Any]


def film_after(
    parameters: Parameters,
    films: Iterable[Array | float],
    velocity: Array | float = 0.0,
    step: float = 1e-4,
    turning: Array | float = 0.0,
    **conditions: Any,
) -> FilmRun:
    """Run a film between surfaces with constant velocities.

    Parameters
    ----------
    parameters : Parameters
    films : iterable of float or ndarray
        Film thickness at the start and at the end of each step [m].
    velocity, turning : float or ndarray
        Axial and circumferential velocity [m/s].
    step : float
        Length of a step [s].
    **conditions
        As for `LubricationModel.advance`.
    """
    model = LubricationModel(parameters)

    def field(values: Array | float) -> Array:
        return np.array(np.broadcast_to(values, parameters.shape), dtype=float)

    first, *others = map(field, films)
    state, outputs = model.start(first, field(velocity), field(turning), **conditions)
    for film in others:
        state, outputs = model.advance(
            state, film, field(velocity), step, field(turning), **conditions
        )
    return FilmRun(model, state, outputs)


def motored(parameters: Parameters, steps: int) -> MotoredRun:
    """Run the first `steps` degrees of the motored skirt."""
    return motored_until(parameters, np.arange(1, steps + 1) * DEGREE)


def motored_until(
    parameters: Parameters,
    ends: Iterable[float],
    motion: Callable[[tuple[int, int], float], Sequence[Array]] = motored_film,
) -> MotoredRun:
    """Run the motored skirt with steps that end at the times `ends` [s].

    `motion` replaces the motion of the surfaces.
    """
    model = LubricationModel(parameters)
    state, _ = model.start(*motion(parameters.shape, 0.0))
    history = []
    last = 0.0
    for end in ends:
        film, sliding, *turning = motion(parameters.shape, end)
        state, outputs = model.advance(state, film, sliding, end - last, *turning)
        history.append(outputs)
        last = end
    return MotoredRun(model, state, history)


def _central_difference(model, state, inputs, change, step) -> list[Array] | None:
    """Central difference of the nodal forces along a change of the inputs at the end of a step.

    None if a cell switches between full and cavitated meanwhile: there is no derivative then.
    """
    size = 1e-5
    ends = []
    for by in (size, -size):
        film, sliding, *turning = (one + by * moved for one, moved in zip(inputs, change))
        ends.append(model.advance(state, film, sliding, step, *turning))
    (ahead_state, ahead), (behind_state, behind) = ends
    if not np.array_equal(ahead_state.film.unknown > 0.0, behind_state.film.unknown > 0.0):
        return None
    return [(ahead[name] - behind[name]) / (2.0 * size) for name, _ in zip(FORCES, inputs)]


def tangent_error(
    model: LubricationModel,
    state: Memory,
    inputs: Sequence[Array],
    step: float = UNEVEN,
    directions: int = 3,
) -> float:
    """Return the largest difference of tangent and central difference.

    It is relative to the largest entry, over directions without switching.

    Parameters
    ----------
    model : LubricationModel
    state : Memory
        At the beginning of a step.
    inputs : sequence of ndarray
        Film thickness, sliding velocity and, of a bearing, circumferential velocity at its end.
    step : float
        Its length [s].
    directions : int
        Number of directions.
    """
    rng = np.random.default_rng(0)
    worst = 0.0
    for _ in range(100):
        change = [
            size * rng.standard_normal(model.parameters.shape)
            for size, _ in zip((1e-6, 1.0, 1.0), inputs)
        ]
        difference = _central_difference(model, state, inputs, change, step)
        if difference is None:
            continue
        directions -= 1
        film, sliding, *turning = inputs
        model.advance(state, film, sliding, step, *turning)
        for tangent, reference in zip(model.tangent(*change), difference):
            largest = max(np.abs(reference).max(), np.finfo(float).tiny)
            worst = np.maximum(worst, np.abs(tangent - reference).max() / largest)  # keeps a NaN
        if directions == 0:
            return worst
    raise RuntimeError("too few directions without switching")


def motored_tangent_error(parameters: Parameters) -> float:
    """`tangent_error` of the motored skirt after 100 degrees."""
    model, state, _ = motored(parameters, 100)
    return tangent_error(model, state, motored_film(parameters.shape, 100 * DEGREE + UNEVEN))


def opening(shape: tuple[int, int]) -> Flags:
    """Cut-outs for the pin on both sides of a skirt grid."""
    n_c, n_a = shape
    cells = np.zeros(shape, dtype=bool)
    half = n_c // 2
    lowest = n_a // 3
    highest = n_a - n_a // 5
    cells[0, lowest:highest] = True
    cells[half, lowest:highest] = True
    cells[half + 1, lowest + 1 : highest - 1] = True
    return cells


def physics(shape: tuple[int, int]) -> dict[str, dict[str, Any]]:
    """Every choice of physics once, as changes of the default parameters, by name."""
    return {
        "contact": dict(roughness_rms=3e-6),
        "power fit": dict(roughness_rms=3e-6, contact_law="power_fit", boundary_shear_strength=2e6),
        "starved": dict(film_fraction_lower_edge=0.8, film_fraction_upper_edge=0.8),
        "edge pressure": dict(pressure_upper_edge=2e5, cavitation_pressure=-5e4),
        "reynolds": dict(cavitation_model="reynolds"),
        "gumbel": dict(cavitation_model="gumbel"),
        "full film": dict(cavitation_model="full_film"),
        "full cavity shear": dict(cavity_shear="full_film"),
        "axial temperature": dict(oil=Oil("vogel_1921"), oil_temperature_upper_edge=420.0),
        "barus": dict(oil=Oil(pressure_viscosity_law="barus_1893"), pressure_upper_edge=1e5),
        "roelands": dict(oil=Oil(pressure_viscosity_law="roelands_1966"), pressure_upper_edge=1e5),
        "cross": dict(oil=Oil(shear_thinning_law="cross_1965")),
        "carreau": dict(oil=Oil(shear_thinning_law="carreau_1972", shear_thinning_exponent=0.6)),
        "flow factors": dict(
            roughness_rms=2e-6, flow_factors="patir_cheng_1978", roughness_share_skirt=1.0
        ),
        "oblong roughness": dict(
            roughness_rms=3e-6,
            flow_factors="patir_cheng_1978",
            peklenik_number_skirt=4.0,
            peklenik_number_bore=0.3,
            roughness_share_skirt=0.1,
        ),
        "cut-out": dict(open_cells=opening(shape)),
        "fed cut-out": dict(open_cells=opening(shape), opening_supply="own", pressure_openings=3e5),
        "coating": dict(coating_thickness=2e-5, coating_modulus=1e9, roughness_rms=3e-6),
        "coating and roelands": dict(
            coating_thickness=2e-5, oil=Oil(pressure_viscosity_law="roelands_1966")
        ),
        "everything": dict(
            oil=Oil("vogel_1921", "roelands_1966", "cross_1965"),
            roughness_rms=3e-6,
            peklenik_number_skirt=0.2,
            flow_factors="patir_cheng_1978",
            film_fraction_lower_edge=0.7,
            open_cells=opening(shape),
            coating_thickness=1e-5,
        ),
    }
