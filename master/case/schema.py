"""Case files: TOML with units -> a checked `Case`, every fault of the file in one message."""

import re
import tomllib
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
from ..fmi.fields import base_of
from ..fmi.option_classes import near, near_key, with_meanings
from ..fmi.quantities import from_si, is_angle, registry, to_si
from ..participants.plugins import names

Port = Annotated[str, Field(pattern=r"^\w+\.[\s\S]*$")]
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
    """A table of a case file; unknown keys are errors. What a key means stands below it, and in
    `piston-cosim keys`.
    """

    model_config = ConfigDict(
        extra="forbid", populate_by_name=True, json_schema_extra=with_meanings
    )


class Time(Table):
    """Run time and macro step: times, or crank angles together with the input that holds the
    angular speed.
    """

    start: str | None = None
    """Where the run begins: a time, or a crank angle; 0 without it."""
    stop: str | None = None
    """Where the run ends at the latest: a time, or a crank angle if `angular_speed` is given.
    Default: `most_periods` periods with `until_periodic`; required without it.
    """
    step: str
    """Macro step, likewise; with a wire's `local_error` the longest one, and where the run must
    come by.
    """
    smallest_step: str | None = None
    """With a wire's `local_error`: no macro step is divided below this; step / 64 without it."""
    angular_speed: Port | None = None
    """Input that holds the angular speed; with it start, stop and steps are crank angles."""
    period: str | None = None
    """Period of the machine, a time or a crank angle. Default in a case of crank angles: 720 deg
    with gas pressure or a table over four strokes, 360 deg otherwise. Summary, checks and headlines
    are of the last whole period.
    """
    until_periodic: float = Field(0.0, ge=0, lt=1)
    """Tolerance: period after period is run until film, motion and oil at its end are this near to
    those at its beginning, as a share of their range (Eq. (Y2), `runs/repetition.py`). Usual: 1e-3;
    0: the run goes on to `stop`.
    """
    least_periods: int = Field(2, ge=2, le=1000)
    """Minimum number of periods with `until_periodic`."""
    most_periods: int = Field(20, ge=2, le=1000)
    """Maximum number of periods with `until_periodic` and without `stop`. Warns if the run is not
    periodic by then.
    """

    @model_validator(mode="after")
    def ends(self):
        if self.stop is None and not self.until_periodic:
            raise ValueError("stop: required without until_periodic")
        if self.least_periods > self.most_periods:
            raise ValueError("least_periods: expected at most most_periods")
        return self


class ParticipantTable(Table):
    """A participant: an FMU by path, or what builds one with options, a package or a slave in one
    file ("FILE.py:CLASS"); or a table, a CSV file of signals; and its parameters and input starts.
    """

    package: str | None = None
    """Part that builds its FMU from `build`: fmu_mfbd, fmu_ehd, or an installed package."""
    file: str | None = None
    """FILE.py:CLASS, a slave in one file that an FMU is built of."""
    fmu: str | None = None
    """An FMU, relative to the case's folder."""
    table: str | None = None
    """A CSV file of signals in place of an FMU."""
    plugin: str | None = None
    """What another installed package makes by that name from `build` (participants/plugins.py)."""
    interpolation: Literal["hold", "linear", "cubic"] | None = None
    """Of a table's columns between its rows; linear without it."""
    step: str | None = None
    """The FMU takes steps of its own inside a macro step, equal ones no longer than this time."""
    event_mode: bool = True
    """Use the Event Mode and the clocks that an FMI 3.0 FMU declares; false for one that rejects
    them.
    """
    build: dict[str, Any] = {}
    """What is decided when the FMU is built."""
    parameters: dict[str, str | bool | float | int | list] = {}
    """Parameters of the FMU and start values of its inputs."""
    role: str | None = None
    """What it does by the contract (bodies, lubrication), so that another FMU can take its place.
    """
    isolated: bool = False
    """The FMU runs in a process of its own."""
    host: str | None = Field(None, pattern="^tls://.+:[0-9]+$")
    """Scheduler of a Dask cluster, tls://NAME:PORT: the FMU runs on one of its workers."""
    timeout: str = "120 s"
    """Of an isolated FMU or one on a host: longest time for any one answer."""
    clones: int = Field(0, ge=0, le=256)
    """Of an isolated FMU: copies of it, in processes of their own, that take the difference probes
    of Newton at the same time, one for each element of its inputs.
    """

    @model_validator(mode="after")
    def one_origin(self):
        if [self.package, self.file, self.fmu, self.table, self.plugin].count(None) != 4:
            raise ValueError(
                "give one of package, file (FILE.py:CLASS; both build an FMU), fmu (a file), "
                "table (a CSV file) and plugin"
            )
        if (self.table or self.plugin) and (self.isolated or self.step or self.host):
            raise ValueError("only an FMU has a process or a step of its own")
        if self.host and self.isolated:
            raise ValueError("an FMU is isolated on this machine or on a host, not both")
        if self.clones and not self.isolated:
            raise ValueError("clones are those of an isolated FMU; write isolated = true")
        if self.interpolation and not self.table:
            raise ValueError("interpolation is that of a table; that of an input is its wire's")
        return self


