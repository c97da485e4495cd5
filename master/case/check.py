"""Check of a case before anything is built: faults, previews of its parts, agreement of parts."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..fmi.errors import BadInput, ParticipantFault
from ..fmi.fields import base_of
from ..fmi.preview import Figure, Preview
from ..fmi.quantities import short, to_si
from ..fmi.tree import import_part
from .ahead import Ahead, ahead, faults_ahead, run_ahead
from .changes import changes_of_variant
from .checked import check_case
from .contract import contract, given_by_others
from .optional_wires import overrides
from .reading import find_case, read_tree
from .schema import Case
from .symmetry import groups
from .system import open_finished, open_system

if TYPE_CHECKING:
    from ..coupling.loops import Loop

MEASURE_TOLERANCE = 2e-3
"""Relative tolerance of a length or volume that two parts measure. The straight edges of a mesh
are a thousandth inside its cylinder."""


MOST_STEPS = 1e6
"""Number of macro steps of a run that takes hours."""
FEWEST_STEPS = 72
"""Macro steps in a period that resolve motion and gas: 10 deg in four strokes, our own choice."""


@dataclass(frozen=True)
class CheckedCase:
    """Check of a case before it is built.

    path : of the case file; title : of the case; previews : by participant; faults : all of
    them; warnings : likely errors; remarks : assumptions; loops : components of the wires, for a
    system of FMUs.
    """

    path: Path
    title: str
    previews: dict[str, Preview] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    loops: "list[Loop]" = field(default_factory=list)

    def figure(self, name: str) -> Figure | None:
        """Return the figure "participant.name", None if there is none."""
        owner, _, own = name.partition(".")
        return self.previews[owner].figure(own) if owner in self.previews else None

    def loop_table(self) -> list[str]:
        """Return the loops as lines of text, with a header."""
        return [self.loops[0].header, *(one.line for one in self.loops)] if self.loops else []

    def draw(self, path: Path) -> list[Path]:
        """Write the pictures of all parts to PNG files, and return their paths.

        If there are several, their names contain the participants.
        """
        drawing = {name: one.draw for name, one in self.previews.items() if one.draw}
        written = []
        for name, draw in drawing.items():
            file = path if len(drawing) == 1 else path.with_name(f"{path.stem}-{name}{path.suffix}")
            file.parent.mkdir(parents=True, exist_ok=True)
            draw(file)
            written.append(file)
        return written


def check(
    name: str | Path, changes: Sequence[tuple[str, Any]] = (), variant: str | None = None
) -> CheckedCase:
    """Check a case.

    Parameters
    ----------
    name : str or Path
        Name of a case, its folder or its file.
    changes : sequence of (key, value)
        Changes to make first.
    variant : str, optional
        Label of a variant of the case. Default: the case itself.

    Raises
    ------
    BadInput
        If there is no such case or variant, or if it is not TOML.
    """
    path = find_case(str(name))
    varied = changes_of_variant(read_tree(path), variant) if variant is not None else {}
    tree = read_tree(path, [*varied.items(), *changes])
    try:
        case = check_case(tree, path)
    except BadInput as error:
        title = tree.get("title", "")
        return CheckedCase(path, str(title), faults=error.faults)
    folder = path.parent
    faults = faults_ahead(case, folder)
    declared = ahead(case, folder)
    previews = _previews(case, folder, declared)
    for owner, one in previews.items():
        lines = [f"participants.{owner}, {line}" for line in one.faults]
        faults += [line for line in lines if line not in faults]
    faults += _disagreements(case, declared, previews)
    if not faults:
        open_finished(case, folder, declared, faults)
    # without its value, figures and messages would be those of a default
    previews = {name: one for name, one in previews.items() if not _refused(case, name, declared)}
    warnings = [f"{owner}: {line}" for owner, one in previews.items() for line in one.warnings]
    warnings += _contradictions(case, declared, previews)
    warnings += _without_a_value(case, declared)
    warnings += _warnings_on_steps(case, folder)
    remarks = [f"{owner}: {line}" for owner, one in previews.items() for line in one.remarks]
    remarks += [
        f"{claim}: the symmetry of {', '.join(group.unknown)} is not known; the check after a run "
        "measures the odd part of the film"
        for group in groups(case, folder, declared)
        for claim in (group.claims if group.unknown else ())
    ]
    loops = _loops(case, folder, faults, remarks) if not faults else []
    warnings += [
        f"coupling.method: {one.unstable}"
        for one in loops
        if one.unstable and (case.coupling.method == "explicit" or one.component.fixed)
    ]
    return CheckedCase(
        path=path,
        title=case.title,
        previews=previews,
        faults=faults,
        warnings=warnings,
        remarks=remarks,
        loops=loops,
    )


def _warnings_on_steps(case: Case, folder: Path) -> list[str]:
    """Return warnings on a run of very many macro steps, a long macro step and the period."""
    clock, _ = run_ahead(case, folder)
    if clock is None:
        return []
    out: list[str] = []
    steps, by_period = (clock.stop - clock.start) / clock.step, clock.period / clock.step
    if steps > MOST_STEPS:
        out.append(f"time.stop = {case.time.stop}: the run has {steps:.2g} macro steps")
    if (cycle := case.cycle) and case.time.period and case.time.angular_speed:
        cycles = to_si(case.time.period, "rad") / to_si(cycle, "rad")
        if abs(cycles - round(cycles)) > MEASURE_TOLERANCE:
            out.append(
                f"time.period = {case.time.period}: expected a multiple of {cycle}, the cycle of "
                "gas or speed; a summary of the last period is not that of a cycle"
            )
    if 0.0 < by_period < FEWEST_STEPS:
        out.append(
            f"time.step = {case.time.step}: expected at least {FEWEST_STEPS} macro steps in a "
            f"period of {case.period}, got {by_period:.3g}"
        )
    return out


def _loops(case: Case, folder: Path, faults: list[str], remarks: list[str]) -> "list[Loop]":
    """Return the loops of a system of finished FMUs, measured at its start; append messages."""
    tables = case.participants.values()
    if not case.wires or any(table.package for table in tables):
        return []  # it must be built first
    from ..coupling.loops import loops  # slow to import, and most cases do not need it
    from ..coupling.starting import closing, start

    try:
        system = open_system(case, folder, remarks.append)
        with closing(system.participants.values()):
            start(system)
            return loops(system)
    except BadInput as error:
        faults += error.faults
    except ParticipantFault as fault:
        faults.append(str(fault))
    return []


def _previews(case: Case, folder: Path, declared: Ahead) -> dict[str, Preview]:
    """Return the previews of the participants whose parameters are valid."""
    previews = {}
    for name, parameters in declared.parameters.items():
        table = case.participants[name]
        try:
            look = import_part(f"{table.package}.preview").preview
        except ImportError:
            continue  # a part of another package
        fields = declared.participants[name].fields
        worded = {
            key: [*fields[key].choices][value - 1] if fields[key].choices else value
            for key, value in parameters.items()
        }
        refused = dict.fromkeys(_refused(case, name, declared))
        previews[name] = look(table.build, worded | refused, folder)
    return previews


def _refused(case: Case, name: str, declared: Ahead) -> list[str]:
    """Return the rejected parameters of a participant, which are already in the faults."""
    known, taken = declared.participants[name].fields, declared.parameters[name]
    return [key for key in case.participants[name].parameters if key in known and key not in taken]


def _contradictions(case: Case, declared: Ahead, previews: dict[str, Preview]) -> list[str]:
    """Return warnings on inputs of films that the case gives twice, with their difference.

    The contract lists them. The value of the film applies.
    """
    warnings = []
    for film, body, variable, source, is_offered, figures in overrides(case):
        where = f"participants.{film}"
        if source:
            if is_offered:
                warnings.append(
                    f"{where}.{variable}: {source} replaces that of the walls of {body}"
                )
            continue
        for key, figure in figures.items():
            measured = previews.get(body, Preview()).figure(figure)
            own = declared.parameters.get(film, {}).get(key)
            if measured is not None and own is not None:
                unit = measured.unit
                warnings.append(
                    f"{where}.parameters.{key} = {short(own, unit, 4)}: the walls of {body} give "
                    f"{short(measured.value, unit, 4)}, {own - measured.value:+.3g} {unit}"
                )
    return warnings


def _without_a_value(case: Case, declared: Ahead) -> list[str]:
    """Return warnings on inputs that need a wire or a value, and have neither.

    The contract lists them, without the film surface that may precede them.
    """
    wired = {base_of(wire.target) for wire in case.wires}
    return [
        f"{name}.{variable}: expected a wire or a value in parameters, got neither; it keeps its "
        "start value"
        for name, table in case.participants.items()
        if table.role in contract() and name in declared.participants
        for variable in declared.participants[name].fields
        if variable.rpartition(".")[2] in contract()[table.role].needs
        and f"{name}.{variable}" not in wired
        and variable not in table.parameters
    ]


def _disagreements(case: Case, declared: Ahead, previews: dict[str, Preview]) -> list[str]:
    """Return faults of parameters that differ from the measurement of another part.

    The contract lists the pairs that must agree. An omitted parameter has its default. Rejected
    parameters are not compared.
    """
    faults = []
    for name, key, (giver, surface), figure in given_by_others(case, "agree"):
        preview = previews.get(giver, Preview())
        measured = preview.figure(f"{surface}{figure}") or preview.figure(figure)
        if measured is None or name not in declared.participants:
            continue
        fields, values = declared.participants[name].fields, declared.parameters[name]
        if key not in fields or key in _refused(case, name, declared):
            continue
        value = values.get(key, fields[key].start)
        if abs(value - measured.value) > MEASURE_TOLERANCE * abs(measured.value):
            default = "" if key in values else ", its default"
            faults.append(
                f"participants.{name}.parameters.{key}: expected "
                f"{short(measured.value, measured.unit, 5)}, the {figure.replace('_', ' ')} of "
                f"{f'{giver}.{surface}'.removesuffix('.')}, got "
                f"{short(value, measured.unit, 5)}{default}"
            )
    return faults
