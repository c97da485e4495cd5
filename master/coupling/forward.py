"""Forward sensitivities: the derivative of a run by variables, in each step that it takes.

For each variable there are two further systems, whose participants have a slightly higher and a
slightly lower value of it. In an accepted step, these participants start from the state of the run
plus and minus a share of the derivative of the state. The derivative of a participant's step is

Eq. (Q14):  z' = (z(s + e s', x + e x', p + e) - z(s - e s', x - e x', p - e)) / (2 e)

with the state s and the inputs x of the run, p the variable and z the state and the outputs at the
end. A participant with `advance_nearby` evaluates z with the factorisation of the run's step. The
derivative x' on the wires fulfils

Eq. (Q15):  x' - A x' = y

with the derivative A of all participants one after another, and y the result of Eq. (Q14) with
x' = 0 on the unknown wires. Eq. (Q14) with this x' then gives the derivative of state and outputs.
Here x' is the correction of an extrapolation, and y the error of that.

A rule that switches within the small change would give a derivative of any size. If the second
difference of a vector of the state is as large as the first one, the side with the smaller change
is used alone. `switches` counts these steps.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..fmi.errors import Discard, ParticipantFault
from ..fmi.state_members import difference, layout_of, members_of, moved
from .interface import Interface
from .methods import Solution
from .starting import start
from .stepping import Observer
from .vector import extrapolate
from .wiring import Port, System

INTERFACE_TOLERANCE = 1e-11
"""Residual of Eq. (Q15) relative to the largest residual."""
PREDICTED = 3
"""Number of steps whose derivatives on the wires predict those of the next one."""
MOST_SWEEPS = 4
"""Maximum number of evaluations of Eq. (Q14) in a step. Two are usual."""
SOLVED = 1e-5
"""Error of Eq. (Q15) over the derivatives on the wires, up to which it is solved."""
MOST_VECTORS = 500
"""Maximum number of products with A in a step, in addition to one for each variable."""
SWITCHED = 0.5
"""Second over first difference of a vector above which a rule has switched."""
ROUND_OFF = 1e-9
"""Difference of a vector relative to its size that may be round-off."""


class NotCovered(Exception):
    """A case without forward sensitivities. The message is the reason."""


class Pair(NamedTuple):
    """Systems with the variable at plus and minus `share` of its step."""

    plus: System
    minus: System
    share: float


class Twin(NamedTuple):
    """Slaves of a system by name, their inputs and parameters, and its step over that of the run.

    A slave with another rotation speed takes another step for the same angle.
    """

    slaves: Mapping[str, Any]
    values: Mapping[str, dict[str, Any]]
    pace: float


class Direction(NamedTuple):
    """Slaves on both sides of the run, and the share e of Eq. (Q14)."""

    plus: Twin
    minus: Twin
    share: float


class Step(NamedTuple):
    """Step of the run: begin and length [s], states at its begin, wires that it used."""

    begin: float
    length: float
    states: Mapping[str, Any]
    used: np.ndarray


class Change(NamedTuple):
    """Derivative of a participant's state by member, and of its real outputs by name."""

    state: list[Any]
    outputs: Mapping[str, Any]


Changes = dict[str, Change]


