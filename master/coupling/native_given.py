"""First part of the memory of a coupled FMU without Python, and unsupported features."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import accumulate
from math import inf, prod
from typing import Any

import numpy as np

from ..fmi.block import PARTS_FROM, memory_of, row_of
from ..fmi.builder_native import Inside
from ..fmi.native_parts import NOWHERE
from ..fmi.slave import PRODUCT, SEED, reserved
from ..fmi.variables import Variable
from . import native
from .coupled import LENIENCE, NUDGE, Coupled
from .methods.newton import Newton
from .native_block import (
    SENTENCES,
    WIRE_SENTENCES,
    CoupledMemory,
    CoupledSetup,
    ExposedRow,
    ExposedVariables,
    ParticipantRow,
    Rules,
    WireRow,
    lengths_of,
    owner_of,
    with_coordinates,
)
from .wiring import Wire, layout_of


def uncovered(coupling: Any) -> Iterator[str]:
    """Yield the faults of a coupling table that a native FMU does not support."""
    if coupling.method != "newton":
        yield f"coupling.method: expected newton in a native FMU, got {coupling.method!r}"
    if coupling.advanced.differences:
        yield "coupling.advanced.differences: expected false in a native FMU, got true"


def uncovered_wires(wires: Iterable[Any]) -> Iterator[str]:
    """Yield the faults of wires that a native FMU does not support."""
    for wire in wires:
        if value := wire.relative_tolerance:
            yield f"{_named(wire)}, relative_tolerance: expected 0 in a native FMU, got {value:g}"


def without_derivative(wires: Iterable[Wire], insides: Mapping[str, Inside]) -> Iterator[str]:
    """Yield the faults of wires whose source has no derivative."""
    for wire in wires:
        owner, variable = wire.source
        reads = any(other.target[0] == owner for other in wires)
        if reads and reserved(PRODUCT, variable) not in insides[owner].slave.references:
            yield f"{_named(wire)}: expected a directional derivative in a native FMU, got none"


def not_started_with(insides: Mapping[str, Inside], parameters: Mapping[str, Any]) -> Iterator[str]:
    """Yield the faults of valid parameters that machine code does not support."""
    for name, inside in insides.items():
        values = {v.name: v.number(v.start) for v in inside.slave.table} | dict(parameters[name])
        for fault in inside.part.uncovered_values(values):
            yield f"participants.{name}.parameters.{fault}"


def _named(wire: Any) -> str:
    ends = (e if isinstance(e, str) else ".".join(e) for e in (wire.source, wire.target))
    return f"wire {' -> '.join(ends)}"


def coupled_inside(
    slave: Coupled, insides: Mapping[str, Inside], codes: Mapping[str, int]
) -> Inside:
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
    options, names = slave.inside, list(insides)
    coupling = options.coupling
    layout = layout_of(options.wires, options.order, coupling.parallel)
    known: dict[str, Any] = {**vars(Newton()), **vars(coupling), **vars(coupling.advanced)}
    known |= dict(step=options.step, lenience=LENIENCE)
    known |= dict(nudge=NUDGE, predicted=coupling.predictor + 1)
    rows = _participants(insides, codes, len(options.wires))
    wires = [
        _wire(k, wire, insides, end - prod(wire.shape), end - 1 in layout.unknowns)
        for k, (wire, end) in enumerate(zip(options.wires, layout.ends))
    ]
    exposed = {one: _exposed(slave, insides, one) for one in ("parameter", "input", "output")}
    ports = [options.output[v.name] for v in slave.table if v.causality == "output"]
    limits = [row for row, port in zip(exposed["output"], ports) if port in options.limits]
    owner = NOWHERE
    if coupling.advanced.coordinates:
        owner = owner_of(options.wires, layout, {name: one.part for name, one in insides.items()})
    if owner != NOWHERE:
        layout = with_coordinates(layout, rows[owner].coordinates)
    setup = CoupledSetup(
        Rules(*(known[name] for name in Rules._fields)),
        layout,
        saved=sum(row.variables + row.states for row in rows),
        owner=owner,
        order=np.array([names.index(name) for name in options.order], float),
        starting=np.array([names.index(name) for name in options.participants], float),
        participants=_matrix(rows),
        wires=_matrix(wires),
        exposed=ExposedVariables(*map(_matrix, (*exposed.values(), limits))),
        contents=np.concatenate([_contents(one) for one in insides.values()]),
    )
    lengths, unsaved = lengths_of(setup, rows[-1].memory + rows[-1].memories, len(slave.real))
    part = native.PART._replace(faults=_sentences(options.wires, insides))
    named = dict(zip(CoupledMemory._fields[1:], lengths))
    return Inside(slave, part, memory_of({"setup": row_of(setup)}, named, unsaved))


def _matrix(rows: Sequence[tuple[Any, ...]]) -> np.ndarray:
    """Return rows of numbers as one array."""
    return np.array([np.array(row, float) for row in rows]).reshape(len(rows), -1 if rows else 0)


def _participants(
    insides: Mapping[str, Inside], codes: Mapping[str, int], wires: int
) -> list[ParticipantRow]:
    """Return the row of every participant."""
    rows: list[ParticipantRow] = []
    end = filled = saved = 0
    sentence = len(SENTENCES) + len(WIRE_SENTENCES) * wires
    for name, inside in insides.items():
        memories, first_state, states, first_fault = inside.setup[:PARTS_FROM].astype(int).tolist()
        reals, integers = len(inside.slave.real), len(inside.slave.integer)
        real, integer, memory, end = accumulate((reals, integers, memories), initial=end)
        rows.append(
            ParticipantRow(
                codes[name],
                real=real,
                reals=reals,
                integer=integer,
                integers=integers,
                memory=memory,
                memories=memories,
                first_state=first_state,
                states=states,
                first_fault=first_fault,
                sentence=sentence,
                variables=inside.slave.real_count,
                setup=len(inside.setup),
                contents=filled,
                saved=saved,
                **_coordinates(inside),
            )
        )
        filled += len(inside.setup) + reals + integers
        saved += inside.slave.real_count + states
        sentence += len(inside.part.faults)
    return rows


def _coordinates(inside: Inside) -> dict[str, int]:
    """Return where the coordinates of a participant are."""
    k = inside.part.coordinates
    if k == NOWHERE:
        return {}
    first, end = inside.setup[PARTS_FROM + k : PARTS_FROM + k + 2].astype(int).tolist()
    return dict(first_coordinate=first, coordinates=end - first)


def _contents(inside: Inside) -> np.ndarray:
    """Return the initial content of a participant: its memory, real and integer variables."""
    slave = inside.slave
    return np.concatenate([inside.setup, slave.real, slave.integer.view(float)])


def _wire(
    k: int, wire: Wire, insides: Mapping[str, Inside], first: int, is_unknown: bool
) -> WireRow:
    """Return the row of the k-th wire."""
    names = list(insides)
    (source, source_name), (target, target_name) = wire.source, wire.target
    places = {name: inside.slave.references for name, inside in insides.items()}
    v = _target(wire, insides)
    return WireRow(
        source=names.index(source),
        source_place=places[source][source_name],
        target=names.index(target),
        target_place=places[target][target_name],
        seed=places[target].get(reserved(SEED, target_name), NOWHERE),
        product=places[source].get(reserved(PRODUCT, source_name), NOWHERE),
        first=first,
        elements=prod(wire.shape),
        is_unknown=is_unknown,
        low=-inf if v.minimum is None else v.minimum,
        high=inf if v.maximum is None else v.maximum,
        columns=v.shape[1] if len(v.shape) > 1 else 1,
        sentence=len(SENTENCES) + k * len(WIRE_SENTENCES),
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
    rows: list[ExposedRow] = []
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
    of_wires: list[str] = []
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
