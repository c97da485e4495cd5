import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_ehd.common.faults import NotConverged
from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.tests.verification.cases.motored import (
    DEGREE,
    film_after,
    motored,
    motored_film,
    motored_tangent_error,
    opening,
    physics,
)

SHAPE = (12, 10)
PHYSICS = physics(SHAPE)
LOSING = ("reynolds", "gumbel", "full film")
"""These lose oil where the film ruptures."""


@pytest.mark.parametrize("name", PHYSICS)
def test_tangent_is_the_central_difference(name):
    # third derivative x (1e-5)^2
    assert motored_tangent_error(Parameters(SHAPE, **PHYSICS[name])) <= 1e-7


def test_many_directions_at_once_are_the_single_ones():
    model, state, _ = motored(Parameters(SHAPE, roughness_rms=1e-6), 60)
    model.advance(state, *motored_film(SHAPE, 61 * DEGREE), DEGREE)
    rng = np.random.default_rng(1)
    dfilm, dvelocity = 1e-6 * rng.standard_normal((30, *SHAPE)), rng.standard_normal((30, *SHAPE))
    together = model.tangent(dfilm, dvelocity)
    for k in range(30):
        for many, single in zip(together, model.tangent(dfilm[k], dvelocity[k])):
            assert (
                np.abs(many[k] - single).max() <= 1e-12 * np.abs(single).max()
            )  # order of summation


@pytest.mark.parametrize("name", [name for name in PHYSICS if name not in LOSING])
def test_oil_is_conserved_under_every_option(name):
    _, _, history = motored(Parameters(SHAPE, **PHYSICS[name]), 100)
    assert max(o["mass_imbalance"] for o in history) <= 1e-12  # round-off
    assert min(o["film_fraction"].min() for o in history) < 0.9  # the film did rupture
    assert max(o["film_fraction"].max() for o in history) <= 1.0 + 1e-12


@pytest.mark.parametrize("name", ["cut-out", "everything"])
def test_what_is_given_in_cut_outs_is_looked_at_nowhere(name):
    """Film, velocity and temperature there may be anything: the same bits everywhere else."""
    rng = np.random.default_rng(2)
    model, state, _ = motored(Parameters(SHAPE, **PHYSICS[name]), 20)
    film, velocity = motored_film(SHAPE, 21 * DEGREE)
    direction = rng.standard_normal((2, *SHAPE)) * [[[1e-6]], [[1.0]]]
    answers = []
    for other in (0.0, -3e-6, 1e-3):
        h, v, dh, dv = (
            np.where(opening(SHAPE), other * 1e6 * np.sign(field), field) if other else field
            for field in (film, velocity, *direction)
        )
        temperature = np.where(opening(SHAPE), 360.0 + 1e3 * other, 380.0)
        after, o = model.advance(state, h, v, DEGREE, oil_temperature=temperature)
        answers.append([after.film.content, *o.values(), *model.tangent(dh, dv)])
    for again in answers[1:]:
        assert all(np.array_equal(a, b) for a, b in zip(answers[0], again))


@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize("pressure, fraction", [(2e5, 1.0), (0.0, 0.3)])
def test_a_cut_out_is_an_edge_of_the_film_beside_it(pressure, fraction, own):
    """A film below a cut-out is that of a skirt that ends there, to round-off.

    All cells above row 6 are cut out. The cut-out has the pressure and the oil of the lower edge,
    or its own next to a lower edge at 1e5 Pa.
    """
    rows = 6
    film, velocity = motored_film(SHAPE, 30 * DEGREE)
    given = dict(pressure_lower_edge=pressure, film_fraction_lower_edge=fraction)
    supply = {}
    if own:
        given = dict(pressure_lower_edge=1e5)
        supply = dict(
            opening_supply="own", pressure_openings=pressure, film_fraction_openings=fraction
        )
    above = np.broadcast_to(np.arange(SHAPE[1]) >= rows, SHAPE)
    whole = LubricationModel(
        Parameters(SHAPE, open_cells=above, pressure_upper_edge=5e5, **given, **supply)
    )
    length = 27e-3 * rows / SHAPE[1]
    short = LubricationModel(
        Parameters(
            (SHAPE[0], rows),
            skirt_length=length,
            pressure_upper_edge=pressure,
            film_fraction_upper_edge=fraction,
            **given,
        )
    )
    answers = []
    for model, columns in ((whole, SHAPE[1]), (short, rows)):
        h, v = film[:, :columns].copy(), velocity[:, :columns].copy()
        state, _ = model.start(h, v)
        high = np.full(h.shape, 1e5)
        state = state._replace(film=state.film._replace(unknown=high, unknown_before=high))
        for k in range(1, 4):
            state, o = model.advance(state, (1.0 - 0.05 * k) * h, v, DEGREE)
        answers.append(o)
    cut, plain = answers
    assert cut["pressure"][:, :rows] == pytest.approx(plain["pressure"], rel=1e-9, abs=1e-3)
    assert cut["film_fraction"][:, :rows] == pytest.approx(plain["film_fraction"], rel=1e-9)
    assert cut["flow_lower_edge"] == pytest.approx(plain["flow_lower_edge"], rel=1e-9)
    assert cut["flow_upper_edge"] == 0.0
    assert cut["flow_openings"] == pytest.approx(plain["flow_upper_edge"], rel=1e-9)
    for force in ("nodal_pressure_force", "nodal_friction_force"):
        assert cut[force][:, :rows] == pytest.approx(plain[force], rel=1e-9, abs=1e-12)
        assert np.all(cut[force][:, rows:] == 0.0)
    assert cut["mass_imbalance"] <= 1e-12


