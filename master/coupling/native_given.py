"""What the memory of a coupled slave without Python begins with, and what it does not cover."""

from collections.abc import Iterable, Iterator, Mapping
from math import inf
from typing import Any

import numpy as np

from ..fmi.builder_native import Inside
from ..fmi.native_parts import uncovered_values
from ..fmi.noted import ROOM
from ..fmi.slave import PRODUCT, SEED, reserved
from ..fmi.variables import Variable
from . import native
from .coupled import LENIENCE, NUDGE, Coupled
from .methods.krylov import KEPT, NOISE
from .methods.newton import Newton
from .native_block import (
    CONSTANT,
    COUNTED,
    NOWHERE,
    OF_EXPOSED,
    OF_LAST,
    OF_ROW,
    OF_SENTENCES,
    OF_TRAIL,
    OF_WIRE,
    OWN_FAULTS,
    in_order,
)
from .wiring import Wire, is_unknown

CAUSALITIES = ("parameter", "input", "output")
"""As `IS_PARAMETER` .. in `native_block`."""


def uncovered(coupling: Any) -> Iterator[str]:
    """Sentences on a case's coupling table that a native FMU does not cover."""
    if coupling.method != "newton":
        yield f"coupling.method: expected newton in a native FMU, got {coupling.method!r}"
    if coupling.differences:
        yield "coupling.differences: expected false in a native FMU, got true"


def uncovered_wires(wires: Iterable[Any]) -> Iterator[str]:
    """The same of wires, of the case or ready for use."""
    for wire in wires:
        for name in ("relative_tolerance", "residual_relative_tolerance"):
            if value := getattr(wire, name):
                yield f"{_named(wire)}, {name}: expected 0 in a native FMU, got {value:g}"


def without_derivative(wires: Iterable[Wire], insides: Mapping[str, Inside]) -> Iterator[str]:
    """Sentences on wires whose source tells no derivative, which the products need."""
    for wire in wires:
        owner, variable = wire.source
        reads = any(other.target[0] == owner for other in wires)
        if reads and reserved(PRODUCT, variable) not in insides[owner].slave.references:
            yield f"{_named(wire)}: expected a directional derivative in a native FMU, got none"


def not_started_with(insides: Mapping[str, Inside], given: Mapping[str, Any]) -> Iterator[str]:
    """Sentences on parameters of a case that are valid, but not covered by the machine code."""
    for name, inside in insides.items():
        for fault in uncovered_values(inside.part, inside.slave.table, given[name]):
            yield f"participants.{name}.parameters.{fault}"


def _named(wire: Any) -> str:
    ends = (e if isinstance(e, str) else ".".join(e) for e in (wire.source, wire.target))
    return f"wire {' -> '.join(ends)}"