class WireTable(Table):
    """A field that goes from an output to an input.

    Of the three tolerances, one that is met is enough. Without any, the tolerance is 1e-6 nominal
    values on a wire that runs against the stepping order. A wire along the order hands over what
    has just been computed: it is not measured, unless one of the three is given; then by how far it
    has moved since the iterate.
    """

    source: Port = Field(alias="from")
    """Output it comes from, "participant.variable"."""
    target: Port = Field(alias="to")
    """Input it goes to, "participant.variable"."""
    tolerance: str | float | None = None
    """Largest difference between output and input in a converged step: text with the field's unit,
    or a number that multiplies its nominal value.
    """
    relative_tolerance: float = Field(0.0, ge=0, lt=1)
    """Root mean square of the difference as a share of the field's; one tolerance that is met is
    enough.
    """
    residual_relative_tolerance: float = Field(0.0, ge=0, lt=1)
    """Root mean square of the difference as a share of what it was in the macro step's first
    evaluation.
    """
    largest_decrease: float | None = Field(None, gt=0, lt=1)
    """No update of an iterate lowers the field's smallest element by more than this share of
    itself.
    """
    local_error: str | float | None = None
    """Local error allowed in a macro step, root mean square over the field; with it on any wire,
    steps are as long as it allows.
    """
    interpolation: Literal["held", "mean", "linear", "hermite"] | None = None
    """The input inside a macro step: held at its value at the end, held at the mean of both ends,
    linear, or a cubic by the slopes that the source declares. Default: coupling.inputs.
    """
    conjugate: Port | None = None
    """Output whose product with the field is work or power; both sides' account of it is compared
    at the end.
    """


