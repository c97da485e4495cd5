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


class Options(targetconfig.TargetConfig):
    """Comparison of options by those that are set."""

    _values: dict[str, Any]

    def __eq__(self, other: object) -> bool:
        if type(self) is type(other) and self._values == other._values:
            return True
        return _equal(self, other)

    def __hash__(self) -> int:
        return hash(type(self))  # numba's own hash is that of the names of all options


_equal: Callable[..., bool] = targetconfig.TargetConfig.__eq__


def variables(self: Any, value: Any) -> list[Any]:
    """Return the variables in a part of an instruction, in the order of numba."""
    kind: Any = type(value)
    if kind in PLAIN:
        return []
    if kind is ir.Var:
        return [value]
    if isinstance(value, dict):
        value = value.values()
    elif not isinstance(value, (list, tuple)):
        return _variables(self, value)
    return [one for part in value for one in variables(self, part)]


_variables: Callable[..., list[Any]] = ir.Inst._rec_list_vars


def call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
    """Return the signature of a function of numba for arguments of given types."""
    flags = targetconfig.ConfigStack.top_or_none()
    known = self.__dict__.setdefault("known_signatures", {})
    key = context, tuple(args), tuple(kws.items()), len(self.templates), flags
    if key not in known:
        known[key] = _call_type(self, context, args, kws)
    return known[key]


_call_type: Callable[..., Any] = functions.BaseFunction.get_call_type


def use() -> None:
    """Replace numba's functions."""
    if functions.BaseFunction.get_call_type.__name__ == call_type.__name__:
        return  # another tree has done it
    targetconfig.TargetConfig.__eq__ = Options.__eq__
    targetconfig.TargetConfig.__hash__ = Options.__hash__
    ir.Inst._rec_list_vars = variables
    functions.BaseFunction.get_call_type = call_type
    scheme: Any = type(errors.termcolor())
    if hasattr(scheme, "_markup"):  # colours of messages, although nobody reads most of them
        scheme._markup = lru_cache(maxsize=1000)(scheme._markup)


use()
