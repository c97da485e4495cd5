"""First part of the memory of a coupled FMU without Python, and unsupported features."""

from collections.abc import Iterable, Iterator, Mapping
from math import inf, prod
from typing import Any

import numpy as np

from ..fmi.builder_native import Inside
from ..fmi.slave import PRODUCT, SEED, reserved
from ..fmi.variables import Variable
from . import native
from .coupled import LENIENCE, NUDGE, Coupled
from .methods.newton import Newton
from .native_block import (
    NOWHERE,
    SENTENCES,
    WIRE_SENTENCES,
    ExposedRow,
    ParticipantRow,
    Rules,
    WireRow,
    lay_out,
)
from .wiring import Wire, layout_of


def uncovered(coupling: Any) -> Iterator[str]:
    """Yield the faults of a coupling table that a native FMU does not support."""
    if coupling.method != "newton":
        yield f"coupling.method: expected newton in a native FMU, got {coupling.method!r}"
    if coupling.differences:
        yield "coupling.differences: expected false in a native FMU, got true"


def uncovered_wires(wires: Iterable[Any]) -> Iterator[str]:
    """Yield the faults of wires that a native FMU does not support."""
    for wire in wires:
        for name in ("relative_tolerance", "residual_relative_tolerance"):
            if value := getattr(wire, name):
                yield f"{_named(wire)}, {name}: expected 0 in a native FMU, got {value:g}"


def without_derivative(wires: Iterable[Wire], insides: Mapping[str, Inside]) -> Iterator[str]:
    """Yield the faults of wires whose source has no derivative."""
    for wire in wires:
        owner, variable = wire.source
        reads = any(other.target[0] == owner for other in wires)
        if reads and reserved(PRODUCT, variable) not in insides[owner].slave.references:
            yield f"{_named(wire)}: expected a directional derivative in a native FMU, got none"


def not_started_with(insides: Mapping[str, Inside], given: Mapping[str, Any]) -> Iterator[str]:
    """Yield the faults of valid parameters that machine code does not support."""
    for name, inside in insides.items():
        values = {v.name: v.number(v.start) for v in inside.slave.table} | dict(given[name])
        for fault in inside.part.uncovered_values(values):
            yield f"participants.{name}.parameters.{fault}"


def _named(wire: Any) -> str:
    ends = (e if isinstance(e, str) else ".".join(e) for e in (wire.source, wire.target))
    return f"wire {' -> '.join(ends)}"


def coupled_inside(slave: Coupled, insides: Mapping[str, Inside], codes: Mapping[str, int]):
    """Return the model of a native coupled FMU.

    Parameters
    ----------
    slave : Coupled
    insides : mapping
        The participants by name.
    codes : mapping
        Participant -> number of its package's entries.

    Returns
    -------
    Inside
    """
    options = slave.inside
    coupling, newton, names = options.coupling, Newton(), list(insides)
    rules = Rules(
        step=options.step,
        lenience=LENIENCE,
        nudge=NUDGE,
        predicted=coupling.predictor + 1,
        halvings=coupling.halvings,
        max_iterations=coupling.max_iterations,
        largest_krylov_space=coupling.largest_krylov_space,
        accuracy=newton.accuracy,
        forcing=newton.forcing,
    )
    causalities = ("parameter", "input", "output")
    layout = layout_of(options.wires, options.order, coupling.parallel)
    head = lay_out(
        rules,
        layout,
        _participants(insides, codes, len(options.wires)),
        [
            _wire(wire, insides, end - prod(wire.shape), end - 1 in layout.unknowns)
            for wire, end in zip(options.wires, layout.ends)
        ],
        [names.index(name) for name in options.order],
        reals=len(slave.real),
        exposed=[_exposed(slave, insides, causality) for causality in causalities],
        starting=[names.index(name) for name in options.participants],
        contents=np.concatenate([_contents(one) for one in insides.values()]),
    )
    part = native.PART._replace(faults=_sentences(options.wires, insides))
    return Inside(slave, part, head)


