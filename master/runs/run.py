"""One run of an opened system: its periods, results, checkpoints and summary."""

import json
import platform
import time as clock
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ..case.contract import contract, players
from ..case.tables import reduced
from ..coupling.compiled_newton import compiled_if_native
from ..coupling.components import by_components, components, table
from ..coupling.freezing import freeze, thaw
from ..coupling.ledger import JudgedPart, ledger, total_balance
from ..coupling.methods import method_of
from ..coupling.negotiation import (
    by_differences,
    objections,
    sentences,
    trial_sentences,
    trials,
    tried,
)
from ..coupling.starting import closing, start
from ..coupling.step_control import step_control
from ..coupling.stepping import Observer, StepFailed, Stepper
from ..coupling.wiring import port_of
from ..coupling.work import InterfaceWork
from ..fmi.errors import BadInput, Finished, NotFinite
from ..participants.fmi2 import ParticipantFault
from ..participants.plain import NotPlain
from ..participants.plugins import from_plugin
from ..participants.warned import LoggedWarning, merged
from .checkpoint import (
    Account,
    Checkpoint,
    Interrupted,
    checkpoint_message,
    fingerprints,
    source_hashes,
)
from .envelopes import envelopes
from .lock import sole_writer
from .logs import CouplingLog
from .recorder import CannotWrite, Recorder, Schedule, writing
from .reductions import Reduction
from .repetition import repetition, turning
from .signals import listening

USUAL_CHECKPOINTS = 50
"""Default number of macro steps between checkpoints."""
CHECKPOINT_SHARE = 0.02
"""Largest share of the time for writing checkpoints, by default."""
FIRST_CHECKPOINT = 5.0
"""Run time before the first checkpoint, which reads all FMUs, by default [s]."""
VERSIONS = ("piston-cosim", "numpy", "scipy", "numba", "fmpy", "pythonfmu", "h5py")


def run(
    system: Any,
    case: Any,
    tree: dict[str, Any],
    output: Path,
    watch: Callable[..., object] = lambda *args: None,
    begin_at: Any = None,
    say: Callable[[str], object] = lambda line: None,
    log: Callable[[str], object] = lambda line: None,
    *,
    observers: Sequence[Observer] = (),
) -> dict[str, Any]:
    """Run to the stop time, or until a period repeats the previous one (`until_periodic`).

    Parameters
    ----------
    system : System
    case : Case
    tree : dict
        Resolved TOML tree, stored in the results.
    output : Path
        Results file.
    watch : callable(time, stop, solution, monitored)
        Called after every macro step. `monitored` maps the case's monitor names to (value, unit).
        Its optional `hold(received)` may pause the run until a signal arrives.
    begin_at : Checkpoint, optional
        Checkpoint to resume from. Default: run from the start.
    say : callable(line)
        Called with the warnings of FMUs at the start, and with deviations from their capabilities.
    log : callable(line)
        Called after each period with its distance from the previous one and its summary entries.
    observers : sequence of Observer
        Further observers of the steps.

    Returns
    -------
    dict
        The summary: counters, wall time [s] and the case's own entries.

    Raises
    ------
    BadInput
        If a participant rejects its parameters, cannot restore its state, or if another process
        writes the same results. Nothing has been written then.
    StepFailed, ParticipantFault, CannotWrite
        If a macro step does not converge, an FMU fails, or the disk is full. The results so far
        remain in `<output>.partial`, and a note on the exception names the last checkpoint.
    Interrupted
        After SIGINT or SIGTERM, once the macro step is complete and a checkpoint is written.
    """
    output = Path(output).absolute()  # an FMU may change the working directory
    participants = system.participants.values()
    with (
        sole_writer(output) as release,
        listening(release) as received,
        closing(participants, say),
    ):
        try:
            if begin_at:
                _check_resumable(begin_at, system, output)
            elif Checkpoint.path(output).exists():
                resume = f"piston-cosim resume {Checkpoint.path(output)}"
                say(f"warning: this run replaces an interrupted one; {resume} would continue that")
            try:
                start(system)
            finally:
                for name, warning in logged_warnings(system):
                    say(f"{name}: {warning.text}")
            rollback_trials = trials(system, case.coupling.method != "explicit")
            for line in trial_sentences(system, rollback_trials):
                say(line)
            system = tried(system, rollback_trials)
            objected = objections(system, method_of(case.coupling))
            for line in [*sentences(objected), *table(system, case.coupling.method)]:
                say(line)
            negotiated = by_differences(system, objected)
            own = {"begin_at": begin_at, "objected": objected, "observers": observers}
            active = ActiveRun(negotiated, case, tree, output, watch, log, **own)
            try:
                return active.go(received)
            finally:
                active.close()
                later = [one for one in logged_warnings(system) if one[1].time is not None]
                for name, warning in [*later, *active.stepper.warned()]:
                    say(f"{name}: warning at {warning.sentence}")
        except (StepFailed, ParticipantFault, CannotWrite) as stop:
            stop.add_note(checkpoint_message(output))
            raise


