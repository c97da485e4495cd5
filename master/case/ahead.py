"""Faults of a case that are found before anything is built."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from ..coupling.wiring import Wire, port_of
from ..fmi.errors import BadInput, collecting, file_fault
from ..fmi.fields import NO_NUMBERS
from ..fmi.quantities import from_si, to_si
from .keys import declared_variables
from .machine_code import native_choice
from .schema import reduced
from .symmetry import symmetry_faults
from .times import record_interval, times
from .values import parameter_values
from .wires import check_sources, field_of, wire_of


@dataclass(frozen=True)
class DeclaredParticipant:
    """Participant before its FMU is built, with the variables that its part declares."""

    name: str
    path: Path
    fields: dict[str, Any]
    declares_units: bool = True


class Ahead(NamedTuple):
    """Participants whose parts declare their variables, by name, before anything is built.

    parameters : valid parameters in SI, by participant; faults : of build options and parameters.
    """

    participants: dict[str, DeclaredParticipant]
    parameters: dict[str, dict[str, Any]]
    faults: list[str]


def ahead(case: Any, folder: Path) -> Ahead:
    """Return what the parts of a case declare."""
    declared = {}
    faults: list[str] = []
    for name, table in case.participants.items():
        with collecting(faults, f"participants.{name}."):
            variables = declared_variables(table, folder)
            if variables is not None:
                fields = {one.name: _as_fmu(one) for one in variables}
                declared[name] = DeclaredParticipant(name, Path(table.package), fields)
    parameters = {
        name: parameter_values(participant, case.participants[name].parameters, faults)
        for name, participant in declared.items()
    }
    return Ahead(declared, parameters, faults)


def faults_ahead(case, folder):
    """Return every fault of a case that is found before anything is built.

    These are faults of build options, parameters, wires, recorded and drawn names, and time. The
    participants must come from parts that declare their variables.

    Parameters
    ----------
    case : Case
    folder : Path
        Folder of the case.

    Returns
    -------
    list of str
    """
    known = ahead(case, folder)
    declared, parameters, faults = known
    check_sources(case.wires, faults)
    declared_wires(case, declared, faults)
    faults += symmetry_faults(case, folder, known)
    for name, table in case.participants.items():
        if fault := missing_file(table, folder):
            faults.append(f"participants.{name}.{fault}")
    faults += native_choice(case, folder, parameters)[1]
    if declared.keys() == case.participants.keys():
        check_ports(case, declared, faults)
        check_time(case, parameters, faults)
    return faults


def reject_asymmetry(case: Any, folder: Path) -> None:
    """Raise BadInput for keys of a case that assume a symmetry which its films do not have."""
    if faults := symmetry_faults(case, folder, ahead(case, folder)):
        raise BadInput(faults)


def declared_wires(case, declared, faults):
    """Return the wires of real numbers between these participants; append faults."""
    joined = [
        wire_of(table, declared, case.coupling, faults)
        for table in case.wires
        if {port_of(table.source)[0], port_of(table.target)[0]} <= declared.keys()
    ]
    return [wire for wire in joined if isinstance(wire, Wire)]


def run_ahead(case, folder):
    """Return the clock of the run and its wires of real numbers, before anything is built.

    The clock is None if the variables of the participant with the angular speed are not declared.
    """
    declared, parameters, ignored = ahead(case, folder)
    wires = declared_wires(case, declared, ignored)
    turning = case.time.angular_speed
    if turning and port_of(turning)[0] not in declared:
        return None, wires
    return check_time(case, parameters, ignored), wires


def _as_fmu(variable):
    """Return a declared variable with the choices of an enumeration by number, as in FMUs."""
    numbers: Any = {text: k for k, text in enumerate(variable.choices, 1)}
    return replace(variable, choices=numbers)


def check_time(case, parameters, faults):
    """Return the clock of the run; None after a fault."""
    if case.time.angular_speed:
        owner, name = port_of(case.time.angular_speed)
        declared = case.participants[owner].parameters
        if name in declared and name not in parameters[owner]:
            return None  # its value is a fault that is already in the list
    with collecting(faults):
        speed = angular_speed(case, parameters)
        record_interval(case, speed)
        return times(case, speed)
    return None


def angular_speed(case, parameters):
    """Return the angular speed that converts angles to times [rad/s]; None without angles."""
    if case.time.angular_speed is None:
        return None
    owner, name = port_of(case.time.angular_speed)
    if name not in parameters[owner]:
        raise BadInput(
            f"time.angular_speed: expected a parameter with a value, got "
            f"{case.time.angular_speed!r}; set it in participants.{owner}.parameters"
        )
    return parameters[owner][name]


def missing_file(table, folder):
    """Return the fault of the path of a participant's FMU or table; "" if there is none."""
    key = "fmu" if table.fmu else "table"
    name = getattr(table, key)
    try:
        if not name or (folder / name).is_file():
            return ""
        (folder / name).open().close()
    except (OSError, ValueError) as error:
        return f"{key}: {file_fault(name[:80], error)}"
    return f"{key}: expected a file, got {name!r}"


def check_ports(case, participants, faults):
    outputs = ("output", "input", "parameter", "local")
    for k, port in enumerate(case.record.fields):
        if port in case.record.fields[:k]:
            faults.append(f"record.fields: expected different names, got {port} twice")
        field = field_of(port, outputs, participants, "record.fields", faults)
        if field is not None and 0 in field.shape:
            faults.append(
                f"record.fields: expected an array with elements, got {port} of shape {field.shape}"
            )
        if field is not None and field.type in NO_NUMBERS:
            faults.append(f"record.fields: expected numbers, got {port} of type {field.type}")
    for where, port in _curves(case):
        field = field_of(port, ("output",), participants, where, faults)
        if field is not None and (field.shape or field.type in NO_NUMBERS):
            shape = f"an array of shape {field.shape}" if field.shape else f"a {field.type}"
            faults.append(f"{where}: expected a scalar number, got {port}, {shape}")
        if field is not None and where.startswith("window."):
            _check_window(where, case.window[where.removeprefix("window.")], field.unit, faults)
    for picture in case.pictures:
        for port in picture.fields:
            field_of(port, ("output",), participants, f"pictures.{picture.file}", faults)
        _check_shown_units(picture, participants, faults)


def _check_window(where, limits, unit, faults):
    """Append a fault if the limits of a window are no rising quantities of the unit."""
    try:
        low, high = (to_si(limit, unit) for limit in limits)
        if low > high:
            faults.append(f"{where}: expected [low, high], got {list(limits)}")
    except ValueError as error:
        faults.append(f"{where}: {error}")


def _check_shown_units(picture, participants, faults):
    """Append a fault for each unit of a picture that its variable cannot be shown in."""
    for port, unit in picture.units.items():
        where = f"pictures.{picture.file}, units.{port}"
        owner, _, name = port.partition(".")
        field = participants[owner].fields.get(name) if owner in participants else None
        try:
            if field is not None:
                from_si(1.0, field.unit, unit)
        except ValueError as error:
            faults.append(f"{where}: {error}")


def _curves(case):
    """Yield (location, port) of all scalar outputs in summaries, pictures and studies."""
    for table in ("summary", "monitor"):
        for name, text in getattr(case, table).items():
            yield f"{table}.{name}", reduced(text).port
    for text in case.window:
        yield f"window.{text}", reduced(text).port
    for picture in case.pictures:
        for port in picture.outputs:
            yield f"pictures.{picture.file}", port
    for name, study in case.studies.items():
        for port in filter(None, (study.x, *study.curves)):
            yield f"studies.{name}", port
