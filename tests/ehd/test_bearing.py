"""The film of a bearing: sliding around, sectors, and what does not go with it."""

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_ehd.common.grid import Cells
from piston_cosim.fmu_ehd.laws.circumferential import gradients_around
from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.parameters import Parameters, faults
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.tests.verification.cases.motored import film_after, motored_until, tangent_error

from .fuzz import made_slave

SHAPE = (24, 8)


def cut(shape):
    """Return the open cells of a groove and a hole."""
    cells = np.zeros(shape, dtype=bool)
    cells[0] = True
    cells[7:9, 3:5] = True
    return cells


PHYSICS = {
    "plain": dict(),
    "reynolds": dict(cavitation_model="reynolds"),
    "gumbel": dict(cavitation_model="gumbel"),
    "full film": dict(cavitation_model="full_film", cavity_shear="full_film"),
    "contact": dict(roughness_rms=6e-6, summit_height=3e-6),
    "fed": dict(open_cells=cut(SHAPE), opening_supply="own", pressure_openings=3e5),
    "barus": dict(oil=Oil(pressure_viscosity_law="barus_1893"), pressure_upper_edge=1e5),
    "cross": dict(oil=Oil(shear_thinning_law="cross_1965")),
    "coating": dict(coating_thickness=2e-5, coating_modulus=1e9, roughness_rms=6e-6),
    "flow factors": dict(
        roughness_rms=6e-6,
        flow_factors="patir_cheng_1978",
        peklenik_number_skirt=0.25,
        peklenik_number_bore=3.0,
        roughness_share_skirt=0.3,
    ),
    "sector": dict(
        sector_angle=2.5, opening_supply="own", pressure_openings=1e5, roughness_rms=6e-6
    ),
}


def motion(shape, time):
    """Return the motion of a journal that turns, tilts and shifts.

    It is the film thickness [m], the axial and the circumferential velocity [m/s].
    """
    theta = np.arange(shape[0]) * 2.0 * np.pi / shape[0]
    y = (np.arange(shape[1]) + 0.5) / shape[1] - 0.5
    turn = 2.0 * np.pi * 50.0 * time
    film = 3e-5 * (1.0 + (0.5 + 0.2 * y + 0.1 * np.sin(turn)) * np.cos(theta[:, None] - turn))
    uneven = 1.0 + 0.2 * np.cos(theta[:, None] + 3.0 * y)
    return film, 1.5 * np.cos(turn) * uneven, 6.0 * (1.0 + 0.3 * np.sin(turn)) / uneven


def run(changes, ends):
    """Return a bearing after steps that end at given times [s]."""
    parameters = Parameters(SHAPE, surface="bearing", skirt_length=0.03, **changes)
    model, state, history = motored_until(parameters, ends, motion)
    return model, state, history[-1]


@pytest.mark.parametrize("name", PHYSICS)
def test_tangent_is_exact_with_both_velocities(name):
    step = 4e-5
    model, state, _ = run(PHYSICS[name], step * np.arange(1, 31))
    # third derivative times the difference squared, and round-off over the difference
    assert tangent_error(model, state, motion(SHAPE, 31 * step), step, directions=2) < 2e-7


def test_oil_is_conserved_to_round_off_and_the_film_ruptures():
    ends = 5e-5 * np.arange(1, 41)
    model, state, outputs = run({}, ends)
    assert (outputs["film_fraction"] < 0.9).any()
    assert outputs["mass_imbalance"] < 1e-12  # round-off


ON_ITS_SIDE = {
    "smooth": (dict(), dict()),
    # the other surface rests, and the axis is at right angles to sliding
    "rough": (
        dict(peklenik_number_skirt=6.0, peklenik_number_bore=1 / 3, roughness_share_skirt=0.7),
        dict(peklenik_number_bore=1 / 6, peklenik_number_skirt=3.0, roughness_share_skirt=0.3),
    ),
}
# film thickness from 2 to 4 rms
FACTORS = dict(flow_factors="patir_cheng_1978", roughness_rms=1e-5, boundary_friction_coefficient=0)


