"""Case files: TOML with units -> a checked `Case`, every fault of the file in one message."""

import re
import tomllib
from copy import deepcopy
from itertools import takewhile
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
from ..fmi.errors import BadInput, file_fault, near, unknown
from ..fmi.fields import base_of
from ..fmi.option_classes import is_key, sentences, with_meanings
from ..fmi.quantities import from_si, is_angle, registry, to_si
from ..participants.plugins import names

Port = Annotated[str, Field(pattern=r"^\w+\.[\s\S]*$")]
"""A variable of a participant: "participant.variable"; the variable's name as the FMU has it, dots,
brackets and all.
"""


def _file_name(text: str) -> str:
    if text in ("", ".", "..") or re.search(r"[/\\\x00-\x1f]", text):
        raise ValueError(f"expected a file name without / and \\, got {text!r}")
    return text


FileName = Annotated[str, AfterValidator(_file_name)]
"""Name of a file in the output folder, without directories."""

REDUCTIONS = ("min", "max", "mean", "last")
ENVELOPE = "envelope"
"""Time of a picture of extreme values."""
TAKEN = ("coupling", "envelopes", "fields", "time")
"""Groups of a results file that are no participants."""


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
        extra="forbid", populate_by_name=True, allow_inf_nan=False, json_schema_extra=with_meanings
    )


class Time(Table):
    """Run time and macro step, as times or crank angles. Crank angles need the input that holds the
    angular speed.
    """

    start: str | None = None
    """Start of the run, as a time or a crank angle. Default: 0."""
    stop: str | None = None
    """Latest end of the run, as a time or a crank angle. Required unless `until_periodic` is set.
    Default with `until_periodic`: `most_periods` periods.
    """
    step: str
    """Macro step, as a time or a crank angle. If a wire sets `local_error`, it is the longest macro
    step, and the run reaches every multiple of it.
    """
    smallest_step: str | None = None
    """Smallest macro step if a wire sets `local_error`. Default: step / 64."""
    angular_speed: Port | None = None
    """Input that holds the angular speed, "participant.variable". If set, start, stop and steps are
    crank angles.
    """
    period: str | None = None
    """Period of the machine, as a time or a crank angle. Summary, checks and headlines refer to the
    last whole period. Default with crank angles: 720 deg with gas pressure or a four-stroke table,
    otherwise 360 deg.
    """
    until_periodic: float = Field(0.0, ge=0, lt=1)
    """Tolerance of periodicity, relative to the range of each quantity, see Eq. (Y2). The run ends
    when film, motion and oil repeat within it. 0: run until `stop`. Typical value: 1e-3.
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
            raise ValueError(
                "stop: expected a time or an angle, got nothing; or set until_periodic"
            )
        if self.least_periods > self.most_periods:
            raise ValueError(
                f"least_periods: expected at most most_periods = {self.most_periods}, "
                f"got {self.least_periods}"
            )
        return self


ORIGINS = ("package", "file", "fmu", "table", "plugin")
"""Keys that say what a participant is made of."""


class ParticipantTable(Table):
    """Participant of a case, with its parameters and start values.

    It is an FMU, a CSV table of signals, or a plugin. A package or a Python file with a model class
    ("FILE.py:CLASS") builds an FMU.
    """

    package: str | None = None
    """Package that builds the FMU from `build`: fmu_mfbd, fmu_ehd, or an installed package."""
    file: str | None = None
    """Python file and model class from which the FMU is built, "FILE.py:CLASS"."""
    fmu: str | None = None
    """Path of an FMU, relative to the case folder."""
    table: str | None = None
    """CSV file of signals that replaces an FMU."""
    plugin: str | None = None
    """Participant type of another installed package, created from `build`
    (participants/plugins.py).
    """
    interpolation: Literal["hold", "linear", "cubic"] | None = None
    """Interpolation between the rows of a table. Default: linear."""
    step: str | None = None
    """Longest communication step of this FMU. Each macro step is divided into equal steps no longer
    than this. Default: one step per macro step.
    """
    event_mode: bool = True
    """Use Event Mode and the clocks that an FMI 3.0 FMU declares. Set false for an FMU that rejects
    them.
    """
    build: dict[str, Any] = {}
    """Options that are fixed when the FMU is built."""
    parameters: dict[str, str | bool | float | int | list] = {}
    """Parameters of the FMU and start values of its inputs."""
    role: str | None = None
    """Role in the interface contract, bodies or lubrication. Another FMU of the same role can
    replace the participant.
    """
    isolated: bool = False
    """Run the FMU in a separate process."""
    host: str | None = Field(None, pattern="^tls://.+:[0-9]+$")
    """Scheduler of a Dask cluster, tls://NAME:PORT. The FMU runs on one of its workers."""
    timeout: str = "120 s"
    """Response timeout of an isolated or remote FMU."""
    clones: int = Field(0, ge=0, le=256)
    """Number of copies of an isolated FMU, each in a separate process. The copies evaluate Newton's
    finite differences in parallel. Useful up to one copy per input element.
    """

    @model_validator(mode="after")
    def one_origin(self):
        origins = [name for name in ORIGINS if getattr(self, name) is not None]
        if len(origins) != 1:
            got = " and ".join(origins) or "nothing"
            raise ValueError(f"expected one of {', '.join(ORIGINS)}, got {got}")
        for key in ("isolated", "step", "host"):
            if (self.table or self.plugin) and getattr(self, key):
                raise ValueError(f"{key}: expected an FMU for this key, got {origins[0]}")
        if self.host and self.isolated:
            raise ValueError("host: expected isolated = false with a host, got true")
        if self.clones and not self.isolated:
            raise ValueError("clones: expected isolated = true with clones, got false")
        if self.interpolation and not self.table:
            raise ValueError(
                f"interpolation: expected a table for this key, got {origins[0]}; "
                "set the interpolation of an input at its wire"
            )
        return self