class Coupling(Table):
    """How a macro step is brought to its fixed point."""

    method: str = "newton"
    """newton (directional derivatives and GMRES), iqn_ils, iqn_imvj, iqn_ageing (secants), aitken,
    constant, explicit (not iterated), or a method of another installed package. Loops among the
    wires are iterated one by one; one with an FMU without saved states is not iterated.
    """
    step_control: str | None = None
    """Step control of another installed package (participants/plugins.py)."""
    options: dict[str, Any] = {}
    """What a method or step control of another package reads."""
    order: list[str]
    """Order in which the participants step, each once; wires that run against it are the unknowns.
    """
    parallel: bool = False
    """Jacobi's order in place of Gauss-Seidel's: all wires are unknowns."""
    predictor: int = Field(2, ge=0, le=2)
    """Order of the extrapolation that begins a macro step, 0 for the last values. Default of
    explicit: 0, a plain exchange.
    """
    inputs: Literal["held", "mean", "linear"] = "held"
    """Inputs of real numbers inside a macro step, for wires without an interpolation. `mean` gives
    second order with every FMU, `linear` with FMUs that declare canInterpolateInputs.
    """
    max_iterations: int = Field(20, ge=1)
    """Iterations of a macro step before it is halved."""
    relaxation: float = Field(0.5, gt=0, le=1)
    """Factor of constant relaxation, first factor of the others."""
    mixing: float = Field(1.0, gt=0, le=1)
    """Share taken of what the secants leave unexplained."""
    probing: bool = False
    """A macro step without secants, or led astray by them, is taken by Newton on differences."""
    windows: int = Field(3, ge=0)
    """Of how many macro steps iqn_ils and iqn_imvj use the secants."""
    filter: Literal["QR1", "QR2", "QR3"] = "QR2"
    """How iqn_ils drops secants."""
    filter_limit: float = Field(1e-2, gt=0, lt=1)
    """Below which share of itself a secant is dropped."""
    largest_krylov_space: int = Field(120, ge=1)
    """Products per Newton update at most."""
    differences: bool = False
    """Products by differences of evaluations, not by the participants' derivatives."""
    halvings: int = Field(6, ge=0)
    """How often a macro step that fails may be halved."""

    @model_validator(mode="before")
    @classmethod
    def plain_exchange(cls, table):
        """Explicit exchange extrapolates only if the case says so."""
        if isinstance(table, dict) and table.get("method") == "explicit":
            return {"predictor": 0} | table
        return table

    @field_validator("method")
    @classmethod
    def known(cls, name):
        known = [*METHODS, *names("methods")]
        if name not in known:
            raise ValueError(f"{name!r} is no method: there are {', '.join(known)}")
        return name


class Record(Table):
    """What goes into the results file: all scalar outputs every macro step, `fields` every so
    many.
    """

    fields: list[Port] = []
    """Fields recorded, "participant.variable"; scalar outputs are recorded every macro step without
    being named.
    """
    every: int | str = 1
    """From one record of the fields to the next: a number of macro steps, halves included, or a
    time or crank angle ("4 deg"). Of the latter each multiple is recorded by the first macro step
    that reaches it, hit exactly where it is a multiple of `time.step`, however steps are divided.
    """
    periods: int | None = Field(None, ge=1)
    """Number of last periods that results, pictures and report show; the file holds all. Default: 1
    with `time.until_periodic`, otherwise the whole run.
    """
    checkpoint_every: int | None = Field(None, ge=0)
    """Macro steps from one checkpoint to the next; 0: none but at SIGINT and SIGTERM; without it
    every 50 once a run takes longer than 5 s, and no more often than is worth a fiftieth of the
    time.
    """

    @field_validator("every")
    @classmethod
    def a_number_or_an_interval(cls, value):
        if isinstance(value, int):
            if value < 1:
                raise ValueError("a number of macro steps is greater than or equal to 1")
        elif not to_si(value, "rad" if is_angle(value) else "s") > 0:
            raise ValueError("must be positive")
        return value


