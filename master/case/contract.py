"""An FMU against the contract: names, units, shapes, capabilities; and an FMU in the place of a
case's participant.
"""

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from ...models import MODELS
from ..coupling.wiring import Wire, port_of
from ..fmi.errors import BadInput, names_of, unknown
from ..participants.open import open_fmu
from .tables import reduced

CONTRACT = MODELS / "lubrication_contract.toml"

CAPABILITIES = (
    "canHandleVariableCommunicationStepSize",
    "canGetAndSetFMUstate",
    "canSerializeFMUstate",
)

Variables = dict[str, dict[str, str]]
"""Shape ("field", "scalar") -> name -> unit."""


@dataclass(frozen=True)
class Curve:
    """One thing by which FMUs of a role are held against each other; see the contract's head."""

    fields: list[str]
    cells: str
    number: str
    instants: str
    unit: str
    title: str = ""
    factor: float = 1.0


@dataclass(frozen=True)
class Role:
    """What the contract asks of an FMU in one role; see the contract's head."""

    participant: str
    parameters: dict[str, str]
    inputs: Variables
    outputs: Variables
    reported: Variables
    model_parameter: str | None = None
    curves: tuple[Curve, ...] = field(default=())
    build: dict[str, str] = field(default_factory=dict)
    repeats: tuple[str, ...] = ()
    turning: tuple[str, ...] = ()
    energy: str | None = None
    energy_size: str | None = None
    agree: dict[str, str] = field(default_factory=dict)
    of_each_film: tuple[str, ...] = ()
    starts_from: tuple[str, ...] = ()
    directions: dict[str, str] = field(default_factory=dict)
    numerical_errors: tuple[str, ...] = ()
    envelopes: dict[str, str] = field(default_factory=dict)
    around: dict[str, str] = field(default_factory=dict)


@cache
def contract() -> dict[str, Role]:
    """The contract's roles by their names."""
    whole = tomllib.loads(CONTRACT.read_text())
    return {
        name: Role(
            **{**terms, "curves": tuple(Curve(**entry) for entry in terms.get("curves", ()))}
        )
        for name, terms in whole.items()
        if name != "version"
    }


def role_of(participant) -> str | None:
    """Role whose outputs the FMU has; None if it has those of none."""
    return next((name for name in contract() if surfaces_of(participant, name)), None)


def surfaces_of(participant, role: str) -> list[str]:
    """What the names of a role's fields begin with in an FMU: "" where they are plain, "SURFACE."
    for each of several film surfaces; none where outputs of the role are lacking.
    """
    terms = contract()[role]
    outputs = [f.name for f in participant.fields.values() if f.causality == "output"]
    wanted = list(terms.outputs["field"])
    found = [name.removesuffix(wanted[0]) for name in outputs if name.endswith(wanted[0])]
    allowed = [one for one in found if not one or terms.of_each_film and one.endswith(".")]
    return [one for one in allowed if all(f"{one}{name}" in outputs for name in wanted)]


class Interface(NamedTuple):
    """The other side of a participant's fields: which participant, and what their names begin
    with there ("", or "SURFACE." of one of several film surfaces).
    """

    owner: str
    surface: str


def interface(wires: Iterable[Mapping[str, str] | Any], name: str, role: str) -> Interface | None:
    """Where the wires to the fields that participant `name` takes in its role come from; None
    without such a wire.

    Parameters
    ----------
    wires : iterable
        Of a case, or of its TOML tree.
    """
    for wire in wires:
        ends = (
            (wire["from"], wire["to"]) if isinstance(wire, Mapping) else (wire.source, wire.target)
        )
        (giver, given), (taker, taken) = map(port_of, ends)
        if taker == name and taken in contract()[role].inputs["field"] and given.endswith(taken):
            return Interface(giver, given.removesuffix(taken))
    return None


def envelope_kinds(tree: dict) -> dict[str, str]:
    """Return the fields of a case with envelopes: port -> "min" or "max".

    The port of an input is that of its source.
    """
    found = {}
    for role, terms in contract().items():
        for name in players(tree, role) if terms.envelopes else ():
            other = interface(tree.get("wires", ()), name, role)
            source = f"{other.owner}.{other.surface}" if other else f"{name}."
            for variable, kind in terms.envelopes.items():
                owner = source if variable in terms.inputs["field"] else f"{name}."
                found[owner + variable] = kind
    return found


