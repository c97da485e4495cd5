"""Plain data as bytes and back, without code, for checkpoints and saved states.

Layout
    8 bytes             length of the header, little endian
    header              JSON: the data, with a reference [offset, size] for every array and bytes
    blobs               consecutive arrays (with dtype and order of the header) and bytes

Plain data are None, bool, numbers, texts, bytes, NumPy arrays and scalars of numbers, slices,
lists, tuples and dictionaries. Objects of the classes that the caller names are also plain.
Equal data gives equal bytes. Objects are restored from their attributes, and no content of the
bytes is called.
"""

import json
from collections.abc import Iterable
from typing import Any

import numpy as np

LENGTH = 8
NUMBERS = "biufc"
"""Kinds of NumPy dtypes that are plain data."""


class NotPlain(ValueError):
    """Bytes that are not plain data, or data that cannot be converted to bytes."""


def pack(thing: Any, classes: Iterable[type] = ()) -> bytes:
    """Return plain data as bytes; raise `NotPlain` for other data."""
    packer = _Packer({kind: kind.__name__ for kind in classes})
    header = json.dumps(packer.node(thing), separators=(",", ":")).encode()
    return b"".join([len(header).to_bytes(LENGTH, "little"), header, *packer.blobs])


def unpack(data: bytes, classes: Iterable[type] = ()) -> Any:
    """Return the data in bytes of `pack`; raise `NotPlain` for other bytes."""
    try:
        end = LENGTH + int.from_bytes(data[:LENGTH], "little")
        reader = _Reader(data[end:], {kind.__name__: kind for kind in classes})
        return reader.thing(json.loads(data[LENGTH:end]))
    except NotPlain:
        raise
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError) as error:
        raise NotPlain(f"{type(error).__name__}: {error}") from None


def attributes(thing: Any) -> dict[str, Any]:
    """Return the attributes of an object, or the members of a named tuple."""
    return dict(zip(thing._fields, thing)) if hasattr(thing, "_fields") else vars(thing)


def _order(array):
    """Return the memory order: "C" if the last index runs fastest, "F" if the first does.

    The last bits of matrix products depend on it.
    """
    steps = [abs(step) for step in array.strides]
    return "F" if len(steps) > 1 and steps[0] < steps[-1] else "C"


class _Packer:
    def __init__(self, names):
        self.names, self.blobs, self.size = names, [], 0

    def node(self, thing):
        """Return the header's node of a value, and append its blobs."""
        if thing is None or type(thing) in (bool, int, float, str):
            return thing
        if type(thing) is list:
            return [self.node(entry) for entry in thing]
        if type(thing) is tuple:
            return {"tuple": [self.node(entry) for entry in thing]}
        if type(thing) is dict:
            return {"dict": [[self.node(key), self.node(value)] for key, value in thing.items()]}
        if type(thing) is bytes:
            return {"bytes": self._blob(thing)}
        if type(thing) is slice:
            return {"slice": [self.node(end) for end in (thing.start, thing.stop, thing.step)]}
        if isinstance(thing, np.ndarray | np.generic):
            return self._array(thing)
        if type(thing) in self.names:
            content = {name: self.node(value) for name, value in attributes(thing).items()}
            return {"class": self.names[type(thing)], "attributes": content}
        raise NotPlain(f"{type(thing).__name__} is not plain data")

    def _array(self, thing):
        if thing.dtype.kind not in NUMBERS:
            raise NotPlain(f"an array of {thing.dtype} is not plain data")
        kind = "array" if isinstance(thing, np.ndarray) else "scalar"
        order = _order(thing)
        blob = self._blob(thing.tobytes(order))
        node = {kind: blob, "dtype": thing.dtype.str, "shape": list(thing.shape)}
        return node | {"order": order}

    def _blob(self, data):
        self.blobs.append(data)
        self.size += len(data)
        return [self.size - len(data), len(data)]


class _Reader:
    def __init__(self, blobs, classes):
        self.blobs, self.classes = blobs, classes

    def thing(self, node):
        """Return the value of a node of the header."""
        if isinstance(node, list):
            return [self.thing(entry) for entry in node]
        if not isinstance(node, dict):
            return node
        if "tuple" in node:
            return tuple(self.thing(entry) for entry in node["tuple"])
        if "dict" in node:
            return {self.thing(key): self.thing(value) for key, value in node["dict"]}
        if "bytes" in node:
            return self._blob(node["bytes"])
        if "slice" in node:
            return slice(*(self.thing(end) for end in node["slice"]))
        if "class" in node:
            return self._object(node)
        return self._array(node)

    def _object(self, node):
        kind: Any = self.classes[node["class"]]
        content = {name: self.thing(value) for name, value in node["attributes"].items()}
        if (names := getattr(kind, "_fields", None)) is not None:
            return kind(*(content[name] for name in names))
        if any(name.startswith("__") for name in content):
            raise NotPlain(f"{node['class']} with an attribute of Python's own")
        instance = object.__new__(kind)
        vars(instance).update(content)
        return instance

    def _array(self, node):
        dtype = np.dtype(str(node["dtype"]))
        if dtype.kind not in NUMBERS:
            raise NotPlain(f"an array of {dtype} is not plain data")
        if any(size < 0 for size in node["shape"]):
            raise NotPlain(f"an array of shape {node['shape']}")
        data = self._blob(node["array"] if "array" in node else node["scalar"])
        order = "F" if node["order"] == "F" else "C"
        array = np.frombuffer(data, dtype).reshape(node["shape"], order=order).copy(order)
        return array if "array" in node else array[()]

    def _blob(self, reference):
        begin, size = reference
        if not 0 <= begin <= begin + size <= len(self.blobs):
            raise NotPlain("a reference leads out of the data")
        return self.blobs[begin : begin + size]
