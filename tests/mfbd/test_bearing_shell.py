"""The elastic shell of a bearing: closed form, whole mesh, work, loads, faults."""

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled
from piston_cosim.fmu_mfbd.finite_elements.mesh import mesh_faults
from piston_cosim.fmu_mfbd.finite_elements.ring import Ring, ring_mesh
from piston_cosim.fmu_mfbd.geometry.pin import PinForces
from piston_cosim.fmu_mfbd.reduction.reduced_body import ShellFilm, ShellKind
from piston_cosim.fmu_mfbd.reduction.shell import film_shell, held_shell
from piston_cosim.fmu_mfbd.shell.build import elastic_shell
from piston_cosim.master.fmi.errors import BadInput

from .conftest import quiet

INSIDE, OUTSIDE, LENGTH = 25e-3, 33e-3, 25e-3
YOUNG, POISSON = 3.6e9, 0.4
GRID = (48, 10)
CELLS = (24, 1, 4)
WHOLE = 2 * np.pi
KIND = ShellKind("shell")


def table(**changed):
    """Build table of the liner of `journal_bearing`, on a coarse mesh."""
    ring = {"inside": "25 mm", "outside": "33 mm", "cells": list(CELLS)}
    usual = {"grid": list(GRID), "length": "25 mm", "young": "3.6 GPa", "poisson": POISSON}
    return usual | {"ring": ring} | changed


@pytest.fixture(scope="module")
def liner():
    return elastic_shell(table(), progress=quiet)


def test_a_ring_has_its_volume_and_its_surfaces():
    """Ten-node faces on both cylinders: 24 around are worth 4e-6 of the volume."""
    mesh = ring_mesh(Ring(INSIDE, OUTSIDE, LENGTH, np.pi / 2, CELLS))
    assert mesh_faults(mesh.points, mesh.tets, "ring") == []
    body = assembled(mesh, YOUNG, POISSON, 1000.0)
    volume = np.pi * (OUTSIDE**2 - INSIDE**2) * LENGTH
    assert body.M.sum() / 3e3 == pytest.approx(volume, rel=1e-5)
    assert len(mesh.faces["bore"]) == 2 * 24 * 4
    x, y, _ = mesh.points[mesh.nodes("held")].T
    np.testing.assert_allclose(np.hypot(x, y), OUTSIDE)
    # 6 of 24 blocks, from 45 to 135 deg
    assert len(mesh.faces["held"]) == 2 * 6 * 4
    assert np.degrees(np.arctan2(y, x)).min() == pytest.approx(45.0)
    assert np.degrees(np.arctan2(y, x)).max() == pytest.approx(135.0)


def test_even_pressure_on_a_bonded_ring_by_closed_form():
    """Displacement follows u = p (R^2/r - r)/(2 (lambda + mu) + 2 mu R^2/r^2) with u(R) = 0.

    With Poisson's ratio 0 the free ends stay plane. 40 modes and 24 blocks around miss 0.1 % of the
    mean and 2 % locally. Forces on points instead of cells miss 19 %.
    """
    shell = elastic_shell(table(poisson=0.0, modes=40), progress=quiet)
    pressure = 4e6
    cell = WHOLE * INSIDE / GRID[0] * LENGTH / GRID[1]
    q = shell.coordinates(PinForces(np.full(GRID, pressure * cell), np.zeros(GRID)))
    opened = shell.deflection(q)
    wanted = pressure * (OUTSIDE**2 / INSIDE - INSIDE) / (YOUNG * (1 + (OUTSIDE / INSIDE) ** 2))
    print(opened.min() / wanted, opened.max() / wanted, opened.mean() / wanted)
    np.testing.assert_allclose(opened, wanted, rtol=3e-2)
    assert opened.mean() == pytest.approx(wanted, rel=3e-3)


