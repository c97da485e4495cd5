"""Iteration of a macro step of a coupled FMU without Python, as `interface` and `newton`."""

from typing import NamedTuple

import numpy as np

from ..fmi.block import keep
from ..fmi.compiled import compiled
from ..fmi.native_parts import (
    FROM_COORDINATES,
    MEASURE,
    NOWHERE,
    PLACE,
    READ,
    TO_COORDINATES,
)
from ..fmi.noted import refuse
from .methods.iteration import NO_FAILURE, Answer, Update, converge, field_update
from .methods.krylov import Goal, Pairs, learn, length, minimise
from .native_block import ON_WIRE, Rules, WireRow, participant_from, rules_of, state_of
from .native_system import (
    ADVANCE,
    TANGENT,
    System,
    call,
    feed,
    is_fed_well,
    of_wire,
    read,
    real_of,
    refuse_element,
    restore_one,
    system_of,
    variable_of,
    wire_of,
)
from .vector import Evaluation, Layout, largest

EXACT, ROUGH = 0.0, 1.0
"""Products of a solve may be rough: Eq. (Q1) then has another matrix, and the same fixed point."""
SMALL_RESIDUAL = 300.0
"""Residual over its tolerance at which the first update of a step has rough products. They leave a
three-hundredth of it. Where surfaces touch, further rough updates do not converge.
"""
LEAST_SCALE = 1e-6
"""Scale of coordinates that move no film, over the largest scale."""


class Step(NamedTuple):
    """Macro step of a system: begin and length [s].

    trail : ndarray, shape (evaluations, wires), measures of the wires; evaluations beyond are not
    recorded. evaluations : ndarray, shape (1,), their number so far.
    """

    system: System
    time: float
    length: float
    trail: np.ndarray
    evaluations: np.ndarray


@compiled
def coordinates_in(system: System):
    """Return the coordinates in the memory of the owner."""
    one = participant_from(system.participants[system.owner])
    first = one.memory + one.first_coordinate
    return system.inside[first : first + one.coordinates]


@compiled
def call_owner(system: System, task: float, more: float):
    """Run the owner's entry `tangent` with two numbers; return whether it answered."""
    numbers = np.zeros(4)
    numbers[0] = task
    numbers[1] = more
    return call(system, system.owner, TANGENT, numbers, system.failures)


@compiled
def read_coordinates(system: System, y: np.ndarray):
    """Copy the owner's coordinates into the end of `y`; return whether it answered."""
    if system.owner < 0:
        return True
    if not call_owner(system, READ, 0.0):
        return False
    coordinates = coordinates_in(system)
    keep(y[len(y) - len(coordinates) :], coordinates)
    return True


@compiled
def place(system: System, length: float, x: np.ndarray):
    """Set the unknowns of a guess to what follows from its coordinates, if the owner answers."""
    if system.owner < 0:
        return
    restore_one(system, system.owner)
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.target == system.owner:
            feed(system, wire, x)
    coordinates = coordinates_in(system)
    keep(coordinates, x[len(x) - len(coordinates) :])
    if call_owner(system, PLACE, length):
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.is_unknown:
                read(system, wire, x)


@compiled
def step_all(step: Step, used: np.ndarray, outputs: np.ndarray):
    """Step every participant once from its saved state, as `Interface.evaluate`.

    Parameters
    ----------
    step : Step
    used : ndarray, shape (size,)
        Iterate; the elements that are no unknowns are set to the outputs.
    outputs : ndarray, shape (size,)
        Written.

    Returns
    -------
    bool
        Whether all participants took the step.
    """
    system = step.system
    numbers = np.zeros(4)
    numbers[0] = step.length
    numbers[1] = step.time
    for k in range(len(system.order)):
        p = int(system.order[k])
        restore_one(system, p)
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.target == p:
                feed(system, wire, used)
                if not is_fed_well(system, wire, system.failures):
                    return False
        if not call(system, p, ADVANCE, numbers, system.failures):
            return False
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.source == p:
                read(system, wire, outputs)
                if not wire.is_unknown:
                    keep(of_wire(wire, used), of_wire(wire, outputs))
    return read_coordinates(system, outputs)


@compiled
def evaluate(step: Step, x: np.ndarray):
    """Return the `Answer` of all participants to an iterate."""
    used = x.copy()
    outputs = np.zeros(len(x))
    is_answered = step_all(step, used, outputs)
    # an element that is fed back was used as in x, another one as in the outputs
    at = Evaluation(used, outputs, outputs - x)
    tolerance = step.system.layout.tolerance
    shares = np.abs(at.residual) / tolerance
    measure = largest(shares) if is_answered else -1.0
    k = int(step.evaluations[0])
    if is_answered and k < len(step.trail):
        begin = 0
        for w, end in enumerate(step.system.layout.ends):
            step.trail[k, w] = largest(shares[begin:end])
            begin = end
    if is_answered:
        step.evaluations[0] = k + 1.0
    return Answer(at, measure, tolerance)


