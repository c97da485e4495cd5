"""A floating pin that tilts and bends.

Tests cover frequencies and deflection of a free beam, rows by hand, springs, derivatives, works
and limits.
"""

import dataclasses

import numpy as np
import pytest
from scipy.linalg import expm

from piston_cosim.fmu_mfbd.dynamics.model_faults import faults
from piston_cosim.fmu_mfbd.dynamics.pin_shells import shapes_of
from piston_cosim.fmu_mfbd.geometry.eigen import symmetric_eigen
from piston_cosim.fmu_mfbd.geometry.pin import (
    ModeMotion,
    PinForces,
    opening_of,
    pin_surface,
    power_on_grid,
    resultants_on,
    turned,
    yielded,
)
from piston_cosim.fmu_mfbd.geometry.pin_shapes import (
    MOST_SHAPES,
    HollowPin,
    beam_at,
    beam_shapes,
    free_beam,
    section,
    spin_inertia,
)

from .pin_models import (
    AXIS,
    CRITICAL,
    PARAMETERS,
    PIN,
    PIN_GRID,
    STEEL,
    STEP,
    Springs,
    bending_model,
    bending_options,
    bodies,
    rough_inputs,
    shells_of,
)

BOSS, EYE = 25e-3, 36e-3


@pytest.mark.parametrize(("bore", "share"), [(0.0, 7.8 / 8.8), (0.9999, 2.6 / 4.9)])
def test_stiffness_of_a_section_by_hand(bore, share):
    """Shear stiffness has Cowper's factors of a solid circle and of a thin tube.

    They are 6 (1 + nu)/(7 + 6 nu) and 2 (1 + nu)/(4 + 3 nu). A wall of 1e-4 of the radius misses
    the latter by the square of 1e-4.
    """
    pin = PIN._replace(bore_radius=bore * PIN.radius)
    of = section(pin)
    area = np.pi * PIN.radius**2 * (1 - bore**2)
    second = area * PIN.radius**2 * (1 + bore**2) / 4
    assert of.shear == pytest.approx(share * 206e9 / 2.6 * area, rel=1e-6)
    assert of.bending == pytest.approx(206e9 * second, rel=1e-12)
    assert of.mass == pytest.approx(0.5 / 86e-3, rel=1e-12)
    assert of.turning == pytest.approx(of.mass * second / area, rel=1e-12)


def test_a_slender_pin_has_the_frequencies_of_a_free_beam():
    """A slender pin has omega = (beta L)^2 (E I/m L^3)^1/2 with cos cosh = 1.

    Shear and rotation in a beam of 1000 diameters reduce it by about (beta r/2)^2 (1 + E/(kappa
    G))/2. This is 5e-5 for the fourth frequency.
    """
    pin = HollowPin(mass=1.0, length=1.0, radius=5e-4, bore_radius=0.0, **STEEL)
    beam = free_beam(pin, 5)
    unit = np.sqrt(section(pin).bending / (pin.mass * pin.length**3))
    wanted = np.array([0.0, 4.730041, 7.853205, 10.995608, 14.137165]) ** 2
    np.testing.assert_allclose(beam.omega / unit, wanted, rtol=6e-5)


def test_a_thick_pin_has_the_frequencies_of_timoshenkos_equation():
    """The determinant of Timoshenko's equation changes sign within 1e-8 of every frequency.

    The test does not use polynomials. The matrix exponential carries the state (w, b, shear force,
    moment) along the pin. Free ends require a 2 x 2 determinant of 0. The test covers ten bending
    frequencies of three kinds.
    """
    of = section(PIN)

    def determinant(omega):
        rates = np.zeros((4, 4))
        rates[0, 1:3] = 1.0, 1 / of.shear
        rates[1, 3] = 1 / of.bending
        rates[2, 0] = -of.mass * omega**2
        rates[3, 1:3] = -of.turning * omega**2, -1.0
        # lengths in radii, forces in newtons of a shear by one radius
        scale = np.array([1.0, 1 / PIN.radius, of.shear / PIN.radius, of.bending / PIN.radius**2])
        through = expm(rates * scale / scale[:, None] * PIN.length)
        return np.linalg.det(through[2:, :2])

    for omega in free_beam(PIN, MOST_SHAPES).omega[1:]:
        assert determinant(omega * (1 - 1e-8)) * determinant(omega * (1 + 1e-8)) < 0.0


