"""Base class of every FMU: one variable table, one state object, fields moved as slices.

The C front, or pythonfmu if there is none, calls the methods of `FieldSlave`. A participant derives
from it and defines three: `start`, `advance` and `directional_derivative`. Storage:

- `real`: one array [variables of type Real | courses | seeds | products]. Each declared array is a
  view of it. Seeds and products are the reserved references of the directional derivative. A course
  is the content of fmi2SetRealInputDerivatives: the first three derivatives of an input at the
  beginning of the next step.
- `integer`, `string`: the same for the other types. A choice is stored by number. The front reads
  and writes `real` and `integer` in place, so they are allocated once and never move. Value
  references run through all three arrays without overlap. A reference of the wrong type is
  rejected.
- `state`: the participant's frozen dataclass or named tuple. The FMU state is (real variables,
  texts and choices, state). Integer outputs count work, which a rollback does not undo, so they are
  not part of it.

No method may raise into pythonfmu's C layer, because an exception that crosses it corrupts the
host later. A failed step is logged, does not change the state, and sets `status` to discard. A
bug sets it to error.
"""

import json
import sys
import traceback
from collections.abc import ItemsView, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast, get_type_hints

import numpy as np
from pythonfmu import Fmi2Slave  # pyright: ignore[reportMissingTypeStubs]
from pythonfmu.enums import Fmi2Status  # pyright: ignore[reportMissingTypeStubs]

from .errors import BadInput, Discard
from .state_bytes import is_sound, join, split
from .variables import KINDS, Variable

COURSE, SEED, PRODUCT = "course", "seed", "product"
"""Kinds of reserved storage: derivatives of an input over a step, seed and product of a
directional derivative."""

STARTS = "start.json"
"""Resource with start values that replace those of the table, by name."""

LARGEST = sys.float_info.max


def reserved(kind: str, name: str) -> str:
    """Return the key of the reserved storage of a variable."""
    return f"{kind}:{name}"


@dataclass(frozen=True)
class Experiment:
    """Default experiment of an importer.

    stop, step : stop time and communication step [s]; tolerance : of an iteration, error of the
    exchanged values over their nominals [-].
    """

    stop: float
    step: float
    tolerance: float | None = None


