"""modelDescription.xml of FMI 3.0: whole arrays, value references by table row, terminals."""

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from .description import (
    VENDOR,
    causality_attributes,
    content_guid,
    dependencies,
    needs,
    root_of,
    type_attributes,
)
from .slave import FieldSlave
from .variables import Variable

TYPES = {"Real": "Float64", "Integer": "Int32", "String": "String", "Enumeration": "Enumeration"}


def model_description_3(
    slave: FieldSlave, platforms: Sequence[str] = (), sums: str = ""
) -> Element:
    """Return the XML tree of an FMU's model description for FMI 3.0.

    The instantiation token is the hash of its content. `platforms` and `sums` are those of an FMU
    that needs no Python.
    """
    abilities = {
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": str(bool(slave.derivative_inputs)).lower(),
    }
    identity = {"fmiVersion": "3.0", "instantiationToken": ""}
    root = root_of(slave, identity, platforms, abilities)
    _variables(SubElement(root, "ModelVariables"), slave.table)
    structure = SubElement(root, "ModelStructure")
    reference = {v.name: k for k, v in enumerate(slave.table)}
    outputs = dependencies(slave, reference)
    for name, depends in outputs.items():
        SubElement(structure, "Output", {"valueReference": str(reference[name])} | depends)
    for name in outputs:  # they depend on everything that is set
        SubElement(structure, "InitialUnknown", {"valueReference": str(reference[name])})
    annotation = SubElement(SubElement(root, "Annotations"), "Annotation", {"type": VENDOR})
    SubElement(annotation, "Needs", needs(slave, True, platforms))
    root.set("instantiationToken", content_guid(root, sums))
    return root


def _variables(parent: Element, table: Sequence[Variable]) -> None:
    reference = {v.name: str(k) for k, v in enumerate(table)}
    for k, v in enumerate(table):
        attributes = causality_attributes(v) | type_attributes(v)
        attributes |= {"derivative": reference[v.derivative_of]} if v.derivative_of else {}
        start = attributes.pop("start", None) if v.type == "String" else None
        node = SubElement(
            parent, TYPES[v.type], {"name": v.name, "valueReference": str(k), **attributes}
        )
        for size in v.shape:
            SubElement(node, "Dimension", {"start": str(size)})
        if start is not None:
            SubElement(node, "Start", {"value": start})
    SubElement(
        parent,
        "Float64",
        {
            "name": "time",
            "valueReference": str(len(table)),
            "causality": "independent",
            "variability": "continuous",
            "description": "Simulation time",
        },
    )


def terminals(slave: FieldSlave) -> Element:
    """Return terminalsAndIcons.xml: the fields of the interface as one terminal, and the icon."""
    root = Element("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})
    picture = SubElement(root, "GraphicalRepresentation")
    block = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    SubElement(picture, "CoordinateSystem", {**block, "suggestedScalingFactorTo_mm": "0.1"})
    SubElement(picture, "Icon", block)
    terminal = SubElement(
        SubElement(root, "Terminals"),
        "Terminal",
        {
            "name": "interface",
            "matchingRule": "bus",
            "description": "Fields that cross the interface",
        },
    )
    for name in (*slave.derivative_inputs, *slave.derivative_outputs):
        SubElement(
            terminal,
            "TerminalMemberVariable",
            {"variableName": name, "memberName": name, "variableKind": "signal"},
        )
    return root
