"""Loops among the wires: each is brought to its fixed point alone, everything else steps once.

Participants that depend on one another form a strongly connected component of the wires' graph.
Components step one after the other, each with what those before it say at the end of the step.
"""

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..fmi.errors import Discard, Ticked
from .interface import Interface
from .methods import Explicit, MacroStep, Method, NotConverged, Solution
from .settling import solve_settled
from .vector import largest
from .wiring import HeldWire, Port, System, Wire, port_of

AnyWire = TypeVar("AnyWire", Wire, HeldWire)

UPSTREAM = ""
"""Name of the participant that stands for all components before; no participant has this name."""


@dataclass(frozen=True)
class Component:
    """Participants that step together: those of a loop, or several that form none.

    names : in stepping order; is_loop : whether they have to agree; fixed : those of a loop that
    cannot go back, so that the loop steps once and its wires agree a step late.
    """

    names: tuple[str, ...]
    is_loop: bool = False
    fixed: tuple[str, ...] = ()

    @property
    def is_iterated(self) -> bool:
        """Return whether steps are repeated until the wires agree."""
        return self.is_loop and not self.fixed


def components(system: System) -> list[Component]:
    """Return the strongly connected components of the wires.

    No component depends on a later one. Components that do not depend on each other keep the order
    of the system. Neighbours without a loop are one component if all or none of them can restore a
    saved state: then isolated participants step at the same time. Wires to clocked inputs join
    nothing, because they are carried at the beginning of a step.
    """
    index = {name: k for k, name in enumerate(system.order)}
    able = {name: getattr(system.participants[name], "can_redo", True) for name in index}
    reaches = np.eye(len(index), dtype=bool)
    wires = (*system.wires, *system.discrete)
    looped = {wire.source[0] for wire in wires if wire.source[0] == wire.target[0]}
    for wire in wires:
        reaches[index[wire.source[0]], index[wire.target[0]]] = True
    for k in range(len(index)):
        reaches |= np.outer(reaches[:, k], reaches[k])
    joined = reaches & reaches.T
    before = reaches.sum(axis=0)
    groups: list[Component] = []
    for name in sorted(index, key=lambda name: (before[index[name]], index[name])):
        names = [other for other in index if joined[index[name], index[other]]]
        if len(names) > 1 or name in looped:
            if name == names[0]:
                groups.append(Component(tuple(names), True, tuple(n for n in names if not able[n])))
        elif groups and not groups[-1].is_loop and able[groups[-1].names[0]] == able[name]:
            groups[-1] = Component((*groups[-1].names, name))
        else:
            groups.append(Component((name,)))
    return groups


def rolled_back(system: System, iterates: bool = True) -> list[str]:
    """Return the names of the participants whose steps are repeated as a matter of course.

    iterates : whether the method iterates loops.
    """
    if any(wire.local_error is not None for wire in system.wires):
        return list(system.order)
    groups = components(system) if iterates else []
    return [name for one in groups if one.is_iterated for name in one.names]


def by_components(method: Method, system: System, halvings: int) -> Method:
    """Return a method that solves one component after the other, or the method itself.

    The method itself solves a system of one loop that can be iterated. `Explicit` never changes.
    """
    groups = components(system)
    if isinstance(method, Explicit) or (len(groups) == 1 and groups[0].is_iterated):
        return method
    return Componentwise(method, groups, system.parallel, halvings)


def table(system: System, method: str) -> list[str]:
    """Return lines that list the components.

    There are none for a single iterated loop, for a method that iterates nothing, and without
    wires.

    method : name of the method, as in the case.
    """
    groups = components(system)
    if method == "explicit" or not system.wires or (len(groups) == 1 and groups[0].is_iterated):
        return []
    if not any(one.is_loop for one in groups):
        return ["the wires form no loop: every participant steps once"]
    lines = ["components of the wires, in stepping order:"]
    for one in groups:
        how = method if one.is_iterated else "explicit" if one.is_loop else "once"
        why = f"  ({', '.join(one.fixed)} cannot restore a saved state)" if one.fixed else ""
        lines.append(f"  {how:10s} {', '.join(one.names)}{why}")
    return lines


