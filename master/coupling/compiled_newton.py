"""Interface Newton-Krylov of `run` as machine code: one call for each macro step.

The code is that of a native coupled FMU, `native.iterate` in the library of the same packages. It
calls the native FMUs of this process by pointers (front/parts.c).
"""

import ctypes
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..fmi.block import memory_of, row_of
from ..fmi.native_parts import NOWHERE
from ..participants.fmi2 import FmuParticipant
from .interface import Ends, Interface
from .methods.krylov import RecycledGmres
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
    parts_of,
    state_from,
)
from .wiring import System

FUNCTIONS = (
    "fmi2SetFMUstate",
    "fmi2SetReal",
    "fmi2DoStep",
    "fmi2GetReal",
    "fmi2GetDirectionalDerivative",
)
FIRST_CALLED = 256
"""Code of the first instance, as in front/parts.c."""
EMPTY = 2
"""Length of the memory of an instance: an empty list of faults."""
NOTED = FOUND + 2
"""Numbers of `native.iterate` before the measures."""


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
    ]


def compiled_if_native(method: Method, system: System, packages: Iterable[str], may_build: bool):
    """Return the method, for `Newton` as machine code if all participants are native FMUs.

    packages : of the participants; may_build : whether to build the library if there is none.
    """
    chosen = sorted({package for package in packages if package})
    if type(method) is not Newton or method.differences or not system.wires or system.held:
        return method
    if any(wire.relative_tolerance or not wire.tolerance for wire in system.wires):
        return method
    if not chosen or not _are_native(system.participants.values()):
        return method
    from ..fmi.builder_native import library_file  # slow to import

    library = library_file(("master.coupling", *chosen), may_build)
    return CompiledNewton(method, library) if library else method


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
    """

    def __init__(self, newton: Newton, library: Path):
        self.newton = newton
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
            self._iteration = Iteration(self.newton, interface, self.run) if is_whole else None
        solution = None
        if self._iteration and isinstance(macro_step, MacroStep):
            solution = self._iteration.solve(macro_step, guess, memory)
        return solution or self.newton.solve(macro_step, guess, memory)


class Iteration:
    """Participants and wires of an interface in the memory of the machine code."""

    def __init__(self, newton: Newton, interface: Interface, run: Any):
        self.interface = interface
        self.names = list(interface.participants)
        self.all_ends: list[Any] = [interface.ends[name] for name in self.names]
        layout, wires = interface.layout, len(interface.wires)
        rows: list[ParticipantRow] = []
        end = saved = 0
        for k, ends in enumerate(self.all_ends):
            variables = _variables(ends)
            reals = 2 * variables
            places = dict(real=end, integer=end + reals, memory=end + reals, saved=saved)
            sizes = dict(reals=reals, memories=EMPTY, variables=variables)
            rows.append(ParticipantRow(FIRST_CALLED + k, **places, **sizes))
            end += reals + EMPTY
            saved += variables
        setup = CoupledSetup(
            Rules(
                *(0.0, 0.0, 0.0, 1, 0),  # Python steps
                newton.max_iterations,
                newton.largest_krylov_space,
                newton.accuracy,
                newton.forcing,
            ),
            layout,
            saved=saved,
            owner=NOWHERE,
            order=np.arange(len(rows), dtype=float),
            starting=np.zeros(0),
            participants=np.array([np.array(row, float) for row in rows]),
            wires=np.array([np.array(self._wire(k), float) for k in range(wires)]),
            exposed=ExposedVariables(*np.zeros((len(ExposedVariables._fields), 0, 0))),
            contents=np.zeros(0),
        )
        lengths, unsaved = lengths_of(setup, end, 0)
        first = memory_of(
            {"setup": row_of(setup)}, dict(zip(CoupledMemory._fields[1:], lengths)), unsaved
        )
        self.block = np.zeros(int(first[0]))
        self.block[: len(first)] = first
        parts = parts_of(self.block)
        parts.state[:] = row_of(nothing_yet(setup))
        self.pairs = state_from(parts.state).pairs
        self.x = np.empty(interface.size)
        self.numbers = np.zeros(NOTED + newton.max_iterations * wires)
        self.called = (Called * len(rows))(*map(self._called, self.names))
        self._lengths = np.array([self.x.size, 0, self.block.size, self.numbers.size])
        arrays = self.x, self.block, self.numbers, self._lengths
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
        self._run = lambda: run(self.called, ctypes.c_size_t(len(rows)), *pointers)

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
        participants: dict[str, Any] = dict(self.interface.participants)
        time, step = macro_step.time, macro_step.step
        if any(one.is_last(time, step) for one in participants.values()):
            return None  # it may be shorter by round-off
        self._adopt(memory)
        self.x[:] = guess
        self.numbers[:2] = step, time
        for one, called in zip(participants.values(), self.called):
            one.begin_step_at(time, step)
            called.begin = macro_step.saved[one.name].value
            called.spent = called.carried = 0.0
        status = self._run()
        self._account()
        if status or not self.numbers[SOLVED]:
            return None
        evaluations, products = self.numbers[FOUND:NOTED].astype(int).tolist()
        measures = self.numbers[NOTED:].reshape(-1, len(self.interface.wires))[:evaluations]
        trail = measures.tolist()
        self.interface.trail += trail
        for one, ends in zip(participants.values(), self.all_ends):
            ends.written.values[ends.of_written] = self.x[ends.into]
            one.note_written(ends.written)
        history = tuple(map(max, trail))
        return Solution(self.x.copy(), history, evaluations - 1, products)

    def _account(self) -> None:
        """Add the times of the calls."""
        spent = self.interface.spent
        for name, called in zip(self.names, self.called):
            spent[name] += called.spent
            spent["transport"] += called.carried

    def _adopt(self, memory: RecycledGmres) -> None:
        """Move the pairs of a memory into the block."""
        if memory.pairs is not self.pairs:
            for own, known in zip(self.pairs, memory.pairs_of(self.pairs.images.shape[1])):
                own[...] = known
            memory.pairs = self.pairs


def _variables(ends: Ends) -> int:
    """Return the number of elements of inputs and outputs."""
    return ends.written.values.size + ends.taken.values.size
