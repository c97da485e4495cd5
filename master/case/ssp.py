"""A case as a System Structure and Parameterization package (SSP), and back.

Components are the built FMUs. Their connectors are the fields of the interface and all scalar
inputs and outputs. Each component has an SSV with its parameters. Unconnected scalar inputs and
scalar outputs are also connectors of the system, and its own SSV contains the start values of these
inputs. FMI 2.0 FMUs give an SSP 1.0 with a connector for every scalar. An FMI 3.0 FMU gives an SSP
2.0 with arrays.

SSP does not define the step, tolerances, coupling and records. OMSimulator reads the step from
its annotation, the rest is in an annotation of this project. Both are in the system, because
OMSimulator rejects annotations of the root and reads only the first one of the system.
"""

import json
import zipfile
from collections import Counter
from hashlib import sha256
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement
from xml.sax.saxutils import escape

import numpy as np

from ..fmi.archive import check_archive
from ..fmi.cache import cache_folder
from ..fmi.description import VENDOR
from ..fmi.description3 import TYPES
from ..fmi.errors import BadInput, file_fault
from ..fmi.fields import base_of
from ..fmi.quantities import base_unit, is_known, pint_unit
from .checked import check_case

SPACE = {
    part: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for part, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"))
}

OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
"""Namespace of OMSimulator's annotations."""

SYSTEM = "case"
"""Name of the system and of its parameters."""

CARRIED = ("Integer", "Boolean", "String")
"""Types of connectors, in addition to Real, whose wires an SSP contains."""

LEFT = ("participants", "variants", "beside")
"""Tables of a case that SSP represents in another way or not at all."""


def _q(name):
    part, local = name.split(":")
    return f"{{{SPACE[part]}}}{local}"


def _add(parent, tag, /, **attributes):
    """Add an element such as "ssd:Connector" to another one, and return it."""
    return SubElement(parent, _q(tag), attributes)


def export_ssp(tree, system, path):
    """Write a case as an SSP.

    Parameters
    ----------
    tree : dict
        Its TOML tree.
    system : System
        The opened case.
    path : Path
        The SSP to write.

    Raises
    ------
    BadInput
        If a wire connects an FMI 3.0 array with FMI 2.0 scalars, or ends at a parameter or clock.
    """
    mixed = [
        f"{'.'.join(c.source)} -> {'.'.join(c.target)}: expected one FMI version on both sides, "
        "got 2.0 and 3.0"
        for c in system.wires
        if c.shape
        and len({_has_arrays(system.participants[end[0]]) for end in (c.source, c.target)}) > 1
    ]
    mixed += [
        f"{'.'.join(wire.source)} -> {'.'.join(wire.target)}: expected an input of type Real, "
        "Integer, Boolean or String in an SSP, got another type or a parameter"
        for wire in system.held
        if wire not in _carried(system)
    ]
    if mixed:
        raise BadInput(mixed)
    version = "2.0" if any(map(_has_arrays, system.participants.values())) else "1.0"
    members = {"SystemStructure.ssd": _xml(_structure(tree, system, version))}
    for name, participant in system.participants.items():
        members[f"resources/{name}.fmu"] = participant.path.read_bytes()
        members[f"resources/{name}.ssv"] = _xml(
            _parameters(
                name,
                {
                    key: (participant.fields[key], value)
                    for key, value in system.parameters[name].items()
                },
                participant,
                version,
            )
        )
    members[f"resources/{SYSTEM}.ssv"] = _xml(_starts(system, version))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)


def _carried(system):
    """Return the wires that SSP can describe."""
    fields = {
        wire: system.participants[wire.target[0]].fields[wire.target[1]] for wire in system.held
    }
    texts = [
        wire
        for wire, field in fields.items()
        if field.causality == "input" and field.type in CARRIED and not wire.clocked
    ]
    return [*system.wires, *texts]


def _has_arrays(participant):
    """Return whether the FMU has arrays with one value reference for all elements (FMI 3.0)."""
    return any(field.shape and len(field.references) == 1 for field in participant.fields.values())


def _type(participant, field):
    """Return the name of a variable's type in the FMU's version of FMI."""
    if not _has_arrays(participant):
        return field.type
    return field.native or TYPES[field.type]


def _xml(root):
    for part, space in SPACE.items():
        ElementTree.register_namespace(part, space)
    ElementTree.register_namespace("oms", OMS)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)


