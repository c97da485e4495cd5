"""Kernels inside other kernels, lowered once and optimised with their caller.

By default numba makes every kernel callable from Python, although most kernels run only inside
others. That takes half of a first start. Here, a callee stays LLVM code for any processor. The
entry links all its callees, and is optimised and translated as a whole. Native FMUs use the same
cached callees. Nothing is reordered or fused, so results are bit for bit the same.

numba numbers the functions of a process from 1 on, to give functions of the same name symbols of
their own. An entry links callees of several processes, so here these numbers are random.
"""

import gc
import secrets
from collections.abc import Generator
from contextlib import contextmanager
from functools import cache, cached_property, partial
from importlib import import_module
from typing import Any

from . import quick_typing
from .borrowing import BorrowingCompiler

_dynfunc: Any = import_module("numba._dynfunc")
bytecode: Any = import_module("numba.core.bytecode")
caching: Any = import_module("numba.core.caching")
compiler: Any = import_module("numba.core.compiler")
JITCodeLibrary: Any = import_module("numba.core.codegen").JITCodeLibrary

bytecode.FunctionIdentity._unique_ids = iter(partial(secrets.randbits, 62), -1)

quick_typing.use()

LLVM: Any = import_module("numba.core.codegen").ll
"""llvmlite, as numba imports it."""


class EntryLibrary(JITCodeLibrary):
    """Code that Python calls.

    callees : bitcode of all kernels inside it, each after its own callees, to its environments.
    """

    _codegen: Any
    _dynamic_globals: Any
    _final_module: Any
    _reload_init: Any
    environments: tuple[Any, ...] = ()
    """Constants of numba for this code, without callees."""

    def __init__(self, codegen: Any, name: str):
        JITCodeLibrary.__init__(self, codegen, name)
        self.callees: dict[bytes, tuple[Any, ...]] = {}

    def add_linking_library(self, library: Any) -> None:
        """Add a library; a kernel is linked at the end, once, whatever calls it."""
        if isinstance(library, CalleeLibrary):
            self._reload_init.update(library._reload_init)
            self._dynamic_globals += library._dynamic_globals
            self.callees |= library.codes
        else:
            JITCodeLibrary.add_linking_library(self, library)

    def link_callees(self) -> None:
        """Link all kernels inside it. LLVM leaves out what nothing calls yet: callers first."""
        for bitcode in reversed(self.callees):
            self._final_module.link_in(_parsed(bitcode), preserve=True)

    def _optimize_functions(self, ll_module: Any) -> None:
        """Set only the layout that LLVM needs to link; `finalize` optimises the whole."""
        ll_module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        """Link, optimise and translate."""
        self.link_callees()
        JITCodeLibrary.finalize(self)


class CalleeLibrary(EntryLibrary):
    """Code of a kernel inside others, the same for all processors."""

    @cached_property
    def bitcode(self) -> bytes:
        """Its own code, without callees."""
        return self._get_module_for_linking().as_bitcode()

    @property
    def codes(self) -> dict[bytes, tuple[Any, ...]]:
        """Bitcode that an entry links, with its environments."""
        return self.callees | {self.bitcode: self.environments}

    def restore(self, codes: dict[bytes, tuple[Any, ...]]) -> None:
        """Take over the `codes` that another process has saved."""
        self.bitcode, self.environments = codes.popitem()
        self.callees = codes
        self._final_module = _parsed(self.bitcode)
        self._finalize_final_module()

    def link_callees(self) -> None:
        """Do nothing; the entry links them."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Simplify each function, so that entries have less to link and to optimise."""
        if not hasattr(LLVM, "create_pass_builder"):  # an old numba
            JITCodeLibrary._optimize_functions(self, ll_module)
            return
        ll_module.data_layout = self._codegen._data_layout
        passes = _simplification()
        manager = passes.getFunctionPassManager()
        manager.add_refprune_pass()
        for function in ll_module.functions:
            if not function.is_declaration:
                manager.run(function, passes)

    def _optimize_final_module(self) -> None:
        """Do nothing; the entry optimises it."""

    def _finalize_final_module(self) -> None:
        """Finish without translation to machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True


@cache
def _parsed(bitcode: bytes) -> Any:
    return LLVM.parse_bitcode(bitcode)


@cache
def _simplification() -> Any:
    """Return LLVM's passes of level 1 for any processor of this platform."""
    machine = LLVM.Target.from_triple(LLVM.get_process_triple()).create_target_machine()
    options = LLVM.create_pipeline_tuning_options(speed_level=1)
    return LLVM.create_pass_builder(machine, options)


@contextmanager
def rare_collections() -> Generator[None]:
    """Let Python look for unused objects less often while numba compiles.

    numba creates millions of objects that live until a kernel is compiled. Without these searches,
    a first start takes an eighth less time, and a quarter more memory.
    """
    threshold = gc.get_threshold()
    gc.set_threshold(200_000, 50, 1000)
    try:
        yield
    finally:
        gc.set_threshold(*threshold)


class CalleeCompiler(BorrowingCompiler):
    """numba's compiler of a kernel that other kernels call."""

    state: Any

    def compile_extra(self, func: Any) -> Any:
        context = self.state.targetctx
        self.state.flags.no_compile = True
        self.state.library = CalleeLibrary(context.codegen(), func.__qualname__)
        with rare_collections():
            compiled = BorrowingCompiler.compile_extra(self, func)
        compiled.library.finalize()
        compiled.library.environments = tuple(compiled._find_referenced_environments())
        compiled = compiled._replace(entry_point=_name_of(compiled.fndesc, compiled.environment))
        context.insert_user_function(compiled.entry_point, compiled.fndesc, [compiled.library])
        return compiled


class EntryCompiler(BorrowingCompiler):
    """numba's compiler of a kernel that Python calls; it registers the environments of callees."""

    state: Any

    def compile_extra(self, func: Any) -> Any:
        self.state.library = EntryLibrary(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        with rare_collections():
            compiled = BorrowingCompiler.compile_extra(self, func)
        for environment in compiled._find_referenced_environments():
            compiled.codegen.set_env(environment.env_name, environment)
        return compiled


class CalleeKept(caching.CompileResultCacheImpl):
    """Cached form of a callee on disk."""

    def check_cachable(self, cres: Any) -> bool:
        """Return whether the code is the same in every process."""
        return not cres.library.has_dynamic_globals

    def reduce(self, cres: Any) -> tuple[Any, ...]:
        """Return all that a caller links."""
        library = cres.library
        cres.fndesc.typemap = cres.fndesc.calltypes = None  # large, and need not be pickled
        named = cres.fndesc, cres.environment, cres.signature, cres.reload_init
        return library.name, library.codes, *named

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """Return the callee that another process has saved."""
        name, codes, fndesc, environment, signature, reload_init = payload
        for again in reload_init:
            again()
        library = CalleeLibrary(target_context.codegen(), name)
        library.restore(codes)
        unknown = dict.fromkeys(compiler.CompileResult._fields)
        known = dict(
            typing_context=target_context.typing_context,
            target_context=target_context,
            entry_point=_name_of(fndesc, environment),
            signature=signature,
            objectmode=False,
            lifted=(),
            fndesc=fndesc,
            library=library,
            environment=environment,
            reload_init=reload_init,
            referenced_envs=library.environments,
        )
        return compiler.CompileResult(**(unknown | known))


def _name_of(fndesc: Any, environment: Any) -> Any:
    """Return the name that numba uses for a kernel: a Python function without code."""
    module, name = fndesc.lookup_module(), fndesc.qualname
    return _dynfunc.make_function(module, name.split(".")[-1], "", 0, environment, ())
