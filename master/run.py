"""One run of an opened system from start to stop: march, record, checkpoint, and the summary of what it did."""

import json
import platform
import time as clock
from importlib.metadata import version

import numpy as np

from .checkpoint import Checkpoint, Interrupted, listening
from .freezing import freeze, thaw
from .methods import method_of
from .participant import ParticipantFault
from .recorder import CannotWrite, Recorder, writing
from .stepping import Stepper, StepFailed
from .wiring import start

VERSIONS = ("piston-cosim", "numpy", "scipy", "numba", "fmpy", "pythonfmu", "h5py")


def run(system, case, tree, output, watch=lambda *args: None, begin_at=None):
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
    begin_at : Checkpoint, optional
        Where to go on; from the start without it.

    Returns
    -------
    dict
        The summary: counters, wall time [s] and the case's own entries.

    Raises
    ------
    BadInput
        If a participant refuses its parameters; nothing has been written then.
    StepFailed, ParticipantFault, CannotWrite
        If a macro step cannot be converged, an FMU has a fault of its own, or the disk is full; the results up to there stay
        in `<output>.partial`, and a note on the exception names the last checkpoint.
    Interrupted
        After SIGINT or SIGTERM, once the macro step is done and a checkpoint is written.
    """
    try:
        start(system)
        return _march(system, case, tree, output, watch, begin_at)
    except (StepFailed, ParticipantFault, CannotWrite) as stop:
        stop.add_note(kept(output))
        raise
    finally:
        for participant in system.participants.values():
            participant.close()


def kept(output):
    """Sentence on the checkpoint that a stopped run has left."""
    checkpoint = Checkpoint.path(output)
    if not checkpoint.exists():
        return "no checkpoint had been written yet"
    return f"what was reached is kept; once the cause is gone, go on with: piston-cosim resume {checkpoint}"


def _march(system, case, tree, output, watch, begin_at):
    reductions = [Reduction(name, text) for name, text in case.summary.items()]

    def accepted(time, solution):
        values = recorder.write(time, solution)
        for reduction in reductions:
            reduction.add(values)
        watch(time, system.stop, solution, monitored(case, system, values))

    stepper = Stepper(system, method_of(case.coupling), case.coupling.halvings, accepted, case.coupling.predictor)
    if begin_at:
        thaw(stepper, begin_at.frozen)
        stepper.counters = begin_at.counters
        for reduction in reductions:
            reduction.values = begin_at.reductions[reduction.name]
    else:
        Checkpoint.path(output).unlink(missing_ok=True)     # that of an older run, whose results give way to these
    with writing(output):
        recorder = Recorder(output, system.participants, case.record, {
            "title": case.title, "case": json.dumps(tree), "versions": json.dumps(versions())}, begin_at.rows if begin_at else 0)
    first, spent = (begin_at.steps_done, begin_at.wall_time) if begin_at else (0, 0.0)
    begin, steps = clock.perf_counter() - spent, round(system.stop / system.step)

    def keep(steps_done):
        recorder.flush()
        with writing(Checkpoint.path(output)):
            Checkpoint(tree, system.folder, steps_done, recorder.rows, clock.perf_counter() - begin, freeze(stepper),
                       stepper.counters, {r.name: r.values for r in reductions}).write(output)

    try:
        with listening() as heard:
            if not begin_at:
                recorder.write(0.0)
            for k in range(first, steps):
                before, after = system.stop * k / steps, system.stop * (k + 1) / steps
                stepper.advance(before, after - before)
                if heard.signal or (case.record.checkpoint_every and (k + 1) % case.record.checkpoint_every == 0):
                    keep(k + 1)
                if heard.signal and k + 1 < steps:
                    raise Interrupted(output, after)
        summary = summarise(stepper, reductions, clock.perf_counter() - begin)
        recorder.finish(summary)
        Checkpoint.path(output).unlink(missing_ok=True)
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
