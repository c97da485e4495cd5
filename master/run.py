"""One run of an opened system from start to stop, and the summary of what it did."""

import json
import platform
import time as clock
from importlib.metadata import version

import numpy as np

from .methods import method_of
from .recorder import Recorder
from .stepping import Stepper
from .wiring import start

VERSIONS = ("piston-cosim", "numpy", "scipy", "numba", "fmpy", "pythonfmu", "h5py")


def run(system, case, tree, output, watch=lambda *args: None):
    """Run to the stop time.

    Parameters
    ----------
    system : System
    case : Case
    tree : dict
        Resolved TOML tree, stored in the results.
    output : Path
        Results file.
    watch : callable(time, stop, solution, monitored)
        Called after every macro step; `monitored` maps the case's monitor names to (value, unit).

    Returns
    -------
    dict
        The summary: counters, wall time [s] and the case's own entries.

    Raises
    ------
    BadInput
        If a participant refuses its parameters; nothing has been written then.
    StepFailed
        If a macro step cannot be converged; the results up to it stay in `<output>.partial`.
    """
    try:
        start(system)
        return _march(system, case, tree, output, watch)
    finally:
        for participant in system.participants.values():
            participant.close()


def _march(system, case, tree, output, watch):
    reductions = [Reduction(name, text) for name, text in case.summary.items()]

    def accepted(time, solution):
        values = recorder.write(time, solution)
        for reduction in reductions:
            reduction.add(values)
        watch(time, system.stop, solution, monitored(case, system, values))

    stepper = Stepper(system, method_of(case.coupling), case.coupling.halvings, accepted)
    recorder = Recorder(output, system.participants, case.record, {
        "title": case.title, "case": json.dumps(tree), "versions": json.dumps(versions())})
    begin, steps = clock.perf_counter(), round(system.stop / system.step)
    try:
        recorder.write(0.0)
        for k in range(steps):
            before, after = system.stop * k / steps, system.stop * (k + 1) / steps
            stepper.advance(before, after - before)
        summary = summarise(stepper, reductions, clock.perf_counter() - begin)
        recorder.finish(summary)
        return summary
    finally:
        recorder.close()


class Reduction:
    """One summary entry: "min|max|mean|last participant.variable" over all macro steps."""

    def __init__(self, name, text):
        self.name = name
        self.kind, port = text.split()
        self.owner, self.variable = port.split(".")
        self.values = []

    def add(self, values):
        self.values.append(values[self.owner][self.variable])

    def result(self):
        if self.kind == "last":
            return self.values[-1]
        return float({"min": np.min, "max": np.max, "mean": np.mean}[self.kind](self.values))


def monitored(case, system, values):
    """Monitor entries of the step just taken: name -> (value, unit)."""
    found = {}
    for name, text in case.monitor.items():
        owner, variable = text.split()[1].split(".")
        found[name] = (values[owner][variable], system.participants[owner].fields[variable].unit)
    return found


def summarise(stepper, reductions, wall_time):
    """The summary of a finished run: no step is ever accepted unconverged, so a run that finishes has none."""
    counters = stepper.counters
    return {"steps": counters.steps, "unconverged_steps": 0, "halved_steps": counters.halved_steps,
            "mean_iterations": float(np.mean(counters.iterations)), "max_iterations": int(np.max(counters.iterations)),
            "residual_evaluations": counters.residual_evaluations, "jacobian_evaluations": counters.jacobian_evaluations,
            "derivative_products": counters.derivative_products, "wall_time_s": wall_time,
            **{r.name: r.result() for r in reductions}}


def versions():
    """Versions of everything that has a say in the numbers."""
    return {"python": platform.python_version(), **{name: version(name) for name in VERSIONS}}
