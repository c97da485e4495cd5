"""Check of names, units, shapes and capabilities by the contract, and replacement by FMUs."""

import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from ...models import MODELS
from ..coupling.wiring import Wire, port_of
from ..fmi.errors import BadInput, for_all, names_of, unknown
from ..participants.open import open_fmu
from .keys import choices_of, part_function
from .tables import reduced

CONTRACT = MODELS / "lubrication_contract.toml"

CAPABILITIES = {
    "canSerializeFMUstate": "a run saves no checkpoints",
    "canHandleVariableCommunicationStepSize": "a macro step that fails is not halved",
}
"""Capabilities that a run can do without, and the consequence."""
OF_PYTHONFMU = {
    "canGetAndSetFMUstate": "; build it with `pythonfmu build --handle-state`",
    "canSerializeFMUstate": "; `pythonfmu build --serialize-state` adds it",
}
"""Options of pythonfmu that add a capability."""

Variables = dict[str, dict[str, str]]
"""Shape ("field", "scalar") -> name -> unit."""


@dataclass(frozen=True)
class Role:
    """Requirements of the contract for an FMU in one role; see the head of the contract."""

    participant: str
    package: str
    parameters: dict[str, str]
    inputs: Variables
    outputs: Variables
    reported: Variables
    model_parameter: str | None = None
    grids: dict[str, str] = field(default_factory=dict)
    build: dict[str, str] = field(default_factory=dict)
    repeats: tuple[str, ...] = ()
    records: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    turning: tuple[str, ...] = ()
    power: str | None = None
    energy_size: str | None = None
    power_size: str | None = None
    longest_step: str | None = None
    agree: dict[str, str] = field(default_factory=dict)
    of_each_film: tuple[str, ...] = ()
    starts_from: tuple[str, ...] = ()
    directions: dict[str, str] = field(default_factory=dict)
    numerical_errors: tuple[str, ...] = ()
    envelopes: dict[str, str] = field(default_factory=dict)
    around: dict[str, str] = field(default_factory=dict)
    wires: dict[str, dict[str, Any]] = field(default_factory=dict)
    optional_wires: dict[str, dict[str, Any]] = field(default_factory=dict)


@cache
def contract() -> dict[str, Role]:
    """Return the contract's roles by name."""
    whole = tomllib.loads(CONTRACT.read_text())
    return {name: Role(**terms) for name, terms in whole.items() if name != "version"}


def role_of(participant) -> str | None:
    """Return the role whose outputs the FMU has, None if there is none."""
    return next((name for name in contract() if surfaces_of(participant, name)), None)


def surfaces_of(participant, role: str) -> list[str]:
    """Return the prefixes of a role's field names in an FMU.

    They are "" for plain names and "SURFACE." for each of several film surfaces. If outputs of
    the role are missing, the list is empty.
    """
    terms = contract()[role]
    outputs = [f.name for f in participant.fields.values() if f.causality == "output"]
    names = list(terms.outputs["field"])
    prefixes = [name.removesuffix(names[0]) for name in outputs if name.endswith(names[0])]
    allowed = [one for one in prefixes if not one or terms.of_each_film and one.endswith(".")]
    return [one for one in allowed if all(f"{one}{name}" in outputs for name in names)]


class Interface(NamedTuple):
    """Other side of a participant's fields.

    owner : participant; surface : prefix of the names there ("", or "SURFACE." of a film surface).
    """

    owner: str
    surface: str


def interface(wires: Iterable[Mapping[str, str] | Any], name: str, role: str) -> Interface | None:
    """Return the source of the fields that participant `name` takes in its role, or None.

    Parameters
    ----------
    wires : iterable
        Wires of a case, or of its TOML tree.
    """
    for wire in wires:
        ends = (
            (wire["from"], wire["to"]) if isinstance(wire, Mapping) else (wire.source, wire.target)
        )
        (giver, port), (taker, taken) = map(port_of, ends)
        if taker == name and taken in contract()[role].inputs["field"] and port.endswith(taken):
            return Interface(giver, port.removesuffix(taken))
    return None


class Given(NamedTuple):
    """Value that a participant takes from the source of its fields, by the contract.

    name, key : participant and its key; source : the other side; what : name of the value there.
    """

    name: str
    key: str
    source: Interface
    what: str


def given_by_others(case: Any, kind: str) -> Iterator[Given]:
    """Yield the pairs of `Role.build` or `Role.agree` that a case has."""
    for name, table in case.participants.items():
        if table.role not in contract():
            continue
        other = interface(case.wires, name, table.role)
        if other is None:
            continue
        for key, source in getattr(contract()[table.role], kind).items():
            role, _, what = source.partition(".")
            if case.participants[other.owner].role == role:
                yield Given(name, key, other, what)