class Picture(Table):
    """One picture. lines: `y` over `x`, panels one below the other; map: `fields` at a time, a
    panel each; section: `fields` at a time along their first index, within `angles` (its whole
    length is 360 deg), at the share `height` of their second.
    """

    file: FileName
    """PNG file in the output folder."""
    title: str
    """Written above it."""
    kind: Literal["lines", "map", "section"]
    """lines: `y` over `x`, panels one below the other; map: `fields` at a time; section: `fields`
    at a time along their first index.
    """
    x: Port | Literal["time"] | None = None
    """Of lines: output that they are drawn over, or "time"."""
    y: list[list[Port]] = []
    """Of lines: a list of outputs for each panel."""
    fields: list[Port] = []
    """Of maps and sections: fields, a panel each."""
    time: str | None = None
    """Of maps and sections: the recorded instant nearest to this time, to this crank angle, or to
    where a scalar output is smallest or largest ("max bodies.side_force").
    """
    angles: tuple[str, str] = ("0 deg", "360 deg")
    """Of sections: from where to where around; a whole turn is 360 deg."""
    height: float = Field(0.5, ge=0, le=1)
    """Of sections: at which share of the second index."""
    units: dict[str, str] = {}
    """Units shown, by "participant.variable"."""

    @field_validator("time")
    @classmethod
    def an_instant(cls, text):
        if text is None or is_angle(text):
            return text
        kind, port = reduced(text)
        if kind in ("min", "max") and re.fullmatch(r"\w+\.\S.*", port):
            return text
        try:
            to_si(text, "s")
        except ValueError as error:
            raise ValueError(
                f"{error}; write a time, a crank angle, e.g. '24 deg', or 'min|max "
                "participant.variable'"
            ) from None
        return text

    @property
    def marker(self) -> str:
        """The output whose smallest or largest value is the picture's instant; "" without one."""
        kind, port = reduced(self.time or "")
        return port if kind in ("min", "max") else ""

    @property
    def outputs(self) -> list[str]:
        """Scalar outputs of participants that the picture needs, without time and `coupling`."""
        ports = filter(None, (self.x, self.marker, *sum(self.y, [])))
        return [port for port in ports if port.partition(".")[0] not in TAKEN]

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
    """Words for what the index runs along."""
    unit: str = ""
    """Of the positions."""
    range: tuple[float, float] = (0.0, 1.0)
    """Positions where the first cell begins and the last one ends."""
    centred: float | None = None
    """A position at which a cell has its centre, on an axis that closes on itself."""
    length: Port | None = None
    """Parameter that holds a length; `range` is then in shares of it, and shown in `unit`."""
    marks: dict[str, float] = {}
    """Words written beside the axis, with their positions."""

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
    """Whose fields have these axes: "PARTICIPANT", or "PARTICIPANT.SURFACE" of one that has several
    film surfaces.
    """
    first: Axis = Axis(label="first index / its number")
    """What the first index runs along."""
    second: Axis = Axis(label="second index / its number")
    """What the second index runs along."""


NEUTRAL = Axes(participants=[""])
"""Of a field that the case says nothing about."""


class Loop(Table):
    """A closed curve and the work in it: the sum of `y` over `x` during the last `period`, in
    `unit`.
    """

    y: list[Port]
    """Outputs whose sum is integrated."""
    x: Port
    """Output it is integrated over."""
    period: str
    """Last so much of the run: a time, or a crank angle."""
    unit: str = "J"
    """Of the result."""


class ReportTable(Table):
    """What a report shows beyond pictures and fields: loops by their name."""

    loops: dict[str, Loop] = {}
    """Closed curves whose work is told, by name."""


