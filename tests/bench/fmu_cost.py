"""Cost of access to an FMU: set, step, get, save and restore the state, and compute a derivative.

The FMU is the 40 x 40 lubrication FMU with oil temperature as a third input field. "Set" writes all
inputs, and "get" reads both force fields. Times are the best of several, in milliseconds. Compare
them within one run only. A step starts from a restored state with unchanged inputs.

The columns are FMI 2.0 and 3.0 by FMPy's Python lists and by the master's pointers. Two more
columns use pointers with FMI 2.0: in a separate process, and through pythonfmu's own library. An
FMU that is built without a C compiler contains that library.

    python tests/bench/fmu_cost.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded


import numpy as np
from rich.console import Console
from rich.table import Table
from timing import shortest

from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.participants.isolated import IsolatedParticipant
from piston_cosim.master.participants.open import open_fmu

CELLS, REPEATS, STEP = (40, 40), 60, 5e-5
INPUTS = {
    "film_thickness": np.full(CELLS, 2.7e-5),
    "sliding_velocity": np.full(CELLS, 5.0),
    "oil_temperature": np.full(CELLS, 370.0),
}
OUTPUTS = ("nodal_pressure_force", "nodal_friction_force")


def best(action, before=lambda: None):
    """Shortest time of an action [ms]; `before` it, untimed, something else."""
    return 1e3 * shortest(action, REPEATS, before)


def costs(p, write, read, advance):
    """Return the rows of the table for one way of access to a started participant.

    `write()`, `read()` and `advance()` access the participant.
    """
    write()
    start = p.save()

    def state():
        saved = p.save()
        p.restore(saved)
        p.free(saved)

    rows = {
        "set 4800": best(write),
        "step": best(advance, lambda: p.restore(start)),
        "get 3200": best(read),
        "save + restore": best(state),
    }
    p.restore(start)
    advance()
    return rows


def started(path, isolated=False):
    """Return a participant ready for its first step."""
    p = open_fmu("bench", path)
    p = IsolatedParticipant(p, 60.0) if isolated else p
    p.start({"film_thickness": np.full(CELLS, 3e-5)}, 0.0, 1.0)
    return p


def by_pointers(path, isolated=False):
    """Return the costs of the master's own access, FMI 2.0 or 3.0."""
    p = started(path, isolated)

    def write():
        for name, values in INPUTS.items():
            p.set(name, values)

    rows = costs(p, write, lambda: [p.get(name) for name in OUTPUTS], lambda: p.step(0.0, STEP))
    seed = {"film_thickness": INPUTS["film_thickness"]}
    rows["derivative"] = best(lambda: p.derivative(seed, OUTPUTS))
    p.close()
    return rows


def by_lists(path):
    """Return the costs of FMPy's calls with Python lists, as in an importer in Python.

    The calls for the state are those of the master.
    """
    p = started(path)
    one = p._fmu
    inputs, outputs = (
        [r for name in names for r in p.fields[name].references] for names in (INPUTS, OUTPUTS)
    )
    values = np.concatenate([v.ravel() for v in INPUTS.values()]).tolist()
    if p.version == "2":
        calls = (
            lambda: one.setReal(inputs, values),
            lambda: one.getReal(outputs),
            lambda: one.doStep(0.0, STEP),
        )
    else:
        size = 2 * CELLS[0] * CELLS[1]
        calls = (
            lambda: one.setFloat64(inputs, values),
            lambda: one.getFloat64(outputs, size),
            lambda: one.doStep(0.0, STEP),
        )
    rows = costs(p, *calls)
    p.close()
    return rows


def main():
    """Print the table."""
    options = {"grid": list(CELLS), "inputs": ["oil_temperature"]}
    front, twin = (
        build_fmu("fmu_ehd", options, ".", version=version) for version in ("2.0", "3.0")
    )
    os.environ["CC"] = "none"
    stock = build_fmu("fmu_ehd", options, ".")
    columns = {
        "FMI 2 lists": by_lists(front),
        "FMI 2 pointers": by_pointers(front),
        "FMI 2 pointers, isolated": by_pointers(front, isolated=True),
        "FMI 3 lists": by_lists(twin),
        "FMI 3 pointers": by_pointers(twin),
        "FMI 2 pointers, pythonfmu's library": by_pointers(stock),
    }
    table = Table("ms", *columns, box=None)
    for row in ("set 4800", "step", "get 3200", "save + restore", "derivative"):
        table.add_row(
            row, *(f"{column[row]:.4f}" if row in column else "" for column in columns.values())
        )
    Console(width=140).print(table)
    here, there = (
        sum(one for row, one in columns[name].items() if row != "derivative")
        for name in ("FMI 2 pointers", "FMI 2 pointers, isolated")
    )
    print(f"a step of an isolated FMU with all inputs and outputs: {there / here:.2f} times")
    pointers, lists = (
        sum(columns[name][row] for row in ("set 4800", "get 3200"))
        for name in ("FMI 2 pointers", "FMI 2 lists")
    )
    print(
        f"fields in and out by pointers: {pointers / lists:.3f} of FMPy's lists on the same FMU "
        "(at most 0.3)"
    )


if __name__ == "__main__":
    main()
