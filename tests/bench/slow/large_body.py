"""A block of about a million degrees of freedom reduced to 60 modes: time and peak memory, in a
process of its own.

    python tests/bench/slow/large_body.py [CELLS_AROUND CELLS_ACROSS CELLS_ALONG]

A cylinder of 56.5 mm bore in a square of 86 mm, 100 mm long, structured in 10-node tetrahedra;
needs the extra `large`. Measured once, on two cores that four sessions shared (load 5 to 7) and
with one load a call of PARDISO: 1 020 240 degrees of freedom, 60 pressure modes in 3465 s, of which
170 s assembly, 1220 s factorisation, the rest 216 solutions; peak memory 17.4 GB.
"""

import resource
import sys
import tempfile
import time
from pathlib import Path

import meshio
import numpy as np

from piston_cosim.fmu_mfbd.finite_elements.mesh import outer_faces
from piston_cosim.fmu_mfbd.options import Bodies, read_options
from piston_cosim.fmu_mfbd.reduction.store import kept_body
from piston_cosim.tests.verification.cases.bodies import box_mesh

BORE, HALF, LOW, HIGH = 28.25e-3, 43e-3, 55e-3, 155e-3


def write_block(path, cells):
    """Mesh file of the block with surfaces bore and bolts; cells around, across the wall, along."""
    points, tets = box_mesh(cells, (1.0, 1.0, 1.0))
    wrapped = points.copy()
    wrapped[wrapped[:, 0] > 1.0 - 1e-9, 0] = 0.0
    _, first, place = np.unique(
        np.round(wrapped, 9), axis=0, return_index=True, return_inverse=True
    )
    angle, across, along = wrapped[first].T
    angle = -2 * np.pi * angle
    square = HALF / np.maximum(np.abs(np.sin(angle)), np.abs(np.cos(angle)))
    radius, tets = BORE + (square - BORE) * across, place.ravel()[tets]
    points = np.stack(
        [radius * np.sin(angle), LOW + (HIGH - LOW) * along, radius * np.cos(angle)], axis=1
    )
    faces = outer_faces(tets)
    seats = (along == 0.0) & (across > 0.5)
    groups = [faces[mask[faces].all(axis=1)] for mask in (across == 0.0, seats)]
    blocks = [("tetra10", tets), *(("triangle6", group) for group in groups)]
    tags = [np.full(len(data), k + 1) for k, (_, data) in enumerate(blocks)]
    meshio.write(
        path,
        meshio.Mesh(
            points,
            blocks,
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data={"bore": np.array([2, 2]), "bolts": np.array([3, 2])},
        ),
        file_format="gmsh22",
    )


def main(cells):
    """Print what happens, then degrees of freedom, seconds and gigabytes."""
    with tempfile.TemporaryDirectory() as folder:
        write_block(Path(folder) / "block.msh", cells)
        table = {
            "block": {
                "mesh": "block.msh",
                "density": "2700 kg/m^3",
                "young": "72 GPa",
                "poisson": 0.33,
                "modes": 60,
            }
        }
        options = read_options(table, folder, Bodies).block
        begin = time.perf_counter()

        def say(text):
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9
            print(f"{time.perf_counter() - begin:7.0f} s {peak:6.2f} GB  {text}", flush=True)

        body = np.load(kept_body(options, (40, 40), Path(folder) / "cache", say))
        say("done")
        print(
            f"{body['points'].size} degrees of freedom, {len(body['omega'])} modes from "
            f"{body['omega'][0] / 2 / np.pi:.1f} Hz: "
            f"{body['seconds']:.0f} s, {body['peak_memory'] / 1e9:.2f} GB"
        )


if __name__ == "__main__":
    main(tuple(map(int, sys.argv[1:4])) or (120, 6, 54))