class Upstream:
    """All components before, as a participant that has stepped already."""

    name, has_derivatives = UPSTREAM, False

    def __init__(self, participants: Mapping[str, Any]):
        self.participants = participants

    def get(self, name: str) -> Any:
        """Return the value of "participant.variable"."""
        owner, variable = port_of(name)
        return self.participants[owner].get(variable)

    def restore(self, saved: Any) -> None:
        """Do nothing: what is before does not change."""

    def step(self, time: float, step: float) -> None:
        """Do nothing."""


class Part(NamedTuple):
    """A component ready to step.

    interface : its participants, `Upstream` the first of them if wires come from there, and the
    wires that end in it; wires, elements : which of the system's these are; from_upstream : for
    each element; method : how it is solved.
    """

    component: Component
    interface: Interface
    wires: np.ndarray
    elements: np.ndarray
    from_upstream: np.ndarray
    method: Method

    def of(self, macro_step: MacroStep) -> MacroStep:
        """Return a macro step of the whole as one of the component."""
        saved = {UPSTREAM: None} | macro_step.saved
        return macro_step._replace(interface=self.interface, saved=saved)


def part(whole: Interface, one: Component, method: Method, parallel: bool) -> Part:
    """Return a component as a system of its own.

    whole : all participants and wires; method : solves the component if it is iterated; parallel :
    see `Interface`.
    """
    chosen = [k for k, wire in enumerate(whole.wires) if wire.target[0] in one.names]
    wires = [_from_upstream(whole.wires[k], one.names) for k in chosen]
    discrete = [_from_upstream(w, one.names) for w in whole.discrete if w.target[0] in one.names]
    participants: dict[str, Any] = {name: whole.participants[name] for name in one.names}
    if any(wire.source[0] == UPSTREAM for wire in (*wires, *discrete)):
        participants = {UPSTREAM: Upstream(whole.participants)} | participants
    indices = np.arange(whole.size)
    elements = [indices[whole.parts[k]] for k in chosen]
    from_upstream = [np.full(len(e), w.source[0] == UPSTREAM) for w, e in zip(wires, elements)]
    return Part(
        component=one,
        interface=Interface(participants, wires, parallel and one.is_loop, discrete),
        wires=np.array(chosen, int),
        elements=np.concatenate([*elements, np.zeros(0, int)]),
        from_upstream=np.concatenate([*from_upstream, np.zeros(0, bool)]),
        method=copy(method) if one.is_iterated else Explicit(),
    )


