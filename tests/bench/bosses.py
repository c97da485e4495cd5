"""Static deflection of the bosses and the skirt of `yielding_bosses`, reduced and whole mesh.

1. Boss deflection under known loads, with gas on the crown and inertia in balance with them. It
   compares the reduced body with the unreduced mesh on six supports. The loads are an even half
   turn of pressure, and a cosine over +-30 deg that falls along the pin. If the results file of a
   finished run is given, the pressures of its left boss are added.
2. Deflection of the skirt under a load on its thrust side. The bosses are tied rigidly, or rest on
   a film of growing stiffness around a rigid pin, or on even pressure. Ties of the whole bore of
   the mesh and of the length that bears show the effect of the length.

Run: python tests/bench/bosses.py [RESULTS.h5]
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys

import numpy as np

from piston_cosim.fmu_mfbd.build import boss_films, reduced_bodies
from piston_cosim.fmu_mfbd.finite_elements.element import rigid_motions
from piston_cosim.fmu_mfbd.finite_elements.faces import face_load, surface_matrix
from piston_cosim.fmu_mfbd.finite_elements.solver import factorise
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.geometry.pin import shell_angles
from piston_cosim.fmu_mfbd.options import read_options
from piston_cosim.fmu_mfbd.reduction.bases import Elastic, mean_conditions
from piston_cosim.fmu_mfbd.reduction.bosses import SIDES, boss_readings
from piston_cosim.fmu_mfbd.reduction.reduce import film_surface, full_model, read_body
from piston_cosim.fmu_mfbd.reduction.reduced_body import Anatomy, ReducedPiston, load
from piston_cosim.fmu_mfbd.reduction.ties import held_piston
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.results.file import Results

PATH = find_case("yielding_bosses")
FILM = "left_film"
ALL_AROUND = 24.4e-3
"""Length of each boss that has a bore all around [m]; its outer end is on the round skirt."""


class Whole:
    """The piston's mesh, unreduced: balanced loads and free bodies on six supports."""

    def __init__(self, build):
        mesh = read_body(build.piston, lambda text: None)
        self.mesh, self.K, self.M = full_model(mesh, build.piston, lambda text: None)
        points = self.mesh.points
        self.bosses = boss_readings(self.mesh, points, boss_films(build))
        self.rigid = rigid_motions(points)
        gas = face_load(points, self.mesh.faces["crown"])
        self.gas = gas.ravel() / -gas[:, 1].sum()
        crown = self.mesh.nodes("crown")
        x, _, z = points[crown].T
        east, west, south = crown[x.argmax()], crown[x.argmin()], crown[z.argmax()]
        # x, y, z of one node, y of two more, x of the last: a body held, but not pressed
        supports = [3 * east, 3 * east + 1, 3 * east + 2, 3 * west + 1, 3 * south + 1, 3 * south]
        self.loose = np.setdiff1d(np.arange(len(self.rigid)), supports)
        self.factors = factorise(self.K.tocsr()[self.loose][:, self.loose].tocsc())
        area = surface_matrix(points, self.mesh.faces["pin_bore"])
        self.mean = mean_conditions(points, np.asarray(area.sum(axis=1)).ravel())

    def balanced(self, pressure):
        """Return the nodal forces of balanced forces on the cells of both bosses, shape (2, c, a).

        Gas balances the part of the cells' forces along the cylinder, and inertia balances the
        rest.
        """
        force = self.bosses.outward().T @ np.ravel(pressure)
        force = force + (self.rigid[:, 1] @ force) * self.gas
        inertia = self.rigid.T @ (self.M @ self.rigid)
        return force - self.M @ (self.rigid @ np.linalg.solve(inertia, self.rigid.T @ force))

    def balance_at_bosses(self, force):
        """Balance forces by those that hold the mean motion of the bores (Eq. (J5))."""
        held = np.linalg.solve((self.mean @ self.rigid).T, self.rigid.T @ force)
        return force - self.mean.T @ held

    def free(self, force):
        """Displacement of the whole body from the mean motion of its bores."""
        out = np.zeros(len(force))
        out[self.loose] = self.factors.solve(force[self.loose])
        return out - self.rigid @ np.linalg.solve(self.mean @ self.rigid, self.mean @ out)


def pressed(around):
    """Shapes of pressure around a bore: an even half turn, a cosine over +-30 deg."""
    lift = np.sin(shell_angles(around))
    return lift > 1e-9, np.maximum(lift - np.cos(np.pi / 6), 0.0)


