"""Tables of a case file, with the checks between their keys."""

import re
from typing import Any, Literal

from pydantic import (
    Field,
    field_validator,
    model_validator,
)

from ..coupling.methods import METHODS
from ..fmi.errors import unknown
from ..fmi.fields import base_of
from ..fmi.option_classes import ADVANCED, Flag
from ..fmi.quantities import from_si, is_angle, to_si
from ..participants.plugins import names
from .shown import NEUTRAL, Axes, Axis, Picture
from .tables import REDUCTIONS, TAKEN, FileName, Port, Table, reduced


class Time(Table):
    """Run time and macro step, as times or crank angles.

    Crank angles need the input that holds the angular speed.
    """

    start: str | None = None
    """Start of the run, as a time or a crank angle. Default: 0."""
    stop: str | None = None
    """Latest end of the run, as a time or a crank angle. Required unless `until_periodic` is set.
    Default with `until_periodic`: 20 periods.
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
    when film, motion and oil repeat within it, and warns if they do not by `stop`. 0: run until
    `stop`. Typical value: 1e-3.
    """

    @model_validator(mode="after")
    def ends(self):
        if self.stop is None and not self.until_periodic:
            raise ValueError(
                "stop: expected a time or an angle, got nothing; or set until_periodic"
            )
        return self


ORIGINS = ("package", "file", "fmu", "table", "plugin")
"""Keys that determine the origin of a participant, of which it has one."""


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
    event_mode: Flag = True
    """Use Event Mode and the clocks that an FMI 3.0 FMU declares. Set false for an FMU that rejects
    them.
    """
    rollback: Flag | None = None
    """Use the saved states of this FMU in iterations. Default: if a restored step reproduces the
    outputs to 1 %.
    """
    build: dict[str, Any] = {}
    """Options that are fixed when the FMU is built."""
    parameters: dict[str, str | bool | float | int | list] = {}
    """Parameters of the FMU, and start values of its inputs and other variables."""
    role: str | None = None
    """Role in the interface contract, bodies or lubrication. Another FMU of the same role can
    replace the participant.
    """
    like: str | None = None
    """Participant before this one whose keys this one has as well. Own keys replace them."""
    body: str | None = None
    """Body whose gap this film fills, "PARTICIPANT", or "PARTICIPANT.SURFACE" for one of several
    surfaces. Adds the four wires of the interface contract. An own wire to the same input replaces
    single keys.
    """
    isolated: Flag = False
    """Run the FMU in a separate process. A process that can hold only one instance of an FMU never
    gets a second one.
    """
    timeout: str = Field("120 s", json_schema_extra=ADVANCED)
    """Response timeout of an isolated FMU."""

    @field_validator("like", "body")
    @classmethod
    def read_before(cls, value):
        raise ValueError("expected a case file for this key, got a change")

    @field_validator("step", "timeout")
    @classmethod
    def a_time(cls, text):
        if text is not None and not to_si(text, "s") > 0:
            raise ValueError(f"expected a positive time, got {text!r}")
        return text

    @model_validator(mode="after")
    def one_origin(self):
        origins = [name for name in ORIGINS if getattr(self, name) is not None]
        if len(origins) != 1:
            got = " and ".join(origins) or "nothing"
            raise ValueError(f"expected one of {', '.join(ORIGINS)}, got {got}")
        for key in ("isolated", "step"):
            if (self.table or self.plugin) and getattr(self, key):
                raise ValueError(f"{key}: expected an FMU for this key, got {origins[0]}")
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
    """Target input or tunable parameter, "participant.variable"."""
    tolerance: str | float | None = None
    """Largest difference between output and input in a converged step. It is a string with a unit,
    or a multiple of the nominal value.
    """
    relative_tolerance: float = Field(0.0, ge=0, lt=1)
    """Tolerance of the rms difference, relative to the rms of the field. A wire converges if it
    meets any of its tolerances.
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


class Advanced(Table):
    """Numerical settings of the coupling that few cases need."""

    probing: Flag = False
    """Use Newton with finite differences in a macro step without secants, or if the secants fail.
    """
    windows: int = Field(3, ge=0)
    """Number of macro steps whose secants iqn_ils uses."""
    filter_limit: float = Field(1e-2, gt=0, lt=1)
    """Relative size of what is new in a secant below which it is dropped."""
    differences: Flag = False
    """Use finite differences instead of the participants' directional derivatives."""
    coordinates: Flag = True
    """Iterate a native FMU of the whole case, or native participants, in the coordinates of the
    bodies where these determine all unknowns. It takes less time than the iteration on wires, with
    the same fixed point.
    """
    halvings: int = Field(6, ge=0, le=50)
    """Maximum number of halvings of a macro step that fails."""


