"""Trees of named tuples in rows of float64 numbers: the memory of code without Python.

The annotations of a tree state its content: numbers, further named tuples, and arrays with their
shapes, `Annotated[NDArray, "n_c, n_a + 1"]`. A row holds the leaves in the order of declaration.
The lengths of an array precede its values, so an absent array takes one length of 0.

A further text is a condition on the leaf `x`, `Annotated[int, "0 <= x < reals"]`, which `checker`
applies to rows from a file.
"""

import ast
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, cast, get_args, get_origin, get_type_hints

import numpy as np

from .compiled import compilable, standing_for


def leaves(kind: Any, path: str = "tree") -> Iterator[tuple[str, Any]]:
    """Yield path and annotation of every leaf of a tree of named tuples, in order."""
    for name, hint in get_type_hints(kind, include_extras=True).items():
        if hasattr(hint, "_fields"):
            yield from leaves(type_of(hint), f"{path}.{name}")
        else:
            yield f"{path}.{name}", hint


def type_of(hint: Any) -> Any:
    """Return the type in an annotation."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


def shape_of(hint: Any) -> list[str]:
    """Return the lengths in an array's annotation; empty for a number."""
    return [] if type_of(hint) in (float, int, bool) else get_args(hint)[1].split(", ")


def condition_of(hint: Any) -> str:
    """Return the condition in an annotation, empty if there is none."""
    texts = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
    is_array = not hasattr(hint, "_fields") and shape_of(hint)
    return "".join(texts[1:] if is_array else texts)


def element_of(hint: Any) -> Any:
    """Return the element type in an array's annotation."""
    of_array = get_args(type_of(hint))
    return get_args(of_array[1])[0] if of_array else np.float64


BY_BITS: tuple[Any, ...] = (np.float32, np.int64)
"""Elements of arrays that are stored by their bits; `flatten` supports only the second."""