@pytest.mark.parametrize("surfaces", ON_ITS_SIDE)
def test_a_turning_bearing_is_an_axial_slider_on_its_side(surfaces):
    """A turning bearing is an axial slider on its side.

    One row around, a sector with both ends at ambient, is the pad of the skirt along its axis.
    The grid rests on the bore, so that sliding has the opposite sign.
    """
    n = 30
    slope = 1.0 + np.linspace(1.0, 0.0, n)
    of_pad, of_bearing = (given and given | FACTORS for given in ON_ITS_SIDE[surfaces])
    p = Parameters((4, n), skirt_length=0.03, bore_radius=0.02, **of_pad)
    pad, _, along = film_after(p, [2e-5 * slope] * 2, -4.0)
    # so wide along that its open edges do not count in the middle
    p = Parameters(
        (n, 4),
        surface="bearing",
        bore_radius=0.02,
        sector_angle=1.5,
        skirt_length=2.0,
        **of_bearing,
    )
    film = 2e-5 * slope
    around, _, across = film_after(p, [film[:, None]] * 2, turning=4.0)
    # both reach 30 mm in sliding; ends of a length 2 m leak 1e-3 of their cell
    assert np.allclose(across["pressure"][:, 1], along["pressure"][0], rtol=1e-4)
    shear = along["nodal_friction_force"][0] / pad.area.max()
    turned = across["nodal_circumferential_force"][:, 1] / around.area.max()
    # the slope belongs to the other surface: forces on both differ by h dp/dx, Eq. (F8)
    pressure = along["pressure"][0]
    carried = film[1:-1] * (pressure[2:] - pressure[:-2]) / (2.0 * 1e-3)
    assert np.allclose((turned + shear)[1:-1], carried, rtol=1e-4, atol=1e-4 * shear.max())


def test_a_skirt_given_nothing_around_has_its_axial_pressure_on_a_bearing_too():
    """Without circumferential velocity a bearing has the axial pressure of a skirt.

    The grid of a bearing rests on the other surface.
    If the film is steady on that surface, sliding has the opposite sign.
    """
    film = np.linspace(1e-5, 2e-5, 8)
    found = {
        surface: film_after(Parameters(SHAPE, surface=surface), [film] * 2, velocity, 1e9).outputs
        for surface, velocity in (("skirt", 3.0), ("bearing", -3.0))
    }
    assert np.array_equal(found["skirt"]["pressure"], found["bearing"]["pressure"])
    assert found["skirt"]["nodal_friction_force"].sum() < 0.0
    assert found["bearing"]["nodal_friction_force"].sum() > 0.0


def test_couette_torque_and_power_of_a_concentric_journal():
    p = Parameters(SHAPE, surface="bearing", oil=Oil(viscosity=0.02), skirt_length=0.04)
    outputs = film_after(p, [2e-5] * 2, 3.0, turning=4.0).outputs
    area = 2.0 * np.pi * p.bore_radius * 0.04
    # Petroff: mu W / h by area and radius; power mu (V^2 + W^2) / h
    assert outputs["friction_torque"] == pytest.approx(-0.02 * 4.0 / 2e-5 * area * p.bore_radius)
    assert outputs["friction_power"] == pytest.approx(0.02 * 25.0 / 2e-5 * area)


def test_coulomb_friction_points_against_both_velocities():
    p = Parameters(SHAPE, surface="bearing", roughness_rms=1e-6, oil=Oil(viscosity=1e-5))
    model, _, outputs = film_after(p, [1e-6] * 2, 3.0, turning=-4.0)
    normal = p.boundary_friction_coefficient * outputs["asperity_pressure"] * model.area.max()
    viscous = 1e-5 / 1e-6 * model.area.max()
    # v0 = 1 mm/s beside 5 m/s: 2e-8
    assert np.allclose(outputs["nodal_friction_force"], -0.6 * normal - 3.0 * viscous, rtol=1e-6)
    expected = 0.8 * normal + 4.0 * viscous
    assert np.allclose(outputs["nodal_circumferential_force"], expected, rtol=1e-6)


def test_gradient_around_by_hand():
    pressure = np.array([[1.0], [3.0], [9.0], [4.0]])
    area = np.ones((4, 1))
    ring = gradients_around(pressure, area, 0.0, 0.5, True)
    assert ring.ravel().tolist() == [-1.0, 8.0, 1.0, -8.0]
    sector = gradients_around(pressure, area, 2.0, 0.5, False)
    # faces 2, 2 | 2, 6 | 6, 6.5 | 6.5, 2
    assert sector.ravel().tolist() == [0.0, 8.0, 1.0, -9.0]
    area[1] = 0.0  # an opening, whose pressure reaches to the face
    assert gradients_around(pressure, area, 0.0, 0.5, True).ravel().tolist()[2] == 7.0


def test_sector_has_the_supply_at_its_ends():
    """Between parallel surfaces at rest pressure falls straight from end to end of a long film."""
    p = Parameters(
        (20, 4),
        surface="bearing",
        sector_angle=1.0,
        skirt_length=2.0,
        bore_radius=0.01,
        opening_supply="own",
        pressure_openings=2e5,
    )
    model, _, outputs = film_after(p, [2e-5] * 2, step=1e9)
    assert model.fixed.domain.cells == Cells(0.01 / 20, 2.0 / 4, ring=False, mirrored=False)
    assert np.allclose(outputs["pressure"][:, 1:3], 2e5, rtol=1e-3)
    # what comes in at the ends leaves over the edges
    leak = outputs["flow_lower_edge"] + outputs["flow_upper_edge"]
    assert outputs["flow_openings"] == pytest.approx(-leak, rel=1e-12)


