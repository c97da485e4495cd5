"""Interface Newton-Krylov as machine code: one call for each macro step.

The code is `iteration.converge` as in native coupled FMUs. If all participants are FMI 2.0
instances of this process, it calls them by pointers (front/fmi_parts.c). Otherwise it has one
participant, which calls `Interface.evaluate` and `Interface.derivative`. Both give the same bits.
"""

import ctypes
import os
import warnings
import weakref
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...fmi.block import row_of
from ..interface import Interface
from ..native_block import (
    ParticipantRow,
    Rules,
    WireRow,
    given_from,
    lay_out,
    nothing_yet,
    parts_of,
    state_from,
    trail_from,
)
from ..wiring import System
from .krylov import RecycledGmres
from .newton import Newton
from .solution import MacroStep, Method, Solution, Tried


def compiled_where_it_can(method: Method, system: System) -> Method:
    """Return the method, for `Newton` as machine code if possible.

    That needs the library and supports no relative tolerances and no differences. It is not used if
    NUMBA_DISABLE_JIT is set.
    """
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0":
        return method
    relative = any(w.relative_tolerance or w.residual_relative_tolerance for w in system.wires)
    if type(method) is not Newton or method.differences or relative or not system.wires:
        return method
    from ...fmi.builder_native import iteration_library  # slow to import

    try:
        library = iteration_library()
        return CompiledNewton(method, library) if library else method
    except (OSError, RuntimeError) as error:
        warnings.warn(f"the iteration runs in Python: {error}", stacklevel=2)
        return method


class CompiledNewton:
    """`Newton` as machine code.

    Both have the same memory, so that either can continue a run of the other. A macro step that
    fails is solved again by Newton in Python, which writes the messages. An error of an FMU is
    raised at once, because an FMU need not answer after one.

    Parameters
    ----------
    newton : Newton
    library : Path
        `builder_native.iteration_library`.
    """

    def __init__(self, newton: Newton, library: Path):
        self.newton = newton
        self.library = Library(library)
        self._iteration: Iteration | None = None

    def memory(self) -> RecycledGmres:
        return self.newton.memory()

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: RecycledGmres) -> Solution:
        if not isinstance(macro_step, MacroStep):
            return self.newton.solve(macro_step, guess, memory)
        if self._iteration is None or self._iteration.interface is not macro_step.interface:
            interface = macro_step.interface
            kind = ByPointers if are_callable(interface) else ByPython
            self._iteration = kind(self.newton, interface, self.library)
        solution = self._iteration.solve(macro_step, guess, memory)
        return solution or self.newton.solve(macro_step, guess, memory)


def are_callable(interface: Interface) -> bool:
    """Return whether machine code can call all participants by pointers."""
    from ...participants.fmi2 import FmuParticipant

    return all(
        type(one) is FmuParticipant
        and one.can_redo
        and (
            one.has_standard_derivative or not (interface.inputs[name] and interface.outputs[name])
        )
        for name, one in interface.participants.items()
    )


class Library:
    """Library with the machine code, and memory for its calls."""

    def __init__(self, path: Path):
        whole = ctypes.CDLL(str(path))
        pointer = ctypes.c_void_p
        whole.iteration_make.restype = pointer
        whole.iteration_free.argtypes = [pointer]
        whole.iteration_free.restype = None
        whole.iteration_run.argtypes = [pointer] * 5
        self._run = whole.iteration_run
        self._pool = whole.iteration_make()
        weakref.finalize(self, whole.iteration_free, self._pool)

    def call(self, real: np.ndarray, memory: np.ndarray, numbers: np.ndarray) -> Callable[[], None]:
        """Return a call of the entry `iterate` on these arrays."""
        arrays = real, memory, numbers, np.array([real.size, 0, memory.size, numbers.size])
        addresses = [array.ctypes.data for array in arrays]

        def run(kept: tuple[np.ndarray, ...] = arrays) -> None:
            if self._run(self._pool, *addresses):
                raise MemoryError("not enough memory for the iteration of a macro step")

        return run


