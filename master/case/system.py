"""Participants and wires of a case, checked before the run."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..coupling.wiring import HeldWire, System, Wire, port_of
from ..coupling.work import conjugates
from ..fmi.errors import BadInput, collecting
from ..participants.plugins import plugin
from ..participants.substeps import Substeps
from .ahead import (
    Ahead,
    ahead,
    angular_speed,
    check_ports,
    check_time,
    declared_wires,
    faults_ahead,
)
from .contract import contract, players, starting_order, unable_to_iterate
from .given import build_options, masks
from .inputs import check_fixed, interpolating, slopes, with_one_way
from .machine_code import native_choice
from .opening import open_participant
from .symmetry import half_films
from .times import record_interval
from .values import parameter_values
from .wires import (
    check_elements,
    conversions_of,
    converting,
    different_items,
    give_types,
    in_units_of_wires,
    is_clock,
    is_real,
    wire_of,
)

MASTER = "master.coupling"
"""Package with the entries of a native coupled FMU, which also iterates runs."""


def open_system(
    case: Any,
    folder: Path,
    progress: Callable[[str], object],
    own: Mapping[str, Callable[[], Any]] | None = None,
    fmu_options: Mapping[str, Any] | None = None,
) -> Any:
    """Build or open every FMU of the case, and check the system before it runs.

    Parameters
    ----------
    case : Case
    folder : Path
        Folder of the case.
    progress : callable
        Called with messages.
    own : mapping, optional
        Constructors of participants that exist only in this process, by name.
    fmu_options : mapping, optional
        As for `builder.build_fmu`, for FMUs in Python. Default: in machine code where possible.

    Raises
    ------
    BadInput
        With every fault: first those found before anything is built, then those of all build
        options, then those of parameters, wires, recorded names and time.
    """
    if faults := faults_ahead(case, folder):
        raise BadInput(faults)
    declared = ahead(case, folder)
    builds, opened = _open_all(case, folder, declared, faults, progress, own, fmu_options)
    halves = half_films(case, folder, declared, builds, faults)
    parameters = {
        name: parameter_values(
            one, {**halves.get(name, {}), **case.participants[name].parameters}, faults
        )
        for name, one in opened.items()
    }
    check_elements(case.wires, opened, faults)
    give_types(case.wires, opened, faults)
    joined = [wire_of(table, opened, case.coupling, faults) for table in case.wires]
    wires = [_mirrored(wire, halves) for wire in joined if isinstance(wire, Wire)]
    reals = [table for table in case.wires if is_real(table, opened)]
    of_clocks = {port_of(t.target) for t in case.wires if is_clock(t.target, opened)}
    handed = [wire for wire in joined if isinstance(wire, HeldWire)]
    uniterated = [wire for wire in handed if wire.target not in of_clocks]
    conversions = {} if faults else conversions_of(reals, opened)
    in_units_of_wires(parameters, conversions)
    participants = with_one_way(case, converting(opened, conversions), faults)
    participants = interpolating(case, participants, {wire.target for wire in wires}, faults)
    with collecting(faults):
        conjugates(wires, case.wires)
    check_fixed(case, participants, faults)
    check_ports(case, participants, faults)
    _check_plugins(case, faults)
    clock = check_time(case, parameters, faults)
    if faults or clock is None:
        raise BadInput(faults)
    for line in different_items(case.wires, opened):
        progress(line)
    participants = _as_they_start(participants, wires, progress)
    wires += slopes(case, participants, wires, clock.step)
    _give_step(opened, clock.step)
    return System(
        participants=participants,
        order=tuple(case.coupling.order),
        wires=tuple(wires),
        parameters=parameters,
        stop=clock.stop,
        step=clock.step,
        smallest_step=clock.smallest_step,
        folder=str(folder),
        parallel=case.coupling.parallel,
        held=tuple(uniterated),
        begin=clock.start,
        period=clock.period,
        earliest=clock.earliest,
        masks=masks(case, builds, folder),
        clocks=tuple(wire for wire in handed if wire.target in of_clocks),
        record_interval=record_interval(case, angular_speed(case, parameters)),
        trusted=frozenset(name for name, table in case.participants.items() if table.rollback),
        limits=_limits(case, participants),
    )


def _open_all(case, folder, declared, faults, progress, own, fmu_options):
    """Return the build options and the participants by name, as `open_system`."""
    finished = open_finished(case, folder, declared, faults, progress, own)
    if faults:
        raise BadInput(faults)
    native, _ = (set(), []) if fmu_options else native_choice(case, folder, declared.parameters)
    if case.native:
        from ..fmi.builder_native import compile_ahead

        packages = [case.participants[name].package for name in sorted(native)]
        coupled = [MASTER] if native == case.participants.keys() else []
        compile_ahead([*coupled, *packages], progress)
    builds = build_options(case, folder, progress)
    participants = {}
    for name in case.participants:
        with collecting(faults, f"participants.{name}."):
            participants[name] = finished.get(name) or open_participant(
                name,
                case,
                builds[name],
                folder,
                progress,
                native=name in native,
                earlier=[*participants.values()],
                fmu_options=fmu_options,
            )
    if faults:
        raise BadInput(faults)
    return builds, participants


def _give_step(participants, step):
    """Give the macro step to participants that take sub-steps of it."""
    for participant in participants.values():
        described = getattr(participant, "described", participant)
        if isinstance(described, Substeps) and described.length is None:
            described.length = step


def _limits(case, participants):
    """Return the outputs with the longest step of the participants that have one."""
    tables = {name: {"role": table.role} for name, table in case.participants.items()}
    ports = (
        (name, terms.longest_step)
        for role, terms in contract().items()
        for name in players({"participants": tables}, role)
    )
    return tuple(
        (name, output) for name, output in ports if output and output in participants[name].fields
    )


def _mirrored(wire, halves):
    """Return the wire, marked if a film at one end of its field computes one half only."""
    owners = {wire.source[0], wire.target[0]}
    return replace(wire, mirrored=len(wire.shape) > 1 and not owners.isdisjoint(halves))


def open_finished(
    case: Any,
    folder: Path,
    declared: Ahead,
    faults: list[str],
    progress: Callable[[str], object] = lambda text: None,
    own: Mapping[str, Callable[[], Any]] | None = None,
) -> dict[str, Any]:
    """Return the participants that need no build, by name; append every fault of them.

    They are compared with the variables that the others declare, before any body is reduced.
    """
    opened = {}
    for name, table in case.participants.items():
        make = (own or {}).get(name)
        if make is None and (table.package or table.file):
            continue
        with collecting(faults, f"participants.{name}."):
            opened[name] = (
                make()
                if make
                else open_participant(name, case, {}, folder, progress, earlier=[*opened.values()])
            )
            if table.fmu and table.role in contract():
                faults += [
                    f"participants.{name}.{line}" for line in unable_to_iterate(opened[name])
                ]
    if opened.keys() == case.participants.keys():
        return opened  # nothing is built, so that all further faults are found together
    known = declared.participants | opened
    for name, participant in opened.items():
        parameter_values(participant, case.participants[name].parameters, faults)
    declared_wires(case, known, faults)
    if opened and known.keys() == case.participants.keys():
        check_ports(case, known, faults)
    return opened


def _check_plugins(case, faults):
    """Append the faults of observers and step control."""
    names = [("observers", name) for name in case.observers]
    if case.coupling.step_control:
        names.append(("step_controls", case.coupling.step_control))
    for kind, name in names:
        with collecting(faults):
            plugin(kind, name)


def _as_they_start(participants, wires, progress):
    """Return the participants in the order in which they start; report a changed order."""
    order = starting_order(participants, wires)
    late = [name for name, first in zip(participants, order) if name != first]
    if late:
        progress(f"participants start in the order {', '.join(order)}: films after their bodies")
    return {name: participants[name] for name in order}
