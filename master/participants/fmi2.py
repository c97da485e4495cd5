"""FMI 2.0 FMU under the master: fields by pointer, steps, saved states, derivatives, log."""

import ctypes
import shutil
import tempfile
import warnings
import zipfile
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from hashlib import sha256
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

from ..fmi.archive import check_archive, restore_files
from ..fmi.cache import cache_folder
from ..fmi.errors import BadInput, Discard, Finished, ParticipantFault, file_fault
from ..fmi.fields import VENDOR, gather_fields
from ..fmi.notebook import html_table
from .derivatives import difference
from .description_cache import cache_description, cached_description
from .exits import guard_exit
from .participant import read_each, write_each
from .printf import Logger, printed

REAL = ctypes.POINTER(ctypes.c_double)
WHOLE = 1e-9
"""Share of a step that counts as zero."""
TRUE = ctypes.c_int(fmi2.fmi2True)
WARNING = fmi2.fmi2Warning
FAILED = (fmi2.fmi2Error, fmi2.fmi2Fatal)


class FmuParticipant:
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

    version, derivative_flag = "2", "providesDirectionalDerivative"
    has_clocks = False
    event_mode = True
    _is_cached = True  # whether the description is cached
    _whole_numbers = {
        "Integer": "fmi2GetInteger",
        "Enumeration": "fmi2GetInteger",
        "Boolean": "fmi2GetBoolean",
    }
    """Functions that read 32-bit integers, by type."""

    def __init__(self, name, path, sizes=None, elements=()):
        self.name, self.path, self.sizes = name, Path(path), sizes or {}
        self.elements = frozenset(elements)
        self._is_cached = self._is_cached and not self.elements
        if self._is_cached and (kept := cached_description(self.path)):
            self.description, self.fields = kept
        else:
            self._read_description()
        self.folder = unpack(self.path)
        self.log = []
        root = self._before_the_variables()
        self._vectors: dict[str, TransferBlock] = {}
        self._pairs: dict[tuple[str, tuple[str, ...]], TransferBlock] = {}
        self._input_values: dict[str, np.ndarray] = {}
        self._written: TransferBlock | None = None
        self._courses: dict[tuple[str, int], tuple] = {}
        self._chosen: dict[tuple[str, ...], list[tuple]] = {}
        self._functions: Any = None  # `Functions` of an instance
        self._derivative = self._reserved_references(root)
        offered = root.find("CoSimulation")
        flag = None if offered is None else offered.get(self.derivative_flag)
        self._standard_derivative = flag in ("true", "1")
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

    def _read_description(self):
        """Read description and fields; raise `BadInput` if the file is no co-simulation FMU."""
        one = f"participants.{self.name}: {self.path}"
        try:
            with zipfile.ZipFile(self.path) as archive:
                check_archive(archive, self.path)
            self.description: Any = fmpy.read_model_description(str(self.path), validate=False)
        except BadInput:
            raise
        except OSError as error:
            raise BadInput(f"participants.{self.name}: {file_fault(self.path, error)}") from None
        except zipfile.BadZipFile:
            raise BadInput(f"{one}: expected an FMU, got another file") from None
        except Exception:  # FMPy raises errors of many kinds
            raise BadInput(
                f"{one}: expected an FMU, got an invalid modelDescription.xml; "
                "`fmpy validate` lists its faults"
            ) from None
        if self.description.coSimulation is None or not self.description.fmiVersion.startswith(
            self.version
        ):
            raise BadInput(
                f"{one}: expected an FMU for co-simulation of FMI {self.version}.0, got another"
            )
        try:
            self.fields = gather_fields(self.description, self.sizes, self.elements)
        except ValueError as error:
            raise BadInput(f"{one}: {error}") from None
        if self._is_cached:
            cache_description(self.path, self.description, self.fields)

    @property
    def has_derivatives(self):
        """True if the FMU has the standard derivative, or reserved references for one."""
        return self._standard_derivative or bool(self._derivative)

    @property
    def has_standard_derivative(self):
        """True if the FMU has the directional derivative of the standard."""
        return self._standard_derivative

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

    def start(self, parameters, start_time, stop_time):
        """Instantiate and initialise with `parameters` by name, in the FMU's units.

        The others have their start values. Raises `BadInput` with the FMU's log if it fails.
        """
        self.enter(parameters, start_time, stop_time)
        self.leave()

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
            self._vectors[name] = _block({name: self.fields[name]})
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
        if (getters := self._chosen.get(names)) is None:
            getters = self._chosen[names] = self._getters(names)
        values = {}
        for chosen, getter in getters:
            values |= zip(chosen, getter())
        return values

    def _getters(self, names):
        """Return names of scalars by type, each with a function that returns their values."""
        kinds: dict[str, list[str]] = {}
        for name in names:
            kind = self._kind(name)
            kinds.setdefault(self._whole_numbers.get(kind, kind), []).append(name)
        return [
            (chosen, self._getter(kind, chosen, [self.fields[n].references[0] for n in chosen]))
            for kind, chosen in ((kind, tuple(found)) for kind, found in kinds.items())
        ]

    def _getter(self, kind, names, references):
        """Return a function that returns the values of several scalars.

        kind : type, or the FMU's function that reads integers.
        """
        if kind in ("Real", "Float64"):
            return lambda: self.read(names).tolist()
        if kind not in self._whole_numbers.values():
            return partial(self._access()[kind][0], references)
        count = len(references)
        values = (ctypes.c_int * count)()
        arguments = (ctypes.c_uint * count)(*references), ctypes.c_size_t(count), values

        def listed():
            self._call(kind, *arguments)
            return list(values)

        return listed

    def _kind(self, name):
        """Return the type of a field in the FMU's version of the standard."""
        return self.fields[name].native or self.fields[name].type

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
        if not self._standard_derivative:
            return (
                self._reserved_derivative(seeds)
                if self._derivative
                else self._difference(seeds, products)
            )
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
            self._pairs[use, names] = _block({name: self.fields[name] for name in names})
        return self._pairs[use, names]

    def _cut(self, block):
        return {
            name: block.values[part].reshape(self.fields[name].shape).copy()
            for name, part in block.parts.items()
        }

    def _reserved_derivative(self, seeds):
        """Return the derivative through reserved references instead of the standard call."""
        write, read = self._derivative["seed"], self._derivative["product"]
        write.values[:] = 0.0
        for name, value in seeds.items():
            write.values[write.parts[name]] = np.ravel(value)
        self._write(write)
        self._read(read)
        return self._cut(read)

    def _difference(self, seeds, products):
        """Return the derivative by repeating the last step."""
        begin = self._begin
        try:
            return difference(self, begin, self._last_step, seeds, products)
        finally:
            self._begin = begin

    def _model_description(self):
        """Return the root of the XML, for content that FMPy does not read."""
        with zipfile.ZipFile(self.path) as archive:
            return ElementTree.fromstring(archive.read("modelDescription.xml"))

    def _before_the_variables(self):
        """Return the root of the XML, read up to the variables, which are most of it."""
        with (
            zipfile.ZipFile(self.path) as archive,
            archive.open("modelDescription.xml") as file,
        ):
            events = ElementTree.iterparse(file, ("start",))
            _, root = next(events)
            for _, node in events:
                if node.tag == "ModelVariables":
                    break
        return root

    def _reserved_references(self, root):
        """Return the blocks of all seeds and all products, from the FMU's vendor annotation."""
        blocks: dict[str, TransferBlock] = {}
        for kind in ("seed", "product"):
            nodes = root.findall(
                f"VendorAnnotations/Tool[@name='{VENDOR}']/Needs/DirectionalDerivative/{kind.capitalize()}"
            )
            first = {node.get("name"): int(node.get("valueReference")) for node in nodes}
            if first:
                blocks[kind] = _block(
                    {
                        name: replace(
                            self.fields[name],
                            references=tuple(range(k, k + self.fields[name].size)),
                        )
                        for name, k in first.items()
                    }
                )
        return blocks

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