Sizes = Mapping[Any, int]
"""Number of elements by name of variable, in order."""


class CalledParticipant(NamedTuple):
    """Participant of the machine code: address of its `Instance`, inputs and outputs.

    Its real variables are inputs, outputs, seeds and products.
    """

    address: int
    inputs: Sizes
    outputs: Sizes

    @property
    def variables(self) -> int:
        """Number of elements of inputs and outputs."""
        return sum(self.inputs.values()) + sum(self.outputs.values())

    @property
    def row(self) -> ParticipantRow:
        """Row of the participant.

        Its memory is an empty list of faults. Its state is not here, because the FMU restores it.
        """
        return ParticipantRow(
            self.address, reals=2 * self.variables, memories=2, variables=self.variables
        )


class Ends(NamedTuple):
    """Number of the participant and name of the variable at both ends of a wire."""

    source: int
    output: Any
    target: int
    input: Any


class Iteration:
    """Participants and wires of an interface in the memory of the machine code.

    Parameters
    ----------
    newton : Newton
    interface : Interface
    library : Library
    called : sequence of CalledParticipant
        In stepping order.
    ends : sequence of Ends
        By wire.
    """

    def __init__(
        self,
        newton: Newton,
        interface: Interface,
        library: Library,
        called: Sequence[CalledParticipant],
        ends: Sequence[Ends],
    ):
        self.interface = interface
        rules = Rules(
            *(0.0, 0.0, 0.0, 0, 0),  # Python steps
            newton.max_iterations,
            newton.largest_krylov_space,
            newton.accuracy,
            newton.forcing,
            newton.max_iterations,
        )
        wires = [
            self._wire(k, called[one.source], called[one.target], one) for k, one in enumerate(ends)
        ]
        head = lay_out(
            rules, interface.layout, [one.row for one in called], wires, range(len(called))
        )
        self.block = np.zeros(int(head[0]))
        self.block[: len(head)] = head
        self.parts = parts_of(self.block)
        state, trail = nothing_yet(given_from.py_func(self.parts.given))
        self.parts.state[:] = self.parts.before[:] = row_of(state)
        self.parts.trail[:] = row_of(trail)
        self.pairs = state_from.py_func(self.parts.state).pairs
        self.trail = trail_from.py_func(self.parts.trail)
        self.x = np.empty(interface.size)
        self.numbers = np.zeros(4)
        self._run = library.call(self.x, self.block, self.numbers)

    def _wire(
        self, k: int, source: CalledParticipant, target: CalledParticipant, ends: Ends
    ) -> WireRow:
        """Return the row of a wire."""
        span = self.interface.parts[k]
        source_place = sum(source.inputs.values()) + place(source.outputs, ends.output)
        target_place = place(target.inputs, ends.input)
        return WireRow(
            source=ends.source,
            source_place=source_place,
            target=ends.target,
            target_place=target_place,
            seed=target.variables + target_place,
            product=source.variables + source_place,
            first=span.start,
            elements=span.stop - span.start,
            is_unknown=bool(self.interface.feedback[span.start]),
        )

    # ---- a macro step

    def begin(self, macro_step: MacroStep) -> None:
        """Prepare the participants for calls from machine code."""
        raise NotImplementedError

    def end(self, macro_step: MacroStep) -> BaseException | None:
        """Update the participants after the calls; return the exception to raise, or None."""
        raise NotImplementedError

    def solve(self, macro_step: MacroStep, guess: np.ndarray, memory: Any) -> Solution | None:
        """Return the solution; return None and restore the memory if there is none."""
        self._adopt(memory)
        self.x[:] = guess
        self.numbers[:2] = macro_step.step, macro_step.time
        self.begin(macro_step)
        self.parts.before[:] = self.parts.state
        self._run()
        if not self.numbers[-1]:
            self.parts.state[:] = self.parts.before
        if fault := self.end(macro_step):
            self.interface.trail += self._measures()
            raise fault
        return self._solution() if self.numbers[-1] else None

    def _solution(self) -> Solution:
        """Return the solution; add the measures of the wires to the interface."""
        measures = self._measures()
        self.interface.trail += measures
        history = tuple(map(max, measures))
        return Solution(self.x.copy(), history, len(history) - 1, int(self.trail.products[0]))

    def _measures(self) -> list[list[float]]:
        """Return the measures of all wires by evaluation."""
        return self.trail.measures[: int(self.trail.evaluations[0])].tolist()

    def _adopt(self, memory: RecycledGmres) -> None:
        """Move the pairs of a memory into the block."""
        if memory.pairs is not self.pairs:
            for own, known in zip(self.pairs, memory.pairs_of(self.pairs.images.shape[1])):
                own[...] = known
            memory.pairs = self.pairs


