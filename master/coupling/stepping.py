"""Macro steps of a run: predict the wires, converge, then accept, halve or repeat the step.

`Stepper.advance` has three ways through an interval:

- `_advance_by_control`: steps of the lengths that step control chooses, each by
  `_try_controlled_step`;
- `_advance_by_ticks`: macro steps that end where clocks tick;
- otherwise one macro step.

`_take_macro_step` takes a macro step of the last two kinds. It first tries
`_take_resolved_parts`, whose parts are short enough for the motion of the participants, and
otherwise `_take_converged_parts`, whose parts converge.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from time import perf_counter
from typing import Any

import numpy as np

from ..fmi.errors import Discard, ParticipantFault, Stopped, Ticked
from ..participants.participant import block_of
from ..participants.warned import LoggedWarnings, NamedWarning
from .events import LARGEST_ITERATION, TIME_TOLERANCE, EndlessEvents, Events
from .interface import SMALL_VECTOR, Interface
from .methods import MacroStep, Method, NotConverged, Solution
from .methods.explicit import Explicit
from .settling import solve_settled
from .step_control import StepControl
from .vector import extrapolate, is_longer, joined, lagrange, step_length
from .wiring import HeldWire, System

Judge = Callable[[float, Solution, bool, bool], None]

REPETITIONS = 5
"""Largest number of halvings of a macro step that is too long for the motion."""
WITHOUT_PARTS = "a macro step was taken without parts, because a part of it failed"


class StepFailed(Stopped):
    """Macro step that does not converge after all halvings: the run stops."""

    headline = "a macro step failed"


class EnergyCreated(RuntimeError):
    """A macro step that converged but created spurious energy (`ledger`)."""


class Unresolved(RuntimeError):
    """A macro step that converged but is too long for the motion of a participant."""


@dataclass
class Counters:
    """Effort of the run.

    Residual and Jacobian evaluations are counted as by an implicit integrator, with probes.
    """

    steps: int = 0
    halved_steps: int = 0
    repeated_steps: int = 0
    steps_without_parts: int = 0
    rejected_steps: int = 0
    iterations: list[int] = field(default_factory=list[int])
    residual_evaluations: int = 0
    jacobian_evaluations: int = 0
    derivative_products: int = 0
    unconverged_steps: int = 0
    unsettled_steps: int = 0
    energy_refused_steps: int = 0

    def accept(self, solution: Solution) -> None:
        iterations = len(solution.history)
        self.steps += 1
        self.iterations.append(iterations)
        self.unconverged_steps += solution.history[-1] > 1.0
        self.unsettled_steps += solution.unsettled > 0
        self.residual_evaluations += iterations + solution.probes
        self.jacobian_evaluations += solution.jacobians
        self.derivative_products += solution.products


@dataclass
class Attempt:
    """Attempt at a part of a macro step, which is not reported to the observer yet.

    saved : states of the participants at its begin; trail : measures of the wires by evaluation;
    solution : None if it did not converge; failure : why it was rolled back, or None.
    """

    begin: float
    length: float
    saved: dict[str, Any]
    trail: list[list[float]]
    solution: Solution | None = None
    failure: Exception | None = None


class Predictor:
    """Extrapolation through the last accepted vectors; order 0 repeats the last one."""

    def __init__(self, order: int):
        self.order = order
        self.past: list[tuple[float, np.ndarray]] = []

    def keep(self, time: float, x: np.ndarray) -> None:
        """Add an accepted vector."""
        self.past = [*self.past, (time, x)][-self.order - 1 :]

    def clear(self) -> None:
        """Remove all but the last vector."""
        self.past = self.past[-1:]

    def __call__(self, time: float) -> np.ndarray:
        """Return the guess at `time` [s]."""
        if not self.past[1:]:
            return self.past[0][1] + 0.0  # as `extrapolate`, which has no -0
        times, vectors = zip(*self.past)
        size = len(vectors[0])
        if size > SMALL_VECTOR:
            return extrapolate(times, vectors, time)
        weights = [0.0] * len(times)
        lagrange(times, time, weights)
        guess = [0.0] * size
        for weight, vector in zip(weights, vectors):
            guess = [a + b * weight for a, b in zip(guess, vector.tolist())]
        return np.array(guess)


class Observer:
    """Observer of a stepper, which does nothing unless a method is replaced."""

    def attempted(
        self, time: float, step: float, trail: list[list[float]], failure: object | None
    ) -> None:
        """Observe an attempt at the macro step, or a part of it, from `time` over `step` [s].

        It is not accepted yet; if it failed, the participants may be rolled back already. trail :
        measures of the wires by evaluation; failure : exception or text, or None.
        """

    def accepted(self, time: float, solution: Solution) -> None:
        """Observe an accepted step, or part of it, that ends at `time` [s]."""


class Stepper:
    """Takes macro steps of a started system.

    Parameters
    ----------
    system : System
        Its participants must have been started.
    method : Method
    halvings : int
        Maximum number of successive halvings of a macro step.
    observer : Observer
    order : int
        Order of the predictor.
    control : StepControl, optional
        Chooses the lengths of macro steps. If omitted, a macro step is as long as the interval of
        `advance`.
    held : sequence of HeldWire
        Wires of the system that are not iterated.
    begin : float
        Time of the participants at the start [s].
    judge : callable(time, solution, is_first, is_last), optional
        Called after a converged part of a macro step that ends at `time` [s], the first or the last
        one. Raises EnergyCreated if the macro step created energy.
    clocks : sequence of HeldWire
        Wires from clock to clock.
    """

    def __init__(
        self,
        system: System,
        method: Method,
        halvings: int,
        observer: Observer | None = None,
        order: int = 2,
        control: StepControl | None = None,
        held: Sequence[HeldWire] = (),
        *,
        begin: float = 0.0,
        judge: Judge | None = None,
        clocks: Sequence[HeldWire] = (),
    ):
        self.interface = Interface(
            {name: system.participants[name] for name in system.order},
            system.wires,
            system.parallel,
            [wire for wire in held if not wire.clocked],
        )
        self.events = Events(self.interface.participants, held, clocks)
        self.method = method if self.interface.size or self.interface.discrete else Explicit()
        self.halvings = halvings
        self.observer = observer or Observer()
        self.judge: Judge = judge or _accept_all
        self.control = control
        self.counters = Counters()
        self.failures: list[str] = []
        self.warnings: dict[str, LoggedWarnings] = {}
        self.memory = self.method.memory()
        # a step that is neither iterated nor halved needs no saved state
        self._saves = not isinstance(self.method, Explicit) or bool(
            halvings or control or self.events
        )
        self._was_not_finite = False
        redone = all(getattr(one, "can_redo", True) for one in system.participants.values())
        self.limits = system.limits if redone and not isinstance(self.method, Explicit) else ()
        self._limit_blocks = [block_of(system.participants[p], (v,)) for p, v in self.limits]
        self._limits_control = bool(self.limits) and hasattr(control, "resolves")
        self.predictor = Predictor(order)
        self.predictor.keep(begin, self.interface.read())

    def advance(self, time: float, step: float) -> None:
        """Advance all participants from time to time + step [s].

        This takes one macro step, or those of step control. A macro step is rolled back if it does
        not converge, if a participant discards it, or if it creates energy. Then the history is
        cleared, and the step is taken in two halves or as step control decides. If the local error
        is too large, a shorter step follows. A macro step ends where clocks tick (`Events`).
        Raises StepFailed if no halving is left.
        """
        try:
            if self.control:
                self._advance_by_control(self.control, time, step)
            elif self.events:
                self._advance_by_ticks(time, step)
            else:
                self._take_macro_step(time, step, self.halvings)
        except EndlessEvents as failure:
            raise StepFailed(str(failure)) from None

    def warn(self, name: str, text: str, time: float | None) -> None:
        """Count a warning about a wire or an output; time : of the macro step [s], None: start."""
        self.warnings.setdefault(name, LoggedWarnings()).add(text, time)

    def warned(self) -> list[NamedWarning]:
        """Return the first warning of each kind about each wire or output."""
        return [(name, one) for name, many in self.warnings.items() for one in many.all()]

    def _advance_by_ticks(self, time: float, step: float) -> None:
        """Take macro steps from one tick of a clock to the next."""
        end = time + step
        for _ in range(LARGEST_ITERATION):
            length = self.events.length(time, end - time)
            time = self._take_macro_step(time, length, self.halvings)
            if end - time <= TIME_TOLERANCE * step:
                return
        raise EndlessEvents(f"t = {time:.6g} s: {LARGEST_ITERATION} clock ticks in a macro step")

    def _take_macro_step(self, time: float, step: float, halvings: int) -> float:
        """Take a macro step; return the time reached [s].

        If participants limit the step, it is first tried in parts that resolve their motion. If
        these fail, or without limits, it is only halved until it converges. A tick of a clock ends
        the step before time + step.
        """
        most = min(REPETITIONS, halvings) if self.limits else 0
        try:
            if most and self._take_resolved_parts(time, step, most):
                return time + step
        except Ticked as tick:
            return self._take_macro_step(time, tick.time - time, halvings)
        return self._take_converged_parts(time, step, halvings)

    def _take_converged_parts(self, time: float, step: float, halvings: int) -> float:
        """Take a macro step in parts that converge; return the time reached [s].

        The first part is the whole step. A part that fails is halved, at most `halvings` times.
        Each part is accepted at once. A tick of a clock ends the step as for `_take_macro_step`.
        """
        depth = done = 0  # halvings, and parts of this length that are done
        while done < 1 << depth:
            length = step / (1 << depth)
            begin = time + done * length
            saved = self._save()
            try:
                solution = self._converge(begin, length, saved)
                self.judge(begin + length, solution, True, True)
                self.predictor.keep(begin + length, solution.x)
                self._accept(begin, length, solution, self.interface.trail)
            except Ticked as tick:
                self._roll_back(begin, length, saved, tick)
                return self._take_macro_step(begin, tick.time - begin, halvings - depth)
            except (NotConverged, Discard, EnergyCreated) as failure:
                self._roll_back_failed(begin, length, saved, failure, depth < halvings)
                done, depth = 2 * done, depth + 1
            else:
                done += 1
                if depth > 0:
                    done, depth = joined(done, depth)
            finally:
                self._free(saved)
        return time + step

    def _take_resolved_parts(self, time: float, step: float, most: int) -> bool:
        """Take a macro step in parts that resolve the motion of all participants.

        A part is halved, at most `most` times, if it is too long for the motion or does not
        converge. The parts are accepted together when the macro step is complete. Return False and
        restore the start if the smallest part does not converge, or if the parts together create
        energy.
        """
        past = self.predictor.past
        longest = self._longest_step()
        attempts: list[Attempt] = []
        depth = done = 0
        try:
            while done < 1 << depth:
                while depth < most and is_longer(step / (1 << depth), longest):
                    done, depth = 2 * done, depth + 1
                length = step / (1 << depth)
                saved = self._save()
                part = Attempt(time + done * length, length, saved, self.interface.trail)
                attempts.append(part)
                self._solve_part(part, done == 0, done + 1 == 1 << depth, depth < most)
                longest = self._longest_step()
                if part.failure is None:
                    done, depth = joined(done + 1, depth)
                    continue
                self._restore(saved)
                if isinstance(part.failure, Unresolved):
                    self.counters.repeated_steps += 1
                    continue
                created = isinstance(part.failure, EnergyCreated)
                if depth == most or created and done:
                    self._undo_parts(attempts, past, part.failure)
                    self.counters.steps_without_parts += 1
                    self.warn(".".join(next(iter(self.limits))), WITHOUT_PARTS, time)
                    self.counters.energy_refused_steps += created
                    return False
                self._record_failure(part.begin, length, part.failure)
                longest = self._longest_step()
                done, depth = 2 * done, depth + 1
            self._accept_parts(attempts)
        except Ticked as tick:
            self._undo_parts(attempts, past, tick)
            raise
        finally:
            for one in attempts:
                self._free(one.saved)
        return True

    def _solve_part(self, part: Attempt, is_first: bool, is_last: bool, may_halve: bool) -> None:
        """Solve a part of a macro step; set its solution and its failure, if it has one."""
        end = part.begin + part.length
        try:
            part.solution = self._converge(part.begin, part.length, part.saved)
            longest = self._longest_step()
            if may_halve and is_longer(part.length, longest):
                raise Unresolved(f"the motion needs steps of {longest:.3g} s")
            self.judge(end, part.solution, is_first, is_last)
            self.predictor.keep(end, part.solution.x)
        except (Unresolved, NotConverged, Discard, EnergyCreated) as failure:
            part.failure = failure

    def _accept_parts(self, attempts: Sequence[Attempt]) -> None:
        """Count and report all attempts at a macro step, each at the state after it."""
        last = self._save() if sum(one.failure is None for one in attempts) > 1 else {}
        ends = [one.saved for one in attempts[1:]] + [last]
        try:
            for one, end in zip(attempts, ends):
                if one.solution is not None and one.failure is None:
                    if last:
                        self._restore(end)
                    self._accept(one.begin, one.length, one.solution, one.trail)
                else:
                    self.observer.attempted(one.begin, one.length, one.trail, one.failure)
                    self.counters.residual_evaluations += len(one.trail)
        finally:
            self._free(last)

    def _undo_parts(self, attempts: Sequence[Attempt], past: Any, reason: Exception) -> None:
        """Return to the start of a macro step whose parts fail for a reason; report them."""
        self._restore(attempts[0].saved)
        self.predictor.past = past
        self.memory = self.method.memory()
        for one in attempts:
            self.counters.residual_evaluations += len(one.trail)
            failure = one.failure or f"undone: {reason}"
            self.observer.attempted(one.begin, one.length, one.trail, failure)

    def _longest_step(self) -> float:
        """Return the longest step that resolves the motion of all participants [s]."""
        for block in self._limit_blocks:
            block.get()
        return min((float(block.values[0]) for block in self._limit_blocks), default=inf)

    def _advance_by_control(self, control: StepControl, time: float, step: float) -> None:
        """Take macro steps of the lengths that step control chooses, to the next tick at most."""
        end = time + step
        tick = end
        while time < end:
            rest = self.events.length(time, end - time) if self.events else end - time
            rest = min(rest, tick - time) if tick > time else rest
            length, last = control.length(rest)
            try:
                if self._try_controlled_step(control, time, length):
                    whole = last and rest == end - time
                    time = end if whole else time + (rest if last else length)
            except Ticked as early:
                tick = early.time

    def _try_controlled_step(self, control: StepControl, time: float, step: float) -> bool:
        """Try one macro step; return whether it was accepted. Step control sets the next length."""
        saved = self._save()
        try:
            solution = self._converge(time, step, saved)
            longest = self._longest_step() if self._limits_control else inf
            if self._limits_control and not control.resolves(step, longest):
                reason = Unresolved(f"the motion needs steps of {longest:.3g} s")
                self.counters.repeated_steps += 1
            elif not control.accepts(self.predictor.past[-1], time, step, solution):
                reason = f"local error {control.error:.2g} times the allowed one"
                self.counters.rejected_steps += 1
            else:
                self.judge(time + step, solution, True, True)
                self.predictor.keep(time + step, solution.x)
                self._accept(time, step, solution, self.interface.trail)
                if self._limits_control:
                    control.limit(longest)
                return True
            self._roll_back(time, step, saved, reason)
        except Ticked as tick:
            self._roll_back(time, step, saved, tick)
            raise
        except (NotConverged, Discard, EnergyCreated) as failure:
            self._roll_back_failed(time, step, saved, failure, control.halve(step))
        finally:
            self._free(saved)
        return False

    def _save(self) -> dict[str, Any]:
        self.interface.begin()
        begun = perf_counter()
        saved: dict[str, Any] = {}
        for name, p in self.interface.participants.items():
            if self._saves:
                saved[name] = p.save()
            elif begin_here := getattr(p, "begin_here", None):
                begin_here()
        self.interface.spent["transport"] += perf_counter() - begun
        return saved

    def _free(self, saved: Mapping[str, Any]) -> None:
        begun = perf_counter()
        for name, state in saved.items():
            self.interface.participants[name].free(state)
        self.interface.spent["transport"] += perf_counter() - begun

    def _accept(
        self, time: float, step: float, solution: Solution, trail: list[list[float]]
    ) -> None:
        """Count an accepted step, and report it to the observer."""
        self.observer.attempted(time, step, trail, None)
        self._was_not_finite = False
        self.counters.accept(solution)
        for name, text in solution.messages:
            self.warn(name, text, time)
        self.observer.accepted(time + step, solution)

    def _roll_back(
        self, time: float, step: float, saved: Mapping[str, Any], reason: object
    ) -> None:
        self.observer.attempted(time, step, self.interface.trail, reason)
        self.counters.residual_evaluations += len(self.interface.trail)
        self._restore(saved)

    def _restore(self, saved: Mapping[str, Any]) -> None:
        for name, state in saved.items():
            self.interface.participants[name].restore(state)

    def _roll_back_failed(
        self,
        time: float,
        step: float,
        saved: Mapping[str, Any],
        failure: NotConverged | Discard | EnergyCreated,
        may_halve: bool,
    ) -> None:
        """Roll back a failed step and clear the history.

        Raises StepFailed if the step cannot be halved, or if the failure is final.
        """
        # the inputs of a first evaluation are accepted values: a second NaN is no accident
        not_finite = getattr(failure, "is_not_finite", False)
        is_final = getattr(failure, "is_final", False) or (not_finite and self._was_not_finite)
        is_final = is_final or not may_halve
        try:
            self._roll_back(time, step, saved, failure)
        except ParticipantFault as fault:
            if not getattr(failure, "is_final", False):
                raise ParticipantFault(f"{failure}; {fault}") from None
        self._was_not_finite = not_finite
        self._record_failure(time, step, failure, is_final)
        if is_final:
            raise StepFailed(self.failures[-1]) from failure

    def _record_failure(
        self, time: float, step: float, failure: Exception, is_final: bool = False
    ) -> None:
        """Record a failed step and clear the history; if it is not final, the step is halved."""
        reason = str(failure)
        if is_final and isinstance(failure, NotConverged):
            reason = failure.explained()
        self.failures.append(f"t = {time:.6g} s, step {step:.3g} s: {reason}")
        self.predictor.clear()
        self.memory = self.method.memory()
        self.counters.energy_refused_steps += isinstance(failure, EnergyCreated)
        self.counters.halved_steps += not is_final

    def _converge(self, time: float, step: float, saved: dict[str, Any]) -> Solution:
        start, share = self.predictor.past[-1][1], 1.0
        guess = self.predictor(time + step)
        if self.interface.is_limited or self.predictor.past[1:]:
            guess -= start
            if self.interface.is_limited:
                share = step_length(self.interface.layout, start, guess)
            guess *= share
            guess += start
        macro_step = MacroStep(self.interface, time, step, saved, share)
        return solve_settled(self.method, macro_step, guess, self.memory)


def _accept_all(time: float, solution: Solution, is_first: bool, is_last: bool) -> None:
    """Accept every part of a macro step."""
