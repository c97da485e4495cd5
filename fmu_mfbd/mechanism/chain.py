"""A chain of bodies as tables: joints, inertia, and the forces between the bodies.

A joint connects each body with its parent, which is an earlier body or the block. A joint is tied,
or it slides in directions that have a coordinate each, for example two for the play in a film. The
angle of a body is driven, a coordinate, the sum of both, or that of a rod that swings. Films, gas
and springs are forces between two bodies, so the chain has no loop.

All tables are arrays over bodies or force elements. Code that is compiled for one chain serves
every other, and `master.fmi.block.flatten` packs a chain into one row of memory.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Matrix, Numbers, Vector

BLOCK = -1
"""Number of the block among the bodies."""

NONE = -1
"""Number of a coordinate that does not exist."""

IN_BLOCK, IN_PARENT = 0, 1
"""Axes of a slide, see `Joints.turns`."""

MOMENT, REACTION = 2, 3
"""Columns of `Loads.wrench` after the force."""


class Bodies(NamedTuple):
    """Inertia integrals (Eq. (J7)) and modal springs of n bodies, their k modes stacked.

    Then follow s modes that have only the inertia of the modal motion, for example those of shells
    and journals. The first r of them deflect the last body. The motion of its frame loads them, but
    they do not change its integrals.

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
    """Joints of n bodies with m coordinates and t slides.

    Parameters
    ----------
    parent : ndarray, shape (n,)
        Number of the parent of each body, or `BLOCK`.
    angle : ndarray, shape (n,)
        Coordinate of the body's angle [rad], or `NONE`; bodies may share one.
    first_slide : ndarray, shape (n + 1,)
        First slide of each joint, and their number. A joint without slides is tied.
    slide, turns : ndarray, shape (t,)
        Coordinate of each slide, the displacement for a direction of length 1 [m], and `IN_PARENT`
        if the direction turns with the parent, else `IN_BLOCK`.
    direction : ndarray, shape (t, 2)
        Direction [-].
    marker : ndarray, shape (n, 2)
        Position of the joint in the parent's axes [m].
    driven : ndarray, shape (n,)
        1 if the drive's angle is added to that of the body, else 0 [-].
    tip_body : ndarray, shape (n,)
        Number of the body at the tip of a rod that swings, `NONE` of any other body. The angle of
        the rod follows from x of its tip, which is within 90 deg of y of the block.
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
    direction: Matrix
    marker: Matrix
    driven: Vector
    tip_body: Numbers
    offset: Vector
    tip: Matrix
    friction: Matrix


class Elements(NamedTuple):
    """Bodies and points of e force elements between two bodies, or a body and the block.

    Force and moments are inputs (`Loads`), for example the sum of the nodal forces of a film, or
    they have a law. The tangent needs these tables for the dependence of forces on the motion.

    Parameters
    ----------
    acts, reacts : ndarray, shape (e,)
        Numbers of the bodies on which force and reaction act, or `BLOCK` for the second.
    carrier, axes : ndarray, shape (e,)
        Body that the point of the reaction moves with, and body that the force turns with.
    play : ndarray, shape (e,)
        First of two coordinates, the position of the marker from the point, or `NONE`.
    mode, modes : ndarray, shape (e,)
        First coordinate of the modes that change the moments (`Loads.slopes`), and their number.
    shape, shapes : ndarray, shape (e,)
        First coordinate of the bending shapes of `acts` along x, and their number. Those along y
        follow. Both are displacements in the block's axes.
    marker, point : ndarray, shape (e, 2)
        Centres of the moments of force and reaction, in the axes of `acts` and `carrier` [m].
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


class Chain(NamedTuple):
    """Bodies, joints and force elements.

    The coordinates are those of joints (m), then all modes (k).

    Parameters
    ----------
    bodies : Bodies
    joints : Joints
    elements : Elements
    laws : Laws
    """

    bodies: Bodies
    joints: Joints
    elements: Elements
    laws: Laws


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
                    row[joints.slide[k]] -= joints.direction[k, 0]  # Eq. (K66)
            p = joints.parent[b]
            if p >= 0 and joints.tip_body[p] == b:
                row[guide[g]] += 1.0
                for j in range(len(row)):
                    joints.tip[p, j] = row[j]
                joints.offset[p] = joints.offset[g]
                break
            b = p
