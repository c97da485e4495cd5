"""Functions of numba's compiler that are called most often, with the same results in less time.

numba resolves each operation of a kernel again, although a kernel repeats few of them: a sum of
two numbers, an element of an array. Here it resolves an operation once for given types.
"""

from collections.abc import Callable
from functools import lru_cache
from importlib import import_module
from typing import Any

errors: Any = import_module("numba.core.errors")
functions: Any = import_module("numba.core.types.functions")
ir: Any = import_module("numba.core.ir")
targetconfig: Any = import_module("numba.core.targetconfig")

PLAIN = frozenset((str, int, float, bool, type(None), ir.Loc))
"""Types of what an instruction contains next to variables."""


def equal_options(self: Any, other: Any) -> Any:
    """Return whether options are equal; compare those that are set first."""
    if type(self) is type(other) and self._values == other._values:
        return True
    return _equal(self, other)


def options_hash(self: Any) -> int:
    """Return the hash of a kind of options; numba's own is that of the names of all options."""
    kind: Any = self.__class__
    return hash(kind)


def variables(self: Any, value: Any) -> list[Any]:
    """Return the variables in a part of an instruction, in the order of numba."""
    kind: Any = value.__class__
    if kind in PLAIN:
        return []
    if kind is ir.Var:
        return [value]
    parts: Any = value.values() if kind is dict else value
    if kind not in (dict, list, tuple):
        return _variables(self, value)
    return [one for part in parts for one in variables(self, part)]


_equal: Callable[..., Any] = targetconfig.TargetConfig.__eq__
_variables: Callable[..., list[Any]] = ir.Inst._rec_list_vars


def call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
    """Return the signature of a function of numba for arguments of given types."""
    flags = targetconfig.ConfigStack.top_or_none()
    key = self, context, tuple(args), tuple(kws.items()), len(self.templates), flags
    if key not in SIGNATURES:
        SIGNATURES[key] = _call_type(self, context, args, kws)
    return SIGNATURES[key]


SIGNATURES: dict[tuple[Any, ...], Any] = {}
"""Known signatures. A type must not contain them, because caches on disk contain types."""

_call_type: Callable[..., Any] = functions.BaseFunction.get_call_type


def use() -> None:
    """Replace numba's functions."""
    if functions.BaseFunction.get_call_type.__name__ == call_type.__name__:
        return  # another tree has done it
    targetconfig.TargetConfig.__eq__ = equal_options
    targetconfig.TargetConfig.__hash__ = options_hash
    ir.Inst._rec_list_vars = variables
    functions.BaseFunction.get_call_type = call_type
    scheme: Any = errors.termcolor().__class__
    if hasattr(scheme, "_markup"):  # colours of messages, although nobody reads most of them
        scheme._markup = lru_cache(maxsize=1000)(scheme._markup)