class ForwardSensitivities(Observer):
    """Derivatives of all scalar outputs of a run; observes its accepted steps.

    All systems are started here, and have participants in this process alone.

    Parameters
    ----------
    base : System
        System of the run, with participants of its own.
    pairs : sequence of Pair

    Attributes
    ----------
    ports : list of (participant, variable)
        The scalar outputs.
    times : list of float
        The start and the end of each accepted step [s].
    rows : list of ndarray, shape (variables, ports)
        Derivatives at `times`, by the step of each variable, in SI.
    sizes : list of ndarray, shape (variables,)
        Rms of the derivatives on all wires, over their nominal values.
    switches : dict of str to int
        Number of differences by participant in which a rule switched.
    mismatch : float
        Largest error of Eq. (Q15), relative to the largest derivative on the wires.
    """

    def __init__(self, base: System, pairs: Sequence[Pair]):
        for system in (base, *(one for pair in pairs for one in pair[:2])):
            start(system)
        ordered = {name: base.participants[name] for name in base.order}
        self.interface = Interface(ordered, base.wires, base.parallel)
        self.slaves = {name: _slave(one) for name, one in ordered.items()}
        self.directions = [
            Direction(_twin(one.plus, base), _twin(one.minus, base), one.share) for one in pairs
        ]
        self._check()
        self.real = {
            name: [v for v in one.table if v.causality == "output" and v.type == "Real"]
            for name, one in self.slaves.items()
        }
        self.ports: list[Port] = [
            (name, v.name) for name, real in self.real.items() for v in real if v.size == 1
        ]
        self.times = [base.begin]
        self.sizes: list[Any] = []
        self.switches = dict.fromkeys(ordered, 0)
        self.mismatch = 0.0
        begun = [self._begin(one) for one in self.directions]
        self.changes = [{name: one.state for name, one in change.items()} for change in begun]
        self.rows = [np.array([self._scalars(change) for change in begun])]
        self.past = [(base.begin, np.array([self._on_wires(change) for change in begun]))]

    def _check(self) -> None:
        """Raise `NotCovered` for systems whose derivative is unknown."""
        for name, slave in self.slaves.items():
            if why := slave.no_nearby_step:
                raise NotCovered(f"{name}: {why}")
            layout = layout_of(slave.state)
            twins = [twin for one in self.directions for twin in one[:2]]
            if any(layout_of(twin.slaves[name].state) != layout for twin in twins):
                raise NotCovered(f"{name}: a variable changes the size of the state")

    def _begin(self, direction: Direction) -> Changes:
        """Return the derivative at the start, from the starts of both systems."""
        out: Changes = {}
        by = 0.5 / direction.share
        for name in self.slaves:
            plus, minus = (twin.slaves[name] for twin in direction[:2])
            state = difference(plus.state, minus.state, by)
            real = (v.name for v in self.real[name])
            outputs = {one: by * (plus.views[one] - minus.views[one]) for one in real}
            out[name] = Change(state, outputs)
        return out

    def _scalars(self, change: Changes) -> list[float]:
        return [float(change[name].outputs[variable]) for name, variable in self.ports]

    def _on_wires(self, change: Changes) -> np.ndarray:
        """Return the derivatives of outputs as the vector of all wires."""
        wires = np.zeros(self.interface.size)
        for name, ends in self.interface.outputs.items():
            for end in ends if name in change else ():
                wires[end.part] = np.ravel(change[name].outputs[end.variable])
        return wires

    def close(self) -> None:
        """Do nothing at the end of the run."""

    def accepted(self, time: float, solution: Solution) -> None:
        """Take the step that ends at `time` [s] again, and move all derivatives on.

        Raises
        ------
        NotCovered
            If a step next to that of the run has no solution.
        """
        try:
            self._advance(time, solution)
        except (Discard, ParticipantFault) as failure:
            raise NotCovered(f"t = {time:.6g} s: {failure}") from failure

    def _advance(self, time: float, solution: Solution) -> None:
        begin = self.times[-1]
        states = {name: slave.state for name, slave in self.slaves.items()}
        used = self.interface.evaluate(solution.inputs, (begin, time - begin)).used
        step = Step(begin, time - begin, states, used)
        pick, scale = self.interface.unknowns, self.interface.nominal
        wires = self._extrapolated(time)
        changes, ends = self._all_moved(wires, step)
        left = ((ends - wires) / scale)[:, pick]
        sweeps = 1
        while (error := _relative(left, (ends / scale)[:, pick])) > SOLVED and sweeps < MOST_SWEEPS:
            wires[:, pick] += solutions(self._product, left.T).T * scale[pick]  # Eq. (Q15)
            changes, ends = self._all_moved(wires, step)
            left = ((ends - wires) / scale)[:, pick]
            sweeps += 1
        self.mismatch = max(self.mismatch, error)
        self.past = [*self.past, (time, ends)][-PREDICTED:]
        self.times.append(time)
        self.changes = [{name: one.state for name, one in change.items()} for change in changes]
        self.rows.append(np.array([self._scalars(change) for change in changes]))
        self.sizes.append(np.sqrt(np.mean((ends / scale) ** 2, axis=1)))

    def growth(self, period: float) -> float:
        """Return the largest ratio of derivatives on the wires at the end to a period before."""
        ends = np.array(self.times[1:])
        before = np.flatnonzero(ends <= ends[-1] - period + 1e-9 * period)
        if not len(before):
            return np.nan
        first, last = self.sizes[before[-1]], self.sizes[-1]
        return float(np.max(last[first > 0.0] / first[first > 0.0], initial=0.0))

    def _extrapolated(self, time: float) -> np.ndarray:
        """Return the derivatives on all wires at a time [s], from those of the last steps."""
        times, vectors = zip(*self.past)
        flat = [one.ravel() for one in vectors]
        guess: np.ndarray = extrapolate(times, flat, time)
        return guess.reshape(vectors[-1].shape)

    def _product(self, x: np.ndarray) -> np.ndarray:
        """Return A x of Eq. (Q15) on the unknown wires, over nominal values."""
        pick = self.interface.unknowns
        scale = self.interface.nominal[pick]
        change = np.zeros(self.interface.size)
        change[pick] = x * scale
        return self.interface.derivative(change)[pick] / scale

    def _all_moved(self, wires: np.ndarray, step: Step) -> tuple[list[Changes], np.ndarray]:
        """Return the derivatives at the end of a step, and those on all wires, by variable."""
        pairs = zip(self.directions, self.changes, wires)
        changes = [self._moved(*one, step) for one in pairs]
        return changes, np.array([self._on_wires(one) for one in changes])

    def _moved(
        self, direction: Direction, change: Mapping[str, list[Any]], wires: np.ndarray, step: Step
    ) -> Changes:
        """Return the derivatives at the end of a step, all participants one after another.

        Of the derivatives on the wires only the unknown ones are read.
        """
        inputs = wires.copy()
        out: Changes = {}
        for name, ends in self.interface.ends.items():
            out[name] = self._difference(direction, name, change[name], inputs, step)
            if ends.forward is not None:
                inputs[ends.forward] = self._on_wires({name: out[name]})[ends.forward]
        return out

    def _difference(
        self, direction: Direction, name: str, change: list[Any], wires: np.ndarray, step: Step
    ) -> Change:
        """Return the derivative of a participant's step, Eq. (Q14)."""
        base, share, state = self.slaves[name], direction.share, step.states[name]
        ends: list[Any] = []
        for twin, e in ((direction.plus, share), (direction.minus, -share)):
            inputs = dict(twin.values[name])
            for end in self.interface.inputs[name]:
                part = step.used[end.part] + e * wires[end.part]
                inputs[end.variable] = part.reshape(end.shape) if end.shape else part.item()
            times = twin.pace * step.begin, twin.pace * step.length
            begin = moved(state, change, e)
            ends.append(twin.slaves[name].advance_nearby(base, begin, inputs, *times))
        (plus, above), (minus, below) = ends
        if sizes := _switched(plus, base.state, minus):
            self.switches[name] += 1
            share = 0.5 * share
            if sizes[0] < sizes[1]:
                minus, below = base.state, base.views
            else:
                plus, above = base.state, base.views
        by = 0.5 / share  # Eq. (Q14)
        real = {v.name: by * (above[v.name] - below[v.name]) for v in self.real[name]}
        return Change(difference(plus, minus, by), real)