def _structure(tree, system, version):
    root = Element(
        _q("ssd:SystemStructureDescription"),
        {"name": SYSTEM, "version": version, "generationTool": VENDOR},
    )
    top = _add(root, "ssd:System", name=SYSTEM, description=tree["title"])
    ports = _system_ports(system)
    connectors = _add(top, "ssd:Connectors")
    for shown, (owner, name) in ports.items():
        participant = system.participants[owner]
        _connector(connectors, participant, participant.fields[name], shown)
    _binding(top, SYSTEM)
    elements = _add(top, "ssd:Elements")
    for name, participant in system.participants.items():
        wired = {end[1] for c in _carried(system) for end in (c.source, c.target) if end[0] == name}
        _component(elements, participant, wired | set(_scalars(participant)))
    joined = _add(top, "ssd:Connections")
    for c in _carried(system):
        source = system.participants[c.source[0]]
        for index in _indices(source, source.fields[c.source[1]].shape):
            _connect(joined, (c.source[0], c.source[1] + index), (c.target[0], c.target[1] + index))
    for shown, (owner, name) in ports.items():
        ends = (None, shown), (owner, name)
        enters = system.participants[owner].fields[name].causality == "input"
        _connect(joined, *(ends if enters else reversed(ends)))
    _annotations(top, tree, system)
    _units(root, "ssd", {c.get("unit") for c in root.iter()})
    times = {"startTime": repr(system.begin), "stopTime": repr(system.earliest)}
    _add(root, "ssd:DefaultExperiment", **times)
    return root


def _connect(parent, *ends):
    """Add a connection of two ends (element, connector); the system itself is no element."""
    attributes = {}
    for side, (element, connector) in zip(("start", "end"), ends):
        attributes |= {f"{side}Element": element} if element else {}
        attributes[f"{side}Connector"] = connector
    _add(parent, "ssd:Connection", **attributes)


def _annotations(parent, tree, system):
    """Add the step for OMSimulator, then the case for this tool."""
    annotations = _add(parent, "ssd:Annotations")
    node = _add(annotations, "ssc:Annotation", type="org.openmodelica")
    for name in ("Annotations", "SimulationInformation"):
        node = SubElement(node, f"{{{OMS}}}{name}")
    master = {"description": "oms-ma", "stepSize": repr(system.step)}
    tolerances = {"absoluteTolerance": "1e-4", "relativeTolerance": "1e-4"}
    SubElement(node, f"{{{OMS}}}FixedStepMaster", master | tolerances)
    own = _add(annotations, "ssc:Annotation", type=VENDOR)
    entries = {key: value for key, value in tree.items() if key not in LEFT}
    # an axis may begin at a build option, which the FMUs lack
    entries["axes"] = [one.model_dump(exclude_none=True) for one in check_case(tree, Path()).axes]
    SubElement(own, "case").text = json.dumps(entries)


def _units(parent, part, names):
    """Declare the units of these names."""
    known = sorted(name for name in names if name and _is_declared(name))
    if not known:
        return
    units = _add(parent, f"{part}:Units")
    for name in known:
        _add(_add(units, "ssc:Unit", name=name), "ssc:BaseUnit", **base_unit(name))


def _unit(field):
    """Return a field's unit if it is declared."""
    return {"unit": field.unit} if field.type == "Real" and _is_declared(field.unit) else {}


def _is_declared(unit):
    """Return whether a unit is a product of SI base units of mechanics and heat."""
    return unit != "1" and is_known(unit) and base_unit(unit).keys() <= {*"kg m s rad K".split()}


def _scalars(participant):
    """Return the names of the scalar inputs and outputs that are numbers."""
    return [
        name
        for name, field in participant.fields.items()
        if field.causality in ("input", "output")
        and not field.shape
        and field.type in ("Real", "Integer")
    ]


def _system_ports(system):
    """Return the connectors of the system: name -> (participant, variable).

    They are all scalar outputs, and all scalar inputs that no wire feeds. If several
    participants share a name, the participant precedes it.
    """
    fed = {wire.target for wire in (*system.wires, *system.held)}
    ports = [
        (owner, name)
        for owner, participant in system.participants.items()
        for name in _scalars(participant)
        if (owner, name) not in fed
    ]
    shared = Counter(name for _, name in ports)
    return {
        (name if shared[name] == 1 else f"{owner}_{name}"): (owner, name) for owner, name in ports
    }


def _starts(system, version):
    """Return the start values of the system's inputs: those of the case, else those of the FMU."""
    values = {}
    anyone = next(iter(system.participants.values()))
    for shown, (owner, name) in _system_ports(system).items():
        field = system.participants[owner].fields[name]
        if field.causality == "input":
            values[shown] = field, system.parameters[owner].get(name, field.start or 0.0)
    return _parameters(SYSTEM, values, anyone, version)


def _binding(parent, name):
    """Bind the SSV of this name to the element."""
    bindings = _add(parent, "ssd:ParameterBindings")
    _add(bindings, "ssd:ParameterBinding", source=f"resources/{name}.ssv")


def _indices(participant, shape):
    """Return the suffixes of an array's scalars; one empty suffix for one variable."""
    if not shape or _has_arrays(participant):
        return [""]
    return [f"[{','.join(str(k + 1) for k in index)}]" for index in np.ndindex(*shape)]


def _component(parent, participant, names):
    source = f"resources/{participant.name}.fmu"
    what = {"name": participant.name, "type": "application/x-fmu-sharedlibrary", "source": source}
    node = _add(parent, "ssd:Component", **what)
    connectors = _add(node, "ssd:Connectors")
    for name in sorted(names):
        field = participant.fields[name]
        for index in _indices(participant, field.shape):
            _connector(connectors, participant, field, name + index)
    _binding(node, participant.name)