@pytest.mark.parametrize("gap", [-5e-6, 3e-6, 4e-5])
@pytest.mark.parametrize("coating", [0.0, 3e-5])
def test_cells_without_a_film_count_in_no_scalar(gap, coating):
    """The thinnest film, the highest pressure and contact are those of the 10 um beside them."""
    p = Parameters(SHAPE, roughness_rms=1e-6, coating_thickness=coating, open_cells=opening(SHAPE))
    o = film_after(p, [np.where(opening(SHAPE), gap, 1e-5)] * 4, 5.0).outputs
    assert o["minimum_film_thickness"] == pytest.approx(1e-5, rel=0.3 if coating else 1e-15)
    assert o["maximum_pressure"] == o["pressure"][~opening(SHAPE)].max()
    assert np.all(o["asperity_pressure"] == 0.0)
    assert o["contact_area_fraction"] == 0.0


def pressed(gap, step=1e-4, from_start=False, **changes):
    """Press one cell among cells of 20 um, in a step from an even film or at the start."""
    film = np.where(np.arange(120).reshape(SHAPE) == 34, gap, 2e-5)
    return film_after(
        Parameters(SHAPE, **changes), [film] if from_start else [2e-5, film], 1.0, step
    )


COATED = dict(coating_thickness=1e-6, coating_modulus=1e12)


@pytest.mark.parametrize("from_start", [False, True])
@pytest.mark.parametrize(
    "least, changes",
    [(0.0, {}), (-6e-7, dict(roughness_rms=4e-7)), (-1.6e-6, COATED | dict(roughness_rms=4e-7))],
)
def test_surfaces_overlap_as_far_as_contact_means_something(least, changes, from_start):
    """Eq. (A14): one cell that overlaps farther is named, at the start and in a step.

    The least film thickness is -1.5 roughnesses, less the thickness of a coating.
    """
    for gap in (least, -1e-5, -0.073):
        with pytest.raises(
            NotConverged, match=rf"film_thickness.4,5.: .* than {least:g} m, got {gap:g} m"
        ):
            pressed(gap, from_start=from_start, **changes)
    if not changes or "coating_modulus" not in changes:
        pressed(least + 1e-9, from_start=from_start, **changes)


def test_a_stiff_coating_does_not_hide_an_overlap():
    """The layer of 1 um yields by 1 nm, so that the surfaces overlap by more than 0.6 um.

    The step is so long that the oil leaves.
    """
    with pytest.raises(
        NotConverged, match=r"4,5.* deflection of the coating: .* -6e-07 m, got -7.9"
    ):
        pressed(-8e-7, 1e9, roughness_rms=4e-7, **COATED)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_film_that_is_no_number_is_refused_by_its_cell(wrong):
    film = np.full(SHAPE, 1e-5)
    film[2, 4] = wrong
    with pytest.raises(
        NotConverged, match=rf"film_thickness\[3,5\]: expected a finite value, got {wrong:g} m"
    ):
        film_after(Parameters(SHAPE), [1e-5, film])


