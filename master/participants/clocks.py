"""FMI 3.0 FMUs with clocks: timed by their intervals, triggered by others, or outputs."""

import ctypes
from contextlib import suppress
from dataclasses import dataclass, field
from math import inf
from typing import Any

import numpy as np
from fmpy import fmi3

from ..fmi.errors import BadInput, CallFailed, Discard, Ticked
from .fmi2 import TIME_TOLERANCE, FmuParticipant
from .fmi3 import LARGEST_ITERATION, Fmu3Participant
from .plain import pack, unpack

PERIODIC = ("constant", "fixed", "tunable")
"""Kinds of input clocks with a constant interval. Tunable ones are included because no parameter
changes during a run."""
KINDS = (*PERIODIC, "changing", "countdown", "triggered")


@dataclass(frozen=True)
class Clock:
    """Clock of a model description: interval and shift [s], None if the FMU must be asked.

    kind : one of KINDS.
    """

    name: str
    reference: int
    causality: str
    kind: str
    interval: float | None
    shift: float | None


@dataclass
class Clockwork:
    """State of an FMU's clocks, in addition to the FMU's own state.

    due    : input clock -> (base [s], interval [s], ticks since the base), see Eq. (P7)
    ticked : output clocks that have ticked and have not been read since
    values : clocked variables: inputs for the next tick, outputs of the last tick
    """

    due: dict[str, tuple[float, float, int]] = field(default_factory=dict)
    ticked: list[str] = field(default_factory=list)
    values: dict[str, Any] = field(default_factory=dict)

    def copy(self) -> "Clockwork":
        return Clockwork(dict(self.due), list(self.ticked), dict(self.values))

    def instant(self, name: str) -> float:
        """Return the time of the next tick of an input clock [s].

        Eq. (P7):  t = base + ticks x interval
        """
        base, interval, ticks = self.due[name]
        return base + ticks * interval  # Eq. (P7)


