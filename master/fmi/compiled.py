"""Compilation of kernels in all parts.

Division by zero gives inf as in numpy (a film that is not finite is rejected by its solver). No
fast mathematics: sums run in the written order and no multiply-add is fused. Results are therefore
bit for bit the same in every process, for cached and for fresh kernels, and inside any kernel.

numba validates its cache by the kernel's own file. A kernel also contains its callees, so this
cache uses that file and all files of the project that it imports. Unreadable kernels are
recompiled. If nothing can be cached, each process compiles its kernels. numba (half a second) is
imported by the first call.
"""

import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cached_property, partial, update_wrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, ParamSpec, TypeVar, overload

Given = ParamSpec("Given")
Result = TypeVar("Result")

KERNELS: list["Kernel[..., Any]"] = []
"""Kernels of this process that Python calls."""


@overload
def compiled(kernel: Callable[Given, Result]) -> "Kernel[Given, Result]": ...
@overload
def compiled(kernel: None = None, **options: Any) -> "Callable[..., Any]": ...
def compiled(kernel: Any = None, **options: Any) -> Any:
    """Compile a kernel: `@compiled`, or with options of `numba.njit`."""
    if kernel is None:
        return partial(compiled, **options)
    KERNELS.append(Kernel(kernel, options))
    return KERNELS[-1]


def compilable(function: Callable[Given, Result]) -> "CompilableFunction[Given, Result]":
    """Return a function that Python runs as written, and that is compiled inside kernels.

    Models use it for code between their kernels, which native FMUs compile.
    """
    return CompilableFunction(function)


def standing_for(
    kernel: "Kernel[..., Any]",
) -> "Callable[[Callable[Given, Result]], ReplacedFunction[Given, Result]]":
    """Return a decorator of a Python function that `kernel` replaces inside kernels.

    Both have the same arguments, some of which are objects in Python.
    """
    return partial(ReplacedFunction, kernel=kernel)


def numbered(*names: str) -> Any:
    """Return a named tuple of the numbers of `names`, from 0 on: choices or rows in kernels."""
    fields = [(name, int) for name in names]
    return NamedTuple("Numbered", fields)._make(range(len(names)))


def packed(kind: Any, *others: str) -> tuple[Any, Any]:
    """Return functions that store the numbers of a named tuple in an array and restore it.

    They are (array, tuple) and (array, *others). `others` are the fields that are not numbers. The
    cache has them under the file of the named tuple.
    """
    names = [name for name in kind._fields if name not in others]
    extra = "".join(f", {name}" for name in others)
    stores = "".join(f"    x[{k}] = value.{name}\n" for k, name in enumerate(names))
    values = ", ".join([f"{n}=x[{k}]" for k, n in enumerate(names)] + [f"{n}={n}" for n in others])
    put, from_row = (f"{word}_{kind.__name__}" for word in ("put", "made"))
    text = f"def {put}(x, value):\n{stores}\ndef {from_row}(x{extra}):\n    return kind({values})"
    module = sys.modules[kind.__module__]
    importable = getattr(module, kind.__name__, None) is kind  # else no cache can name its type
    scope: dict[str, Any] = {"kind": kind, "__name__": kind.__module__}
    exec(compile(text, str(module.__file__) if importable else "<string>", "exec"), scope)
    return compilable(scope[put]), compilable(scope[from_row])


class Kernel(Generic[Given, Result]):
    """Function that is compiled at its first call.

    py_func : the function as written; targetoptions : options of `numba.njit`.
    """

    def __init__(self, function: Callable[Given, Result], options: dict[str, Any]):
        update_wrapper(self, function)
        self.py_func = function
        self.targetoptions = options

    def __call__(self, *arguments: Given.args, **named: Given.kwargs) -> Result:
        return self.dispatcher(*arguments, **named)

    @cached_property
    def dispatcher(self) -> Any:
        """numba's dispatcher for calls from Python."""
        from .callees import EntryCompiler

        return self._made(self._kept, pipeline_class=EntryCompiler, no_cfunc_wrapper=True)

    @cached_property
    def callee(self) -> Any:
        """numba's dispatcher for calls from other kernels."""
        from .callees import CalleeCompiler

        alone = dict.fromkeys(("no_cpython_wrapper", "no_cfunc_wrapper"), True)
        return self._made(self._kept_as("CalleeCache"), pipeline_class=CalleeCompiler, **alone)

    def _made(self, cache: Any, **options: Any) -> Any:
        from numba import njit

        # numba would hand it on to the kernels inside
        inlined = {"forceinline": self.targetoptions.get("forceinline", False)}
        options |= {"error_model": "numpy"} | inlined | self.targetoptions
        dispatcher: Any = njit(**options)(self.py_func)
        if cache:
            dispatcher._cache = cache
        return dispatcher

    @cached_property
    def _kept(self) -> Any:
        return self._kept_as("KernelCache")

    def _kept_as(self, kind: str) -> Any:
        """Return the cache on disk, None if there is none."""
        from . import kernel_cache

        with suppress(RuntimeError):
            return getattr(kernel_cache, kind)(self.py_func)

    @property
    def store(self) -> Path | None:
        """Folder of the cached kernel."""
        return Path(self._kept.cache_path) if self._kept else None

    @property
    def _numba_type_(self) -> Any:
        return self.callee._numba_type_


class CompilableFunction(Kernel[Given, Result], partial[Any]):
    """Function that is compiled inside kernels only."""

    def __init__(  # pyright: ignore[reportInconsistentConstructor]
        self, function: Callable[Given, Result]
    ):
        super().__init__(function, {})

    if not TYPE_CHECKING:
        __call__ = partial.__call__  # takes a third of the time of a function that passes on


class ReplacedFunction(Generic[Given, Result]):
    """Function that kernels replace by another one."""

    def __init__(self, function: Callable[Given, Result], kernel: Kernel[..., Any]):
        update_wrapper(self, function)
        self.function = function
        self.kernel = kernel

    def __call__(self, *arguments: Given.args, **named: Given.kwargs) -> Result:
        return self.function(*arguments, **named)

    @property
    def _numba_type_(self) -> Any:
        return self.kernel._numba_type_  # pyright: ignore[reportPrivateUsage]


def first_start() -> str:
    """Return the message of a first start, empty if there are no kernels or all are cached."""
    stores = (folder for one in KERNELS if (folder := one.store))
    if not KERNELS or any(next(folder.glob("*.nbi"), None) for folder in stores):
        return ""
    can_keep = any(one.store for one in KERNELS)
    later = "later starts reuse it" if can_keep else "repeated at each start without a cache"
    return f"compiling the code of this FMU, which takes about a minute; {later}"
