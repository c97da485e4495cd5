"""The chain of one cylinder: crank, rod, pin and piston, and the films between them.

A tied pin is part of the rod. The coordinates have this order:

1. x_A and the rocking angle
2. for a floating pin, the coordinates `PIN`
3. with a film of the crank pin, its position in the rod's big end (x, y)
4. with a film of the journal, its position in the main bearing (x, y)
5. modes of the piston, those with inertia first
6. modes of the block
7. shapes of the pin along x, then along y
8. modes of small end, big end and main bearing

Relative coordinates keep the digits of a pin that moves by micrometres in its films. They also keep
the rod on the crank without a constraint that could drift. Modes of shells have only the inertia of
the modal motion (Eq. (D40)), in the axes of rod and block, because these bodies already contain the
mass of the shells. The inertia of the small end of `yielding_bosses` at 6700 m/s2 bends it by 0.9
um, and a film under 25 kN by 20 to 60 um (`tests/bench/small_end.py`).
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.pin import PIN_SURFACES
from .bdf2 import BY_BDF2, STATIC
from .carrier import FIXED
from .chain import BLOCK, IN_BLOCK, NONE, Bodies, Chain, Elements, Joints, Laws, put_tips
from .derivative import chain_derivative
from .equations import chain_forces
from .floating_frame import ArrowMatrix, FlexibleBody, X, Y
from .generalised_alpha import Motion
from .loads import no_loads
from .modal_damping import ModalSprings
from .motion import Increments
from .pin_friction import put_pin_friction
from .piston_motion import LATERAL, RIGID, ROCKING
from .slider_crank import CrankMotion, Mechanism

NO_ELEMENTS = np.zeros(0, np.int64)
EYE = PIN_SURFACES.index("small_end")
"""Number of the eye's film; those of the bosses come before it, those of the crank after."""


class CylinderBodies(NamedTuple):
    """Numbers of the bodies of a cylinder; the pin is one if it floats, the piston is the last."""

    crank: int = 0
    rod: int = 1
    pin: int = 2


BODY = CylinderBodies()


class PinCoordinates(NamedTuple):
    """Numbers of the coordinates of a floating pin.

    Positions of its axis, along x and y of the block: from the axis of the piston's bosses and from
    that of the rod's eye [m]. The last is its angle about +z [rad].
    """

    boss_x: int = RIGID
    boss_y: int = RIGID + 1
    eye_x: int = RIGID + 2
    eye_y: int = RIGID + 3
    spin: int = RIGID + 4


PIN = PinCoordinates()
COORDINATES = PIN.spin + 1
"""Those of a floating pin without films of the crank and modes."""


class CylinderLaws(NamedTuple):
    """Force elements of a cylinder that depend on its motion.

    Parameters
    ----------
    kind : ndarray, shape (f,)
        Number in `FORCE_ELEMENTS`.
    acts, reacts : ndarray, shape (f,)
        Number in `force_elements.element.BODIES`, or `BLOCK`.
    height : ndarray, shape (f,)
        y of the point from the reference point of its body [m].
    numbers
        As of `chain.Laws`.
    """

    kind: np.ndarray
    acts: np.ndarray
    reacts: np.ndarray
    height: np.ndarray
    numbers: np.ndarray


class FreeSlides(NamedTuple):
    """Slides of joints that are tied otherwise.

    Parameters
    ----------
    acts : ndarray, shape (r,)
        Number in `force_elements.element.BODIES` of the body whose joint it is.
    turns, direction
        As of `chain.Joints`.
    """

    acts: np.ndarray
    turns: np.ndarray
    direction: np.ndarray


NO_SLIDES = FreeSlides(NO_ELEMENTS, NO_ELEMENTS, np.zeros((0, 2)))


class CylinderParts(NamedTuple):
    """Parts of the chain of a cylinder.

    Parameters
    ----------
    piston : FlexibleBody
    moving : int
        Number of its first modes, which have inertia.
    mechanism : Mechanism
    spin_inertia : float
        Moment of inertia of the pin about its axis [kg m2].
    crank_mass : float
        Mass that moves with the journal in the main bearing [kg].
    unbalance : float
        Unbalance of the crank: mass times distance towards the crank pin [kg m].
    floats, big_end, main_bearing : bool
        Which of pin, big end and main bearing have films.
    springs : ModalSprings
        Springs of the modes of the block, of the pin's shapes and of the modes of all shells.
    block_modes, block_static : int
        Number of modes of the block, and of those without inertia at their end.
    shapes, big_end_modes, main_bearing_modes : int
        Number of shapes along each axis, and of the last modes in `springs`.
    laws : CylinderLaws
    slides : FreeSlides
        Their coordinates are the last ones of joints.
    """

    piston: FlexibleBody
    moving: int
    mechanism: Mechanism
    spin_inertia: float
    crank_mass: float
    unbalance: float
    floats: bool
    big_end: bool
    main_bearing: bool
    springs: ModalSprings
    block_modes: int
    block_static: int
    shapes: int
    big_end_modes: int
    main_bearing_modes: int
    laws: CylinderLaws = CylinderLaws(
        NO_ELEMENTS, NO_ELEMENTS, NO_ELEMENTS, np.zeros(0), np.zeros((0, 0))
    )
    slides: FreeSlides = NO_SLIDES