class FieldSlave(Fmi2Slave):
    """Base class of every model class; the module docstring describes its storage.

    A participant defines

    - `name`, `description`: model identifier and one sentence;
    - `state_type`: the frozen dataclass or named tuple (of arrays, floats and named tuples) that
      `start` and `advance` return;
    - `variables(options)`: its table, a list of `Variable`;
    - `start(values) -> (state, outputs)`: called at the end of initialisation; raises `BadInput`
      with every fault;
    - `advance(state, values, time, step) -> (state, outputs)`: one step [s]; raises `Discard` if it
      fails;
    - `slow_state`: optional members of the state, `field` or `field.name`, that a run may
      extrapolate from cycle to cycle, see `state_bytes`;
    - `interpolates_inputs`: True if `advance` reads its inputs from `course` instead of `values`.
      If not, the C front extrapolates them to the end of the step;
    - `derivative_inputs`, `derivative_outputs`, `directional_derivative(seeds) -> products`:
      optional.
    """

    log: Any
    log_queue: list[Any]
    name = "slave"
    description = ""
    state_type: Any = None
    slow_state: tuple[str, ...] = ()
    experiment = Experiment(stop=5e-3, step=5e-5)
    interpolates_inputs = False
    derivative_inputs: Sequence[str] = ()
    derivative_outputs: Sequence[str] = ()

    def __init__(self, **kwargs: Any):
        super().__init__(**kwargs)  # pyright: ignore[reportUnknownMemberType]
        self.modelName = self.name
        self.description = type(self).description
        self.resources: Path = Path(self.resources)
        self.options: dict[str, Any] = json.loads((self.resources / "build.json").read_text())
        self.table: list[Variable] = self._table()
        self.state: Any = None
        self.fault: str | None = None
        self.started_with: Any = None
        self.initialising = False
        self.shown: Any = None
        self.status = Fmi2Status.ok
        self.inputs = [v for v in self.table if v.causality == "input" and v.type != "String"]
        self.given_to_steps = [*self.inputs, *(v for v in self.table if v.tunable)]
        self._lay_out()

    def _table(self) -> list[Variable]:
        """Return the variables with the start values of the FMU's resources."""
        table = self.variables(self.options)
        if not self.interpolates_inputs:
            table = [v.at_the_end() for v in table]
        file = self.resources / STARTS
        starts: dict[str, Any] = json.loads(file.read_text()) if file.exists() else {}
        return [v.starting(starts[v.name]) if v.name in starts else v for v in table]

    # methods of the participant

    @staticmethod
    def variables(options: dict[str, Any]) -> list[Variable]:
        """Return the variable table for the build `options`."""
        raise NotImplementedError

    def start(self, values: dict[str, Any]) -> tuple[Any, Mapping[str, Any]]:
        """Return state and outputs at the start time, for the parameters and inputs in `values`."""
        raise NotImplementedError

    def advance(
        self, state: Any, values: dict[str, Any], time: float, step: float
    ) -> tuple[Any, Mapping[str, Any]]:
        """Return state and outputs at time + step [s]; inputs in `values` are those at its end."""
        raise NotImplementedError

    def advance_nearby(
        self, base: Any, state: Any, values: dict[str, Any], time: float, step: float
    ) -> tuple[Any, Mapping[str, Any]]:
        """Return what `advance` returns, for a step next to the last one of another instance.

        A participant that solves large equations may use the factorisation of `base`. The error
        must be of second order in the differences of the two steps.
        """
        return self.advance(state, values, time, step)

    @property
    def no_nearby_step(self) -> str:
        """Return why `advance_nearby` does not fit the model, or ""."""
        return ""

    def course(self, name: str) -> np.ndarray:
        """Return an input over the current step, as the importer described it.

        Eq. (Y1):  u(t + s) = u + u' s + u'' s^2/2 + u''' s^3/6,
                   constant (all derivatives 0) if the importer set none

        Returns
        -------
        ndarray, shape (4, *shape of the input)
            u, u', u'', u''' at the beginning of the step [unit, unit/s, ..].
        """
        # the coefficients of Eq. (Y1), without the factorials
        return np.concatenate([self.views[name][None], self.views[reserved(COURSE, name)]])

    def directional_derivative(self, seeds: dict[str, np.ndarray]) -> Mapping[str, Any]:
        """Return the change of `derivative_outputs` at the end of the last step.

        `seeds` is the change of its inputs.
        """
        raise NotImplementedError

    # storage

    def _lay_out(self) -> None:
        """Allocate storage, give every variable its view, and set the start values."""
        self.views: dict[str, np.ndarray] = {}
        self.references: dict[str, int] = {}
        real = [v for v in self.table if v.type == "Real"]
        shapes = {v.name: v.shape for v in real}
        self.real_count = sum(v.size for v in real)
        self.courses = [v.name for v in real if v.causality == "input" and self.interpolates_inputs]
        extra: list[tuple[str, tuple[int, ...]]]
        extra = [(reserved(COURSE, n), (3, *shapes[n])) for n in self.courses]
        extra += [(reserved(SEED, n), shapes[n]) for n in self.derivative_inputs]
        extra += [(reserved(PRODUCT, n), shapes[n]) for n in self.derivative_outputs]
        self.real = np.zeros(self.real_count + sum(int(np.prod(s)) for _, s in extra))
        integer = [v for v in self.table if v.type in ("Integer", "Enumeration")]
        self.enumerations = [v for v in self.table if v.type == "Enumeration"]
        self.integer = np.zeros(sum(v.size for v in integer), dtype=np.int64)
        self._lay_into(self.real, [(v.name, v.shape) for v in real] + extra)
        self._lay_into(self.integer, [(v.name, v.shape) for v in integer])
        self.string: list[Any] = [v.start for v in self.table if v.type == "String"]
        self.references |= {
            v.name: k for k, v in enumerate(v for v in self.table if v.type == "String")
        }
        self.first_integer = len(self.real)
        self.first_text = self.first_integer + len(self.integer)
        firsts = {"Real": 0, "String": self.first_text}
        self.first_references = {
            v.name: firsts.get(v.type, self.first_integer) + self.references[v.name]
            for v in self.table
        }
        for v in real + integer:
            self.views[v.name][...] = v.number(v.start)
        self.first_product = (
            self.references.get(reserved(PRODUCT, self.derivative_outputs[0]), len(self.real))
            if self.derivative_outputs
            else len(self.real)
        )
        self.parameter_elements = np.array(
            [
                k
                for v in real
                if v.kind == "parameter"
                for k in range(self.references[v.name], self.references[v.name] + v.size)
            ],
            dtype=int,
        )
        self.settable = {v.name for v in real + integer if v.causality != "output"}
        self.read_texts = [v.name for v in self.table if v.type == "String"]
        self.read_numbers = {
            v.name: self.views[v.name]
            for v in self.table
            if v.causality != "output" and v.type != "String"
        }
        self.seeds = {n: self.views[reserved(SEED, n)] for n in self.derivative_inputs}
        self.products = {n: self.views[reserved(PRODUCT, n)] for n in self.derivative_outputs}
        self.products_due = False
        self.all_references = list(range(len(self.real)))

    def _lay_into(
        self, storage: np.ndarray, entries: Iterable[tuple[str, tuple[int, ...]]]
    ) -> None:
        offset = 0
        for name, shape in entries:
            size = int(np.prod(shape))
            self.references[name] = offset
            self.views[name] = storage[offset : offset + size].reshape(shape)
            offset += size

    def _values(self) -> dict[str, Any]:
        """Return copies of all parameters and inputs: floats, ints, texts, arrays."""
        strings = dict(zip(self.read_texts, self.string))
        numbers = {
            name: view.copy() if view.ndim else view.item()
            for name, view in self.read_numbers.items()
        }
        chosen = {v.name: v.choices[numbers[v.name] - 1] for v in self.enumerations}
        return strings | numbers | chosen

    def _publish(self, outputs: Mapping[str, Any]) -> None:
        for name, value in outputs.items():
            self.views[name][...] = value

    # methods that only the C front calls

    def layout(self) -> bytes:
        """Return the memory layout for the front (front.h).

        It contains addresses, lengths, courses, seeds, products and all variables.
        """
        real = self.real.ctypes.data
        integer = self.integer.ctypes.data
        blocks = [
            [
                (self.references[n], self.views[n].size, self.references[reserved(kind, n)])
                for n in names
            ]
            for kind, names in (
                (COURSE, self.courses),
                (SEED, self.derivative_inputs),
                (PRODUCT, self.derivative_outputs),
            )
        ]
        kinds = ("Real", "Integer", "String", "Enumeration")
        entries = [
            (
                kinds.index(v.type),
                self.references[v.name],
                v.size,
                KINDS.index(v.kind),
            )
            for v in self.table
        ]
        head = [
            real,
            integer,
            self.real_count,
            len(self.integer),
            len(self.string),
            self.first_integer,
            self.first_text,
            *map(len, blocks),
            len(entries),
        ]
        parts = [head, *map(np.ravel, blocks), np.ravel(entries)]
        return np.concatenate(parts).astype(np.int64).tobytes()

    def verdict(self) -> tuple[int, list[tuple[int, str, str]]]:
        """Return status and messages (status, category, text) of the last call; clear both."""
        status = int(self.status)
        self.status = Fmi2Status.ok
        messages = [(int(m.status), m.category or "logAll", m.msg) for m in self.log_queue]
        self.log_queue.clear()
        return status, messages

    def update_products(self) -> None:
        """Compute the products for the stored seeds; set NaN and an error if that fails."""
        try:
            seeds = {name: view.copy() for name, view in self.seeds.items()}
            for name, value in self.directional_derivative(seeds).items():
                self.products[name][...] = value
        except Exception:
            self._fail(traceback.format_exc(), Fmi2Status.error)
            self.real[self.first_product :] = np.nan
        self.products_due = False

    # methods that both call

    def enter_initialization_mode(self) -> None:
        """Let outputs follow inputs until `exit_initialization_mode`; log a compilation."""
        kernels: Any = sys.modules.get(f"{__package__}.compiled")
        if kernels and (message := kernels.first_start()):
            self.log(message, Fmi2Status.warning)
        self.initialising = True
        self.shown = None

    def show_start(self) -> None:
        """Publish the outputs that follow from parameters and inputs in Initialization Mode.

        If these are rejected, the outputs do not change. The end of the initialisation reports why.
        """
        if not self.initialising or self.shown == self._start_values():
            return
        self.shown = self._start_values()
        if self._range_faults():
            return
        try:
            self._publish(self.start(self._values())[1])
        except Exception:
            return

    def exit_initialization_mode(self) -> None:
        """Check all parameter ranges and start the participant.

        A fault is logged, and every later step is discarded.
        """
        self.initialising = False
        self.state = self._checked_start()

    def _start_values(self) -> tuple[Any, ...]:
        """Return all values that a start depends on, comparable."""
        return (
            *(self.views[v.name].tobytes() for v in self.table if v.name in self.settable),
            tuple(self.string),
        )

    def _checked_start(self) -> Any:
        """Return the start state and publish its outputs; None if parameters are rejected."""
        self.started_with = self._parameters()
        try:
            if faults := self._range_faults():
                raise BadInput(faults)
            state, outputs = self.start(self._values())
            self._publish(outputs)
            return state
        except BadInput as error:
            self._refuse("\n".join(error.faults))
        except Exception:
            self._refuse(traceback.format_exc())
        return None

    def _parameters(self) -> tuple[Any, ...]:
        """Return the parameters that `start` depends on, comparable.

        A saved state with other parameters needs a new start.
        """
        return self.real[self.parameter_elements].tobytes(), self._settings()

    def _settings(self) -> tuple[Any, ...]:
        """Return all texts, then the numbers of all choices."""
        return (*self.string, *(self.views[v.name].item() for v in self.enumerations))

    def _refuse(self, text: str) -> None:
        self.fault = text
        self._fail(text, Fmi2Status.error)

    def _fail(self, text: str, status: Fmi2Status) -> None:
        self.status = status
        self.log(text, status)

    def _range_faults(self) -> list[str]:
        """Return a sentence for each parameter and input that is out of range or not finite.

        Only the first such element of an array is reported.
        """
        faults: list[str] = []
        for v in self.table:
            if v.causality == "output" or v.type == "String":
                continue
            faults += self._choice_faults(v) if v.choices else self._number_faults(v)
        return faults

    def _number_faults(self, v: Variable) -> list[str]:
        """Return a sentence if an element of a number is out of range or not finite."""
        low = -LARGEST if v.minimum is None else max(v.minimum, -LARGEST)
        high = LARGEST if v.maximum is None else min(v.maximum, LARGEST)
        view = self.views[v.name]
        smallest, largest = (view.min(), view.max()) if view.ndim else [view.item()] * 2
        if low <= smallest and largest <= high:  # both are NaN if an element is
            return []
        values = view.ravel()
        k = int(np.argmin((values >= low) & (values <= high)))
        if np.isfinite(values[k]):
            return [str(v.fault(values[k]))]
        unit = "" if v.unit == "1" else f" {v.unit}"
        return [f"{element_names(v)[k]}: expected a finite value, got {values[k]}{unit}"]

    def _choice_faults(self, v: Variable) -> list[str]:
        """Return a sentence if the number of a choice is invalid."""
        number = self.views[v.name].item()
        if 1 <= number <= len(v.choices):
            return []
        known = ", ".join(f"{k} {name}" for k, name in enumerate(v.choices, 1))
        return [f"{v.name}: expected {known}, got {number}"]

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Take a step; if it fails, log why, keep the state, return False (fmi2Discard)."""
        try:
            self._check_step(step_size)
            self.state, outputs = self.advance(self.state, self._values(), current_time, step_size)
            self._publish(outputs)
            return True
        except Discard as refusal:
            self._fail(str(refusal), Fmi2Status.discard)
        except Exception:
            self._fail(traceback.format_exc(), Fmi2Status.error)
        finally:
            for name in self.courses:  # they are valid for this step only
                self.views[reserved(COURSE, name)][...] = 0.0
        return False

    def _check_step(self, step_size: float) -> None:
        if self.fault:
            raise Discard(f"not initialised: {self.fault}")
        if not 0 < step_size < np.inf:
            raise Discard(f"step size = {step_size:g} s: must be positive and finite")
        for v in self.given_to_steps:
            if faults := self._choice_faults(v) if v.choices else self._number_faults(v):
                raise Discard(faults[0])

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        first = vrs[0]
        last = vrs[-1] + 1
        if vrs == self.all_references[first:last]:
            self.real[first:last] = values
        else:
            self.real[vrs] = values
        self.products_due = self.products_due or last > self.real_count

    def get_real(self, vrs: list[int]) -> list[float]:
        self.show_start()
        first = vrs[0]
        last = vrs[-1] + 1
        if last > self.first_product and self.products_due:
            self.update_products()
        if vrs == self.all_references[first:last]:
            return self.real[first:last].tolist()
        return self.real[vrs].tolist()

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self.integer[self._places(vrs, self.first_integer)] = values

    def get_integer(self, vrs: list[int]) -> list[int]:
        self.show_start()
        return self.integer[self._places(vrs, self.first_integer)].tolist()

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        for place, value in zip(self._places(vrs, self.first_text), values):
            self.string[place] = value

    def get_string(self, vrs: list[int]) -> list[str]:
        return [self.string[place] for place in self._places(vrs, self.first_text)]

    @staticmethod
    def _places(references: list[int], first: int) -> list[int]:
        """Return the positions in the storage of a type whose value references begin at `first`."""
        places = [reference - first for reference in references]
        if min(places, default=0) < 0:
            raise IndexError(f"no variable of this type has value reference {min(references)}")
        return places

    # state

    def _get_fmu_state(self) -> Any:
        return self.real[: self.real_count].copy(), self._settings(), self.state

    def _set_fmu_state(self, saved: Any) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        real, settings, state = saved
        texts = len(self.string)
        self.string[:] = settings[:texts]
        for v, number in zip(self.enumerations, settings[texts:]):
            self.views[v.name][...] = number
        self.fault = None
        self.real[: self.real_count] = real
        if state is not None and (self.state is None or self._parameters() != self.started_with):
            self.state = self._checked_start()
            self.real[: self.real_count] = real
        if isinstance(state, dict):
            state = self._restored(state)
        self.state = state

    def _restored(self, members: Any) -> Any:
        """Return the state with these members; log and return None if they do not fit the model."""
        own = {} if self.state is None else _members(self.state)
        if _layout(members) != _layout(own):
            return self._refuse("expected a state of this FMU, got one of another grid")
        numbers = {name: a if a.shape else a.item() for name, a in members.items()}
        return _assembled(self.state_type, numbers)

    @classmethod
    def _fmu_state_to_bytes(cls, saved: Any) -> bytes:  # pyright: ignore[reportIncompatibleMethodOverride]
        real, settings, state = saved
        arrays = {"": real} | ({} if state is None else _members(state))
        head = {"settings": settings, "started": state is not None}
        return join(head | ({"slow": cls.slow_state} if cls.slow_state else {}), arrays)

    def _fmu_state_from_bytes(self, data: Any) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Return the saved state in bytes; raise `BadInput` for other or damaged bytes."""
        try:
            head, arrays = split(bytes(data))
            real, settings = arrays.pop(""), tuple(head["settings"])
            state = arrays if head["started"] else None
        except (ValueError, TypeError, KeyError, AttributeError):
            real, settings, arrays, state = np.zeros(0), (), {}, None
        fits = _layout({"": real}) == _layout({"": self.real[: self.real_count]})
        if not (fits and self._may_be_settings(settings) and all(map(is_sound, arrays.values()))):
            raise BadInput(
                f"expected the bytes of a state of this FMU, got {len(data)} other or damaged bytes"
            )
        return real, settings, state

    def _may_be_settings(self, settings: tuple[Any, ...]) -> bool:
        """Return whether these may be the `_settings` of another instance."""
        numbers = settings[len(self.string) :]
        return list(map(type, settings)) == list(map(type, self._settings())) and all(
            1 <= number <= len(v.choices) for v, number in zip(self.enumerations, numbers)
        )


