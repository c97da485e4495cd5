"""Interface Newton-Krylov as machine code, on FMI 2.0 FMUs of this process: a macro step is one
call, which does what `Newton.solve` does.

The machine code is that of a native coupled FMU (`native_newton`); its participants are the FMUs'
instances, called by pointers (front/fmi_parts.c).
"""

import ctypes
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..interface import End, Interface
from ..native_block import (
    CONSTANT,
    COUNTED,
    DIFFERENCES,
    EVALUATIONS,
    GRAM,
    IMAGES,
    MOST_FAULTS,
    NOWHERE,
    OF_A_FAULT,
    OF_LAST,
    OF_ROW,
    OF_TRAIL,
    OF_WIRE,
    OLDEST,
    PRODUCTS,
    STATE,
    TRAIL,
    given,
    in_order,
    part,
)
from ..wiring import System
from .krylov import KEPT, NOISE, RecycledGmres
from .newton import Newton
from .solution import MacroStep, Method, Solution, Tried


def compiled_where_it_can(method: Method, system: System) -> Method:
    """The method, or for `Newton` on FMUs that machine code can call one that calls them so, where
    its library is there.
    """
    from ...fmi.builder_native import iteration_library

    if type(method) is not Newton or method.differences or not is_covered(system):
        return method
    library = iteration_library()
    return CompiledNewton(method, library) if library else method


def is_covered(system: System) -> bool:
    """Whether machine code can call all participants, and knows the norms of all wires."""
    from ...participants.fmi2 import FmuParticipant

    sources = {wire.source[0] for wire in system.wires}
    targets = {wire.target[0] for wire in system.wires}
    relative = any(w.relative_tolerance or w.residual_relative_tolerance for w in system.wires)
    return (
        bool(system.wires)
        and not relative
        and all(
            type(one) is FmuParticipant
            and one.can_redo
            and (one.has_standard_derivative or name not in sources & targets)
            for name, one in system.participants.items()
        )
    )