@compilable
def cylinder_chain(c: CylinderParts) -> Chain:
    """Return the chain of a cylinder on a fixed block.

    Its elements are all films, skirt and gas, and those with laws.

    Eq. (K16):  x_S = x_A + a_x - e_x,   Y_A = Y_S + e_y - a_y,   x_P = x_A + a_x
                of the rod's eye S and the pin P: a = P - A from the bosses, e = P - S from the eye
    Eq. (K25):  O = m,   C = O + r u,   B = C - b,   u = (-sin phi, cos phi)
                of the crank's journal O, its pin C and the rod's big end B: m from the main
                bearing, b from the big end
    """
    plays = _plays_of(c)
    joints = _joints_of(c, plays)
    elements = _elements_of(c, plays, joints.tip.shape[1])
    laws = _put_laws(c, elements)
    return Chain(bodies=_bodies_of(c, 1.0), joints=joints, elements=elements, laws=laws)


@compilable
def _count(c):
    """Return the number of bodies."""
    return 4 if c.floats else 3


@compilable
def _bodies_of(c, of_rod):
    """Return the inertia of crank, rod, pin and piston, with a share of that of crank and rod."""
    n, k = _count(c), c.moving
    piston = n - 1
    rod, centre = of_rod * c.mechanism.rod_mass, c.mechanism.rod_centre * c.mechanism.rod_length
    masses, S, modes = np.zeros((2, n)), np.zeros((n, 2)), np.zeros((2, n + 1), np.int64)
    mass, I0 = masses[0], masses[1]
    mass[BODY.crank] = of_rod * c.crank_mass if c.main_bearing else 0.0
    S[BODY.crank, Y] = c.unbalance
    mass[BODY.rod], S[BODY.rod, Y] = rod, rod * centre
    I0[BODY.rod] = of_rod * c.mechanism.rod_inertia + rod * centre**2
    if c.floats:
        mass[BODY.pin], I0[BODY.pin] = c.mechanism.pin_mass, c.spin_inertia
    else:
        pin, length = c.mechanism.pin_mass, c.mechanism.rod_length
        mass[BODY.rod] += pin
        S[BODY.rod, Y] += pin * length
        I0[BODY.rod] += pin * length**2
    mass[piston], I0[piston] = c.piston.mass, c.piston.I0
    S[piston, X], S[piston, Y] = c.piston.S[X], c.piston.S[Y]
    modes[0, n], modes[1, n] = k, 2 * k * k
    return Bodies(
        mass=mass,
        I0=I0,
        S=S,
        first_mode=modes[0],
        first_entry=modes[1],
        T=c.piston.T.copy(),
        b=c.piston.b.copy(),
        g=c.piston.g.copy(),
        coupling=np.concatenate((c.piston.B[:k, :k], c.piston.G[:k, :k])).reshape(2 * k * k),
        stiffness=np.concatenate((c.piston.stiffness, c.springs.stiffness)),
        damping=np.concatenate((c.piston.damping, c.springs.damping)),
    )


@compilable
def _plays_of(c):
    """Return the first coordinate of the play in the joint of each body, `NONE` if it is tied."""
    out = np.full(_count(c), NONE)
    size = RIGID
    if c.floats:
        out[BODY.pin + 1], out[BODY.pin] = PIN.boss_x, PIN.eye_x
        size = COORDINATES
    if c.big_end:
        out[BODY.rod] = size
        size += 2
    if c.main_bearing:
        out[BODY.crank] = size
    return out


