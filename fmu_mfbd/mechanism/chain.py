"""A chain of bodies as tables: what hangs where, its inertia, and the forces between its bodies.

Each body hangs on one before it, or on the block, by a joint. A joint is tied or slides along
directions, each with a coordinate: two for the play in a film. The angle of a body is driven, a
coordinate, their sum, or that of a rod that swings.
Films, gas and springs close no loop: they are forces between two bodies.

All tables are arrays over bodies or force elements. Code that is compiled for one chain serves
every other, and `master.fmi.block.flatten` packs a chain into one row of memory.
"""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..dynamics.floating_frame import FlexibleBody
from ..dynamics.modal_damping import ModalSprings
from ..dynamics.pin_friction import PinFriction
from ..geometry.arrays import Matrix, Numbers, Vector

BLOCK = -1
"""Number of the block among the bodies."""

NONE = -1
"""Number of a coordinate that does not exist."""

IN_BLOCK, IN_PARENT = 0, 1
"""Axes of a slide, see `Joints.turns`."""

NO_MOUNTS = np.zeros((3, 3, 3))
NO_SPRINGS = ModalSprings(np.zeros(0), np.zeros(0))

SMOOTH = PinFriction(0.0, 0.0, 0.0)
"""Friction of a joint that has none."""

LEVER, VISCOUS = map(PinFriction._fields.index, ("lever", "viscous"))
"""Columns of `Joints.friction`."""


class Bodies(NamedTuple):
    """Inertia integrals (Eq. (J7)) and modal springs of n bodies, their k modes stacked.

    After them there are s modes with the inertia of their own motion alone, as those of shells and
    journals. The first r of them deflect the last body: the motion of its frame loads them, but
    their deflection changes none of its integrals.

    Parameters
    ----------
    mass, I0 : ndarray, shape (n,)
        Mass [kg], moment of inertia about the body's origin [kg m2].
    S : ndarray, shape (n, 2)
        First moment about the origin [kg m].
    first_mode, first_entry : ndarray, shape (n + 1,)
        First mode of each body, first entry of it in `coupling`, and the numbers of both.
    T : ndarray, shape (2, k + r)
        Change of the first moments with the modes [kg^1/2].
    b, g : ndarray, shape (k + r,)
        Change of half the moment of inertia, angular momentum of the modes [kg^1/2 m].
    coupling : ndarray, shape (entries,)
        B and below it G of each body, which has 2 j j entries for j modes [-].
    stiffness, damping : ndarray, shape (k + s,)
        omega^2 [rad2/s2], 2 zeta omega [rad/s].
    """

    mass: Vector
    I0: Vector
    S: Matrix
    first_mode: Numbers
    first_entry: Numbers
    T: Matrix
    b: Vector
    g: Vector
    coupling: Vector
    stiffness: Vector
    damping: Vector


class Joints(NamedTuple):
    """Joints of n bodies with m coordinates and t slides; see `Link` and `Slide`.

    Parameters
    ----------
    parent, angle : ndarray, shape (n,)
        Numbers of a body and of a coordinate.
    first_slide : ndarray, shape (n + 1,)
        First slide of each joint, and their number.
    slide, turns : ndarray, shape (t,)
        Coordinate of each slide, and `IN_PARENT` if its direction turns with the parent, else
        `IN_BLOCK`.
    way : ndarray, shape (t, 2)
        Direction [-].
    marker : ndarray, shape (n, 2)
        [m]
    driven : ndarray, shape (n,)
        [-]
    held : ndarray, shape (n,)
        Number of the body at the tip of a rod that swings, `NONE` of any other body.
    offset : ndarray, shape (n,)
        x of the tip if all coordinates are 0 [m].
    tip : ndarray, shape (n, m)
        Factor of each coordinate in x of the tip [-].
    friction : ndarray, shape (n, 3)
        A `PinFriction` of each.
    """

    parent: Numbers
    angle: Numbers
    first_slide: Numbers
    slide: Numbers
    turns: Numbers
    way: Matrix
    marker: Matrix
    driven: Vector
    held: Numbers
    offset: Vector
    tip: Matrix
    friction: Matrix


class Elements(NamedTuple):
    """Bodies and points of e force elements; see `Element`.

    Parameters
    ----------
    acts, reacts, carrier, axes : ndarray, shape (e,)
        Numbers of bodies.
    play, mode, modes, shape, shapes : ndarray, shape (e,)
        First coordinates, and how many.
    marker, point : ndarray, shape (e, 2)
        [m]
    at_point : ndarray, shape (e,)
        1 if the moment of the force is about the point, 0 if it is about the marker [-].
    """

    acts: Numbers
    reacts: Numbers
    carrier: Numbers
    axes: Numbers
    play: Numbers
    mode: Numbers
    modes: Numbers
    shape: Numbers
    shapes: Numbers
    marker: Matrix
    point: Matrix
    at_point: Vector