def envelope_kinds(tree: dict) -> dict[str, str]:
    """Return the fields of a case with envelopes: port -> "min" or "max".

    The port of an input is that of its source.
    """
    kinds = {}
    for role, terms in contract().items():
        for name in players(tree, role) if terms.envelopes else ():
            other = interface(tree.get("wires", ()), name, role)
            source = f"{other.owner}.{other.surface}" if other else f"{name}."
            for variable, kind in terms.envelopes.items():
                owner = source if variable in terms.inputs["field"] else f"{name}."
                kinds[owner + variable] = kind
    return kinds


def starting_order(names: Iterable[str], wires: Iterable[Wire]) -> list[str]:
    """Return the participants in the order in which they start.

    It is the order of the case, except that `starts_from` of the contract names inputs whose source
    must start first.

    Raises
    ------
    BadInput
        If some wait for each other.
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
    """Return the participants of a TOML tree that have a role, else the one the contract names."""
    tables = tree["participants"]
    owners = [name for name, table in tables.items() if table.get("role") == role]
    usual = contract()[role].participant
    return owners or [name for name in tables if name == usual]


def replaced_participant(tree: dict, role: str, text: str) -> tuple[str, str]:
    """Return participant and model of a `--ROLE` option "FILE" or "PARTICIPANT=FILE".

    Raises
    ------
    BadInput
        If the case has no such participant, or several of the role and the option names none.
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


def check_fmu(path: Path) -> tuple[str, list[str], list[str]]:
    """Return the differences between an FMU and the contract.

    Parameters
    ----------
    path : Path

    Returns
    -------
    role : str
        Whose outputs the FMU has.
    breaches : list of str
        Reasons why it cannot take part.
    remarks : list of str
        Missing features that it can do without.

    Raises
    ------
    BadInput
        If the file is not an FMU, or has no role.
    """
    participant = open_fmu("fmu", path)
    role = role_of(participant)
    if role is None:
        contract_names = names_of(contract())
        raise BadInput(f"{path}: expected the outputs of {contract_names}, got others")
    terms = contract()[role]
    units = in_contract_units(participant, role)
    breaches, remarks = unable_to_iterate(participant), _capabilities(participant)
    if units:
        listed = ", ".join(f"{name} [{unit}]" for name, unit in units)
        remarks.append(f"no unit, so that of the contract: {listed}")
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
            got = ", ".join(map(str, sorted(shapes)))
            breaches.append(f"fields{of}: expected equal shapes, got {got}")
    return role, breaches, remarks


def _named(terms, surfaces):
    """Return the parameters of a role with their units, with a prefix for each of several films."""
    return {
        f"{one}{name}": unit
        for name, unit in terms.parameters.items()
        for one in (surfaces if name in terms.of_each_film else ("",))
    }


def _compare(participant, terms, causalities, faults):
    """Append a fault for every variable of `terms` (shape -> name -> unit) that differs."""
    for shape, variables in terms.items():
        for name, unit in variables.items():
            field = participant.fields.get(name)
            if field is None or field.causality not in causalities:
                faults.append(f"{name}: expected {' or '.join(causalities)} [{unit}], got none")
            elif field.unit != unit:
                faults.append(f"{name}: expected unit {unit}, got {field.unit}")
            elif (len(field.shape) == 2) != (shape == "field"):
                faults.append(f"{name}: expected a {shape}, got shape {field.shape}")


def unable_to_iterate(participant: Any) -> list[str]:
    """Return why an FMU cannot take part, if its steps cannot be repeated."""
    can = participant.description.coSimulation
    flag = "canGetAndSetFMUstate"
    hint = _hint(participant, flag)
    return [] if getattr(can, flag) else [f"{flag}: expected true, got false{hint}"]


def _hint(participant, flag):
    """Return how an FMU of pythonfmu gets a capability; empty for others."""
    tool = participant.description.generationTool or ""
    return OF_PYTHONFMU.get(flag, "") if tool.lower().startswith("pythonfmu") else ""


def _capabilities(participant):
    """Return remarks about missing capabilities of the FMU."""
    can = participant.description.coSimulation
    remarks = [
        f"{flag}: false, so {consequence}{_hint(participant, flag)}"
        for flag, consequence in CAPABILITIES.items()
        if not getattr(can, flag)
    ]
    if not participant.has_derivatives:
        remarks.append("no directional derivative: formed by repeated steps")
    return remarks


def in_contract_units(participant: Any, role: str | None) -> list[tuple[str, str]]:
    """Give the variables of an FMU without a unit those of the contract's package.

    Parameters
    ----------
    participant : Participant
        Its `fields` are replaced.
    role : str or None
        Role in the contract. Participants of other roles do not change.

    Returns
    -------
    list of (str, str)
        Name and unit of the variables that had none.
    """
    if role not in contract():
        return []
    declared = part_function(contract()[role].package, "declared_variables")
    units = {v.name: v.unit for v in declared(None, Path())} if declared else {}
    fields = participant.fields
    added = [
        (name, units[name])
        for name, field in fields.items()
        if field.type == "Real" and field.unit == "1" and units.get(name, "1") != "1"
    ]
    fields.update({name: replace(fields[name], unit=unit) for name, unit in added})
    return added


