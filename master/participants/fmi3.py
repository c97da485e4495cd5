"""One FMI 3.0 FMU under the master: as `FmuParticipant`, by the calls of FMI 3 and with arrays
whole.
"""

from fmpy import fmi3

from .fmi2 import FmuParticipant


class Fmu3Participant(FmuParticipant):
    """An FMI 3.0 co-simulation FMU; see `FmuParticipant`."""

    version, derivative_flag = "3", "providesDirectionalDerivatives"

    @property
    def can_interpolate(self) -> bool:
        """Never: FMI 3.0 has no call that tells an FMU the derivatives of its inputs."""
        return False

    def _instantiate(self, start_time, stop_time):
        self._fmu = self._slave(fmi3.FMU3Slave)
        self._fmu.instantiate(loggingOn=True, logMessage=fmi3.fmi3LogMessageCallback(self._note_3))

    def _note_3(self, _environment, status, _category, message):
        self.log.append((status, (message or b"").decode(errors="replace")))

    def _enter(self, start_time, stop_time):
        self._fmu.enterInitializationMode(startTime=start_time, stopTime=stop_time)

    def _write(self, block):
        self._fmu.fmi3SetFloat64(
            self._fmu.component, block.references, block.count, block.pointer, block.values.size
        )

    def _read(self, block):
        self._fmu.fmi3GetFloat64(
            self._fmu.component, block.references, block.count, block.pointer, block.values.size
        )

    def _access(self) -> dict[str, tuple]:
        one = self._fmu
        return {
            "Real": (one.getFloat64, one.setFloat64),
            "Integer": (one.getInt32, one.setInt32),
            "Enumeration": (one.getInt64, one.setInt64),
            "Boolean": (one.getBoolean, one.setBoolean),
            "String": (one.getString, one.setString),
            "Binary": (one.getBinary, one.setBinary),
        }

    def _listed(self, field):
        """Values of all elements of a field that is not real."""
        return self._access()[field.type][0](list(field.references), field.size)

    def _derive(self, known, unknown):
        self._fmu.fmi3GetDirectionalDerivative(
            self._fmu.component,
            unknown.references,
            unknown.count,
            known.references,
            known.count,
            known.pointer,
            known.values.size,
            unknown.pointer,
            unknown.values.size,
        )

    def save(self):
        """A handle on the FMU's state; `free` it when it is no longer needed."""
        return self._fmu.getFMUState()

    def _set_state(self, saved):
        self._fmu.setFMUState(saved)

    def free(self, saved):
        self._fmu.freeFMUState(saved)

    def serialise(self, saved):
        """The saved state as bytes."""
        return bytes(self._fmu.serializeFMUState(saved))

    def deserialise(self, data):
        """A handle on the state that `serialise` made into bytes."""
        return self._fmu.deserializeFMUState(data)