def coupled_inside(slave: Coupled, insides: Mapping[str, Inside], codes: Mapping[str, int]):
    """The coupled slave about to become machine code.

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
    layout = Layout(slave, insides, codes)
    part = native.PART._replace(faults=layout.sentences(), covered=layout.covered())
    return Inside(slave, part, part.given((layout.contents(), layout.lengths())))


class Layout:
    """Where what lies; arguments as of `coupled_inside`."""

    def __init__(self, slave: Coupled, insides: Mapping[str, Inside], codes: Mapping[str, int]):
        self.slave = slave
        self.options = slave.inside
        self.insides = insides
        self.codes = codes
        self.names = list(insides)
        self.wires = self.options.wires
        self.sizes = [int(np.prod(wire.shape)) for wire in self.wires]
        self.order = list(self.options.order)
        self.against = [
            is_unknown(wire, self.order, self.options.coupling.parallel) for wire in self.wires
        ]
        self.own = {name: _sizes(inside) for name, inside in insides.items()}

    @property
    def size(self) -> int:
        """Elements of all wires."""
        return sum(self.sizes)

    @property
    def unknowns(self) -> int:
        """Those that are unknowns."""
        return sum(n for n, against in zip(self.sizes, self.against) if against)

    @property
    def kept(self) -> int:
        """Pairs that the Krylov method remembers."""
        return min(KEPT, self.unknowns)

    @property
    def standing(self) -> int:
        """Variables and states of all participants."""
        return sum(i.slave.real_count + self.own[n]["states"] for n, i in self.insides.items())

    def lengths(self) -> dict[str, int]:
        """Of the parts that are not given."""
        past = self.options.coupling.predictor + 1
        states = {
            "standing": self.standing,
            "times": 1 + past,
            "past": past * self.size,
            "oldest": 1,
            "images": self.kept * self.unknowns,
            "differences": self.kept * self.unknowns,
            "gram": self.kept**2,
        }
        exposed = self.exposed()
        of_kept = {
            which: sum(v.size for v, row in exposed if v.causality == which and row["kept"] >= 0)
            for which in ("input", "output")
        }
        return {
            "inside": sum(map(self._inside, self.names)),
            "saved": self.standing,
            **states,
            "before": sum(states.values()),
            "marks": self.kept,
            "last": len(OF_LAST),
            "last_inputs": of_kept["input"],
            "last_outputs": of_kept["output"],
            "trail": len(OF_TRAIL) + len(self.wires),
            "failures": ROOM,
            "faults": ROOM,
        }

    def contents(self) -> dict[str, np.ndarray]:
        """Parts that are given."""
        coupling = self.options.coupling
        newton = Newton()
        counts = {
            "participants": len(self.names),
            "wires": len(self.wires),
            "size": self.size,
            "unknowns": self.unknowns,
            "kept": self.kept,
            "past": coupling.predictor + 1,
            "iterations": coupling.max_iterations,
            "space": coupling.largest_krylov_space,
            "halvings": coupling.halvings,
            "exposed": len(self.slave.table),
        }
        constants = {
            "step": self.options.step,
            "lenience": LENIENCE,
            "accuracy": newton.accuracy,
            "forcing": newton.forcing,
            "noise": NOISE,
            "nudge": NUDGE,
        }
        given = {
            "counts": in_order([counts], COUNTED),
            "constants": in_order([constants], CONSTANT),
            "order": np.array([self.names.index(name) for name in self.order], float),
            "starting": np.array([self.names.index(n) for n in self.options.participants], float),
            "rows": in_order(self.rows(0), OF_ROW),
            "wires": in_order(self.wired(), OF_WIRE),
            "exposed": in_order((row for _, row in self.exposed()), OF_EXPOSED),
            "contents": np.concatenate([_contents(one) for one in self.insides.values()]),
        }
        # participants lie behind all that is given
        head = native.given_of((given, self.lengths()))
        given["rows"] = in_order(self.rows(len(head)), OF_ROW)
        return given

    def rows(self, behind: int) -> list[dict[str, float]]:
        """`OF_ROW` of every participant, the first of them `behind` so many numbers."""
        rows = []
        content = standing = 0
        sentence = len(OWN_FAULTS) + OF_SENTENCES * len(self.wires)
        for name, inside in self.insides.items():
            own = self.own[name]
            reals, integers = len(inside.slave.real), len(inside.slave.integer)
            rows.append(
                {
                    "code": self.codes[name],
                    "real": behind,
                    "reals": reals,
                    "integer": behind + reals,
                    "integers": integers,
                    "memory": behind + reals + integers,
                    "memories": own["whole"],
                    "first_state": own["first_state"],
                    "states": own["states"],
                    "first_fault": own["first_fault"],
                    "sentence": sentence,
                    "variables": inside.slave.real_count,
                    "contents": content,
                    "given": len(inside.given),
                    "standing": standing,
                }
            )
            behind += self._inside(name)
            content += len(_contents(inside))
            standing += inside.slave.real_count + own["states"]
            sentence += len(inside.part.faults)
        return rows

    def _inside(self, name):
        """Numbers that a participant takes."""
        slave = self.insides[name].slave
        return len(slave.real) + len(slave.integer) + self.own[name]["whole"]

    def wired(self) -> list[dict[str, float]]:
        """`OF_WIRE` of every wire."""
        rows = []
        first = unknown = 0
        for k, (wire, size, against) in enumerate(zip(self.wires, self.sizes, self.against)):
            source, target = (self.insides[end[0]].slave for end in (wire.source, wire.target))
            v = self.target(wire)
            decrease = wire.largest_decrease
            rows.append(
                {
                    "source": self.names.index(wire.source[0]),
                    "source_place": source.references[wire.source[1]],
                    "target": self.names.index(wire.target[0]),
                    "target_place": target.references[wire.target[1]],
                    "elements": size,
                    "first": first,
                    "unknown": unknown if against else NOWHERE,
                    "nominal": wire.nominal,
                    "tolerance": wire.tolerance,
                    "largest_decrease": NOWHERE if decrease is None else decrease,
                    "seed": target.references.get(reserved(SEED, wire.target[1]), NOWHERE),
                    "product": source.references.get(reserved(PRODUCT, wire.source[1]), NOWHERE),
                    "low": -inf if v.minimum is None else v.minimum,
                    "high": inf if v.maximum is None else v.maximum,
                    "columns": v.shape[1] if len(v.shape) > 1 else 1,
                    "sentence": len(OWN_FAULTS) + OF_SENTENCES * k,
                }
            )
            first += size
            unknown += size if against else 0
        return rows

    def target(self, wire: Wire) -> Variable:
        """The input that a wire ends at."""
        table = self.insides[wire.target[0]].slave.table
        return next(v for v in table if v.name == wire.target[1])

    def exposed(self) -> list[tuple[Variable, dict[str, float]]]:
        """Every variable seen from outside with its `OF_EXPOSED`."""
        ports = self.options.parameter | self.options.input | self.options.output
        kept = dict.fromkeys(CAUSALITIES, 0)
        rows = []
        for v in self.slave.table:
            owner, name = ports[v.name]
            kind = SEED if v.causality == "input" else PRODUCT
            is_kept = v.type == "Real" and v.causality != "parameter"
            row = {
                "integral": v.type != "Real",
                "place": self.slave.references[v.name],
                "owner": self.names.index(owner),
                "own_place": self.insides[owner].slave.references[name],
                "length": v.size,
                "causality": CAUSALITIES.index(v.causality),
                "reserved": self.slave.references.get(reserved(kind, v.name), NOWHERE),
                "nominal": v.nominal or 0.0,
                "kept": kept[v.causality] if is_kept else NOWHERE,
            }
            kept[v.causality] += v.size if is_kept else 0
            rows.append((v, row))
        return rows

    def sentences(self) -> tuple[str, ...]:
        """Of all faults: the coupling's own, three a wire, those of every participant."""
        of_wires = []
        for wire in self.wires:
            v = self.target(wire)
            unit = "" if v.unit == "1" else f" {v.unit}"
            name = f"{wire.target[0]}: {wire.target[1]}"
            index = "[{i},{j}]" if len(v.shape) > 1 else "[{i}]" if v.shape else ""
            of_wires += [
                f"{'.'.join(wire.target)}{index}: expected a residual of at most "
                f"{{b}}{unit}, got {{a}}{unit}",
                f"{name}{index}: expected a finite value, got {{a}}{unit}",
                f"{name}: expected {{b}} to {{c}}{unit}, got {{a}}{unit}",
            ]
        own = [
            f"{name}: {sentence}"
            for name, inside in self.insides.items()
            for sentence in inside.part.faults
        ]
        return (*OWN_FAULTS, *of_wires, *own)

    def covered(self) -> dict[str, tuple[str, ...] | float]:
        """Covered choices and numbers by their names outside."""
        return {
            exposed: self.insides[owner].part.covered[name]
            for exposed, (owner, name) in self.options.parameter.items()
            if name in self.insides[owner].part.covered
        }


def _sizes(inside: Inside) -> dict[str, int]:
    """What a participant's entry `size` tells."""
    numbers = np.zeros(4)
    tell = inside.part.entries[0].kernel
    tell(inside.slave.real, inside.slave.integer, inside.given, numbers)
    names = ("whole", "first_state", "states", "first_fault")
    return dict(zip(names, numbers.astype(int).tolist()))


def _contents(inside: Inside) -> np.ndarray:
    """What a participant begins with: of its memory, real and integer variables."""
    slave = inside.slave
    return np.concatenate([inside.given, slave.real, slave.integer.view(float)])
