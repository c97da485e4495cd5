"""The project's own tree of packages: the installed one, or the copy that an FMU carries under a
name made of its content.
"""

import ast
import json
import sys
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from .cache import cache_folder, write_whole

INSTALLED = "piston_cosim"
ROOT = __name__.removesuffix(".master.fmi.tree")
"""Name of the package that this tree is: INSTALLED, or an FMU's own."""

FOR_USERS = ("master.fmi.errors", "master.fmi.variables", "master.fmi.slave")
"""What a slave written outside the project imports."""

_OWN_SOURCE = Path(__file__).read_bytes()


def import_part(name: str) -> ModuleType:
    """Module `name` of this tree ("fmu_ehd.build"), else the installed one of that name (a
    participant from elsewhere).
    """
    spec = find_spec(f"{ROOT}.{name.partition('.')[0]}")
    own = spec is not None and spec.origin is not None  # a folder without code is not a part
    return import_module(f"{ROOT}.{name}" if own else name)


def slave_class(path: str) -> type:
    """The class at "module:class" of this tree; `import piston_cosim...` in its module reaches this
    tree too.
    """
    module, _, name = path.partition(":")
    with _under_the_installed_name():
        return getattr(import_part(module), name)


@contextmanager
def _under_the_installed_name():
    """Inside an FMU, this tree under the name of the installed one, which is hidden meanwhile."""
    if ROOT == INSTALLED:
        yield
        return
    for name in FOR_USERS:
        import_module(f"{ROOT}.{name}")
    hidden = _taken_out(INSTALLED)
    sys.modules.update(
        {INSTALLED + name.removeprefix(ROOT): sys.modules[name] for name in _names(ROOT)}
    )
    try:
        yield
    finally:
        _taken_out(INSTALLED)
        sys.modules.update(hidden)


def _names(package):
    """Loaded modules of a package, itself included."""
    return [name for name in sys.modules if name == package or name.startswith(package + ".")]


def _taken_out(package):
    """The same, no longer among the loaded modules: name -> module."""
    return {name: sys.modules.pop(name) for name in _names(package)}


def reached(file):
    """The file and those that its relative imports lead to, directly or not, as a set."""
    reached = set()
    waiting = [file]
    while waiting:
        path = waiting.pop()
        if path not in reached:
            reached.add(path)
            waiting += _imported(path)
    return reached


@cache
def _imported(file):
    """Files that a file's relative imports name."""
    found = []
    for level, module, names in _relative_imports(file.read_bytes()):
        package = file.parents[level - 1].joinpath(*module.split("."))
        if (one := package.with_name(package.name + ".py")).is_file():
            found.append(one)
        else:
            found += [package / "__init__.py", *(package / f"{name}.py" for name in names)]
            found += [package / name / "__init__.py" for name in names]
    return [path.resolve() for path in found if path.is_file()]


def _relative_imports(source):
    """Level, module and names of each relative import of a source. To parse all that a part is made
    of takes a fifth of a start, so what was found in a source is kept where the disk allows it.
    """
    kept = None
    with suppress(OSError, ValueError):
        kept = cache_folder("imports") / sha256(_OWN_SOURCE + source).hexdigest()[:24]
        return json.loads(kept.read_text())
    found = [
        [node.level, node.module or "", [alias.name for alias in node.names]]
        for node in _statements(ast.parse(source))
        if isinstance(node, ast.ImportFrom) and node.level
    ]
    if kept:
        with suppress(OSError):
            write_whole(kept, json.dumps(found).encode())
    return found


def _statements(node):
    """All statements below a node of a syntax tree; expressions hold none and are passed by."""
    for name in ("body", "handlers", "orelse", "finalbody", "cases"):
        for inner in getattr(node, name, ()):
            yield inner
            yield from _statements(inner)
