"""What the number of films costs: the same skirt as 1, 2, 4 and 8 lubrication FMUs on one body FMU;
then a skirt and the three films of a floating pin, its bosses rigid and yielding.

The rigid piston of `data_sheet`, 40 x 40 cells in all, 40 deg; films that touch have edges of their
own between them, so that the physics of each row differs and iterations may. A case with no change
but participants and wires. The pin's films have 72 x 8 cells each; 8 of them are five bands of the
skirt and the pin's three. `yielding_bosses` is another, smaller engine, with 100 modes. Run:
python tests/bench/films.py [--no-pin]
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys
import tempfile
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).parents[2]))
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run
from tests.fmu.films import PATH, even_bands, several_films

GRID, STOP, PASSES = (40, 40), "40 deg", 2


def computed(count, folder):
    """Processor time a macro step [s], iterations a step (mean, most) and what work the two sides
    of the interface disagree by.
    """
    return measured(several_films(GRID, STOP, even_bands(GRID[1], count)), PATH, folder)


def measured(tree, source, folder):
    """The same of a case's tree that lies at `source`."""
    case = check_case(tree, source)
    system = open_system(case, source.parent, lambda text: None)
    path = folder / "films.h5"
    begin = process_time()
    run(system, case, tree, path)
    spent = process_time() - begin
    results = Results(path)
    iterations = results.series("coupling.iterations").values[1:]
    assert results.summary
    off = results.summary["interface_work_imbalance"]
    path.unlink()
    return spent / len(iterations), iterations, off


def floating(name, bands):
    """Tree of a shipped case with a floating pin, its skirt one film or so many bands."""
    tree = read_tree(find_case(name), [("time.stop", STOP)])
    tree |= {"record": {"every": 1000}, "pictures": [], "summary": {}, "monitor": {}, "axes": []}
    if bands == 1:
        return tree
    films = tree["participants"]
    film = films.pop("skirt_film")
    around, along = GRID
    rows = along // bands
    length = float(film["parameters"]["skirt_length"].removesuffix(" mm")) * rows / along
    of_skirt = [wire for wire in tree["wires"] if "skirt" in wire["from"]]
    wires = [wire for wire in tree["wires"] if wire not in of_skirt]
    surfaces, names = [], []
    for k in range(1, bands + 1):
        surfaces.append({"name": f"band_{k}", "rows": [(k - 1) * rows + 1, k * rows]})
        names.append(f"film_{k}")
        films[names[-1]] = film | {
            "build": {"grid": [around, rows]},
            "parameters": film["parameters"] | {"skirt_length": f"{length!r} mm"},
        }
        wires += [
            {
                key: text.replace("bodies.skirt.", f"bodies.band_{k}.").replace(
                    "skirt_film.", f"film_{k}."
                )
                if isinstance(text, str)
                else text
                for key, text in wire.items()
            }
            for wire in of_skirt
        ]
    films["bodies"]["build"]["film_surfaces"] = surfaces
    order = [one for one in tree["coupling"]["order"] if one != "skirt_film"]
    tree["coupling"]["order"] = names + order
    return tree | {"wires": wires}


PINS = (
    ("4, pin", "floating_pin", 1),
    ("8, pin", "floating_pin", 5),
    ("4, yielding", "yielding_bosses", 1),
)
"""Films, case, and how many of them on its skirt."""


def line(label, rows, run_of_it, first):
    """A line of the table; `first`: of one film [s]."""
    spent, iterations, off = run_of_it
    print(
        f"{label:12s} {rows:9d} {1e3 * spent:8.2f} ms {spent / first:6.2f} "
        f"{iterations.mean():11.2f} (most {iterations.max():.0f}) {off:12.1e}",
        flush=True,
    )


def main():
    """The table."""
    print("films        rows each  CPU a step  ratio  iterations a step  interface work off by")
    first = None
    with tempfile.TemporaryDirectory() as folder:
        for count in (1, 2, 4, 8):
            runs = [computed(count, Path(folder)) for _ in range(PASSES)]  # the first one compiles
            spent, iterations, off = min(runs, key=lambda one: one[0])
            first = first or spent
            line(str(count), GRID[1] // count, (spent, iterations, off), first)
        for label, name, bands in PINS if "--no-pin" not in sys.argv else ():
            runs = [
                measured(floating(name, bands), find_case(name), Path(folder))
                for _ in range(PASSES)
            ]
            line(label, GRID[1] // bands, min(runs, key=lambda one: one[0]), first)


if __name__ == "__main__":
    main()
