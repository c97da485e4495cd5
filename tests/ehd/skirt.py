"""A motored skirt for the tests: films with rupture, reformation and reversal of sliding."""

import numpy as np

from fmu_ehd.model import LubricationModel, Parameters

STEP = 1.0 / 50.0 / 360.0  # one degree at 3000 rpm [s]


def motored(shape, time):
    """Film thickness [m] and sliding velocity [m/s] at a time, both smooth."""
    angle = np.arange(shape[0]) * 2.0 * np.pi / shape[0]
    y = (np.arange(shape[1]) + 0.5) / shape[1] - 0.5
    shift = 8e-6 * np.sin(2.0 * np.pi * 25.0 * time) + 3e-6 * np.sin(2.0 * np.pi * 75.0 * time)
    tilt = 6e-6 * np.sin(2.0 * np.pi * 50.0 * time + 1.0)
    film = 15e-6 - (shift + tilt * y) * np.sin(angle)[:, None] + 10e-6 * (2.0 * y) ** 4
    return film, np.full(shape, 8.0 * np.sin(2.0 * np.pi * 50.0 * time + 0.1))


def run(parameters, steps):
    """Model, state and outputs after `steps` degrees, with the outputs of every step."""
    model = LubricationModel(parameters)
    state, outputs = model.start(*motored(parameters.shape, 0.0))
    history = []
    for k in range(1, steps + 1):
        state, outputs = model.advance(state, *motored(parameters.shape, k * STEP), STEP)
        history.append(outputs)
    return model, state, history


def central_difference(model, state, film, velocity, dfilm, dvelocity, step=STEP, size=1e-5):
    """Central difference of both force fields along (dfilm, dvelocity); None if a cell switches meanwhile."""
    forward = model.advance(state, film + size * dfilm, velocity + size * dvelocity, step)
    backward = model.advance(state, film - size * dfilm, velocity - size * dvelocity, step)
    if not np.array_equal(forward[0].unknown > 0.0, backward[0].unknown > 0.0):
        return None
    return [(forward[1][name] - backward[1][name]) / (2.0 * size) for name in ("nodal_pressure_force", "nodal_friction_force")]


__all__ = ["Parameters", "STEP", "central_difference", "motored", "run"]
