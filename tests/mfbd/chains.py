"""Engines as chains of bodies, for tests and benches of `fmu_mfbd.mechanism`."""

from typing import NamedTuple

import numpy as np

from piston_cosim.fmu_mfbd.force_elements.element import BODIES
from piston_cosim.fmu_mfbd.mechanism.chain import (
    BLOCK,
    IN_PARENT,
    NONE,
    Chain,
    Loads,
)
from piston_cosim.fmu_mfbd.mechanism.cylinder import EYE, NO_SLIDES, CylinderLaws, cylinder_chain
from piston_cosim.fmu_mfbd.mechanism.floating_frame import FlexibleBody
from piston_cosim.fmu_mfbd.mechanism.modal_damping import ModalSprings
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion, Mechanism
from piston_cosim.fmu_mfbd.mechanism.solution import mode_coupling
from piston_cosim.tests.verification.cases.links import (
    Element,
    Link,
    Slide,
    chain_of,
    play,
)
from piston_cosim.tests.verification.cases.tied import GAS as ON_BORE
from piston_cosim.tests.verification.cases.tied import PISTON, SKIRT, tied_parts

MECHANISM = Mechanism(0.072, 0.223, 1.2e-3, 1.7, 0.017, 72 / 223, 0.5)
SPIN_INERTIA = 2e-4
CRANK = CrankMotion(0.9, 210.0, 4e3)
CRANK_MASS, UNBALANCE = 3.1, 0.012
GAS = 12e3
SHAPES, SHELL_MODES = 2, 3
SLIDES = (0.3, 0.9), (0.0, 1.0), (0.8, -0.2)
"""Directions of a big end that slides on the crank, and of a small end that slides on the rod."""


class Engine(NamedTuple):
    """A chain, and which of its bodies and elements are which.

    pistons : numbers of bodies; skirts, gas : elements on each; plays : first coordinates of plays,
    with the element of the film in each.
    """

    chain: Chain
    pistons: list
    skirts: list
    gas: list
    films: dict


def rigid(mass, y=0.0, about_origin=0.0):
    """Return a rigid body with its centre of mass at y [m]."""
    none, square = np.zeros(0), np.zeros((0, 0))
    S = np.array([0.0, mass * y])
    return FlexibleBody(
        mass, S, about_origin, np.zeros((2, 0)), none, square, none, square, none, none
    )


def flexible(modes, seed=3):
    """Return a piston whose matrices have no symmetry that they need not have."""
    rng = np.random.default_rng(seed)
    omega = np.linspace(2e4, 3e5, modes)
    first, second = rng.standard_normal((2, modes, modes)) / max(1, modes) ** 0.5
    return FlexibleBody(
        1.39,
        1.39 * np.array([1.5e-3, 26.5e-3]),
        0.004,
        0.2 * rng.standard_normal((2, modes)),
        5e-3 * rng.standard_normal(modes),
        0.3 * (first + first.T) + np.eye(modes),
        5e-3 * rng.standard_normal(modes),
        0.2 * (second - second.T),
        omega**2,
        0.04 * omega,
    )


def springs(modes):
    """Return springs of so many modes of shells and shapes."""
    omega = np.linspace(1e4, 5e4, modes)
    return ModalSprings(omega**2, 0.04 * omega)


