"""What modal bases leave out of the deflection under the film of a run, by full-mesh statics.

python tests/bench/slow/film_truncation.py [RESULTS.h5 [CASE]]

Default: results/numerical_example/flexible.h5 of `piston-cosim run numerical_example`. For each
basis and each recorded instant the deflection of the reduced body is compared with that of the
whole mesh. `check` is what the run itself estimates by Eqs. (J17) and (J34).
"""

import itertools
import sys
from typing import NamedTuple

import numpy as np

from piston_cosim.fmu_mfbd.body_options import Block, Piston
from piston_cosim.fmu_mfbd.finite_elements.solver import factorise
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres, film_rows
from piston_cosim.fmu_mfbd.options import read_options
from piston_cosim.fmu_mfbd.reduction.bases import Elastic
from piston_cosim.fmu_mfbd.reduction.film_loads import (
    FilmLoads,
    on_rows,
    on_stations,
    recorded_film_thickness,
    recorded_loads,
)
from piston_cosim.fmu_mfbd.reduction.interpolation import SurfaceReading
from piston_cosim.fmu_mfbd.reduction.reduce import (
    ends,
    film_surface,
    full_model,
    read_body,
    reduce_block,
    reduce_piston,
)
from piston_cosim.fmu_mfbd.reduction.truncation import (
    StaticModes,
    share_of_film,
    static_modes,
    truncation,
)
from piston_cosim.master.case.reading import find_case, read_tree

RUN = "results/numerical_example/flexible.h5"
BASES = {
    "smooth_pressure_modes": (20, 40, 60, 80, 120, 140, 200),
    "pressure_modes": (60, 120),
    "craig_bampton": (60,),
    "characteristic_constraint_modes": (60,),
}
SHIPPED = 80, 140
"""Modes of piston and block in the case."""
COUNTED = 0.1
"""Share of the largest deflection: points and instants with less are not compared."""
PATCHES = {  # angles [deg], height from the middle over the length, widths [deg] and [m]
    "broad": ((90,), 0.0, 25, 6e-3),
    "low": ((90,), -0.35, 20, 3e-3),
    "edge": ((135,), 0.2, 10, 3e-3),
    "edges": ((45, 135), 0.0, 10, 4e-3),
    "narrow": ((90,), 0.1, 6, 2e-3),
    "pin": ((0,), -0.2, 20, 5e-3),
}
"""Single Gaussian loads of 1 kN."""


class Surface(NamedTuple):
    """Surface of a body on its whole mesh: elastic body, its reading, and film loads.

    The surface is read, and loaded, at the grid's angles [rad] and heights [m].
    """

    elastic: Elastic
    reading: SurfaceReading
    angle: np.ndarray
    height: np.ndarray
    film: FilmLoads


def whole_surface(options: Piston | Block, grid, film: FilmLoads, height: np.ndarray) -> Surface:
    """Return the surface of a body with its whole mesh."""
    held, surface = ("pin_bore", "skirt") if isinstance(options, Piston) else ("bolts", "bore")
    mesh = read_body(options, print)
    _, K, M = full_model(mesh, options, print)
    angle, _ = cell_centres(grid[0], 1, 0.0, 1.0)
    elastic = Elastic(K, M, mesh.nodes(held))
    reading = film_surface(mesh, surface, angle, height).reading
    reading = SurfaceReading(*(one[:, elastic.free].tocsr() for one in reading))
    return Surface(elastic, reading, angle, height, film)


def patches(angle: np.ndarray, height: np.ndarray) -> FilmLoads:
    """Return the loads `PATCHES`."""
    middle, length = np.mean(height[[0, -1]]), np.ptp(height)
    loads = []
    for angles, place, around, along in PATCHES.values():
        load = np.zeros((len(angle), len(height)))
        for one in np.radians(angles):
            apart = np.remainder(angle - one + np.pi, 2 * np.pi) - np.pi
            far = (height - middle - place * length) / along
            bump = np.exp(-((apart / np.radians(around)) ** 2) / 2)[:, None] * np.exp(-(far**2) / 2)
            load += 1e3 / len(angles) * bump / bump.sum()
        loads.append(load)
    return FilmLoads(np.array(loads), np.zeros((len(loads), *load.shape)))


