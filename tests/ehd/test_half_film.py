"""Half of a film that is its own mirror image equals the whole one."""

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.master.fmi.symmetry import odd_part, thrust_image

SHAPE = (12, 8)
HALF = dict(film_symmetry="thrust_plane")
ROUGH = dict(
    roughness_rms=2e-6,
    flow_factors="patir_cheng_1978",
    peklenik_number_skirt=4.0,
    roughness_share_skirt=0.2,
)
COATED = dict(coating_thickness=1e-6, coating_modulus=3e9)
STARVED = dict(
    film_fraction_lower_edge=0.3, film_fraction_upper_edge=0.6, initial_film_fraction=0.7
)
FED = dict(opening_supply="own", pressure_openings=2e5)
ON_BORE = dict(oil_supply="bore", initial_film_fraction=0.5, initial_oil_layer=3e-6)
RING = dict(
    oil_supply="bore_and_ring", initial_oil_layer=3e-6, oil_splash=1e-3, chamfer_capacity=1e-9
)
THINNED = dict(
    shear_thinning_law="carreau_1972",
    viscosity_law="vogel_1921",
    pressure_viscosity_law="roelands_1966",
    pressure_viscosity_coefficient=3e-8,
)
CASES = [
    (10e-6, dict(STARVED), {}, False),
    (6e-6, dict(cavitation_model="gumbel"), {}, False),
    (6e-6, dict(ROUGH, cavitation_model="reynolds"), {}, False),
    (6e-6, dict(cavitation_model="full_film"), {}, True),
    (30e-6, dict(FED), THINNED, True),
    (6e-6, dict(RING), {}, True),
    (8e-6, dict(ROUGH | COATED | ON_BORE), {}, True),
]
"""Mean film thickness [m], parameters, those of the oil, and whether there are cut-outs."""


def even(rng, *shape):
    """Return random fields that are their own mirror image, within -1 and 1."""
    field = rng.uniform(-1.0, 1.0, (*shape, *SHAPE))
    return field - odd_part(field, -2)


def motion(level):
    """Return film thickness, velocity and oil temperature of a start and three steps."""
    rng = np.random.default_rng(7)
    film = level * (1.0 + 0.8 * even(rng, 4))
    velocity = np.array([9.0, -4.0, -11.0, 7.0])[:, None, None] * (1.0 + 0.1 * even(rng, 4))
    return zip(film, velocity, 360.0 + 10.0 * even(rng, 4))


def cut_outs():
    """Return cut-outs on and beside both ends of a half, and at an edge of the skirt."""
    cells = np.zeros(SHAPE, dtype=bool)
    cells[3, 2:4] = cells[8:11, 5] = cells[1, -1] = cells[4, 6] = True
    return cells | cells[thrust_image(SHAPE[0])]


def steps(level, parameters, oil, has_cut_outs, seeds):
    """Return outputs, tangents and content of the cells after a start and each of three steps."""
    cells = cut_outs() if has_cut_outs else None
    model = LubricationModel(Parameters(SHAPE, oil=Oil(**oil), open_cells=cells, **parameters))
    state, found = None, []
    for k, (film, velocity, temperature) in enumerate(motion(level)):
        inputs = film, velocity
        if state is None:
            state, outputs = model.start(*inputs, oil_temperature=temperature)
        else:
            length = 1e-4 * (1.0 + k)
            state, outputs = model.advance(state, *inputs, length, oil_temperature=temperature)
            tangents = model.tangent(1e-6 * seeds[0], seeds[1])
            outputs |= dict(zip(("of pressure", "of friction"), tangents))
        found.append(outputs | dict(content=state.film.content))
    return found


@pytest.mark.parametrize("case", CASES)
def test_half_of_a_symmetric_film_is_the_whole_film(case):
    """All outputs and derivatives agree to the round-off of a solution.

    The derivatives of half a film are those along the even part of a seed.
    """
    level, parameters, oil, has_cut_outs = case
    seeds = np.random.default_rng(1).standard_normal((2, 3, *SHAPE))
    even_seeds = seeds - odd_part(seeds, -2)
    whole = steps(level, parameters, oil, has_cut_outs, even_seeds)
    half = steps(level, parameters | HALF, oil, has_cut_outs, seeds)
    for expected, got in zip(whole, half):
        assert got.keys() == expected.keys()
        expected["content"] = expected["content"][3:10]  # from the thrust to the anti-thrust line
        for name in expected.keys() - {"mass_imbalance", "solver_iterations"}:
            a, b = np.asarray(expected[name]), np.asarray(got[name])
            assert a.shape == b.shape
            assert np.abs(a - b).max() <= 1e-12 * np.abs(a).max(), name
        assert got["mass_imbalance"] <= 1e-12 or "cavitation_model" in parameters
    last = whole[-1]
    assert last["film_fraction"].min() < 0.9 or "cavitation_model" in parameters
    assert last["contact_area_fraction"] > 0.0 or "roughness_rms" not in parameters


@pytest.mark.parametrize(
    "name, size", [("film_thickness", 1e-5), ("sliding_velocity", 5.0), ("oil_temperature", 350.0)]
)
def test_half_a_film_discards_a_step_with_inputs_that_are_not_symmetric(name, size):
    film = pc.Film(SHAPE, **HALF)
    inputs = dict(film_thickness=1e-5, sliding_velocity=5.0, oil_temperature=350.0)
    film.start(**inputs)
    before = film.state
    field = np.full(SHAPE, size)
    field[1, 2] *= 1.0 + 1.9e-6  # an odd part of 0.95e-6
    film.step(step=1e-4, **inputs | {name: field})
    film.state = before
    field[1, 2] = size * (1.0 + 2.1e-6)
    with pytest.raises(pc.Discard, match=rf"{name}\[2,3\]: .* set film_symmetry = none"):
        film.step(step=1e-4, **inputs | {name: field})
    assert film.state is before


@pytest.mark.parametrize("odd", [0.0, 1e-5])
def test_automatic_symmetry_follows_the_inputs_at_the_start(odd):
    """A film that starts with an odd part is computed whole."""
    film = pc.Film(SHAPE, film_symmetry="automatic")
    thickness = np.full(SHAPE, 1e-5)
    thickness[1] *= 1.0 + odd
    for _ in range(2):
        film.start(thickness, sliding_velocity=5.0)
        assert film.state is not None
        assert len(film.state.film.content) == (12 if odd else 7)
        film.start(1e-5, sliding_velocity=5.0)
        assert film.state is not None
        assert len(film.state.film.content) == 7


def test_faults_of_half_a_film_name_cells_of_the_whole_one():
    """They are reported before a lost symmetry, which may follow from them."""
    film = pc.Film(SHAPE, roughness_rms=1e-6, **HALF)
    film.start(1e-5, sliding_velocity=1.0)
    thin = np.full(SHAPE, 1e-5)
    thin[1, 2] = -3e-5  # the even part is -10 um there and in the image, row 5
    with pytest.raises(pc.Discard, match=r"film_thickness\[6,3\]: expected more than"):
        film.step(thin, 1e-4, sliding_velocity=1.0)


@pytest.mark.parametrize(
    "grid, options",
    [
        ((12, 8), dict(surface="bearing")),
        ((11, 8), {}),
        ((12, 8), dict(open_cells=np.arange(96).reshape(12, 8) == 8)),
    ],
)
def test_a_film_without_mirror_image_rejects_the_symmetry(grid, options):
    with pytest.raises(pc.BadInput, match="film_symmetry: expected none for a bearing"):
        pc.Film(grid, **HALF, **options)