@compiled
def derivative(step: Step, change: np.ndarray, result: np.ndarray):
    """Linearise an evaluation, as `Interface.derivative`; return whether all of them answered."""
    system = step.system
    input_change = np.zeros(len(change))
    keep(result, input_change)
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.is_unknown:
            keep(of_wire(wire, input_change), of_wire(wire, change))
    numbers = np.zeros(4)
    for k in range(len(system.order)):
        p = int(system.order[k])
        real = real_of(system, p)
        seeds = real[participant_from(system.participants[p]).variables :]
        keep(seeds, np.zeros(len(seeds)))
        reads = False
        writes = False
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            writes = writes or wire.source == p
            if wire.target == p:
                reads = True
                if wire.seed != NOWHERE:
                    keep(variable_of(system, wire, p, wire.seed), of_wire(wire, input_change))
        if not (reads and writes):
            continue  # nothing depends on it, or it depends on nothing
        if not call(system, p, TANGENT, numbers, system.failures):
            return False
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.source == p:
                keep(of_wire(wire, result), variable_of(system, wire, p, wire.product))
                if not wire.is_unknown:
                    keep(of_wire(wire, input_change), of_wire(wire, result))
    return True


# ---- in the coordinates of one participant


class CoordinateSystem(NamedTuple):
    """Linear system of a Newton update in the coordinates z of the owner, see `coordinate_update`.

    values : ndarray, shape (coordinates,), in the memory of the owner;
    limits : ndarray, shape (size,), bounds on the residual of the unknowns;
    rough : `EXACT` or `ROUGH`.
    """

    step: Step
    values: np.ndarray
    limits: np.ndarray
    rough: float


@compiled
def product_of(system: System, wire: WireRow):
    """Return the products of a wire's source."""
    return variable_of(system, wire, wire.source, wire.product)


@compiled
def seed(system: System, p: int):
    """Set the seeds of a participant to the products of those before it."""
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.target == p and wire.seed != NOWHERE:
            keep(variable_of(system, wire, p, wire.seed), product_of(system, wire))


@compiled
def pass_through(system: System, rough: float):
    """Compute the owner's coordinates from its products; return whether all answered."""
    numbers = np.zeros(4)
    for k in range(len(system.order)):
        p = int(system.order[k])
        seed(system, p)
        if p == system.owner:
            break
        if not call(system, p, TANGENT, numbers, system.failures):
            return False
    return call_owner(system, TO_COORDINATES, rough)


@compiled
def coordinate_product(linear: CoordinateSystem, k: int, direction: np.ndarray, out: np.ndarray):
    """Write the k-th product with I - C A S; return whether all participants answered."""
    system = linear.step.system
    keep(linear.values, direction / system.scale)
    rough = linear.rough
    if not (call_owner(system, FROM_COORDINATES, rough) and pass_through(system, rough)):
        return False
    keep(out, direction - linear.values * system.scale)
    return True


@compiled
def coordinate_excess(linear: CoordinateSystem, residual: np.ndarray):
    """Return the largest residual of an unknown over its limit."""
    system = linear.step.system
    keep(linear.values, residual / system.scale)
    if not call_owner(system, FROM_COORDINATES, linear.rough):
        return np.inf
    above = 0.0
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.is_unknown:
            shares = np.abs(product_of(system, wire)) / of_wire(wire, linear.limits)
            above = max(above, largest(shares))
    return above


@compiled
def clear_seeds(system: System):
    """Set all seeds and products to 0."""
    for p in range(len(system.participants)):
        real = real_of(system, p)
        seeds = real[participant_from(system.participants[p]).variables :]
        keep(seeds, np.zeros(len(seeds)))


@compiled
def set_scale(system: System, values: np.ndarray):
    """Write how much each coordinate changes the unknowns; return whether the owner answered."""
    if not call_owner(system, MEASURE, 0.0):
        return False
    least = LEAST_SCALE * np.max(values)
    for k in range(len(values)):
        system.scale[k] = max(values[k], least)
    return True


