"""FMI 2.0 FMU under the master: fields by pointer, steps, saved states, derivatives, log."""

import ctypes
import re
import zipfile
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

from ..fmi.archive import unpack
from ..fmi.errors import BadInput, Discard, Finished, ParticipantFault
from ..fmi.notebook import html_table
from .derivatives import difference
from .description import read_description
from .exits import guard_exit
from .participant import StartsInTwo, read_each, write_each
from .printf import Logger, printed
from .transfer import REAL, Functions, TransferBlock, transfer_block

WHOLE = 1e-9
"""Share of a step that counts as zero."""
HEAD = 2**16
"""Length of the part of a model description that contains its capabilities [bytes]."""
DERIVATIVE = re.compile(
    rb"""<CoSimulation[^>]*\sprovidesDirectionalDerivatives?\s*=\s*["'](true|1)["']"""
)
TRUE = ctypes.c_int(fmi2.fmi2True)
WARNING = fmi2.fmi2Warning
FAILED = (fmi2.fmi2Error, fmi2.fmi2Fatal)


class FmuParticipant(StartsInTwo):
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

    Raises
    ------
    BadInput
        If the file is not an FMU for co-simulation.
    """

    version = "2"
    has_clocks = False
    event_mode = True

    def __init__(self, name, path, sizes=None, elements=()):
        self.name, self.path, self.sizes = name, Path(path), sizes or {}
        self.elements = frozenset(elements)
        self.description: Any
        self.description, self.fields = read_description(
            name, self.path, self.version, self.sizes, self.elements
        )
        self.folder = unpack(self.path)
        self.log = []
        self._vectors: dict[str, TransferBlock] = {}
        self._pairs: dict[tuple[str, tuple[str, ...]], TransferBlock] = {}
        self._input_values: dict[str, np.ndarray] = {}
        self._written: TransferBlock | None = None
        self._courses: dict[tuple[str, int], tuple] = {}
        self._chosen: dict[tuple[str, ...], list[tuple]] = {}
        self._functions: Any = None  # `Functions` of an instance
        with zipfile.ZipFile(self.path) as archive, archive.open("modelDescription.xml") as file:
            self.has_derivatives = DERIVATIVE.search(file.read(HEAD)) is not None
        self._fmu: Any = None
        self._begun = False
        self._broken = False
        self.ended = ""

    def __repr__(self):
        return f"<FMU {self.path.name}, FMI {self.description.fmiVersion}>"

    def _repr_html_(self):
        kinds = [field.causality for field in self.fields.values()]
        rows = {
            "model": self.description.modelName,
            "made by": self.description.generationTool or "",
            **{f"{kind}s": kinds.count(kind) for kind in ("input", "output", "parameter")},
            "directional derivatives": "yes" if self.has_derivatives else "no",
        }
        return html_table(repr(self)[1:-1], rows)

    @property
    def can_redo(self):
        """True if the FMU can save and restore its state."""
        return bool(self.description.coSimulation.canGetAndSetFMUstate)

    @property
    def can_vary_steps(self):
        """True if the steps may differ in length."""
        return bool(self.description.coSimulation.canHandleVariableCommunicationStepSize)

    @property
    def can_serialise(self):
        """True if the FMU can serialise its saved states."""
        return bool(self.description.coSimulation.canSerializeFMUstate)

    @property
    def can_interpolate(self) -> bool:
        """True if the FMU can interpolate inputs from their derivatives."""
        return bool(self.description.coSimulation.canInterpolateInputs)

    @property
    def declares_units(self):
        """True if the FMU declares any unit; otherwise its variables are in SI."""
        return any(field.unit != "1" for field in self.fields.values())

    def enter(self, parameters, start_time, stop_time):
        """Run the first half of `start`, up to Initialization Mode.

        In that mode, outputs follow the inputs that are set.
        """
        guard_exit(self)
        self.started_with = parameters, start_time, stop_time
        self.log.clear()
        self._forget_inputs()
        self._begun = self._broken = False
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
        """Return the warnings that the FMU logged at its start, without duplicates.

        Call it before the first step.
        """
        return list(dict.fromkeys(text for status, text in self.log if status == WARNING))

    @contextmanager
    def _raise_logged(self):
        """Raise the errors that the FMU logs at its start."""
        try:
            yield
        except Exception as error:
            raise self._logged_error() or BadInput(
                f"participants.{self.name}: expected a start, got {error}{self._hint}"
            ) from error
        if refusal := self._logged_error():
            raise refusal

    _hint = ""  # what to try if it does not start

    def _slave(self, kind):
        """Return FMPy's slave of this FMU."""
        return kind(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            instanceName=self.name,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )

    def _instantiate(self, start_time, stop_time):
        self._fmu = self._slave(fmi2.FMU2Slave)
        self._chosen.clear()
        self._callbacks = fmi2.fmi2CallbackFunctions()
        self._logger = Logger(self._note)
        self._callbacks.logger = ctypes.cast(self._logger, fmi2.fmi2CallbackLoggerTYPE)
        self._callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        self._callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self._fmu.instantiate(callbacks=self._callbacks, loggingOn=True)
        self._functions = Functions(self._fmu)
        self._fmu.setupExperiment(startTime=start_time, stopTime=stop_time)

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
        self.log.append((status, printed(message, arguments)))

    def _vector(self, name):
        """Return the block of a field, created once."""
        if name not in self._vectors:
            self._vectors[name] = transfer_block({name: self.fields[name]})
        return self._vectors[name]

    def set(self, name, value):
        """Set a field (array of its shape), or a scalar of any type."""
        field = self.fields[name]
        if field.is_double:
            block = self._vector(name)
            block.values[:] = np.ravel(value)
            self._write(block)
            if field.causality == "input":
                self._remember(block)
        else:
            values = (
                np.broadcast_to(value, field.shape).ravel().tolist() if field.shape else [value]
            )
            self._check_fit(field, values)
            self._access()[field.native or field.type][1](list(field.references), values)
            if field.causality == "input" and field.type == "Real":
                self._input_values[name] = np.array(values, dtype=float)
                self._written = None

    def _check_fit(self, field, values):
        """Raise `ParticipantFault` if an integer does not fit its type; C would truncate it."""
        if field.whole_numbers:
            low, high = field.whole_numbers
            for value in values:
                if not low <= value <= high:
                    kind = field.native or field.type
                    raise ParticipantFault(
                        f"{self.name}: {field.name}: {value} does not fit its type, {kind}, "
                        f"{low} to {high}"
                    )

    def set_course(self, name, course):
        """Set an input and its time derivatives at the beginning of the next step.

        course : ndarray, shape (order + 1, *shape of the field), value first.
        """
        self.set(name, course[0])
        highest, field = len(course) - 1, self.fields[name]
        if (name, highest) not in self._courses:
            orders = np.repeat(np.arange(1, highest + 1), field.size)
            self._courses[name, highest] = (
                (ctypes.c_uint * orders.size)(*field.references * highest),
                (ctypes.c_int * orders.size)(*orders),
            )
        references, orders = self._courses[name, highest]
        values = np.ascontiguousarray(course[1:], dtype=float)
        self._fmu.fmi2SetRealInputDerivatives(
            self._fmu.component, references, values.size, orders, values.ctypes.data_as(REAL)
        )

    def get(self, name):
        """Return the value of a field: array of its shape, or a Python scalar.

        A real input has the value that was set, because FMUs may return any other.
        """
        field = self.fields[name]
        values = self._input_values.get(name)
        if values is None and not field.is_double:
            values = self._listed(field)
            return np.array(values).reshape(field.shape) if field.shape else values[0]
        if values is None:
            block = self._vector(name)
            self._read(block)
            values = block.values
        return values.reshape(field.shape).copy() if field.shape else float(values[0])

    def _remember(self, block):
        """Save the inputs of a block as the values that were set."""
        if block is not self._written:
            self._input_values |= {name: block.values[part] for name, part in block.parts.items()}
            self._written = block

    def _forget_inputs(self):
        """Read inputs from the FMU until they are set again."""
        self._input_values.clear()
        self._written = None

    def _listed(self, field):
        """Return the values of all elements of a field that is not real."""
        values = self._access()[field.type][0](list(field.references))
        return [value.decode() if isinstance(value, bytes) else value for value in values]

    def write(self, names, values):
        """Set several real fields from their concatenated values."""
        block = self._pairs.get(("written", names))
        if block is None:
            if not self._are_double(names):
                write_each(self, names, values)
                return
            block = self._pair(names, "written")
        block.values[:] = values
        self._write(block)
        self._remember(block)

    def read(self, names):
        """Return several real fields, concatenated; the next call overwrites the array."""
        block = self._pairs.get(("read", names))
        if block is None:
            if not self._are_double(names):
                return read_each(self, names)
            block = self._pair(names)
        self._read(block)
        return block.values

    def _are_double(self, names):
        """Return whether one call can transfer several fields."""
        return True

    def _write(self, block):
        self._call("fmi2SetReal", *block.arguments)

    def _read(self, block):
        self._call("fmi2GetReal", *block.arguments)

    def _call(self, function, *arguments):
        """Call the FMU without FMPy's layers, which take longer than a small FMU.

        All arguments are ctypes objects, so nothing is converted.
        """
        functions = self._functions
        status = functions[function](functions.component, *arguments)
        if status > fmi2.fmi2Warning:
            raise FMICallException(function, status)

    def _access(self) -> dict[str, tuple]:
        """Return FMPy's getters and setters of lists, by type."""
        one = self._fmu
        return {
            "Real": (one.getReal, one.setReal),
            "Integer": (one.getInteger, one.setInteger),
            "Enumeration": (one.getInteger, one.setInteger),
            "Boolean": (one.getBoolean, one.setBoolean),
            "String": (one.getString, one.setString),
        }

    def get_many(self, names):
        """Return the values of several scalars by name, with one call for each type."""
        names = tuple(names)
        if names not in self._chosen:
            kinds: dict[str, list[str]] = {}
            for name in names:
                field = self.fields[name]
                kinds.setdefault(field.native or field.type, []).append(name)
            self._chosen[names] = [self._getter(kind, *of_kind) for kind, of_kind in kinds.items()]
        values = {}
        for of_kind, get in self._chosen[names]:
            values |= zip(of_kind, get())
        return values

    def _getter(self, kind, *names):
        """Return names of scalars of one type, and a function that returns their values."""
        if kind in ("Real", "Float64"):
            return names, lambda: self.read(names).tolist()
        references = [self.fields[name].references[0] for name in names]
        return names, partial(self._access()[kind][0], references)

    def step(self, time, step):
        """Take a step [s].

        Raises `Discard` with the FMU's message if it discards the step, and `ParticipantFault`
        with its traceback if it fails. Raises `Finished` if it ends the simulation inside the
        step.
        """
        self.log.clear()
        self.ended = ""
        self._last_step = (time, step)
        try:
            self._do_step(time, step)
        except FMICallException as failure:
            text = self._message(failure)
            if failure.status in FAILED or any(status in FAILED for status, _ in self.log):
                self._broken = True
                raise ParticipantFault(f"{self.name}: {text}") from None
            if self._wants_to_end():
                self._end(self._reached(time), time + step, step)
                return
            raise Discard(f"{self.name}: {text}") from None

    def _end(self, reached, end, step):
        """End the simulation for the FMU; raise `Finished` if this step is incomplete."""
        self.ended = f"{self.name}: ends the simulation at t = {reached:.6g} s"
        if end - reached > WHOLE * step:
            raise Finished(self.ended)

    def _reached(self, time):
        """Return the last successful time of a discarded step [s]; else its beginning."""
        answer = ctypes.c_double(time)
        kind = ctypes.c_int(fmi2.fmi2LastSuccessfulTime)
        with suppress(FMICallException):
            self._call("fmi2GetRealStatus", kind, ctypes.byref(answer))
        return answer.value

    def _wants_to_end(self):
        """Return whether the FMU discarded the step to end the simulation."""
        answer = ctypes.c_int(0)
        with suppress(FMICallException):
            kind = ctypes.c_int(fmi2.fmi2Terminated)
            self._call("fmi2GetBooleanStatus", kind, ctypes.byref(answer))
        return bool(answer.value)

    def _do_step(self, time, step):
        """Call the FMU's step.

        noSetFMUStatePriorToCurrentPoint is true, because the master never restores a state
        before `time`. If it is false, FMUs may repeat their last step.
        """
        self._call("fmi2DoStep", ctypes.c_double(time), ctypes.c_double(step), TRUE)

    def _message(self, failure):
        """Return the FMU's log of the failed call, or the call's name and status."""
        return "\n".join(text for _, text in self.log) or str(failure)

    def save(self):
        """Return a handle of the FMU's state; `free` it after use."""
        state = ctypes.c_void_p()
        self._call("fmi2GetFMUstate", ctypes.byref(state))
        return state

    def restore(self, saved):
        """Restore a saved state, where the next step begins."""
        self._begin = saved
        self._set_state(saved)

    def _set_state(self, saved):
        self._call("fmi2SetFMUstate", saved)

    def free(self, saved):
        self._call("fmi2FreeFMUstate", ctypes.byref(saved))

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
        if not self.has_derivatives:
            begin = self._begin
            try:
                return difference(self, begin, self._last_step, seeds, products)
            finally:
                self._begin = begin
        known, unknown = self._pair(tuple(seeds), "seeds"), self._pair(tuple(products))
        for name, value in seeds.items():
            known.values[known.parts[name]] = np.ravel(value)
        self.log.clear()
        try:
            self._derive(known, unknown)
        except FMICallException as failure:
            raise ParticipantFault(f"{self.name}: {self._message(failure)}") from None
        return self._cut(unknown)

    def _derive(self, known, unknown):
        """Compute the standard directional derivative in `unknown` for the seeds in `known`."""
        self._fmu.fmi2GetDirectionalDerivative(
            self._fmu.component,
            unknown.references,
            unknown.count,
            known.references,
            known.count,
            known.pointer,
            unknown.pointer,
        )

    @property
    def component(self):
        """Address of the instance."""
        return self._fmu.component

    def addresses(self, functions):
        """Return the addresses of functions of the FMU's library."""
        found = [ctypes.cast(getattr(self._fmu.dll, name), ctypes.c_void_p) for name in functions]
        return [one.value for one in found]

    def references(self, names):
        """Return address and number of the concatenated references of several real fields."""
        block = self._pair(tuple(names))
        return ctypes.addressof(block.references), block.count

    def stepped(self, saved, time, step):
        """Update the state after compiled code has taken this step [s] from a saved state."""
        self._forget_inputs()
        self._begin = saved
        self.ended = ""
        self._last_step = (time, step)

    def fault(self, function, status):
        """Return the exception for an error of a function that compiled code called.

        Returns None if the status is no error. Then Python must repeat the call.
        """
        if status not in FAILED:
            return None
        failure = FMICallException(function, status)
        if function not in ("fmi2DoStep", "fmi2GetDirectionalDerivative"):
            return failure
        self._broken |= function == "fmi2DoStep"
        return ParticipantFault(f"{self.name}: {self._message(failure)}")

    def _pair(self, names, use="read"):
        """Return the block of several fields, created once for each use."""
        if (use, names) not in self._pairs:
            self._pairs[use, names] = transfer_block({name: self.fields[name] for name in names})
        return self._pairs[use, names]

    def _cut(self, block):
        return {
            name: block.values[part].reshape(self.fields[name].shape).copy()
            for name, part in block.parts.items()
        }

    def _model_description(self):
        """Return the root of the XML, for content that FMPy does not read."""
        with zipfile.ZipFile(self.path) as archive:
            return ElementTree.fromstring(archive.read("modelDescription.xml"))

    def close(self):
        """Terminate and free the instance, as far as the standard allows.

        An instance that was not created needs neither. One that has not started or has failed
        must not be terminated. Raises `ParticipantFault` with the FMU's message if termination
        fails.
        """
        fmu, self._fmu = self._fmu, None
        if fmu is None:
            return
        self.log.clear()
        try:
            if self._begun and not self._broken:
                fmu.terminate()
        except FMICallException as failure:
            words = self._message(failure)
            raise ParticipantFault(f"{self.name}: at its end: {words}") from None
        finally:
            if fmu.component:
                fmu.freeInstance()
            else:
                fmu.freeLibrary()