OWN = dict(opening_supply="own")
STARVED = dict(film_fraction_lower_edge=0.0, film_fraction_upper_edge=0.9)
PARTLY = "expected 1 above cavitation_pressure = {} Pa, got {} at pressure_{} = {} Pa"
FROM_BORE = dict(pressure_upper_edge=1e5, film_fraction_lower_edge=0.5, cavitation_model="gumbel")


@pytest.mark.parametrize(
    "changes, words",
    [
        (dict(surface="skirt", sector_angle=2.0), ["sector_angle: expected a full revolution"]),
        (dict(surface="bearing", oil_supply="bore"), ["oil_supply: expected edges for a bearing,"]),
        (dict(surface="bearing", sector_angle=2.0, open_cells=cut(SHAPE)), ["with openings"]),
        (
            dict(pressure_lower_edge=-1e4, pressure_upper_edge=-2e4),
            ["got -10000 Pa", "got -20000 Pa"],
        ),
        (
            dict(film_fraction_upper_edge=0.3, cavitation_pressure=-1e5),
            [PARTLY.format(-100000, 0.3, "upper_edge", 0)],
        ),
        (
            STARVED | dict(pressure_lower_edge=1.0, pressure_upper_edge=1.0),
            [PARTLY.format(0, 0, "lower_edge", 1), PARTLY.format(0, 0.9, "upper_edge", 1)],
        ),
        (
            OWN | dict(pressure_openings=1.0, film_fraction_openings=0.4),
            [PARTLY.format(0, 0.4, "openings", 1)],
        ),
        (
            OWN | dict(pressure_openings=-1e4),
            ["pressure_openings: expected at least cavitation_pressure = 0 Pa"],
        ),
        (dict(pressure_openings=3e5), ["or set opening_supply = own"]),
        (OWN | dict(oil_supply="bore"), ["opening_supply: expected lower_edge with oil_supply"]),
        (
            FROM_BORE | dict(oil_supply="bore"),
            ["pressure_upper_edge", "film_fraction_lower_edge", "cavitation_model"],
        ),
    ],
)
def test_what_does_not_go_together_is_said(changes, words):
    sentences = faults(Parameters(SHAPE, **changes))
    assert len(sentences) == len(words)
    assert all(any(word in sentence for sentence in sentences) for word in words), sentences


@pytest.mark.parametrize(
    "changes",
    [
        STARVED,
        OWN | dict(pressure_openings=3e5),
        OWN | dict(film_fraction_openings=0.4),
        dict(cavitation_pressure=-1e5),  # flooded
        dict(oil_supply="bore"),
    ],
)
def test_what_goes_together_is_taken(changes):
    assert faults(Parameters(SHAPE, **changes)) == []


def test_the_fmu_of_a_bearing_has_both_velocities_and_no_thrust_side(tmp_path):
    slave = made_slave(tmp_path, grid=list(SHAPE), surface="bearing")
    film, axial, around = motion(SHAPE, 0.0)
    slave.views["film_thickness"][...] = film
    slave.views["sliding_velocity"][...] = axial
    slave.views["circumferential_velocity"][...] = around
    slave.exit_initialization_mode()
    assert slave.do_step(0.0, 1e-4)
    declared = {v.name for v in slave.table if v.causality == "output"}
    _, outputs = slave.advance(slave.state, slave._values(), 0.0, 1e-4)
    assert set(outputs) == declared
    assert not any("thrust" in name for name in declared)
    seeds = {name: np.ones(SHAPE) for name in slave.derivative_inputs}
    assert set(slave.directional_derivative(seeds)) == set(slave.derivative_outputs)
    assert slave.views["friction_torque"] < 0.0


def test_a_film_called_like_the_other_surface_raises():
    """A turning journal called like a skirt had no load."""
    bearing, skirt = pc.Film(SHAPE, surface="bearing"), pc.Film(SHAPE)
    with pytest.raises(BadInput, match="surface: expected one of skirt, bearing,"):
        pc.Film(SHAPE, surface="journal")
    with pytest.raises(BadInput, match="circumferential_velocity: expected nothing"):
        skirt.start(1e-5, sliding_velocity=0.0, circumferential_velocity=2.0)
    with pytest.raises(BadInput, match="circumferential_velocity: expected the"):
        bearing.start(1e-5, sliding_velocity=2.0)
    with pytest.raises(BadInput, match="sliding_velocity: expected the velocity of"):
        skirt.start(1e-5)
    with pytest.raises(TypeError):
        bearing.start(1e-5, 2.0)
    bearing.start(1e-5, circumferential_velocity=0.0)
    with pytest.raises(BadInput, match="circumferential_velocity: expected the velocity"):
        bearing.step(1e-5, 1e-4)
    with pytest.raises(TypeError):
        bearing.step(1e-5, 2.0, 1e-4)
    outputs = bearing.step(1e-5, 1e-4, circumferential_velocity=2.0)
    assert (outputs["nodal_circumferential_force"] < 0.0).all()
    of_film, *_ = bearing.tangent(1.0)
    assert of_film.shape == SHAPE