def test_shapes_have_no_part_in_the_shift_nor_in_each_other():
    """Shapes are free of the shift and of each other, with masses by a separate quadrature.

    The masses include displacement w and rotation of sections. Tilt has m (L^2/12 + (R^2 + r^2)/4)
    about a diameter.
    """
    beam = free_beam(PIN, 7)
    points, weights = np.polynomial.legendre.leggauss(80)
    value = beam_at(beam, points * PIN.length / 2)
    assert np.abs(weights @ value).max() < 1e-10
    shapes = beam_shapes(beam)
    about = PIN.mass * (PIN.length**2 / 12 + (PIN.radius**2 + PIN.bore_radius**2) / 4)
    assert 1 / shapes.slope[0] ** 2 == pytest.approx(about, rel=1e-12)
    assert shapes.slope[1:].tolist() == [0.0] * 6
    # of shift: no slope; of a bent shape the middle lies away from the ends
    assert abs(shapes.sag[0]) < 1e-12 and abs(shapes.sag[1]) > 1.0
    assert spin_inertia(PIN) == pytest.approx(0.5 * (0.018**2 + 0.0094**2) / 2, rel=1e-12)


def sag_of_even_loads(pin):
    """Return the height of the pin's middle above its ends under 1 N, by the cantilever formula.

    The load is even, upwards along the eye and downwards along both bosses. Half of the pin is a
    cantilever from the middle, with int q (z^2 (3 a - z)/(6 E I) + z/(kappa G A)) dz.
    """
    of = section(pin)
    a = pin.length / 2

    def tip(q, begin, end):
        def at(z):
            return (a * z**3 - z**4 / 4) / (6 * of.bending) + z**2 / 2 / of.shear

        return q * (at(end) - at(begin))

    return tip(0.5 / BOSS, EYE / 2, a) - tip(1 / EYE, 0.0, EYE / 2)


@pytest.mark.parametrize(("shapes", "error"), [(2, 6e-2), (4, 1.2e-2), (MOST_SHAPES, 5e-3)])
def test_deflection_under_eye_and_bosses_by_number_of_shapes(shapes, error):
    """Even loads against the cantilever's formula: what shapes left out would do."""
    beam = free_beam(PIN, shapes)
    points, weights = np.polynomial.legendre.leggauss(200)

    def push(begin, end):
        z = (begin + end) / 2 + (end - begin) / 2 * points
        return weights @ beam_at(beam, z) / 2

    outer = EYE / 2 + BOSS
    force = push(-EYE / 2, EYE / 2) - push(EYE / 2, outer) / 2 - push(-outer, -EYE / 2) / 2
    sag = beam_shapes(beam).sag[1:] @ (force[1:] / beam.omega[1:] ** 2)
    assert sag == pytest.approx(sag_of_even_loads(PIN), rel=error)


