"""Participants that compiled code calls (front/fmi_parts.c).

FMI 2.0 instances of this process are called by pointers, others by a Python function.
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
"""Entry of a step, as in coupling/native_system.py; other entries are derivatives."""

ASK = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int64)


class Instance(ctypes.Structure):
    """`struct` of an instance, as in front/fmi_parts.c."""

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


class CallLog(list):
    """Log of an FMU that compiled code calls, limited to the last step or derivative."""

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
        """Messages of the last call."""
        return list(self) if self.calls == self.instance.calls else []


class CallbackParticipant:
    """Participants that compiled code calls through a Python function.

    Parameters
    ----------
    answer : callable(entry)
        Takes a step or a derivative, depending on `entry`.
    """

    def __init__(self, answer: Callable[[int], None]):
        self.raised: BaseException | None = None

        def ask(entry: int) -> int:
            try:
                answer(entry)
            except BaseException as raised:  # raised again after the compiled code
                self.raised = raised
                return 1
            return 0

        self.instance = Instance(ask=ASK(ask))

    @property
    def address(self) -> int:
        """Address of the instance."""
        return ctypes.addressof(self.instance)

    def fault(self) -> BaseException | None:
        """Return the exception of the last call, or None."""
        raised, self.raised = self.raised, None
        return raised


class PointerParticipant:
    """Participant that compiled code calls by pointers.

    Parameters
    ----------
    participant : FmuParticipant
        Started.
    inputs, outputs : sequence of str
        Real fields, concatenated in the values that are set, read and derived.

    Attributes
    ----------
    spent, carried : float
        Time since `begin` in steps and derivatives, and in setting and reading [s].
    """

    def __init__(self, participant: FmuParticipant, inputs: Sequence[str], outputs: Sequence[str]):
        self.participant = participant
        self.instance = Instance()
        self.words = CallLog(self.instance)
        self.instance.inputs, self.instance.input_count = participant.references(inputs)
        self.instance.outputs, self.instance.output_count = participant.references(outputs)

    @property
    def address(self) -> int:
        """Address of the instance."""
        return ctypes.addressof(self.instance)

    @property
    def spent(self) -> float:
        return self.instance.spent

    @property
    def carried(self) -> float:
        return self.instance.carried

    def begin(self, saved: Any) -> None:
        """Prepare for calls from compiled code; every step starts from a saved state."""
        one = self.instance
        if one.component != self.participant.component:
            one.component = self.participant.component
            one.functions[:] = self.participant.addresses(FUNCTIONS)
        one.begin = saved
        one.spent = one.carried = 0.0
        one.failed = one.status = one.calls = 0
        self.words = CallLog(one)
        self.participant.log = self.words

    def end(self, saved: Any, time: float, step: float) -> None:
        """Update the participant after the calls, with the last step [s]."""
        self.participant.log = self.words.last
        if self.instance.calls:
            self.participant.stepped(saved, time, step)

    def fault(self) -> Exception | None:
        """Return the exception of the last call, or None."""
        failed = self.instance.failed
        if not failed:
            return None
        return self.participant.fault(FUNCTIONS[failed - 1], self.instance.status)