class Study(Table):
    """Runs of the case that differ in `points` (label -> {dotted key: value}), held against the one
    labelled `reference`.

    `set` changes the case in all of them; `curves` over `x`, if any, are scored against the
    reference's.
    """

    title: str
    """Written above table and picture."""
    set: dict[str, Any] = {}
    """Changes of the case in all runs, {dotted key: value}."""
    points: dict[FileName, dict[str, Any]]
    """Runs: label -> {dotted key: value}."""
    reference: str
    """Label of the run that the others are held against."""
    x: Port | None = None
    """Output that curves are drawn and scored over."""
    curves: list[Port] = []
    """Outputs scored against the reference's."""

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
    """A whole case file."""

    title: str
    """One line about the case."""
    label: FileName = "base"
    """Name of the case itself among its variants."""
    time: Time
    """Run time and macro step."""
    participants: dict[str, ParticipantTable]
    """What takes part, by name, in the order in which it starts; a film waits for what gives it its
    film_thickness.
    """
    wires: list[WireTable]
    """What goes from outputs to inputs."""
    coupling: Coupling
    """Method, order and limits of the iterations of a macro step."""
    native: bool | list[str] | None = None
    """Participants of packages run as machine code: all of them, none, or those named; without it
    those whose library a release has brought and that it covers.
    """
    record: Record = Field(default_factory=lambda: Record.model_validate({}))
    """What goes into the results file."""
    summary: dict[str, str] = {}
    """Name -> "min|max|mean|last participant.variable", what the last screen says."""
    monitor: dict[str, str] = {}
    """Likewise, shown while running."""
    pictures: list[Picture] = []
    """Pictures drawn at the end."""
    axes: list[Axes] = []
    """What the indices of fields run along: words, nowhere computed with."""
    window: dict[str, tuple[str, str]] = {}
    """"min|max|mean|last participant.variable" -> [low, high], where the value is expected."""
    report: ReportTable = ReportTable()
    """What a report shows beyond pictures and fields."""
    studies: dict[FileName, Study] = {}
    """Runs that are held against one of them, by the study's name."""
    observers: dict[str, dict[str, Any]] = {}
    """Observers of other installed packages, name -> options."""
    variants: dict[FileName, dict[str, Any]] = {}
    """Name -> {dotted key: value}, changes that make a further run, on demand (--only)."""
    beside: list[FileName] = []
    """Variants that run beside the case without being asked for."""

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
        used |= {name.partition(".")[0] for pair in self.axes for name in pair.participants}
        unknown = sorted((used | set(self.coupling.order)) - set(self.participants))
        if unknown:
            raise ValueError(
                f"no participant {', '.join(unknown)}: there are {', '.join(self.participants)}"
            )
        if missing := [label for label in self.beside if label not in self.variants]:
            raise ValueError(
                f"beside = {missing[0]!r}: the variants are {', '.join(self.variants) or 'none'}"
            )
        if sorted(self.coupling.order) != sorted(self.participants):
            raise ValueError(
                f"coupling.order must name each participant once: {', '.join(self.participants)}"
            )
        return self

    @model_validator(mode="after")
    def axes_have_their_lengths(self):
        """Ranges in shares of a parameter become ranges in units, once."""
        for axis in (axis for pair in self.axes for axis in (pair.first, pair.second)):
            if axis.length is not None:
                self._give_length(axis, *axis.length.split(".", 1))
        return self

    def _give_length(self, axis: Axis, owner: str, name: str) -> None:
        """A length that the case does not give, or gives wrongly, leaves shares."""
        table = self.participants.get(owner)
        text = table.parameters.get(name) if table else None
        axis.length = None
        try:
            scale = from_si(to_si(str(text), "m"), "m", axis.unit)
        except ValueError:
            axis.label, axis.unit = f"{axis.label} / {name.replace('_', ' ')}", ""
            return
        low, high = axis.range
        axis.range = (low * scale, high * scale)

    def _ports(self) -> list[str]:
        """Every "participant.variable" that the file names."""
        ports = [port for wire in self.wires for port in (wire.source, wire.target)]
        ports += self.record.fields
        if self.time.angular_speed:
            ports.append(self.time.angular_speed)
        for picture in self.pictures:
            ports += picture.outputs + picture.fields
        for entries in (self.summary.values(), self.monitor.values(), self.window):
            ports += [reduced(text).port for text in entries]
        for loop in self.report.loops.values():
            ports += [loop.x, *loop.y]
        return ports

    def elements_of(self, participant: str) -> set[str]:
        """Return the single elements of arrays, "name[2]", that the file names of a participant."""
        ports = (port.partition(".") for port in self._ports())
        names = {name for owner, _, name in ports if owner == participant}
        names |= self.participants[participant].parameters.keys()
        return {name for name in names if base_of(name) != name}

    def unrecorded(self, picture: Picture) -> list[str]:
        """Fields that a picture wants and the case does not record."""
        return [port for port in picture.fields if port not in self.record.fields]

    @property
    def period(self) -> str | None:
        """Period of the machine: as given, or 720 deg if gas or a table over four strokes drives a
        crank, 360 deg for any other crank; None without crank angles.
        """
        if self.time.period or self.time.angular_speed is None:
            return self.time.period
        tables = [
            table.build[key]
            for table in self.participants.values()
            for key in ("gas", "speed")
            if isinstance(table.build.get(key), dict)
        ]
        blown = any(wire.target.endswith(".gas_pressure") for wire in self.wires)
        four = blown or any(table.get("strokes", 4) == 4 for table in tables)
        return "720 deg" if four else "360 deg"

    def axes_of(self, port: str) -> Axes:
        """What the indices of a field "participant.name" run along."""
        named = [
            (len(name), pair)
            for pair in self.axes
            for name in pair.participants
            if port.startswith(f"{name}.")
        ]
        return max(named, key=lambda one: one[0])[1] if named else NEUTRAL


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
    known = case_names()
    raise BadInput(
        f"no case {name!r}: neither a file, nor a folder with a case.toml, nor one of "
        f"{', '.join(known)}{near(Path(name).name, known)}"
    )


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
    from .changes import changed  # knows the schema, and the parts' own keys

    return changed(tree, changes, Path(path).parent)


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
        return f"{where}: unknown key{near_key(Case.model_json_schema(), fault['loc'])}"
    if fault["type"] == "string_type":
        return f"{where}: must be text, with its unit if it has one (given: {fault['input']!r})"
    given = f" (given: {fault['input']!r})" if isinstance(fault["input"], (str, int, float)) else ""
    return f"{where}: {fault['msg'].removeprefix('Value error, ')}{given}"