@compilable
def _joints_of(c, plays):
    """Return the joints of crank, rod, pin and piston. Each body is the parent of the next."""
    n = _count(c)
    piston = n - 1
    parent, angle = np.full(n, BLOCK), np.full(n, NONE)
    marker, driven, offset = np.zeros((n, 2)), np.zeros(n), np.zeros(n)
    tip_body, guide = np.full(n, NONE), np.full(n, NONE)
    for b in range(1, n):
        parent[b] = b - 1
    angle[piston] = ROCKING
    if c.floats:
        angle[BODY.pin] = PIN.spin
    driven[BODY.crank] = 1.0
    marker[BODY.rod, Y], marker[BODY.rod + 1, Y] = c.mechanism.crank_radius, c.mechanism.rod_length
    tip_body[BODY.rod], guide[piston], offset[piston] = BODY.rod + 1, LATERAL, c.mechanism.offset
    friction = np.zeros((n, 3))
    if not c.floats:
        put_pin_friction(friction[piston], c.mechanism.friction)
    first, slide, turns, direction = _slides_of(c.slides, plays)
    size = RIGID + len(slide) + c.floats
    out = Joints(
        parent=parent,
        angle=angle,
        first_slide=first,
        slide=slide,
        turns=turns,
        direction=direction,
        marker=marker,
        driven=driven,
        tip_body=tip_body,
        offset=offset,
        tip=np.zeros((n, size)),
        friction=friction,
    )
    put_tips(out, guide)
    return out


@compilable
def _slides_of(free, plays):
    """Return the first slide of each joint, and coordinate, axes and direction of all slides."""
    n, size = len(plays), RIGID + (1 if len(plays) > BODY.pin + 1 else 0)
    most = 2 * n + len(free.acts)
    first, slide, direction = (
        np.zeros(n + 1, np.int64),
        np.empty(most, np.int64),
        np.zeros((most, 2)),
    )
    turns = np.full(most, IN_BLOCK)
    for b in range(n):
        size += 2 if plays[b] >= 0 else 0
    for b in range(n):
        k = first[b]
        first[b + 1] = k
        if plays[b] < 0:
            for i in range(len(free.acts)):
                if min(free.acts[i], n - 1) == b:
                    j = first[b + 1]
                    slide[j], turns[j] = size + i, free.turns[i]
                    direction[j, X], direction[j, Y] = free.direction[i, X], free.direction[i, Y]
                    first[b + 1] = j + 1
        else:
            # Eqs. (K16), (K25)
            sign = -1.0 if b == n - 1 or b == BODY.rod else 1.0
            slide[k], slide[k + 1] = plays[b], plays[b] + 1
            direction[k, X], direction[k + 1, Y] = sign, sign
            first[b + 1] = k + 2
    last = first[n]
    return first, slide[:last].copy(), turns[:last].copy(), direction[:last].copy()


@compilable
def _elements_of(c, plays, first):
    """Return the force elements: films in the order of their surfaces, skirt, gas, and laws."""
    of_pin, piston = EYE + 1 if c.floats else 0, _count(c) - 1
    films = of_pin + c.big_end + c.main_bearing
    n = films + 2 + len(c.laws.kind)
    out = Elements(
        acts=np.full(n, piston),
        reacts=np.full(n, BLOCK),
        carrier=np.full(n, BLOCK),
        axes=np.full(n, BLOCK),
        play=np.full(n, NONE),
        mode=np.zeros(n, np.int64),
        modes=np.zeros(n, np.int64),
        shape=np.zeros(n, np.int64),
        shapes=np.zeros(n, np.int64),
        marker=np.zeros((n, 2)),
        point=np.zeros((n, 2)),
        at_point=np.zeros(n),
    )
    k = len(c.piston.stiffness)
    bent = first + k + c.block_modes
    eye = bent + 2 * c.shapes
    main = first + len(c.piston.stiffness) + len(c.springs.stiffness) - c.main_bearing_modes
    big_end = main - c.big_end_modes
    for e in range(films):
        if e < of_pin - 1:
            _put_film(out, e, BODY.pin, piston, plays[piston], first, k)
        elif e == of_pin - 1:
            _put_film(out, e, BODY.pin, BODY.rod, plays[BODY.pin], eye, big_end - eye)
            out.point[e, Y] = c.mechanism.rod_length
        elif e == of_pin and c.big_end:
            _put_film(out, e, BODY.crank, BODY.rod, plays[BODY.rod], big_end, c.big_end_modes)
            out.marker[e, Y] = c.mechanism.crank_radius
        else:
            _put_film(out, e, BODY.crank, BLOCK, plays[BODY.crank], main, c.main_bearing_modes)
        if e < of_pin:
            out.shape[e], out.shapes[e] = bent, c.shapes
    out.carrier[films] = piston
    out.point[films + 1, X], out.at_point[films + 1] = c.mechanism.offset, 1.0
    return out


@compilable
def _put_film(out, e, journal, shell, play, mode, modes):
    """Write a film between a journal and the shell that its forces turn with."""
    out.acts[e], out.reacts[e], out.carrier[e], out.axes[e] = journal, shell, shell, shell
    out.play[e], out.mode[e], out.modes[e] = play, mode, modes


