"""Values of an FMU's fields: typed, and several real ones by one call."""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

from ..fmi.errors import CallDiscarded, CallFailed, ParticipantFault
from .description import DescribedFmu
from .participant import FieldBlock

REAL = ctypes.POINTER(ctypes.c_double)
FAILED = (fmi2.fmi2Error, fmi2.fmi2Fatal)
SURVIVED = ("FMUstate", "FMUState", "Status", "DirectionalDerivative")
"""Ends of the names of calls that an FMU may fail without failing itself."""


class FmuFields(DescribedFmu):
    """Fields of an FMI 2.0 FMU, set and read.

    A subclass creates the instance, `_fmu` of FMPy, and calls `_bind`.
    """

    _real_functions = "fmi2GetReal", "fmi2SetReal"
    _whole_numbers = {
        "Integer": "fmi2GetInteger",
        "Enumeration": "fmi2GetInteger",
        "Boolean": "fmi2GetBoolean",
    }
    """Functions that read 32-bit integers, by type."""
    _fatal: ClassVar[set[Path]] = set()
    """Folders of FMUs that returned fmi2Fatal, after which none of their instances is called."""
    folder: Path
    log: Any
    _broken = False

    def __init__(self, name, path, sizes=None, elements=()):
        super().__init__(name, path, sizes, elements)
        self._vectors: dict[str, TransferBlock] = {}
        self._blocks: dict[tuple[tuple[str, ...], str], TransferBlock] = {}
        self._input_values: dict[str, np.ndarray] = {}
        self._written: TransferBlock | None = None
        self._courses: dict[tuple[str, int], tuple] = {}
        self._functions: Any = None
        self._fmu: Any = None

    def _bind(self):
        """Use the instance that was created instead of an earlier one."""
        self._functions = Functions(self._fmu)
        for block in (*self._vectors.values(), *self._blocks.values()):
            self._aim(block)

    def _call_of(self, function, *arguments):
        """Return a function that calls the FMU with these and further arguments, for its status.

        All arguments are ctypes objects, so nothing is converted. FMPy's layers take longer than a
        small FMU.
        """
        return partial(getattr(self._functions, function), self._functions.component, *arguments)

    def _call(self, function, *arguments):
        """Call the FMU once, see `_call_of`."""
        if status := self._call_of(function, *arguments)():
            self._check(function, status)

    def _block(self, fields, is_input=False):
        """Return the block of several fields (name -> Field)."""
        references = [reference for field in fields.values() for reference in field.references]
        ends = np.cumsum([field.size for field in fields.values()])
        values = np.zeros(int(ends[-1]) if fields else 0)
        sizes = (ctypes.c_size_t(values.size),) * (self.version == "3")
        arguments = (
            (ctypes.c_uint * len(references))(*references),
            ctypes.c_size_t(len(references)),
            values.ctypes.data_as(REAL),
            *sizes,
        )
        parts = {
            name: slice(int(end) - field.size, int(end))
            for (name, field), end in zip(fields.items(), ends)
        }
        block = TransferBlock(arguments, values, parts, is_input)
        self._aim(block)
        return block

    def _aim(self, block):
        """Let a block call the present instance."""
        getter, setter = self._real_functions
        getting, setting = (self._call_of(name, *block.arguments) for name in self._real_functions)

        def get():
            if status := getting():
                self._check(getter, status)

        def put():
            if status := setting():
                self._check(setter, status)
            if block is not self._written:
                self.note_written(block)

        block.get, block.put = get, put

    def note_written(self, block):
        """Save the values of a block that the FMU has received, if they are inputs."""
        if block.is_input and block is not self._written:
            parts = block.parts.items()
            self._input_values |= {name: block.values[part] for name, part in parts}
            self._written = block

    def addresses(self, functions):
        """Return the instance and functions of the FMU as numbers, None for a missing function."""
        pointers = [getattr(self._functions, name, None) for name in functions]
        return self._functions.component.value, [
            one and ctypes.cast(one, ctypes.c_void_p).value for one in pointers
        ]

    def _vector(self, name):
        """Return the block of a field, created once."""
        if name not in self._vectors:
            field = self.fields[name]
            self._vectors[name] = self._block({name: field}, field.causality == "input")
        return self._vectors[name]

    def set(self, name, value):
        """Set a field (array of its shape), or a scalar of any type."""
        field = self.fields[name]
        if field.is_double:
            block = self._vector(name)
            block.values[:] = np.ravel(value)
            block.put()
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
            block.get()
            values = block.values
        return values.reshape(field.shape).copy() if field.shape else float(values[0])

    def _forget_inputs(self):
        """Read inputs from the FMU until they are set again."""
        self._input_values.clear()
        self._written = None

    def _listed(self, field):
        """Return the values of all elements of a field that is not real."""
        values = self._access()[field.type][0](list(field.references))
        return [bool(value) for value in values] if field.type == "Boolean" else values

    def _are_double(self, names):
        """Return whether one call can transfer several fields: all must be 64-bit floats."""
        return all(self.fields[name].is_double for name in names)

    def _check(self, function, status):
        """Note a warning; raise `CallFailed` with the FMU's messages for a failure."""
        if status == fmi2.fmi2Warning:
            self._note_status(function)
            return
        if status == fmi2.fmi2Fatal:
            self._fatal.add(self.folder)
        self._broken |= status in FAILED and not function.endswith(SURVIVED)
        call = str(FMICallException(function, status))
        logged = [text for kind, text in self.log if kind not in (fmi2.fmi2OK, fmi2.fmi2Warning)]
        kind = CallDiscarded if status == fmi2.fmi2Discard else CallFailed
        raise kind("\n".join([f"{self.name}: {call}", *logged]), call, status)

    def _checked(self, call, function, *arguments):
        """Return the result of FMPy's `call` of a function; raise `CallFailed` as `_check`."""
        try:
            return call(function, *arguments)
        except FMICallException as failure:
            status = failure.status
        return self._check(function, status)

    def _note_status(self, function):
        """Note that a call returns a warning."""

    def _access(self) -> dict[str, tuple]:
        """Return FMPy's getters and setters of lists, by type."""
        one = self._fmu
        return {
            "Real": (one.getReal, one.setReal),
            "Integer": (one.getInteger, one.setInteger),
            "Enumeration": (one.getInteger, one.setInteger),
            "Boolean": (one.getBoolean, one.setBoolean),
            "String": self._texts,
        }

    @property
    def _texts(self):
        """Getter and setter of lists of texts; bytes that are not UTF-8 remain as surrogates."""

        def call(verb, references, values):
            sizes = (ctypes.c_size_t(len(values)),) * (self.version == "3")
            known = (ctypes.c_uint * len(references))(*references)
            count = ctypes.c_size_t(len(references))
            self._call(f"fmi{self.version}{verb}String", known, count, values, *sizes)

        def get(references, size=None):
            values = (ctypes.c_char_p * (len(references) if size is None else size))()
            call("Get", references, values)
            return [(value or b"").decode(errors="surrogateescape") for value in values]

        def put(references, texts):
            encoded = [text.encode(errors="surrogateescape") for text in texts]
            call("Set", references, (ctypes.c_char_p * len(encoded))(*encoded))

        return get, put

    def get_many(self, names):
        """Return the values of several scalars by name, with one call for each type."""
        return dict(zip(names, self.lister(tuple(names))()))

    def lister(self, names):
        """Return a function that lists the values of several scalars, see `get_many`."""
        getters = self._getters(names)
        if len(getters) < 2:
            return getters[0][1] if getters else list
        order = [name for chosen, _ in getters for name in chosen]
        sort = itemgetter(*map(order.index, names))
        return lambda: [*sort([value for _, getter in getters for value in getter()])]

    def _getters(self, names):
        """Return names of scalars by type, each with a function that returns their values."""
        kinds: dict[str, list[str]] = {}
        for name in names:
            kind = self._kind(name)
            kinds.setdefault(self._whole_numbers.get(kind, kind), []).append(name)
        return [
            (chosen, self._getter(kind, chosen, [self.fields[n].references[0] for n in chosen]))
            for kind, chosen in ((kind, tuple(names)) for kind, names in kinds.items())
        ]

    def _getter(self, kind, names, references):
        """Return a function that returns the values of several scalars.

        kind : type, or the FMU's function that reads integers.
        """
        if kind in ("Real", "Float64"):
            block = self.block(names)

            def numbers():
                block.get()
                return block.values.tolist()

            return numbers
        if kind not in self._whole_numbers.values():
            return partial(self._access()[kind][0], references)
        count = len(references)
        values = (ctypes.c_int * count)()
        references = (ctypes.c_uint * count)(*references)
        call = self._call_of(kind, references, ctypes.c_size_t(count), values)

        def listed():
            if status := call():
                self._check(kind, status)
            return list(map(bool, values) if kind == "fmi2GetBoolean" else values)

        return listed

    def _kind(self, name):
        """Return the type of a field in the FMU's version of the standard."""
        return self.fields[name].native or self.fields[name].type

    def block(self, names, use="read") -> Any:
        """Return several real fields, which one call transfers; created once for each use."""
        if (names, use) not in self._blocks:
            if not self._are_double(names):
                return FieldBlock(self, names, use)
            known = {name: self.fields[name] for name in names}
            self._blocks[names, use] = self._block(known, use == "written")
        return self._blocks[names, use]

    def _cut(self, block):
        return {
            name: block.values[part].reshape(self.fields[name].shape).copy()
            for name, part in block.parts.items()
        }


@dataclass
class TransferBlock:
    """Fields that one call transfers.

    arguments : references as a C array, their number, pointer to `values`, and in FMI 3.0 the
    number of values; parts : slice of each field; is_input : whether values that are set are saved;
    get, put : calls that read and write the values.
    """

    arguments: tuple
    values: np.ndarray
    parts: dict[str, slice]
    is_input: bool
    get: Callable[[], None] = field(init=False)
    put: Callable[[], None] = field(init=False)

    @property
    def references(self) -> tuple[int, int]:
        """Address of the references, and their number."""
        return ctypes.addressof(self.arguments[0]), len(self.arguments[0])


class Functions:
    """Functions of an FMU's library as attributes, without declared types, and its instance."""

    def __init__(self, fmu):
        self.library = fmu.dll
        self.component = ctypes.c_void_p(fmu.component)

    def __getattr__(self, name):
        function = self.library[name]
        setattr(self, name, function)
        return function