def test_gap_and_forces_of_a_leaning_pin_by_hand():
    """Four cells around and two rows, in a shell turned by 90 deg, give gap and forces by hand.

    One shape, -2 at the first row and 1 at the second, moves by 3 um upwards in space. This is
    along the shell's +x.
    """
    axis = np.array([[-2.0], [1.0]])
    surface = pin_surface(0.02, 10e-6, (4, 2), axis=axis)
    axes = turned(np.pi / 2)
    up = np.array([[0.0, 3e-6]])
    gap = opening_of(surface, np.zeros(2), up @ axes)
    np.testing.assert_allclose(gap[:, 0], [6e-6, 0, -6e-6, 0], atol=1e-20)
    np.testing.assert_allclose(gap[:, 1], [-3e-6, 0, 3e-6, 0], atol=1e-20)
    # 5 N in the first row push the pin along the shell's -x, downwards; 2 N of friction in the
    # second along its +y, to the left
    push, drag = np.zeros((4, 2)), np.zeros((4, 2))
    push[0, 0], drag[0, 1] = 5.0, 2.0
    forces = PinForces(push, drag)
    found = resultants_on(surface, forces, np.zeros(2), axes, up)
    np.testing.assert_allclose(found.force, [-2.0, -5.0], atol=1e-15)
    np.testing.assert_allclose(found.on_shapes, [[-2.0, 10.0]], atol=1e-14)
    assert found.on_shell == pytest.approx(-0.04, rel=1e-14)
    # the second row stands 3 um above: its 2 N to the left turn the pin by +6e-6 about the shell's
    # axis, and against it about its own
    assert found.on_pin == pytest.approx(0.04 - 6e-6, rel=1e-12)
    # rising by 0.1 m/s: pressure closes nothing but the first row, whose pin comes down at 0.2 m/s
    rising = ModeMotion(up @ axes, np.array([[0.0, 0.1]]) @ axes)
    none, rigid = np.zeros(2), (yielded(surface, np.zeros(0)), np.zeros(0))
    power, _ = power_on_grid(surface, forces, none, none, 0.0, *rigid, rising)
    assert power == pytest.approx(5.0 * 0.2, rel=1e-12)
    # turning by 30 rad/s, the friction's arm is shorter by those 3 um
    power, _ = power_on_grid(
        surface, forces, none, none, 30.0, *rigid, ModeMotion(up @ axes, 0 * up)
    )
    assert power == pytest.approx(2.0 * (0.02 - 3e-6) * 30.0, rel=1e-12)


def test_eigenvalues_are_numpys():
    """A symmetric matrix with a double eigenvalue, and one whose entries span 16 decades."""
    turn, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((6, 6)))
    double = turn * [-3.0, 1.0, 1.0, 2.0, 5.0, 8.0] @ turn.T
    scale = 10.0 ** np.arange(0, 12, 2)
    for matrix in (double, scale[:, None] * (np.eye(6) + 0.1) * scale):
        values, vectors = symmetric_eigen(matrix)
        size = np.abs(matrix).max()
        np.testing.assert_allclose(values, np.linalg.eigvalsh(matrix), atol=1e-14 * size)
        np.testing.assert_allclose(matrix @ vectors, vectors * values, atol=1e-14 * size)
        np.testing.assert_allclose(vectors.T @ vectors, np.eye(6), atol=1e-14)


def test_a_relieved_shell_by_hand():
    """Wider by 8 um at its ends, four rows: at 3/4 and 1/4 of the way to them, 4.5 and 0.5 um."""
    plain, wide = bending_model(2), bending_model(2, boss_relief=8e-6)
    inputs = rough_inputs(plain, 3)
    gaps = []
    for model in (plain, wide):
        state, _ = model.start(0.3, 2e-6, 1e-4, inputs)
        _, out = model.advance(state, inputs, STEP)
        gaps.append(out)
    for name in ("boss_left", "boss_right"):
        more = gaps[1][f"{name}.film_thickness"] - gaps[0][f"{name}.film_thickness"]
        wanted = np.array([4.5e-6, 0.5e-6, 0.5e-6, 4.5e-6])
        np.testing.assert_allclose(more, np.tile(wanted, (PIN_GRID[0], 1)), atol=1e-15)
    assert np.array_equal(*(one["small_end.film_thickness"] for one in gaps))


def standing(model, stiffness, steps=15, gas=6e5, step=2e-4):
    """Springs of an engine at rest after some steps, and its outputs."""
    springs = Springs(model, stiffness, by_row=True)
    *_, out = springs.run(steps, gas, 0.0, (0.3, 0.0, 0.0), step)
    return springs, out