class Componentwise:
    """A method that solves one component of a system after the other.

    A component that fails is halved by itself where an earlier one cannot go back; else the whole
    macro step is.

    Parameters
    ----------
    method : Method
        For the loops that are iterated.
    found : sequence of Component
    parallel : bool
        See `Interface`.
    halvings : int
        Maximum number of successive halvings of the step of a component.
    """

    def __init__(
        self, method: Method, components: Sequence[Component], parallel: bool, halvings: int
    ):
        self.method, self.components, self.halvings = method, components, halvings
        self.parallel = parallel
        self.remembered = getattr(method, "remembered", ())
        self._whole: Interface | None = None
        self._parts: list[Part] = []

    def memory(self) -> list[Any]:
        """Return the memory of the method for each component."""
        once = Explicit()
        return [(self.method if one.is_iterated else once).memory() for one in self.components]

    def solve(self, macro_step: Any, guess: np.ndarray, memory: list[Any]) -> Solution:
        """Solve the macro step, one component after the other; raise what the method raises."""
        whole = macro_step.interface
        if self._whole is not whole:
            self._whole = whole
            self._parts = [part(whole, one, self.method, self.parallel) for one in self.components]
        whole.late.clear()  # that of the parts counts
        x, inputs = guess.copy(), guess.copy()
        solutions: list[Solution] = []
        trails: list[tuple[np.ndarray, list[list[float]]]] = []
        try:
            for k, own in enumerate(self._parts):
                own.interface.begin()
                trails.append((own.wires, own.interface.trail))
                halvings = self.halvings if self._is_past(macro_step, k) else 0
                solution = self._solved(own, macro_step, guess, memory[k], halvings)
                x[own.elements], inputs[own.elements] = solution.x, solution.inputs
                solutions.append(solution)
        finally:
            whole.trail += _merged(trails, len(whole.wires))
            self._account(whole)
        return Solution(
            x=x,
            history=tuple(map(largest, whole.trail)),
            jacobians=sum(one.jacobians for one in solutions),
            products=sum(one.products for one in solutions),
            probes=sum(one.probes for one in solutions),
            held=inputs,
            messages=tuple(message for one in solutions for message in one.messages),
            unsettled=sum(one.unsettled for one in solutions),
        )

    def _is_past(self, macro_step: MacroStep, k: int) -> bool:
        """Return whether a participant without rollback has stepped before component k does."""
        before = (name for one in self.components[:k] for name in one.names)
        known = macro_step.interface.participants
        return not all(getattr(known[name], "can_redo", True) for name in before)

    def _solved(
        self, part: Part, macro_step: MacroStep, guess: np.ndarray, memory: Any, halvings: int
    ) -> Solution:
        """Solve the step of a component, or its halves."""
        component, interface = part.component, part.interface
        own = part.of(macro_step)
        first = guess[part.elements]
        if part.from_upstream.any() or not component.is_iterated:
            elements = part.from_upstream if component.is_iterated else slice(None)
            first[elements] = interface.read()[elements]
        try:
            return solve_settled(part.method, own, first, memory)
        except Ticked:
            raise
        except (NotConverged, Discard):
            if component.fixed or not halvings:
                raise
        return self._halves(part, own, guess, halvings - 1)

    def _halves(self, part: Part, own: MacroStep, guess: np.ndarray, halvings: int) -> Solution:
        """Solve the step of a component in two halves, over which upstream values are held."""
        members = {name: own.interface.participants[name] for name in part.component.names}
        half = own.step / 2
        for name, one in members.items():
            one.restore(own.saved[name])
        own.interface.hold(own.interface.late)
        memory = part.method.memory()
        begun = self._solved(part, own._replace(step=half), guess, memory, halvings)
        middle = {name: one.save() for name, one in members.items()}
        try:
            second = own._replace(time=own.time + half, step=half, saved=own.saved | middle)
            moved = guess.copy()
            moved[part.elements] = begun.x
            solution = self._solved(part, second, moved, memory, halvings)
            return solution._replace(
                messages=begun.messages + solution.messages,
                unsettled=begun.unsettled + solution.unsettled,
            )
        finally:
            for name, one in members.items():
                one.free(middle[name])

    def _account(self, whole: Interface) -> None:
        """Add the times that the components took to those of the whole."""
        for own in self._parts:
            for name, seconds in own.interface.spent.items():
                if name in whole.spent:
                    whole.spent[name] += seconds
            own.interface.spent = dict.fromkeys(own.interface.spent, 0.0)


def _from_upstream(wire: AnyWire, names: Iterable[str]) -> AnyWire:
    """Return the wire, which begins at `Upstream` if it comes from another component."""
    if wire.source[0] in names:
        return wire
    source: Port = (UPSTREAM, ".".join(wire.source))
    return replace(wire, source=source)


def _merged(
    trails: Iterable[tuple[np.ndarray, list[list[float]]]], wires: int
) -> list[list[float]]:
    """Return the measures of all wires by evaluation; a shorter trail repeats its last ones."""
    nonempty = [(which.tolist(), trail) for which, trail in trails if trail]
    merged = [[0.0] * wires for _ in range(max((len(trail) for _, trail in nonempty), default=0))]
    for k, row in enumerate(merged):
        for which, trail in nonempty:
            for wire, measure in zip(which, trail[min(k, len(trail) - 1)]):
                row[wire] = measure
    return merged