def test_a_coated_film_survives_jumps():
    """A coated film with piezoviscous oil survives jumps: none of 200 steps is rejected.

    Films of 2 um jump by up to 30 % from cell to cell and step to step.
    Whole steps of Newton's method lost one of 200, and 0.3 to 0.5 % of 2000.
    """
    parameters = Parameters(
        SHAPE, coating_thickness=2e-5, oil=Oil(pressure_viscosity_law="roelands_1966")
    )
    for seed in (0, 1):
        rng = np.random.default_rng(seed)
        model = LubricationModel(parameters)
        state, _ = model.start(*motored_film(SHAPE, 0.0))
        for n in range(1, 101):
            film, velocity = motored_film(SHAPE, n * DEGREE)
            film = 0.2 * film * rng.uniform(0.7, 1.3, SHAPE)
            state, _ = model.advance(state, film, velocity, DEGREE)


@pytest.mark.parametrize("cavitation", ["jfo", "reynolds", "gumbel", "full_film"])
def test_a_coated_film_is_the_hard_film_of_its_thickness(cavitation):
    """A coating under w = c (p + p_a) has the pressure of a hard film of h + w.

    Tangent: third derivative x (1e-5)^2.
    """
    rng = np.random.default_rng(5)
    options = dict(
        cavitation_model=cavitation,
        cavitation_pressure=-5e4,
        pressure_lower_edge=3e5,
        pressure_upper_edge=4e5,
        roughness_rms=3e-7,
    )
    soft = pc.Film(SHAPE, coating_thickness=1.4e-5, coating_modulus=1e9, **options)
    hard = pc.Film(SHAPE, **options)
    begun = 2e-6 * (1.0 + rng.random(SHAPE))
    ended = begun * (1.0 + 0.1 * rng.standard_normal(SHAPE))
    for film in (soft, hard):
        film.start(begun, sliding_velocity=3.0)
    state = soft.state
    direction = 2e-7 * rng.standard_normal(SHAPE)
    forces = []
    for share in (1e-5, -1e-5):
        soft.state = state
        moved = soft.step(ended + share * direction, 1e-5, sliding_velocity=3.0)
        forces.append(moved["nodal_pressure_force"])
    soft.state = state
    outputs = soft.step(ended, 1e-5, sliding_velocity=3.0)
    assert soft.state is not None
    yielded = soft.state.film.deflection
    pressure = outputs["pressure"] + 5e4 + outputs["asperity_pressure"]
    assert np.abs(yielded - 1.04e-14 * pressure).max() <= 1e-10 * yielded.max()  # E, nu by hand
    expected = hard.step(ended + yielded, 1e-5, sliding_velocity=3.0)["pressure"]
    assert np.abs(outputs["pressure"] - expected).max() <= 1e-10 * expected.max()
    difference = (forces[0] - forces[1]) / 2e-5
    change = soft.tangent(direction)[0]
    assert np.abs(change - difference).max() <= 1e-6 * np.abs(change).max()
    assert cavitation != "jfo" or outputs["mass_imbalance"] <= 1e-12  # round-off


def test_a_film_at_rest_has_an_even_pressure_and_no_friction():
    """Edges at 0.7 bar above the cavity: the same bits in every cell, whatever the film."""
    film = pc.Film(SHAPE, cavitation_pressure=-7e4, viscosity=0.3)
    thickness = 1e-6 * (1.0 + np.random.default_rng(1).random(SHAPE))
    film.start(thickness, sliding_velocity=0.0)
    outputs = film.step(thickness, 1e-2, sliding_velocity=0.0)
    assert np.ptp(outputs["pressure"]) == 0.0
    assert not outputs["nodal_friction_force"].any()


def test_suction_below_the_end_of_a_law_discards_the_step():
    """Plates of 20 mm that part at 20 m/s would need gigapascals of suction."""
    film = pc.Film(SHAPE, cavitation_model="full_film", pressure_viscosity_law="roelands_1966")
    film.start(5e-6, sliding_velocity=0.0)
    before = film.state
    with pytest.raises(pc.Discard, match=r"-1.96e\+08 Pa .* roelands_1966 ends, got -\d"):
        film.step(1e-5, 2.5e-7, sliding_velocity=0.0)
    assert film.state is before


def test_a_refused_step_has_no_tangent():
    model, state, _ = motored(Parameters(SHAPE), 3)
    film, velocity = motored_film(SHAPE, 4 * DEGREE)
    with pytest.raises(NotConverged):
        model.advance(state, -film, velocity, DEGREE)
    with pytest.raises(RuntimeError):
        model.tangent(film, velocity)


