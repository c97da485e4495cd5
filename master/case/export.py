"""One FMU of a whole case, which iterates inside, for tools that cannot repeat a step."""

import json
import re
import tempfile
from collections import Counter
from dataclasses import asdict, replace
from math import inf, isfinite
from pathlib import Path
from typing import Any

from ..coupling.coupled import Coupled
from ..coupling.methods import METHODS
from ..coupling.native_given import (
    coupled_inside,
    not_started_with,
    uncovered,
    uncovered_wires,
    without_derivative,
)
from ..fmi.builder import code_of, code_with, pack_fmu, slave_of
from ..fmi.builder_native import cannot_build, pack_native_fmu, part_of, slave_inside
from ..fmi.errors import BadInput, collecting
from ..fmi.slave import Experiment
from ..fmi.tree import import_part
from .ahead import run_ahead
from .given import build_options
from .system import MASTER, open_system

COUPLED = "master.coupling.coupled"
"""Part of the master inside the FMU, with all its imports."""


def export_fmu(case, folder, progress, version="2.0", platforms=()):
    """Return the FMU of the coupled case.

    Its inputs are those that no wire feeds. It has all parameters, whose start values are those of
    the case. Its outputs are all scalars, and in FMI 3.0 also all fields. A name that several
    participants share becomes participant.name.

    Parameters
    ----------
    case : Case
    folder : Path
        Folder of relative paths in the case.
    progress : callable
        Called with a message before long work.
    version : {"2.0", "3.0"}
        Version of FMI. 3.0 needs a C compiler.
    platforms : sequence of str
        Platforms of a native FMU that needs no Python, see `compiler.PLATFORMS`. If empty,
        the FMU runs in Python.

    Returns
    -------
    Path
        The FMU in the user's cache.

    Raises
    ------
    BadInput
        With every fault of the case. Participants must be packages, because an FMU cannot contain
        others. With platforms, also with all features that machine code does not cover.
    """
    faults = [
        f"participants.{name}: expected a package inside one FMU, got {kind}"
        for name, table in case.participants.items()
        for kind in ("fmu", "table", "plugin", "file")
        if getattr(table, kind) and not table.package
    ]
    faults += [
        f"wire {wire.source} -> {wire.target}: expected held inputs inside one FMU, got {kind!r}"
        for wire in case.wires
        if (kind := wire.interpolation or case.coupling.inputs) != "held"
    ]
    if case.coupling.method not in METHODS:
        faults.append(
            f"coupling.method: expected one of {', '.join(METHODS)} inside one FMU, "
            f"got {case.coupling.method!r}"
        )
    faults += _uncovered_ahead(case, platforms) if platforms else []
    if faults:
        raise BadInput(faults)
    system = open_system(case, folder, progress)
    if system.held:
        raise BadInput(
            [
                f"wire {'.'.join(wire.source)} -> {'.'.join(wire.target)}: "
                "expected real inputs inside one FMU, got another type or a parameter"
                for wire in system.held
            ]
        )
    builds = build_options(case, folder, progress)
    packages = {name: table.package for name, table in case.participants.items()}
    codes = {name: code_of(package) for name, package in packages.items()}
    prepared = {
        name: import_part(f"{package}.build").prepare(builds[name], Path(folder), progress)
        for name, package in packages.items()
    }
    exposed = _exposed(
        {name: _variables(packages[name], options) for name, (options, _) in prepared.items()},
        system,
        fields=version == "3.0",
    )
    name = re.sub(r"\W", "_", Path(folder).resolve().name, flags=re.ASCII)
    options = {
        "name": name if name.isidentifier() else f"engine_{name}",
        "title": case.title,
        # a list, because names in a table would be sorted
        "participants": [
            [name, codes[name].name, codes[name].slave] for name in system.participants
        ],
        "order": list(system.order),
        "step": system.step,
        "wires": [asdict(c) for c in system.wires],
        "limits": system.limits,
        "coupling": case.coupling.model_dump(),
        "variables": [asdict(variable) for variable, _ in exposed],
        **{
            causality: {v.name: port for v, port in exposed if v.causality == causality}
            for causality in ("parameter", "input", "output")
        },
    }
    usual = experiment(system.earliest, system.step, system.wires)
    if platforms:
        return _pack_native(options, prepared, system, usual, progress, (version, platforms))
    return pack_fmu(
        options["name"],
        code_with(f"{COUPLED}:Coupled", COUPLED),
        options,
        _resources(prepared),
        progress,
        version,
        participants=codes.values(),
        experiment=usual,
    )