def swap_all(
    trees: dict[str, dict[str, Any]],
    models: Mapping[str, Sequence[str]],
    say: Callable[[str], object],
) -> dict[str, dict[str, Any]]:
    """Return the trees of all variants with the models `models`: role -> "[PARTICIPANT=]MODEL".

    A model is an FMU, a model class FILE.py:CLASS, or a value of the role's `model_parameter`.
    With several models of a role, each variant becomes a tree for each model, with the name of the
    model in its label. All trees have the pictures that every model can fill. Calls `say` with the
    keys that the case has and a model lacks.
    """
    for role, texts in models.items():
        if texts:
            trees = _swapped(trees, role, texts, say)
    return trees


def _swapped(trees, role, texts, say):
    """Return a tree for each variant and model."""
    first = next(iter(trees.values()))
    parameter = contract()[role].model_parameter

    def model_of(text):
        """Return participant, name of the model, and its FMU or None for a parameter."""
        name, model = replaced_participant(first, role, text)
        if parameter and not model.endswith((".fmu", ".py")) and ".py:" not in model:
            known = choices_of(first["participants"][name], parameter)
            if known and model not in known:
                raise BadInput(f"--{role}: {unknown('model', model, known)}")
            return name, model, None
        fmu = fmu_of_model(role, model, first["participants"][name], say)
        return name, model.rpartition(":")[2] if ".py:" in model else fmu.stem, fmu

    variants = {}
    common = trees
    for name, model, fmu in for_all(model_of, texts):
        pairs = {
            label: swap(tree, name, fmu, say) if fmu else (_set(tree, name, parameter, model), [])
            for label, tree in trees.items()
        }
        if left_out := next(iter(pairs.values()))[1]:
            say(
                f"{model} lacks the variables of these keys, and the run omits them: "
                f"{', '.join(left_out)}"
            )
        if fmu:
            common = {label: swap(tree, name, fmu)[0] for label, tree in common.items()}
        for label, (tree, _) in pairs.items():
            parts = [label] * (len(trees) > 1 or len(texts) == 1) + [model] * (len(texts) > 1)
            variants["_".join(parts)] = label, tree
    if len(variants) < len(trees) * len(texts):
        raise BadInput(f"--{role}: expected models of different names, got {', '.join(texts)}")
    return {
        label: tree | {"pictures": common[variant].get("pictures", [])}
        for label, (variant, tree) in variants.items()
    }


def _set(tree, name, parameter, value):
    """Return the tree with another value of a participant's parameter."""
    own = tree["participants"][name]
    changed = own | {"parameters": own.get("parameters", {}) | {parameter: value}}
    return tree | {"participants": tree["participants"] | {name: changed}}


def fmu_of_model(role: str, model: str, table: dict, say: Callable[[str], object]) -> Path:
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
    if ".py:" in model and Path(model.rpartition(":")[0]).is_file():
        from ..fmi.builder import build_fmu_of_file

        grid = table.get("build", {}).get("grid", [40, 40])
        return build_fmu_of_file(model, {"grid": list(grid)}, say)
    if not Path(model).is_file() or model.endswith(".py"):
        raise BadInput(f"--{role}: expected an existing FMU or FILE.py:CLASS, got {model!r}")
    return Path(model)


