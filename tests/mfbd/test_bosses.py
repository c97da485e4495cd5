"""Pin bosses of a mesh as film surfaces.

Tests cover reading, Lame's tube, modes compared with the whole mesh and rejected meshes.
"""

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.body_options import Piston
from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled
from piston_cosim.fmu_mfbd.finite_elements.mesh import Mesh, MeshFault
from piston_cosim.fmu_mfbd.finite_elements.ring import Ring, ring_mesh
from piston_cosim.fmu_mfbd.geometry.pin import shell_angles
from piston_cosim.fmu_mfbd.options import _faults_of_bosses as bosses_faults
from piston_cosim.fmu_mfbd.reduction.bosses import boss_readings, with_pressure_modes
from piston_cosim.fmu_mfbd.reduction.film_loads import FilmLoads, RecordedLoads, Training
from piston_cosim.fmu_mfbd.reduction.reduce import reduce_piston
from piston_cosim.fmu_mfbd.reduction.reduced_body import ShellFilm
from piston_cosim.models import MODELS

from .conftest import mean_held, quiet

INNER, OUTER, HALF = 8e-3, 14e-3, 20e-3
YOUNG, POISSON = 75e9, 0.33
GRID = (48, 8)
SHEET = {"density": "2680 kg/m^3", "young": "78 GPa", "poisson": 0.33}


@pytest.fixture(scope="module")
def pipe():
    """Return a thick pipe about z with a wide gap in the middle of its bore: two bosses."""
    mesh = ring_mesh(Ring(INNER, OUTER, 2 * HALF, np.pi, (32, 1, 10)))
    bore = mesh.faces["bore"]
    own = np.abs(mesh.points[bore[:, :3], 2].mean(axis=1)) > 4e-3
    return Mesh(mesh.points, mesh.tets, {"pin_bore": bore[own]})


def test_displacements_that_are_known_are_read(pipe):
    """A shift, a rotation about the pin and a widening are read as computed by hand.

    Linear fields are exact on ten-node faces, except for the curvature of a face between a cell and
    the mesh. This error is at most (pi/64)^4/8.
    """
    films = ShellFilm(GRID, 16e-3, 0)
    found = boss_readings(pipe, pipe.points, films)
    assert found.radius == pytest.approx(INNER, rel=1e-12)
    np.testing.assert_allclose(found.sides[1].stations, 4e-3 + 2e-3 * (np.arange(8) + 0.5))
    np.testing.assert_allclose(found.sides[0].stations, -found.sides[1].stations[::-1])
    a = np.repeat(shell_angles(GRID[0]), GRID[1])
    x, y, z = pipe.points.T
    none = 0 * x
    for side in found.sides:
        height = np.tile(side.stations, GRID[0])
        shift = np.stack([3.0 + none, -2.0 * z, 9.0 + none], axis=1).ravel()
        np.testing.assert_allclose(
            side.outward @ shift, 3 * np.cos(a) - 2 * height * np.sin(a), atol=1e-12
        )
        np.testing.assert_allclose(
            side.onward @ shift, -3 * np.sin(a) - 2 * height * np.cos(a), atol=1e-12
        )
        turn = np.stack([-y, x, none], axis=1).ravel()
        np.testing.assert_allclose(side.onward @ turn, INNER, rtol=1e-4)
        np.testing.assert_allclose(side.outward @ turn, 0.0, atol=3e-4 * INNER)
        wide = np.stack([x, y, none], axis=1).ravel()
        np.testing.assert_allclose(side.outward @ wide, INNER, rtol=1e-4)
    # the pin off the mesh's origin: the same about its own axis
    moved = Mesh(pipe.points + [2e-3, 0.0, 0.0], pipe.tets, pipe.faces)
    again = boss_readings(moved, moved.points - [2e-3, 0.0, 0.0], films)
    assert abs(again.sides[0].outward - found.sides[0].outward).max() < 1e-9


