"""Participants as compiled code calls them (front/fmi_parts.c): FMI 2.0 instances of this process
by pointers, without Python; others by a function of Python's.
"""

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

from .fmi2 import FmuParticipant

FUNCTIONS = (
    "fmi2SetFMUstate",
    "fmi2SetReal",
    "fmi2DoStep",
    "fmi2GetReal",
    "fmi2GetDirectionalDerivative",
)


ADVANCE = 2
"""The entry that is a step, as in coupling/native_calls.py; else a derivative is asked for."""

ASK = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int64)


class Instance(ctypes.Structure):
    """As in front/fmi_parts.c."""

    _fields_ = [
        ("ask", ASK),
        ("component", ctypes.c_void_p),
        ("begin", ctypes.c_void_p),
        ("functions", ctypes.c_void_p * len(FUNCTIONS)),
        ("inputs", ctypes.c_void_p),
        ("outputs", ctypes.c_void_p),
        ("input_count", ctypes.c_size_t),
        ("output_count", ctypes.c_size_t),
        ("spent", ctypes.c_double),
        ("carried", ctypes.c_double),
        ("calls", ctypes.c_int64),  # of this macro step
        ("failed", ctypes.c_int64),
        ("status", ctypes.c_int64),
        ("is_called", ctypes.c_int64),
    ]


class Words(list):
    """What an FMU logs while compiled code calls it: that of the last step or derivative, as where
    Python calls.
    """

    def __init__(self, instance: Instance):
        super().__init__()
        self.instance = instance
        self.calls = 0

    def append(self, said: Any) -> None:
        if self.calls != self.instance.calls:
            self.clear()
            self.calls = self.instance.calls
        super().append(said)

    @property
    def last(self) -> list[Any]:
        """Those of the last call."""
        return list(self) if self.calls == self.instance.calls else []


class Asked:
    """Participants in whose place compiled code calls a function of Python's.

    Parameters
    ----------
    answer : callable(entry)
        Takes a step or a derivative, as `entry` says.
    """

    def __init__(self, answer: Callable[[int], None]):
        self.raised: BaseException | None = None

        def ask(entry: int) -> int:
            try:
                answer(entry)
            except BaseException as raised:  # raised again behind the compiled code
                self.raised = raised
                return 1
            return 0

        self.instance = Instance(ask=ASK(ask))

    @property
    def address(self) -> int:
        """Where the instance lies."""
        return ctypes.addressof(self.instance)

    def fault(self) -> BaseException | None:
        """What the last call has raised, if anything."""
        raised, self.raised = self.raised, None
        return raised


class Pointed:
    """A participant that compiled code calls by pointers.

    Parameters
    ----------
    participant : FmuParticipant
        Started.
    inputs, outputs : sequence of str
        Real fields, one behind the other in what is set, read and derived.

    spent, carried : time in steps and derivatives, and in setting and reading, since `begin` [s].
    """

    def __init__(self, participant: FmuParticipant, inputs: Sequence[str], outputs: Sequence[str]):
        self.participant = participant
        self.instance = Instance()
        self.words = Words(self.instance)
        self.instance.inputs, self.instance.input_count = participant.references(inputs)
        self.instance.outputs, self.instance.output_count = participant.references(outputs)

    @property
    def address(self) -> int:
        """Where the instance lies."""
        return ctypes.addressof(self.instance)

    @property
    def spent(self) -> float:
        return self.instance.spent

    @property
    def carried(self) -> float:
        return self.instance.carried

    def begin(self, saved: Any) -> None:
        """Compiled code is about to call it; every step goes from a saved state."""
        one = self.instance
        if one.component != self.participant.component:
            one.component = self.participant.component
            one.functions[:] = self.participant.addresses(FUNCTIONS)
        one.begin = saved
        one.spent = one.carried = 0.0
        one.failed = one.status = one.calls = 0
        self.words = Words(one)
        self.participant.log = self.words

    def end(self, saved: Any, time: float, step: float) -> None:
        """It did; with the last step [s]."""
        self.participant.log = self.words.last
        if self.instance.calls:
            self.participant.stepped(saved, time, step)

    def fault(self) -> Exception | None:
        """What is to be raised, if anything."""
        failed = self.instance.failed
        if not failed:
            return None
        return self.participant.fault(FUNCTIONS[failed - 1], self.instance.status)
