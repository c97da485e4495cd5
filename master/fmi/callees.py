"""Kernels inside other kernels, lowered once and optimised with their caller.

By default numba makes every kernel callable from Python, although most kernels run only inside
others. That takes half of a first start. Here, a callee stays LLVM code, and the entry that
links it is optimised and translated as a whole. Nothing is reordered or fused, so results are
bit for bit the same.
"""

from typing import Any

from numba import _dynfunc  # pyright: ignore[reportAttributeAccessIssue]
from numba.core import codegen
from numba.core.caching import CompileResultCacheImpl
from numba.core.compiler import Compiler, CompileResult

LLVM: Any = vars(codegen)["ll"]
"""llvmlite, as numba imports it."""


class CalleeLibrary(codegen.JITCodeLibrary):
    """Code that is linked into other kernels."""

    def _optimize_final_module(self):
        """Do nothing; the caller optimises it."""

    def _finalize_final_module(self):
        """Finish without translation to machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True


class CalleeCompiler(Compiler):
    """numba's compiler of a kernel that other kernels call."""

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
    """numba's compiler of a kernel that Python calls; it registers the environments of callees."""

    def compile_extra(self, func):
        made = super().compile_extra(func)
        for environment in made._find_referenced_environments():
            made.codegen.set_env(environment.env_name, environment)
        return made


class CalleeKept(CompileResultCacheImpl):
    """Cached form of a callee on disk."""

    def reduce(self, cres: Any) -> tuple:
        """Return all that a caller links."""
        library = cres.library
        code = library._get_module_for_linking().as_bitcode()
        cres.fndesc.typemap = cres.fndesc.calltypes = None  # large, and need not be pickled
        environments = tuple(cres._find_referenced_environments())
        named = cres.fndesc, cres.environment, cres.signature, cres.reload_init, environments
        return library.name, code, *named

    def rebuild(self, target_context, payload):
        """Return the callee that another process has saved."""
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
    """Return the name that numba uses for a kernel: a Python function without code."""
    module, name = fndesc.lookup_module(), fndesc.qualname
    return _dynfunc.make_function(module, name.split(".")[-1], "", 0, environment, ())
