"""FMI 2.0 FMU under the master: steps, saved states, derivatives, log."""

import ctypes
import re
from collections import deque
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from math import inf, nextafter

import fmpy
import numpy as np
from fmpy import fmi2

from ..fmi.archive import unpack
from ..fmi.errors import BadInput, CallFailed, Discard, Finished, ParticipantFault
from .derivatives import RepeatedStep
from .exits import guard_exit
from .participant import StartedInHalves, derive_each
from .printf import Logger, printed
from .transfer import FAILED, FmuFields
from .warned import LoggedWarnings

TIME_TOLERANCE = 1e-9
"""Share of a step that counts as zero."""
TRUE = ctypes.c_int(fmi2.fmi2True)
WARNING = fmi2.fmi2Warning
MOST_MESSAGES = 200
"""Maximum number of messages of a call that are kept for its errors."""
REFERENCE = re.compile(r"value reference (\d+)")


def step_within(time, step, stop):
    """Return a step [s] that does not end beyond the stop time by round-off.

    Longer steps, which trials take, do not change.
    """
    if not 0.0 < time + step - stop <= TIME_TOLERANCE * step < inf:
        return step
    step = stop - time
    return step if time + step <= stop else nextafter(step, 0.0)


class FmuParticipant(RepeatedStep, StartedInHalves, FmuFields):
    """FMI 2.0 co-simulation FMU.

    Parameters
    ----------
    name : str
        Name in the system.
    path : Path
        The FMU. It is unpacked into a cache folder that is named by content, so that its compiled
        code remains cached.
    sizes : dict of str to int, optional
        Values of its structural parameters.
    elements : iterable of str, optional
        Elements of arrays ("y[2]") that are fields too, next to their array.

    Attributes
    ----------
    at : saved state or None
        Saved state of the instance, until a step changes it.

    Raises
    ------
    BadInput
        If the file is not an FMU for co-simulation.
    """

    has_clocks = False
    event_mode = True
    _state = "FMUstate"

    def __init__(self, name, path, sizes=None, elements=()):
        super().__init__(name, path, sizes, elements)
        self.folder = unpack(self.path)
        self.log = deque(maxlen=MOST_MESSAGES)
        self._warnings = LoggedWarnings()
        self._warned_at = None
        self._begun = False
        self.at = None
        self._stop = inf
        self.ended = ""

    def _reserved_field(self, name, first):
        """Return a field at the reserved references from `first` on."""
        field = self.fields[name]
        return replace(field, references=tuple(range(first, first + field.size)))

    def enter(self, parameters, start_time, stop_time):
        """Run the first half of `start`, up to Initialization Mode.

        In that mode, outputs follow the inputs that are set.
        """
        self.check_library()
        guard_exit(self)
        self.started_with = parameters, start_time, stop_time
        self._stop = stop_time
        self.log.clear()
        self._forget_inputs()
        self._begun = self._broken = False
        self._fatal.discard(self.folder)
        self._warnings, self._warned_at = LoggedWarnings(), None
        with self._raise_logged():
            self._instantiate(start_time, stop_time)
            self._configure()
            for name, value in parameters.items():
                if name not in self.sizes:
                    self.set(name, value)
            self._enter(start_time, stop_time)

    def leave(self):
        """Run the second half of `start`: leave Initialization Mode."""
        with self._raise_logged():
            self._fmu.exitInitializationMode()
        self._begun = True

    def another(self):
        """Return a second instance that is not started; None if the FMU allows only one."""
        if self.description.coSimulation.canBeInstantiatedOnlyOncePerProcess:
            return None
        one = type(self)(f"{self.name}_trial", self.path, self.sizes, self.elements)
        one.event_mode = self.event_mode
        return one

    def warned(self):
        """Return the first warning of each kind since the start: `LoggedWarning`s."""
        return self._warnings.all()

    @contextmanager
    def _raise_logged(self):
        """Raise the errors that the FMU logs at its start."""
        try:
            yield
        except Exception as error:
            if getattr(error, "status", None) == fmi2.fmi2Fatal:
                self._fatal.add(self.folder)
            texts = [text for status, text in self.log if status == fmi2.fmi2Discard]
            got = "; ".join([str(getattr(error, "call", error)).rstrip("."), *texts])
            raise self._logged_error() or BadInput(
                f"participants.{self.name}: expected a start, got {got}{self._hint}"
            ) from error
        if refusal := self._logged_error():
            raise refusal

    _hint = ""  # what to try if it does not start

    def _slave(self, kind):
        """Return FMPy's slave of this FMU."""
        slave = kind(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            instanceName=self.name,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )
        slave._call = partial(self._checked, slave._call)
        return slave

    def _instantiate(self, start_time, stop_time):
        self._fmu = self._slave(fmi2.FMU2Slave)
        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._logger = Logger(self._note)
        self._callbacks.logger = ctypes.cast(self._logger, fmi2.fmi2CallbackLoggerTYPE)
        self._callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        self._callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self._fmu.instantiate(callbacks=self._callbacks, loggingOn=True)
        self._bind()
        self._fmu.setupExperiment(startTime=start_time, stopTime=stop_time)

    def _bind(self):
        super()._bind()
        self._times = ctypes.c_double(), ctypes.c_double()
        names = ("DoStep", *(verb + self._state for verb in ("Get", "Set", "Free")))
        self._do, self._get_state, self._put_state, self._free_state = (
            self._call_of(f"fmi{self.version}{name}") for name in names
        )
        self._derivative = {
            kind: self._block({name: self._reserved_field(name, k) for name, k in first.items()})
            for kind, first in self._reserved.items()
        }

    def _configure(self):
        """Set the `sizes` of the FMU; FMI 2.0 has none."""

    def _enter(self, start_time, stop_time):
        self._fmu.enterInitializationMode()

    def _logged_error(self):
        """Return the exception for the errors in the log: a fault, bad input, or None."""
        if any(text.startswith("Traceback") for _, text in self.log):
            return ParticipantFault(f"{self.name}: {self.log[-1][1]}")
        lines = [
            f"participants.{self.name}, {line}"
            for status, text in self.log
            if status in FAILED
            for line in text.splitlines()
        ]
        return BadInput(lines) if lines else None

    def _note(self, _environment, _instance, status, _category, message, *arguments):
        self._keep(status, printed(message, arguments))

    def _keep(self, status, text):
        """Keep a message of the FMU for errors of this call, and count it if it is a warning."""
        text = REFERENCE.sub(self._with_names, text)
        self.log.append((status, text))
        if status == WARNING:
            self._warnings.add(text, self._warned_at)

    def _with_names(self, reference):
        """Return a match of `REFERENCE` with the names of its variables."""
        fields = self.fields.values()
        names = [field.name for field in fields if int(reference[1]) in field.references]
        return f"{reference[0]} ({' or '.join(names)})" if names else reference[0]

    def _note_status(self, function):
        """Count the warning that a call returns, if the FMU has logged none."""
        if not any(status == WARNING for status, _ in self.log):
            self._warnings.add(f"{function} returned a warning without a text", self._warned_at)

    def step(self, time, step):
        """Take a step [s].

        Raises `Discard` with the FMU's message if it discards the step, and `ParticipantFault`
        with its traceback if it fails. Raises `Finished` if it ends the simulation inside the
        step.
        """
        # without the two methods below, whose calls a small FMU would notice
        if time + step > self._stop:
            step = step_within(time, step, self._stop)
        self.log.clear()
        self.ended = ""
        self.at = None
        self._last_step = (time, step)
        self._warned_at = time
        try:
            self._do_step(time, step)
        except CallFailed as failure:
            text = self._message(failure)
            if failure.status == fmi2.fmi2Pending:
                with suppress(CallFailed, AttributeError):
                    self._call("fmi2CancelStep")
                self._broken = True
                text = "expected a complete step, got fmi2Pending; asynchronous FMUs do not work"
            elif any(status in FAILED for status, _ in self.log):
                self._broken = True
            if self._broken:
                raise ParticipantFault(f"{self.name}: {text}") from None
            if self._wants_to_end():
                self._end(self._reached(time), time + step, step)
                return
            raise Discard(f"{self.name}: {text}") from None

    def is_last(self, time, step):
        """Return whether a step [s] ends beyond the stop time, if only by round-off."""
        return time + step > self._stop

    def begin_step_at(self, time, step):
        """Prepare for a step [s] that is taken by pointers."""
        self.log.clear()
        self.ended = ""
        self.at = None
        self._last_step = (time, step)
        self._warned_at = time

    def _end(self, reached, end, step):
        """End the simulation for the FMU; raise `Finished` if this step is incomplete."""
        self.ended = f"{self.name}: ends the simulation at t = {reached:.6g} s"
        if end - reached > TIME_TOLERANCE * step:
            raise Finished(self.ended)

    def _reached(self, time):
        """Return the last successful time of a discarded step [s]; else its beginning."""
        answer = ctypes.c_double(time)
        kind = ctypes.c_int(fmi2.fmi2LastSuccessfulTime)
        with suppress(CallFailed):
            self._call("fmi2GetRealStatus", kind, ctypes.byref(answer))
        return answer.value

    def _wants_to_end(self):
        """Return whether the FMU discarded the step to end the simulation."""
        answer = ctypes.c_int(0)
        with suppress(CallFailed):
            kind = ctypes.c_int(fmi2.fmi2Terminated)
            self._call("fmi2GetBooleanStatus", kind, ctypes.byref(answer))
        return bool(answer.value)

    def _do_step(self, time, step):
        """Call the FMU's step.

        noSetFMUStatePriorToCurrentPoint is true, because the master never restores a state
        before `time`. If it is false, FMUs may repeat their last step.
        """
        begin, length = self._times
        begin.value, length.value = time, step
        if status := self._do(begin, length, TRUE):
            self._check("fmi2DoStep", status)

    def _message(self, failure):
        """Return the FMU's log of the failed call, or the call's name and status."""
        return "\n".join(text for _, text in self.log) or failure.call

    def save(self):
        """Return a handle of the FMU's state; `free` it after use."""
        state = ctypes.c_void_p()
        if status := self._get_state(ctypes.byref(state)):
            self._check(f"fmi{self.version}Get{self._state}", status)
        self.at = state
        return state

    def restore(self, saved):
        """Restore a saved state, where the next step begins."""
        self._begin = self.at = saved
        if status := self._put_state(saved):
            self._check(f"fmi{self.version}Set{self._state}", status)

    def free(self, saved):
        if not (self._fatal and self.folder in self._fatal):
            if status := self._free_state(ctypes.byref(saved)):
                self._check(f"fmi{self.version}Free{self._state}", status)

    def serialise(self, saved):
        """Return the saved state as bytes."""
        return bytes(self._fmu.serializeFMUstate(saved))

    def deserialise(self, data):
        """Return a handle of the state in bytes of `serialise`."""
        return self._fmu.deSerializeFMUstate(data)

    def derivative(self, seeds, products):
        """Return the directional derivative of the last step.

        It is the FMU's own, or a difference of two steps if the FMU has none.

        Parameters
        ----------
        seeds : dict of str to ndarray
            Change of input fields. Omitted inputs do not change.
        products : iterable of str
            Output fields.

        Returns
        -------
        dict of str to ndarray
            Change of the output fields.
        """
        if not self._standard_derivative:
            return (
                self._reserved_derivative(seeds)
                if self._derivative
                else super().derivative(seeds, products)
            )
        changes = np.concatenate([np.ravel(value) for value in seeds.values()])
        self.derive(tuple(seeds), changes, tuple(products))
        return self._cut(self.block(tuple(products)))

    def derive(self, inputs, changes, outputs):
        """Return `derivative` of concatenated fields; the next call overwrites the array."""
        if not self._standard_derivative:
            return derive_each(self, inputs, changes, outputs)
        known, unknown = self.block(inputs, "seeds"), self.block(outputs)
        known.values[:] = changes
        self.log.clear()
        self._derive(known, unknown)
        return unknown.values

    def _derive(self, known, unknown):
        """Compute the standard directional derivative in `unknown` for the seeds in `known`."""
        wanted, count, *values = unknown.arguments
        function = f"fmi{self.version}GetDirectionalDerivative"
        self._call(function, wanted, count, *known.arguments, *values)

    def _reserved_derivative(self, seeds):
        """Return the derivative through reserved references instead of the standard call."""
        write, read = self._derivative["seed"], self._derivative["product"]
        write.values[:] = 0.0
        for name, value in seeds.items():
            write.values[write.parts[name]] = np.ravel(value)
        write.put()
        read.get()
        return self._cut(read)

    def close(self):
        """Terminate and free the instance, as far as the standard allows.

        An instance that was not created needs neither. One that has not started or has failed
        must not be terminated. After fmi2Fatal nothing is called. Raises `ParticipantFault` with
        the FMU's message if termination fails.
        """
        fmu, self._fmu = self._fmu, None
        if fmu is None:
            return
        self.log.clear()
        is_dead = self.folder in self._fatal
        try:
            if self._begun and not self._broken and not is_dead:
                fmu.terminate()
        except CallFailed as failure:
            words = self._message(failure)
            raise ParticipantFault(f"{self.name}: at its end: {words}") from None
        finally:
            if fmu.component and not is_dead:
                fmu.freeInstance()
            else:
                fmu.freeLibrary()
