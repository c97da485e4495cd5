"""Large named tuples that kernels pass to each other by reference.

numba passes each number in a tuple as an argument of its own. A tuple of all bodies has hundreds,
which every kernel takes apart and builds again. Here the argument is a pointer to the tuple, and a
kernel loads only the parts that it uses, once, at its start. Nothing writes to such a tuple.
"""

from collections.abc import Iterable, Sequence
from importlib import import_module
from typing import Any

from .tree import ROOT

llvm: Any = import_module("numba.core.cgutils").ir
models: Any = import_module("numba.core.datamodel.models")
registry: Any = import_module("numba.core.datamodel.registry")
types: Any = import_module("numba.core.types")

LARGEST_TUPLE = 16
"""Count of numbers of the largest named tuple that is passed by value."""


class ByReference:
    """Mixin of numba's models of named tuples: the argument is a pointer."""

    get_value_type: Any

    def get_argument_type(self) -> Any:
        """Return LLVM's type of the argument."""
        return self.get_value_type().as_pointer()

    def as_argument(self, builder: Any, value: Any) -> Any:
        """Return the pointer to a value, which is stored unless it is in memory."""
        if not is_referenced(value):
            place, block = getattr(value, "stored", (None, None))
            if block is not builder.basic_block:
                with builder.goto_entry_block():
                    place = builder.alloca(value.type)
                builder.store(value, place)
                value.stored = place, builder.basic_block
            return place
        return pointer_of(value)

    def from_argument(self, builder: Any, pointer: Any) -> Any:
        """Return the value of an argument."""
        return value_at(builder, pointer, ())


class ReferencedTuple(ByReference, models.TupleModel):
    """Model of a named tuple."""


class ReferencedUniTuple(ByReference, models.UniTupleModel):
    """Model of a named tuple whose fields have one type."""


def value_at(builder: Any, pointer: Any, positions: Sequence[int]) -> Any:
    """Return the part of a tuple in memory, loaded at the start of the kernel."""
    integer = llvm.IntType(32)
    with builder.goto_entry_block():
        if positions:
            indices = [integer(k) for k in (0, *positions)]
            pointer = builder.gep(pointer, indices, inbounds=True)
        value = builder.load(pointer)
    value.pointer = pointer
    return value


def is_referenced(value: Any) -> bool:
    """Return whether a value is that of `value_at`."""
    return hasattr(value, "pointer")


def pointer_of(value: Any) -> Any:
    """Return where the value of `value_at` is."""
    return value.pointer


def remove_unused(function: Any, values: Iterable[Any]) -> None:
    """Remove those values of `value_at` that no instruction of a function uses."""
    loads = {id(one): one for one in values if is_referenced(one)}
    if not loads:
        return
    for block in function.blocks:
        for one in block.instructions:
            for operand in one.operands:
                loads.pop(id(operand), None)
            for operand, _ in getattr(one, "incomings", ()):
                loads.pop(id(operand), None)
    block = function.entry_basic_block
    block.instructions = [one for one in block.instructions if id(one) not in loads]


def _count(model: Any) -> int:
    """Return the count of numbers in a value."""
    inner = model.inner_models()
    if isinstance(model, models.UniTupleModel):
        return model._count * _count(inner[0])  # pyright: ignore[reportPrivateUsage]
    return sum(_count(one) for one in inner) if isinstance(model, models.StructModel) else 1


def _whole(convert: Any) -> Any:
    """Return a conversion of numba that leaves values as they are if memory has the same type."""

    def converted(model: Any, builder: Any, value: Any) -> Any:
        same = model.__dict__.get("is_same")
        if same is None:
            same = model.is_same = model.get_value_type() == model.get_data_type()
        return value if same else convert(model, builder, value)

    return converted


for _name in ("as_data", "as_return"):
    setattr(models.StructModel, _name, _whole(getattr(models.StructModel, _name)))


def _register(kind: Any, model: Any) -> None:
    """Use a model for large named tuples of this tree; numba caches kernels of others."""
    manager = registry.default_manager
    other = manager._handlers[kind]  # of numba, or of another tree

    def made(manager: Any, fe_type: Any) -> Any:
        if fe_type.instance_class.__module__.partition(".")[0] == ROOT:
            known = model(manager, fe_type)
            if _count(known) > LARGEST_TUPLE:
                return known
        return other(manager, fe_type)

    manager.register(kind, made)


_register(types.NamedTuple, ReferencedTuple)
_register(types.NamedUniTuple, ReferencedUniTuple)
