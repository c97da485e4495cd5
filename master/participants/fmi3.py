"""FMI 3.0 FMU under the master: as `FmuParticipant`, with whole arrays."""

import ctypes
from functools import cached_property
from math import inf

from fmpy import fmi3

from ..fmi.errors import Discard
from .fmi2 import TIME_TOLERANCE, FmuParticipant, step_within
from .plain import pack, unpack

LARGEST_ITERATION = 1000
"""Maximum number of calls of fmi3UpdateDiscreteStates in an event."""


class Fmu3Participant(FmuParticipant):
    """FMI 3.0 co-simulation FMU; see `FmuParticipant`."""

    version, derivative_flag = "3", "providesDirectionalDerivatives"
    _whole_numbers = {}
    _real_functions = "fmi3GetFloat64", "fmi3SetFloat64"
    _state = "FMUState"
    _is_cached = False  # the size of arrays depends on `sizes`
    _next_event = inf  # time that the FMU has announced [s]; -inf: it ends the simulation

    @property
    def can_interpolate(self) -> bool:
        """False, because FMI 3.0 has no call that sets derivatives of inputs."""
        return False

    def _instantiate(self, start_time, stop_time):
        self._fmu = self._slave(fmi3.FMU3Slave)
        self._fmu.instantiate(
            loggingOn=True,
            logMessage=fmi3.fmi3LogMessageCallback(self._note_3),
            eventModeUsed=self._has_events,
            earlyReturnAllowed=self._has_events,
        )
        self._bind()

    def _note_3(self, _environment, status, _category, message):
        self._keep(status, (message or b"").decode(errors="replace"))

    def _enter(self, start_time, stop_time):
        self._fmu.enterInitializationMode(startTime=start_time, stopTime=stop_time)

    def _access(self) -> dict[str, tuple]:
        one = self._fmu
        integers = [f"{sign}{bits}" for sign in ("Int", "UInt") for bits in (8, 16, 32, 64)]
        kinds = ["Float64", "Float32", *integers, "Boolean", "Binary"]
        access = {kind: (getattr(one, f"get{kind}"), getattr(one, f"set{kind}")) for kind in kinds}
        return access | {"Enumeration": access["Int64"], "String": self._texts}

    def _are_double(self, names):
        events = self._discrete if self._has_events else ()
        return super()._are_double(names) and not any(name in events for name in names)

    def _configure(self):
        """Set the `sizes` of the FMU in Configuration Mode."""
        if not self.sizes:
            return
        self._fmu.enterConfigurationMode()
        for name, value in self.sizes.items():
            self.set(name, value)
        self._fmu.exitConfigurationMode()

    def leave(self):
        """Leave Initialization Mode, and the Event Mode that follows it in FMUs that have one."""
        super().leave()
        if self._has_events:
            with self._raise_logged():
                self._settle_events()
                self._fmu.enterStepMode()

    @cached_property
    def _has_events(self):
        """True if the FMU is used with Event Mode."""
        return self.event_mode and bool(self.description.coSimulation.hasEventMode)

    @property
    def _hint(self):
        tried = "; if it rejects the Event Mode that it declares, set event_mode = false"
        return tried if self._has_events else ""

    @cached_property
    def _discrete(self):
        """Discrete inputs and tunable parameters, which may change in Event Mode only."""
        return {
            v.name
            for v in self.description.modelVariables
            if (v.causality == "input" and v.variability == "discrete")
            or self.fields[v.name].tunable
        }

    def set(self, name, value):
        """Set a field; in an FMU with Event Mode, discrete inputs and parameters are set there."""
        event = self._begun and self._has_events and name in self._discrete
        if event:
            self._fmu.enterEventMode()
        super().set(name, value)
        if event:
            self._settle_events()
            self._fmu.enterStepMode()

    def _settle_events(self):
        """Update discrete states in Event Mode until none changes; return whether the FMU ends."""
        for _ in range(LARGEST_ITERATION):
            again, end = self._update_discrete_states()
            if end or not again:
                return end
        raise Discard(f"{self.name}: an event without end")

    def _update_discrete_states(self):
        """Update once; return whether states change again, and whether the FMU ends."""
        again, end, _, _, is_announced, time = self._fmu.updateDiscreteStates()
        self._next_event = time if is_announced and self.can_vary_steps else inf
        if end:
            self._next_event = -inf
        return again, end

    def _do_step(self, time, step):
        """Complete a step: resume after early returns, and handle events in Event Mode.

        A step of the FMU ends at the event that it has announced.
        """
        end, at = time + step, time
        if self._next_event == -inf:  # at the start, or at an event after the last step
            self._end(time, end, step)
        flags = [ctypes.c_bool() for _ in range(3)]
        reached = ctypes.c_double()
        references = [ctypes.byref(answer) for answer in (*flags, reached)]
        while True:
            inside = at + TIME_TOLERANCE * step < self._next_event < end - TIME_TOLERANCE * step
            until = self._next_event if inside else end
            length = step_within(at, until - at, self._stop)
            times = ctypes.c_double(at), ctypes.c_double(length)
            if status := self._do(*times, ctypes.c_bool(True), *references):
                self._check("fmi3DoStep", status)
            event, finished, early = (flag.value for flag in flags)
            now = reached.value if early or finished else until
            is_due = self._next_event <= now + TIME_TOLERANCE * step
            if (event or is_due) and self._has_events and not finished:
                finished = self._handle_event(now, end, step)
            if finished:
                self._end(now, end, step)
                return
            if end - now <= TIME_TOLERANCE * step:
                return
            if not now > at:
                raise Discard(f"{self.name}: returns early at t = {at:.6g} s without progress")
            at = now

    def _wants_to_end(self):
        """Return False, because fmi3DoStep itself returns whether the simulation ends."""
        return False

    def _handle_event(self, reached, end, step):
        """Handle an event at time `reached` of a step to `end` [s]; return whether the FMU ends."""
        self._fmu.enterEventMode()
        finished = self._settle_events()
        self._fmu.enterStepMode()
        return finished

    def _listed(self, field):
        values = self._access()[field.native][0](list(field.references), field.size)
        return [b"" if value is None else value for value in values]

    def save(self):
        """Return a handle of the FMU's state, and its next event; `free` it after use."""
        return super().save(), self._next_event

    def restore(self, saved):
        """Restore a saved state, where the next step begins."""
        handle, self._next_event = saved
        super().restore(handle)
        self._begin = saved

    def free(self, saved):
        super().free(saved[0])

    def serialise(self, saved):
        """Return the saved state as bytes."""
        return pack((bytes(self._fmu.serializeFMUState(saved[0])), saved[1]))

    def deserialise(self, data):
        """Return a handle of the state in bytes of `serialise`."""
        state, next_event = unpack(data)
        return self._fmu.deserializeFMUState(state), next_event