def test_a_step_with_such_an_edge_is_refused():
    model = LubricationModel(Parameters(SHAPE))
    film, velocity = np.full(SHAPE, 1e-5), np.full(SHAPE, 2.0)
    state, _ = model.start(film, velocity)
    with pytest.raises(
        NotConverged, match="film_fraction_lower_edge: .* got 0.5 at pressure_lower_edge"
    ):
        model.advance(
            state, film, velocity, 1e-4, film_fraction_lower_edge=0.5, pressure_lower_edge=1e5
        )
    state, o = model.advance(state, film, velocity, 1e-4, film_fraction_lower_edge=0.5)
    assert o["mass_imbalance"] <= 1e-12  # round-off


def test_boundary_friction_share_is_that_of_the_work_since_the_start():
    """Steps of 1 and 3 degrees; axial forces times one velocity for the whole skirt."""
    p = Parameters(SHAPE, roughness_rms=3e-6)
    model = LubricationModel(p)
    film, sliding = motored_film(SHAPE, 0.0)
    state, outputs = model.start(0.3 * film, sliding)
    assert outputs["boundary_friction_share"] == 0.0
    boundary = total = 0.0
    time = 0.0
    for step in (DEGREE, 3.0 * DEGREE, DEGREE):
        time += step
        film, sliding = motored_film(SHAPE, time)
        state, outputs = model.advance(state, 0.3 * film, sliding, step)
        boundary -= outputs["friction_force_asperity"] * sliding[0, 0] * step
        total += outputs["friction_power"] * step
    assert outputs["boundary_friction_share"] == pytest.approx(boundary / total, rel=1e-12)
    assert 0.001 < outputs["boundary_friction_share"] < 0.999


def test_a_film_that_an_edge_pressure_drives_has_a_boundary_friction_share_of_one():
    """The pressure flow shears the skirt along its motion, so friction is less than contact."""
    film, _ = motored_film(SHAPE, 0.0)
    p = Parameters(SHAPE, roughness_rms=3e-6, pressure_lower_edge=5e6)
    found = []
    for velocity in (-0.01, 0.01):
        outputs = film_after(p, [0.3 * film] * 2, velocity).outputs
        contact = -outputs["friction_force_asperity"] * velocity
        found.append((outputs["friction_power"] / contact, outputs["boundary_friction_share"]))
    (driven, one), (held, less) = sorted(found)
    assert driven < 1.0 and one == 1.0
    assert held > 1.0 and less == pytest.approx(1.0 / held, rel=1e-12)


def test_contact_area_is_that_of_the_skirt_that_is_there():
    """The same parallel film with a part cut out has the same share in contact."""
    whole, cut = (
        film_after(Parameters(SHAPE, roughness_rms=1e-6, open_cells=mask), [1e-6]).outputs
        for mask in (None, opening(SHAPE))
    )
    share = whole["contact_area_fraction"]
    assert share > 0.0
    assert cut["contact_area_fraction"] == pytest.approx(share, rel=1e-14)


def test_cavitation_pressure_shifts_the_datum_alone():
    gauge, absolute = (
        motored(
            Parameters(SHAPE, pressure_lower_edge=p, pressure_upper_edge=p, cavitation_pressure=p),
            60,
        )[2][-1]
        for p in (0.0, 1e5)
    )
    scale = gauge["maximum_pressure"]
    assert (
        np.abs(absolute["pressure"] - 1e5 - gauge["pressure"]).max() <= 1e-9 * scale
    )  # round-off of the datum
    assert np.abs(absolute["film_fraction"] - gauge["film_fraction"]).max() <= 1e-12


@pytest.mark.parametrize("flow_factors", ["none", "patir_cheng_1978"])
def test_friction_power_is_the_work_of_the_axial_force(flow_factors):
    """- sum F V, with a velocity, a film in contact and oil that differ from cell to cell."""
    rng = np.random.default_rng(3)
    film = rng.uniform(1e-6, 8e-6, SHAPE)
    velocity = rng.uniform(-5.0, 5.0, SHAPE)
    p = Parameters(SHAPE, roughness_rms=1e-6, flow_factors=flow_factors, open_cells=opening(SHAPE))
    o = film_after(p, [film] * 2, velocity).outputs
    work = -(o["nodal_friction_force"] * velocity).sum()
    assert o["friction_power"] == pytest.approx(work, rel=1e-12)
    assert o["friction_force_asperity"] != 0.0