def row_of(tree: Any) -> np.ndarray:
    """Return the row of a tree, as its kernel writes it."""
    if isinstance(tree, tuple):
        return np.concatenate([row_of(member) for member in cast(tuple[Any, ...], tree)])
    flat = np.ravel(tree)
    if np.ndim(tree) and flat.dtype in BY_BITS:
        flat = np.pad(flat, (0, -flat.nbytes % 8 // flat.itemsize)).view(float)
    return np.concatenate([np.shape(tree), flat], dtype=float)


# ---- memory of a participant: a head, then parts

FIRST_STATE, STATES, FAULTS, PARTS_FROM = range(1, 5)
"""The head: total length, position and length of the state, position of the faults (the result
of the entry `size`), then the positions of the parts."""


def memory_of(
    given: Mapping[str, np.ndarray],
    lengths: Mapping[str, int],
    unsaved: int = 0,
) -> np.ndarray:
    """Return the first part of a memory: the head and the given parts.

    Parameters
    ----------
    given : mapping
        Parts by name, in order.
    lengths : mapping
        Lengths of the parts after them. Two of them are named state and faults.
    unsaved : int
        Length of the end of the state that a saved state omits.
    """
    sizes = {name: part.size for name, part in given.items()} | dict(lengths)
    begins = np.cumsum([PARTS_FROM + len(sizes) + 1, *sizes.values()])
    first = dict(zip(sizes, begins))
    head = [begins[-1], first["state"], sizes["state"] - unsaved, first["faults"], *begins]
    return np.concatenate([head, *given.values()])


@compilable
def part(memory: np.ndarray, k: int) -> np.ndarray:
    return memory[int(memory[PARTS_FROM + k]) : int(memory[PARTS_FROM + k + 1])]


def parts(kind: Any) -> Any:
    """Return a kernel of the parts of a memory by name, as the named tuple `kind`."""
    ends = (f"int(memory[{PARTS_FROM + k}])" for k in range(len(kind._fields) + 1))
    text = ", ".join(f"memory[{begin} : {end}]" for begin, end in pairwise(ends))
    scope: dict[str, Any] = {"kind": kind}
    exec(f"def get(memory):\n    return kind({text})", scope)
    return compilable(scope["get"])


# ---- rows


@compilable
def _keep(to: np.ndarray, what: np.ndarray) -> None:
    for k in range(len(to)):
        to[k] = what[k]


@standing_for(_keep)
def keep(to: np.ndarray, what: np.ndarray) -> None:
    """Copy an array of one axis; in kernels by a loop, which never calls Python."""
    to[:] = what


@compilable
def write(row: np.ndarray, at: int, array: np.ndarray) -> int:
    """Write an array and its lengths into a row at a position; return the position after it."""
    for length in array.shape:
        row[at] = length
        at += 1
    flat = array.reshape(array.size)
    for k in range(len(flat)):
        row[at + k] = flat[k]
    return at + len(flat)


@compilable
def read_1(row: np.ndarray, at: int) -> tuple[np.ndarray, int]:
    """Return the array of one axis at a position of a row, and the position after it."""
    end = at + 1 + int(row[at])
    return row[at + 1 : end], end


@compilable
def read_2(row: np.ndarray, at: int) -> tuple[np.ndarray, int]:
    """Return the array of two axes at a position of a row, and the position after it."""
    n, m = int(row[at]), int(row[at + 1])
    end = at + 2 + n * m
    return row[at + 2 : end].reshape((n, m)), end


@compilable
def read_singles(row: np.ndarray, at: int) -> tuple[np.ndarray, int]:
    """Return the array of two axes of single precision, and the position after it."""
    n, m = int(row[at]), int(row[at + 1])
    end = at + 2 + (n * m + 1) // 2
    return row[at + 2 : end].view(np.float32)[: n * m].reshape((n, m)), end


@compilable
def read_3(row: np.ndarray, at: int) -> tuple[np.ndarray, int]:
    """Return the array of three axes at a position of a row, and the position after it."""
    q, n, m = int(row[at]), int(row[at + 1]), int(row[at + 2])
    end = at + 3 + q * n * m
    return row[at + 3 : end].reshape((q, n, m)), end


@compilable
def read_4(row: np.ndarray, at: int) -> tuple[np.ndarray, int]:
    """Return the array of four axes at a position of a row, and the position after it."""
    p, q, n, m = int(row[at]), int(row[at + 1]), int(row[at + 2]), int(row[at + 3])
    end = at + 4 + p * q * n * m
    return row[at + 4 : end].reshape((p, q, n, m)), end


READERS = {f"read_{axes}": one for axes, one in enumerate((read_1, read_2, read_3, read_4), 1)}


def flatten(kind: Any) -> tuple[Any, Any]:
    """Return kernels that write a tree into a row and read it back.

    The first kernel, (row, tree), returns the length that it wrote. The second one is `reader`.

    Parameters
    ----------
    kind : type
        Named tuple whose leaves are float, int, bool, or arrays, `Annotated`, of float64, int64 or
        bool.
    """
    scope: dict[str, Any] = {"write": write, "np": np}
    lines = ["at = 0"]
    for path, hint in leaves(kind):
        if shape_of(hint):
            bits = ".view(np.float64)" if element_of(hint) is np.int64 else ""
            lines.append(f"at = write(row, at, {path}{bits})")
        else:
            lines += [f"row[at] = {path}", "at += 1"]
    return _made("row, tree", [*lines, "return at"], scope), reader(kind)


def reader(kind: Any) -> Any:
    """Return the kernel that reads a tree from a row, (row).

    Arrays that are read are views of the row. Arrays of flags are copies.

    Parameters
    ----------
    kind : type
        As of `flatten`, or with arrays of two axes of single precision.
    """
    scope: dict[str, Any] = {"np": np, "read_singles": read_singles, **READERS}
    lines = ["at = 0"]
    for path, hint in leaves(kind):
        axes = len(shape_of(hint))
        name = path.replace(".", "_")
        if axes:
            of = "singles" if element_of(hint) is np.float32 else axes
            lines.append(f"{name}, at = read_{of}(row, at)")
            if element_of(hint) is np.bool_:
                lines.append(f"{name} = {name} != 0.0")
            if element_of(hint) is np.int64:
                lines.append(f"{name} = {name}.view(np.int64)")
        else:
            cast = "" if type_of(hint) is float else type_of(hint).__name__
            lines += [f"{name} = {cast}(row[at])", "at += 1"]
    return _made("row", [*lines, f"return {_built(kind, 'tree', scope)}"], scope)


def alike(kind: Any) -> Any:
    """Return the kernel that compares two rows of a tree, (row, other): False if lengths differ.

    The lengths are those of all arrays. `other` is a valid row, `row` may hold anything.
    """
    all_axes = tuple(len(shape_of(hint)) for _, hint in leaves(kind))

    def has_lengths(row: np.ndarray, other: np.ndarray) -> bool:
        at = 0
        for axes in all_axes:
            size = 1
            for k in range(at, at + axes):
                if row[k] != other[k]:
                    return False
                size *= int(other[k])
            at += axes + size
        return True

    return compilable(has_lengths)


# ---- checks of rows from a file

LARGEST = 2.0**53
"""Bound of whole numbers that a float64 holds exactly."""


@compilable
def end_of(row: np.ndarray, at: int, axes: float, per_word: float) -> int:
    """Return the position after the array of so many axes at a position, -1 if it does not fit."""
    first = at + int(axes)
    if first > len(row):
        return -1
    size = 1
    for k in range(at, first):
        if not 0.0 <= row[k] <= 2 * len(row) or row[k] != np.floor(row[k]):
            return -1
        size *= int(row[k])
        if size > 2 * len(row):
            return -1
    end = first + int(np.ceil(size / per_word))
    return end if end <= len(row) else -1


@compilable
def is_finite(x: np.ndarray) -> bool:
    """Return whether all elements are finite."""
    flat = x.reshape(x.size)
    for k in range(len(flat)):
        if not np.isfinite(flat[k]):
            return False
    return True


@compilable
def within(x: np.ndarray, low: float, end: float) -> bool:
    """Return whether all elements are whole numbers from `low` to below `end`."""
    flat = x.reshape(x.size)
    for k in range(len(flat)):
        if not low <= flat[k] < end or flat[k] != np.floor(flat[k]):
            return False
    return True


@compilable
def has_room(first: float, size: int, end: int) -> bool:
    """Return whether so many elements from a position on end before `end`, or there are none."""
    return size == 0 or (0.0 <= first <= end - size and first == np.floor(first))


CONDITIONS = {"end_of": end_of, "is_finite": is_finite, "within": within, "has_room": has_room}
"""Functions in the conditions of all trees."""


Names = dict[str, Any]
"""Variables of the kernel by name of a tuple's members and lengths; `Names` of a tuple inside."""


def checker(kind: Any, arguments: str = "", **functions: Any) -> Any:
    """Return the kernel that checks a row from a file, (row, *arguments).

    It returns the position after the tree, or -1 if a length or a value does not fit. A length with
    a name is the same in the tuple and in tuples inside it, except n and m. Numbers are finite,
    counts whole. A condition, which replaces this, may use all names, `x` for its leaf, and the
    members of a tuple. Conditions are checked after all lengths.

    Parameters
    ----------
    kind : type
        As of `reader`.
    arguments : str
        Names that conditions use.
    functions
        Functions that conditions use.
    """
    scope: dict[str, Any] = {"np": np, "read_singles": read_singles, **READERS, **CONDITIONS}
    lines, conditions = ["at = 0"], list[tuple[str, list[Names]]]()
    names = dict.fromkeys(filter(None, arguments.split(", ")))
    _check(kind, "tree", [{name: name for name in names}], (lines, conditions))
    for text, scopes in conditions:
        lines += [f"if not ({_translated(text, scopes)}):", "    return -1"]
    row = ", ".join(["row", *names])
    return _made(row, [*lines, "return at"], scope | functions)


def _check(kind: Any, path: str, outer: list[Names], out: tuple[list[str], list[Any]]) -> Names:
    """Append the lines that read a tuple, and its conditions; return its names."""
    lines, conditions = out
    own: Names = {}
    scopes = [own, *outer]
    for name, hint in get_type_hints(kind, include_extras=True).items():
        leaf = f"{path}_{name}"
        if hasattr(hint, "_fields"):
            own[name] = _check(type_of(hint), leaf, scopes, out)
            condition = condition_of(hint)
        else:
            lines += _reading(hint, leaf)
            for k, length in enumerate(shape_of(hint)):
                _bind(length, f"{leaf}.shape[{k}]", f"{path}_{length}_", scopes, lines)
            if not shape_of(hint):
                _bind(name, leaf, leaf, scopes, lines)
            own[name] = leaf
            condition = condition_of(hint) or _usual(hint)
        if condition:
            conditions.append((condition, [{"x": own[name]}, *scopes]))
    return own


def _usual(hint: Any) -> str:
    """Return the condition on a leaf without one."""
    if shape_of(hint):
        return "" if element_of(hint) is np.int64 else "is_finite(x)"
    return "np.isfinite(x)" if type_of(hint) is float else ""


def _reading(hint: Any, leaf: str) -> list[str]:
    """Return the lines that read a leaf, unless the row ends before, or its type differs."""
    axes = len(shape_of(hint))
    if not axes:
        kind = type_of(hint).__name__
        is_whole = f"row[at] == np.floor(row[at]) and abs(row[at]) <= {LARGEST}"
        is_one = {"bool": "row[at] == 0.0 or row[at] == 1.0", "int": is_whole}
        return [
            f"if at >= len(row) or not ({is_one.get(kind, True)}):",
            "    return -1",
            f"{leaf} = {kind}(row[at])",
            "at += 1",
        ]
    is_single = element_of(hint) is np.float32
    lines = [
        f"if end_of(row, at, {axes}.0, {2.0 if is_single else 1.0}) < 0:",
        "    return -1",
        f"{leaf}, at = read_{'singles' if is_single else axes}(row, at)",
    ]
    return lines + [f"{leaf} = {leaf}.view(np.int64)"] * (element_of(hint) is np.int64)


ANY_LENGTH = ("n", "m")
"""Names of lengths that may differ between arrays."""


def _bind(length: str, actual: str, variable: str, scopes: list[Names], lines: list[str]) -> None:
    """Append the lines that compare a length, or name it at its first appearance."""
    if length in ANY_LENGTH:
        return
    if length.isidentifier() and not any(length in names for names in scopes):
        scopes[0][length] = variable
        lines.append(f"{variable} = {actual}")
    else:
        lines += [f"if {actual} != {_translated(length, scopes)}:", "    return -1"]


def _translated(text: str, scopes: list[Names]) -> str:
    """Return an expression with the variables of the kernel for its names."""

    def variable(node: Any) -> Any:
        if isinstance(node, ast.Name):
            return next((names[node.id] for names in scopes if node.id in names), None)
        inside = variable(node.value) if isinstance(node, ast.Attribute) else None
        return cast(Names, inside).get(node.attr) if isinstance(inside, dict) else None

    class Translation(ast.NodeTransformer):
        def generic_visit(self, node: Any) -> Any:
            name = variable(node)
            if isinstance(name, str):
                return ast.Name(name, ast.Load())
            return super().generic_visit(node)

    return ast.unparse(Translation().visit(ast.parse(text, mode="eval")))


def length_of(kind: Any) -> Any:
    """Return the kernel that computes the length of a tree's row, (tree)."""
    hints = list(leaves(kind))
    sizes = [
        f"{len(shape_of(hint))} + {path}.size" if shape_of(hint) else "1" for path, hint in hints
    ]
    return _made("tree", [f"return {' + '.join(sizes)}"], {})


def room_of(kind: Any, names: str) -> Any:
    """Return the kernel of the length of a tree's longest row, for lengths of arrays, (*names)."""
    shapes = [shape_of(hint) for _, hint in leaves(kind)]
    sizes = (f"{len(shape)} + {' * '.join(f'({one})' for one in shape) or 1}" for shape in shapes)
    return _made(names, [f"return {' + '.join(sizes)}"], {})


@compilable
def given_part(
    memory: np.ndarray, parts: float, check: Any, reals: int, integers: int
) -> np.ndarray:
    """Return the first of so many parts from a file, empty if it is that of another memory.

    The file ends with this part. `check` is its `checker`.
    """
    first = PARTS_FROM + int(parts) + 1
    fits = len(memory) > first and memory[PARTS_FROM] == first
    row = memory[first if fits and memory[PARTS_FROM + 1] == len(memory) else len(memory) :]
    is_whole = len(row) > 0 and check(row, reals, integers) == len(row)
    return row if is_whole else row[len(row) :]


@compilable
def is_head(memory: np.ndarray, lengths: Any, state: float, unsaved: int) -> bool:
    """Return whether a head from a file is that of `memory_of` for these lengths.

    lengths : tuple, of the parts after the given one, the faults last; state : its number in them.
    """
    end = len(memory)
    first_state = first = end
    for k in range(len(lengths)):
        first = end
        first_state = first if k == int(state) else first_state
        end += lengths[k]
        if memory[PARTS_FROM + 2 + k] != end:
            return False
    fits = memory[FIRST_STATE] == first_state and memory[FAULTS] == first
    return fits and memory[STATES] == lengths[int(state)] - unsaved and memory[0] == end


def _made(arguments: str, lines: list[str], scope: dict[str, Any]) -> Any:
    """Return the function of these lines, which kernels compile."""
    exec(f"def made({arguments}):\n    " + "\n    ".join(lines), scope)
    return compilable(scope["made"])


def _built(kind: Any, path: str, scope: dict[str, Any]) -> str:
    """Return the expression that makes a tree from its leaves."""
    scope[kind.__name__] = kind
    members = (
        _built(hint, f"{path}_{name}", scope) if hasattr(hint, "_fields") else f"{path}_{name}"
        for name, hint in get_type_hints(kind).items()
    )
    return f"{kind.__name__}({', '.join(members)})"