def _slave(participant: Any) -> Any:
    return participant.slave


def _twin(system: System, base: System) -> Twin:
    slaves = {name: _slave(system.participants[name]) for name in base.order}
    values = {name: slave._values() for name, slave in slaves.items()}
    return Twin(slaves, values, system.step / base.step)


def _relative(errors: np.ndarray, values: np.ndarray) -> float:
    """Return the largest error of a row over its largest value."""
    if not errors.size:
        return 0.0
    highest, sizes = (np.abs(one).max(axis=1) for one in (errors, values))
    return float(np.max(highest[sizes > 0.0] / sizes[sizes > 0.0], initial=0.0))


def _switched(plus: Any, here: Any, minus: Any) -> tuple[float, float] | None:
    """Return the changes of a vector of the state to both sides if a rule has switched there."""
    for a, b, c in zip(members_of(plus), members_of(here), members_of(minus)):
        if np.ndim(b) == 1 and len(b):
            first, second = np.abs(a - c).max(), np.abs(a - 2.0 * b + c).max()
            if second > SWITCHED * first + ROUND_OFF * np.abs(b).max():
                return float(np.abs(a - b).max()), float(np.abs(c - b).max())
    return None


def solutions(product: Callable[[np.ndarray], np.ndarray], right: np.ndarray) -> np.ndarray:
    """Return x of Eq. (Q15) for several right-hand sides, by products that all of them share.

    With x = y + z, z - A z = A y. Each further direction is the residual of the worst right-hand
    side. It reduces all residuals (GCR). As many products are needed as A has rank.

    Parameters
    ----------
    product : callable
        Returns A x.
    right : ndarray, shape (n, m)
        Over nominal values.

    Returns
    -------
    ndarray, shape (n, m)
    """
    inner = right
    residual = np.array([product(y) for y in right.T]).reshape(right.T.shape).T
    tolerance = np.maximum(INTERFACE_TOLERANCE * np.linalg.norm(residual, axis=0), 1e-300)
    basis = images = np.zeros((0, len(right)))
    for _ in range(MOST_VECTORS):
        norms = np.linalg.norm(residual, axis=0)
        if not (norms > tolerance).any():
            break
        vector = residual[:, np.argmax(norms / tolerance)]
        vector = vector / np.linalg.norm(vector)
        image = vector - product(vector)
        for _ in range(2):  # twice, so that they are orthogonal to round-off
            shares = images @ image
            image, vector = image - shares @ images, vector - shares @ basis
        size = np.linalg.norm(image)
        basis = np.vstack([basis, vector / size])
        images = np.vstack([images, image / size])
        shares = images[-1] @ residual
        inner = inner + np.outer(basis[-1], shares)
        residual = residual - np.outer(images[-1], shares)
    return inner