def _layout(members: Mapping[str, np.ndarray]) -> dict[str, tuple[Any, ...]]:
    """Return type and shape of each array by name."""
    return {name: (array.dtype, array.shape) for name, array in members.items()}


def _members(state: Any, path: str = "") -> dict[str, np.ndarray]:
    """Return the arrays of a state by name, nested ones as `field.name`."""
    members: dict[str, np.ndarray] = {}
    for name, value in _named(state):
        if isinstance(value, tuple):
            members |= _members(value, f"{path}{name}.")
        else:
            members[f"{path}{name}"] = np.asarray(value)
    return members


def _named(state: object) -> ItemsView[str, Any]:
    """Return names and values of the members of a named tuple or a dataclass."""
    if isinstance(state, tuple):
        return cast(Any, state)._asdict().items()
    return vars(state).items()


def _assembled(kind: Any, members: Mapping[str, Any], path: str = "") -> Any:
    """Return the state with these `_members`."""
    values = {
        name: _assembled(hint, members, f"{path}{name}.")
        if hasattr(hint, "_fields")
        else members[f"{path}{name}"]
        for name, hint in get_type_hints(kind).items()
    }
    return kind(**values)


def element_names(variable: Variable) -> list[str]:
    """Return the FMI names of a variable's scalars: `name`, or `name[i,j]`, 1-based, C order."""
    if not variable.shape:
        return [variable.name]
    return [
        f"{variable.name}[{','.join(str(k + 1) for k in index)}]"
        for index in np.ndindex(*variable.shape)
    ]