def _participants(insides, codes, wires):
    """Return the row of every participant."""
    rows = []
    sentence = len(SENTENCES) + len(WIRE_SENTENCES) * wires
    for name, inside in insides.items():
        numbers = np.zeros(4)  # what the participant's entry `size` tells
        tell = inside.part.entries[0].kernel
        tell(inside.slave.real, inside.slave.integer, inside.given, numbers)
        memories, first_state, states, first_fault = numbers.astype(int).tolist()
        rows.append(
            ParticipantRow(
                codes[name],
                reals=len(inside.slave.real),
                integers=len(inside.slave.integer),
                memories=memories,
                first_state=first_state,
                states=states,
                first_fault=first_fault,
                sentence=sentence,
                variables=inside.slave.real_count,
                given=len(inside.given),
            )
        )
        sentence += len(inside.part.faults)
    return rows


def _contents(inside: Inside) -> np.ndarray:
    """Return the initial content of a participant: its memory, real and integer variables."""
    slave = inside.slave
    return np.concatenate([inside.given, slave.real, slave.integer.view(float)])


def _wire(wire: Wire, insides: Mapping[str, Inside], first: int, is_unknown: bool) -> WireRow:
    """Return the row of a wire."""
    names = list(insides)
    (source, said), (target, heard) = wire.source, wire.target
    places = {name: inside.slave.references for name, inside in insides.items()}
    v = _target(wire, insides)
    return WireRow(
        source=names.index(source),
        source_place=places[source][said],
        target=names.index(target),
        target_place=places[target][heard],
        seed=places[target].get(reserved(SEED, heard), NOWHERE),
        product=places[source].get(reserved(PRODUCT, said), NOWHERE),
        first=first,
        elements=prod(wire.shape),
        is_unknown=is_unknown,
        low=-inf if v.minimum is None else v.minimum,
        high=inf if v.maximum is None else v.maximum,
        columns=v.shape[1] if len(v.shape) > 1 else 1,
    )


def _target(wire: Wire, insides: Mapping[str, Inside]) -> Variable:
    """Return the input that a wire ends at."""
    owner, name = wire.target
    return next(v for v in insides[owner].slave.table if v.name == name)


def _exposed(slave: Coupled, insides: Mapping[str, Inside], causality: str) -> list[ExposedRow]:
    """Return the rows of variables of the coupled FMU."""
    names = list(insides)
    ports = getattr(slave.inside, causality)
    kind = SEED if causality == "input" else PRODUCT
    rows = []
    for v in slave.table:
        if v.causality != causality:
            continue
        owner, name = ports[v.name]
        rows.append(
            ExposedRow(
                is_integer=v.type != "Real",
                place=slave.references[v.name],
                owner=names.index(owner),
                own_place=insides[owner].slave.references[name],
                length=v.size,
                reserved=slave.references.get(reserved(kind, v.name), NOWHERE),
                nominal=v.nominal or 0.0,
            )
        )
    return rows


def _sentences(wires: Iterable[Wire], insides: Mapping[str, Inside]) -> tuple[str, ...]:
    """Return the sentences of the coupling, of the wires and of all participants."""
    of_wires = []
    for wire in wires:
        v = _target(wire, insides)
        unit = "" if v.unit == "1" else f" {v.unit}"
        name = ": ".join(wire.target)
        index = "[{i},{j}]" if len(v.shape) > 1 else "[{i}]" if v.shape else ""
        of_wires += [
            f"{'.'.join(wire.target)}{index}: expected a residual of at most "
            f"{{b}}{unit}, got {{a}}{unit}",
            f"{name}{index}: expected a finite value, got {{a}}{unit}",
            f"{name}: expected {{b}} to {{c}}{unit}, got {{a}}{unit}",
        ]
    own = [f"{name}: {text}" for name, inside in insides.items() for text in inside.part.faults]
    return (*SENTENCES.values(), *of_wires, *own)