def _check_resumable(checkpoint, system, output):
    """Raise `BadInput` if the FMUs differ from the checkpoint's or the results are lost."""
    now = fingerprints(system.participants)
    faults = [
        f"{Checkpoint.path(output)}: expected the file of {name} that began the run, got another "
        "content; run again from the start"
        for name in sorted(now.keys() | checkpoint.fmus.keys())
        if now.get(name) != checkpoint.fmus.get(name)
    ]
    partial_file = Path(f"{output}.partial")
    if not partial_file.exists():
        faults.append(f"{partial_file}: expected the results so far, got no such file")
    if faults:
        raise BadInput(faults)


class ActiveRun(Observer):
    """Run in progress; see `run` for the arguments.

    `account` contains its counters and sums, and `objected` why derivatives are not the
    participants' own (see `negotiation`).
    """

    def __init__(self, system, case, tree, output, watch, log, *, begin_at, objected, observers=()):
        self.objected = objected
        self.is_resumed, self.earlier = begin_at is not None, []
        self.system = system
        self.case = case
        self.tree = tree
        self.output = output
        self.watch, self.log_period = watch, log
        self.may_end = [one for one in system.participants.values() if hasattr(one, "ended")]
        self.steps = round((system.stop - system.begin) / system.step)
        self.steps_of_period = round(system.period / system.step)
        self.stepper = Stepper(
            system,
            by_components(self._method(), system, case.coupling.advanced.halvings),
            case.coupling.advanced.halvings,
            self,
            case.coupling.predictor,
            _step_control(system, case.coupling),
            system.held,
            begin=system.begin,
            judge=self.judge,
            clocks=system.clocks,
        )
        if begin_at:
            try:
                thaw(self.stepper, begin_at.frozen)
            except NotPlain:
                where = Checkpoint.path(output)
                raise BadInput(f"{where}: expected a checkpoint of this run, got another") from None
            self.account, self.stepper.counters = begin_at.account, begin_at.account.counters
            self.earlier = [(name, LoggedWarning(*rest)) for name, *rest in self.account.warnings]
            self.stepper.interface.spent = self.account.spent
        else:
            Checkpoint.path(output).unlink(
                missing_ok=True
            )  # that of an older run, whose results give way to these
            self.account = Account(
                self.stepper.counters,
                [],
                InterfaceWork(self.stepper.interface, case.wires, system.begin),
                self.stepper.interface.spent,
                repetition=repetition(case, tree, system),
            )
            self.account.spent["recording"] = 0.0
        self.monitors = monitors(case, system)
        self.observers = [
            *observers,
            *(
                from_plugin("observers", name, options, system, output)
                for name, options in case.observers.items()
            ),
        ]
        self.parts = []
        self.begin = clock.perf_counter() - self.account.wall_time
        self.next_checkpoint = self.begin + FIRST_CHECKPOINT
        with writing(output):
            self.recorder = self._recorder()
            self.log = CouplingLog(output, system.wires, self.account.counters)

    def _method(self):
        """Return the method, as machine code if all participants are."""
        coupling = self.case.coupling
        packages = {name: table.package for name, table in self.case.participants.items()}
        predicted = coupling.predictor + 1 if coupling.advanced.coordinates else 0
        native = bool(self.case.native)
        return compiled_if_native(method_of(coupling), self.system, packages, native, predicted)

    def _ledger(self):
        """Return the ledger of the participants whose role in the contract has a power output."""
        known = self.system.participants
        ports: list[tuple[str, str]] = []
        sizes: list[tuple[str, str]] = []
        for role, terms in contract().items():
            for name in players(self.tree, role):
                if terms.power in known[name].fields:
                    ports.append((name, str(terms.power)))
                for size in (terms.energy_size, terms.power_size):
                    if size in known[name].fields:
                        sizes.append((name, str(size)))
        return ledger(ports, sizes, len(self.account.work.pairs), known)

    def _recorder(self):
        """Return the writer of the results, with the rows so far."""
        shown = self.case.record.periods or (1 if self.case.time.until_periodic else 0)
        period = {
            "length": self.system.period,
            "shown": shown,
            "turning": turning(self.tree, self.system.participants),
        }
        derivatives = {name: why or "its own" for name, why in self.objected.items()}
        attributes = {
            "title": self.case.title,
            "case": json.dumps(self.tree),
            "versions": json.dumps(versions()),
            "derivatives": json.dumps(derivatives),
            "method": type(getattr(self.stepper.method, "method", self.stepper.method)).__name__,
            "period": json.dumps(period),
            "masks": json.dumps(self.system.masks),
        }
        participants = self.system.participants
        every = self.case.record.every
        count = every if isinstance(every, int) else 1
        schedule = Schedule(count, self.system.begin, self.system.record_interval)
        rows = self.account.rows
        return Recorder(self.output, participants, self.case, attributes, schedule, rows)

    def go(self, received):
        """Run all periods, and return the summary.

        The run ends at the stop time or once it is periodic. It also ends after the macro step
        in which a signal arrives, or if a participant ends it.
        """
        if not self.account.rows:
            self._begin_period()
            for port, value in self.recorder.undefined.items():
                self.stepper.warn(port, f"expected a finite output, got {value}", None)
            self.recorder.write(self.system.begin)
        ended = self._period(received)
        while not ended and self._goes_on():
            ended = self._period(received)
        if ended and not self.account.counters.steps:
            raise StepFailed(f"{ended}, before its first macro step is complete")
        summary = summarise(self.account, self.stepper.control, clock.perf_counter() - self.begin)
        if ended:
            summary["ended_early"] = ended
        if logged := self.warnings():
            summary["warnings"] = [f"{name}: {warning.sentence}" for name, warning in logged]
        if self.account.repetition:
            summary |= self.account.repetition.summary()
        if count := sum(map(bool, self.objected.values())):
            summary["derivatives_by_differences"] = count
        unable = sum(bool(one.fixed) for one in components(self.system))
        if unable and self.case.coupling.method != "explicit":
            summary["loops_stepped_explicitly"] = unable
        self.recorder.finish(summary, self._time(self.account.began), self.account.envelopes)
        Checkpoint.path(self.output).unlink(missing_ok=True)
        return summary

    def _period(self, received):
        """Run the rest of a period; return which participant ends the run, or ""."""
        account = self.account
        end = self._end_of_period
        after = self._time(account.steps_done)
        for k in range(account.steps_done, end):
            before, after = after, self._time(k + 1)
            if ended := self._advance(before, after - before):
                return ended
            account.steps_done = k + 1
            received.stepped = True
            if received.signal or self.is_due(k + 1):
                self.write_checkpoint()
            if received.signal and k + 1 < end:
                raise Interrupted(self.output, after)
        return ""

    def _time(self, step):
        """Return the end of a macro step [s], counted from 1: the communication points of FMPy."""
        return min(self.system.begin + step * self.system.step, self.system.stop)

    @property
    def _end_of_period(self):
        """Number of macro steps at the end of the current period.

        The last period ends at the stop time, so the first one may be shorter.
        """
        began, length = self.account.began, self.steps_of_period
        if not 0 < length <= self.steps:
            return self.steps
        return began + (length if began else self.steps % length or length)

    def _goes_on(self):
        """End a period; return whether another one has begun."""
        account, periods = self.account, self.account.repetition
        whole = account.steps_done - account.began == self.steps_of_period
        taken_back = False
        if periods and whole:
            periods.end(self.system.participants)
            entries = (f"{one.name} {one.result():.6g}" for one in account.reductions)
            self.log_period("; ".join([periods.sentence(), *entries]))
            if periods.is_over:
                return False
            count = periods.count
            if account.steps_done < self.steps:
                if done := periods.proceed(self.system.participants):
                    self.log_period(done)
            taken_back = periods.count < count
        if account.steps_done >= self.steps:
            return False
        if taken_back:
            account.steps_done = account.began
            self._take_back_rows()
        self._begin_period()
        return True

    def _begin_period(self):
        """Begin a period at the current state of the participants, with new sums."""
        account = self.account
        account.began, account.began_rows = account.steps_done, self.recorder.rows
        begin = self._time(account.began)
        account.reductions = [
            Reduction(name, text, begin) for name, text in self.case.summary.items()
        ]
        account.work = InterfaceWork(self.stepper.interface, self.case.wires, begin)
        account.ledger = self._ledger()
        account.envelopes = envelopes(self.tree, self.system.participants)
        account.envelopes.begin(self.system.participants)
        if account.repetition:
            account.repetition.begin(self.system.participants)

    def _take_back_rows(self):
        """Drop the rows of the current period, and write a checkpoint that does not need them."""
        self.recorder.flush()
        self.account.rows = self.recorder.rows = self.account.began_rows
        if self.case.record.checkpoint_every != 0:
            self.write_checkpoint()
        self.recorder.close()
        with writing(self.output):
            self.recorder = self._recorder()

    def _advance(self, time, step):
        """Take a macro step of the case; return which participant ends the run, or ""."""
        try:
            self.stepper.advance(time, step)
        except Finished as wish:
            return str(wish)
        for participant in self.may_end:
            if participant.ended:
                return participant.ended
        return ""

    def is_due(self, steps):
        """Return whether a checkpoint is due after this number of macro steps."""
        every = self.case.record.checkpoint_every
        if every is not None:
            return bool(every) and steps % every == 0
        return steps % USUAL_CHECKPOINTS == 0 and clock.perf_counter() >= self.next_checkpoint

    def attempted(self, time, step, trail, failure):
        """Log an attempt at a macro step."""
        try:
            self.log.attempt(time, step, trail, failure)
        except OSError as error:
            raise CannotWrite.of(self.output, error) from error
        for observer in self.observers:
            observer.attempted(time, step, trail, failure)

    def accepted(self, time, solution):
        """Record an accepted step, and report it."""
        begin, account = clock.perf_counter(), self.account
        row, index = self.recorder.write(time, solution), self.recorder.index
        if account.envelopes.kinds:
            account.envelopes.add(self.system.participants)
        if account.repetition:
            account.repetition.note(self.system.participants)
        for reduction in account.reductions:
            reduction.add(time, row[index[reduction.port]])
        account.spent["recording"] += clock.perf_counter() - begin
        if account.work.pairs:
            if account.ledger and self.parts[0].is_first:
                account.ledger.add(total_balance([part.balance for part in self.parts]))
            part = self.parts.pop(0)
            account.work.add(part.end, part.exchange)
        monitored = {name: (row[index[port]], unit) for name, port, unit in self.monitors}
        for observer in self.observers:
            observer.accepted(time, solution)
        ends = self.case.time.until_periodic
        end = self._time(self._end_of_period) if ends else self.system.stop
        self.watch(time, end, solution, monitored)

    def judge(self, time, solution, is_first, is_last):
        """Raise Discard or EnergyCreated for a macro step that cannot be accepted.

        An output that is recorded is not finite at `time`, or the macro step created spurious
        energy. `accepted` takes over the exchange of its parts.
        """
        if wrong := self.recorder.not_finite(time):
            port, value = next(iter(wrong.items()))
            raise NotFinite(f"{port}: expected a finite output, got {value}")
        work, balances = self.account.work, self.account.ledger
        if not work.pairs:
            return
        parts = [] if is_first else self.parts
        end = time, solution.inputs, self.stepper.interface.read()
        exchange = work.exchange(parts[-1].end if parts else work.last, end)
        balance = balances.balance(self.system.participants, exchange) if balances else None
        self.parts = [*parts, JudgedPart(is_first, end, exchange, balance)]
        if balances and is_last:
            balances.check(total_balance([part.balance for part in self.parts]))

    def write_checkpoint(self):
        """Write a checkpoint, if all participants can serialise their states."""
        if not all(participant.can_serialise for participant in self.system.participants.values()):
            return
        begin = clock.perf_counter()
        if self.account.steps_done:
            self.recorder.flush()
            self.account.rows = self.recorder.rows
        self.log.flush()
        self.account.wall_time = begin - self.begin
        self.account.warnings = [(name, *warning) for name, warning in self.warnings()]
        with writing(Checkpoint.path(self.output)):
            Checkpoint(
                tree=self.tree,
                folder=self.system.folder,
                frozen=freeze(self.stepper),
                account=self.account,
                fmus=self.fingerprints,
                sources=self.sources,
            ).write(self.output)
        end = clock.perf_counter()
        self.next_checkpoint = end + (end - begin) / CHECKPOINT_SHARE
        self.account.spent["recording"] += end - begin

    def warnings(self):
        """Return the warnings since the start of the run; a resumed one repeats those of it."""
        later = logged_warnings(self.system)
        if self.is_resumed:
            later = [one for one in later if one[1].time is not None]
        return merged(self.earlier, [*later, *self.stepper.warned()])

    @cached_property
    def fingerprints(self):
        """Hashes of the participants' FMUs and tables."""
        return fingerprints(self.system.participants)

    @cached_property
    def sources(self):
        """Hashes of the Python files that the case names."""
        return source_hashes(self.tree, self.system.folder)

    def close(self):
        """Close the files."""
        self.recorder.close()
        self.log.close()
        for observer in self.observers:
            observer.close()