def known_pressures(grid, results):
    """Cells' forces in both bosses by name, the right one mirrored from the left."""
    even, patch = pressed(grid[0])
    loads = {
        "half a turn, even": np.outer(even, np.ones(grid[1])),
        "+-30 deg": np.outer(patch, np.linspace(0.0, 2.0, grid[1])),
    }
    if results:
        pressures = Results(results).dataset(f"{FILM}.pressure")[:]
        for name, at in (
            ("at the highest pressure", pressures.max(axis=(1, 2)).argmax()),
            ("amid the run", len(pressures) // 2 + len(pressures) // 8),
        ):
            loads[f"of the film, {name}"] = pressures[at]
    return {name: np.stack([one, one[:, ::-1]]) for name, one in loads.items()}


def of_bosses(whole, build, tree, results):
    """Table 1."""
    table = tree["participants"]["bodies"]["build"]
    grid = boss_films(build).grid
    loads = {k: whole.balanced(p) for k, p in known_pressures(grid, results).items()}
    reading = whole.bosses.outward()
    exact = {name: reading @ whole.free(force) for name, force in loads.items()}
    print("boss deflection beside the whole mesh: rms over rms, largest over largest")
    for modes, own in ((100, 60), (150, 110), (200, 160)):
        table["piston"]["modes"] = modes
        table["floating_pin"] = table["floating_pin"] | {"boss_modes": own}
        path = reduced_bodies(table, PATH.parent, lambda text: None, True)["piston"]
        shapes = load(Anatomy, path).shapes.reshape(-1, modes)
        omega = load(ReducedPiston, path).omega
        for name, force in loads.items():
            found = reading @ (shapes @ (shapes.T @ force / omega**2))
            error = found - exact[name]
            size = np.linalg.norm(exact[name])
            largest = np.abs(error).max() / np.abs(exact[name]).max()
            print(
                f"{modes:4d} modes, {own:3d} for the bosses  {name:35s}"
                f"{np.linalg.norm(error) / size:9.1e} {largest:9.1e}",
                flush=True,
            )


def of_skirt(whole, build):
    """Print table 2: mean deflection of the skirt under a load on its thrust side.

    The load has no moment about the pin. The deflection is divided by that of a piston whose bosses
    are tied to a rigid pin at every node.
    """
    mesh = whole.mesh
    angle, height = cell_centres(
        *build.grid, *np.sort(mesh.points[mesh.nodes("skirt"), 1])[[0, -1]]
    )
    reading = film_surface(mesh, "skirt", angle, height).reading.radial
    patch = np.maximum(np.cos(angle - np.pi / 2) - np.cos(np.pi / 6), 0.0)
    pressure = np.outer(patch, np.ones(len(height))).ravel()
    about = np.outer(patch, height).ravel()
    turn = reading.T @ np.stack([pressure, about], axis=1)
    moments = whole.rigid[:, 5] @ turn  # about the pin
    pressure = pressure - moments[0] / moments[1] * about
    force = -reading.T @ (pressure / pressure.sum())

    def deflection(moved):
        return float(force @ moved)

    def tied(nodes):
        body = Elastic(whole.K, whole.M, nodes)
        return deflection(body.full(body.solve(force[body.free])[:, None])[:, 0])

    def listed(name, value):
        print(f"{name:45s} {1e9 * value:8.3f} um/kN, {value / rigid - 1:+.1%}", flush=True)

    node = int(mesh.nodes("crown")[mesh.points[mesh.nodes("crown"), 0].argmax()])
    loose = np.setdiff1d(np.arange(len(force)), [3 * node + 1, 3 * node + 2])

    def on_film(bosses, length, stiffness):
        """Deflection on springs across the gap to a pin at rest. The load has no free motion."""
        films = bosses.outward()
        spring = stiffness * 2 * np.pi * bosses.radius * length * len(SIDES) / films.shape[0]
        K = (whole.K + spring * (films.T @ films)).tocsr()[loose][:, loose].tocsc()
        moved = np.zeros(len(force))
        moved[loose] = factorise(K).solve(force[loose])
        # a turn about the pin and a shift along it meet no spring
        for k in (2, 5):
            slack = whole.mean @ moved
            moved = moved - whole.rigid[:, k] * slack[k] / (whole.mean @ whole.rigid[:, k])[k]
        return deflection(moved)

    bore = mesh.nodes("pin_bore")
    depth = np.abs(mesh.points[bore, 2])
    begin, end = depth.min(), depth.max()
    films = boss_films(build)
    rigid = tied(bore)
    print("\nskirt under a load on its thrust side, by that of bosses tied to a rigid pin (RBE2)")
    listed(f"tied, {1e3 * (end - begin):.4g} mm of each boss", rigid)
    listed(f"tied, inner {1e3 * films.length:.4g} mm", tied(bore[depth <= begin + films.length]))
    every = films._replace(length=ALL_AROUND)
    on_all = boss_readings(mesh, mesh.points, every)
    listed(f"film of 1e15 Pa/m, {1e3 * every.length:.4g} mm", on_film(on_all, every.length, 1e15))
    for stiffness in (1e12, 1e13, 1e14, 1e15, 1e16):
        value = on_film(whole.bosses, films.length, stiffness)
        listed(f"film of {stiffness:.0e} Pa/m, inner {1e3 * films.length:.4g} mm", value)
    slides = build.piston.model_copy(update={"tie": "sliding", "boss_length": films.length})
    sliding = held_piston(mesh, whole.K, whole.M, slides, print, factorise)
    listed(f"sliding, inner {1e3 * films.length:.4g} mm", deflection(sliding.solve(force)))
    listed(
        "mean motion of the bosses (RBE3)", deflection(whole.free(whole.balance_at_bosses(force)))
    )


def main():
    """Both tables."""
    tree = read_tree(PATH)
    build = read_options(tree["participants"]["bodies"]["build"], PATH.parent)
    whole = Whole(build)
    of_skirt(whole, build)
    of_bosses(whole, build, tree, sys.argv[1] if len(sys.argv) > 1 else None)


if __name__ == "__main__":
    main()
