"""Steady film of `journal_bearing` at e = 0.8: rigid shell, liner by modes and by its whole mesh.

The whole mesh is solved without modes, and film and liner by fixed-point iteration, without FMUs.

Run: python tests/bench/bearing_shell.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded


import numpy as np

import piston_cosim as pc
from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled
from piston_cosim.fmu_mfbd.finite_elements.ring import Ring, ring_mesh
from piston_cosim.fmu_mfbd.geometry.pin import PinForces
from piston_cosim.fmu_mfbd.reduction.reduced_body import ShellFilm, ShellKind
from piston_cosim.fmu_mfbd.reduction.shell import film_shell, held_shell
from piston_cosim.fmu_mfbd.shell.build import elastic_shell
from piston_cosim.master.case.reading import find_case, read_tree

PATH = find_case("journal_bearing")
BUILD = read_tree(PATH)["variants"]["elastic"]["participants.shell"]["build"]
GRID, LENGTH = (60, 12), 25e-3
RING = Ring(25e-3, 33e-3, LENGTH, 2 * np.pi, (36, 2, 6))
YOUNG, POISSON = 3.6e9, 0.4
SPEED = 100 * np.pi * 25e-3
ECCENTRICITY, PLACE = 0.8, np.radians(305.0)
ANGLE = 2 * np.pi * np.arange(GRID[0]) / GRID[0]


def whole_mesh():
    """Deflection under forces, by the whole mesh."""
    mesh = ring_mesh(RING)
    kind = ShellKind("shell")
    elastic = held_shell(assembled(mesh, YOUNG, POISSON, 1000.0), kind=kind)
    (side,) = film_shell(mesh, ShellFilm(GRID, LENGTH, 1), kind).sides
    out, on = (one[:, elastic.free] for one in (side.outward, side.onward))

    def answer(forces):
        load = out.T @ forces.pressure.ravel() - on.T @ forces.circumferential.ravel()
        return (out @ elastic.solve(load)).reshape(GRID)

    return answer


def settled(film, answer):
    """Load [N], highest pressure [MPa], minimum film and largest deflection [um] in balance."""
    rigid = 40e-6 * (1 - ECCENTRICITY * np.cos(ANGLE - PLACE))[:, None] + np.zeros(GRID)
    opened = np.zeros(GRID)
    change = 1.0
    while change > 1e-10:
        out = film.steady(rigid + opened, circumferential_velocity=SPEED)
        forces = PinForces(out["nodal_pressure_force"], out["nodal_circumferential_force"])
        more = answer(forces) - opened
        opened += 0.2 * more
        change = np.abs(more).max()
    push = forces.pressure.sum(axis=1)
    load = np.hypot(push @ np.cos(ANGLE), push @ np.sin(ANGLE))
    thinnest = (rigid + opened).min()
    return load, out["pressure"].max() / 1e6, 1e6 * thinnest, 1e6 * opened.max()


def main():
    """Print the table."""
    film = pc.Film(
        GRID,
        surface="bearing",
        bore_radius=RING.inside,
        skirt_length=LENGTH,
        viscosity=0.02,
        open_cells=np.loadtxt(PATH.parent / "groove.csv", delimiter=",") == 0,
        opening_supply="own",
        pressure_openings=1e5,
    )
    answers = {"rigid": lambda forces: np.zeros(GRID), "whole mesh": whole_mesh()}
    for modes in (20, 40, 60, 100):
        shell = elastic_shell(BUILD | {"modes": modes}, progress=lambda text: None)
        answers[f"{modes} modes"] = lambda forces, shell=shell: shell.deflection(
            shell.coordinates(forces)
        )
    print(f"{'shell':12s} load [N]  pressure [MPa]  film [um]  deflection [um]")
    for name, answer in answers.items():
        load, pressure, thinnest, opened = settled(film, answer)
        print(f"{name:12s} {load:8.0f} {pressure:15.2f} {thinnest:10.2f} {opened:16.2f}")


if __name__ == "__main__":
    main()