class CompiledNewton:
    """`Newton` as machine code.

    What it remembers is Newton's, so that either goes on from where the other stopped. A macro step
    in which anything is not as it should be (refused, not converged, not finite) is solved again by
    Newton in Python, from what was remembered before: what is said of it is Newton's word. An error
    of an FMU is raised at once, for an FMU need not answer after one.

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
            self._iteration = Iteration(self.newton, macro_step.interface, self.library)
        solution = self._iteration.solve(macro_step, guess, memory)
        return solution or self.newton.solve(macro_step, guess, memory)


class Library:
    """The machine code, with memory for its calls."""

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

    def run(self, real: np.ndarray, memory: np.ndarray, numbers: np.ndarray) -> None:
        """The entry `iterate` of `native`."""
        lengths = np.array([real.size, 0, memory.size, numbers.size])
        arrays = (array.ctypes.data for array in (real, memory, numbers, lengths))
        if self._run(self._pool, *arrays):
            raise MemoryError("not enough memory for the iteration of a macro step")


class Iteration:
    """The participants and wires of an interface, as machine code knows them."""

    def __init__(self, newton: Newton, interface: Interface, library: Library):
        from ...participants.pointers import Pointed

        self.interface = interface
        self.library = library
        self.names = list(interface.participants)
        self.ins = {name: distinct(interface.inputs[name]) for name in self.names}
        self.outs = {name: distinct(interface.outputs[name]) for name in self.names}
        participants: Mapping[str, Any] = interface.participants
        self.pointed = {
            name: Pointed(participants[name], list(self.ins[name]), list(self.outs[name]))
            for name in self.names
        }
        contents = self._contents(newton)
        lengths = self._lengths(newton.max_iterations)
        first = len(given(contents, lengths))
        contents["rows"] = in_order(self._rows(first), OF_ROW)
        head = given(contents, lengths)
        self.block = np.zeros(int(head[0]))
        self.block[: len(head)] = head
        self.x = np.empty(interface.size)
        self.numbers = np.zeros(4)
        pairs = (self.kept, self.unknowns)
        self.images = self._part(IMAGES).reshape(pairs)
        self.differences = self._part(DIFFERENCES).reshape(pairs)
        self.gram = self._part(GRAM).reshape(self.kept, self.kept)
        self.oldest = self._part(OLDEST)
        self.trail = self._part(TRAIL)

    @property
    def unknowns(self) -> int:
        """Elements that are unknowns."""
        return int(self.interface.feedback.sum())

    @property
    def kept(self) -> int:
        """Pairs that the Krylov method remembers."""
        return min(KEPT, self.unknowns)

    def _part(self, which: int) -> np.ndarray:
        return part.py_func(self.block, which)

    # ---- the block of memory

    def _contents(self, newton: Newton) -> dict[str, np.ndarray]:
        """Parts that are given."""
        counts = dict.fromkeys(COUNTED, 0.0) | {
            "participants": len(self.names),
            "wires": len(self.interface.wires),
            "size": self.interface.size,
            "unknowns": self.unknowns,
            "kept": self.kept,
            "iterations": newton.max_iterations,
            "space": newton.largest_krylov_space,
        }
        constants = dict.fromkeys(CONSTANT, 0.0) | {
            "accuracy": newton.accuracy,
            "forcing": newton.forcing,
            "noise": NOISE,
        }
        return {
            "counts": in_order([counts], COUNTED),
            "constants": in_order([constants], CONSTANT),
            "order": np.arange(len(self.names), dtype=float),
            "starting": np.zeros(0),
            "rows": in_order(self._rows(0), OF_ROW),
            "wires": in_order(self._wires(), OF_WIRE),
            "exposed": np.zeros(0),
            "contents": np.zeros(0),
        }

    def _lengths(self, evaluations: int) -> dict[str, int]:
        """Of the parts that are not given."""
        states = dict.fromkeys(STATE, 0) | {
            "oldest": 1,
            "images": self.kept * self.unknowns,
            "differences": self.kept * self.unknowns,
            "gram": self.kept**2,
        }
        faults = 1 + OF_A_FAULT * MOST_FAULTS
        return {
            "inside": sum(map(self._inside, self.names)),
            "saved": 0,
            **states,
            "before": sum(states.values()),
            "marks": self.kept,
            "last": len(OF_LAST),
            "last_inputs": 0,
            "last_outputs": 0,
            "trail": len(OF_TRAIL) + evaluations * len(self.interface.wires),
            "failures": faults,
            "faults": faults,
        }

    def _inside(self, name: str) -> int:
        """Numbers that a participant takes: inputs, outputs, seeds and products, and how many
        faults it has noted, which is none.
        """
        return 2 * (length(self.ins[name]) + length(self.outs[name])) + 1

    def _rows(self, behind: int) -> list[dict[str, float]]:
        """`OF_ROW` of every participant, the first of them `behind` so many numbers. Its state is
        the FMU's, which is put back before every step: there is none here.
        """
        rows = []
        for name in self.names:
            inside = self._inside(name)
            row = dict.fromkeys(OF_ROW, 0.0) | {
                "code": float(self.pointed[name].address),
                "real": behind,
                "reals": inside - 1,
                "memory": behind + inside - 1,
                "memories": 1,
            }
            rows.append(row)
            behind += inside
        return rows

    def _wires(self) -> list[dict[str, float]]:
        """`OF_WIRE` of every wire."""
        rows = []
        unknown = 0
        for wire, part_of_it in zip(self.interface.wires, self.interface.parts):
            first, size = part_of_it.start, part_of_it.stop - part_of_it.start
            source, target = wire.source[0], wire.target[0]
            against = bool(self.interface.feedback[first])
            source_place = length(self.ins[source]) + place(self.outs[source], wire.source[1])
            target_place = place(self.ins[target], wire.target[1])
            decrease = wire.largest_decrease
            row = dict.fromkeys(OF_WIRE, 0.0) | {
                "source": self.names.index(source),
                "source_place": source_place,
                "target": self.names.index(target),
                "target_place": target_place,
                "elements": size,
                "first": first,
                "unknown": unknown if against else NOWHERE,
                "nominal": wire.nominal,
                "tolerance": wire.tolerance,
                "largest_decrease": NOWHERE if decrease is None else decrease,
                "seed": self._variables(target) + target_place,
                "product": self._variables(source) + source_place,
                "low": -np.inf,
                "high": np.inf,
                "columns": 1,
            }
            rows.append(row)
            unknown += size if against else 0
        return rows

    def _variables(self, name: str) -> int:
        """Elements of a participant's inputs and outputs; seeds and products lie behind them."""
        return length(self.ins[name]) + length(self.outs[name])

    # ---- a macro step

    def solve(self, macro_step: MacroStep, guess: np.ndarray, memory: Any) -> Solution | None:
        """As `Newton.solve`; None where it is not found, and what is remembered is as before."""
        _, time, step, saved = macro_step
        self._adopt(memory)
        self.oldest[0] = memory.oldest
        self.x[:] = guess
        self.numbers[:2] = step, time
        for name, one in self.pointed.items():
            one.begin(saved[name])
        self.library.run(self.x, self.block, self.numbers)
        memory.oldest = int(self.oldest[0])
        spent = self.interface.spent
        for name, one in self.pointed.items():
            one.end(saved[name], time, step)
            spent[name] += one.spent
            spent["transport"] += one.carried
        for one in self.pointed.values():
            if fault := one.fault():
                raise fault
        return self._solution() if self.numbers[2] else None

    def _solution(self) -> Solution:
        """What was found; the interface is told the measures of the wires."""
        evaluations = int(self.trail[EVALUATIONS])
        wires = len(self.interface.wires)
        measures = self.trail[len(OF_TRAIL) :][: evaluations * wires].reshape(-1, wires).tolist()
        self.interface.trail += measures
        history = tuple(map(max, measures))
        return Solution(self.x.copy(), history, evaluations - 1, int(self.trail[PRODUCTS]))

    def _adopt(self, memory: RecycledGmres) -> None:
        """Let a memory lie in the block, where the machine code has it."""
        if memory.images is self.images:
            return
        knows_something = memory.images.size > 0
        for name in ("images", "differences", "gram"):
            own = getattr(self, name)
            own[...] = getattr(memory, name) if knows_something else 0.0
            setattr(memory, name, own)


def distinct(ends: Sequence[End]) -> dict[str, int]:
    """Elements of every variable at one side of a participant, in their order."""
    return {end.variable: end.part.stop - end.part.start for end in ends}


def length(sizes: Mapping[str, int]) -> int:
    """Elements of all."""
    return sum(sizes.values())


def place(sizes: Mapping[str, int], name: str) -> int:
    """Elements in front of a variable."""
    names = list(sizes)
    return sum(sizes[one] for one in names[: names.index(name)])
