"""The project's tree of packages: the installed one, or the copy inside an FMU."""

import ast
import json
import re
import sys
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from .cache import cache_folder, write_whole

INSTALLED = "piston_cosim"
ROOT = __name__.removesuffix(".master.fmi.tree")
"""Package name of this tree: INSTALLED, or that of an FMU."""

FOR_USERS = ("master.fmi.errors", "master.fmi.variables", "master.fmi.slave")
"""Modules that a model class outside the project imports."""

_OWN_SOURCE = Path(__file__).read_bytes()

_TEXT_OR_COMMENT = re.compile(
    r"""("{3}(?:[^\\]|\\.)*?"{3}|'{3}(?:[^\\]|\\.)*?'{3}"""
    r"""|"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')|#[^\n]*""",
    re.DOTALL,
)
"""A text in a source, or a comment; `tokenize` takes a twentieth of a first start."""


def import_part(name: str) -> ModuleType:
    """Return module `name` of this tree ("fmu_ehd.build"), else the installed module."""
    spec = find_spec(f"{ROOT}.{name.partition('.')[0]}")
    own = spec is not None and spec.origin is not None  # a folder without code is not a part
    return import_module(f"{ROOT}.{name}" if own else name)


def slave_class(path: str) -> type:
    """Return the class at "module:class" of this tree.

    `import piston_cosim...` in its module refers to this tree too.
    """
    module, _, name = path.partition(":")
    with _as_installed():
        return getattr(import_part(module), name)


@contextmanager
def _as_installed() -> Generator[None, None, None]:
    """Inside an FMU, give this tree the name of the installed one, which is hidden meanwhile."""
    if ROOT == INSTALLED:
        yield
        return
    for name in FOR_USERS:
        import_module(f"{ROOT}.{name}")
    hidden = _remove_modules(INSTALLED)
    sys.modules.update(
        {INSTALLED + name.removeprefix(ROOT): sys.modules[name] for name in _names(ROOT)}
    )
    try:
        yield
    finally:
        _remove_modules(INSTALLED)
        sys.modules.update(hidden)


def _names(package: str) -> list[str]:
    """Return the loaded modules of a package, including itself."""
    return [name for name in sys.modules if name == package or name.startswith(package + ".")]


def _remove_modules(package: str) -> dict[str, ModuleType]:
    """Remove a package from the loaded modules; return them, name to module."""
    return {name: sys.modules.pop(name) for name in _names(package)}


def reached(file: Path) -> set[Path]:
    """Return the set of the file and all files that its relative imports reach."""
    reached: set[Path] = set()
    waiting = [file]
    while waiting:
        path = waiting.pop()
        if path not in reached:
            reached.add(path)
            waiting += _imported(path)
    return reached


@cache
def _imported(file: Path) -> list[Path]:
    """Return the files that a file's relative imports name."""
    files: list[Path] = []
    level: int
    for level, module, names in _relative_imports(file.read_bytes()):
        package = file.parents[level - 1].joinpath(*module.split("."))
        if (one := package.with_name(package.name + ".py")).is_file():
            files.append(one)
        else:
            files += [package / "__init__.py", *(package / f"{name}.py" for name in names)]
            files += [package / name / "__init__.py" for name in names]
    return [path.resolve() for path in files if path.is_file()]


def _cached(find: Callable[[bytes], Any]) -> Callable[[bytes], Any]:
    """Cache the results of a function of a source, because parsing takes a fifth of a start."""

    def known(source: bytes) -> Any:
        path = None
        with suppress(OSError, ValueError):
            name = sha256(_OWN_SOURCE + source).hexdigest()[:24]
            path = cache_folder("imports") / f"{name}.{find.__name__.strip('_')}"
            return json.loads(path.read_text())
        entries = find(source)
        if path:
            with suppress(OSError):
                write_whole(path, json.dumps(entries).encode())
        return entries

    return known


@_cached
def _relative_imports(source: bytes) -> list[list[Any]]:
    """Return level, module and names of each relative import of a source."""
    return [
        [node.level, node.module or "", [alias.name for alias in node.names]]
        for node in _statements(ast.parse(source))
        if isinstance(node, ast.ImportFrom) and node.level
    ]


@_cached
def code_digest(source: bytes) -> str:
    """Return the digest of a source's code, without comments, docstrings and empty lines."""
    lines = _TEXT_OR_COMMENT.sub(r"\1", source.decode()).split("\n")
    tree = ast.parse(source)
    for node in (tree, *_statements(tree)):
        first: Any = next(iter(getattr(node, "body", ())), None)
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
            begin, end = first.lineno - 1, first.end_lineno or 0
            before = lines[begin].encode()[: first.col_offset]
            after = lines[end - 1].encode()[first.end_col_offset :]
            if not (before.strip() or after.strip()):
                lines[begin:end] = [""] * (end - begin)
    code = "\n".join(line.rstrip() for line in lines if line.strip())
    return sha256(code.encode()).hexdigest()


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """Yield all statements below a node of a syntax tree."""
    for name in ("body", "handlers", "orelse", "finalbody", "cases"):
        for inner in getattr(node, name, ()):
            yield inner
            yield from _statements(inner)
