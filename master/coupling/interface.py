"""The coupled wires as one vector, one evaluation of all participants, and its derivative."""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from ..fmi.errors import Discard, ParticipantFault
from ..participants.derivatives import DIFFERENCE, NEGLIGIBLE
from ..participants.participant import Participant, block_of, derive_each
from .vector import Evaluation, largest
from .wiring import HeldWire, Wire, is_unknown, layout_of

SMALL_VECTOR = 16
"""Elements up to which a loop in Python is faster than operations on arrays."""


class End(NamedTuple):
    """One participant's end of a wire: its variable, the wire's part of the vector, its shape."""

    variable: str
    part: slice
    shape: tuple[int, ...]


class Ends:
    """All ends of wires at one participant, moved together.

    A single element is moved as a number, which is faster.

    Parameters
    ----------
    participant : Participant
    inputs, outputs : sequence of End
        By their part of the vector.
    feedback : ndarray of bool, shape (size,)
        See `Interface`.
    """

    def __init__(
        self,
        participant: Any,
        inputs: Sequence[End],
        outputs: Sequence[End],
        feedback: np.ndarray,
    ):
        self.participant = participant
        self.inputs = tuple(end.variable for end in inputs)
        self.outputs = tuple(dict.fromkeys(end.variable for end in outputs))
        self.written = block_of(participant, self.inputs, "written")
        self.taken = block_of(participant, self.outputs)
        self.derive = getattr(participant, "derive", None) or partial(derive_each, participant)
        self.nominals = [participant.fields[name].nominal for name in self.inputs]
        ends = np.cumsum([0, *(end.part.stop - end.part.start for end in inputs)])
        self.starts = ends[:-1]
        self.into, self.of_written = _positions([end.part for end in inputs])
        self.out, self.of_taken = _positions([end.part for end in outputs])
        if (repeated := _repeated(outputs)) is not None:
            self.of_taken = repeated
        forward = [end.part for end in outputs if not feedback[end.part.start]]
        self.forward = _positions(forward)[0] if forward else None

    def feed(self, values: Any) -> None:
        """Set the inputs to their elements of the vector."""
        self.written.values[self.of_written] = values
        self.written.put()

    def differentiate(self, change: np.ndarray, result: np.ndarray) -> None:
        """Write the change of the outputs for a change of the inputs."""
        values = self.derive(self.inputs, np.atleast_1d(change[self.into]), self.outputs)
        result[self.out] = values[self.of_taken]

    def values(self) -> Any:
        """Return the outputs by their ends; the next call may overwrite them."""
        self.taken.get()
        return self.taken.values[self.of_taken]

    def collect(self, used: np.ndarray, y: np.ndarray) -> None:
        """Collect the outputs; later participants use those of wires along the order."""
        if self.outputs:
            y[self.out] = self.values()
        if self.forward is not None:
            used[self.forward] = y[self.forward]

    def largest_change(self, change: Any, values: Any) -> float:
        """Return the largest change of an input, relative to its nominal value or its size."""
        if self.of_written == 0:
            return abs(change) / (self.nominals[0] or abs(values) or 1.0)
        pairs = [np.maximum.reduceat(np.abs(v), self.starts).tolist() for v in (change, values)]
        return largest([a / (n or b or 1.0) for n, a, b in zip(self.nominals, *pairs)])


def _repeated(ends: Sequence[End]) -> np.ndarray | None:
    """Return the indices of the ends' elements among those of their distinct variables.

    Return None if each end has a different variable.
    """
    sizes = {end.variable: end.part.stop - end.part.start for end in ends}
    if len(sizes) == len(ends):
        return None
    parts = dict(zip(sizes, _slices(list(sizes.values()))))
    return np.concatenate(
        [np.arange(*parts[end.variable].indices(sum(sizes.values()))) for end in ends]
    )


def _positions(parts: Sequence[slice]) -> tuple[Any, Any]:
    """Return the indices of parts of the vector, and of all elements of a copy of these parts.

    They are a number for one element, and a slice if the parts are contiguous.
    """
    elements = np.array([k for part in parts for k in range(part.start, part.stop)], int)
    if len(elements) == 1:
        return int(elements[0]), 0
    if all(one.stop == other.start for one, other in zip(parts, parts[1:])):
        return (slice(parts[0].start, parts[-1].stop) if parts else slice(0, 0)), slice(None)
    return elements, slice(None)