class ByPointers(Iteration):
    """Iteration on FMI 2.0 instances of this process."""

    def __init__(self, newton: Newton, interface: Interface, library: Library):
        from ...participants.pointers import PointerParticipant

        names = list(interface.participants)
        participants: Mapping[str, Any] = interface.participants
        sides = interface.inputs, interface.outputs
        sizes = [
            [{end.variable: end.part.stop - end.part.start for end in side[n]} for side in sides]
            for n in names
        ]
        self.pointed = {
            n: PointerParticipant(participants[n], *map(list, s)) for n, s in zip(names, sizes)
        }
        super().__init__(
            newton,
            interface,
            library,
            [CalledParticipant(one.address, *s) for one, s in zip(self.pointed.values(), sizes)],
            [
                Ends(names.index(w.source[0]), w.source[1], names.index(w.target[0]), w.target[1])
                for w in interface.wires
            ],
        )

    def begin(self, macro_step: MacroStep) -> None:
        for name, one in self.pointed.items():
            one.begin(macro_step.saved[name])

    def end(self, macro_step: MacroStep) -> BaseException | None:
        spent = self.interface.spent
        for name, one in self.pointed.items():
            one.end(macro_step.saved[name], macro_step.time, macro_step.step)
            spent[name] += one.spent
            spent["transport"] += one.carried
        return next(filter(None, (one.fault() for one in self.pointed.values())), None)


class ByPython(Iteration):
    """Iteration on any participants: one that stands for the interface, with all wires."""

    def __init__(self, newton: Newton, interface: Interface, library: Library):
        from ...participants.pointers import CallbackParticipant

        self.asked = CallbackParticipant(self._answer)
        self.macro_step: MacroStep | None = None
        sizes = {k: span.stop - span.start for k, span in enumerate(interface.parts)}
        super().__init__(
            newton,
            interface,
            library,
            [CalledParticipant(self.asked.address, sizes, sizes)],
            [Ends(0, k, 0, k) for k in sizes],
        )
        self.given, self.said, self.seeds, self.products = self.parts.inside[
            : 4 * interface.size
        ].reshape(4, -1)

    def _answer(self, entry: int) -> None:
        """Run an entry on the variables in the block."""
        from ...participants.pointers import ADVANCE

        assert self.macro_step is not None
        if entry == ADVANCE:
            self.said[:] = self.macro_step.evaluate(self.given).outputs
        else:
            self.products[:] = self.macro_step.derivative(self.seeds)

    def begin(self, macro_step: MacroStep) -> None:
        self.macro_step = macro_step

    def end(self, macro_step: MacroStep) -> BaseException | None:
        self.macro_step = None
        return self.asked.fault()


def place(sizes: Sizes, name: Any) -> int:
    """Return the number of elements before a variable."""
    names = list(sizes)
    return sum(sizes[one] for one in names[: names.index(name)])
