"""The eye of an elastic rod.

Thick and thin rings follow closed forms, and modes are compared with the whole mesh. Other
tests cover rows by hand, energies and rejected inputs.
"""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.model_faults import faults
from piston_cosim.fmu_mfbd.dynamics.pin_shells import shell_modes_of
from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled
from piston_cosim.fmu_mfbd.finite_elements.mesh import MeshFault
from piston_cosim.fmu_mfbd.finite_elements.ring import Ring, ring_mesh
from piston_cosim.fmu_mfbd.geometry.pin import (
    PinForces,
    diameters,
)
from piston_cosim.fmu_mfbd.mechanism.cylinder import EYE
from piston_cosim.fmu_mfbd.reduction.reduced_body import ShellFilm
from piston_cosim.fmu_mfbd.reduction.shell import (
    elastic_shell_modes,
    film_shell,
    held_shell,
    reduce_shell,
)

from .chains import matrix_of
from .conftest import mean_held
from .pin_models import (
    PARAMETERS,
    PIN_GRID,
    SHELL_MODES,
    bodies,
    eye_model,
    options,
    rough_inputs,
    small_end,
)

YOUNG, POISSON, DENSITY = 206e9, 0.3, 7850.0
STEEL = (YOUNG, POISSON, DENSITY)
HALF = 10e-3


def ring(inner, outer, cells, half=HALF):
    """Return a ring about z, whose cut is a patch of 50 deg at the bottom of its outside."""
    mesh = ring_mesh(Ring(inner, outer, 2 * half, np.radians(50.2), cells))
    faces = {"eye": mesh.faces["bore"], "cut": mesh.faces["held"]}
    return dataclasses.replace(mesh, points=mesh.points * [-1.0, -1.0, 1.0], faces=faces)


def answer(reduced, force):
    """Outward displacement under forces on the cells, (c, a), by the modes."""
    outward = reduced.outward
    push = np.einsum("ij,ijk->k", force, outward)
    return outward @ (push / reduced.omega**2)


def test_two_opposite_loads_flatten_a_thin_ring_as_timoshenko_says():
    """Two forces W apart along the diameter at 50 deg follow Roark's table 9.2, case 1.

    With a = I/(A R^2), b = 1.2 E I/(G A R^2) and k = 1 - a, the diameter changes in two directions.
    It grows by W R^3/(E I) ((k + b) pi/4 - 2 k^2/pi) along the load. It shrinks by W R^3/(E I) (2
    k^2/pi - k/2) across it. Six Fourier orders of a load on one cell miss 0.3 %, faces next to
    cells as much. Curvature of a section (t/R = 0.1) misses less than 1 %.
    """
    mean, thick, load = 20e-3, 2e-3, 500.0
    body = assembled(ring(mean - thick / 2, mean + thick / 2, (72, 1, 2), 2e-3), *STEEL)
    film = ShellFilm((72, 4), 4e-3, 40)
    reduced = elastic_shell_modes(mean_held(body, "eye"), film_shell(body.mesh, film), film)
    assert reduced.radius == pytest.approx(mean - thick / 2, rel=1e-12)
    force = np.zeros((72, 4))
    force[[10, 46]] = load / 4
    opened = answer(reduced, force).mean(axis=1)
    second, area = 4e-3 * thick**3 / 12, 4e-3 * thick
    a = second / area / mean**2
    b, k = 1.2 * 2 * (1 + POISSON) * a, 1 - a
    unit = load * mean**3 / (YOUNG * second)
    along = unit * ((k + b) * np.pi / 4 - 2 * k**2 / np.pi)
    across = -unit * (2 * k**2 / np.pi - k / 2)
    assert opened[10] + opened[46] == pytest.approx(along, rel=1.5e-2)
    assert opened[28] + opened[64] == pytest.approx(across, rel=1.5e-2)


@pytest.fixture(scope="module")
def eye():
    """Return a thick ring held at the bottom."""
    return assembled(ring(8e-3, 12e-3, (24, 2, 6)), *STEEL)


def test_friction_on_an_eye_turns_it_against_its_shank(eye):
    """By Eq. (G6) friction of 1 N on every cell moves the bore against the pin's direction.

    The force is -f along t. The displacement is that of the whole mesh. 60 modes chosen for
    pressure miss 5 %.
    """
    film = ShellFilm((36, 6), 18e-3, 60)
    reduced = reduce_shell(eye, film, lambda text: None)
    push = -reduced.onward.sum(axis=(0, 1))
    found = (reduced.onward @ (push / reduced.omega**2)).mean()
    elastic = held_shell(eye)
    (side,) = film_shell(eye.mesh, film).sides
    onward = side.onward[:, elastic.free]
    wanted = (onward @ elastic.solve(-onward.T @ np.ones(36 * 6))).mean()
    assert wanted < 0.0
    assert found == pytest.approx(wanted, rel=7e-2)