def swap(
    tree: dict, name: str, path: Path, say: Callable[[str], object] = lambda text: None
) -> tuple[dict, list[str]]:
    """Return a case's TOML tree with an FMU that replaces participant `name`.

    Keys that refer to variables which the FMU lacks are removed: parameters, recorded fields,
    pictures, summary, monitor and window entries. All studies are removed. The body of a film has
    the grid of the film's fields, see `Role.grids`, and the films of a body have its grid; `say` is
    called if that is another one.

    Returns
    -------
    tree : dict
        A new tree.
    left_out : list of str
        Removed keys.

    Raises
    ------
    BadInput
        If the FMU lacks variables of the wires, or has another grid that its body cannot follow.
    """
    fields = open_fmu(name, path).fields
    changed = _with_grid_of(tree, name, fields, say)
    _check_ends(tree, name, fields, changed is tree)
    tree = changed
    left_out: list[str] = []

    def known(port):
        owner, _, variable = port.partition(".")
        return owner != name or variable in fields

    def left(table, entries):
        """Return the entries (key -> port) whose port exists, and add the others to `left_out`."""
        left_out.extend(f"{table}.{key}" for key, port in entries.items() if not known(port))
        return {key: port for key, port in entries.items() if known(port)}

    def kept_reductions(table):
        entries = tree.get(table, {})
        ports = left(table, {key: reduced(text).port for key, text in entries.items()})
        return {key: entries[key] for key in ports}

    table = tree["participants"][name]
    texts = table.get("parameters", {})
    parameters = left(f"participants.{name}.parameters", {key: f"{name}.{key}" for key in texts})
    record = tree.get("record", {})
    pictures = (_picture(one, known, left_out) for one in tree.get("pictures", []))
    swapped = tree | {
        "participants": tree["participants"]
        | {
            name: {
                "fmu": str(Path(path).resolve()),
                "parameters": {key: texts[key] for key in parameters},
                **{key: table[key] for key in ("role", "isolated", "timeout") if key in table},
            }
        },
        "record": record
        | {
            "fields": list(left("record.fields", {port: port for port in record.get("fields", [])}))
        },
        "summary": kept_reductions("summary"),
        "window": {
            text: limits
            for text, limits in tree.get("window", {}).items()
            if text in left("window", {text: reduced(text).port})
        },
        "studies": {},  # they compare runs of the case's own FMU
        "monitor": kept_reductions("monitor"),
        "pictures": [*filter(None, pictures)],
    }
    return swapped, left_out


def _check_ends(tree, name, fields, keeps_grid):
    """Raise `BadInput` if an FMU cannot have the wires of the participant that it replaces.

    keeps_grid : whether the body of a film keeps its grid.
    """
    ends = [port_of(wire[end]) for wire in tree.get("wires", ()) for end in ("from", "to")]
    wired = [variable for owner, variable in ends if owner == name]
    if lacking := [variable for variable in dict.fromkeys(wired) if variable not in fields]:
        raise BadInput(
            f"participants.{name}: expected an FMU with {', '.join(lacking)} for its wires, got "
            "one without; models for a skirt and for a bearing differ"
        )
    is_film = any(name in players(tree, role) for role, terms in contract().items() if terms.grids)
    grid = is_film and tree["participants"][name].get("build", {}).get("grid")
    shapes = [fields[variable].shape for variable in wired if len(fields[variable].shape) == 2]
    if keeps_grid and grid and shapes and shapes[0] != (*grid,):
        raise BadInput(
            f"participants.{name}: expected fields of shape {(*grid,)}, got {shapes[0]}; build the "
            "FMU on the grid of the film that it replaces, which its body cannot change"
        )


def _with_grid_of(tree, name, fields, say):
    """Return the tree with the other side of an FMU's fields on its grid: body or films."""
    for role, terms in contract().items():
        for film in players(tree, role) if terms.grids else ():
            other = interface(tree.get("wires", ()), film, role)
            if other is None or name not in (film, other.owner):
                continue
            of_film = film == name
            owner, before = (other.owner, "") if of_film else (film, other.surface)
            key = terms.grids.get(other.surface) if of_film else "grid"
            field = fields.get(before + next(iter(terms.inputs["field"])))
            table = tree["participants"][owner]
            build, on_grid = table.get("build", {}), part_function(table.get("package"), "on_grid")
            if not (field and key and on_grid) or len(field.shape) != 2:
                continue
            if build.get(key) != [*field.shape]:
                changed = on_grid(build, key, field.shape)
                lines = ", ".join(_changes(build, changed, f"participants.{owner}.build"))
                say(f"{lines}: the grid of the FMU of {name}")
                tables = {owner: table | {"build": changed}}
                tree = tree | {"participants": tree["participants"] | tables}
    return tree


def _changes(old, new, before):
    """Yield the values of a table that differ from an older one."""
    for key, value in new.items():
        if isinstance(value, dict):
            yield from _changes(old.get(key, {}), value, f"{before}.{key}")
        elif old.get(key) != value:
            yield f"{before}.{key} = {value}"


def _picture(picture, known, left_out):
    """Return a picture with the existing curves and fields.

    Returns None if it has none, or if its horizontal axis or the output of its instant is missing.
    """
    x, (kind, marker) = picture.get("x"), reduced(picture.get("time", ""))
    needed = [port for port in (x, marker if kind in ("min", "max") else None) if port]
    curves = [[port for port in panel if known(port)] for panel in picture.get("y", [])]
    shown = [port for port in picture.get("fields", []) if known(port)]
    lost = [
        port
        for port in [*picture.get("fields", []), *sum(picture.get("y", []), []), *needed]
        if not known(port)
    ]
    left_out.extend(f"pictures.{picture['file']}: {port}" for port in lost)
    whole = (
        picture
        | ({"y": [panel for panel in curves if panel]} if curves else {})
        | ({"fields": shown} if shown else {})
    )
    nothing = not any(curves) and not shown
    return whole if all(map(known, needed)) and not nothing else None
