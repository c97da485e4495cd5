"""Plain data as bytes: everything comes back to the bit, and nothing in the bytes is called."""

import json
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from piston_cosim.master.participants.plain import LENGTH, NotPlain, pack, unpack


class Point(NamedTuple):
    x: float
    y: np.ndarray


@dataclass
class Thing:
    name: str
    points: list


class Loud:
    """Complains when it is made the usual way."""

    def __init__(self):
        raise AssertionError


KEYS = st.one_of(st.integers(), st.text(max_size=5), st.booleans())
DATA = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.text(max_size=10),
        st.binary(max_size=10),
        st.builds(slice, st.none() | st.integers(), st.integers()),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.lists(inner, max_size=4).map(tuple),
        st.dictionaries(KEYS, inner, max_size=4),
    ),
    max_leaves=20,
)


@given(DATA)
@settings(max_examples=60, deadline=None)
def test_plain_data_comes_back(data):
    again = unpack(pack(data))
    assert repr(again) == repr(data)  # tells 1 from True and 1.0, and -0.0 from 0.0
    assert pack(again) == pack(data)


@pytest.mark.parametrize("dtype", ["f8", "f4", "i8", "u1", "?", "c16", ">f8"])
@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 3)])
def test_arrays_come_back_to_the_bit(dtype, shape):
    array = np.full(shape, np.pi).astype(dtype)
    again = unpack(pack({"a": array, "after": b"x"}))["a"]
    assert (again.dtype, again.shape) == (array.dtype, shape)
    assert again.tobytes() == array.tobytes() and again.flags.writeable
    scalar = unpack(pack(np.float32(0.1)))
    assert type(scalar) is np.float32 and scalar == np.float32(0.1)


def test_arrays_keep_their_order_in_memory():
    random = np.random.default_rng(0)
    array = random.standard_normal((5, 7))
    for one in (array, array.T, array[:, ::2], array.T[1:3]):
        other = unpack(pack(one))
        assert np.array_equal(one, other)
        assert other.flags.f_contiguous == (abs(one.strides[0]) < abs(one.strides[1]))


def test_objects_of_named_classes_come_back_without_being_called():
    thing = Thing("a", [Point(1.0, np.arange(3.0))])
    again = unpack(pack(thing, (Thing, Point)), (Thing, Point))
    assert type(again) is Thing and type(again.points[0]) is Point
    assert again.points[0].y.tolist() == [0.0, 1.0, 2.0]
    loud = object.__new__(Loud)
    loud.x = 1
    assert unpack(pack(loud, (Loud,)), (Loud,)).x == 1
    with pytest.raises(NotPlain):
        unpack(pack(thing, (Thing, Point)), (Thing,))


@pytest.mark.parametrize("thing", [object(), print, Thing("a", []), np.array([None]), {1, 2}])
def test_anything_else_is_refused(thing):
    with pytest.raises(NotPlain):
        pack(thing)


def crafted(header, blobs=b""):
    text = json.dumps(header).encode()
    return len(text).to_bytes(LENGTH, "little") + text + blobs


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"nonsense",
        crafted({"class": "Popen", "attributes": {}}),
        crafted({"class": "Thing", "attributes": {"__class__": 1}}),
        crafted({"class": "Point", "attributes": {}}),
        crafted({"bytes": [0, 1]}),
        crafted({"bytes": [-1, 1]}, b"abc"),
        crafted({"bytes": [2**80, 1]}, b"abc"),
        crafted({"array": [0, 8], "dtype": "O", "shape": [1], "order": "C"}, bytes(8)),
        crafted({"array": [0, 8], "dtype": "f8", "shape": [2], "order": "C"}, bytes(8)),
        crafted({"array": [0, 8], "dtype": "f8", "shape": [-1], "order": "C"}, bytes(8)),
        crafted({"array": [0, 8], "dtype": "f8,O", "shape": [1], "order": "C"}, bytes(8)),
        crafted({"dict": [[[1], 2]]}),
        crafted({"dict": 1}),
        crafted({}),
        (5).to_bytes(LENGTH, "little") + b"[[[[[",
    ],
)
def test_crafted_bytes_are_refused(data):
    with pytest.raises(NotPlain):
        unpack(data, (Thing, Point))


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_flipped_bytes_give_a_sentence_or_other_data(data):
    whole = bytearray(pack({"a": [1.0, (b"bytes", None)], "b": np.arange(4.0)}))
    place = data.draw(st.integers(0, len(whole) - 1))
    whole[place] ^= data.draw(st.integers(1, 255))
    try:
        unpack(bytes(whole))
    except NotPlain:
        pass
