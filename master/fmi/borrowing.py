"""Kernels without reference counts of what their caller lends them.

numba counts a reference to each array of a tuple whenever a kernel names the tuple or a part of it,
and again when it drops the name. The caller of a kernel keeps its arguments until the kernel
returns. A variable that is only ever an argument, or a part of one, therefore needs no count.

To count the references of a tuple, numba takes every number in it, even lengths and strides of
arrays. Here it takes only parts that are counted, which are half of all instructions.
"""

from functools import cache
from importlib import import_module
from typing import Any

from .references import is_referenced, pointer_of, remove_unused, value_at

compiler: Any = import_module("numba.core.compiler")
ir: Any = import_module("numba.core.ir")
machinery: Any = import_module("numba.core.compiler_machinery")
numba_lowering: Any = import_module("numba.core.lowering")
runtime: Any = import_module("numba.core.runtime.context")
typed_passes: Any = import_module("numba.core.typed_passes")
types: Any = import_module("numba.core.types")

PARTS = ("getattr", "static_getitem")
"""Operations that take a part of a tuple."""

Path = tuple[int, ...]


class BorrowingLower(numba_lowering.Lower):
    """Translation of numba's code to LLVM.

    borrowed : names of the variables without counts.
    paths : number of the argument, and positions of the part in it, of each variable in it.
    """

    builder: Any
    fnargs: Any
    func_ir: Any
    typeof: Any
    borrowed: frozenset[str] = frozenset()
    paths: dict[str, Path]
    counts = True
    """Whether the instruction that is translated counts references."""

    def pre_lower(self) -> None:
        """Find the borrowed variables before the first instruction."""
        numba_lowering.Lower.pre_lower(self)
        self.paths = {}
        self.parts: dict[Path, Any] = {}
        if self.generator_info is None:
            values: dict[str, list[Any]] = {}
            for block in self.func_ir.blocks.values():
                for one in block.find_insts(ir.Assign):
                    values.setdefault(one.target.name, []).append(one.value)
            self.borrowed = self._borrowed(values)
            single = {name: values[name][0] for name in self.borrowed if len(values[name]) == 1}
            paths = {name: self._path(name, single) for name in single}
            self.paths = {name: path for name, path in paths.items() if path}

    def post_lower(self) -> None:
        """Remove values that nothing uses after the last instruction."""
        remove_unused(self.builder.function, [*self.parts.values(), *self.fnargs])
        numba_lowering.Lower.post_lower(self)

    def _path(self, name: str, values: dict[str, Any]) -> Path:
        """Return the path of a borrowed variable, empty if no argument by reference has it."""
        value: Any = values.get(name)
        if value is None:
            return ()
        if isinstance(value, ir.Arg):
            return (value.index,) if is_referenced(self.fnargs[value.index]) else ()
        if isinstance(value, ir.Var):
            return self._path(value.name, values)
        whole = self._path(value.value.name, values)
        position = _position(self.typeof(value.value.name), value)
        return (*whole, position) if whole and position is not None else whole

    def _part(self, path: Path) -> Any:
        """Return the value at a path."""
        argument, *positions = path
        if not positions:
            return self.fnargs[argument]
        if path not in self.parts:
            pointer = pointer_of(self.fnargs[argument])
            self.parts[path] = value_at(self.builder, pointer, positions)
        return self.parts[path]

    def loadvar(self, name: str) -> Any:
        """Return the value of a variable."""
        if name in self.paths:
            return self._part(self.paths[name])
        return numba_lowering.Lower.loadvar(self, name)

    def _borrowed(self, values: dict[str, list[Any]]) -> frozenset[str]:
        """Return the largest set of variables that are arguments or parts of others of the set."""
        names = frozenset(values)
        while True:
            left = frozenset(
                name
                for name in names
                if all(self._is_lent(name, one, names) for one in values[name])
            )
            if left == names:
                return names
            names = left

    def _is_lent(self, name: str, value: Any, names: frozenset[str]) -> bool:
        """Return whether a value is an argument, or one of `names` or its part, as it is."""
        if isinstance(value, ir.Arg):
            return self.typeof("arg." + value.name) == self.typeof(name)
        if isinstance(value, ir.Var):
            return value.name in names and self.typeof(value.name) == self.typeof(name)
        if not isinstance(value, ir.Expr) or value.op not in (*PARTS, "exhaust_iter"):
            return False
        if value.value.name not in names:
            return False
        whole = self.typeof(value.value.name)
        if value.op == "exhaust_iter":  # of a tuple that is unpacked
            return isinstance(whole, types.BaseTuple) and whole == self.typeof(name)
        position = _position(whole, value)
        return position is not None and whole[position] == self.typeof(name)

    def lower_inst(self, inst: Any) -> None:
        """Translate an instruction, without counts if it names or drops a borrowed variable."""
        name = ""
        if isinstance(inst, ir.Assign):
            name = inst.target.name
        elif isinstance(inst, ir.Del):
            name = inst.value
        if name in self.paths:
            return
        self.counts = name not in self.borrowed
        numba_lowering.Lower.lower_inst(self, inst)
        self.counts = True

    def lower_expr(self, resty: Any, expr: Any) -> Any:
        """Translate an expression; numba itself would count the part of a tuple."""
        if expr.op not in PARTS:
            return numba_lowering.Lower.lower_expr(self, resty, expr)
        name = expr.value.name
        whole = self.typeof(name)
        if name in self.paths and (position := _position(whole, expr)) is not None:
            if whole[position] == resty:
                value = self._part((*self.paths[name], position))
                self.incref(resty, value)
                return value
        if self.counts:
            return numba_lowering.Lower.lower_expr(self, resty, expr)
        return self.builder.extract_value(self.loadvar(name), _position(self.typeof(name), expr))

    def incref(self, typ: Any, val: Any) -> None:
        """Count a reference."""
        if self.counts:
            numba_lowering.Lower.incref(self, typ, val)

    def decref(self, typ: Any, val: Any) -> None:
        """Drop a reference."""
        if self.counts:
            numba_lowering.Lower.decref(self, typ, val)