def test_an_eye_that_is_not_where_its_film_is_and_a_cut_that_holds_nothing_are_told(eye):
    with pytest.raises(MeshFault, match="small_end_length = 22 mm about z = 0, got z = -10 to 10"):
        film_shell(eye.mesh, ShellFilm((36, 5), 22e-3, 1))
    beside = dataclasses.replace(eye.mesh, points=eye.mesh.points + [1e-3, 0.0, 0.0])
    with pytest.raises(MeshFault, match="beside a cylinder about the pin's axis"):
        film_shell(beside, ShellFilm((36, 5), 16e-3, 1))
    turned = dataclasses.replace(eye.mesh, points=eye.mesh.points * [-1.0, -1.0, 1.0])
    with pytest.raises(MeshFault, match="'cut': expected y < -8 mm, below the eye, got y = 12 mm"):
        film_shell(turned, ShellFilm((36, 5), 16e-3, 1))
    point = eye.mesh.faces | {"cut": np.tile(eye.mesh.faces["cut"][0, :1], (1, 6))}
    loose = eye._replace(mesh=dataclasses.replace(eye.mesh, faces=point))
    with pytest.raises(
        MeshFault, match="'cut': expected at least three nodes, not all on one line, got"
    ):
        held_shell(loose)


def test_widening_of_an_eye_by_hand():
    """Eq. (H13): 3 cos 2a + 2 + z over 4 mm on eight cells and six, where x and y are lines."""
    a = 2 * np.pi * np.arange(8) / 8
    rows = np.array([-2.5, -1.5, -0.5, 0.5, 1.5, 2.5])
    opened = 3 * np.cos(2 * a)[:, None] + 2 + rows
    np.testing.assert_allclose(diameters(opened), [10.0, -2.0], rtol=1e-12)
    # six cells: +y lies amid two lines, at 60 and 120 deg, where cos a is 1/2 and -1/2
    six = np.cos(2 * np.pi * np.arange(6) / 6)[:, None] + np.array([0.0, 1.0, 5.0])
    np.testing.assert_allclose(diameters(six), [2.0, 2.0], rtol=1e-12)


def test_the_account_holds_the_modes_of_an_eye():
    """The energy balance includes the modes of an eye at rest under a steady pressure.

    There is no damping and there are three steps of 1 us. Modal velocity is force times time, minus
    (omega t)^2/2, which is at most 4 %. Kinetic energy is 3/4 of the film's work, as backward Euler
    has the displacement t/2 + h/2 instead of t/2.
    """
    free_of = dataclasses.replace(PARAMETERS, damping_ratio=0.0, high_frequency_damping_ratio=0.0)
    model = eye_model(parameters=free_of)
    none = PinForces(np.zeros(PIN_GRID), np.zeros(PIN_GRID))
    pressed = PinForces(np.random.default_rng(4).random(PIN_GRID), np.zeros(PIN_GRID))
    at_rest = rough_inputs(model, 1, 0.0, gas=0.0)
    given = dataclasses.replace(at_rest, crank_speed=0.0, pins=(none, none, pressed))
    state, _ = model.start(0.0, 0.0, 0.0, given)
    work = 0.0
    for _ in range(3):
        before = state.position
        state, out = model.advance(state, given, 1e-6)
        push = np.einsum("ij,ijk->k", pressed.pressure, small_end().outward)
        ways = (shell_modes_of(model.chain.elements, one, EYE) for one in (state.position, before))
        work += push @ np.subtract(*ways)
    found = shell_modes_of(model.chain.elements, state.velocity, EYE)
    np.testing.assert_allclose(found, 3e-6 * push, rtol=6e-2)
    still = state.velocity.copy()
    still[-SHELL_MODES:] = 0.0
    rest = still @ matrix_of(model.model.parts.inertia) @ still / 2
    assert out["kinetic_energy"] - rest == pytest.approx(found @ found / 2, rel=1e-9)
    assert out["elastic_energy"] < 0.1 * out["kinetic_energy"]
    assert found @ found / 2 == pytest.approx(0.75 * work, rel=0.1)


def test_a_pin_that_is_not_the_eyes_is_told():
    yielding = bodies()._replace(shells={"small_end": small_end()})
    wide = dataclasses.replace(PARAMETERS, pin_radius=18.5e-3)
    (told,) = faults(yielding, options(True), wide)
    assert told == ("pin_radius: expected within 2 % of the eye in its mesh, 18 mm, got 18.5 mm")
    assert faults(yielding, options(True), PARAMETERS) == []