@compiled
def coordinate_update(step: Step, answer: Answer, rules: Rules, layout: Layout, pairs: Pairs):
    """Return the Newton update at an evaluation, in the coordinates of one participant.

    All unknowns are outputs of the owner, and change with its coordinates q alone: J = S C A, A
    from unknowns to its inputs, C from these to the coordinates, S from these to the unknowns. With
    the residuals r of the unknowns and p of the coordinates, which are the last elements of the
    vector, Eq. (Q1) becomes a system of far fewer unknowns, whose residual times S is that of
    Eq. (Q1).

    Eq. (Q13):  (I - C A S) dq = p + C A (r - S p),   dx = (r - S p) + S dq

    r - S p is what is not linear in the coordinates.
    """
    at, system = answer.at, step.system
    values = coordinates_in(system)
    change = np.zeros(len(at.used))
    clear_seeds(system)
    if system.scale[0] == 0.0 and not set_scale(system, values):
        return Update(change, 0, False)
    moved = at.residual[len(change) - len(values) :]
    keep(values, moved)
    if not call_owner(system, FROM_COORDINATES, EXACT):
        return Update(change, 0, False)
    limits = rules.accuracy * answer.allowed
    is_linear = True
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.is_unknown:
            rest = of_wire(wire, at.residual) - product_of(system, wire)
            keep(of_wire(wire, change), rest)
            keep(product_of(system, wire), rest)
            is_linear = is_linear and (np.abs(rest) <= of_wire(wire, limits)).all()
    right = moved * system.scale
    count = 0
    if not is_linear:
        count += 1
        if not pass_through(system, EXACT):
            return Update(change, count, False)
        right += values * system.scale
    goal = Goal(rules.forcing * length(right), np.inf)
    is_small = answer.measure <= SMALL_RESIDUAL and step.evaluations[0] <= 1.0
    linear = CoordinateSystem(step, values, limits, ROUGH if is_small else EXACT)
    most = rules.largest_krylov_space
    # Eq. (Q13)
    solved = minimise(coordinate_product, coordinate_excess, linear, right, goal, pairs, most)
    count += len(solved.weights)
    if not solved.is_answered:
        return Update(change, count, False)
    if len(solved.weights) > 0:
        learn(pairs, solved.space, len(solved.weights))
    keep(values, solved.x / system.scale)
    keep(change[len(change) - len(values) :], values)
    if not call_owner(system, FROM_COORDINATES, EXACT):
        return Update(change, count, False)
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.is_unknown:
            keep(of_wire(wire, change), of_wire(wire, change) + product_of(system, wire))
    return Update(change, count, True)


@compiled
def update(step: Step, answer: Answer, rules: Rules, layout: Layout, pairs: Pairs):
    """Return the Newton update at an evaluation, see `converge`."""
    if step.system.owner >= 0:
        return coordinate_update(step, answer, rules, layout, pairs)
    return field_update(derivative, step, answer, rules, layout, pairs)


@compiled
def note_worst(system: System, residual: np.ndarray):
    """Note the fault of the wire with the largest residual."""
    shares = np.abs(residual) / system.layout.tolerance
    shares[np.isnan(shares)] = np.inf
    k = np.argmax(shares)
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if 0 <= k - wire.first < wire.elements:
            x, allowed = float(residual[k]), float(system.layout.tolerance[k])
            refuse_element(system.failures, wire, k - wire.first, ON_WIRE.worst, x, allowed, 0.0)


@compiled
def find(memory: np.ndarray, x: np.ndarray, time: float, length: float, noted: np.ndarray):
    """Replace a guess by the fixed point of a macro step; return False and note why if none.

    noted : ndarray, written: evaluations, products, and the measures of all wires by evaluation;
    nothing if it is empty.
    """
    system = system_of(memory)
    system.failures[0] = 0.0
    wires = len(system.wires)
    rows = (len(noted) - 2) // wires if len(noted) > 0 and wires > 0 else 0
    trail = noted[len(noted) - rows * wires :].reshape((rows, wires))
    counts = noted[:2] if rows > 0 else np.zeros(2)
    step = Step(system, time, length, trail, counts)
    pairs = state_of(memory).pairs
    rules = rules_of(memory)
    place(system, length, x)
    end = converge(evaluate, update, step, x, rules, system.layout, pairs)
    counts[1] = end.products
    if end.is_converged:
        keep(x, end.at.used)
        if len(end.history) == 1:  # else a guess would be extrapolated again, and drift
            first = len(x) - len(system.scale)
            keep(x[first:], end.at.outputs[first:])
    if end.failure != NO_FAILURE:
        count, best, last = len(end.history), np.min(end.history), end.history[-1]
        refuse(system.failures, end.failure, float(count), 0.0, last, best, 0.0)
        note_worst(system, end.at.residual)
    return end.is_converged
