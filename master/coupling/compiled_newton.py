"""Interface Newton-Krylov of `run` as machine code: one call for each macro step.

The code is that of a native coupled FMU, `native.iterate` in the library of the same packages. It
calls the native FMUs of this process by pointers (front/parts.c). It iterates in the coordinates of
the bodies, as that FMU does, if these determine all unknowns.
"""

import ctypes
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..fmi.block import memory_of, row_of
from ..fmi.native_parts import NOWHERE, READ, WHOLE, NativePart
from ..participants.fmi2 import FmuParticipant
from .interface import Ends, Interface
from .methods.krylov import RecycledGmres, forget
from .methods.newton import Newton
from .methods.solution import MacroStep, Method, Solution, Tried
from .native_block import (
    FOUND,
    SOLVED,
    CoupledMemory,
    CoupledSetup,
    ExposedVariables,
    ParticipantRow,
    Rules,
    WireRow,
    lengths_of,
    nothing_yet,
    owner_of,
    parts_of,
    state_from,
    with_coordinates,
)
from .vector import extrapolate
from .wiring import System

FUNCTIONS = (
    "fmi2SetFMUstate",
    "fmi2SetReal",
    "fmi2DoStep",
    "fmi2GetReal",
    "fmi2GetDirectionalDerivative",
    "native_task",
)
FIRST_CALLED = 256
"""Code of the first instance, as in front/parts.c."""
EMPTY_MEMORY = 2
"""Length of the memory of an instance without coordinates: an empty list of faults."""
NOTED = FOUND + 2
"""Numbers of `native.iterate` before the measures."""


DERIVE = ctypes.CFUNCTYPE(
    ctypes.c_int,
    *(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t),
    *(ctypes.c_void_p, ctypes.c_void_p),
)
TASK = ctypes.CFUNCTYPE(
    ctypes.c_int64, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_void_p
)
"""Functions of an FMU, the second as in front/native.c."""
TIME_TOLERANCE = 1e-6
"""Share of a macro step in which two times are equal."""


class Called(ctypes.Structure):
    """Instance, as in front/parts.c."""

    _fields_ = [
        ("component", ctypes.c_void_p),
        ("begin", ctypes.c_void_p),
        ("functions", ctypes.c_void_p * len(FUNCTIONS)),
        ("inputs", ctypes.c_void_p),
        ("outputs", ctypes.c_void_p),
        ("input_count", ctypes.c_size_t),
        ("output_count", ctypes.c_size_t),
        ("spent", ctypes.c_double),
        ("carried", ctypes.c_double),
        ("has_moved", ctypes.c_int),
    ]


def compiled_if_native(
    method: Method,
    system: System,
    packages: Mapping[str, str | None],
    may_build: bool,
    predicted: int = 0,
):
    """Return the method, for `Newton` as machine code if all participants are native FMUs.

    packages : of the participants; may_build : whether to build the library if there is none;
    predicted : as of `CompiledNewton`.
    """
    chosen = sorted({package for package in packages.values() if package})
    if type(method) is not Newton or method.differences or not system.wires or system.held:
        return method
    if any(wire.relative_tolerance or not wire.tolerance for wire in system.wires):
        return method
    if not chosen or not _are_native(system.participants.values()):
        return method
    from ..fmi.builder_native import library_file, part_of  # slow to import

    library = library_file(("master.coupling", *chosen), may_build)
    if not library:
        return method
    if not all(packages.get(name) for name in system.participants):
        predicted = 0  # another FMU says nothing about its coordinates
    parts = {name: part_of(str(packages[name])) for name in system.participants if predicted}
    return CompiledNewton(method, library, parts, predicted)


def _are_native(participants: Iterable[Any]) -> bool:
    """Return whether all participants are native FMUs of this process."""
    file = Path("resources", "slave.bin")
    return all(type(one) is FmuParticipant and (one.folder / file).exists() for one in participants)


class CompiledNewton:
    """`Newton` as machine code.

    Both have the same memory. A macro step that fails is solved again by `Newton` in Python, which
    writes the messages.

    Parameters
    ----------
    newton : Newton
    library : Path
        Library of a native coupled FMU.
    parts : mapping
        Native parts of the participants by name.
    predicted : int
        Largest number of vectors from which coordinates are extrapolated; 0 iterates on wires.
    """

    def __init__(
        self, newton: Newton, library: Path, parts: Mapping[str, NativePart], predicted: int
    ):
        self.newton, self.parts, self.predicted = newton, parts, predicted
        self.run = ctypes.CDLL(str(library)).coupling_iterate
        self._interface: Interface | None = None
        self._iteration: Iteration | None = None

    def memory(self) -> RecycledGmres:
        return self.newton.memory()

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: RecycledGmres) -> Solution:
        interface = macro_step.interface
        if self._interface is not interface:
            self._interface = interface
            is_whole = _are_native(interface.participants.values())
            self._iteration = Iteration(self, interface) if is_whole else None
        solution = None
        if self._iteration and isinstance(macro_step, MacroStep):
            solution = self._iteration.solve(macro_step, guess, memory)
        return solution or self.newton.solve(macro_step, guess, memory)


