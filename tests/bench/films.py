"""What the number of films costs: the same skirt as 1, 2, 4 and 8 lubrication FMUs on one body FMU.

The rigid piston of `data_sheet`, 40 x 40 cells in all, 40 deg; films that touch have edges of their
own between them, so that the physics of each row differs and iterations may. A case with no change
but participants and wires. Run: python tests/bench/films.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys
import tempfile
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).parents[2]))
from piston_cosim.master.case.schema import check_case
from piston_cosim.master.case.system import open_system
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run
from tests.fmu.films import PATH, even_bands, several_films

GRID, STOP, PASSES = (40, 40), "40 deg", 2


def computed(count, folder):
    """Processor time a macro step [s], iterations a step (mean, most) and what work the two sides
    of the interface disagree by.
    """
    tree = several_films(GRID, STOP, even_bands(GRID[1], count))
    case = check_case(tree, PATH)
    system = open_system(case, PATH.parent, lambda text: None)
    path = folder / f"{count}.h5"
    begin = process_time()
    run(system, case, tree, path)
    spent = process_time() - begin
    results = Results(path)
    iterations = results.series("coupling.iterations").values[1:]
    assert results.summary
    off = results.summary["interface_work_imbalance"]
    path.unlink()
    return spent / len(iterations), iterations, off


def main():
    """The table."""
    print("films  rows each  CPU a step  ratio  iterations a step  interface work differs by")
    first = None
    with tempfile.TemporaryDirectory() as folder:
        for count in (1, 2, 4, 8):
            runs = [computed(count, Path(folder)) for _ in range(PASSES)]  # the first one compiles
            spent, iterations, off = min(runs, key=lambda one: one[0])
            first = first or spent
            print(
                f"{count:5d} {GRID[1] // count:10d} {1e3 * spent:8.2f} ms {spent / first:6.2f} "
                f"{iterations.mean():11.2f} (most {iterations.max():.0f}) {off:12.1e}",
                flush=True,
            )


if __name__ == "__main__":
    main()