class ClockedFmu3(Fmu3Participant):
    """FMI 3.0 FMU in Event Mode, with clocks.

    `set(clock, True)` ticks a triggered input clock. `get(clock)` returns whether an output clock
    has ticked, once for each tick, as fmi3GetClock does. Clocked inputs take effect when one of
    their clocks ticks. Clocked outputs have the values of the last tick.

    Raises
    ------
    BadInput
        If a clock has no interval above 0.
    """

    has_clocks = True

    def __init__(self, name, path, sizes=None, elements=()):
        super().__init__(name, path, sizes, elements)
        try:
            described = [_clock(node) for node in self._model_description().iter("Clock")]
        except (TypeError, ValueError, ArithmeticError) as error:
            raise BadInput(f"participants.{name}: {path}, clocks: {error}") from None
        self.clocks = {clock.name: clock for clock in described}
        by_reference = {clock.reference: clock.name for clock in described}
        self._clocks_of: dict[str, set[str]] = {}
        for variable in self.description.modelVariables:
            if variable.clocks:
                references = {clock.valueReference for clock in variable.clocks}
                if not references <= by_reference.keys():
                    raise BadInput(
                        f"participants.{name}: {path}, {variable.name}: expected clocks, "
                        "got other variables"
                    )
                self._clocks_of[variable.name] = {by_reference[k] for k in references}
        self._timed = [c for c in self._inputs() if c.kind != "triggered"]
        self._announced = [c for c in self.clocks.values() if c.causality == "output"]
        self._stops: frozenset[str] = frozenset()

    def _inputs(self):
        return [clock for clock in self.clocks.values() if clock.causality == "input"]

    def enter(self, parameters, start_time, stop_time):
        self._work, self._now, self._running = Clockwork(), start_time, False
        super().enter(parameters, start_time, stop_time)

    def leave(self):
        """Leave Initialization Mode, see `FmuParticipant.leave`.

        Before their first tick, clocked outputs have the values that the FMU returns here, or zero.
        """
        for name in self._clocks_of:
            field = self.fields[name]
            if field.causality == "output":
                nothing = {"String": "", "Binary": b""}.get(field.type, 0)
                self._work.values[name] = np.full(field.shape, nothing) if field.shape else nothing
                with suppress(CallFailed):
                    self._work.values[name] = super().get(name)
        super().leave()

    def stop_at(self, clocks):
        """Raise `Ticked` in every step in which one of these output clocks ticks."""
        self._stops = frozenset(clocks)

    def next_tick(self):
        """Return the time of the next tick of the timed input clocks [s], or infinity."""
        return min(map(self._work.instant, self._work.due), default=inf)

    def tick(self, time, step):
        """Tick the input clocks that are due at `time`, within a tolerance of the next step [s]."""
        for _ in range(LARGEST_ITERATION):
            due = [
                c for c in self._work.due if self._work.instant(c) <= time + TIME_TOLERANCE * step
            ]
            if not due:
                return
            self._now = time
            self._event(due)
        raise Discard(f"{self.name}: {due[0]} ticks without end at t = {time:.6g} s")

    def set(self, name, value):
        """Set a field; a triggered clock ticks if it is set to true."""
        if name in self.clocks:
            if value:
                self._event([name])
        elif self._begun and name in self._clocks_of:
            self._work.values[name] = value
        else:
            super().set(name, value)

    def get(self, name):
        """Return a field; for an output clock, whether it has ticked since the last call."""
        if name in self.clocks:
            ticked = name in self._work.ticked
            if ticked:
                self._work.ticked.remove(name)
            return ticked
        return self._work.values[name] if name in self._work.values else super().get(name)

    def lister(self, names):
        """Return a function that lists the values of several scalars."""
        return lambda: [self.get(name) for name in names]

    def _are_double(self, names):
        return super()._are_double(names) and not any(name in self._clocks_of for name in names)

    def _event(self, active):
        """Tick input clocks in an event."""
        self._fmu.enterEventMode()
        self._fmu.setClock([self.clocks[name].reference for name in active], [True] * len(active))
        for name, clocks in self._clocks_of.items():
            is_input = self.fields[name].causality == "input"
            if is_input and name in self._work.values and not clocks.isdisjoint(active):
                FmuParticipant.set(self, name, self._work.values[name])
        for name in active:
            if name in self._work.due:
                base, interval, ticks = self._work.due.pop(name)
                if self.clocks[name].kind in PERIODIC:
                    self._work.due[name] = base, interval, ticks + 1
        self._settle_events(active)
        self._fmu.enterStepMode()

    def _settle_events(self, active=()):
        """Update discrete states as `Fmu3Participant`; first read clocks and clocked outputs."""
        if not self._running:
            self._begin()
        for _ in range(LARGEST_ITERATION):
            self._read_ticks(active)
            self._ask_intervals()
            again, end = self._update_discrete_states()
            active = ()
            if end or not again:
                self._ask_intervals()
                return end
        raise Discard(f"{self.name}: an event without end")

    def _read_ticks(self, active):
        """Save the output clocks that tick, and the outputs of all clocks that tick."""
        ticking = set(active)
        if self._announced:
            answers = self._fmu.getClock([clock.reference for clock in self._announced])
            new = [clock.name for clock, answer in zip(self._announced, answers) if answer]
            self._work.ticked += [name for name in new if name not in self._work.ticked]
            ticking.update(new)
        for name, clocks in self._clocks_of.items():
            if self.fields[name].causality == "output" and not ticking.isdisjoint(clocks):
                self._work.values[name] = super().get(name)

    def _begin(self):
        """Compute the first tick of each clock from its shift; countdowns announce it at events."""
        self._running = True
        for clock in self._timed:
            shift = self._shift(clock)
            if clock.kind in PERIODIC:
                interval, _ = self._interval(clock)
                if not 0.0 < interval < inf:
                    raise BadInput(
                        f"{self.name}.{clock.name}: expected an interval above 0 s, got "
                        f"{interval:g} s"
                    )
                self._work.due[clock.name] = self._now + shift, interval, 0
            elif clock.kind == "changing":
                self._work.due[clock.name] = self._now, shift, 1

    def _ask_intervals(self):
        """Update the next ticks that clocks announce at events.

        Countdown clocks may announce them at any event, changing clocks after they have ticked.
        """
        for clock in self._timed:
            ticked = clock.kind == "changing" and clock.name not in self._work.due
            if clock.kind == "countdown" or ticked:
                interval, qualifier = self._interval(clock)
                news = (fmi3.fmi3IntervalChanged, fmi3.fmi3IntervalUnchanged)
                if qualifier in news[: 1 + ticked]:
                    self._work.due[clock.name] = self._now, interval, 1

    def _interval(self, clock):
        """Return interval [s] and qualifier of a clock; ask the FMU if the description has none."""
        if clock.interval is not None and clock.kind in PERIODIC:
            return clock.interval, fmi3.fmi3IntervalUnchanged
        reference = (fmi3.fmi3ValueReference * 1)(clock.reference)
        interval = (fmi3.fmi3Float64 * 1)()
        qualifier = (fmi3.fmi3IntervalQualifier * 1)()
        self._fmu.getIntervalDecimal(reference, interval, qualifier)
        return interval[0], qualifier[0]

    def _shift(self, clock):
        """Return the shift of a clock's first tick [s]."""
        if clock.shift is not None or clock.kind == "changing":
            return clock.shift or 0.0
        if clock.kind == "constant":
            return 0.0
        reference, shift = (fmi3.fmi3ValueReference * 1)(clock.reference), ctypes.c_double()
        self._fmu.getShiftDecimal(reference, ctypes.pointer(shift))
        return shift.value

    def _do_step(self, time, step):
        super()._do_step(time, step)
        self._now = time + step

    def _handle_event(self, reached, end, step):
        """Handle an event inside a step; raise `Ticked` if others must receive it now."""
        self._now = reached
        finished = super()._handle_event(reached, end, step)
        inside = end - step + TIME_TOLERANCE * step < reached < end - TIME_TOLERANCE * step
        if inside and not self._stops.isdisjoint(self._work.ticked):
            raise Ticked(self.name, reached)
        return finished

    def save(self):
        """Return a handle of the FMU's state and the state of its clocks."""
        return super().save(), self._work.copy(), self._now

    def restore(self, saved):
        """Restore a saved state, where the next step begins."""
        handle, work, self._now = saved
        self._work = work.copy()
        super().restore(handle)
        self._begin = saved

    def free(self, saved):
        super().free(saved[0])

    def serialise(self, saved):
        """Return the saved state as bytes."""
        handle, work, now = saved
        return pack((super().serialise(handle), work, now), (Clockwork,))

    def deserialise(self, data):
        """Return a handle of the state in bytes of `serialise`."""
        state, work, now = unpack(data, (Clockwork,))
        return super().deserialise(state), work, now


def _clock(node):
    """Return the clock of an XML element; raise `ValueError` if it is invalid."""
    kind = node.get("intervalVariability")
    if kind not in KINDS:
        raise ValueError(f"expected intervalVariability {', '.join(KINDS)}, got {kind!r}")
    return Clock(
        name=str(node.get("name")),
        reference=int(node.get("valueReference")),
        causality=node.get("causality", "local"),
        kind=kind,
        interval=_seconds(node, "interval"),
        shift=_seconds(node, "shift"),
    )


def _seconds(node, what):
    """Return interval or shift of a clock [s], from its decimal or counter; else None.

    Eq. (P8):  t = counter / resolution
    """
    if (decimal := node.get(f"{what}Decimal")) is not None:
        return float(decimal)
    counter, resolution = node.get(f"{what}Counter"), node.get("resolution")
    return None if counter is None or not resolution else int(counter) / int(resolution)  # Eq. (P8)