@cache
def _is_counted(models: Any, kind: Any) -> bool:
    """Return whether values of a type contain memory with a reference count."""
    return models[kind].contains_nrt_meminfo()


def counted(self: Any, builder: Any, ty: Any, val: Any) -> list[tuple[Any, Any]]:
    """Return type and block of memory of all counted parts of a value, in the order of numba."""
    models = self._context.data_model_manager
    model = models[ty]
    blocks = [(ty, model.get_nrt_meminfo(builder, val))] if model.has_nrt_meminfo() else []
    for kind, part in model.traverse(builder):
        if _is_counted(models, kind):
            blocks += counted(self, builder, kind, part(val))
    return blocks


runtime.NRTContext.get_meminfos = counted


def _position(whole: Any, expr: Any) -> int | None:
    """Return the position of the part of a tuple that an expression takes, None if it has none."""
    if expr.op == "getattr" and isinstance(whole, types.BaseNamedTuple):
        return whole.fields.index(expr.attr) if expr.attr in whole.fields else None
    if expr.op == "static_getitem" and isinstance(whole, types.BaseTuple):
        return expr.index % len(whole) if isinstance(expr.index, int) else None
    return None


@machinery.register_pass(mutates_CFG=True, analysis_only=False)
class BorrowingLowering(typed_passes.NativeLowering):
    """Pass of numba's compiler that translates a kernel to LLVM."""

    _name = "borrowing_lowering"
    lowering_class = BorrowingLower


class BorrowingCompiler(compiler.Compiler):
    """numba's compiler with `BorrowingLowering`."""

    def define_pipelines(self) -> Any:
        """Return numba's passes with this translation."""
        pipelines = compiler.Compiler.define_pipelines(self)
        for one in pipelines:
            one.passes = [
                (BorrowingLowering if kind is typed_passes.NativeLowering else kind, text)
                for kind, text in one.passes
            ]
            one.finalize()
        return pipelines
