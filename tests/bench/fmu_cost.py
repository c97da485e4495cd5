"""What access to an FMU costs: set both input fields, read both force fields, save and restore, derivative, one step.

Times are the best of several, in milliseconds, on the 40 x 40 lubrication FMU; compare within one run only. Columns: FMI
2.0 by Python lists and by pointers, through the front and through pythonfmu's own library; FMI 3.0 by lists and pointers.

    python tests/bench/fmu_cost.py
"""

import ctypes
import os
import tempfile
import time

import fmpy
import numpy as np
from fmpy import fmi2, fmi3
from rich.console import Console
from rich.table import Table

from master.fmi.builder import build_fmu
from master.participant import FmuParticipant

CELLS, REPEATS = (40, 40), 30
INPUTS, OUTPUTS = ("film_thickness", "sliding_velocity"), ("nodal_pressure_force", "nodal_friction_force")
FILM, SPEED = np.full(CELLS, 3e-5), np.full(CELLS, 5.0)
DOUBLES = ctypes.POINTER(ctypes.c_double)


def best(action):
    """Shortest time of an action [ms]."""
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        action()
        times.append(time.perf_counter() - begin)
    return 1e3 * min(times)


def participant_costs(path):
    """FMI 2.0 by pointers: the master's own way."""
    p = FmuParticipant("bench", path)
    p.start({"film_thickness": FILM}, 0.0, 1.0)

    def write():
        p.set("film_thickness", FILM * 0.9)
        p.set("sliding_velocity", SPEED)

    write()
    start = p.save()

    def state():
        saved = p.save()
        p.restore(saved)
        p.free(saved)

    def step():
        p.restore(start)
        write()
        p.step(0.0, 5e-5)

    costs = {"set 3200": best(write), "step": best(step), "get 3200": best(lambda: [p.get(name) for name in OUTPUTS]),
             "get 1600": best(lambda: p.get(OUTPUTS[0])),
             "save + restore": best(state), "derivative": best(lambda: p.derivative({"film_thickness": FILM}, OUTPUTS))}
    p.close()
    return costs


def list_costs(path):
    """FMI 2.0 by FMPy's lists."""
    one, references = _fmi2(path)
    inputs, outputs = ([r for name in names for r in references[name]] for names in (INPUTS, OUTPUTS))
    values = [*FILM.ravel(), *SPEED.ravel()]
    costs = {"set 3200": best(lambda: one.setReal(inputs, values)), "get 3200": best(lambda: one.getReal(outputs)),
             "get 1600": best(lambda: one.getReal(references[OUTPUTS[0]]))}
    one.terminate()
    one.freeInstance()
    return costs


def _fmi2(path):
    p = FmuParticipant("bench", path)
    one = fmi2.FMU2Slave(guid=p.description.guid, unzipDirectory=str(p.folder), instanceName="bench",
                         modelIdentifier=p.description.coSimulation.modelIdentifier)
    one.instantiate()
    one.setupExperiment(startTime=0.0)
    one.enterInitializationMode()
    one.exitInitializationMode()
    return one, {name: list(field.references) for name, field in p.fields.items()}


def costs_3(path, folder):
    """FMI 3.0 by lists and by pointers."""
    description = fmpy.read_model_description(str(path))
    reference = {v.name: v.valueReference for v in description.modelVariables}
    one = fmi3.FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(str(path), unzipdir=folder), instanceName="bench",
                         modelIdentifier=description.coSimulation.modelIdentifier)
    one.instantiate()
    one.enterInitializationMode(startTime=0.0)
    one.exitInitializationMode()
    inputs, outputs = [reference[name] for name in INPUTS], [reference[name] for name in OUTPUTS]
    values, buffer = np.concatenate([FILM.ravel(), SPEED.ravel()]), np.empty(2 * FILM.size)
    count, size = 2, values.size
    to, source = (ctypes.c_uint * count)(*inputs), (ctypes.c_uint * count)(*outputs)

    def state():
        saved = one.getFMUState()
        one.setFMUState(saved)
        one.freeFMUState(saved)

    lists = {"set 3200": best(lambda: one.setFloat64(inputs, values.tolist())),
             "get 3200": best(lambda: one.getFloat64(outputs, size)), "save + restore": best(state)}
    pointers = {
        "set 3200": best(lambda: one.fmi3SetFloat64(one.component, to, count, values.ctypes.data_as(DOUBLES), size)),
        "get 3200": best(lambda: one.fmi3GetFloat64(one.component, source, count, buffer.ctypes.data_as(DOUBLES), size))}
    one.terminate()
    one.freeInstance()
    return lists, pointers


def main():
    """Print the table."""
    front, twin = (build_fmu("fmu_ehd", {"grid": list(CELLS)}, ".", version=v) for v in ("2.0", "3.0"))
    os.environ["CC"] = "none"
    stock = build_fmu("fmu_ehd", {"grid": list(CELLS)}, ".")
    with tempfile.TemporaryDirectory() as folder:
        lists_3, pointers_3 = costs_3(twin, folder)
    columns = {"FMI 2 lists": list_costs(front), "FMI 2 pointers": participant_costs(front),
               "FMI 2 pointers, pythonfmu's library": participant_costs(stock),
               "FMI 3 lists": lists_3, "FMI 3 pointers": pointers_3}
    table = Table("[ms]", *columns, box=None)
    for row in ("set 3200", "step", "get 3200", "get 1600", "save + restore", "derivative"):
        table.add_row(row, *(f"{column[row]:.4f}" if row in column else "" for column in columns.values()))
    Console(width=140).print(table)
    pointers, lists = (sum(columns[name][row] for row in ("set 3200", "get 1600")) for name in ("FMI 2 pointers", "FMI 2 lists"))
    print(f"set 3200 + get 1600 by pointers: {pointers / lists:.3f} of FMPy's lists on the same FMU (target 0.3)")


if __name__ == "__main__":
    main()
