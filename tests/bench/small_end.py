"""Static deflection of the rod's eye of `yielding_bosses`, reduced and by the whole mesh.

1. Deflection of the bore under known loads of 25 kN each, by number of modes. The loads are an even
   half turn of pressure, a cosine over +-30 deg that falls along the pin, and a cosine that bears
   mostly at both ends. Each acts downwards as under gas, and upwards as under inertia. If the
   results file of a finished run of the variant `elastic` is given, its film loads are added.
2. Deflection by the small end's own weight under the rod's largest acceleration, a load that the
   modes do not contain, and the lowest frequencies.

Run: python tests/bench/small_end.py [RESULTS.h5]
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys

import numpy as np
from bosses import pressed

from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled
from piston_cosim.fmu_mfbd.finite_elements.mesh import read_mesh
from piston_cosim.fmu_mfbd.finite_elements.solver import factorise
from piston_cosim.fmu_mfbd.geometry.pin import shell_angles
from piston_cosim.fmu_mfbd.reduction.shell import (
    ShellFilm,
    film_shell,
    held_shell,
    reduce_shell,
)
from piston_cosim.master.case.reading import find_case
from piston_cosim.master.results.file import Results

PATH = find_case("yielding_bosses").parent / "small_end.msh.xz"
STEEL = (206e9, 0.3, 7850.0)
GRID, LENGTH = (72, 8), 20e-3
LOAD = 25e3
ACCELERATION = 6700.0
"""Of the small end at top dead centre, 4000 rpm: 29.75 mm (2 pi 66.7/s)^2 (1 + 29.75/108)."""

FILM = "small_end_film"


class Once:
    """One factorisation for all numbers of modes."""

    def __init__(self):
        self.factors = None

    def __call__(self, matrix):
        """Return the factors of the first matrix, for every matrix."""
        self.factors = self.factors or factorise(matrix)
        return self.factors


def known_pressures(results):
    """Cells' forces in the eye by name."""
    around, along = GRID
    lift = np.sin(shell_angles(around))
    even, patch = pressed(around)
    shapes = {
        "half a turn, even": np.outer(even, np.ones(along)),
        "+-30 deg, falling": np.outer(patch, np.linspace(0.0, 2.0, along)),
        "+-30 deg, at both ends": np.outer(patch, [8.0, 3.0, 1.0, 0.5, 0.5, 1.0, 3.0, 8.0]),
    }
    loads = {}
    for name, up in shapes.items():
        force = up * LOAD / (lift @ up).sum()
        loads[f"{name}, down"] = np.roll(force, around // 2, axis=0)
        loads[f"{name}, up"] = force
    if results:
        pressures = Results(results).dataset(f"{FILM}.pressure")[:]
        highest = pressures.max(axis=(1, 2)).argmax()
        most = np.abs(np.einsum("tij,i->t", pressures, lift)).argmax()
        cell = 2 * np.pi * 8.5e-3 / around * LENGTH / along
        loads["the film, highest pressure"] = pressures[highest] * cell
        loads["the film, largest load"] = pressures[most] * cell
    return loads


def main():
    """Both tables."""
    mesh = read_mesh(PATH, dict.fromkeys(("eye", "cut")))
    body = assembled(mesh, *STEEL)
    factors = Once()
    elastic = held_shell(body, factors)
    (side,) = film_shell(mesh, ShellFilm(GRID, LENGTH, 1)).sides
    reading = side.outward[:, elastic.free].tocsr()
    loads = known_pressures(sys.argv[1] if len(sys.argv) > 1 else None)
    exact = {name: reading @ elastic.solve(reading.T @ p.ravel()) for name, p in loads.items()}
    print("bore's deflection beside the whole mesh: largest; rms over rms, largest over largest")
    for count in (20, 40, 60, 100, 200):
        reduced = reduce_shell(body, ShellFilm(GRID, LENGTH, count), lambda text: None, factors)
        outward = reduced.outward.reshape(-1, count)
        for name, load in loads.items():
            found = outward @ (outward.T @ load.ravel() / reduced.omega**2)
            error, whole = found - exact[name], np.abs(exact[name]).max()
            rms = np.linalg.norm(error) / np.linalg.norm(exact[name])
            print(
                f"{count:4d} modes  {name:30s}{1e6 * whole:8.1f} um{rms:9.1e}"
                f"{np.abs(error).max() / whole:9.1e}",
                flush=True,
            )
    down = np.tile([0.0, -ACCELERATION, 0.0], len(mesh.points))
    weight = (body.M @ down)[elastic.free]
    fallen = reading @ elastic.solve(weight)
    low, *_ = reduced.omega / (2 * np.pi)
    print(f"\nsmall end from its cut on: {body.M.sum() / 3 * 1e3:.1f} g, from {low:.0f} Hz on")
    print(f"its own weight at {ACCELERATION:.0f} m/s2: bore by {1e6 * np.abs(fallen).max():.2f} um")


if __name__ == "__main__":
    main()