def logged_warnings(system):
    """Return pairs of participant and `LoggedWarning`; none of a process that has ended."""
    pairs = []
    for name, participant in system.participants.items():
        with suppress(ParticipantFault):
            pairs += [(name, warning) for warning in getattr(participant, "warned", list)()]
    return pairs


def _step_control(system, coupling):
    """Return the step control of the wires, or that of another package."""
    if coupling.step_control is None:
        return step_control(system.wires, system.smallest_step)
    arguments = system.wires, system.smallest_step, coupling.options
    return from_plugin("step_controls", coupling.step_control, *arguments)


def monitors(case, system):
    """Return the monitor entries: (name, port, unit) of each."""
    ports = {name: port_of(reduced(text).port) for name, text in case.monitor.items()}
    return [
        (name, port, system.participants[port[0]].fields[port[1]].unit)
        for name, port in ports.items()
    ]


def summarise(account, control, wall_time):
    """Return the summary of a finished run.

    Only `explicit` coupling accepts steps that have not converged.
    """
    counters = account.counters
    controlled = {}
    if control:
        controlled["rejected_steps"] = counters.rejected_steps
        controlled["inaccurate_smallest_steps"] = control.at_smallest
    spent = account.spent | {"acceleration": wall_time - sum(account.spent.values())}
    return {
        "steps": counters.steps,
        "unconverged_steps": counters.unconverged_steps,
        **({"unsettled_steps": counters.unsettled_steps} if counters.unsettled_steps else {}),
        "halved_steps": counters.halved_steps,
        **{name: count for name in PARTS if (count := getattr(counters, name))},
        **controlled,
        "mean_iterations": float(np.mean(counters.iterations)),
        "max_iterations": int(np.max(counters.iterations)),
        "residual_evaluations": counters.residual_evaluations,
        "jacobian_evaluations": counters.jacobian_evaluations,
        "derivative_products": counters.derivative_products,
        "wall_time_s": wall_time,
        **{f"wall_time_{name}_s": seconds for name, seconds in spent.items()},
        **account.work.summary(),
        **_of_ledger(account),
        **{r.name: r.result() for r in account.reductions},
    }


PARTS = "repeated_steps", "steps_without_parts"
"""Counters of parts of macro steps, which the summary has if they are not 0."""


def _of_ledger(account):
    """Return the summary entries of the participants' energy; empty without a ledger."""
    if account.ledger is None:
        return {}
    refused = {"energy_refused_steps": account.counters.energy_refused_steps}
    return account.ledger.summary() | refused


def versions():
    """Return the versions of all packages that affect the results."""
    return {"python": platform.python_version(), **{name: version(name) for name in VERSIONS}}