def _connector(parent, participant, field, shown):
    """Add a connector for a field, or for a scalar of it."""
    node = _add(parent, "ssd:Connector", name=shown, kind=field.causality)
    _add(node, f"ssc:{_type(participant, field)}", **_unit(field))
    for size in field.shape if _has_arrays(participant) else ():
        _add(node, "ssc:Dimension", size=str(size))


def _parameters(name, values, participant, version):
    """Return the SSV of a name.

    `values` are (field, value) by name, with the types of the participant's FMU.
    """
    root = Element(_q("ssv:ParameterSet"), {"version": version, "name": name})
    parameters = _add(root, "ssv:Parameters")
    for shown, (field, value) in values.items():
        node = _add(parameters, "ssv:Parameter", name=shown)
        text = _item(field, value) if field.choices else str(value)
        _add(node, f"ssv:{_type(participant, field)}", value=text, **_unit(field))
    _units(root, "ssv", {node.get("unit") for node in root.iter()})
    return root


def _item(field, number):
    """Return the name of an enumeration's item."""
    return next(name for name, value in field.choices.items() if value == number)


def read_ssp(path):
    """Return the case of an SSP as a TOML tree, and unpack its FMUs into the user's cache.

    The SSP of another tool has no coupling. Then the tree contains participants, wires, stop time
    and the order of the components, and the user must add the macro step.

    Raises
    ------
    BadInput
        If the file is not an SSP.
    """
    try:
        folder = cache_folder("ssp") / sha256(Path(path).read_bytes()).hexdigest()[:16]
        with zipfile.ZipFile(path) as archive:
            check_archive(archive, Path(path))
            archive.extractall(folder)
        root = ElementTree.parse(folder / "SystemStructure.ssd").getroot()
    except (zipfile.BadZipFile, ElementTree.ParseError):
        raise BadInput(f"{path}: expected an SSP, got another file") from None
    except OSError as error:
        raise BadInput(file_fault(path, error)) from None
    components = list(root.iter(_q("ssd:Component")))
    participants = {
        node.get("name"): {
            "fmu": str(folder / node.get("source", "")),
            "parameters": _read_parameters(node, folder),
        }
        for node in components
    }
    wires = _wires(root, {name: table["fmu"] for name, table in participants.items()})
    experiment = root.find(_q("ssd:DefaultExperiment"))
    own = root.find(f".//{_q('ssc:Annotation')}[@type='{VENDOR}']/case")
    tree = (
        json.loads(own.text or "{}")
        if own is not None
        else {
            "title": root.get("name"),
            "coupling": {"order": list(participants)},
            "time": {"stop": f"{experiment.get('stopTime')} s"} if experiment is not None else {},
        }
    )
    known = {(wire["from"], wire["to"]): wire for wire in tree.get("wires", [])}
    return tree | {
        "participants": participants,
        "wires": [
            known.get((source, target), {"from": source, "to": target}) for source, target in wires
        ],
    }


def _wires(root, fmus):
    """Return the (source, target) of all connections between components.

    Connections of elements become one wire of the arrays if they join all elements of both in
    the same order. Otherwise each connection is a wire.
    """
    groups: dict[tuple, list] = {}
    for c in root.iter(_q("ssd:Connection")):
        if c.get("startElement") and c.get("endElement"):  # else a connector of the system itself
            ends = c.get("startConnector"), c.get("endConnector")
            bases = tuple(map(base_of, ends))
            groups.setdefault((c.get("startElement"), c.get("endElement"), *bases), []).append(ends)
    wires = []
    for (source, target, first, second), pairs in groups.items():
        whole = all(one.removeprefix(first) == two.removeprefix(second) for one, two in pairs)
        for owner, base in ((source, first), (target, second)):
            whole = whole and _elements(fmus.get(owner), base) in (0, len(pairs))
        chosen = [(first, second)] if whole else pairs
        wires += [(f"{source}.{one}", f"{target}.{two}") for one, two in chosen]
    return wires


def _elements(fmu, base):
    """Return how many variables of an FMU are elements of an array; 0 if it cannot be read."""
    try:
        with zipfile.ZipFile(fmu or "") as archive:
            text = archive.read("modelDescription.xml").decode(errors="replace")
    except (OSError, KeyError, zipfile.BadZipFile):
        return 0
    return text.count(f'name="{escape(base)}[')


def _read_parameters(component, folder):
    """Return the parameter values from all SSVs of a component, as a case file writes them."""
    values = {}
    for binding in component.iter(_q("ssd:ParameterBinding")):
        for node in (
            ElementTree.parse(folder / binding.get("source")).getroot().iter(_q("ssv:Parameter"))
        ):
            (value,) = node
            unit = pint_unit(value.get("unit", ""))
            text = f"{value.get('value')} {unit}".strip()
            is_text = value.tag in (_q("ssv:String"), _q("ssv:Enumeration"))
            is_number = not is_text and not unit
            values[node.get("name")] = float(text) if is_number else text
    return values
