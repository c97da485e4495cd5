"""Kernels in the code of other kernels: lowered once, optimised and translated where they end up.

numba makes every kernel ready to run by itself, and most run only within a few that Python calls:
half of a first start was spent on machine code that nobody asked for. A callee stays in LLVM's
language; the entry into which it is linked is optimised and translated as a whole. The bits are
the same either way, for nothing is reordered or fused.
"""

from typing import Any

from numba import _dynfunc  # pyright: ignore[reportAttributeAccessIssue]
from numba.core import codegen
from numba.core.caching import CompileResultCacheImpl
from numba.core.compiler import Compiler, CompileResult

LLVM: Any = vars(codegen)["ll"]
"""llvmlite, as numba has it."""


class CalleeLibrary(codegen.JITCodeLibrary):
    """Code to be linked into that of others."""

    def _optimize_final_module(self):
        """Whoever links it does that."""

    def _finalize_final_module(self):
        """Nothing is translated."""
        self._finalize_dynamic_globals()
        self._finalized = True


class CalleeCompiler(Compiler):
    """numba's compiler of a kernel for others."""

    def compile_extra(self, func):
        context = self.state.targetctx
        self.state.flags.no_compile = True
        self.state.library = CalleeLibrary(context.codegen(), func.__qualname__)
        made = super().compile_extra(func)
        made.library.finalize()
        made = made._replace(entry_point=_name_of(made.fndesc, made.environment))
        context.insert_user_function(made.entry_point, made.fndesc, [made.library])
        return made


class EntryCompiler(Compiler):
    """numba's compiler of a kernel for Python: what its callees raise is found once it is ready."""

    def compile_extra(self, func):
        made = super().compile_extra(func)
        for environment in made._find_referenced_environments():
            made.codegen.set_env(environment.env_name, environment)
        return made


class CalleeKept(CompileResultCacheImpl):
    """What is kept of a callee on disk."""

    def reduce(self, cres: Any) -> tuple:
        """All that a caller links and asks for."""
        library = cres.library
        code = library._get_module_for_linking().as_bitcode()
        cres.fndesc.typemap = cres.fndesc.calltypes = None  # large, and need not be pickled
        environments = tuple(cres._find_referenced_environments())
        named = cres.fndesc, cres.environment, cres.signature, cres.reload_init, environments
        return library.name, code, *named

    def rebuild(self, target_context, payload):
        """The callee of another process."""
        name, code, fndesc, environment, signature, reload_init, environments = payload
        for again in reload_init:
            again()
        library = CalleeLibrary(target_context.codegen(), name)
        library._final_module = library._shared_module = LLVM.parse_bitcode(code)
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
            referenced_envs=environments,
        )
        return CompileResult(**(unknown | known))


def _name_of(fndesc, environment):
    """What numba knows a kernel by: a function of Python's, here one that has no code."""
    module, name = fndesc.lookup_module(), fndesc.qualname
    return _dynfunc.make_function(module, name.split(".")[-1], "", 0, environment, ())