def rows_of(springs):
    """Force on the pin by row along y [N], and z of the rows [m], film by film."""
    up, z = [], []
    model = springs.model
    for one, surface, shell in zip(
        springs.inputs(springs.forces).pins, model.pins, shells_of(model)
    ):
        up.append(-(shell.axes @ surface.outward @ one.pressure)[1])
        z.append(surface.axis[:, 0] / model.model.parts.shapes.slope[0])
    return up, z


def test_a_lopsided_pin_tilts_by_the_angle_of_its_springs():
    """With a left boss twice as stiff as the right one, the pin tilts until the moments cancel.

    By hand, tilt = B S_1/(S_0 (S_2 + S_e) - S_1^2). B is the force of the bosses, S_n = sum K_row
    z^n over the bosses and S_e = sum K_row z^2 over the eye. Each of four rows has a quarter
    of the stiffness of its boss or eye. The residual oscillation of the piston turns the pin by
    2e-5 of the tilt.
    """
    stiff = 4e8, 2e8, 5e8
    springs, out = standing(bending_model(1, CRITICAL), stiff)
    up, z = rows_of(springs)
    bosses = up[0].sum() + up[1].sum()
    left, right = (np.array(one) for one in z[:2])
    np.testing.assert_allclose(right, EYE / 2 + BOSS * (np.arange(4) + 0.5) / 4, rtol=1e-12)
    np.testing.assert_allclose(left, -right[::-1], rtol=1e-12)
    moments = [stiff[0] / 4 * np.sum(left**n) + stiff[1] / 4 * np.sum(right**n) for n in range(3)]
    of_eye = stiff[2] / 4 * np.sum(np.array(z[2]) ** 2)
    S0, S1, S2 = moments
    wanted = bosses * S1 / (S0 * (S2 + of_eye) - S1**2)
    assert abs(wanted) > 1e-5
    assert out["pin_tilt_y"] == pytest.approx(wanted, rel=1e-4)


def test_a_pin_on_soft_springs_bends_as_under_even_loads():
    """On springs so soft that bending hardly shifts their load, the cantilever formula holds.

    Loads act at the middles of rows. This misses a share 1/n^2 of each film's own part, 1 % for
    four rows. Six shapes miss 1 % more.
    """
    model = bending_model(8, CRITICAL)
    springs, out = standing(model, (2e6, 2e6, 4e6), steps=10, gas=2e5, step=5e-3)
    up, _ = rows_of(springs)
    eye = up[2].sum()
    assert eye > 1e3
    assert np.ptp(up[2]) < 2e-2 * abs(up[2]).mean()
    assert out["pin_bending_y"] == pytest.approx(eye * sag_of_even_loads(PIN), rel=2.5e-2)
    assert abs(out["pin_tilt_y"]) < 1e-9
    # what the pin stores is half the work of its load, through the displacement of its rows
    bent = shapes_of(model.chain.elements, model._last.now.position, 0)
    pairs = zip(springs.inputs(springs.forces).pins, model.pins, shells_of(model))
    rows = [-(shell.axes @ surface.outward @ one.pressure).T for one, surface, shell in pairs]
    ways = [surface.axis @ bent for surface in model.pins]
    work = sum(np.sum(force * way) for force, way in zip(rows, ways)) / 2
    assert out["elastic_energy"] == pytest.approx(work, rel=1e-5)


def test_what_a_pin_cannot_be_is_told():
    wrong = dataclasses.replace(AXIS, pin_bore_radius=18e-3, pin_length=85e-3)
    told = faults(bodies(), bending_options(3), PARAMETERS, [wrong])
    assert told == [
        "pin_bore_radius: expected less than the radius of the pin, 18 mm, got 18 mm",
        "pin_length: expected 0 or at least the length of all films, 86 mm, got 85 mm",
    ]
    fine = dataclasses.replace(AXIS, pin_length=86e-3)
    assert faults(bodies(), bending_options(3), PARAMETERS, [fine]) == []