def _uncovered_ahead(case, platforms):
    """Return faults of features that machine code does not cover, from the case alone."""
    faults = [*uncovered(case.coupling), *uncovered_wires(case.wires)]
    packages = set()
    for name, table in case.participants.items():
        if not table.package:
            continue
        with collecting(faults):
            part = part_of(table.package)
            packages.add(table.package)
            ahead = part.uncovered(table.build)
            faults += [f"participants.{name}.build.{fault}" for fault in ahead]
    return [*cannot_build(platforms, (MASTER, *sorted(packages))), *faults]


def _pack_native(options, prepared, system, usual, progress, made_for):
    """Return the native FMU.

    Parameters
    ----------
    options : dict
        Content of build.json.
    prepared : dict
        Participant -> its checked build options, and the files that they name.
    system : System
    usual : Experiment
    progress : callable
    made_for : (str, sequence of str)
        Version of FMI and platforms.
    """
    version, platforms = made_for
    slave = _coupled_slave(options)
    slaves = {name: path for name, (_, path) in slave.inside.participants.items()}
    packages = {name: path.partition(".")[0] for name, path in slaves.items()}
    codes = sorted(set(packages.values()))
    parts = {name: part_of(package) for name, package in packages.items()}
    faults = [
        f"participants.{name}.build.{fault}"
        for name, part in parts.items()
        for fault in part.uncovered(prepared[name][0])
    ]
    if faults:
        raise BadInput(faults)
    insides = {
        name: slave_inside(packages[name], part, *prepared[name]) for name, part in parts.items()
    }
    faults = [
        *uncovered_wires(system.wires),
        *without_derivative(system.wires, insides),
        *not_started_with(insides, system.parameters),
    ]
    if slave.string:
        faults.append("participants: expected no texts in a native FMU, got some")
    if faults:
        raise BadInput(faults)
    slave.experiment = usual
    inside = coupled_inside(
        slave, insides, {name: codes.index(package) for name, package in packages.items()}
    )
    return pack_native_fmu(
        options["name"],
        inside,
        progress,
        version,
        platforms=platforms,
        package=MASTER,
        participants=codes,
    )


def _coupled_slave(options):
    """Return the coupled model in Python, with its variables and their positions."""
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "build.json").write_text(json.dumps(options, sort_keys=True))
        return Coupled(instance_name="native", resources=scratch)


def experiment(stop, step, wires):
    """Return a case's experiment: stop, longest step, tightest tolerance over its nominal."""
    shares = [wire.tolerance / wire.nominal for wire in wires if wire.tolerance > 0.0]
    tightest = min(shares, default=inf)
    return Experiment(stop, step, tightest if isfinite(tightest) else None)


def experiment_ahead(case: Any, folder: Path) -> Any:
    """Return the experiment of a case before anything is built, for the FMU of one participant.

    Returns None if it depends on variables that are not declared.

    Parameters
    ----------
    case : Case
    folder : Path
        Folder of the case.
    """
    clock, wires = run_ahead(case, folder)
    return experiment(clock.earliest, clock.step, wires) if clock else None


def _variables(package, options):
    module, slave = slave_of(package).split(":")
    return getattr(import_part(module), slave).variables(options)


def _exposed(tables, system, fields):
    """Return pairs (variable of the coupled FMU, (participant, name inside))."""
    fed = {wire.target for wire in system.wires}
    chosen = [
        (owner, v)
        for owner, table in tables.items()
        for v in table
        if _is_exposed(v, (owner, v.name) in fed, fields)
    ]
    shared = Counter(v.name for _, v in chosen)
    exposed = []
    for owner, v in chosen:
        name = v.name if shared[v.name] == 1 else f"{owner}.{v.name}"
        outside = v.starting(system.parameters[owner].get(v.name, v.start))
        exposed.append((replace(outside, name=name), (owner, v.name)))
    return exposed


def _is_exposed(variable, is_fed, fields):
    if variable.causality == "output":
        return fields or not variable.shape
    return variable.causality != "constant" and not is_fed


def _resources(prepared):
    """Return each participant's resources in a folder of its name."""
    files = {
        f"{name}/build.json": json.dumps(options, sort_keys=True).encode()
        for name, (options, _) in prepared.items()
    }
    return files | {
        f"{name}/{path.name}": path.read_bytes()
        for name, (_, paths) in prepared.items()
        for path in paths
    }
