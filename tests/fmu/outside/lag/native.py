"""The same lag as machine code."""

from typing import Annotated, NamedTuple

import numpy as np

from piston_cosim.master.fmi.block import memory_of, parts
from piston_cosim.master.fmi.compiled import compiled
from piston_cosim.master.fmi.native_parts import NativePart
from piston_cosim.master.fmi.noted import ROOM, refuse
from piston_cosim.master.fmi.slave import PRODUCT, SEED, reserved

Vector = Annotated[np.ndarray, "n"]


class Parts(NamedTuple):
    """Memory: positions of the variables, state, slope of the last step, faults."""

    places: Vector
    state: Vector
    slope: Vector
    faults: Vector


parts_of = parts(Parts)


class Places(NamedTuple):
    """Positions of the variables."""

    gain: int
    longest: int
    u: int
    load: int
    x: int
    seed: int
    product: int


@compiled
def places_of(memory):
    gain, longest, u, load, x, seed, product = parts_of(memory).places
    return Places(int(gain), int(longest), int(u), int(load), int(x), int(seed), int(product))


@compiled
def start(real, integer, memory, numbers):
    parts = parts_of(memory)
    parts.faults[0] = 0.0
    parts.state[0] = 1.0
    real[places_of(memory).x] = 1.0


@compiled
def advance(real, integer, memory, numbers):
    parts, places = parts_of(memory), places_of(memory)
    step, gain, slope = numbers[0], real[places.gain], np.tanh(real[places.u])
    parts.faults[0] = 0.0
    if step > real[places.longest]:
        refuse(parts.faults, 0.0, 0.0, 0.0, step, 0.0, 0.0)
        return
    parts.state[0] = (parts.state[0] + step * (gain * slope + real[places.load])) / (1.0 + step)
    parts.slope[0] = step * gain * (1.0 - slope * slope) / (1.0 + step)
    real[places.x] = parts.state[0]


@compiled
def tangent(real, integer, memory, numbers):
    parts, places = parts_of(memory), places_of(memory)
    parts.faults[0] = 0.0
    real[places.product] = parts.slope[0] * real[places.seed]


def given(slave):
    """Return the first part of the memory."""
    names = ("gain", "longest", "u", "load", "x", reserved(SEED, "u"), reserved(PRODUCT, "x"))
    places = np.array([slave.references[name] for name in names], float)
    return memory_of({"places": places}, dict(state=1, slope=1, faults=ROOM))


PART = NativePart(
    (start, advance, tangent),
    given,
    ("step of {a} s is too long",),
    "",
)
