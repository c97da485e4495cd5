"""Participants of a case: FMUs that are built or opened, tables and plugins."""

from functools import partial

from ..fmi.errors import BadInput
from ..fmi.quantities import to_si
from ..participants.isolated import IsolatedParticipant
from ..participants.open import open_fmu
from ..participants.plugins import from_plugin
from ..participants.table import TableParticipant
from .contract import in_contract_units
from .values import value_of


def open_participant(
    name,
    case,
    build,
    folder,
    progress=lambda text: None,
    native=False,
    earlier=(),
    fmu_options=None,
):
    """Return a participant of a case; `earlier` are those that are already open.

    `fmu_options` : see `system.open_system`.
    """
    table = case.participants[name]
    if table.plugin:
        return from_plugin("participants", table.plugin, name, table.build, folder)
    if table.table:
        return TableParticipant(name, folder / table.table, table.interpolation or "linear")
    path = path_of_fmu(table, build, folder, progress, native, fmu_options)
    elements = case.elements_of(name)
    options = {
        "step": table.step and to_si(table.step, "s"),
        "elements": elements,
        "event_mode": table.event_mode,
    }
    open_with = partial(open_fmu, name, path, **options)
    opened = open_with()
    if sizes := _sizes(opened, table.parameters):
        opened = open_with(sizes)
    in_contract_units(opened, table.role)
    opened.check_library()
    timeout = to_si(table.timeout, "s")
    is_second = any(getattr(one, "only_once", None) == opened.only_once for one in earlier)
    if opened.only_once and is_second and not table.isolated:
        progress(f"{name}: runs isolated, because a process can instantiate its FMU only once")
    elif not table.isolated:
        return opened
    return IsolatedParticipant(opened, timeout)


def _sizes(participant, texts):
    """Return the values of the structural parameters of the case."""
    faults, sizes = [], {}
    for name, text in texts.items():
        field = participant.fields.get(name)
        if field is not None and field.causality == "structuralParameter":
            try:
                sizes[name] = value_of(field, text)
            except ValueError as error:
                faults.append(f"parameters.{name}: {error}")
    if faults:
        raise BadInput(faults)
    return sizes


def path_of_fmu(table, build, folder, progress, native, fmu_options=None):
    """Return the path of a participant's FMU; build it if necessary.

    `native` : as machine code; `fmu_options` : see `system.open_system`.
    """
    if table.package or table.file:
        return _built(table, build, folder, progress, native, fmu_options or {})
    return folder / table.fmu


def _built(table, build, folder, progress, native, fmu_options):
    """Build the FMU of a package or of a file."""
    from ..fmi.builder import build_fmu, build_fmu_of_file
    from ..fmi.builder_native import build_native_fmu
    from ..fmi.compiler import this_platform

    if table.package and native:
        here = [name for name in [this_platform()] if name]
        return build_native_fmu(table.package, build, folder, progress, platforms=here)
    if table.package:
        return build_fmu(table.package, build, folder, progress, **fmu_options)
    return build_fmu_of_file(
        str(folder / table.file), build, progress, fmu_options.get("version", "2.0")
    )
