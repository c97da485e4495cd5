"""A skirt that moves on a given path: the transient film that verification, tests and benchmarks
share.
"""

import numpy as np

from .model import LubricationModel
from .oil import Oil

DEGREE = 1.0 / 50.0 / 360.0  # one degree at 3000 rpm [s]
UNEVEN = 0.7 * DEGREE  # a step of another length than those before it [s]


def motored_film(shape, time):
    """A skirt that shifts and tilts in its bore at 3000 rpm, with rupture, reformation and reversal
    of sliding.

    Returns
    -------
    film_thickness, sliding_velocity : ndarray, shape (n_c, n_a)
        [m], [m/s].
    """
    angle = np.arange(shape[0]) * 2.0 * np.pi / shape[0]
    y = (np.arange(shape[1]) + 0.5) / shape[1] - 0.5
    shift = 8e-6 * np.sin(2.0 * np.pi * 25.0 * time) + 3e-6 * np.sin(2.0 * np.pi * 75.0 * time)
    tilt = 6e-6 * np.sin(2.0 * np.pi * 50.0 * time + 1.0)
    film = 15e-6 - (shift + tilt * y) * np.sin(angle)[:, None] + 10e-6 * (2.0 * y) ** 4
    return film, np.full(shape, 8.0 * np.sin(2.0 * np.pi * 50.0 * time + 0.1))


def motored(parameters, steps):
    """Model, state and outputs of each of the first `steps` degrees of the motored skirt."""
    return motored_until(parameters, np.arange(1, steps + 1) * DEGREE)


def motored_until(parameters, ends):
    """The same with steps that end at the times `ends` [s]."""
    model = LubricationModel(parameters)
    state, _ = model.start(*motored_film(parameters.shape, 0.0))
    history, last = [], 0.0
    for end in ends:
        state, outputs = model.advance(state, *motored_film(parameters.shape, end), end - last)
        history.append(outputs)
        last = end
    return model, state, history


def central_difference(model, state, inputs, change, size=1e-5):
    """Central difference of both force fields along a change of (film_thickness, sliding_velocity)
    at the end of a step.

    Returns
    -------
    list of ndarray or None
        None if a cell switches between full and cavitated meanwhile: there is no derivative then.
    """
    forward, backward = (
        model.advance(state, *(x + sign * size * dx for x, dx in zip(inputs, change)), UNEVEN)
        for sign in (1.0, -1.0)
    )
    if not np.array_equal(forward[0].unknown > 0.0, backward[0].unknown > 0.0):
        return None
    return [
        (forward[1][name] - backward[1][name]) / (2.0 * size)
        for name in ("nodal_pressure_force", "nodal_friction_force")
    ]


def tangent_error(parameters, steps=100, seed=0):
    """Largest difference of tangent and central difference, relative to the largest entry, over
    directions without switching.
    """
    model, state, _ = motored(parameters, steps)
    inputs = motored_film(parameters.shape, steps * DEGREE + UNEVEN)
    rng, worst, tried = np.random.default_rng(seed), 0.0, 0
    while tried < 3:
        change = 1e-6 * rng.standard_normal(parameters.shape), rng.standard_normal(parameters.shape)
        difference = central_difference(model, state, inputs, change)
        if difference is None:
            continue
        tried += 1
        model.advance(state, *inputs, UNEVEN)
        for tangent, reference in zip(model.tangent(*change), difference):
            worst = np.maximum(
                worst, np.abs(tangent - reference).max() / np.abs(reference).max()
            )  # keeps a NaN
    return worst


def opening(shape):
    """Cut-outs for the pin on both sides of a skirt grid."""
    cells = np.zeros(shape, dtype=bool)
    half, middle = shape[0] // 2, slice(shape[1] // 3, shape[1] - shape[1] // 5)
    cells[0, middle] = cells[half, middle] = cells[half + 1, middle.start + 1 : middle.stop - 1] = (
        True
    )
    return cells


def physics(shape):
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
            peklenik_number=4.0,
            roughness_share_skirt=0.1,
        ),
        "cut-out": dict(open_cells=opening(shape)),
        "coating": dict(coating_thickness=2e-5, coating_modulus=1e9, roughness_rms=3e-6),
        "coating and roelands": dict(
            coating_thickness=2e-5, oil=Oil(pressure_viscosity_law="roelands_1966")
        ),
        "everything": dict(
            oil=Oil("vogel_1921", "roelands_1966", "cross_1965"),
            roughness_rms=3e-6,
            peklenik_number=0.2,
            flow_factors="patir_cheng_1978",
            film_fraction_lower_edge=0.7,
            open_cells=opening(shape),
            coating_thickness=1e-5,
        ),
    }
