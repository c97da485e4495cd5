"""How kernels are compiled, in every part.

Division by zero gives inf as in numpy (a film that is not finite is refused where it is solved);
results are kept on disk. No fast mathematics: sums in the order written and no fused multiply-add
give the same bits in every process, whether a kernel has just been compiled or comes from disk, and
in whatever kernel it is inlined. Measured, it costs nothing here.

numba looks at a kernel's own file to tell whether what it kept is still true. A kernel also holds
what it calls, so here it is the kernel's file and all files of the project that it imports,
directly or not. A kept kernel that cannot be read is made again; where nothing can be kept, kernels
are compiled anew in each process. numba itself (half a second) is imported by the first call.
"""

from contextlib import suppress
from functools import cached_property, partial, update_wrapper
from pathlib import Path
from typing import Any

KERNELS: list["Kernel"] = []
"""All of this process that Python calls."""


def compiled(kernel=None, **options):
    """Compile a kernel: `@compiled`, or `@compiled(inline="always")` with options of
    `numba.njit`.
    """
    if kernel is None:
        return partial(compiled, **options)
    KERNELS.append(Kernel(kernel, options))
    return KERNELS[-1]


def compilable(function):
    """A function that runs as written where Python calls it, and is compiled within kernels that
    call it: what a model says between its kernels, and a native FMU in them.
    """
    return WithinKernels(function, {})


def standing_for(kernel):
    """A function that Python runs as written, and in whose place kernels call `kernel`: of the same
    arguments, some of which are objects in Python.
    """
    return partial(StandIn, kernel=kernel)


def packed(kind: Any, *others: str):
    """Kernels that keep the numbers of a named tuple in an array, (array, tuple), and that make it
    of them again, (array, *others); `others` are its fields that are no numbers.
    """
    names = [name for name in kind._fields if name not in others]
    given = "".join(f", {name}" for name in others)
    stores = "".join(f"    x[{k}] = value.{name}\n" for k, name in enumerate(names))
    values = ", ".join([f"{n}=x[{k}]" for k, n in enumerate(names)] + [f"{n}={n}" for n in others])
    scope = {"kind": kind}
    exec(f"def put(x, value):\n{stores}\ndef made(x{given}):\n    return kind({values})", scope)
    return compiled(scope["put"]), compiled(scope["made"])


class Kernel:
    """A function that is compiled at its first call.

    py_func : the function as written; targetoptions : options of `numba.njit`.
    """

    keeps = True
    """Whether kernels of this process are kept on disk."""

    def __init__(self, function, options):
        update_wrapper(self, function)
        self.py_func = function
        self.targetoptions = options

    def __call__(self, *arguments, **named):
        return self.dispatcher(*arguments, **named)

    @cached_property
    def dispatcher(self) -> Any:
        """What numba makes of it for calls from Python."""
        from .callees import EntryCompiler

        return self._made(self._kept, pipeline_class=EntryCompiler)

    @cached_property
    def callee(self) -> Any:
        """What numba makes of it for the code of other kernels, in which it stands for this."""
        from .callees import CalleeCompiler

        alone = dict.fromkeys(("no_cpython_wrapper", "no_cfunc_wrapper"), True)
        return self._made(self._kept_as("CalleeCache"), pipeline_class=CalleeCompiler, **alone)

    def _made(self, kept, **options):
        from numba import njit

        dispatcher: Any = njit(error_model="numpy", **options, **self.targetoptions)(self.py_func)
        if kept:
            dispatcher._cache = kept
        return dispatcher

    @cached_property
    def _kept(self):
        return self._kept_as("KernelCache")

    def _kept_as(self, kind):
        """What is kept of it on disk; None where there is nowhere to keep it."""
        from . import kernel_cache

        with suppress(RuntimeError):
            return getattr(kernel_cache, kind)(self.py_func) if self.keeps else None

    @property
    def store(self) -> Path | None:
        """The folder where it is kept."""
        return Path(self._kept.cache_path) if self._kept else None

    @property
    def _numba_type_(self):
        return self.callee._numba_type_


class WithinKernels(Kernel):
    """A function that is compiled in the code of kernels alone."""

    def __call__(self, *arguments, **named):
        return self.py_func(*arguments, **named)


class StandIn:
    """A function of Python's, to kernels another."""

    def __init__(self, function, kernel: Kernel):
        update_wrapper(self, function)
        self.function = function
        self.kernel = kernel

    def __call__(self, *arguments):
        return self.function(*arguments)

    @property
    def _numba_type_(self):
        return self.kernel._numba_type_


def first_start() -> str:
    """What takes long at a start, for whoever waits; empty without kernels, or if they are kept."""
    stores = (folder for one in KERNELS if (folder := one.store))
    if not KERNELS or any(next(folder.glob("*.nbi"), None) for folder in stores):
        return ""
    can_keep = any(one.store for one in KERNELS)
    kept = "kept for the starts to come" if can_keep else "again at each start: nothing can be kept"
    return f"compiling the code of this FMU, which takes about a minute; {kept}"
