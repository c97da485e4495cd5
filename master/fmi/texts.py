"""Texts below the annotated names of a class, which describe them."""

import ast
import inspect
import sys
from functools import cache
from itertools import pairwise


@cache
def texts_below(kind: type) -> dict[str, str]:
    """Return the text below each annotated name of a class that has one."""
    texts: dict[str, str] = {}
    for one, below in pairwise(_classes_of(kind.__module__)[kind.__name__].body):
        if isinstance(one, ast.AnnAssign) and isinstance(below, ast.Expr):
            assert isinstance(one.target, ast.Name) and isinstance(below.value, ast.Constant)
            texts[one.target.id] = inspect.cleandoc(str(below.value.value))
    return texts


def description(kind: type, name: str) -> str:
    """Return the description of a variable: the text below it, without its last full stop.

    Raises
    ------
    TypeError
        If it has none.
    """
    text = texts_below(kind).get(name)
    if text is None:
        raise TypeError(f"{kind.__name__}.{name}: expected its description below it, got nothing")
    return " ".join(text.split()).removesuffix(".")


@cache
def _classes_of(module: str) -> dict[str, ast.ClassDef]:
    """Return the classes in the source of a module, by name."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {one.name: one for one in ast.walk(tree) if isinstance(one, ast.ClassDef)}
