"""A case as a System Structure and Parameterization package (SSP), and back.

Components are the built FMUs, connectors what crosses the interface, parameters one SSV a
component. FMI 2.0 FMUs make an SSP 1.0 with a connector for every scalar; with an FMI 3.0 FMU it is
an SSP 2.0, whose connectors are arrays with dimensions. What SSP has no words for (tolerances,
coupling, macro step, records) travels in an annotation that other tools pass over.
"""

import json
import zipfile
from hashlib import sha256
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ..fmi.archive import check_archive
from ..fmi.cache import cache_folder
from ..fmi.description import BASE_UNITS, VENDOR
from ..fmi.errors import BadInput
from ..fmi.fields import ELEMENT
from ..fmi.quantities import pint_unit

SPACE = {
    part: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for part, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"))
}

LEFT = ("participants", "variants", "beside")
"""Tables of a case that an SSP says otherwise, or does not have."""


def _q(name):
    part, local = name.split(":")
    return f"{{{SPACE[part]}}}{local}"


def export_ssp(tree, system, path):
    """Write a case as an SSP.

    Parameters
    ----------
    tree : dict
        Its TOML tree.
    system : System
        The case opened.
    path : Path
        The SSP to write.

    Raises
    ------
    BadInput
        If a wire joins an array with scalars: an FMU of FMI 3.0 with one of FMI 2.0.
    """
    mixed = [
        f"{'.'.join(c.source)} -> {'.'.join(c.target)}: an FMU of FMI 3.0 on one side alone; "
        "take one version on both"
        for c in system.wires
        if c.shape
        and len({_has_arrays(system.participants[end[0]]) for end in (c.source, c.target)}) > 1
    ]
    mixed += [
        f"{'.'.join(wire.source)} -> {'.'.join(wire.target)}: is no wire of real numbers; "
        "none other goes into an SSP"
        for wire in system.held
    ]
    if mixed:
        raise BadInput(mixed)
    version = "2.0" if any(map(_has_arrays, system.participants.values())) else "1.0"
    members = {"SystemStructure.ssd": _xml(_structure(tree, system, version))}
    for name, participant in system.participants.items():
        members[f"resources/{name}.fmu"] = participant.path.read_bytes()
        members[f"resources/{name}.ssv"] = _xml(
            _parameters(participant, system.parameters[name], version)
        )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)


def _has_arrays(participant):
    """Whether the FMU has true arrays, one value reference for all elements: FMI 3.0."""
    return any(field.shape and len(field.references) == 1 for field in participant.fields.values())


TYPES_3 = {
    "Real": "Float64",
    "Integer": "Int32",
    "String": "String",
    "Enumeration": "Enumeration",
}


def _type(participant, field):
    """Name of a variable's type in the FMU's version of FMI."""
    return TYPES_3[field.type] if _has_arrays(participant) else field.type


def _xml(root):
    for part, space in SPACE.items():
        ElementTree.register_namespace(part, space)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)


def _structure(tree, system, version):
    root = Element(
        _q("ssd:SystemStructureDescription"),
        {"name": "case", "version": version, "generationTool": VENDOR},
    )
    top = SubElement(root, _q("ssd:System"), {"name": "case", "description": tree["title"]})
    elements = SubElement(top, _q("ssd:Elements"))
    for name, participant in system.participants.items():
        _component(
            elements,
            participant,
            {end[1] for c in system.wires for end in (c.source, c.target) if end[0] == name},
        )
    joined = SubElement(top, _q("ssd:Connections"))
    for c in system.wires:
        for index in [""] if _has_arrays(system.participants[c.source[0]]) else _indices(c.shape):
            SubElement(
                joined,
                _q("ssd:Connection"),
                {
                    "startElement": c.source[0],
                    "startConnector": c.source[1] + index,
                    "endElement": c.target[0],
                    "endConnector": c.target[1] + index,
                },
            )
    units = SubElement(root, _q("ssd:Units"))
    for unit in sorted({c.unit for c in system.wires} - {"1"}):
        SubElement(
            SubElement(units, _q("ssc:Unit"), {"name": unit}),
            _q("ssc:BaseUnit"),
            {base: str(power) for base, power in BASE_UNITS[unit].items()},
        )
    SubElement(
        root, _q("ssd:DefaultExperiment"), {"startTime": "0.0", "stopTime": repr(system.stop)}
    )
    annotation = SubElement(
        SubElement(root, _q("ssd:Annotations")), _q("ssc:Annotation"), {"type": VENDOR}
    )
    SubElement(annotation, "case").text = json.dumps(
        {key: value for key, value in tree.items() if key not in LEFT}
    )
    return root


