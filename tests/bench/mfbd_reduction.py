"""Time and peak memory of reducing the shipped bodies from their meshes, each in a process of its
own.

python tests/bench/mfbd_reduction.py
"""

import resource
import subprocess
import sys
import time
from pathlib import Path

CASE = Path(__file__).parents[2] / "models" / "numerical_example"


def reduce_one(name, basis, modes):
    """Print degrees of freedom, seconds and gigabytes of one reduction without any cache."""
    from piston_cosim.fmu_mfbd.options import read_options
    from piston_cosim.fmu_mfbd.reduction.reduce import reduce_block, reduce_piston

    material = {
        "density": "2700 kg/m^3",
        "young": "75 GPa",
        "poisson": 0.33,
        "basis": basis,
        "modes": modes,
    }
    table = {"grid": [40, 40]} | {
        body: {"mesh": f"{body}.msh.xz", **material} for body in ("piston", "block")
    }
    options = getattr(read_options(table, CASE), name)
    begin = time.perf_counter()
    body = (reduce_piston if name == "piston" else reduce_block)(
        options, (40, 40), lambda text: None
    )
    seconds = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9
    print(
        f"{name:>8} {3 * len(body.anatomy.points):>8} dof  {modes:>3} {basis:<34} "
        f"{seconds:6.1f} s {peak:5.2f} GB"
    )


def main():
    """The table."""
    for name in ("piston", "block"):
        for basis in (
            "smooth_pressure_modes",
            "pressure_modes",
            "craig_bampton",
            "characteristic_constraint_modes",
        ):
            subprocess.run([sys.executable, __file__, name, basis, "60"], check=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        reduce_one(sys.argv[1], sys.argv[2], int(sys.argv[3]))
    else:
        main()