class Laws(NamedTuple):
    """Laws of the last f force elements, whose force depends on the motion of their bodies.

    Parameters
    ----------
    kind : ndarray, shape (f,)
        Number in `FORCE_ELEMENTS`.
    zero : ndarray, shape (f, 2)
        Reference point in the axes of the body of the reaction [m].
    numbers : ndarray, shape (f, p)
        Parameters of each, and zeros after them.
    """

    kind: Numbers
    zero: Matrix
    numbers: Matrix


NO_LAWS = Laws(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros((0, 0)))


class Chain(NamedTuple):
    """Bodies, joints and force elements, and the block that they hang on.

    The coordinates are those of joints and block (m), then all modes (k).

    Parameters
    ----------
    bodies : Bodies
    joints : Joints
    elements : Elements
    laws : Laws
    block : int
        First of the block's coordinates: x, y of the origin and the angle. `NONE`: its motion is
        given.
    mounts : ndarray, shape (3, 3, 3)
        Mass, damping and stiffness matrices of the block on its mounts [SI].
    """

    bodies: Bodies
    joints: Joints
    elements: Elements
    laws: Laws
    block: int
    mounts: Annotated[np.ndarray, "3, 3, 3"]


class Loads(NamedTuple):
    """Forces of all elements, and forces on modes.

    Parameters
    ----------
    wrench : ndarray, shape (e, 4)
        Force on the body that the element acts on, in the block's axes [N], its moment about the
        element's marker, or its point, and the moment of the reaction about its point [N m].
    modal : ndarray, shape (k,)
        [kg^-1/2 N]
    slopes : ndarray, shape (s,)
        Moment on the body that an element acts on, its opposite on the other one, by each mode of
        each element [kg^-1/2 N].
    on_shapes : ndarray, shape (e, n, 2)
        Part of `modal` on the shapes of each element, along x and y of the block [kg^-1/2 N].
    law_slopes : ndarray, shape (f, 3, 6)
        Change of the force of each law with the position and angle of its point, and with their
        rates, in the block's axes.
    """

    wrench: Matrix
    modal: Vector
    slopes: Vector = np.zeros(0)
    on_shapes: Annotated[np.ndarray, "e, n, 2"] = np.zeros((0, 0, 2))
    law_slopes: Annotated[np.ndarray, "f, 3, 6"] = np.zeros((0, 3, 6))


# ---- construction by name


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
    """A force between two bodies, or a body and the block.

    Its force and moments are inputs (`Loads`), for example the sum of the nodal forces of a film,
    or they have a law.
    This tells the tangent how they follow the motion.

    Parameters
    ----------
    acts, reacts : int
        Numbers of the bodies on which force and reaction act, or `BLOCK` for the second.
    carrier, axes : int
        Body that the point of the reaction moves with, and body that the force turns with.
    marker, point : tuple of float
        Centres of the moments of force and reaction, in the axes of `acts` and `carrier` [m].
    play : int
        First of two coordinates, the position of the marker from the point, or `NONE`.
    mode, modes : int
        First coordinate of the modes that change the moments (`Loads.slopes`), and their number.
    shape, shapes : int
        First coordinate of the bending shapes of `acts` along x, and their number. Those along y
        follow. Both are displacements in the block's axes.
    at_point : bool
        Whether the moment of the force is about the point instead of the marker.
    """

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


@compilable
def put_tips(joints: Joints, guide: np.ndarray) -> None:
    """Write the x of the tips of all rods that swing; `guide` is a coordinate of each body.

    Eq. (K66):  x_T = x_G - sum v_x      v the slides of all joints from the tip to the guided body
                                         G, in the block's axes
    """
    for g in range(len(guide)):
        b = g if guide[g] >= 0 else NONE
        row = np.zeros(joints.tip.shape[1])
        while b >= 0:
            for k in range(joints.first_slide[b], joints.first_slide[b + 1]):
                if joints.turns[k] == IN_BLOCK:
                    row[joints.slide[k]] -= joints.way[k, 0]  # Eq. (K66)
            p = joints.parent[b]
            if p >= 0 and joints.held[p] == b:
                row[guide[g]] += 1.0
                for j in range(len(row)):
                    joints.tip[p, j] = row[j]
                joints.offset[p] = joints.offset[g]
                break
            b = p


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
    block: int = NONE,
    mounts: np.ndarray = NO_MOUNTS,
    springs: ModalSprings = NO_SPRINGS,
    laws: Laws = NO_LAWS,
) -> Chain:
    """Return the chain of bodies and force elements with m coordinates of joints and block.

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
        way=real(slides, "way", (2,)),
        held=np.array([parents.index(k) if one.swings else NONE for k, one in enumerate(links)]),
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
    return Chain(bodies, joints, table, laws, block, mounts)
