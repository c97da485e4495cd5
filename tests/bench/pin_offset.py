"""Error of `pin_offset` without a new mesh (Eq. (J45)), against a mesh with moved bosses and bores.

With `pin_offset`, the pin bores of the mesh keep their position.

1. Static deflection of the skirt under gas on the crown and under single patches of pressure, with
   the pin bores held. The distance of the two meshes is divided by the largest deflection of the
   load.
2. A short run of `fired_motorcycle` with either mesh, from the start to 100 deg after firing top
   dead centre. The root mean square of the distance is divided by the range of each curve. The
   table also shows the change that the offset itself makes.

Run: python tests/bench/pin_offset.py [OFFSET in mm, default 0.5] [--run]
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import lzma
import sys
import tempfile
from pathlib import Path

import meshio
import numpy as np

import piston_cosim as pc
from piston_cosim.fmu_mfbd.finite_elements.faces import face_load
from piston_cosim.fmu_mfbd.finite_elements.solver import factorise
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.options import read_options
from piston_cosim.fmu_mfbd.reduction.reduce import ends, film_surface, full_model, read_body
from piston_cosim.fmu_mfbd.reduction.ties import held_piston
from piston_cosim.master.case.reading import find_case, read_tree

PATH = find_case("fired_motorcycle")
BOSS, REST = 13e-3, 20e-3  # up to here all moves, from here on nothing [m]
SHELL = 30e-3  # beyond this radius points move around the bore's axis, within along x [m]
PATCHES = {  # angle and height of the middle, half widths [deg], [mm]
    "thrust, broad": (90.0, 0.0, 30.0, 10.0),
    "anti-thrust, top edge": (270.0, 12.0, 15.0, 2.0),
    "thrust, lower edge": (90.0, -13.0, 15.0, 2.0),
    "next to the pin hole": (30.0, 0.0, 10.0, 5.0),
}
CURVES = {
    "bodies.lateral_displacement": "lateral displacement",
    "bodies.rocking_angle": "rocking angle",
    "bodies.side_force": "side force",
    "ehd.minimum_film_thickness": "thinnest film",
    "ehd.maximum_pressure": "highest pressure",
    "bodies.kinetic_energy": "kinetic energy across the bore",
}


def moved(points, d):
    """Nodes of a mesh [m] with the bosses moved by d towards thrust; the outside keeps its shape.

    The share of the move falls from 1 at `BOSS` to 0 at `REST`, distances from the pin's axis.
    """
    x, y, z = points.T
    s = np.clip((REST - np.hypot(x, y)) / (REST - BOSS), 0.0, 1.0)
    step = d * s * s * (3.0 - 2.0 * s)
    radius = np.hypot(x, z)
    shell = radius > SHELL
    turned = np.arctan2(x, z) + step / np.maximum(radius, SHELL) * np.sign(z)
    return np.column_stack(
        [
            np.where(shell, radius * np.sin(turned), x + step),
            y,
            np.where(shell, radius * np.cos(turned), z),
        ]
    )


def deflections(tree, folder):
    """Radial deflection of the skirt under each load, (load, cell) [m]."""
    build = read_options(tree["participants"]["bodies"]["build"], folder)
    mesh = read_body(build.piston, lambda text: None)
    _, K, M = full_model(mesh, build.piston, lambda text: None)
    lower, upper = ends(mesh, "skirt", None, None)
    angle, height = cell_centres(*build.grid, lower, upper)
    radial = film_surface(mesh, "skirt", angle, height).reading.radial
    elastic = held_piston(mesh, K, M, build.piston, lambda text: None, factorise)
    gas = face_load(mesh.points, mesh.faces["crown"]).ravel()
    loads = {"gas on the crown": gas}
    for name, (theta, y, wide, high) in PATCHES.items():
        far = (np.degrees(angle) - theta + 180.0) % 360.0 - 180.0
        on = np.outer(np.abs(far) <= wide, np.abs(1e3 * height - y) <= high)
        loads[name] = -(radial.T @ on.ravel().astype(float))
    free = elastic.free
    return {
        name: radial[:, free] @ elastic.solve(load[free, None])[:, 0]
        for name, load in loads.items()
    }


def runs(mesh, offset):
    """Curves of short runs: bosses moved and not, and without an offset."""
    piston = "participants.bodies.build.piston"
    changes = {"time.stop": "460 deg", "record.every": 100000, "native": True}
    out = {}
    for name, change in {
        "moved": {f"{piston}.mesh": str(mesh), f"{piston}.pin_offset": f"{offset} mm"},
        "kept": {f"{piston}.pin_offset": f"{offset} mm"},
        "none": {f"{piston}.pin_offset": "0 mm"},
    }.items():
        results = pc.open_case("fired_motorcycle", changes | change).run().whole
        out[name] = {port: results.series(port).values for port in CURVES}
        out[name]["time"] = results.time
    return out


def main():
    given = [one for one in sys.argv[1:] if one != "--run"]
    offset = float(given[0]) if given else 0.5
    tree = read_tree(PATH)
    piston = tree["participants"]["bodies"]["build"]["piston"]
    piston["pin_offset"] = f"{offset} mm"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "moved.msh"
        kept = deflections(tree, PATH.parent)
        path.write_bytes(lzma.decompress((PATH.parent / piston["mesh"]).read_bytes()))
        mesh = meshio.read(path)
        mesh.points = moved(mesh.points, 1e-3 * offset)
        meshio.write(path, mesh, file_format="gmsh22", binary=True)
        piston["mesh"] = str(path)
        other = deflections(tree, PATH.parent)
        print(f"pin bores kept against moved by {offset} mm: deflection of the skirt")
        for name, one in kept.items():
            size = np.abs(other[name]).max()
            far = np.abs(one - other[name])
            rms = np.sqrt(np.mean(far**2) / np.mean(other[name] ** 2))
            print(f"  {name:24} {rms:8.2%} rms, {far.max() / size:8.2%} largest")
        if "--run" in sys.argv:
            compared(runs(path, offset))


def compared(curves):
    print("run: kept against moved, and no offset against it: rms over the range of the curve")
    moved_run = curves["moved"]
    for port, name in CURVES.items():
        reach = np.ptp(moved_run[port])
        parts = []
        for other in ("kept", "none"):
            one = np.interp(moved_run["time"], curves[other]["time"], curves[other][port])
            parts.append(np.sqrt(np.mean((one - moved_run[port]) ** 2)) / reach)
        print(f"  {name:32} {parts[0]:8.2%} {parts[1]:8.2%}")


if __name__ == "__main__":
    main()