class WireTable(Table):
    """Connection from an output to an input.

    A wire converges if it meets any of its three tolerances. If none is given, a wire against the
    stepping order has a tolerance of 1e-6 nominal values. A wire along the order converges
    immediately. If a tolerance is given, its change since the last iterate is measured.
    """

    source: Port = Field(alias="from")
    """Source output, "participant.variable"."""
    target: Port = Field(alias="to")
    """Target input, "participant.variable"."""
    tolerance: str | float | None = None
    """Largest difference between output and input in a converged step. It is a string with a unit,
    or a multiple of the nominal value.
    """
    relative_tolerance: float = Field(0.0, ge=0, lt=1)
    """Tolerance of the rms difference, relative to the rms of the field. A wire converges if it
    meets any of its tolerances.
    """
    residual_relative_tolerance: float = Field(0.0, ge=0, lt=1)
    """Tolerance of the rms difference, relative to its value in the first evaluation of the macro
    step.
    """
    largest_decrease: float | None = Field(None, gt=0, lt=1)
    """Largest relative decrease of the field's minimum in one update of an iterate. Default: no
    limit.
    """
    local_error: str | float | None = None
    """Allowed local error of a macro step, rms over the field. If any wire sets it, the step size
    is adaptive.
    """
    interpolation: Literal["held", "mean", "linear", "hermite"] | None = None
    """Input inside a macro step. `held` uses the end value and `mean` the mean of both ends.
    `hermite` is a cubic with the slopes that the source declares. Default: coupling.inputs.
    """
    conjugate: Port | None = None
    """Output whose product with this field is work or power. The run compares the work on both
    sides of the wire.
    """