def record_interval(case: Case, speed: float | None) -> float:
    """From one record of the fields to the next [s], 0 where macro steps are counted; `speed` as in
    `times`.
    """
    every = case.record.every
    try:
        return 0.0 if isinstance(every, int) else _seconds(every, speed)
    except (ValueError, ZeroDivisionError) as error:
        raise BadInput(f"record.every: {error}") from None


class Clock(NamedTuple):
    """Stop time at the latest, macro step, smallest macro step, period (0: unknown) and stop time
    at the earliest [s].
    """

    stop: float
    step: float
    smallest_step: float
    period: float
    earliest: float


def times(case: Case, speed: float | None) -> Clock:
    """Times of the run; `speed` [rad/s] turns angles into times."""
    faults: list[str] = []
    values: dict[str, float] = {}
    given = {key: getattr(case.time, key) for key in ("stop", "step", "smallest_step")}
    given["period"] = case.period
    for key, text in given.items():
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
    begin, step, period = start_time(case, speed), values["step"], values.get("period", 0.0)
    if case.time.until_periodic and not period:
        raise BadInput(
            "time.period: required with time.until_periodic in a case without time.angular_speed"
        )
    if fault := period and _whole_fault(
        f"time.period = {case.period}", None, period / step, case.time
    ):
        if case.time.period or case.time.until_periodic:
            raise BadInput(fault)
        period = 0.0  # a derived one that macro steps do not come by
    stop = values.get("stop", begin + case.time.most_periods * period)
    where = f"time.stop = {case.time.stop}"
    if fault := _whole_fault(where, case.time.start, (stop - begin) / step, case.time):
        raise BadInput(fault)
    earliest = begin + case.time.least_periods * period if case.time.until_periodic else stop
    smallest = values.get("smallest_step", step / 64)
    return Clock(stop, step, smallest, period, min(stop, earliest))


def start_time(case: Case, speed: float | None) -> float:
    """Where the run starts [s]; `speed` as in `times`."""
    try:
        return 0.0 if case.time.start is None else _seconds(case.time.start, speed)
    except (ValueError, ZeroDivisionError) as error:
        raise BadInput(f"time.start: {error}") from None


def _seconds(text: str, speed: float | None) -> float:
    """A time, or an angle at a speed [rad/s], in seconds."""
    return to_si(text, "s") if speed is None else to_si(text, "rad") / speed


def _whole_fault(where: str, start: str | None, steps: float, time: Time) -> str:
    """What is wrong with a time of so many macro steps after `start`; they may be off a whole
    number by what rounding does to two units.
    """
    whole = round(steps)
    if whole >= 1 and abs(steps - whole) <= 1e-9 * whole:
        return ""
    if steps < 1:
        return f"{where}: is before the end of the first step, {time.step}"
    step = registry().Quantity(time.step)
    begin = registry().Quantity(start) if start else 0 * step
    nearest = [f"{begin + count * step:.10g~P}" for count in (floor(steps), floor(steps) + 1)]
    return f"{where}: is no multiple of time.step = {time.step}; {nearest[0]} and {nearest[1]} are"
