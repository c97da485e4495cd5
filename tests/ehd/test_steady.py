"""The steady state of a film alone, a journal under load, elastic shells, and errors."""

from functools import partial
from typing import NamedTuple

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_ehd.common.faults import NotConverged
from piston_cosim.fmu_ehd.journal import by_shapes, film_force, gap, shapes_of, stiffness
from piston_cosim.tests.verification.cases import bearings

BEARING = (160, 40)


def journal(eccentricity):
    """Return the film of a bearing of L/D = 1, grooved at the thickest film, and its thickness."""
    film = pc.Film(
        BEARING,
        surface="bearing",
        bore_radius=bearings.RADIUS,
        skirt_length=2.0 * bearings.RADIUS,
        viscosity=bearings.VISCOSITY,
        minimum_flow_film=1e-9,
        open_cells=bearings.grooved(BEARING),
    )
    return film, bearings.eccentric(BEARING, eccentricity)


@pytest.mark.parametrize("eccentricity", [0.6, 0.8])
def test_short_steps_stay_there_and_reach_the_same_state(eccentricity):
    film, thickness = journal(eccentricity)
    steady = film.steady(thickness, circumferential_velocity=bearings.SPEED)
    peak = steady["pressure"].max()
    after = film.step(thickness, 1e-4, circumferential_velocity=bearings.SPEED)
    assert np.abs(after["pressure"] - steady["pressure"]).max() <= 1e-8 * peak
    film.start(thickness, circumferential_velocity=bearings.SPEED)
    for length in 4.0 ** np.arange(-7, 8):
        outputs = film.step(thickness, length, circumferential_velocity=bearings.SPEED)
    assert np.abs(outputs["pressure"] - steady["pressure"]).max() <= 1e-9 * peak
    assert np.abs(outputs["film_fraction"] - steady["film_fraction"]).max() <= 1e-9


def test_a_step_may_be_an_integer():
    film = pc.Film((4, 8))
    film.start(1e-5, sliding_velocity=1.0)
    assert film.step(1e-5, 1, sliding_velocity=1.0)["film_fraction"].max() <= 1.0


def test_a_film_that_does_not_become_steady_raises_and_keeps_its_state(monkeypatch):
    film = pc.Film((4, 8))
    film.start(1e-5, sliding_velocity=1.0)
    state = film.state

    def fail(*_, **__):
        raise NotConverged("no solution")

    monkeypatch.setattr(film.model, "advance", fail)
    with pytest.raises(pc.Discard, match="the film does not become steady: no solution"):
        film.steady(1e-5, sliding_velocity=1.0)
    assert film.state is state


def test_a_change_above_the_tolerance_raises():
    film, thickness = journal(0.6)
    with pytest.raises(pc.Discard, match="expected a change of at most -1, got"):
        film.steady(thickness, circumferential_velocity=bearings.SPEED, tolerance=-1.0)


def test_oil_from_the_bore_is_rejected():
    film = pc.Film((4, 8), oil_supply="bore")
    with pytest.raises(pc.BadInput, match="oil_supply: expected edges for a steady film, got bore"):
        film.steady(1e-5, sliding_velocity=1.0)


def mixed_film():
    """Return a rough bearing, and the inputs of a load that mostly asperities carry."""
    film = pc.Film(
        (60, 8),
        surface="bearing",
        bore_radius="24 mm",
        skirt_length="17 mm",
        viscosity="7 mPa s",
        roughness_rms="0.3 um",
        summit_height="0.6 um",
    )
    around = dict(circumferential_velocity=0.3, pressure_lower_edge=1e5, pressure_upper_edge=1e5)
    return film, (3000.0, -7000.0), 24e-6, around


def test_a_journal_that_touches_is_in_balance():
    film, load, clearance, around = mixed_film()
    outputs = film.equilibrium(load, clearance, **around)
    assert outputs["boundary_friction_share"] > 0.5
    forces = outputs["nodal_pressure_force"], outputs["nodal_circumferential_force"]
    assert np.hypot(*film_force(*forces) + load) <= 1e-9 * np.hypot(*load)
    again = film.steady(outputs["film_thickness"], **around)
    highest = outputs["pressure"].max()
    assert again["pressure"] == pytest.approx(outputs["pressure"], abs=1e-12 * highest)  # round-off