def starting_order(names: Iterable[str], wires: Iterable[Wire]) -> list[str]:
    """Participants in the order in which they start: that of the case, but for those that a wire
    feeds what the contract says they start from (`starts_from`): they wait for its source.

    Raises
    ------
    BadInput
        If some wait for one another.
    """
    inputs = {name for role in contract().values() for name in role.starts_from}
    waiting = {name: set() for name in names}
    for wire in wires:
        owner, variable = wire.target
        if variable in inputs and wire.source[1].endswith(variable):
            waiting[owner].add(wire.source[0])
    order: list[str] = []
    while len(order) < len(waiting):
        ready = (name for name in waiting if name not in order and waiting[name] <= {*order})
        name = next(ready, None)
        if name is None:
            left = ", ".join(one for one in waiting if one not in order)
            raise BadInput(
                f"wires: expected a participant that can start first, got a loop of {left} through "
                f"{', '.join(inputs)}"
            )
        order.append(name)
    return order


def players(tree: dict, role: str) -> list[str]:
    """Participants of a case's TOML tree that play a role: those that say so, else the one that the
    contract names.
    """
    tables = tree["participants"]
    said = [name for name, table in tables.items() if table.get("role") == role]
    usual = contract()[role].participant
    return said or [name for name in tables if name == usual]


def in_place_of(tree: dict, role: str, text: str) -> tuple[str, str]:
    """Participant and file (or model) of "FILE" or "PARTICIPANT=FILE", as --ROLE takes it.

    Raises
    ------
    BadInput
        If the case has no such participant, or several of the role and none is named.
    """
    known = players(tree, role)
    named, sign, rest = text.rpartition("=")
    if sign and named in known:
        return named, rest
    if sign and named.isidentifier():
        raise BadInput(f"--{role}: {unknown('participant', named, known)}")
    if len(known) == 1:
        return known[0], text
    if not known:
        raise BadInput(f"--{role}: expected a participant with role = {role!r}, got none")
    raise BadInput(
        f"--{role}: expected one of {', '.join(known)}, got several; write --{role} "
        f"{known[0]}={text}"
    )


def check_fmu(path: Path, role: str | None = None) -> tuple[str, list[str], list[str]]:
    """Differences between an FMU and the contract.

    Parameters
    ----------
    path : Path
    role : str, optional
        Without it, whichever the FMU's outputs fit.

    Returns
    -------
    role : str
    breaches : list of str
        What keeps it from taking part.
    remarks : list of str
        What it lacks but can take part without.

    Raises
    ------
    BadInput
        If the file is no FMU, or fits no role.
    """
    participant = open_fmu("fmu", path)
    role = role or role_of(participant)
    if role is None:
        wanted = names_of(contract())
        raise BadInput(f"{path}: expected the outputs of {wanted}, got others")
    terms = contract()[role]
    breaches, remarks = _capabilities(participant)
    surfaces = surfaces_of(participant, role) or [""]
    _compare(participant, {"scalar": _named(terms, surfaces)}, ("local", "parameter"), breaches)
    for side, causalities in ((terms.inputs, ("input", "parameter")), (terms.outputs, ("output",))):
        scalars = {"scalar": side.get("scalar", {})}
        fields = {f"{one}{name}": unit for one in surfaces for name, unit in side["field"].items()}
        _compare(participant, scalars | {"field": fields}, causalities, breaches)
    _compare(participant, terms.reported, ("output",), remarks)
    for one in surfaces:
        shapes = {
            participant.fields[f"{one}{name}"].shape
            for side in (terms.inputs, terms.outputs)
            for name in side["field"]
            if f"{one}{name}" in participant.fields
        }
        if len(shapes) > 1:
            of = f" of {one.removesuffix('.')}" if one else ""
            told = ", ".join(map(str, sorted(shapes)))
            breaches.append(f"fields{of}: expected equal shapes, got {told}")
    return role, breaches, remarks


def _named(terms, surfaces):
    """Parameters of a role with their units, those of each film by the names they have."""
    return {
        f"{one}{name}": unit
        for name, unit in terms.parameters.items()
        for one in (surfaces if name in terms.of_each_film else ("",))
    }


def _compare(participant, terms, causalities, faults):
    """Append a sentence for every variable of `terms` (shape -> name -> unit) that is missing or
    different.
    """
    for shape, variables in terms.items():
        for name, unit in variables.items():
            field = participant.fields.get(name)
            if field is None or field.causality not in causalities:
                faults.append(f"{name}: expected a {' or '.join(causalities)} [{unit}], got none")
            elif field.unit != unit and participant.declares_units:
                faults.append(f"{name}: expected unit {unit}, got {field.unit}")
            elif (len(field.shape) == 2) != (shape == "field"):
                faults.append(f"{name}: expected a {shape}, got shape {field.shape}")


