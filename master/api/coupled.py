"""Coupling of your own participants, described in Python instead of in a case file."""

import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard, Union

from ..fmi.errors import BadInput, unknown
from ..participants.participant import Participant
from .cases import Case

if TYPE_CHECKING:
    from ..fmi.slave import FieldSlave

Origin = Union["type[FieldSlave]", str, Path, Callable[[], Participant]]
"""Origin of a participant, see `couple`."""


def couple(
    participants: Mapping[str, Origin],
    wires: Sequence[str | Mapping[str, Any]],
    *,
    stop: str,
    step: str,
    method: str = "newton",
    order: Sequence[str] | None = None,
    parameters: Mapping[str, Mapping[str, Any]] | None = None,
    build: Mapping[str, Mapping[str, Any]] | None = None,
    record: Sequence[str] = (),
    title: str = "",
    **coupling: Any,
) -> Case:
    """Return a case of participants and wires, which iterates every macro step.

    Parameters
    ----------
    participants : mapping
        Name -> a class derived from `Slave` (runs in this process), the path of an FMU,
        "FILE.py:CLASS" (packed as an FMU), a CSV file of signals, or a function without arguments
        that returns an object with the methods of `master.participants.participant.Participant`.
    wires : sequence
        "spring.force -> mass.force", or a mapping with the keys of a case's wires, for example
        {"from": "spring.force", "to": "mass.force", "tolerance": "1 mN"}.
    stop, step : str
        Stop time and macro step, "1 s", "1 ms".
    method : str
        newton, iqn_ils, iqn_ageing, aitken, constant, or explicit.
    order : sequence of str, optional
        Stepping order of the participants. Default: that of the mapping. Wires against this order
        are the unknowns.
    parameters : mapping, optional
        Participant -> name -> value with its unit: parameters, and start values of inputs.
    build : mapping, optional
        Participant -> argument of its `variables(options)`.
    record : sequence of str
        Arrays to record, "participant.variable". Scalar outputs are always recorded.
    **coupling
        Further keys of a case's `[coupling]`: max_iterations, relaxation, predictor, ...

    Returns
    -------
    Case
        With `run` and `changed` like any other case.

    Raises
    ------
    BadInput
        With every fault of the description. `Case.run` reports faults of units, shapes and names,
        because they depend on the participants.

    Examples
    --------
    A mass on a spring by the implicit midpoint rule, with one class for each side:

    >>> class Spring(pc.Slave):
    ...     name = "spring"
    ...     @staticmethod
    ...     def variables(options):
    ...         return [
    ...             pc.variables.parameter("stiffness", "N/m", "Stiffness", 100.0, 0.0),
    ...             pc.variables.input_variable("length", "m", "Elongation", 0.0, 1.0),
    ...             pc.variables.output_variable("force", "N", "Restoring force", 1.0),
    ...         ]
    ...     def start(self, values):
    ...         return self.advance(None, values, 0.0, 0.0)
    ...     def advance(self, state, values, time, step):
    ...         return state, {"force": -values["stiffness"] * values["length"]}
    >>> class Mass(pc.Slave):
    ...     name = "mass"
    ...     @staticmethod
    ...     def variables(options):
    ...         return [
    ...             pc.variables.input_variable("force", "N", "Force", 0.0, 1.0),
    ...             pc.variables.output_variable("position", "m", "Position", 1.0),
    ...         ]
    ...     def start(self, values):
    ...         return (1.0, 0.0, values["force"]), {"position": 1.0}
    ...     def advance(self, state, values, time, step):
    ...         position, velocity, before = state
    ...         faster = velocity + step * (before + values["force"]) / 2.0
    ...         position += step * (velocity + faster) / 2.0
    ...         return (position, faster, values["force"]), {"position": position}
    >>> case = pc.couple(
    ...     {"spring": Spring, "mass": Mass},
    ...     ["mass.position -> spring.length", "spring.force -> mass.force"],
    ...     stop="0.2 s", step="2 ms", method="aitken", parameters={"spring": {"length": "1 m"}},
    ... )
    >>> position = case.run().series("mass.position").values
    >>> print(f"{position[-1]:.3f}")      # cos(10/s 0.2 s) = -0.416
    -0.416
    """
    by_participant = {name: dict(values) for name, values in (parameters or {}).items()}
    options = {name: dict(values) for name, values in (build or {}).items()}
    strangers = sorted((by_participant.keys() | options.keys()) - participants.keys())
    if strangers:
        raise BadInput(
            [f"wires: {unknown('participant', name, participants)}" for name in strangers]
        )
    tables: dict[str, dict[str, Any]] = {}
    own: dict[str, Any] = {}
    for name, origin in participants.items():
        tables[name] = {"parameters": by_participant.get(name, {}), "build": options.get(name, {})}
        if isinstance(origin, (str, Path)):
            tables[name] |= _file(str(origin))
            continue
        tables[name]["plugin"] = getattr(origin, "__qualname__", type(origin).__qualname__)
        own[name] = origin
        if _is_slave(origin):
            own[name] = partial(in_process, name, origin, options.get(name, {}))
    tree = {
        "title": title or " and ".join(participants),
        "time": {"stop": stop, "step": step},
        "participants": tables,
        "wires": [_wire(wire) for wire in wires],
        "coupling": {"method": method, "order": list(order or participants), **coupling},
        "record": {"fields": list(record)},
    }
    return Case(tree, Path.cwd() / "coupled.toml", own)


def _is_slave(origin: Origin) -> TypeGuard["type[FieldSlave]"]:
    """Return whether an origin is a class derived from `Slave`."""
    if not isinstance(origin, type):
        return False
    from ..fmi.slave import FieldSlave  # slow to import

    return issubclass(origin, FieldSlave)


def in_process(name: str, slave: "type[FieldSlave]", options: Mapping[str, Any]) -> Any:
    """Return a participant of a model class in this process, without an FMU."""
    from ..participants.local import LocalParticipant

    with tempfile.TemporaryDirectory() as folder:  # read for its options only, immediately
        (Path(folder) / "build.json").write_text(json.dumps(dict(options)))
        participant = LocalParticipant(name, slave(instance_name=name, resources=folder))
    participant.can_serialise = False  # a checkpoint may be read by a process without this class
    return participant


def _file(origin: str) -> dict[str, str]:
    """Return the table entry of a participant in a file."""
    if ".py:" in origin:
        return {"file": origin}
    return {"table" if origin.endswith(".csv") else "fmu": origin}


def _wire(wire: str | Mapping[str, Any]) -> dict[str, Any]:
    """Return the table of a wire."""
    if not isinstance(wire, str):
        return dict(wire)
    source, arrow, target = (part.strip() for part in wire.partition("->"))
    if not arrow:
        raise BadInput(f"wires: expected 'participant.output -> participant.input', got {wire!r}")
    return {"from": source, "to": target}