def test_the_stiffness_of_a_journal_is_exact():
    """Against differences of the steady force; pressure, contact and shear."""
    film, load, clearance, around = mixed_film()
    place = np.array([6e-6, -21.5e-6])
    small = 1e-11

    def force(position):
        # the first steps settle the film, of the last one 1e9 s long is the tangent
        film.start(clearance, **around)
        for _ in range(4):
            outputs = film.step(gap(clearance, position, film.grid), 1e9, **around)
        return film_force(outputs["nodal_pressure_force"], outputs["nodal_circumferential_force"])

    ends = [[force(place + by * unit) for by in (small, -small)] for unit in np.eye(2)]
    differences = np.array([(low - high) / (2.0 * small) for high, low in ends]).T
    force(place)
    found = stiffness(film.model.tangent, film.grid)
    # round-off of forces of 1 kN, 1e-12 of them, over the difference
    assert np.abs(found - differences).max() <= 1e-4 * np.abs(differences).max()


def squeezed(film, outputs, clearance, around, length, way):
    """Return -F/velocity of one step that moves the journal, without its stiffness."""
    state, columns = film.state, []
    for unit in np.eye(2):
        forces = []
        for moved in (way * unit, -way * unit):
            film.state = state
            last = film.step(
                gap(clearance, outputs["position"] + moved, film.grid), length, **around
            )
            forces.append(
                film_force(last["nodal_pressure_force"], last["nodal_circumferential_force"])
            )
        columns.append((forces[1] - forces[0]) / (2.0 * way / length))
    return np.transpose(columns) - length * outputs["stiffness"]


def test_damping_is_that_of_a_squeeze_that_leaves_the_cavity():
    """One short step that moves the journal, whose cavity holds down to a fifth of the oil."""
    film = pc.Film(
        (48, 10), surface="bearing", bore_radius=0.025, skirt_length=0.02, viscosity=0.02
    )
    around = dict(circumferential_velocity=5.0, pressure_lower_edge=1e5, pressure_upper_edge=1e5)
    outputs = film.equilibrium((300.0, -1200.0), 25e-6, **around)
    assert outputs["film_fraction"].min() < 0.4
    differences = squeezed(film, outputs, 25e-6, around, 1e-7, 1e-12)
    damping, largest = outputs["damping"], np.abs(outputs["damping"]).max()
    # change of the cavity within a step, of first order in its length; round-off is below
    assert np.abs(damping - differences).max() <= 1e-4 * largest
    assert np.abs(damping - damping.T).max() <= 1e-2 * largest


def test_shells_follow_a_journal_that_is_damped():
    """Z(s) = K + s D of a full film for small s, by the tangents of two long steps."""
    film = pc.Film(
        (24, 6),
        surface="bearing",
        bore_radius=0.025,
        skirt_length=0.02,
        viscosity=0.02,
        cavitation_model="full_film",
    )
    around = dict(circumferential_velocity=5.0)
    shell = oval_shell(film.grid, 1e8)
    outputs = film.equilibrium((0.0, -500.0), 25e-6, shells=[shell], **around)
    shapes = shapes_of([shell], film.grid, np.array([0.0, -500.0]))
    rates = []
    for s in (1e-2, 1e-1):
        film.step(outputs["film_thickness"], 1.0 / s, **around)
        whole = -by_shapes(film.model.tangent, shapes, film.grid)
        rates.append(np.linalg.inv(np.linalg.inv(whole)[:2, :2]))
    damping = (rates[1] - rates[0]) / 0.09
    rigid = film.equilibrium((0.0, -500.0), 25e-6, **around)["damping"]
    largest = np.abs(damping).max()
    # stiffness over 0.09/s: round-off of 1e8 N/m is 1e-7 of 1e5 N s/m
    assert np.abs(outputs["damping"] - damping).max() <= 1e-4 * largest
    assert np.abs(rigid - damping).max() > 0.05 * largest


SUPPLIES = {
    "edge": (dict(), dict(pressure_upper_edge=1e4)),
    "partly filled edge that moves in": (
        dict(film_fraction_lower_edge=0.5),
        dict(sliding_velocity=0.1),
    ),
    "opening": (dict(open_cells=bearings.grooved((24, 6))), dict()),
    "ambient": (dict(cavitation_pressure=-1e5), dict()),
    "reynolds": (dict(cavitation_model="reynolds"), dict()),
    "gumbel": (dict(cavitation_model="gumbel"), dict()),
    "full film": (dict(cavitation_model="full_film"), dict()),
}