def test_modes_answer_a_film_as_the_whole_mesh_does(liner):
    """60 modes miss 5 % of the deflection (rms), most of it under the peak, and 0.7 % of the work.

    The load is pressure and friction of a short bearing with e = 0.8. It is sharper than that of an
    elastic film.
    """
    a = WHOLE * np.arange(GRID[0]) / GRID[0]
    y = (np.arange(GRID[1]) + 0.5) / GRID[1]
    bump = np.maximum(np.sin(a), 0.0) / (1 + 0.8 * np.cos(a)) ** 3
    pressure = 2.0 * bump[:, None] * 4 * y * (1 - y)
    forces = PinForces(pressure, 0.01 / (1 + 0.8 * np.cos(a))[:, None] + np.zeros(GRID))
    found = liner.deflection(liner.coordinates(forces))
    mesh = ring_mesh(Ring(INSIDE, OUTSIDE, LENGTH, WHOLE, CELLS))
    elastic = held_shell(assembled(mesh, YOUNG, POISSON, 1000.0), kind=KIND)
    (side,) = film_shell(mesh, ShellFilm(GRID, LENGTH, 1), KIND).sides
    outward, onward = (one[:, elastic.free] for one in (side.outward, side.onward))
    load = outward.T @ pressure.ravel() - onward.T @ forces.circumferential.ravel()
    wanted = (outward @ elastic.solve(load)).reshape(GRID)
    print(np.linalg.norm(found - wanted) / np.linalg.norm(wanted))
    print(np.sum(pressure * found) / np.sum(pressure * wanted))
    assert np.linalg.norm(found - wanted) < 7e-2 * np.linalg.norm(wanted)
    assert np.sum(pressure * found) == pytest.approx(np.sum(pressure * wanted), rel=1e-2)


def test_work_of_a_film_is_elastic_energy_and_its_force_is_on_the_support(liner):
    rng = np.random.default_rng(5)
    forces = PinForces(100 * rng.random(GRID), 10 * rng.random(GRID))
    q = liner.coordinates(forces)
    modes = liner.surface.modes
    along = (modes.onward @ q).reshape(GRID)
    opened = liner.deflection(q)
    work = np.sum(forces.pressure * opened - forces.circumferential * along) / 2
    assert liner.energy(q) == pytest.approx(work, rel=1e-12)
    a = WHOLE * np.arange(GRID[0]) / GRID[0]
    load = liner.on_support(forces, q)
    push, drag = forces.pressure.sum(axis=1), forces.circumferential.sum(axis=1)
    assert load.force_x == pytest.approx(push @ np.cos(a) + drag @ np.sin(a), rel=1e-12)
    assert load.force_y == pytest.approx(push @ np.sin(a) - drag @ np.cos(a), rel=1e-12)
    slope = (np.roll(opened, -1, axis=0) - np.roll(opened, 1, axis=0)) / (2 * a[1])
    moment = -INSIDE * drag.sum() - np.sum(forces.pressure * slope)
    assert load.moment == pytest.approx(moment, rel=1e-9)


RING = {"inside": "25 mm", "outside": "33 mm"}
FAULTS = {
    "expected either mesh or ring, got neither": {"ring": None},
    "ring.outside: expected more than inside = 0.025 m": {"ring": RING | {"outside": "25 mm"}},
    "ring.held: expected at least one block around, 10 deg": {"ring": RING | {"held": "5 deg"}},
    "ring.cells": {"ring": RING | {"cells": [36, 0, 6]}},
    "young: expected": {"young": "1 kPa"},
    "density: expected one of": {"density": "7850 kg/m^3"},
    "modes: expected at most 14 for 4 x 4 cells, got 60": {"grid": [4, 4]},
    "mesh: expected a file in": {"ring": None, "mesh": "none.msh"},
    "expected a bore under all of length = 40 mm": {
        "length": "40 mm",
        "ring": RING | {"length": "25 mm"},
    },
}


@pytest.mark.parametrize("wanted", FAULTS)
def test_faults_of_a_shell(wanted, tmp_path):
    with pytest.raises(BadInput) as raised:
        elastic_shell(table(**FAULTS[wanted]), tmp_path, progress=quiet)
    assert wanted in "\n".join(raised.value.faults)
