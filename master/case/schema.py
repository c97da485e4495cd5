"""Case files: TOML with units -> a checked `Case`, every fault of the file in one message."""

import re
import tomllib
from copy import deepcopy
from math import floor
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)

from ...models import MODELS
from ..coupling.methods import METHODS
from ..fmi.errors import BadInput
from ..fmi.quantities import registry, to_si
from ..participants.plugins import names

Port = Annotated[str, Field(pattern=r"^\w+\.\S(.*\S)?$")]
"""A variable of a participant: "participant.variable"; the variable's name as the FMU has it, dots,
brackets and all.
"""


def _file_name(text: str) -> str:
    if text in ("", ".", "..") or re.search(r"[/\\\x00-\x1f]", text):
        raise ValueError("must be a plain file name, without / and \\")
    return text


FileName = Annotated[str, AfterValidator(_file_name)]
"""Becomes the name of a file in the output folder, and of none elsewhere."""

REDUCTIONS = ("min", "max", "mean", "last")
TAKEN = ("coupling", "fields", "time")
"""What results files hold beside the participants."""


class Reduced(NamedTuple):
    """What "min|max|mean|last participant.variable" says."""

    kind: str
    port: str


def reduced(text: str) -> Reduced:
    """Kind and port of a summary entry."""
    kind, _, port = text.strip().partition(" ")
    return Reduced(kind, port.strip())