def _capabilities(participant):
    """Breaches and remarks on what the FMU can do."""
    can = participant.description.coSimulation
    breaches = [
        f"{flag}: expected true, got false" for flag in CAPABILITIES if not getattr(can, flag)
    ]
    remarks = (
        []
        if participant.has_derivatives
        else ["no directional derivative: formed by repeated steps"]
    )
    remarks += [] if participant.declares_units else ["no units: taken to be SI"]
    return breaches, remarks


def swap_all(
    trees: dict[str, dict], given: Mapping[str, str | None], say: Callable[[str], None]
) -> dict[str, dict]:
    """Return the trees of all variants with the models `given`: role -> "[PARTICIPANT=]MODEL".

    A model is an FMU, or a model class FILE.py:CLASS. Calls `say` with the keys that the case has
    and the model lacks.
    """
    for role, text in given.items():
        if text is None:
            continue
        first = next(iter(trees.values()))
        name, model = in_place_of(first, role, text)
        fmu = fmu_of_model(role, model, first["participants"][name], say)
        pairs = {label: swap(tree, name, fmu) for label, tree in trees.items()}
        trees = {label: tree for label, (tree, _) in pairs.items()}
        left_out = next(iter(pairs.values()))[1]
        if left_out:
            say(
                f"{Path(model).name} lacks the variables of these keys, and the run omits them: "
                f"{', '.join(left_out)}"
            )
    return trees


def fmu_of_model(role: str, model: str, table: dict, say: Callable[[str], None]) -> Path:
    """Return the FMU of a model; build it from FILE.py:CLASS if the cache lacks it.

    Parameters
    ----------
    role : str
        Role in the contract.
    model : str
        Path of an FMU, or FILE.py:CLASS.
    table : dict
        Participant that the model replaces. The built FMU has the grid of its build options.
    say : callable
        Called with a message before the FMU is built.

    Raises
    ------
    BadInput
        If the file or the class does not exist.
    """
    if ".py:" in model:
        from ..fmi.builder import build_fmu_of_file

        grid = table.get("build", {}).get("grid", [40, 40])
        return build_fmu_of_file(model, {"grid": list(grid)}, say)
    if not Path(model).is_file():
        raise BadInput(f"--{role}: expected a file, got no such file {model!r}")
    return Path(model)


def swap(tree: dict, name: str, path: Path) -> tuple[dict, list[str]]:
    """A case's TOML tree with an FMU in the place of participant `name`.

    What the case says about variables the FMU does not have is left out: parameters, recorded
    fields, pictures, summary and monitor entries; studies altogether.

    Returns
    -------
    tree : dict
        A new one.
    left_out : list of str
        Keys of what was left out.
    """
    fields = open_fmu(name, path).fields
    left_out: list[str] = []

    def known(port):
        owner, _, variable = port.partition(".")
        return owner != name or variable in fields

    def kept(table, entries):
        """Entries (key -> port) of a table whose port is there; the others are noted."""
        left_out.extend(f"{table}.{key}" for key, port in entries.items() if not known(port))
        return {key: port for key, port in entries.items() if known(port)}

    def kept_reductions(table):
        entries = tree.get(table, {})
        ports = kept(table, {key: reduced(text).port for key, text in entries.items()})
        return {key: entries[key] for key in ports}

    table = tree["participants"][name]
    given = table.get("parameters", {})
    parameters = kept(f"participants.{name}.parameters", {key: f"{name}.{key}" for key in given})
    record = tree.get("record", {})
    swapped = tree | {
        "participants": tree["participants"]
        | {
            name: {
                "fmu": str(Path(path).resolve()),
                "parameters": {key: given[key] for key in parameters},
                **{key: table[key] for key in ("role", "isolated", "timeout") if key in table},
            }
        },
        "record": record
        | {
            "fields": list(kept("record.fields", {port: port for port in record.get("fields", [])}))
        },
        "summary": kept_reductions("summary"),
        "studies": {},  # they compare runs of the case's own FMU
        "monitor": kept_reductions("monitor"),
        "pictures": [
            p
            for p in (_picture(picture, known, left_out) for picture in tree.get("pictures", []))
            if p
        ],
    }
    return swapped, left_out


def _picture(picture, known, left_out):
    """The picture without curves and fields that are not there; None if nothing is left."""
    curves = [[port for port in panel if known(port)] for panel in picture.get("y", [])]
    shown = [port for port in picture.get("fields", []) if known(port)]
    lost = [
        port
        for port in [*picture.get("fields", []), *sum(picture.get("y", []), [])]
        if not known(port)
    ]
    left_out.extend(f"pictures.{picture['file']}: {port}" for port in lost)
    whole = (
        picture
        | ({"y": [panel for panel in curves if panel]} if curves else {})
        | ({"fields": shown} if shown else {})
    )
    nothing = not any(curves) and not shown
    return None if nothing or picture.get("x") and not known(picture["x"]) else whole
