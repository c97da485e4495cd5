"""Trees of named tuples in rows of float64 numbers: the memory of code without Python.

The annotations of a tree state its content: numbers, further named tuples, and arrays with their
shapes, `Annotated[NDArray, "n_c, n_a + 1"]`. A row holds the leaves in the order of declaration.
The lengths of an array precede its values, so an absent array takes one length of 0.
"""

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

PARTS_FROM = 4
"""Position of the parts' positions in the head, after total length, position and length of the
state, and position of the faults, which front/native.c reads."""


def memory_of(
    first_parts: Mapping[str, np.ndarray],
    lengths: Mapping[str, int],
    unsaved: int = 0,
) -> np.ndarray:
    """Return the first part of a memory: the head and the given parts.

    Parameters
    ----------
    first_parts : mapping
        Parts by name, in order.
    lengths : mapping
        Lengths of the parts after them. Two of them are named state and faults.
    unsaved : int
        Length of the end of the state that a saved state omits.
    """
    sizes = {name: part.size for name, part in first_parts.items()} | dict(lengths)
    begins = np.cumsum([PARTS_FROM + len(sizes) + 1, *sizes.values()])
    first = dict(zip(sizes, begins))
    head = [begins[-1], first["state"], sizes["state"] - unsaved, first["faults"], *begins]
    return np.concatenate([head, *first_parts.values()])


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
    return _function("row, tree", [*lines, "return at"], scope), reader(kind)


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
    return _function("row", [*lines, f"return {_built(kind, 'tree', scope)}"], scope)


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


@compilable
def is_finite(x: np.ndarray) -> bool:
    """Return whether all elements are finite."""
    flat = x.reshape(x.size)
    for k in range(len(flat)):
        if not np.isfinite(flat[k]):
            return False
    return True


def length_of(kind: Any) -> Any:
    """Return the kernel that computes the length of a tree's row, (tree)."""
    hints = list(leaves(kind))
    sizes = [
        f"{len(shape_of(hint))} + {path}.size" if shape_of(hint) else "1" for path, hint in hints
    ]
    return _function("tree", [f"return {' + '.join(sizes)}"], {})


def room_of(kind: Any, names: str) -> Any:
    """Return the kernel of the length of a tree's longest row, for lengths of arrays, (*names)."""
    shapes = [shape_of(hint) for _, hint in leaves(kind)]
    sizes = (f"{len(shape)} + {' * '.join(f'({one})' for one in shape) or 1}" for shape in shapes)
    return _function(names, [f"return {' + '.join(sizes)}"], {})


def _function(arguments: str, lines: list[str], scope: dict[str, Any]) -> Any:
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
