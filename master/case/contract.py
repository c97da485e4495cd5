"""An FMU against the contract: names, units, shapes, capabilities; and an FMU in the place of a
case's participant.
"""

import tomllib
from pathlib import Path

from ...models import MODELS
from ..fmi.errors import BadInput
from ..participants.open import open_fmu

CONTRACT = MODELS / "lubrication_contract.toml"

CAPABILITIES = (
    "canHandleVariableCommunicationStepSize",
    "canGetAndSetFMUstate",
    "canSerializeFMUstate",
)


def contract():
    """The contract's table of each role."""
    whole = tomllib.loads(CONTRACT.read_text())
    return {name: terms for name, terms in whole.items() if name != "version"}


def role_of(participant):
    """Role ("lubrication", "bodies") whose outputs the FMU has; None if it has those of none."""
    for role, terms in contract().items():
        outputs = {
            name for name, field in participant.fields.items() if field.causality == "output"
        }
        if terms["outputs"]["field"].keys() <= outputs:
            return role
    return None


def check_fmu(path, role=None):
    """Differences between an FMU and the contract.

    Parameters
    ----------
    path : Path
    role : str, optional
        "lubrication" or "bodies"; without it, whichever the FMU's outputs fit.

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
        wanted = "; ".join(
            f"{name}: {', '.join(terms['outputs']['field'])}" for name, terms in contract().items()
        )
        raise BadInput(f"{path}: has the outputs of no role of the contract ({wanted})")
    terms = contract()[role]
    breaches, remarks = _capabilities(participant)
    _compare(participant, {"scalar": terms["parameters"]}, ("parameter",), breaches)
    _compare(participant, terms["inputs"], ("input", "parameter"), breaches)
    _compare(participant, terms["outputs"], ("output",), breaches)
    _compare(participant, terms["reported"], ("output",), remarks)
    shapes = {
        participant.fields[name].shape
        for kind in ("inputs", "outputs")
        for name in terms[kind].get("field", {})
        if name in participant.fields
    }
    if len(shapes) > 1:
        breaches.append(f"the fields have different shapes: {', '.join(map(str, sorted(shapes)))}")
    return role, breaches, remarks


def _compare(participant, terms, causalities, faults):
    """Append a sentence for every variable of `terms` (shape -> name -> unit) that is missing or
    different.
    """
    for shape, variables in terms.items():
        for name, unit in variables.items():
            field = participant.fields.get(name)
            if field is None or field.causality not in causalities:
                faults.append(f"{name}: no such {' or '.join(causalities)} [{unit}]")
            elif field.unit != unit and participant.declares_units:
                faults.append(f"{name}: unit {field.unit}, the contract says {unit}")
            elif (len(field.shape) == 2) != (shape == "field"):
                faults.append(f"{name}: shape {field.shape}, the contract says {shape}")


def _capabilities(participant):
    """Breaches and remarks on what the FMU can do."""
    can = participant.description.coSimulation
    breaches = [f"{flag} is not true" for flag in CAPABILITIES if not getattr(can, flag)]
    remarks = (
        []
        if participant.has_derivatives
        else ["no directional derivative: formed by repeated steps"]
    )
    remarks += [] if participant.declares_units else ["no units: taken to be SI"]
    return breaches, remarks


def swap_all(trees, given, say):
    """Trees of all variants with the FMUs `given` (role -> path or None) in place; says once what
    was left out.
    """
    for role, path in given.items():
        if path is None:
            continue
        if not path.is_file():
            raise BadInput(f"--{role} {path}: no such file")
        pairs = {
            label: swap(tree, contract()[role]["participant"], path)
            for label, tree in trees.items()
        }
        trees = {label: tree for label, (tree, _) in pairs.items()}
        left_out = next(iter(pairs.values()))[1]
        if left_out:
            say(f"{path.name} has no variable for, and the run goes without: {', '.join(left_out)}")
    return trees


def swap(tree, name, path):
    """A case's TOML tree with an FMU in the place of participant `name`.

    What the case says about variables the FMU does not have is left out: parameters, recorded
    fields, pictures, summary and monitor entries.

    Returns
    -------
    tree : dict
        A new one.
    left_out : list of str
        Keys of what was left out.
    """
    fields = open_fmu(name, path).fields
    left_out = []

    def known(port):
        owner, _, variable = port.split()[-1].partition(".")
        return owner != name or variable in fields

    def kept(table, entries):
        """Entries (key -> port) of a table whose port is there; the others are noted."""
        left_out.extend(f"{table}.{key}" for key, port in entries.items() if not known(port))
        return {key: port for key, port in entries.items() if known(port)}

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
                **{key: table[key] for key in ("isolated", "timeout") if key in table},
            }
        },
        "record": record
        | {
            "fields": list(kept("record.fields", {port: port for port in record.get("fields", [])}))
        },
        "summary": kept("summary", tree.get("summary", {})),
        "monitor": kept("monitor", tree.get("monitor", {})),
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
