"""Kernels inside other kernels, lowered once and optimised with their caller.

By default numba makes every kernel callable from Python, although most kernels run only inside
others. That takes half of a first start. Here, a callee stays LLVM code for any processor. The
entry links all its callees, and is optimised and translated as a whole. Native FMUs use the same
cached callees. Nothing is reordered or fused, so results are bit for bit the same.

numba numbers the functions of a process from 1 on, to give functions of the same name symbols of
their own. An entry links callees of several processes, so here these numbers are random.
"""

import secrets
from functools import cache, cached_property, partial
from typing import Any

from numba import _dynfunc  # pyright: ignore[reportAttributeAccessIssue]
from numba.core import codegen
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import CompileResultCacheImpl
from numba.core.compiler import Compiler, CompileResult

FunctionIdentity._unique_ids = iter(partial(secrets.randbits, 62), -1)  # pyright: ignore

LLVM: Any = vars(codegen)["ll"]
"""llvmlite, as numba imports it."""


class EntryLibrary(codegen.JITCodeLibrary):
    """Code that Python calls.

    callees : bitcode of all kernels inside it, each after its own callees, to its environments.
    """

    environments: tuple = ()
    """Constants of numba for this code, without callees."""

    def __init__(self, codegen, name):
        super().__init__(codegen, name)
        self.callees: dict[bytes, tuple] = {}

    def add_linking_library(self, library):
        """Add a library; a kernel is linked at the end, once, whatever calls it."""
        if isinstance(library, CalleeLibrary):
            self._reload_init.update(library._reload_init)
            self._dynamic_globals += library._dynamic_globals
            self.callees |= library.codes
        else:
            super().add_linking_library(library)

    def link_callees(self):
        """Link all kernels inside it. LLVM leaves out what nothing calls yet: callers first."""
        for bitcode in reversed(self.callees):
            self._final_module.link_in(_parsed(bitcode), preserve=True)

    def finalize(self):
        """Link, optimise and translate."""
        self.link_callees()
        super().finalize()


class CalleeLibrary(EntryLibrary):
    """Code of a kernel inside others, the same for all processors."""

    @cached_property
    def bitcode(self) -> bytes:
        """Its own code, without callees."""
        return self._get_module_for_linking().as_bitcode()

    @property
    def codes(self) -> dict[bytes, tuple]:
        """Bitcode that an entry links, with its environments."""
        return self.callees | {self.bitcode: self.environments}

    def link_callees(self):
        """Do nothing; the entry links them."""

    def _optimize_functions(self, ll_module):
        """Simplify each function, so that entries have less to link and to optimise."""
        if not hasattr(LLVM, "create_pass_builder"):  # an old numba
            super()._optimize_functions(ll_module)
            return
        ll_module.data_layout = self._codegen._data_layout
        passes = _simplification()
        manager = passes.getFunctionPassManager()
        manager.add_refprune_pass()
        for function in ll_module.functions:
            manager.run(function, passes)

    def _optimize_final_module(self):
        """Do nothing; the entry optimises it."""

    def _finalize_final_module(self):
        """Finish without translation to machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True


@cache
def _parsed(bitcode):
    return LLVM.parse_bitcode(bitcode)


@cache
def _simplification():
    """Return LLVM's passes of level 1 for any processor of this platform."""
    machine = LLVM.Target.from_triple(LLVM.get_process_triple()).create_target_machine()
    options = LLVM.create_pipeline_tuning_options(speed_level=1)
    return LLVM.create_pass_builder(machine, options)


class CalleeCompiler(Compiler):
    """numba's compiler of a kernel that other kernels call."""

    def compile_extra(self, func):
        context = self.state.targetctx
        self.state.flags.no_compile = True
        self.state.library = CalleeLibrary(context.codegen(), func.__qualname__)
        made = super().compile_extra(func)
        made.library.finalize()
        made.library.environments = tuple(made._find_referenced_environments())
        made = made._replace(entry_point=_name_of(made.fndesc, made.environment))
        context.insert_user_function(made.entry_point, made.fndesc, [made.library])
        return made


class EntryCompiler(Compiler):
    """numba's compiler of a kernel that Python calls; it registers the environments of callees."""

    def compile_extra(self, func):
        self.state.library = EntryLibrary(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        made = super().compile_extra(func)
        for environment in made._find_referenced_environments():
            made.codegen.set_env(environment.env_name, environment)
        return made


class CalleeKept(CompileResultCacheImpl):
    """Cached form of a callee on disk."""

    def check_cachable(self, cres: Any) -> bool:
        """Return whether the code is the same in every process."""
        return not cres.library.has_dynamic_globals

    def reduce(self, cres: Any) -> tuple:
        """Return all that a caller links."""
        library = cres.library
        cres.fndesc.typemap = cres.fndesc.calltypes = None  # large, and need not be pickled
        named = cres.fndesc, cres.environment, cres.signature, cres.reload_init
        return library.name, library.codes, *named

    def rebuild(self, target_context, payload):
        """Return the callee that another process has saved."""
        name, codes, fndesc, environment, signature, reload_init = payload
        for again in reload_init:
            again()
        library = CalleeLibrary(target_context.codegen(), name)
        library.bitcode, library.environments = codes.popitem()
        library.callees = codes
        library._final_module = _parsed(library.bitcode)
        library._finalize_final_module()
        unknown = dict.fromkeys(CompileResult._fields)
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
        return CompileResult(**(unknown | known))


def _name_of(fndesc, environment):
    """Return the name that numba uses for a kernel: a Python function without code."""
    module, name = fndesc.lookup_module(), fndesc.qualname
    return _dynfunc.make_function(module, name.split(".")[-1], "", 0, environment, ())