def test_modes_for_bosses_answer_smooth_pressure(pipe):
    """The error of 10, 20 and 40 shapes falls with each doubling.

    The pressure is a half-sine in both bosses, around and along them.
    """
    films = ShellFilm(GRID, 16e-3, 0)
    found = boss_readings(pipe, pipe.points, films)
    elastic = mean_held(assembled(pipe, YOUNG, POISSON, 1.0), "pin_bore")
    a = shell_angles(GRID[0])
    along = np.sin(np.pi * (np.arange(8) + 0.5) / 8)
    pressure = np.outer(np.maximum(np.sin(a), 0.0) ** 2, along).ravel()
    load = found.outward().T @ np.append(pressure, pressure)
    whole = found.outward() @ elastic.solve(load)
    missed = []
    for count in (10, 20, 40):
        none = np.empty((len(load), 0))
        shapes = with_pressure_modes(elastic, found, GRID, none, count)
        energy = shapes.T @ (elastic.K @ shapes)
        kept = found.outward() @ (shapes @ np.linalg.solve(energy, shapes.T @ load))
        missed.append(np.linalg.norm(kept - whole) / np.linalg.norm(whole))
    assert missed[2] < 0.02
    assert missed[0] > 2 * missed[1] > 4 * missed[2]


def test_a_film_longer_than_its_boss_and_a_boss_that_is_not_there_are_told(pipe):
    with pytest.raises(MeshFault, match="boss_length = 18 mm begins where it does"):
        boss_readings(pipe, pipe.points, ShellFilm(GRID, 18e-3, 0))
    z = pipe.points[pipe.faces["pin_bore"][:, :3], 2].mean(axis=1)
    one = Mesh(pipe.points, pipe.tets, {"pin_bore": pipe.faces["pin_bore"][z > 0]})
    with pytest.raises(MeshFault, match="'pin_bore': expected faces at z < 0, got none"):
        boss_readings(one, one.points, ShellFilm(GRID, 16e-3, 0))
    beside = pipe.points + [1e-3, 0.0, 0.0]
    with pytest.raises(MeshFault, match="beside a cylinder about the pin's axis"):
        boss_readings(pipe, beside, ShellFilm(GRID, 16e-3, 0))


def test_an_error_needs_boss_modes_with_a_floating_pin():
    """The skirt gets modes by the error, and the bosses get theirs in addition."""
    given = Piston(mesh="a.msh", **SHEET, modes="1 %", tie="rbe3")
    assert bosses_faults(given, 24) == []
    assert bosses_faults(given, 0) == [
        "floating_pin.boss_modes: expected at least 1 with piston.modes, got 0; modes of the skirt "
        "alone miss the deflection of the bosses"
    ]


@pytest.mark.slow
def test_boss_modes_are_added_to_those_of_an_error():
    """The piston of yielding_bosses has the modes of its skirt, and four more for its bosses."""
    mesh = str(MODELS / "fired_motorcycle/piston.msh.xz")
    piston = Piston(mesh=mesh, **SHEET, tie="rbe3", modes="20 %")
    films = None, ShellFilm((24, 4), 16e-3, 4)
    counts = [len(reduce_piston(piston, (16, 12), quiet, bosses=f).body.omega) for f in films]
    assert counts[1] == counts[0] + 4


@pytest.mark.slow
def test_boss_modes_are_added_to_trained_ones():
    """Modes of an earlier run come first; the films in the bosses add four."""
    mesh = str(MODELS / "fired_motorcycle/piston.msh.xz")
    around, along = np.meshgrid(np.linspace(0, 2 * np.pi, 16), np.linspace(0, 1, 12), indexing="ij")
    push = np.array([np.exp(-((around - 2) ** 2)) * along**n for n in range(3)])
    loads = RecordedLoads(FilmLoads(push, 0.0 * push), np.full(3, 0.1))
    prior = Piston(mesh=mesh, **SHEET, tie="rbe3", modes=20)
    basis = {"basis": "trained", "train_on": "run.h5"}
    trained = Piston(mesh=mesh, **SHEET, tie="rbe3", modes=24, **basis)
    training = Training(loads, np.empty(0))
    with_films = reduce_piston(
        trained, (16, 12), quiet, training=training, bosses=ShellFilm((24, 4), 16e-3, 4)
    )
    alone = reduce_piston(prior, (16, 12), quiet)
    added = len(with_films.body.omega) - len(alone.body.omega) - 4
    assert 0 < added <= 12
    assert with_films.bosses.boss_outward.shape[-1] == len(with_films.body.omega)
