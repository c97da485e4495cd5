"""Iron liner of 2.5 mm in an aluminium wall of 8 mm, bore radius 43 mm, next to one material.

A ring between frictionless plates: growth of the bore by 80 K and by 10 MPa, in finite elements and
in closed form (Lame). The frequency is that of the oval shape of a free ring of 20 mm.

Run: python tests/bench/liner.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import numpy as np
from scipy.sparse.linalg import eigsh

from piston_cosim.fmu_mfbd.finite_elements.element import consistent_mass, stiffness, thermal_load
from piston_cosim.fmu_mfbd.finite_elements.faces import face_load
from piston_cosim.tests.mfbd.test_hot_shapes import lined_growth
from piston_cosim.tests.mfbd.test_materials import (
    ALUMINIUM,
    IRON,
    between_plates,
    lame_two_layers,
    lined_ring,
)

RADII = (43e-3, 45.5e-3, 51e-3)
RISE, PRESSURE = 80.0, 10e6


def main():
    points, mesh, inner = lined_ring(cells=(36, 3, 4))
    bore = mesh.nodes("bore")
    for name, layers in (
        ("aluminium", (ALUMINIUM, ALUMINIUM)),
        ("iron", (IRON, IRON)),
        ("iron liner in aluminium", (IRON, ALUMINIUM)),
    ):
        own = {key: np.where(inner, *(one[key] for one in layers)) for key in IRON}
        K = stiffness(points, mesh.tets, own["young"], own["poisson"])
        rise = np.full(len(points), RISE)
        heat = own["young"], own["poisson"], own["expansion"], rise
        growth = []
        for load in (
            thermal_load(points, mesh.tets, *heat),
            PRESSURE * face_load(points, mesh.faces["bore"]),
        ):
            u = between_plates(points, K, load)
            growth.append((u[bore, :2] * points[bore, :2]).sum(axis=1).mean() / RADII[0])
        A, B, *_ = lame_two_layers(RADII, layers, PRESSURE)
        exact = lined_growth(RISE, RADII, layers), A * RADII[0] + B / RADII[0]
        long = points * [1.0, 1.0, 20.0 / 6.0]
        K = stiffness(long, mesh.tets, own["young"], own["poisson"])
        M = consistent_mass(long, mesh.tets, own["density"])
        value = eigsh(K, 8, M, sigma=-1e6, return_eigenvectors=False)
        frequency = np.sqrt(np.sort(value)[6]) / (2 * np.pi)
        print(
            f"{name:24} 80 K {1e6 * growth[0]:6.1f} um (closed form {1e6 * exact[0]:6.1f}), "
            f"10 MPa {1e6 * growth[1]:6.2f} um ({1e6 * exact[1]:6.2f}), oval {frequency:6.0f} Hz, "
            f"{1e3 * M.sum() / 3:5.1f} g"
        )


if __name__ == "__main__":
    main()