class Table(BaseModel):
    """A table of a case file; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True)


class Time(Table):
    """Run time and macro step: times, or crank angles together with the input that holds the
    angular speed. start : default 0.

    until_periodic : start to stop is one cycle, run again and again until film, motion and oil at
    its end are this near to those at its beginning, as a share of their range (Eq. (Y2),
    `runs/repetition.py`); results and summary are of the last one. most_cycles : that it is run at
    most; a run that has not come so far by then says so.

    smallest_step : where a wire has a `local_error`, `step` is where the run must come by and the
    longest macro step: it is divided by the local error, into none smaller than this; default step
    / 64.
    """

    start: str | None = None
    stop: str
    step: str
    smallest_step: str | None = None
    angular_speed: Port | None = None
    until_periodic: float | None = Field(None, gt=0, lt=1)
    most_cycles: int = Field(20, ge=2, le=1000)

    @property
    def cycles(self) -> int:
        """That the run may take."""
        return 1 if self.until_periodic is None else self.most_cycles


class ParticipantTable(Table):
    """A participant: an FMU by path, or what builds one with options, a package or a slave in one
    file ("FILE.py:CLASS"); or a table, a CSV file of signals; and its parameters and input starts.

    interpolation : of a table's columns between its rows. step : it takes steps of its own inside a
    macro step, equal ones no longer than this. plugin : what another installed package makes by
    that name from `build`, see `participants/plugins.py`.
    role : what it does by the contract of `models`, so that another FMU of that role can take its
    place. isolated : the FMU runs in a process of its own, which is ended if it takes longer than
    `timeout` for any one answer.
    """

    package: str | None = None
    file: str | None = None
    fmu: str | None = None
    table: str | None = None
    plugin: str | None = None
    interpolation: Literal["hold", "linear", "cubic"] | None = None
    step: str | None = None
    build: dict[str, Any] = {}
    parameters: dict[str, str | bool | float | int | list] = {}
    role: str | None = None
    isolated: bool = False
    timeout: str = "120 s"

    @model_validator(mode="after")
    def one_origin(self):
        if [self.package, self.file, self.fmu, self.table, self.plugin].count(None) != 4:
            raise ValueError(
                "give one of package, file (FILE.py:CLASS; both build an FMU), fmu (a file), "
                "table (a CSV file) and plugin"
            )
        if (self.table or self.plugin) and (self.isolated or self.step):
            raise ValueError("only an FMU has a process or a step of its own")
        if self.interpolation and not self.table:
            raise ValueError("interpolation is that of a table; that of an input is its wire's")
        return self


class WireTable(Table):
    """A field that goes from an output to an input.

    tolerance : largest difference between output and input in a converged step; text with the
    field's unit, or a number that multiplies its nominal value. relative_tolerance : root mean
    square of the difference as a share of the field's. residual_relative_tolerance : root mean
    square of the difference as a share of what it was in the macro step's first evaluation. Of
    these three, one that is met is enough. Without any, the tolerance is 1e-6 nominal values on a
    wire that runs against the stepping order. A wire along the order hands over what has just been
    computed: it is not measured, unless one of the three is given; then by how far it has moved
    since the iterate. largest_decrease : no update of an iterate may lower the field's smallest
    element by more than this share of itself. local_error : local error allowed in a macro step,
    root mean square over the field; text with the field's unit, or a number that multiplies its
    nominal value. With it on any wire, macro steps are as long as their local error allows.
    interpolation : the input inside a macro step: held at the value of its end, linear from
    beginning to end, or a cubic that also has the slopes which the source declares (an output that
    is the field's `derivative`). conjugate : output whose product with the field is work or power;
    both sides' account of it is compared at the end.
    """

    source: Port = Field(alias="from")
    target: Port = Field(alias="to")
    tolerance: str | float | None = None
    relative_tolerance: float = Field(0.0, ge=0, lt=1)
    residual_relative_tolerance: float = Field(0.0, ge=0, lt=1)
    largest_decrease: float | None = Field(None, gt=0, lt=1)
    local_error: str | float | None = None
    interpolation: Literal["held", "linear", "hermite"] = "held"
    conjugate: Port | None = None


class Coupling(Table):
    """How a macro step is brought to its fixed point.

    method : newton (directional derivatives and GMRES); iqn_ils, iqn_imvj or iqn_ageing (secants;
    methods/secants.py); aitken, or constant relaxation; explicit: one evaluation a macro step, not
    iterated, and what is off by more than its tolerance counted. order : the order in which the
    participants step; the wires that run against it are the unknowns. parallel : Jacobi's order in
    place of Gauss-Seidel's: nobody reads what another has just computed, all wires are unknowns.
    predictor : order of the extrapolation that begins a macro step, 0 for the last values.
    relaxation : factor of constant relaxation, first factor of the others. mixing : share taken of
    what the secants leave unexplained. probing : a macro step without secants, or led astray by
    them, is taken by Newton on differences of evaluations. windows : of how many macro steps
    iqn_ils and iqn_imvj use the secants; filter, filter_limit : how iqn_ils drops some.
    largest_krylov_space : products per Newton update at most. differences : products by differences
    of evaluations, not by the participants' derivatives. halvings : how often a macro step that
    fails may be halved. method and step_control can be those of another installed package
    (`participants/plugins.py`), which reads `options`.
    """

    method: str = "newton"
    step_control: str | None = None
    options: dict[str, Any] = {}
    order: list[str]
    parallel: bool = False
    predictor: int = Field(2, ge=0, le=2)
    max_iterations: int = Field(20, ge=1)
    relaxation: float = Field(0.5, gt=0, le=1)
    mixing: float = Field(1.0, gt=0, le=1)
    probing: bool = False
    windows: int = Field(3, ge=0)
    filter: Literal["QR1", "QR2", "QR3"] = "QR2"
    filter_limit: float = Field(1e-2, gt=0, lt=1)
    largest_krylov_space: int = Field(120, ge=1)
    differences: bool = False
    halvings: int = Field(6, ge=0)

    @field_validator("method")
    @classmethod
    def known(cls, name):
        known = [*METHODS, *names("methods")]
        if name not in known:
            raise ValueError(f"{name!r} is no method: there are {', '.join(known)}")
        return name


class Record(Table):
    """What goes into the results file: all scalar outputs every macro step, `fields` every so many.

    checkpoint_every : macro steps from one checkpoint to the next; 0 for none but at SIGINT and
    SIGTERM; without it every 50, and no more often than is worth a fiftieth of the time.
    """

    fields: list[Port] = []
    every: int = Field(1, ge=1)
    checkpoint_every: int | None = Field(None, ge=0)


class Picture(Table):
    """One picture. lines: `y` over `x`, panels one below the other; map: `fields` at a time, a
    panel each; section: `fields` at a time along their first index, within `angles` (its whole
    length is 360 deg), at the share `height` of their second.
    """

    file: FileName
    title: str
    kind: Literal["lines", "map", "section"]
    x: Port | None = None
    y: list[list[Port]] = []
    fields: list[Port] = []
    time: str | None = None
    angles: tuple[str, str] = ("0 deg", "360 deg")
    height: float = Field(0.5, ge=0, le=1)
    units: dict[str, str] = {}

    @model_validator(mode="after")
    def complete(self):
        needed = ("x", "y") if self.kind == "lines" else ("fields", "time")
        missing = [key for key in needed if not getattr(self, key)]
        if missing:
            raise ValueError(f"a picture of kind {self.kind!r} needs {' and '.join(missing)}")
        return self


class Axis(Table):
    """What one index of a field runs along, from the beginning of the first cell to the end of the
    last.

    range : of the positions, in `unit`. centred : a position inside it at which a cell has its
    centre; the range moves by half a cell or less, and the axis is one that closes on itself.
    marks : word -> position, written beside the axis.
    """

    label: str
    unit: str = ""
    range: tuple[float, float] = (0.0, 1.0)
    centred: float | None = None
    marks: dict[str, float] = {}

    @property
    def title(self) -> str:
        """Label and unit, as on a picture."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    @property
    def marked(self) -> str:
        """Title and marks, as a sentence."""
        marks = ", ".join(f"{word} {position:g}" for word, position in self.marks.items())
        return f"{self.title}; {marks}" if marks else self.title

    def ends(self, cells):
        """Where the first of so many cells begins and the last one ends."""
        low, high = self.range
        if self.centred is None:
            return low, high
        before = cells * (self.centred - low) / (high - low)
        shift = (before % 1.0 - 0.5) * (high - low) / cells
        return low + shift, high + shift

    def positions(self, cells):
        """Where so many cells have their centres."""
        low, high = self.ends(cells)
        return low + (np.arange(cells) + 0.5) / cells * (high - low)


class Axes(Table):
    """What the two indices of the fields of some participants run along: words for axes, shown and
    nowhere computed with.
    """

    participants: list[str] = Field(min_length=1)
    first: Axis = Axis(label="first index / its number")
    second: Axis = Axis(label="second index / its number")


NEUTRAL = Axes(participants=[""])
"""Of a field that the case says nothing about."""


class Loop(Table):
    """A closed curve and the work in it: the sum of `y` over `x` during the last `period`, divided
    by `per`, in `unit`.
    """

    y: list[Port]
    x: Port
    period: str
    per: str | float = 1.0
    unit: str = "J"


class Motion(Table):
    """A rigid outline moved in a plane by three outputs, between fixed lines.

    Sideways displacement and rotation are drawn `exaggeration` times. Outline points (across,
    along) are those of the body at rest about its reference point; lines have two ends.
    """

    across: Port
    along: Port
    rotation: Port
    outline: list[tuple[str, str]] = Field(min_length=3)
    lines: list[tuple[tuple[str, str], tuple[str, str]]] = []
    exaggeration: float = Field(100.0, gt=0)


class ReportTable(Table):
    """What a report shows beyond pictures and fields: loops by their name, and a moving body."""

    loops: dict[str, Loop] = {}
    motion: Motion | None = None


class Study(Table):
    """Runs of the case that differ in `points` (label -> {dotted key: value}), held against the one
    labelled `reference`.

    `set` changes the case in all of them; `curves` over `x`, if any, are scored against the
    reference's.
    """

    title: str
    set: dict[str, Any] = {}
    points: dict[FileName, dict[str, Any]]
    reference: str
    x: Port | None = None
    curves: list[Port] = []

    @model_validator(mode="after")
    def consistent(self):
        if self.curves and not self.x:
            raise ValueError("curves need an x")
        if self.reference not in self.points:
            raise ValueError(
                f"reference = {self.reference!r}: the points are {', '.join(self.points)}"
            )
        return self


class Case(Table):
    """A whole case file.

    label : name of the case itself among its variants. participants : in the order in which they
    start; what one has at the start begins the inputs of those after it. summary : name ->
    "min|max|mean|last participant.variable", what the last screen and --summary-json say. window :
    "min|max|mean|last participant.variable" -> [low, high], where the value is expected; shown in
    pictures and reports. axes : what the indices of 2-D fields run along. observers : of
    another package, name -> options. monitor : as summary,
    shown while running. variants : name -> {dotted key: value} changes that make a further run.
    """

    title: str
    label: FileName = "base"
    time: Time
    participants: dict[str, ParticipantTable]
    wires: list[WireTable]
    coupling: Coupling
    record: Record = Field(default_factory=lambda: Record.model_validate({}))
    summary: dict[str, str] = {}
    monitor: dict[str, str] = {}
    pictures: list[Picture] = []
    axes: list[Axes] = []
    window: dict[str, tuple[str, str]] = {}
    report: ReportTable = ReportTable()
    studies: dict[FileName, Study] = {}
    observers: dict[str, dict[str, Any]] = {}
    variants: dict[FileName, dict[str, Any]] = {}

    @field_validator("summary", "monitor")
    @classmethod
    def reductions(cls, entries):
        for name, text in entries.items():
            kind, port = reduced(text)
            owner, _, variable = port.partition(".")
            if kind not in REDUCTIONS or not owner or not variable:
                raise ValueError(
                    f"{name} = {text!r}: write 'min|max|mean|last participant.variable'"
                )
        return entries

    @field_validator("participants")
    @classmethod
    def names(cls, tables):
        for name in tables:
            if not re.fullmatch(r"\w+", name) or name in TAKEN:
                raise ValueError(
                    f"{name!r} cannot name a participant: letters, digits and _, "
                    f"and none of {', '.join(TAKEN)}"
                )
        return tables

    @field_validator("window")
    @classmethod
    def windows(cls, entries):
        cls.reductions({text: text for text in entries})
        return entries

    @model_validator(mode="after")
    def names_exist(self):
        used = {port.partition(".")[0] for port in self._ports()}
        used |= {name for pair in self.axes for name in pair.participants}
        unknown = sorted((used | set(self.coupling.order)) - set(self.participants))
        if unknown:
            raise ValueError(
                f"no participant {', '.join(unknown)}: there are {', '.join(self.participants)}"
            )
        if sorted(self.coupling.order) != sorted(self.participants):
            raise ValueError(
                f"coupling.order must name each participant once: {', '.join(self.participants)}"
            )
        return self

    def _ports(self) -> list[str]:
        """Every "participant.variable" that the file names."""
        ports = [port for wire in self.wires for port in (wire.source, wire.target)]
        ports += self.record.fields
        if self.time.angular_speed:
            ports.append(self.time.angular_speed)
        for picture in self.pictures:
            ports += [picture.x] if picture.x else []
            ports += picture.fields
            ports += [port for panel in picture.y for port in panel]
        for entries in (self.summary.values(), self.monitor.values(), self.window):
            ports += [reduced(text).port for text in entries]
        for loop in self.report.loops.values():
            ports += [loop.x, *loop.y]
        if motion := self.report.motion:
            ports += [motion.across, motion.along, motion.rotation]
        return ports

    def axes_of(self, port: str) -> Axes:
        """What the indices of a field "participant.name" run along."""
        owner = port.partition(".")[0]
        return next((pair for pair in self.axes if owner in pair.participants), NEUTRAL)


def case_names():
    """Names of the cases that come with the tool: folders of `models` with a case.toml."""
    return sorted(p.name for p in MODELS.iterdir() if (p / "case.toml").is_file())


def find_case(name):
    """Path of a case file, by its path, its folder, or the name of a case that comes with the
    tool.
    """
    for candidate in (Path(name), Path(name) / "case.toml", MODELS / name / "case.toml"):
        if candidate.is_file():
            return candidate.resolve()
    raise BadInput(f"no case {name!r}: neither a file nor one of {', '.join(case_names())}")


def read_tree(path, changes=()):
    """The TOML tree of a case, or of the case in an SSP, with `changes` (pairs of dotted key and
    value) made in it.

    Raises BadInput for a file that is no TOML, and for every change whose path leads nowhere.
    """
    try:
        if Path(path).suffix == ".ssp":
            from .ssp import read_ssp

            tree = read_ssp(path)
        else:
            tree = tomllib.loads(Path(path).read_text())
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise BadInput(f"{path}: {error}") from None
    return changed(tree, changes)


def changed(tree, changes):
    """The TOML tree of a case with `changes` (pairs of dotted key and value) made in it; the tree
    given stays as it is.

    Raises BadInput for every change whose path leads nowhere.
    """
    tree = deepcopy(tree)
    faults = [fault for key, value in changes if (fault := _change(tree, key, value))]
    if faults:
        raise BadInput(faults)
    return tree


def _change(tree, key, value):
    """Set a dotted key; the tables on its way must exist, entries of lists are counted from 0.
    Returns a fault or None.
    """
    *parents, last = _parts(key)
    node = tree
    for k, part in enumerate(parents):
        if isinstance(node, list):
            node = node[int(part)] if part.isdigit() and int(part) < len(node) else None
        else:
            node = node.get(part)
        if not isinstance(node, (dict, list)):
            return f"{key}: there is no table {'.'.join(parents[: k + 1])} in the case"
    if isinstance(node, list):
        return (
            f"{key}: {'.'.join(parents)} is a list; "
            "name a key in one of its entries, counted from 0"
        )
    node[last] = value
    return None


def value_at(tree, key):
    """Value at a dotted key of a case's tree; KeyError with the key where there is none."""
    node = tree
    for part in _parts(key):
        try:
            node = node[int(part) if isinstance(node, list) else part]
        except (KeyError, IndexError, TypeError, ValueError):
            raise KeyError(key) from None
    return node


def _parts(key):
    """Parts of a dotted key; a part with dots of its own is quoted, as in TOML."""
    try:
        node, parts = tomllib.loads(f"{key} = 0"), []
    except tomllib.TOMLDecodeError:
        return key.split(".")
    while isinstance(node, dict):
        ((part, node),) = node.items()
        parts.append(part)
    return parts


def check_case(tree, path):
    """The `Case` in a TOML tree; raises BadInput with every fault, each with its path in the
    file.
    """
    try:
        return Case.model_validate(tree)
    except ValidationError as error:
        raise BadInput([f"{path}: {_sentence(fault)}" for fault in error.errors()]) from None


def _sentence(fault):
    where = ".".join(str(part) for part in fault["loc"]) or "case"
    if fault["type"] == "extra_forbidden":
        return f"{where}: unknown key"
    given = f" (given: {fault['input']!r})" if isinstance(fault["input"], (str, int, float)) else ""
    return f"{where}: {fault['msg'].removeprefix('Value error, ')}{given}"


class Clock(NamedTuple):
    """Stop time, macro step and smallest macro step [s]."""

    stop: float
    step: float
    smallest_step: float


def times(case: Case, speed: float | None) -> Clock:
    """Times of the run; `speed` [rad/s] turns angles into times."""
    faults: list[str] = []
    values: dict[str, float] = {}
    for key in ("stop", "step", "smallest_step"):
        text = getattr(case.time, key)
        if text is None:
            continue
        try:
            values[key] = _seconds(text, speed)
            if not values[key] > 0:
                faults.append(f"time.{key} = {text}: must be positive")
        except (ValueError, ZeroDivisionError) as error:
            faults.append(f"time.{key}: {error}")
    if faults:
        raise BadInput(faults)
    begin = start_time(case, speed)
    if fault := _end_fault(case.time, (values["stop"] - begin) / values["step"]):
        raise BadInput(fault)
    return Clock(values["stop"], values["step"], values.get("smallest_step", values["step"] / 64))


def start_time(case: Case, speed: float | None) -> float:
    """Where the run starts [s]; `speed` as in `times`."""
    try:
        return 0.0 if case.time.start is None else _seconds(case.time.start, speed)
    except (ValueError, ZeroDivisionError) as error:
        raise BadInput(f"time.start: {error}") from None


def _seconds(text: str, speed: float | None) -> float:
    """A time, or an angle at a speed [rad/s], in seconds."""
    return to_si(text, "s") if speed is None else to_si(text, "rad") / speed


def _end_fault(time: Time, steps: float) -> str | None:
    """What is wrong with a stop time of so many macro steps; they may be off a whole number by
    what rounding does to two units.
    """
    whole = round(steps)
    if whole >= 1 and abs(steps - whole) <= 1e-9 * whole:
        return None
    where = f"time.stop = {time.stop}"
    if steps < 1:
        return f"{where}: is before the end of the first step, {time.step}"
    step = registry().Quantity(time.step)
    begin = registry().Quantity(time.start) if time.start else 0 * step
    nearest = [f"{begin + count * step:.10g~P}" for count in (floor(steps), floor(steps) + 1)]
    return f"{where}: is no multiple of time.step = {time.step}; {nearest[0]} and {nearest[1]} are"
