"""Protocol of participants: every object with these methods can take part."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from math import prod
from typing import Any, Protocol

import numpy as np

from ..fmi.fields import Field
from ..fmi.variables import Variable

Value = np.ndarray | float | int | bool | str
"""Value of a variable: an array of its shape, or a Python scalar."""


class Participant(Protocol):
    """One model under the master.

    `start` calls `enter` and `leave`, begin and end of Initialization Mode. `step` advances from
    `time` by `step` [s]. A saved state is the result of `save`, which the master does not inspect.
    `derivative` returns the changes of `products` (outputs) for changes `seeds` of inputs, both by
    name.

    A participant may also define `block(names, use)`, see `FieldBlock`, and
    `derive(inputs, changes, outputs)`. They transfer several concatenated real fields in one call.
    For other participants the master transfers each field separately.
    """

    @property
    def name(self) -> str: ...
    @property
    def has_derivatives(self) -> bool: ...
    @property
    def fields(self) -> Mapping[str, Field | Variable]: ...

    def start(
        self, parameters: Mapping[str, Value], start_time: float, stop_time: float
    ) -> None: ...
    def enter(
        self, parameters: Mapping[str, Value], start_time: float, stop_time: float
    ) -> None: ...
    def leave(self) -> None: ...
    def set(self, name: str, value: Value) -> None: ...
    def get(self, name: str) -> Any: ...
    def get_many(self, names: Iterable[str]) -> dict[str, float]: ...
    def step(self, time: float, step: float) -> None: ...
    def save(self) -> Any: ...
    def restore(self, saved: Any) -> None: ...
    def free(self, saved: Any) -> None: ...
    def serialise(self, saved: Any) -> bytes: ...
    def deserialise(self, data: bytes) -> Any: ...
    def derivative(
        self, seeds: Mapping[str, np.ndarray], products: Iterable[str]
    ) -> dict[str, np.ndarray]: ...
    def close(self) -> None: ...


class StartedInHalves:
    """Mixin whose `start` calls `enter` and `leave`, begin and end of Initialization Mode."""

    enter: Callable[..., None]
    leave: Callable[[], None]

    def start(self, parameters: Mapping[str, Value], start_time: float, stop_time: float) -> None:
        """Instantiate and initialise with `parameters` by name, in the participant's units.

        The others have their start values. Raises `BadInput` with every fault.
        """
        self.enter(parameters, start_time, stop_time)
        self.leave()


class Wrapper(StartedInHalves):
    """Participant that changes another one: undefined attributes are those of that one."""

    def __init__(self, participant: Any):
        self.participant = participant

    def __getattr__(self, name: str) -> Any:
        return getattr(self.participant, name)


class FieldBlock:
    """Several real fields of a participant, one by one.

    use : "read" or "written"; values : ndarray, their concatenated values.
    """

    def __init__(self, participant: Any, names: Sequence[str], use: str = "read"):
        self.participant, self.names = participant, names
        written = names if use == "written" else ()
        self.values = np.zeros(sum(prod(participant.fields[name].shape) for name in written))

    def get(self) -> None:
        """Read the fields into `values`."""
        self.values = np.concatenate([np.ravel(self.participant.get(name)) for name in self.names])

    def put(self) -> None:
        """Set the fields to `values`."""
        for name, value in split(self.participant, self.names, self.values.copy()).items():
            self.participant.set(name, value)


def block_of(participant: Any, names: Sequence[str], use: str = "read") -> Any:
    """Return several real fields of a participant, see `FieldBlock`."""
    make = getattr(participant, "block", None) or partial(FieldBlock, participant)
    return make(names, use)


class FieldByField:
    """`block` and `derive` field by field, for participants that change these."""

    def block(self, names: Sequence[str], use: str = "read") -> FieldBlock:
        """Return several real fields."""
        return FieldBlock(self, names, use)

    def derive(
        self, inputs: Sequence[str], changes: np.ndarray, outputs: Sequence[str]
    ) -> np.ndarray:
        """Return the directional derivative of several fields, concatenated."""
        return derive_each(self, inputs, changes, outputs)


def split(participant: Any, names: Iterable[str], values: np.ndarray) -> dict[str, np.ndarray]:
    """Return several real fields by name from their concatenated values."""
    fields, begin = {}, 0
    for name in names:
        shape = participant.fields[name].shape
        fields[name] = values[begin : begin + prod(shape)].reshape(shape)
        begin += prod(shape)
    return fields


def derive_each(
    participant: Any, inputs: Iterable[str], changes: np.ndarray, outputs: Sequence[str]
) -> np.ndarray:
    """Return the directional derivative of several outputs for changes of several inputs."""
    products = participant.derivative(split(participant, inputs, changes), outputs)
    return np.concatenate([np.ravel(products[name]) for name in outputs])