def answers(surface: Surface, film: FilmLoads) -> np.ndarray:
    """Return the radial deflection of the whole mesh, (m, points)."""
    pressure, friction = (np.reshape(force, (len(force), -1)) for force in film)
    radial, axial = surface.reading
    out = []
    for first in range(0, len(pressure), 64):
        part = slice(first, first + 64)
        load = radial.T @ pressure[part].T - axial.T @ friction[part].T
        out.append(radial @ surface.elastic.solve(load))
    return np.hstack(out).T


def modal_answers(modes: StaticModes, film: FilmLoads) -> np.ndarray:
    """Return the radial deflection of a reduced body, (m, points)."""
    pressure, friction = (np.reshape(force, (len(force), -1)) for force in film)
    return (pressure @ modes.radial - friction @ modes.axial) / modes.omega**2 @ modes.radial.T


class Kept:
    """Factorises each matrix once, for all bases."""

    def __init__(self):
        self.known = {}

    def __call__(self, K):
        key = K.shape, K.nnz, float(abs(K).sum())
        if key not in self.known:
            self.known[key] = factorise(K)
        return self.known[key]


def rms(values, axis):
    """Return the root mean square."""
    return np.sqrt(np.mean(values**2, axis=axis))


def report(name, basis, reduced, surface, whole, single):
    """Print one basis of one body; return its missing deflection by the mesh and by the check."""
    modes = static_modes(reduced.body)
    missing = whole - modal_answers(modes, surface.film)
    instants, lost = rms(whole, 1), rms(missing, 1)
    counted = instants >= COUNTED * instants.max()
    film = patches(surface.angle, surface.height)
    bumps = rms(single - modal_answers(modes, film), 1) / rms(single, 1)
    check = truncation(reduced.left_out, modes, surface.film)
    figures = [
        f"{100 * rms(missing, None) / rms(whole, None):7.3f}",
        f"{100 * (lost[counted] / instants[counted]).max():7.3f}",
        f"{1e6 * np.abs(missing).max():7.4f}",
        f"{100 * check.error:10.3f} {100 * check.largest:7.3f}   ",
        *(f"{100 * bump:6.2f}" for bump in bumps),
    ]
    print(f"{name:6} {basis:32} {len(modes.omega):3}  {' '.join(figures)}", flush=True)
    return missing, check.missing


def main(results=RUN, case="numerical_example"):
    """Print the tables."""
    path = find_case(case)
    build = read_options(read_tree(path)["participants"]["bodies"]["build"], path.parent)
    loads = recorded_loads(results, build.grid)
    thickness = recorded_film_thickness(results, build.grid)
    skirt = read_body(build.piston, print)
    rows = film_rows(*ends(skirt, "skirt", None, None), build.grid)
    bore = read_body(build.block, print)
    lower, upper = ends(bore, "bore", None, None)
    stations = np.linspace(lower, upper, build.block.stations)
    surfaces = {
        "piston": whole_surface(build.piston, build.grid, loads.film, rows),
        "block": whole_surface(
            build.block, build.grid, on_stations(loads, rows, stations), stations
        ),
    }
    columns = "modes  run %  worst %  point um  check: run, worst %   patches %:"
    print(f"{'body':6} {'basis':32} {columns} {', '.join(PATCHES)}")
    shape = loads.film.pressure.shape
    gaps = {}
    for name, surface in surfaces.items():
        make = reduce_piston if name == "piston" else reduce_block
        whole = answers(surface, surface.film)
        single = answers(surface, patches(surface.angle, surface.height))
        kept = Kept()
        for basis, counts in BASES.items():
            for count in counts:
                options = getattr(build, name).model_copy(update=dict(basis=basis, modes=count))
                reduced = make(options, build.grid, lambda text: None, kept)
                both = report(name, basis, reduced, surface, whole, single)
                if name == "block":
                    both = (
                        on_rows(
                            one.reshape(len(one), shape[1], -1), loads.height_of_A, rows, stations
                        )
                        for one in both
                    )
                gaps[name, basis, count] = [one.reshape(shape) for one in both]
    print("missing gap over film thickness, %: by the mesh, by the check")
    for basis, counts in BASES.items():
        for piston, block in itertools.product(counts, repeat=2):
            if piston == block or (piston, block) == SHIPPED:
                pairs = zip(gaps["piston", basis, piston], gaps["block", basis, block])
                mesh, check = (100 * share_of_film(a + b, thickness) for a, b in pairs)
                print(f"{basis:32} {piston:3} + {block:3}  {mesh:6.3f} {check:6.3f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