class Interface:
    """Vector layout of all wires.

    The vector x contains the values that the targets read, wire after wire. `feedback` marks the
    elements of wires against the stepping order. They are the unknowns of a sequential
    (Gauss-Seidel) evaluation. `unknowns` are their positions, and `feedback_wires` is the slice of
    each wire among them. In norms, an element is divided by the nominal value of its wire.

    Parameters
    ----------
    participants : dict of str to Participant
        In stepping order.
    wires : sequence of Wire
    parallel : bool
        Jacobi's order: every participant reads the iterate alone, all wires are unknowns.
    discrete : sequence of HeldWire
        Wires of values that are not real numbers. Along the stepping order they carry the result
        of the evaluation, against it `late`, which changes only between solves (`unsettled`).

    Participants that wait for no other one's output of the same evaluation form a stage; those of
    them that `runs_apart`, in a process of their own, step at the same time.

    `trail` holds the measures of every wire since `begin`, a list for each evaluation that was
    measured. `spent` [s] is where the time goes: each participant's steps and derivatives under its
    name, values and states carried to and fro under "transport".
    """

    def __init__(
        self,
        participants: Mapping[str, Participant],
        wires: Sequence[Wire],
        parallel: bool = False,
        discrete: Sequence[HeldWire] = (),
    ):
        self.participants = participants
        self.wires = wires
        self.discrete = discrete
        self.discrete_inputs: dict[str, list[HeldWire]] = {}
        for one in discrete:
            self.discrete_inputs.setdefault(one.target[0], []).append(one)
        self._against = [w for w in discrete if is_unknown(w, list(participants), parallel)]
        self.late: dict[HeldWire, Any] = {}
        self._carried: dict[HeldWire, Any] = {}
        self.spent = dict.fromkeys((*participants, "transport"), 0.0)
        self.relative = any(w.relative_tolerance for w in wires)
        # an error of the noise over the difference: both parts of a derivative's error are equal
        self.difference = max((DIFFERENCE, *(w.noise**0.5 for w in wires)))
        self.begin()
        sizes = [int(np.prod(wire.shape)) for wire in wires]
        self.parts = _slices(sizes)
        self.size = sum(sizes)
        self.layout = layout_of(wires, list(participants), parallel)
        self.nominal, self.tolerance = self.layout.nominal, self.layout.tolerance
        self.unknowns = self.layout.unknowns
        self.is_limited = bool(np.isfinite(self.layout.largest_decrease).any())
        against = [is_unknown(wire, list(participants), parallel) for wire in wires]
        self.feedback = np.repeat(np.array(against, bool), np.array(sizes, int))
        self.feedback_wires = _slices([size for size, back in zip(sizes, against) if back])
        whole = list(zip(wires, self.parts))
        self.inputs = {
            name: [End(w.target[1], part, w.shape) for w, part in whole if w.target[0] == name]
            for name in participants
        }
        self.outputs = {
            name: [End(w.source[1], part, w.shape) for w, part in whole if w.source[0] == name]
            for name in participants
        }

        self.ends = {
            name: Ends(participant, self.inputs[name], self.outputs[name], self.feedback)
            for name, participant in participants.items()
        }
        self._last: tuple[Evaluation, tuple[float, float], Mapping[str, Any]] | None = None
        self.starts = [part.start for part in self.parts]
        is_small = 0 < self.size <= SMALL_VECTOR and set(sizes) == {1} and self.tolerance.all()
        scalars = is_small and not self.relative
        self._scalar_tolerances = self.tolerance.tolist() if scalars else None
        self.separate = {
            name for name, p in participants.items() if getattr(p, "runs_apart", False)
        }
        self.derived = {name for name, p in participants.items() if p.has_derivatives}
        if self.difference == DIFFERENCE:
            # those apart repeat a step by themselves, which takes fewer messages
            self.derived |= self.separate - self.discrete_inputs.keys()
        self.stages = self._stages(against) if self.separate else [[name] for name in participants]

    def _stages(self, against: Sequence[bool]) -> list[list[str]]:
        """Return the participants by the longest chain of wires that leads to them."""
        depth: dict[str, int] = {}
        for name in self.participants:
            sources = [
                wire.source[0]
                for wire, back in zip(self.wires, against)
                if wire.target[0] == name and not back
            ]
            sources += [
                wire.source[0]
                for wire in self.discrete_inputs.get(name, ())
                if wire not in self._against
            ]
            depth[name] = max((depth[source] + 1 for source in sources), default=0)
        return [
            [name for name in self.participants if depth[name] == k]
            for k in range(max(depth.values(), default=-1) + 1)
        ]

    def begin(self) -> None:
        """Begin an attempt at a macro step."""
        self.trail: list[list[float]] = []
        if self._against:
            self.hold(self._against)

    def hold(self, wires: Iterable[HeldWire]) -> None:
        """Set the `late` values of discrete wires to the present ones of their sources."""
        for wire in wires:
            self.late[wire] = self.participants[wire.source[0]].get(wire.source[1])

    def unsettled(self) -> list[HeldWire]:
        """Return the discrete wires whose source differs from their `late` value."""
        changed: list[HeldWire] = []
        for wire, value in self.late.items():
            if not np.array_equal(self.participants[wire.source[0]].get(wire.source[1]), value):
                changed.append(wire)
        return changed

    def read(self) -> np.ndarray:
        """Return the vector of the present outputs."""
        y = np.empty(self.size)
        for ends in self.ends.values():
            ends.collect(y, y)
        return y

    def evaluate(
        self,
        x: np.ndarray,
        step: tuple[float, float] | None = None,
        saved: Mapping[str, Any] | None = None,
    ) -> Evaluation:
        """Step every participant once from its saved state.

        Later participants read the results of earlier ones.

        Parameters
        ----------
        x : ndarray, shape (size,)
            Iterate; the inputs are set to its feedback elements.
        step : (float, float), optional
            Start and length of the macro step [s]. Default: no step, outputs follow the inputs.
        saved : dict of str to saved state, optional
            Default: the participants are in the right state.
        """
        used, y = x.copy(), np.empty(self.size)
        spent, transport = self.spent, 0.0
        now = perf_counter()
        for stage in self.stages:
            for name in stage:
                ends = self.ends[name]
                if saved is not None:
                    ends.participant.restore(saved[name])
                if ends.inputs:
                    ends.feed(used[ends.into])
                if name in self.discrete_inputs:
                    self._carry(name)
            fed = perf_counter()
            transport += fed - now
            if step and self.separate:
                self._step(stage, *step)
            elif step:  # a stage of one
                self.participants[stage[0]].step(*step)
            now = perf_counter()
            if not self.separate:
                spent[stage[0]] += now - fed
            for name in stage:
                self.ends[name].collect(used, y)
        spent["transport"] += transport + perf_counter() - now
        # an element that is fed back was used as in x, another one as in y
        at = Evaluation(used, y, y - x)
        self._last = (at, step, saved) if step and saved is not None else None
        return at

    def _carry(self, name: str) -> None:
        """Set the inputs of a participant that are not real numbers."""
        for wire in self.discrete_inputs[name]:
            owner, variable = wire.source
            late = wire in self.late
            value = self.late[wire] if late else self.participants[owner].get(variable)
            self.participants[name].set(wire.target[1], value)
            self._carried[wire] = value

    def _step(self, stage: Sequence[str], time: float, step: float) -> None:
        """Step the participants of a stage, the isolated ones in parallel.

        A discarded step or a fault is raised after all of them have answered.
        """
        participants: Mapping[str, Any] = self.participants  # begin_step: only where apart
        separate = [name for name in stage if name in self.separate]
        here = [name for name in stage if name not in self.separate]
        calls = [
            *((name, partial(participants[name].begin_step, time, step)) for name in separate),
            *((name, partial(participants[name].step, time, step)) for name in here),
            *((name, participants[name].end_step) for name in separate),
        ]
        failures: dict[str, Discard | ParticipantFault] = {}
        for name, call in calls:
            if name in failures:
                continue  # it could not begin
            begun = perf_counter()
            try:
                call()
            except (Discard, ParticipantFault) as failure:
                failures[name] = failure
            self.spent[name] += perf_counter() - begun
        for name in stage:
            if name in failures:
                raise failures[name]

    def derivative(self, change: np.ndarray) -> np.ndarray:
        """Return the derivative of the evaluation at the last step of every participant.

        A participant without derivatives repeats its step with changed inputs and stays there, so
        evaluate again before its state is used.

        Parameters
        ----------
        change : ndarray, shape (size,)
            Change of the iterate; only its feedback elements are read.

        Returns
        -------
        ndarray, shape (size,)
            Change of all outputs.
        """
        input_change = np.zeros(self.size)
        input_change[self.unknowns] = change[self.unknowns]
        result = np.zeros(self.size)
        for name, ends in self.ends.items():
            if not (ends.inputs and ends.outputs):
                continue  # nothing depends on it, or it depends on nothing
            begun = perf_counter()
            if name in self.derived or self._last is None:
                ends.differentiate(input_change, result)
            else:
                result[ends.out] = self._difference(name, *self._last, input_change[ends.into])
            self.spent[name] += perf_counter() - begun
            if ends.forward is not None:
                input_change[ends.forward] = result[ends.forward]
        return result

    def _difference(
        self,
        name: str,
        at: Evaluation,
        step: tuple[float, float],
        saved: Mapping[str, Any],
        change: Any,
    ) -> Any:
        """Return the change of a participant's outputs for a change of its inputs, Eq. (P1).

        at, step, saved : the last evaluation, and what it was computed from.
        """
        ends = self.ends[name]
        inputs = at.used[ends.into]
        largest_change = ends.largest_change(change, inputs)
        if largest_change <= NEGLIGIBLE:
            return 0.0
        share = self.difference / largest_change
        ends.participant.restore(saved[name])
        ends.feed(inputs + share * change)
        for wire in self.discrete_inputs.get(name, ()):
            ends.participant.set(wire.target[1], self._carried[wire])
        ends.participant.step(*step)
        return (ends.values() - at.outputs[ends.out]) / share  # Eq. (P1)

    def allowed(self, values: np.ndarray) -> np.ndarray:
        """Return the residual that counts as converged, by element, for given values."""
        if not self.relative:
            return self.tolerance
        allowed = [wire.allowed(values[part]) for wire, part in zip(self.wires, self.parts)]
        return np.repeat(allowed, [part.stop - part.start for part in self.parts])

    def measure(self, residual: np.ndarray, values: np.ndarray) -> float:
        """Return the largest `Wire.measure`: converged if at most 1, NaN if not finite."""
        self.trail.append(self._measures(residual, values))
        return largest(self.trail[-1])

    def _measures(self, residual: np.ndarray, values: np.ndarray) -> list[float]:
        if not self.size:
            return []
        if self._scalar_tolerances:
            return [abs(r) / t for r, t in zip(residual.tolist(), self._scalar_tolerances)]
        if not self.relative:
            shares = np.abs(residual) / self.tolerance
            return np.maximum.reduceat(shares, self.starts).tolist()
        return [w.measure(residual[part], values[part]) for w, part in zip(self.wires, self.parts)]

    def worst(self, residual: np.ndarray, values: np.ndarray) -> str:
        """Return a sentence with the worst wire and its largest residual."""
        measures = self._measures(residual, values)
        k = int(np.argmax(np.where(np.isnan(measures), np.inf, measures)))
        wire = self.wires[k]
        r = residual[self.parts[k]]
        element = int(np.argmax(np.where(np.isnan(r), np.inf, np.abs(r))))
        allowed = wire.allowed(values[self.parts[k]])
        unit = "" if wire.unit == "1" else f" {wire.unit}"
        return (
            f"{_element(wire.target, element, wire.shape)}: expected a residual of at most "
            f"{allowed:.3g}{unit}, got {r[element]:.3g}{unit}"
        )

    def not_finite(self, evaluation: Evaluation) -> str:
        """Return a sentence with the first output that is not finite in the order of stepping.

        A participant whose inputs are finite is the origin; the others pass on what they received.
        """
        origins: list[str] = []
        for name in self.participants:
            finite = all(np.isfinite(evaluation.used[end.part]).all() for end in self.inputs[name])
            for variable, part, shape in self.outputs[name]:
                bad = np.flatnonzero(~np.isfinite(evaluation.outputs[part]))
                if len(bad):
                    port = _element((name, variable), int(bad[0]), shape)
                    value = evaluation.outputs[part][bad[0]]
                    sentence = f"{port}: expected a finite output, got {value}"
                    if finite:
                        return f"{sentence}; its inputs are finite, the cause is in {name}"
                    origins.append(sentence)
        return origins[0] if origins else "expected finite outputs"


def _element(port: tuple[str, str], element: int, shape: tuple[int, ...]) -> str:
    """Return the name of an element of a port, "body.force[3]"; indices count from 1."""
    if not shape:
        return ".".join(port)
    index = ",".join(str(i + 1) for i in np.unravel_index(element, shape))
    return f"{'.'.join(port)}[{index}]"


def _slices(sizes: Sequence[int]) -> list[slice]:
    """Return the slices of contiguous parts."""
    ends = np.cumsum(sizes, dtype=int).tolist()
    return [slice(end - size, end) for end, size in zip(ends, sizes)]