class Coupling(Table):
    """Iteration of a macro step to its fixed point."""

    method: str = "newton"
    """Coupling method: newton, iqn_ils, iqn_ageing, aitken, constant, explicit, or a method of
    another installed package. `newton` uses directional derivatives and GMRES, the iqn methods use
    secants, and `explicit` does not iterate. Each loop of wires is iterated separately. A loop is
    not iterated if one of its FMUs cannot save its state.
    """
    step_control: str | None = Field(None, json_schema_extra=ADVANCED)
    """Step control of another installed package (participants/plugins.py)."""
    options: dict[str, Any] = {}
    """Options of a method or step control of another package."""
    order: list[str]
    """Stepping order, each participant once. Wires against this order are the unknowns."""
    parallel: Flag = False
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
    advanced: Advanced = Field(
        default_factory=lambda: Advanced.model_validate({}), json_schema_extra=ADVANCED
    )
    """Numerical settings that few cases need; `keys coupling.advanced` lists them."""

    @model_validator(mode="before")
    @classmethod
    def in_advanced(cls, table):
        """Name the new place of keys that were in this table before."""
        before = sorted(table.keys() & Advanced.model_fields) if isinstance(table, dict) else ()
        if before:
            raise ValueError(
                "\n".join(
                    f"{key}: expected in coupling.advanced, got coupling.{key}; "
                    f"write coupling.advanced.{key}"
                    for key in before
                )
            )
        return table

    @model_validator(mode="before")
    @classmethod
    def plain_exchange(cls, table):
        """Set the default of `predictor` to 0 for explicit exchange."""
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
    """Content of the results file: scalar outputs at every macro step, `fields` at intervals."""

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
    checkpoint_every: int | None = Field(None, ge=0, json_schema_extra=ADVANCED)
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

    extends: str | None = None
    """Case whose tables this one has as well: a file, a folder, or the name of an installed case.
    Own keys replace its keys. Wires, axes and pictures are added to those of that case. One with
    a known `to`, `participants` or `file` changes the entry of that case.
    """
    without: list[str] = []
    """Keys of the extended case that this one does not have."""
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
    native: Flag | list[str] | None = None
    """Run participants of packages as machine code: true for all, false for none, or a list of
    names. Default: all participants that have a prebuilt library.
    """
    symmetric: Flag | None = None
    """Compute one half of films that are their own mirror image about the thrust plane. true
    rejects other cases, false computes whole films. Default: halves in symmetric cases.
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

    @field_validator("extends", "without")
    @classmethod
    def read_before(cls, value):
        raise ValueError("expected a case file for this key, got a change")

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

    @field_validator("pictures")
    @classmethod
    def different_files(cls, pictures):
        files = [picture.file for picture in pictures]
        for file in sorted({one for one in files if files.count(one) > 1}):
            raise ValueError(f"expected different files, got {file!r} twice")
        return pictures

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
        """Convert ranges relative to a parameter into ranges in units, once."""
        for axis in (axis for pair in self.axes for axis in (pair.first, pair.second)):
            if axis.length is not None:
                self._give_length(axis, *axis.length.split(".", 1))
        return self

    def _give_length(self, axis: Axis, owner: str, name: str) -> None:
        """Set the range of an axis from a length; it stays relative if the length is invalid."""
        table = self.participants.get(owner)
        text = table.parameters.get(name) if table else None
        begin, axis.length, axis.lower = self._length_at(axis.lower), None, None
        try:
            scale = from_si(to_si(str(text), "m"), "m", axis.unit)
        except ValueError:
            axis.label, axis.unit = f"{axis.label} / {name.replace('_', ' ')}", ""
            return
        begin = from_si(begin, "m", axis.unit)
        low, high = axis.range
        axis.range = (begin + low * scale, begin + high * scale)

    def _length_at(self, text: str | None) -> float:
        """Return the length of an axis' key `lower` [m]; 0 if it is omitted."""
        owner, *parts = (text or "").split(".build.")
        node: Any = self.participants[owner].build if owner in self.participants else None
        for part in parts[0].split(".") if parts else ():
            node = node.get(part) if isinstance(node, dict) else None
        try:
            return to_si(node if parts and isinstance(node, str) else text, "m") if text else 0.0
        except ValueError:
            expected = "a length, or a build option of a participant that holds one"
            raise ValueError(f"axes.second.lower: expected {expected}, got {text!r}") from None

    def _ports(self) -> list[str]:
        """Return every "participant.variable" that the file names."""
        ports = [port for wire in self.wires for port in (wire.source, wire.target)]
        ports += self.record.fields
        if self.time.angular_speed:
            ports.append(self.time.angular_speed)
        for picture in self.pictures:
            ports += picture.outputs + picture.fields
        for entries in (self.summary.values(), self.monitor.values(), self.window):
            ports += [reduced(text).port for text in entries]
        return ports

    def elements_of(self, participant: str) -> set[str]:
        """Return the single elements of arrays, "name[2]", that the file names of a participant."""
        ports = (port.partition(".") for port in self._ports())
        names = {name for owner, _, name in ports if owner == participant}
        names |= self.participants[participant].parameters.keys()
        return {name for name in names if base_of(name) != name}

    @property
    def period(self) -> str | None:
        """Period of the machine, None without crank angles.

        Default: 720 deg if gas or a four-stroke table drives the crank, otherwise 360 deg.
        """
        if self.time.period or self.time.angular_speed is None:
            return self.time.period
        return self.cycle or "360 deg"

    @property
    def cycle(self) -> str | None:
        """Cycle of gas or of tables of gas and speed, None without them."""
        tables = [
            table.build[key]
            for table in self.participants.values()
            for key in ("gas", "speed")
            if isinstance(table.build.get(key), dict)
        ]
        blown = any(wire.target.endswith(".gas_pressure") for wire in self.wires)
        if blown or any(table.get("strokes", 4) == 4 for table in tables):
            return "720 deg"
        return "360 deg" if tables else None

    def axes_of(self, port: str) -> Axes:
        """Return the axes of a field "participant.name"."""
        named = [
            (len(name), pair)
            for pair in self.axes
            for name in pair.participants
            if port.startswith(f"{name}.")
        ]
        return max(named, key=lambda one: one[0])[1] if named else NEUTRAL
