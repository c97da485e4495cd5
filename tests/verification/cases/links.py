"""Chains of bodies by name, instead of tables."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from piston_cosim.fmu_mfbd.mechanism.chain import (
    BLOCK,
    IN_BLOCK,
    NONE,
    Bodies,
    Chain,
    Elements,
    Joints,
    Laws,
    put_tips,
)
from piston_cosim.fmu_mfbd.mechanism.floating_frame import FlexibleBody
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Coefficients
from piston_cosim.fmu_mfbd.mechanism.modal_damping import ModalSprings
from piston_cosim.fmu_mfbd.mechanism.motion import Increments
from piston_cosim.fmu_mfbd.mechanism.pin_friction import PinFriction

NO_SPRINGS = ModalSprings(np.zeros(0), np.zeros(0))
NO_LAWS = Laws(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros((0, 0)))

SMOOTH = PinFriction(0.0, 0.0, 0.0)
"""Friction of a joint that has none."""


class Slide(NamedTuple):
    """A direction along which a body moves in its joint.

    Parameters
    ----------
    coordinate : int
        Displacement of the body along it, for a direction of length 1 [m].
    way : tuple of float
        Direction [-].
    turns : int
        `IN_PARENT` if the direction turns with the parent, `IN_BLOCK` if it does not.
    """

    coordinate: int
    way: tuple[float, float]
    turns: int = IN_BLOCK


def play(first: int, sign: float = 1.0) -> tuple[Slide, ...]:
    """Return the slides of a joint with a film: two coordinates from `first` on, none if `NONE`.

    The coordinates are the position of the body in the joint in the block's axes, or, with the sign
    -1, that of the joint in the body.
    """
    if first < 0:
        return ()
    return Slide(first, (sign, 0.0)), Slide(first + 1, (0.0, sign))


class Link(NamedTuple):
    """A body and its joint.

    Parameters
    ----------
    body : FlexibleBody
        Its integrals refer to its origin, where it hangs.
    parent : int
        Number of the body that it hangs on, or `BLOCK`.
    marker : tuple of float
        Position of the joint in the parent's axes [m].
    slides : tuple of Slide
        Tied if empty.
    angle : int
        Coordinate of the body's angle [rad]; bodies may share one.
    driven : bool
        Whether the drive's angle is added to it.
    swings : bool
        Whether its angle follows from x of its tip, the joint of the first body that hangs on it.
        The tip is within 90 deg of y of the block.
    guide : int
        Coordinate of x of the origin of a body that hangs on a rod that swings, or on a body on it.
    offset : float
        x of the origin of a guided body if this coordinate is 0 [m].
    friction : PinFriction
        Of the joint of a body that is no rod that swings.
    """

    body: FlexibleBody
    parent: int
    marker: tuple[float, float] = (0.0, 0.0)
    slides: tuple[Slide, ...] = ()
    angle: int = NONE
    driven: bool = False
    swings: bool = False
    guide: int = NONE
    offset: float = 0.0
    friction: PinFriction = SMOOTH


class Element(NamedTuple):
    """A force between two bodies, or a body and the block, as a row of `Elements`."""

    acts: int
    reacts: int = BLOCK
    carrier: int = BLOCK
    axes: int = BLOCK
    marker: tuple[float, float] = (0.0, 0.0)
    point: tuple[float, float] = (0.0, 0.0)
    play: int = NONE
    mode: int = 0
    modes: int = 0
    shape: int = 0
    shapes: int = 0
    at_point: bool = False


NUMBERS = ("acts", "reacts", "carrier", "axes", "play", "mode", "modes", "shape", "shapes")
"""Members of `Element` that are whole numbers."""


def stack_bodies(bodies: Sequence[FlexibleBody], springs: ModalSprings = NO_SPRINGS) -> Bodies:
    """Return the tables of bodies and of modes with the inertia of their own motion alone."""
    modes = [len(body.stiffness) for body in bodies]
    coupling = [np.concatenate([body.B.ravel(), body.G.ravel()]) for body in bodies]

    def stacked(name, *more):
        parts = [*(getattr(body, name) for body in bodies), *more]
        return np.ascontiguousarray(np.concatenate(parts, axis=-1))

    tables = {
        name: np.array([getattr(body, name) for body in bodies]) for name in ("mass", "I0", "S")
    }
    tables |= {name: stacked(name) for name in ("T", "b", "g")}
    tables |= {name: stacked(name, getattr(springs, name)) for name in ModalSprings._fields}
    return Bodies(
        first_mode=np.cumsum([0, *modes], dtype=np.int64),
        first_entry=np.cumsum([0, *(len(one) for one in coupling)], dtype=np.int64),
        coupling=np.concatenate(coupling),
        **tables,
    )


def chain_of(
    links: Sequence[Link],
    elements: Sequence[Element] = (),
    coordinates: int = 0,
    springs: ModalSprings = NO_SPRINGS,
    laws: Laws = NO_LAWS,
) -> Chain:
    """Return the chain of bodies and force elements with m coordinates of joints.

    Raises
    ------
    ValueError
        Lists every link that hangs on none before it, and every number out of range.
    """
    faults = []
    for k, link in enumerate(links):
        if not BLOCK <= link.parent < k:
            faults.append(f"link {k}: expected a parent from -1 to {k - 1}, got {link.parent}")
        numbers = [("slide", one.coordinate, 0) for one in link.slides]
        numbers += [("angle", link.angle, NONE), ("guide", link.guide, NONE)]
        for name, number, least in numbers:
            if not least <= number < coordinates:
                span = f"from {least} to {coordinates - 1}"
                faults.append(f"link {k}: expected {name} {span}, got {number}")
        hanging = [one for one in links if one.parent == k]
        if link.swings and (link.angle != NONE or not hanging):
            faults.append(f"link {k}: expected a body on a rod that swings, and no angle of it")
    for k, element in enumerate(elements):
        numbers = element[:4]
        if min(numbers) < BLOCK or max(numbers) >= len(links) or element.acts == BLOCK:
            faults.append(f"element {k}: expected bodies below {len(links)}, got {numbers}")
    if faults:
        raise ValueError("\n".join(faults))

    def whole(rows, name):
        return np.array([getattr(row, name) for row in rows], dtype=np.int64)

    def real(rows, name, shape=()):
        return np.array([getattr(row, name) for row in rows], dtype=float).reshape(-1, *shape)

    slides = [one for link in links for one in link.slides]
    parents = [link.parent for link in links]
    pairs = {"marker": real(links, "marker", (2,)), "friction": real(links, "friction", (3,))}
    joints = Joints(
        first_slide=np.cumsum([0, *(len(link.slides) for link in links)], dtype=np.int64),
        slide=whole(slides, "coordinate"),
        turns=whole(slides, "turns"),
        direction=real(slides, "way", (2,)),
        tip_body=np.array(
            [parents.index(k) if one.swings else NONE for k, one in enumerate(links)]
        ),
        tip=np.zeros((len(links), coordinates)),
        **pairs,
        **{name: whole(links, name) for name in ("parent", "angle")},
        **{name: real(links, name) for name in ("driven", "offset")},
    )
    put_tips(joints, whole(links, "guide"))
    numbers = {name: whole(elements, name) for name in NUMBERS}
    points = {name: real(elements, name, (2,)) for name in ("marker", "point")}
    table = Elements(**numbers, **points, at_point=real(elements, "at_point"))
    bodies = stack_bodies([link.body for link in links], springs)
    return Chain(bodies, joints, table, laws)


def increments_of(c: Coefficients, n: int) -> Increments:
    """Return those of n coordinates with their end accelerations in a step (Eq. (N2))."""
    return Increments(np.full(n, c.to_position), np.full(n, c.to_velocity), np.ones(n))