def _indices(shape):
    """Suffixes of an array's scalars; one empty suffix for a scalar."""
    return (
        [f"[{','.join(str(k + 1) for k in index)}]" for index in np.ndindex(*shape)]
        if shape
        else [""]
    )


def _component(parent, participant, names):
    node = SubElement(
        parent,
        _q("ssd:Component"),
        {
            "name": participant.name,
            "type": "application/x-fmu-sharedlibrary",
            "source": f"resources/{participant.name}.fmu",
        },
    )
    connectors = SubElement(node, _q("ssd:Connectors"))
    for name in sorted(names):
        field, arrays = participant.fields[name], _has_arrays(participant)
        for index in [""] if arrays else _indices(field.shape):
            connector = SubElement(
                connectors, _q("ssd:Connector"), {"name": name + index, "kind": field.causality}
            )
            SubElement(
                connector,
                _q(f"ssc:{_type(participant, field)}"),
                {} if field.unit == "1" else {"unit": field.unit},
            )
            for size in field.shape if arrays else ():
                SubElement(connector, _q("ssc:Dimension"), {"size": str(size)})
    bindings = SubElement(node, _q("ssd:ParameterBindings"))
    SubElement(
        bindings, _q("ssd:ParameterBinding"), {"source": f"resources/{participant.name}.ssv"}
    )


def _parameters(participant, values, version):
    root = Element(_q("ssv:ParameterSet"), {"version": version, "name": participant.name})
    parameters = SubElement(root, _q("ssv:Parameters"))
    for name, value in values.items():
        field = participant.fields[name]
        node = SubElement(parameters, _q("ssv:Parameter"), {"name": name})
        unit = {"unit": field.unit} if field.type == "Real" and field.unit != "1" else {}
        shown = _item(field, value) if field.choices else str(value)
        SubElement(node, _q(f"ssv:{_type(participant, field)}"), {"value": shown, **unit})
    return root


def _item(field, number):
    """Name of an enumeration's item."""
    return next(name for name, value in field.choices.items() if value == number)


def read_ssp(path):
    """The case in an SSP as a TOML tree; its FMUs are unpacked into the user's cache.

    Of another tool's SSP, which says nothing of coupling, the tree holds participants, wires, stop
    time and the order of the components; the macro step has to be given.

    Raises
    ------
    BadInput
        If the file is no SSP.
    """
    folder = cache_folder("ssp") / sha256(Path(path).read_bytes()).hexdigest()[:16]
    try:
        with zipfile.ZipFile(path) as archive:
            check_archive(archive, Path(path))
            archive.extractall(folder)
        root = ElementTree.parse(folder / "SystemStructure.ssd").getroot()
    except (zipfile.BadZipFile, OSError, ElementTree.ParseError) as error:
        raise BadInput(f"{path} is no SSP: {error}") from None
    components = list(root.iter(_q("ssd:Component")))
    participants = {
        node.get("name"): {
            "fmu": str(folder / node.get("source", "")),
            "parameters": _read_parameters(node, folder),
        }
        for node in components
    }
    wires = dict.fromkeys(
        (
            f"{c.get('startElement')}.{_base(c.get('startConnector'))}",
            f"{c.get('endElement')}.{_base(c.get('endConnector'))}",
        )
        for c in root.iter(_q("ssd:Connection"))
    )
    experiment = root.find(_q("ssd:DefaultExperiment"))
    own = root.find(f"{_q('ssd:Annotations')}/{_q('ssc:Annotation')}[@type='{VENDOR}']/case")
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


def _base(connector):
    match = ELEMENT.match(connector)
    return match["base"] if match else connector


def _read_parameters(component, folder):
    """Parameter values as a case file writes them, from all SSVs of a component."""
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
