"""Differences: of a function, of a step in a direction, and Lagrange's equations of an energy."""

import dataclasses

import numpy as np

CHANGED = ("pressure_force", "friction_force", "rings", "pins", "carrier", "bore_deflection")
"""Inputs of a direction."""


def derivative(f, x, h):
    """Return the central difference of sixth order."""
    weights = {1: 0.75, 2: -0.15, 3: 1 / 60}
    return sum(w * (f(x + k * h) - f(x - k * h)) for k, w in weights.items()) / h


def plus(value, change, share):
    """Return a value plus a share of its change: numbers, arrays or tuples of them."""
    if isinstance(value, tuple):
        parts = [plus(*pair, share) for pair in zip(value, change, strict=True)]
        return value._make(parts) if hasattr(value, "_make") else tuple(parts)
    return value + share * change


def products_by_differences(model, state, base, change, step, within, size=1.0):
    """All products of a step's derivative with a change of the inputs, held against differences.

    `within` : of each output's largest difference; `size` of the change that differences take.
    """

    def outputs(share):
        moved = {name: plus(getattr(base, name), getattr(change, name), share) for name in CHANGED}
        return model.advance(state, dataclasses.replace(base, **moved), step)[1]

    up, down = outputs(size), outputs(-size)
    model.advance(state, base, step)
    products = model.directional_derivative(
        change.pressure_force,
        change.friction_force,
        change.rings,
        np.array(change.carrier),
        pins=change.pins,
    )
    if change.bore_deflection.size:
        for name, widened in model.widened(change.bore_deflection).items():
            products[name] = products[name] + widened
    for name, product in products.items():
        wanted = (np.asarray(up[name]) - down[name]) / (2 * size)
        bound = within * np.abs(wanted).max()
        np.testing.assert_allclose(product, wanted, rtol=0.0, atol=bound, err_msg=name)
    return products


def rough_change(model, base, seed=1):
    """Return a direction with changes of 1 N on all cells, and of the rings."""
    rng = np.random.default_rng(seed)
    push, drag = rng.standard_normal((2, *base.pressure_force.shape))
    pins = tuple(
        one._make(rng.standard_normal((2, *grid.shape)))
        for one, grid in zip(base.pins, model.grids, strict=True)
    )
    rings = base.rings._make((0.3, -0.2, 0.005))
    return dataclasses.replace(
        base,
        pressure_force=push,
        friction_force=drag,
        rings=rings,
        pins=pins,
        carrier=base.carrier._make((0.0,) * 4),
    )


def lagrange(energy, position, velocity, acceleration, scale):
    """Return d/dt dT/dvelocity - dT/dposition of a kinetic energy quadratic in the velocities.

    Differences are of fourth order; `scale` is their change of each coordinate.
    """
    position, velocity, acceleration = (
        np.asarray(one, dtype=np.longdouble) for one in (position, velocity, acceleration)
    )
    unit = np.eye(len(position))
    weights = ((1, 8 / 12), (2, -1 / 12))

    def momentum(t):
        z = position + velocity * t + acceleration * t * t / 2
        r = velocity + acceleration * t
        return np.array([(energy(z, r + 50 * u) - energy(z, r - 50 * u)) / 100 for u in unit])

    def slope(u, s):
        ends = ((w, position + k * s * u, position - k * s * u) for k, w in weights)
        return sum(w * (energy(up, velocity) - energy(down, velocity)) for w, up, down in ends) / s

    dt = 1e-5
    along = sum(w * (momentum(k * dt) - momentum(-k * dt)) for k, w in weights) / dt
    found = along - np.array([slope(u, s) for u, s in zip(unit, scale)])
    return found.astype(float)