class Coupling(Table):
    """Iteration of a macro step to its fixed point."""

    method: str = "newton"
    """Coupling method: newton, iqn_ils, iqn_imvj, iqn_ageing, aitken, constant, explicit, or a
    method of another installed package. `newton` uses directional derivatives and GMRES, the iqn
    methods use secants, and `explicit` does not iterate. Each loop of wires is iterated separately.
    A loop is not iterated if one of its FMUs cannot save its state.
    """
    step_control: str | None = None
    """Step control of another installed package (participants/plugins.py)."""
    options: dict[str, Any] = {}
    """Options of a method or step control of another package."""
    order: list[str]
    """Stepping order, each participant once. Wires against this order are the unknowns."""
    parallel: bool = False
    """Use Jacobi instead of Gauss-Seidel iteration. All wires are unknowns."""
    predictor: int = Field(2, ge=0, le=2)
    """Order of the extrapolation that starts a macro step. 0 repeats the last values. Default with
    `explicit`: 0.
    """
    inputs: Literal["held", "mean", "linear"] = "held"
    """Real inputs inside a macro step, for wires without `interpolation`. `mean` is second-order
    with every FMU. `linear` is second-order with FMUs that declare canInterpolateInputs.
    """
    max_iterations: int = Field(20, ge=1)
    """Maximum number of iterations of a macro step before it is halved."""
    relaxation: float = Field(0.5, gt=0, le=1)
    """Factor of constant relaxation, and first factor of the other methods."""
    mixing: float = Field(1.0, gt=0, le=1)
    """Relaxation factor for the part of the residual that the secants do not represent."""
    probing: bool = False
    """Use Newton with finite differences in a macro step without secants, or if the secants fail.
    """
    windows: int = Field(3, ge=0)
    """Number of macro steps whose secants iqn_ils and iqn_imvj use."""
    filter: Literal["QR1", "QR2", "QR3"] = "QR2"
    """Filter that drops secants of iqn_ils."""
    filter_limit: float = Field(1e-2, gt=0, lt=1)
    """Relative size below which the filter drops a secant."""
    largest_krylov_space: int = Field(120, ge=1)
    """Maximum number of derivative products per Newton update."""
    differences: bool = False
    """Use finite differences instead of the participants' directional derivatives."""
    halvings: int = Field(6, ge=0)
    """Maximum number of halvings of a macro step that fails."""

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
            raise ValueError(unknown("method", name, known))
        return name


class Record(Table):
    """Content of the results file: all scalar outputs at every macro step, and `fields` at
    intervals.
    """

    fields: list[Port] = []
    """Recorded fields, "participant.variable". All scalar outputs are recorded automatically at
    every macro step.
    """
    every: int | str = 1
    """Interval between records of the fields: a number of macro steps, a time, or a crank angle
    such as "4 deg". A number counts halved steps as well. With a time or angle, each multiple is
    recorded at the first macro step that reaches it. Multiples of `time.step` are reached exactly.
    """
    periods: int | None = Field(None, ge=1)
    """Number of last periods that results, pictures and report show. The file holds all periods.
    Default: 1 with `time.until_periodic`, otherwise the whole run.
    """
    checkpoint_every: int | None = Field(None, ge=0)
    """Number of macro steps between checkpoints. 0: only at SIGINT and SIGTERM. By default, a run
    longer than 5 s writes one every 50 steps, in at most 2 % of its time.
    """

    @field_validator("every")
    @classmethod
    def a_number_or_an_interval(cls, value):
        if isinstance(value, int):
            if value < 1:
                raise ValueError(f"expected a number of macro steps of at least 1, got {value}")
        elif not to_si(value, "rad" if is_angle(value) else "s") > 0:
            raise ValueError(f"expected a positive time or angle, got {value!r}")
        return value


