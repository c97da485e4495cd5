"""Cost of the number of cylinders: 1, 2 and 4 pistons on one mounted block.

Each piston and each film is an FMU. The engines of the case `twin` are rigid, with 40 x 40 cells
per film, and run over 40 deg. The first piston alone, in a block at rest, is the comparison.

Run: python tests/bench/engines.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import tempfile
from pathlib import Path
from time import process_time

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.system import open_system
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run
from piston_cosim.tests.fmu.engines import ENGINES, PATH, alone, engine_tree

GRID, STOP, PASSES = (40, 40), "40 deg", 2


def computed(tree, path):
    """Processor time a macro step [s], iterations a step, and the run's summary."""
    case = check_case(tree, PATH)
    system = open_system(case, PATH.parent, lambda text: None)
    begin = process_time()
    run(system, case, tree, path)
    spent = process_time() - begin
    results = Results(path)
    iterations = results.series("coupling.iterations").values[1:]
    path.unlink()
    return spent / len(iterations), iterations, results.summary


def main():
    """Print the table."""
    single = alone(engine_tree(ENGINES["single"], GRID, STOP), 1)
    trees = {"one, block at rest": single}
    trees |= {name: engine_tree(one, GRID, STOP) for name, one in ENGINES.items()}
    print("engine               CPU a step  ratio  iterations a step  products a step")
    first = None
    with tempfile.TemporaryDirectory() as folder:
        for name, tree in trees.items():
            runs = [computed(tree, Path(folder) / "engine.h5") for _ in range(PASSES)]
            spent, iterations, summary = min(runs, key=lambda one: one[0])  # the first one compiles
            first = first or spent
            print(
                f"{name:20s} {1e3 * spent:7.2f} ms {spent / first:6.2f} "
                f"{iterations.mean():11.2f} (most {iterations.max():.0f}) "
                f"{summary['derivative_products'] / len(iterations):10.1f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
