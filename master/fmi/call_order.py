"""Order of calls of an FMU with the library of pythonfmu, which does not check it.

The phases, what they allow and the sentences are those of front/common.c. Of the library's calls
only a step has a status. A misplaced call is logged and ignored, and a misplaced step is discarded.
"""

import atexit
import ctypes
from collections.abc import Callable
from functools import cache
from math import inf, isfinite, isnan
from pathlib import Path
from struct import Struct, error
from typing import Any, NamedTuple

import numpy as np

from .errors import BadInput
from .slave import FieldSlave, Fmi2Status


class Phase(NamedTuple):
    """Phase of an instance: its name, what to do next, and which kinds of variables may be set."""

    name: str
    hint: str
    settable: str
    kinds: tuple[str, ...]


FIRST = "enter Initialization Mode first"
AGAIN = "reset the instance to start again"
CHANGING = ("input", "tunable parameter")
GIVEN = ("a parameter or an input", ("parameter", *CHANGING))
INSTANTIATED = Phase("before Initialization Mode", FIRST, *GIVEN)
INITIALIZING = Phase("in Initialization Mode", "leave Initialization Mode first", *GIVEN)
STEPPING = Phase("in Step Mode", AGAIN, "an input or a tunable parameter", CHANGING)
TERMINATED = Phase("after termination", AGAIN, "no variable", ())
PHASES = (INSTANTIATED, INITIALIZING, STEPPING, TERMINATED)

SHARE, LENIENCE, ROUNDING = 1e-6, 1e-2, 1e-15
"""Error of the beginning of a step and of its end at the stop time, over the step; of a time."""

PROGRESS = Struct("<dq")
"""Time and number of the phase, which follow the bytes of a saved state."""


class CallOrder(FieldSlave):
    """Checks of the calls of a model class that is the next base class."""

    phase, reached, stop = INSTANTIATED, 0.0, inf

    def __init__(self, **kwargs: Any):
        super().__init__(**kwargs)
        release_at_exit(self.resources.parent)
        # rows of the table by value reference, the last one for seeds and products
        self.owner = np.full(self.first_text + len(self.string), -1)
        for k, v in enumerate(self.table):
            first = self.first_references[v.name]
            self.owner[first : first + v.size] = k

    def _reject(self, where: str, words: str) -> bool:
        self._fail(f"{where}: expected {words}", Fmi2Status.error)
        return False

    def _moves(self, where: str, before: Phase, after: Phase) -> bool:
        """Go on from a phase to the next; return whether that is possible, and log it if not."""
        now = self.phase
        if now is not before:
            return self._reject(where, f"a call {before.name}, got one {now.name}; {now.hint}")
        self.phase = after
        return True

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        where, stop = "fmi2SetupExperiment", inf if stop_time is None else stop_time
        if not self._moves(where, INSTANTIATED, INSTANTIATED):
            return
        if not (isfinite(start_time) and start_time <= stop):
            got = f"got start {start_time:g} s and stop {stop:g} s"
            self._reject(where, f"a finite start before the stop, {got}")
            return
        self.reached, self.stop = start_time, stop

    def enter_initialization_mode(self) -> None:
        if self._moves("fmi2EnterInitializationMode", INSTANTIATED, INITIALIZING):
            super().enter_initialization_mode()

    def exit_initialization_mode(self) -> None:
        if self._moves("fmi2ExitInitializationMode", INITIALIZING, STEPPING):
            super().exit_initialization_mode()

    def terminate(self) -> None:
        if self._moves("fmi2Terminate", STEPPING, TERMINATED):
            super().terminate()

    def do_step(self, current_time: float, step_size: float) -> bool:
        where, time, step = "fmi2DoStep", current_time, step_size
        if not self._moves(where, STEPPING, STEPPING):
            return False
        if not isfinite(time) or isnan(step):
            return self._reject(where, f"finite times, got a step of {step:g} s at {time:g} s")
        rounding, end = ROUNDING * abs(time), time + step
        if not abs(time - self.reached) <= SHARE * abs(step) + rounding:
            got = f"got one at {time:.15g} s; restore a state to return"
            return self._reject(where, f"a step at {self.reached:.15g} s, {got}")
        if isfinite(step) and end - self.stop > LENIENCE * abs(step) + rounding:
            got = f"the stop time, got one to {end:.15g} s"
            return self._reject(where, f"a step to at most {self.stop:.15g} s, {got}")
        if not super().do_step(time, step):
            return False
        self.reached = end
        return True

    def _set(self, where: str, references: list[int], set_them: Callable[[], None]) -> None:
        """Set variables; log the first one that may not be set, or that is none of this type."""
        may = np.array([v.kind in self.phase.kinds for v in self.table] + [True])
        try:
            wrong = np.flatnonzero(~may[self.owner[list(references)]])
            if not wrong.size:
                set_them()
                return
        except IndexError:
            self._reject(where, f"variables of this type, got others among {len(references)}")
            return
        reference = references[int(wrong[0])]
        got = f"got the {self.table[int(self.owner[reference])].kind} of value reference"
        self._reject(where, f"{self.phase.settable} {self.phase.name}, {got} {reference}")

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        self._set("fmi2SetReal", vrs, lambda: super(CallOrder, self).set_real(vrs, values))

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self._set("fmi2SetInteger", vrs, lambda: super(CallOrder, self).set_integer(vrs, values))

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        self._set("fmi2SetString", vrs, lambda: super(CallOrder, self).set_string(vrs, values))

    # state

    def _get_fmu_state(self) -> Any:
        return super()._get_fmu_state(), self.reached, self.phase

    def _set_fmu_state(self, saved: Any) -> None:
        if saved is None:
            self._reject("fmi2SetFMUstate", "a state of this FMU, got none")
            return
        state, self.reached, self.phase = saved
        super()._set_fmu_state(state)

    @classmethod
    def _fmu_state_to_bytes(cls, saved: Any) -> bytes:
        state, reached, phase = saved
        return super()._fmu_state_to_bytes(state) + PROGRESS.pack(reached, PHASES.index(phase))

    def _fmu_state_from_bytes(self, data: Any) -> Any:
        try:
            reached, phase = PROGRESS.unpack(bytes(data[-PROGRESS.size :]))
            return super()._fmu_state_from_bytes(data), reached, PHASES[phase]
        except (BadInput, IndexError, error) as fault:
            self._fail(f"fmi2DeSerializeFMUstate: {fault}", Fmi2Status.error)
            return None


@cache
def release_at_exit(folder: Path) -> None:
    """Release what the library in the folder of an FMU keeps of Python before a Linux host exits.

    At the exit the library frees it twice, and a host may abort. After this call nothing is left.
    """
    for path in folder.glob("binaries/linux64/*.so"):
        atexit.register(ctypes.CDLL(str(path)).finalizePythonInterpreter)


def in_order(model: type[FieldSlave]) -> type[FieldSlave]:
    """Return a model class whose calls are checked."""
    return type(model.__name__, (CallOrder, model), {})