class Picture(Table):
    """Picture of a run.

    `lines` plots `y` over `x`, one panel per entry. `map` shows `fields` at one instant, one panel
    each. `section` shows `fields` at one instant along their first index, within `angles` and at
    `height`.
    """

    file: FileName
    """Name of the PNG file in the output folder."""
    title: str
    """Title above the picture."""
    kind: Literal["lines", "map", "section"]
    """`lines` plots `y` over `x`. `map` shows `fields` at one instant. `section` shows them along
    their first index.
    """
    x: Port | Literal["time"] | None = None
    """Horizontal axis of `lines`: an output or "time"."""
    y: list[list[Port]] = []
    """Outputs of `lines`, one list per panel."""
    fields: list[Port] = []
    """Fields of `map` and `section`, one panel each."""
    time: str | None = None
    """Instant of `map` and `section`: a time, a crank angle, or the extreme of a scalar output such
    as "max bodies.side_force". The nearest recorded instant is shown. A `map` with "envelope" shows
    the extreme value of every cell over all macro steps of the last period.
    """
    angles: tuple[str, str] = ("0 deg", "360 deg")
    """Range of `section` around the circumference. A full revolution is 360 deg."""
    height: float = Field(0.5, ge=0, le=1)
    """Position of `section` along the second index, as a fraction of its length."""
    units: dict[str, str] = {}
    """Displayed units by "participant.variable"."""

    @field_validator("time")
    @classmethod
    def an_instant(cls, text):
        if text is None or text == ENVELOPE or is_angle(text):
            return text
        kind, port = reduced(text)
        if kind in ("min", "max") and re.fullmatch(r"\w+\.\S.*", port):
            return text
        try:
            to_si(text, "s")
        except ValueError:
            raise ValueError(
                f"expected a time, a crank angle or min|max participant.variable, got {text!r}; "
                "write for example '24 deg'"
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
            wanted = " and ".join(missing)
            raise ValueError(f"expected {wanted} in a picture of kind {self.kind!r}, got nothing")
        if self.time == ENVELOPE and self.kind != "map":
            raise ValueError(
                f"expected an instant in a picture of kind {self.kind!r}, got {self.time!r}"
            )
        return self


class Axis(Table):
    """Axis of one index of a field, from the start of the first cell to the end of the last. On a
    closed axis, `centred` shifts the range by at most half a cell.
    """

    label: str
    """Label of the axis."""
    unit: str = ""
    """Unit of the positions."""
    range: tuple[float, float] = (0.0, 1.0)
    """Positions of the start of the first cell and of the end of the last."""
    centred: float | None = None
    """Position of a cell centre on a closed axis."""
    length: Port | None = None
    """Parameter that holds a length. If set, `range` is relative to this length and shown in
    `unit`.
    """
    marks: dict[str, float] = {}
    """Labels at positions along the axis."""

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
    """Axes of the fields of some participants. They are labels that no computation uses."""

    participants: list[str] = Field(min_length=1)
    """Participants whose fields have these axes: "PARTICIPANT", or "PARTICIPANT.SURFACE" for one of
    several film surfaces.
    """
    first: Axis = Axis(label="first index / its number")
    """Axis of the first index."""
    second: Axis = Axis(label="second index / its number")
    """Axis of the second index."""


NEUTRAL = Axes(participants=[""])
"""Axes of a field that the case does not describe."""


class Loop(Table):
    """Closed curve and its work: the integral of the sum of `y` over `x` during the last `period`,
    in `unit`.
    """

    y: list[Port]
    """Outputs whose sum is integrated."""
    x: Port
    """Output over which the sum is integrated."""
    period: str
    """Length of the curve before the end of the run, as a time or a crank angle."""
    unit: str = "J"
    """Unit of the work."""


class ReportTable(Table):
    """Content of a report in addition to pictures and fields: loops by name."""

    loops: dict[str, Loop] = {}
    """Closed curves whose work is reported, by name."""


class Study(Table):
    """Runs of the case that differ in `points`, compared with the run labelled `reference`.

    `set` changes the case in all runs. `curves` over `x`, if any, are scored against those of the
    reference.
    """

    title: str
    """Title above table and picture."""
    set: dict[str, Any] = {}
    """Changes of the case in all runs, {dotted key: value}."""
    points: dict[FileName, dict[str, Any]]
    """Runs of the study: label -> {dotted key: value}."""
    reference: str
    """Label of the run with which the others are compared."""
    x: Port | None = None
    """Output over which curves are plotted and scored."""
    curves: list[Port] = []
    """Outputs that are scored against those of the reference."""
    summary: list[str] = []
    """Entries of the case's summary that the command prints for each run."""
    sizes: dict[FileName, float] = {}
    """Cell size or step of three points in any unit, from which the command computes observed
    orders of `summary`."""

    @model_validator(mode="after")
    def consistent(self):
        if self.curves and not self.x:
            raise ValueError("x: expected an output with curves, got nothing")
        if self.reference not in self.points:
            raise ValueError(f"reference: {unknown('point', self.reference, self.points)}")
        for label in self.sizes:
            if label not in self.points:
                raise ValueError(f"sizes: {unknown('point', label, self.points)}")
        if len(self.sizes) not in (0, 3) or len(set(self.sizes.values())) != len(self.sizes):
            raise ValueError(f"sizes: expected three different sizes, got {self.sizes}")
        return self


class Case(Table):
    """Case file."""

    title: str
    """Title of the case, one line."""
    label: FileName = "base"
    """Label of the case among its variants."""
    time: Time
    """Run time and macro step."""
    participants: dict[str, ParticipantTable]
    """Participants by name, in the order in which they start. A lubrication FMU starts after the
    participant that provides its film_thickness.
    """
    wires: list[WireTable]
    """Connections from outputs to inputs."""
    coupling: Coupling
    """Method, order and limits of the iterations of a macro step."""
    native: bool | list[str] | None = None
    """Run participants of packages as machine code: true for all, false for none, or a list of
    names. Default: all participants that have a prebuilt library.
    """
    record: Record = Field(default_factory=lambda: Record.model_validate({}))
    """Content of the results file."""
    summary: dict[str, str] = {}
    """Entries of the summary after a run: name -> "min|max|mean|last participant.variable"."""
    monitor: dict[str, str] = {}
    """Values shown during a run: name -> "min|max|mean|last participant.variable"."""
    pictures: list[Picture] = []
    """Pictures drawn at the end of a run."""
    axes: list[Axes] = []
    """Axes of the fields. They are labels that no computation uses."""
    window: dict[str, tuple[str, str]] = {}
    """Expected range of a value: "min|max|mean|last participant.variable" -> [low, high]."""
    report: ReportTable = ReportTable()
    """Content of a report in addition to pictures and fields."""
    studies: dict[FileName, Study] = {}
    """Studies by name. Each compares several runs with a reference run."""
    observers: dict[str, dict[str, Any]] = {}
    """Observers of other installed packages: name -> options."""
    variants: dict[FileName, dict[str, Any]] = {}
    """Variants of the case: name -> {dotted key: value}. A variant runs with `--only`, or if
    `beside` lists it.
    """
    beside: list[FileName] = []
    """Variants that run together with the case."""

    @field_validator("summary", "monitor")
    @classmethod
    def reductions(cls, entries):
        for name, text in entries.items():
            kind, port = reduced(text)
            owner, _, variable = port.partition(".")
            if kind not in REDUCTIONS or not owner or not variable:
                raise ValueError(
                    f"{name}: expected 'min|max|mean|last participant.variable', got {text!r}"
                )
        return entries

    @field_validator("participants")
    @classmethod
    def names(cls, tables):
        for name in tables:
            if not re.fullmatch(r"\w+", name) or name in TAKEN:
                raise ValueError(
                    f"expected a name of letters, digits and _ other than {', '.join(TAKEN)}, "
                    f"got {name!r}"
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
        for name in sorted((used | set(self.coupling.order)) - set(self.participants)):
            where = "coupling.order" if name in self.coupling.order else "participants"
            raise ValueError(f"{where}: {unknown('participant', name, self.participants)}")
        for label in self.beside:
            if label not in self.variants:
                raise ValueError(f"beside: {unknown('variant', label, self.variants)}")
        if sorted(self.coupling.order) != sorted(self.participants):
            raise ValueError(
                f"coupling.order: expected each of {', '.join(self.participants)} once, "
                f"got {', '.join(self.coupling.order) or 'nothing'}"
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
    question = near(Path(name).name, known) or "; `piston-cosim list` lists the cases"
    raise BadInput(
        f"case: expected a file, a folder with case.toml or the name of a case, "
        f"got {name!r}{question}"
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
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{path}: {toml_fault(error)}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(file_fault(path, error)) from None
    from .changes import changed  # knows the schema, and the parts' own keys

    return changed(tree, changes, Path(path).parent)


def check_case(tree, path):
    """The `Case` in a TOML tree; raises BadInput with every fault, each with its path in the
    file.
    """
    try:
        return Case.model_validate(tree)
    except ValidationError as error:
        faults = sentences(error, Case)
        deeper = _faults_below(tree, error, Path(path).parent)
    raise BadInput([*faults, *(one for one in deeper if _key(one) not in map(_key, faults))])


def _key(fault: str) -> str:
    """Return the key of a fault."""
    return fault.partition(": ")[0]


MOST_ROUNDS = 4
"""Rounds of leaving entries out of a case, for faults that show only without others."""


def _faults_below(tree, error: ValidationError, folder: Path) -> list[str]:
    """Return the faults of a case that its first faults hide.

    The entries with a fault are left out of a copy of the case. The copy then has the next checks:
    those between keys, then those of build options, parameters and wires.
    """
    from .system import faults_ahead  # knows the schema

    tree = deepcopy(tree)
    faults: list[str] = []
    for _ in range(MOST_ROUNDS):
        found = sorted(error.errors(), key=lambda one: str(one["loc"]), reverse=True)
        if not all(_leave_out(tree, list(takewhile(is_key, one["loc"])), one) for one in found):
            return faults
        try:
            case = Case.model_validate(tree)
        except ValidationError as next_error:
            error = next_error
            # an entry that is left out is no fault of the case
            faults += [one for one in sentences(error, Case) if "got nothing" not in one]
        else:
            return [*faults, *faults_ahead(case, folder)]
    return faults


def _leave_out(tree, place: list[str | int], fault) -> bool:
    """Remove the value of a fault from a case's tree, of an incomplete entry of a list the entry.
    A number that lacks its unit becomes a string. Returns whether the rest makes sense without it.
    """
    if fault["type"] == "missing":
        place = place[:-1] if len(place) > 1 and isinstance(place[-2], int) else []
    if not place:
        return False
    *parents, last = place
    node = tree
    try:
        for part in parents:
            node = node[part]
        if isinstance(node[last], (dict, list)) and not isinstance(last, int):
            return False
        if fault["type"] == "string_type":
            node[last] = str(node[last])
        else:
            del node[last]
    except (LookupError, TypeError):
        return False
    return True


def toml_fault(error: tomllib.TOMLDecodeError) -> str:
    """Return what is wrong with a text that is no TOML, and where."""
    line = re.search(r"line (\d+)", str(error))
    place = f"line {line[1]}" if line else "its last line"
    return f"expected TOML, got invalid syntax in {place}; write KEY = VALUE, texts in quotes"


def record_interval(case: Case, speed: float | None) -> float:
    """From one record of the fields to the next [s], 0 where macro steps are counted; `speed` as in
    `times`.
    """
    every = case.record.every
    try:
        return 0.0 if isinstance(every, int) else _seconds(every, speed)
    except ValueError as error:
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
                faults.append(f"time.{key}: expected a positive value, got {text!r}")
        except ValueError as error:
            faults.append(f"time.{key}: {error}")
    if faults:
        raise BadInput(faults)
    begin, step, period = start_time(case, speed), values["step"], values.get("period", 0.0)
    if case.time.until_periodic and not period:
        raise BadInput("time.period: expected a time with time.until_periodic, got nothing")
    if fault := period and _whole_fault("time.period", case.period, None, period / step, case.time):
        if case.time.period or case.time.until_periodic:
            raise BadInput(fault)
        period = 0.0  # a derived one that macro steps do not come by
    stop = values.get("stop", begin + case.time.most_periods * period)
    steps = (stop - begin) / step
    if fault := _whole_fault("time.stop", case.time.stop, case.time.start, steps, case.time):
        raise BadInput(fault)
    earliest = begin + case.time.least_periods * period if case.time.until_periodic else stop
    smallest = values.get("smallest_step", step / 64)
    return Clock(stop, step, smallest, period, min(stop, earliest))


def start_time(case: Case, speed: float | None) -> float:
    """Where the run starts [s]; `speed` as in `times`."""
    try:
        return 0.0 if case.time.start is None else _seconds(case.time.start, speed)
    except ValueError as error:
        raise BadInput(f"time.start: {error}") from None


def _seconds(text: str, speed: float | None) -> float:
    """A time, or an angle at a speed [rad/s], in seconds."""
    if speed is None:
        return to_si(text, "s")
    if not speed:
        raise ValueError("expected an angular speed above 0 with crank angles, got 0 rad/s")
    return to_si(text, "rad") / speed


def _whole_fault(key: str, text: str | None, start: str | None, steps: float, time: Time) -> str:
    """Return what is wrong with a time of so many macro steps after `start`; they may be off a
    whole number by what rounding does to two units.
    """
    whole = round(steps)
    if whole >= 1 and abs(steps - whole) <= 1e-9 * whole:
        return ""
    if steps < 1:
        return f"{key}: expected at least one step of {time.step}, got {text!r}"
    step = registry().Quantity(time.step)
    begin = registry().Quantity(start) if start else 0 * step
    nearest = [f"{begin + count * step:.10g~P}" for count in (floor(steps), floor(steps) + 1)]
    return (
        f"{key}: expected a multiple of time.step = {time.step}, got {text!r}; "
        f"the nearest are {nearest[0]} and {nearest[1]}"
    )