class Coordinates:
    """Coordinates of a native instance, in its memory; an FMU of an earlier version has none."""

    def __init__(self, participant: Any):
        self.participant = participant
        self.component, (derive, task) = participant.addresses(FUNCTIONS[-2:])
        self._derive, self._task = DERIVE(derive), TASK(task) if task else None
        self.count = len(self._coordinates(WHOLE)) if task else 0

    def _coordinates(self, task: float) -> np.ndarray:
        """Return all, in the memory of the instance; its next derivative does the task."""
        at = ctypes.POINTER(ctypes.c_double)()
        count: int = self._task(self.component, task, 0.0, ctypes.byref(at)) if self._task else 0
        return np.ctypeslib.as_array(at, (count,))

    def read(self, saved: Mapping[str, Any]) -> np.ndarray:
        """Return those of the saved state of the participant."""
        self.participant.restore(saved[self.participant.name])
        coordinates = self._coordinates(READ)
        self._derive(self.component, None, 0, None, 0, None, None)
        return coordinates.copy()


class Iteration:
    """Participants and wires of an interface in the memory of the machine code.

    The vector is that of the interface, then coordinates if there are some.
    """

    def __init__(self, method: "CompiledNewton", interface: Interface):
        self.interface, self.predicted = interface, method.predicted
        self.names = list(interface.participants)
        self.all_ends: list[Any] = [interface.ends[name] for name in self.names]
        self.layout = interface.layout
        owner, self.owned = self._owner(method.parts)
        count = self.owned.count if self.owned else 0
        if owner != NOWHERE:
            self.layout = with_coordinates(self.layout, count)
        rows = self._rows(count)
        self.block = self._block(self._setup(method.newton, rows, owner), rows[-1])
        self.state = parts_of(self.block).state
        self.pairs, self.scale = state_from(self.state).pairs, state_from(self.state).scale
        self.x = np.empty(len(self.layout.nominal))
        self.numbers = np.zeros(NOTED + method.newton.max_iterations * len(interface.wires))
        called = (Called * len(rows))(*map(self._called, self.names))
        self.each = [(ends.participant, ends, one) for ends, one in zip(self.all_ends, called)]
        self._lengths = np.array([self.x.size, 0, self.block.size, self.numbers.size])
        arrays = self.x, self.block, self.numbers, self._lengths
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
        self._run = partial(method.run, called, ctypes.c_size_t(len(rows)), *pointers)

    def _setup(self, newton: Newton, rows: list[ParticipantRow], owner: int) -> CoupledSetup:
        """Return the data of participants, wires and method for the machine code."""
        wires = range(len(self.interface.wires))
        return CoupledSetup(
            Rules(
                *(0.0, 0.0, 0.0, 1, 0),  # Python steps
                newton.max_iterations,
                newton.largest_krylov_space,
                newton.accuracy,
                newton.forcing,
            ),
            self.layout,
            saved=sum(row.variables for row in rows),
            owner=owner,
            order=np.arange(len(rows), dtype=float),
            starting=np.zeros(0),
            participants=np.array([np.array(row, float) for row in rows]),
            wires=np.array([np.array(self._wire(k), float) for k in wires]),
            exposed=ExposedVariables(*np.zeros((len(ExposedVariables._fields), 0, 0))),
            contents=np.zeros(0),
        )

    def _block(self, setup: CoupledSetup, last: ParticipantRow) -> np.ndarray:
        """Return the memory with its setup, and a state in which nothing is known."""
        lengths, unsaved = lengths_of(setup, last.memory + last.memories, 0)
        first = memory_of(
            {"setup": row_of(setup)}, dict(zip(CoupledMemory._fields[1:], lengths)), unsaved
        )
        block = np.zeros(int(first[0]))
        block[: len(first)] = first
        parts_of(block).state[:] = row_of(nothing_yet(setup))
        return block

    def _owner(self, parts: Mapping[str, NativePart]) -> tuple[int, Coordinates | None]:
        """Return the participant whose coordinates determine all unknowns, and these."""
        if self.predicted:
            own = {name: parts[name] for name in self.names}
            owner = owner_of(self.interface.wires, self.layout, own)
            if owner != NOWHERE:
                owned = Coordinates(self.interface.participants[self.names[owner]])
                return (owner, owned) if owned.count else (NOWHERE, None)
        return NOWHERE, None

    def _rows(self, coordinates: int) -> list[ParticipantRow]:
        """Return the rows of all participants, each with room for so many coordinates."""
        rows: list[ParticipantRow] = []
        end = saved = 0
        for k, ends in enumerate(self.all_ends):
            variables = _variables(ends)
            memory = end + 2 * variables
            rows.append(
                ParticipantRow(
                    FIRST_CALLED + k,
                    real=end,
                    reals=2 * variables,
                    integer=memory,
                    memory=memory,
                    memories=EMPTY_MEMORY + coordinates,
                    variables=variables,
                    saved=saved,
                    first_coordinate=EMPTY_MEMORY,
                    coordinates=coordinates,
                )
            )
            end = memory + EMPTY_MEMORY + coordinates
            saved += variables
        return rows

    def _called(self, name: str) -> Called:
        """Return the instance of a participant, which has started."""
        participant: Any = self.interface.participants[name]
        ends: Any = self.interface.ends[name]
        component, functions = participant.addresses(FUNCTIONS)
        called = Called(component)
        called.functions[:] = functions
        called.inputs, called.input_count = ends.written.references
        called.outputs, called.output_count = ends.taken.references
        return called

    def _wire(self, k: int) -> WireRow:
        """Return the row of a wire."""
        interface = self.interface
        wire, part = interface.wires[k], interface.parts[k]
        ends = dict[str, Any](interface.ends)
        source, target = ends[wire.source[0]], ends[wire.target[0]]
        source_place = source.written.values.size + source.taken.parts[wire.source[1]].start
        target_place = target.written.parts[wire.target[1]].start
        return WireRow(
            source=self.names.index(wire.source[0]),
            source_place=source_place,
            target=self.names.index(wire.target[0]),
            target_place=target_place,
            seed=_variables(target) + target_place,
            product=_variables(source) + source_place,
            first=part.start,
            elements=part.stop - part.start,
            is_unknown=bool(interface.feedback[part.start]),
        )

    def solve(self, macro_step: MacroStep, guess: np.ndarray, memory: Any) -> Solution | None:
        """Return the solution, None if there is none."""
        time, step = macro_step.time, macro_step.step
        if any(one.is_last(time, step) for one, _, _ in self.each):
            return None  # it may be shorter by round-off
        self._adopt(memory)
        wires = self.interface.size
        self.x[:wires] = guess
        if self.owned:
            self.x[wires:] = self._guess(macro_step, memory)
        self.numbers[:2] = step, time
        for one, _, called in self.each:
            saved = macro_step.saved[one.name]
            called.has_moved = one.at is not saved
            one.begin_step_at(time, step)
            called.begin = saved.value
            called.spent = called.carried = 0.0
        status = self._run()
        self._account()
        if status or not self.numbers[SOLVED]:
            return None
        evaluations, products = self.numbers[FOUND:NOTED].astype(int).tolist()
        measures = self.numbers[NOTED:].reshape(-1, len(self.interface.wires))[:evaluations]
        trail = measures.tolist()
        self.interface.trail += trail
        for one, ends, _ in self.each:
            ends.written.values[ends.of_written] = self.x[ends.into]
            one.note_written(ends.written)
        if self.owned:
            now = self.x[wires:].copy()
            memory.past = [*memory.past, (time + step, now)][-self.predicted - 1 :]
        history = tuple(map(max, trail))
        return Solution(self.x[:wires].copy(), history, evaluations - 1, products)

    def _account(self) -> None:
        """Add the times of the calls."""
        spent = self.interface.spent
        for one, _, called in self.each:
            spent[one.name] += called.spent
            spent["transport"] += called.carried

    def _guess(self, macro_step: MacroStep, memory: RecycledGmres) -> np.ndarray:
        """Return the coordinates at the end of a step, extrapolated as the wires.

        The memory may end with those of a step that was rejected later, so it holds one more. If
        it lacks those at the begin, they are read.
        """
        time, step = macro_step.time, macro_step.step
        known = [one for one in memory.past if one[0] <= time + TIME_TOLERANCE * step]
        memory.past = known[-self.predicted :]
        if not memory.past or memory.past[-1][0] < time - TIME_TOLERANCE * step:
            assert self.owned
            memory.past = [(time, self.owned.read(macro_step.saved))]
        times, vectors = zip(*memory.past)
        last = vectors[-1]
        return last + macro_step.share * (extrapolate(times, vectors, time + step) - last)

    def _adopt(self, memory: RecycledGmres) -> None:
        """Move pairs and scale of a memory into the block."""
        if memory.pairs is self.pairs:
            return
        forget(self.pairs)
        if memory.pairs and memory.pairs.products.shape == self.pairs.products.shape:
            for own, known in zip(self.pairs, memory.pairs):
                own[...] = known
        self.scale[:] = 0.0 if memory.scale is None else memory.scale
        memory.pairs, memory.scale = self.pairs, self.scale


def _variables(ends: Ends) -> int:
    """Return the number of elements of inputs and outputs."""
    return ends.written.values.size + ends.taken.values.size