def test_a_film_without_supply_is_rejected_with_its_cures(monkeypatch):
    """Before it is solved. Its only steady state has drained."""
    steps = []
    monkeypatch.setattr(pc.Film, "_step", lambda *_: steps.append(1))
    grooved = bearings.grooved((24, 6))
    grooved[:, 1] = True
    closed = dict(opening_supply="own", film_fraction_openings=0.0, open_cells=grooved)
    for parameters, inputs in (
        (dict(), dict()),
        (dict(roughness_rms=1e-6, flow_factors="patir_cheng_1978"), dict()),
        (dict(coating_thickness=1e-5), dict()),
        (dict(film_fraction_lower_edge=0.0), dict(sliding_velocity=0.1)),
        (closed, dict()),
    ):
        film = pc.Film((24, 6), surface="bearing", **parameters)
        inputs = dict(circumferential_velocity=3.0) | inputs
        calls = (
            partial(film.equilibrium, (0.0, -10.0)),
            partial(film.equilibrium, None),
            film.steady,
        )
        for call in calls:
            with pytest.raises(pc.BadInput, match="supply") as trouble:
                call(25e-6, **inputs)
            for cure in ("pressure_lower_edge", "opening", "cavitation_pressure below"):
                assert cure in str(trouble.value)
    assert not steps


@pytest.mark.parametrize("name", SUPPLIES)
def test_a_film_with_supply_is_steady(name):
    parameters, inputs = SUPPLIES[name]
    film = pc.Film((24, 6), surface="bearing", **parameters)
    assert film.steady(25e-6, circumferential_velocity=3.0, **inputs)["mass_imbalance"] < 1e-9


def test_a_journal_at_rest_is_carried_by_asperities_alone():
    film, load, clearance, around = mixed_film()
    outputs = film.equilibrium(load, clearance, **around | dict(circumferential_velocity=0.0))
    asperities = film_force(outputs["asperity_pressure"] * film.model.area)
    assert asperities == pytest.approx(-np.array(load), rel=1e-8)
    smooth = pc.Film(film.grid, surface="bearing")
    with pytest.raises(pc.BadInput, match="circumferential_velocity: expected another value than"):
        smooth.equilibrium(load, clearance, **around | dict(circumferential_velocity=0.0))


def test_a_load_that_cannot_be_carried_is_reported(monkeypatch):
    film, load, clearance, around = mixed_film()
    film.start(clearance, **around)
    state = film.state
    monkeypatch.setattr("piston_cosim.fmu_ehd.journal.MOST_POSITIONS", 2)
    with pytest.raises(pc.Discard, match="no position of the journal carries the load"):
        film.equilibrium(load, clearance, **around)
    assert film.state is state
    with pytest.raises(pc.BadInput, match="load: expected two forces"):
        film.equilibrium((0.0, 0.0), clearance, **around)
    with pytest.raises(pc.BadInput, match="clearance: expected more than 0 m, got 0 m"):
        film.equilibrium(load, 0.0, **around)
    with pytest.raises(pc.BadInput, match="surface: expected bearing .*, got skirt"):
        pc.Film((4, 8)).equilibrium(load, clearance, circumferential_velocity=1.0)
    part = pc.Film((4, 8), surface="bearing", sector_angle="90 deg")
    with pytest.raises(pc.BadInput, match="sector_angle: expected a full revolution.*1.571 rad"):
        part.equilibrium(load, clearance, circumferential_velocity=1.0)
    with pytest.raises(pc.BadInput, match="shells: expected modes .*, got str; FMUs are not"):
        film.equilibrium(load, clearance, shells=["shell.fmu"], **around)


class Modes(NamedTuple):
    """A shell whose modes are harmonics around it, even along it."""

    omega: np.ndarray
    outward: np.ndarray
    onward: np.ndarray


def deflection(shell, outputs):
    """By which a shell opens a film under the forces of its outputs."""
    compliance = shell.outward / shell.omega
    q = np.tensordot(outputs["nodal_pressure_force"], compliance)
    q -= np.tensordot(outputs["nodal_circumferential_force"], shell.onward / shell.omega)
    return compliance @ q


def oval_shell(grid, stiffness):
    """Return a shell that deforms in 2, 3 and 4 lobes.

    Its circumferential shapes follow from a thin ring, du_t/da = -u_e.
    """
    angle = 2 * np.pi * np.arange(grid[0]) / grid[0]
    number = np.repeat([2, 3, 4], 2)
    phase = np.tile([0.0, np.pi / 2], 3)
    wave = np.cos(number * angle[:, None] - phase), np.sin(number * angle[:, None] - phase)
    even = np.ones((*grid, 1))
    onward = -wave[1] / number
    return Modes(np.sqrt(stiffness) * number, wave[0][:, None] * even, onward[:, None] * even)