@dataclass(frozen=True)
class TransferBlock:
    """Fields that one call transfers.

    references : C array of value references; count : their number; pointer : to `values`; parts
    : slice of each field.
    """

    references: ctypes.Array
    count: int
    values: np.ndarray
    pointer: Any
    parts: dict[str, slice]

    @cached_property
    def arguments(self):
        """References, their number and the pointer to the values."""
        return self.references, ctypes.c_size_t(self.count), self.pointer


class Functions(dict):
    """Functions of an FMU's library by name, without declared types, and its instance."""

    def __init__(self, fmu):
        super().__init__()
        self.library = fmu.dll
        self.component = ctypes.c_void_p(fmu.component)

    def __missing__(self, name):
        self[name] = function = self.library[name]
        return function


def _block(fields):
    """Return the block of several fields (name -> Field)."""
    references = [reference for field in fields.values() for reference in field.references]
    ends = np.cumsum([field.size for field in fields.values()])
    values = np.zeros(int(ends[-1]) if fields else 0)
    parts = {
        name: slice(int(end) - field.size, int(end))
        for (name, field), end in zip(fields.items(), ends)
    }
    return TransferBlock(
        (ctypes.c_uint * len(references))(*references),
        len(references),
        values,
        values.ctypes.data_as(REAL),
        parts,
    )


def unpack(path):
    """Unpack an FMU into a folder of the user's cache, named by its hash; return the folder."""
    digest = sha256(Path(path).read_bytes()).hexdigest()[:16]
    folder = cache_folder("unpacked") / f"{Path(path).stem}-{digest}"
    if folder.exists():
        if restored := restore_files(path, folder):
            warnings.warn(f"{folder}: was damaged; restored {', '.join(restored)}", stacklevel=2)
    else:
        partial = Path(tempfile.mkdtemp(dir=folder.parent))
        with zipfile.ZipFile(path) as archive:
            check_archive(archive, Path(path))
            archive.extractall(partial)
        try:
            partial.rename(folder)
        except OSError:  # another process was faster
            shutil.rmtree(partial)
    return folder