def engine(
    pistons,
    floating=False,
    crank_films=False,
    free=False,
    yields=False,
    slides=False,
    mechanism=MECHANISM,
):
    """Return the engine of some flexible pistons, with their cranks evenly apart.

    Coordinates of each cylinder: x_A, rocking angle; with a floating pin pin from bosses, pin from
    eye (x, y), angle of the pin; with films of the crank crank pin from big end. Then journal from
    main bearing, and the lead of a free crank over its drive.
    If it yields, each pin has `SHAPES` shapes along both axes and each shell `SHELL_MODES` modes.
    The last coordinates of each cylinder with slides are those of `SLIDES`.
    """
    m = mechanism
    per = 2 + 5 * floating + 2 * crank_films + len(SLIDES) * slides
    journal = per * len(pistons) if crank_films else NONE
    size = per * len(pistons) + 2 * crank_films + free
    crank = rigid(CRANK_MASS)._replace(S=np.array([0.0, UNBALANCE])) if crank_films else rigid(0.0)
    about_end = m.rod_inertia + m.rod_mass * (m.rod_centre * m.rod_length) ** 2
    rod = rigid(m.rod_mass, m.rod_centre * m.rod_length, about_end)
    pin = rigid(m.pin_mass, 0.0, SPIN_INERTIA if floating else 0.0)
    links = [Link(crank, BLOCK, (0.0, 0.0), play(journal), size - 1 if free else NONE, True)]
    elements, found = [], Engine(None, [], [], [], {})

    shapes, shells = (SHAPES, SHELL_MODES) if yields else (0, 0)
    of_pistons = sum(len(piston.stiffness) for piston in pistons)
    of_each = 2 * shapes + 2 * shells
    main = of_pistons + len(pistons) * of_each

    def film(play, journal, shell, modes, bent=(0, 0), point=(0.0, 0.0), marker=(0.0, 0.0)):
        found.films[play] = len(elements)
        own = Element(journal, shell, shell, shell, marker, point, play, *modes, *bent)
        elements.append(own)

    for k, piston in enumerate(pistons):
        x = per * k
        boss, eye, spin = (x + 2, x + 4, x + 6) if floating else (NONE, NONE, x + 1)
        big_end = x + per - 2 if crank_films else NONE
        (to_crank, *to_rod) = ((Slide(x + 2 + i, way, IN_PARENT),) for i, way in enumerate(SLIDES))
        in_crank, in_eye = play(big_end, -1.0), play(eye)
        if slides:
            in_crank, in_eye = to_crank, sum(to_rod, ())
        at = len(links)
        angle = 2 * np.pi * k / len(pistons)
        pin_of_crank = (-m.crank_radius * np.sin(angle), m.crank_radius * np.cos(angle))
        links += [
            Link(rod, 0, pin_of_crank, in_crank, swings=True),
            Link(pin, at, (0.0, m.rod_length), in_eye, spin),
            Link(piston, at + 1, slides=play(boss, -1.0), angle=x + 1, guide=x, offset=m.offset),
        ]
        first, modes = size + k * len(piston.stiffness), len(piston.stiffness)
        bent = size + of_pistons + k * of_each
        eye_modes = bent + 2 * shapes
        if floating:
            for _ in range(EYE):
                film(boss, at + 1, at + 2, (first, modes), (bent, shapes))
            of_eye = eye_modes, shells
            film(eye, at + 1, at, of_eye, (bent, shapes), point=(0.0, m.rod_length))
        if crank_films:
            film(big_end, 0, at, (eye_modes + shells, shells), marker=pin_of_crank)
        if crank_films and piston is pistons[-1]:
            film(journal, 0, BLOCK, (size + main, shells))
        found.pistons.append(at + 2)
        found.skirts.append(len(elements))
        found.gas.append(len(elements) + 1)
        elements += [
            Element(at + 2, BLOCK, at + 2, BLOCK),
            Element(at + 2, BLOCK, point=(m.offset, 0.0), at_point=True),
        ]
    tail = springs(main + shells - of_pistons if crank_films else 0)
    return found._replace(chain=chain_of(links, elements, size, tail))


def matrix_of(arrow, coupling=0.0):
    """Return a tangent and the coupling of its modes as one matrix."""
    return np.vstack([arrow.top, np.hstack([arrow.left, np.diag(arrow.diagonal) + coupling])])


def loads_of(chain, load, now, films):
    """Return the loads of a cylinder whose pin floats: on its piston, and of films by resultants.

    The films are those of both bosses together, eye, and crank.
    """
    bosses, *others = ([*one.force, one.on_pin, one.on_shell] for one in films)
    skirt = [load.lateral, load.axial + load.axis_force, load.moment, 0.0]
    gas = [0.0, -load.axis_force, 0.0, 0.0]
    wrench = np.array([bosses, np.zeros(4), *others, skirt, gas])
    return Loads(wrench, load.modal)


def tied(piston, mechanism=MECHANISM, slides=NO_SLIDES):
    """Return the engine of one cylinder with a tied pin, as the FMU has it."""
    parts = tied_parts(piston, mechanism, UNBALANCE)._replace(slides=slides)
    return Engine(cylinder_chain(parts), [PISTON], [SKIRT], [ON_BORE], {})


def touching(piston):
    """Return `tied` with a top land that touches the bore."""
    numbers = np.array([[1e7, 0.1, 0.0, 0.03]])
    laws = CylinderLaws(
        *np.array([[0], [BODIES.index("piston")], [BLOCK]]), numbers[0, 3:], numbers
    )
    parts = tied_parts(piston, MECHANISM, UNBALANCE)._replace(laws=laws)
    return Engine(cylinder_chain(parts), [PISTON], [SKIRT], [ON_BORE], {})


def coupled(arrow, chain, own, by):
    """Return a tangent as one matrix, with its modes coupled."""
    whole, m = matrix_of(arrow), len(arrow.top)
    for j, unit in enumerate(np.eye(len(whole))[m:], m):
        product = mode_coupling(chain.bodies, own.motion, own.inertia.carrier, by, unit)
        whole[m:, j] += product
    return whole