def test_elastic_shells_agree_with_fixed_point_iteration():
    """Film and shell in turn, the journal by the rigid solve; and the stiffness by differences.

    More compliant shells make this iteration oscillate at this relaxation.
    """
    film, load, clearance, around = mixed_film()
    shell = oval_shell(film.grid, 1e9)
    outputs = film.equilibrium(load, clearance, shells=[shell], **around)
    opened = np.zeros(film.grid)
    for _ in range(200):
        last = film.equilibrium(load, clearance + opened, **around)
        change = deflection(shell, last) - opened
        opened = opened + 0.4 * change
        if np.abs(change).max() < 1e-9 * np.abs(opened).max():
            break
    largest = np.abs(opened).max()
    assert largest > 5.0 * outputs["film_thickness"].min()
    assert np.abs(outputs["deflection"] - opened).max() < 1e-7 * largest  # 100 times the tolerance
    assert np.abs(outputs["position"] - last["position"]).max() < 1e-7 * largest
    assert outputs["friction_power"] == pytest.approx(last["friction_power"], rel=1e-6)
    for column, unit in enumerate(np.eye(2)):
        ends = [
            film.equilibrium(load + by * unit, clearance, shells=[shell], **around)["position"]
            for by in (0.5, -0.5)
        ]
        # dx/dW is the inverse of the stiffness; forces differ by 1e-4 of the load
        flexibility = np.linalg.inv(outputs["stiffness"])
        assert ends[0] - ends[1] == pytest.approx(flexibility[:, column], rel=1e-3, abs=1e-11)


def test_stiff_shells_are_rigid():
    film, load, clearance, around = mixed_film()
    rigid = film.equilibrium(load, clearance, **around)
    shift = []
    for size in (1e14, 1e15):
        stiff = film.equilibrium(load, clearance, shells=[oval_shell(film.grid, size)], **around)
        shift.append(np.abs(stiff["position"] - rigid["position"]).max())
        for name in ("stiffness", "damping"):
            assert np.abs(stiff[name] / rigid[name] - 1.0).max() < 1e13 / size
    assert shift[0] / shift[1] == pytest.approx(10.0, rel=0.1)


def test_a_journal_that_does_not_move_has_shells_that_yield():
    """The force that the balance finds holds the same position."""
    film, load, clearance, around = mixed_film()
    shell = oval_shell(film.grid, 1e8)
    carried = film.equilibrium(load, clearance, shells=[shell], **around)
    rigid = gap(clearance, carried["position"], film.grid)
    held = film.equilibrium(None, np.maximum(rigid, 1e-6), shells=[shell], **around)
    assert held["position"].shape == (0,)
    opened = held["deflection"]
    again = film.steady(np.maximum(rigid, 1e-6) + opened, **around)
    assert np.abs(deflection(shell, again) - opened).max() < 1e-7 * np.abs(opened).max()
    with pytest.raises(pc.BadInput, match="shells: expected modes on"):
        film.equilibrium(load, clearance, shells=[oval_shell((8, 8), 1e8)], **around)


def flap_shell(grid, stiffness):
    """Return a shell whose edge behind a slot at angle 0 deforms like a flap."""
    angle = 2 * np.pi * np.arange(grid[0]) / grid[0]
    shape = np.exp(-angle / 0.3)[:, None, None] * np.ones((*grid, 1))
    return Modes(np.full(1, np.sqrt(stiffness)), shape, 0.0 * shape)


def test_a_soft_edge_at_an_inlet_opens_as_it_does_in_time(monkeypatch):
    """By twice the clearance. The reference is dq/dt = Q - q from rest.

    An open edge takes in more oil, which opens it more. Undamped iterations do not end.
    """
    grid = (90, 8)
    film = pc.Film(
        grid,
        surface="bearing",
        bore_radius="100 mm",
        skirt_length="200 mm",
        viscosity="9 mPa s",
        open_cells=np.repeat(np.arange(grid[0])[:, None] == 0, grid[1], axis=1),
        opening_supply="own",
    )
    clearance = gap(150e-6, np.array([-45e-6, 0.0]), grid)
    shell = flap_shell(grid, 2e6)
    outputs = film.equilibrium(None, clearance, shells=[shell], circumferential_velocity=28.0)
    opened, change = np.zeros(grid), np.ones(grid)
    while np.abs(change).max() > 1e-9 * opened.max():
        steady = film.steady(clearance + opened, circumferential_velocity=28.0)
        change = deflection(shell, steady) - opened
        opened = opened + 0.3 * change
    assert opened.max() > 300e-6
    assert np.abs(outputs["deflection"] - opened).max() < 1e-7 * opened.max()
    monkeypatch.setattr("piston_cosim.fmu_ehd.journal.LARGEST_DAMPING", 0.0)
    with pytest.raises(pc.Discard, match="no position of the journal"):
        film.equilibrium(None, clearance, shells=[shell], circumferential_velocity=28.0)