@compilable
def _put_laws(c, out):
    """Write the last elements, which have laws, and return these."""
    n = len(c.laws.kind)
    zero = np.empty((n, 2))
    for k in range(n):
        e = len(out.acts) - n + k
        body, x, y = _reference(c, c.laws.acts[k])
        other, zero[k, X], zero[k, Y] = _reference(c, c.laws.reacts[k])
        out.acts[e], out.carrier[e], out.reacts[e], out.axes[e] = body, body, other, other
        out.marker[e, X], out.marker[e, Y] = x, y + c.laws.height[k]
        out.point[e, X], out.point[e, Y] = x, y + c.laws.height[k]
    return Laws(c.laws.kind, zero, c.laws.numbers)


@compilable
def _reference(c, body):
    """Return the number of a body and its reference point, as of `ForceElement`."""
    if body == BLOCK:
        return BLOCK, c.mechanism.offset, 0.0
    if body == BODY.crank:
        return BODY.crank, 0.0, c.mechanism.crank_radius
    if body == BODY.rod or (body == BODY.pin and not c.floats):
        return BODY.rod, 0.0, c.mechanism.rod_length
    return (BODY.pin if body == BODY.pin else _count(c) - 1), 0.0, 0.0


@compilable
def piston_of(chain: Chain) -> int:
    """Return the number of the piston, the last body."""
    return len(chain.bodies.mass) - 1


@compilable
def floats(chain: Chain) -> bool:
    """Return whether the pin floats."""
    return piston_of(chain) > BODY.pin


@compilable
def film_of(chain: Chain, shell: int) -> int:
    """Return the number of the film of the crank in the rod or the block, or `NONE`."""
    elements = chain.elements
    for e in range(len(elements.play)):
        of_crank = elements.acts[e] == BODY.crank and elements.reacts[e] == shell
        if of_crank and elements.play[e] >= 0:
            return e
    return NONE


@compilable
def integrators(c: CylinderParts, chain: Chain) -> np.ndarray:
    """Return the time integrator of each coordinate, as of `bdf2.reach_of`, shape (m + k,).

    Plays, and modes of the bodies with films that carry them, follow BDF2: they are so stiff that a
    step does not resolve their inertia. With a floating pin these are all modes.
    """
    m = chain.joints.tip.shape[1]
    out = np.zeros(m + len(chain.bodies.stiffness))
    for j in chain.joints.slide:
        out[j] = BY_BDF2
    of_skirt = len(c.piston.stiffness) + c.block_modes
    out[m if c.floats else m + of_skirt :] = BY_BDF2
    last = m + of_skirt
    out[m + c.moving : last - c.block_modes] = STATIC
    out[last - c.block_static : last] = STATIC
    return out


@compilable
def motion_across(c: CylinderParts, of_rod: float) -> ArrowMatrix:
    """Return M of the motion across the bore and of the pin in its shells.

    Eq. (D22):  T = q' . M q'/2      of piston and pin, the piston upright, the rod's eye along the
                                     bore as its big end, at rest without play in it; all other
                                     modes by their own inertia
    Eq. (K12):  T += (k^2 m_r + J_r / L^2) eye'^2/2        the rod swings with its eye
    Eq. (D35):  T += m_r (delta'^2 + 2 k eye' delta_x')/2 + m_c m'^2/2      eye = x_S - delta_x

    Eqs. (K12) and (D35) are the parts of rod and crank, which move by the play at the crank. Eq.
    (K16) gives the eye. T omits the driven motion along the bore, as with a tied pin.

    Parameters
    ----------
    c : CylinderParts
    of_rod : float
        Share of the masses of rod and crank that counts: 0 or 1.
    """
    whole = cylinder_chain(c)
    joints, elements = whole.joints, whole.elements
    joints.offset[BODY.rod] = 0.0  # an upright rod
    chain = Chain(bodies=_bodies_of(c, of_rod), joints=joints, elements=elements, laws=whole.laws)
    m, k = chain.joints.tip.shape[1], len(chain.bodies.stiffness)
    none = np.zeros(m + k)
    still = Motion(none, none, none)
    loads = no_loads(chain)
    forces = chain_forces(chain, loads, still, CrankMotion(0.0, 0.0, 0.0), FIXED)
    by = Increments(none, none, np.ones(m + k))
    arrow = chain_derivative(chain, loads, still, forces, by).arrow  # Eqs. (D22), (K12), (D35)
    kinds = integrators(c, chain)
    for i in range(k):
        if kinds[m + i] == STATIC:
            arrow.diagonal[i] = 0.0
            arrow.left[i] = 0.0
    return arrow
