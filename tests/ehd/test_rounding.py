"""Rounded cavitation, Eq. (C6): the film is a smooth function of its inputs."""

import numpy as np
import pytest

from piston_cosim.fmu_ehd.laws.cavitation import VOID_PRESSURE
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters, faults

SHAPE = (12, 30)
LENGTH = 27e-3
STEPS = 60
STEP = 1e-2 / STEPS
AROUND = 2.0 * np.pi * np.arange(SHAPE[0])[:, None] / SHAPE[0]
ALONG = ((np.arange(SHAPE[1]) + 0.5) / SHAPE[1] - 0.5) * LENGTH
THINNEST = 4.5e-6
ROUNDING = 9.0
STARVED = dict(film_fraction_lower_edge=0.5, film_fraction_upper_edge=0.5)
ON_BORE = dict(
    oil_supply="bore_and_ring",
    stroke=60e-3,
    initial_oil_layer=8e-6,
    oil_ring_layer=5e-6,
    initial_film_fraction=0.3,
)
WINDOW = np.zeros(SHAPE, dtype=bool)
WINDOW[2:4, 10:14] = True


def motion(k, profile=0.0, rocking=0.0):
    """Return film thickness and sliding velocity of a rocking skirt after k steps."""
    phase = 2.0 * np.pi * k / STEPS
    tilt = 1.2e-4 * np.cos(phase + 0.4) + rocking / LENGTH * np.cos(phase + 1.0)
    lateral = (7.5e-6 * np.sin(phase) + tilt * ALONG) * np.cos(AROUND)
    film = 12e-6 + 12e-6 * (2.0 * ALONG / LENGTH) ** 2 + lateral + profile
    return film, np.full(SHAPE, -15.7 * np.sin(phase))


def revolution(steps=STEPS, profile=0.0, rocking=0.0, **options):
    """Return the model, its state and the outputs of each step."""
    options = dict(skirt_length=LENGTH, bore_radius=30e-3, cavitation_rounding=ROUNDING) | options
    model = LubricationModel(Parameters(SHAPE, **options))
    state, _ = model.start(*motion(0, profile, rocking))
    history = []
    for k in range(1, steps + 1):
        state, outputs = model.advance(state, *motion(k, profile, rocking), STEP)
        history.append(outputs)
    return model, state, history


def forces(profile, rocking, **options):
    """Return load, side force, moment and friction of each step of a revolution."""
    _, _, history = revolution(profile=profile, rocking=rocking, **options)
    normal = np.array([o["nodal_pressure_force"] for o in history])
    side = normal * np.cos(AROUND)
    friction = np.array([o["nodal_friction_force"] for o in history])
    return np.array([each.sum((1, 2)) for each in (normal, side, side * ALONG, friction)])


def distances(**options):
    """Return the distances of central differences from those of a tenth of their size.

    A thousandth and a ten thousandth of the thinnest film are the larger sizes. A distance is the
    largest rms of one of `forces`, relative to that of the difference.
    """
    random = np.random.default_rng(4)
    direction, rocking = random.standard_normal(SHAPE), random.standard_normal()
    sizes = THINNEST * np.array([1e-3, 1e-4, 1e-5])
    ends = [[forces(s * e * direction, s * e * rocking, **options) for s in (1, -1)] for e in sizes]
    slopes = [(up - down) / (2.0 * e) for (up, down), e in zip(ends, sizes)]
    pairs = zip(slopes, slopes[1:])
    rms = [np.sqrt(((a - b) ** 2).mean(1) / (b**2).mean(1)).max() for a, b in pairs]
    return np.array(rms)


@pytest.mark.parametrize("options", [{}, STARVED, ON_BORE, dict(roughness_rms=2e-6)])
def test_differences_of_a_revolution_converge(options):
    """Distances of a smooth function fall by 100 for a tenth of the size, those of kinks do not."""
    rounded = distances(**options)
    assert rounded[1] <= 1e-4
    assert 50.0 <= rounded[0] / rounded[1] <= 150.0
    assert distances(**options, cavitation_rounding=0.0)[1] >= 10.0 * rounded[1]


@pytest.mark.parametrize("options", [STARVED, STARVED | dict(open_cells=WINDOW)])
def test_cavities_hold_a_gas(options):
    _, state, history = revolution(**options)
    product = (history[-1]["pressure"] + ROUNDING) * (1.0 - history[-1]["film_fraction"])
    cut_out = options.get("open_cells", np.zeros(SHAPE, dtype=bool))
    # the film fraction of a full cell has a round-off of 1e-16, at 1 MPa 1e-10 Pa
    assert np.allclose(product[~cut_out], ROUNDING, rtol=1e-9)
    assert 0.1 < (state.film.unknown > 0.0).mean() < 0.9  # both kinds of cells are there
    assert max(o["mass_imbalance"] for o in history) <= 1e-13


def test_the_sharp_film_is_the_limit():
    """The film at the boundary of the full zone differs by the root of the rounding."""
    found = []
    for rounding in (1.0, 1e-2, 1e-4, 0.0):
        _, _, history = revolution(1, **STARVED, cavitation_rounding=rounding)
        found.append(history[0]["pressure"])
    off = [np.abs(p - found[-1]).max() for p in found[:-1]]
    assert off[0] <= 3.0 * np.sqrt(VOID_PRESSURE)
    assert off[1] <= 0.2 * off[0]
    assert off[2] <= 0.2 * off[1]


def test_the_tangent_is_exact():
    model, state, _ = revolution(20, **STARVED)
    film, velocity = motion(21)
    random = np.random.default_rng(1)
    dfilm, dvelocity = random.standard_normal(SHAPE), random.standard_normal(SHAPE)
    e = 1e-10
    ends = []
    for size in (e, -e):
        _, outputs = model.advance(state, film + size * dfilm, velocity + size * dvelocity, STEP)
        ends.append([outputs[f"nodal_{name}_force"] for name in ("pressure", "friction")])
    model.advance(state, film, velocity, STEP)
    for up, down, change in zip(*ends, model.tangent(dfilm, dvelocity)):
        # truncation: the square of 1e-10 m over some um of film, and round-off
        assert np.allclose((up - down) / (2.0 * e), change, rtol=0.0, atol=1e-6 * np.ptp(change))


def test_random_films_converge():
    random = np.random.default_rng(2)
    model = LubricationModel(Parameters(SHAPE, **STARVED, cavitation_rounding=100.0))
    for _ in range(20):
        film = 10.0 ** random.uniform(-6, -4.5) * (1.0 + 5.0 * random.random(SHAPE))
        state, _ = model.start(film, np.zeros(SHAPE))
        for _ in range(5):
            film = film * (0.9 + 0.2 * random.random(SHAPE))
            velocity = np.full(SHAPE, 10.0 * random.standard_normal())
            state, outputs = model.advance(state, film, velocity, 10.0 ** random.uniform(-6, 0))
            assert outputs["mass_imbalance"] <= 1e-12
            assert -1e-12 <= outputs["film_fraction"].min()
            assert outputs["film_fraction"].max() < 1.0


@pytest.mark.parametrize("options", [dict(cavitation_model="gumbel"), dict(coating_thickness=1e-5)])
def test_only_hard_films_that_conserve_oil_are_rounded(options):
    (fault,) = faults(Parameters(SHAPE, cavitation_rounding=1.0, **options))
    assert fault.startswith("cavitation_rounding: expected 0 Pa")
