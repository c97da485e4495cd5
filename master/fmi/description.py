"""modelDescription.xml of FMI 2.0 with units, ranges, nominals and structure."""

import hashlib
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from .fields import VENDOR
from .quantities import base_unit, is_known
from .requirements import PACKAGES
from .slave import PRODUCT, SEED, FieldSlave, element_names, reserved
from .variables import END, Variable

AUTHOR = "the piston-cosim developers"
COPYRIGHT = f"Copyright (c) 2026, {AUTHOR}"
LICENCE = "BSD-3-Clause"
DATE = "2026-11-22T00:00:00Z"
"""Fixed date of the version, so that the same content gives the same file."""


def model_description(
    slave: FieldSlave, any_host: bool, platforms: Sequence[str] = (), sums: str = ""
) -> Element:
    """Return the XML tree of an FMU's model description. The GUID is the hash of its content.

    Parameters
    ----------
    slave : FieldSlave
    any_host : bool
        True if the FMU contains the C front. Then it runs in hosts that are not Python and has the
        standard directional derivative. Otherwise pythonfmu's library runs in Python hosts only.
    platforms : sequence of str
        Platforms of an FMU that needs no Python.
    sums : str
        `model_file.sums_of` its resources/slave.bin.
    """
    abilities = {
        "canNotUseMemoryManagementFunctions": "true",
        "canInterpolateInputs": str(any_host).lower(),
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": str(any_host and bool(slave.derivative_inputs)).lower(),
    }
    root = root_of(slave, {"fmiVersion": "2.0", "guid": ""}, platforms, abilities)
    _vendor_annotations(SubElement(root, "VendorAnnotations"), slave, any_host, platforms)
    _variables(SubElement(root, "ModelVariables"), slave)
    _structure(SubElement(root, "ModelStructure"), slave, any_host)
    root.set("guid", content_guid(root, sums))
    return root


NO_DEPENDENCIES = {"dependencies": ""}


def content_guid(root: Element, sums: str = "") -> str:
    """Return the hash of a description, so that the same content has the same identifier.

    It ends with the sums of the model file of a native FMU.
    """
    return "{" + hashlib.sha256(tostring(root)).hexdigest()[:32] + sums + "}"


def root_of(
    slave: FieldSlave,
    identity: dict[str, str],
    platforms: Sequence[str],
    abilities: dict[str, str],
) -> Element:
    """Return the root with the parts that are equal in FMI 2 and 3.

    These are abilities, units, log categories and default experiment. identity, abilities :
    attributes of the root and of CoSimulation that differ.
    """
    attributes = {
        "modelName": slave.name,
        "description": slave.description or "",
        "author": AUTHOR,
        "version": version("piston-cosim"),
        "copyright": COPYRIGHT,
        "license": LICENCE,
        "generationTool": f"piston-cosim {version('piston-cosim')}",
        "generationDateAndTime": DATE,
        "variableNamingConvention": "structured",
    }
    root = Element("fmiModelDescription", identity | attributes)
    common = {
        "modelIdentifier": slave.name,
        "needsExecutionTool": str(not platforms).lower(),
        "canHandleVariableCommunicationStepSize": "true",
    }
    SubElement(root, "CoSimulation", common | abilities)
    _units(SubElement(root, "UnitDefinitions"), slave.table)
    _types(root, slave.table)
    categories = SubElement(root, "LogCategories")
    for name, text in slave.log_categories.items():
        SubElement(categories, "Category", {"name": name, "description": text})
    usual = slave.experiment
    attributes = {"startTime": 0.0, "stopTime": usual.stop, "stepSize": usual.step}
    if usual.tolerance is not None:
        attributes["tolerance"] = usual.tolerance
    texts = {name: repr(float(value)) for name, value in attributes.items()}
    SubElement(root, "DefaultExperiment", texts)
    return root


def _units(parent: Element, table: Sequence[Variable]) -> None:
    for unit in sorted({v.unit for v in table if v.type == "Real" and v.unit != "1"}):
        node = SubElement(parent, "Unit", {"name": unit})
        if is_known(unit):
            SubElement(node, "BaseUnit", base_unit(unit))


def _types(root: Element, table: Sequence[Variable]) -> None:
    """Add a type for every choice."""
    chosen = [v for v in table if v.choices]
    if not chosen:
        return
    parent = SubElement(root, "TypeDefinitions")
    third = root.get("fmiVersion") == "3.0"
    for v in chosen:
        if third:
            node = SubElement(parent, "EnumerationType", {"name": _type_name(v)})
        else:
            simple = SubElement(parent, "SimpleType", {"name": _type_name(v)})
            node = SubElement(simple, "Enumeration")
        for number, name in enumerate(v.choices, 1):
            SubElement(node, "Item", {"name": name, "value": str(number)})


def _type_name(v: Variable) -> str:
    return f"{v.name}_choice"


def needs(slave: FieldSlave, any_host: bool, platforms: Sequence[str]) -> dict[str, str]:
    """Return the attributes that describe what an FMU needs of its host."""
    inputs = {} if slave.interpolates_inputs else {"inputs": f"at the {END}"}
    if platforms:
        return inputs | {"hosts": f"any on {', '.join(platforms)}"}
    return inputs | {
        "hosts": "any on Linux x86-64" if any_host else "Python only",
        "python": ">=3.11",
        "packages": " ".join(PACKAGES),
    }


def _vendor_annotations(
    parent: Element, slave: FieldSlave, any_host: bool, platforms: Sequence[str]
) -> None:
    """Add the requirements on the host.

    If there is no front, also add the first reserved reference of each seed and product.
    """
    tool = SubElement(parent, "Tool", {"name": VENDOR})
    node = SubElement(tool, "Needs", needs(slave, any_host, platforms))
    if any_host or not slave.derivative_inputs:
        return
    node = SubElement(node, "DirectionalDerivative")
    for kind, names in ((SEED, slave.derivative_inputs), (PRODUCT, slave.derivative_outputs)):
        for name in names:
            SubElement(
                node,
                kind.capitalize(),
                {"name": name, "valueReference": str(slave.references[reserved(kind, name)])},
            )


def _variables(parent: Element, slave: FieldSlave) -> None:
    first = dict(
        zip((v.name for v in slave.table), np.cumsum([1, *(v.size for v in slave.table)]).tolist())
    )
    for v in slave.table:
        common = causality_attributes(v)
        typed = type_attributes(v)
        for k, name in enumerate(element_names(v)):
            node = SubElement(
                parent,
                "ScalarVariable",
                {"name": name, "valueReference": str(slave.first_references[v.name] + k), **common},
            )
            SubElement(
                node,
                v.type,
                typed
                | ({"derivative": str(first[v.derivative_of] + k)} if v.derivative_of else {}),
            )


def causality_attributes(v: Variable) -> dict[str, str]:
    """Return description, causality, variability and initial."""
    kind = {
        "parameter": {
            "causality": "parameter",
            "variability": "tunable" if v.tunable else "fixed",
            "initial": "exact",
        },
        "input": {
            "causality": "input",
            "variability": "continuous" if v.type == "Real" else "discrete",
        },
        "constant": {"causality": "local", "variability": "constant", "initial": "exact"},
        "output": {
            "causality": "output",
            "variability": "continuous" if v.type == "Real" else "discrete",
            "initial": "calculated",
        },
    }[v.causality]
    return {"description": v.description, **kind}


def type_attributes(v: Variable) -> dict[str, str]:
    """Return start, unit, nominal and range."""
    attributes: dict[str, str] = {}
    if v.causality != "output":
        attributes["start"] = repr(float(v.start)) if v.type == "Real" else str(v.number(v.start))
    if v.choices:
        attributes["declaredType"] = _type_name(v)
    if v.type == "Real" and v.unit != "1":
        attributes["unit"] = v.unit
    if v.type == "Real" and v.nominal is not None:
        attributes["nominal"] = repr(float(v.nominal))
    for key, limit in (("min", v.minimum), ("max", v.maximum)):
        if v.causality != "constant" and limit is not None and np.isfinite(limit):
            attributes[key] = repr(float(limit)) if v.type == "Real" else str(limit)
    return attributes


def dependencies(slave: FieldSlave, places: Mapping[str, int]) -> dict[str, dict[str, str]]:
    """Return the attribute dependencies of each output by name: inputs of the derivatives.

    `places` contains the index or value reference of each variable by name.
    """
    inputs = {"dependencies": " ".join(str(places[name]) for name in slave.derivative_inputs)}
    outputs = [v.name for v in slave.table if v.causality == "output"]
    return {n: inputs if n in slave.derivative_outputs else NO_DEPENDENCIES for n in outputs}


def _structure(parent: Element, slave: FieldSlave, any_host: bool) -> None:
    """Add outputs and initial unknowns.

    Outputs depend on the inputs of the derivatives that the FMU offers. If these contain fields,
    the attribute is left out, which means all inputs. A list for each cell would take 60 MB.
    Initial unknowns depend on everything that is set, so they have no such attribute.
    """
    firsts = np.cumsum([1, *(v.size for v in slave.table)]).tolist()
    shapes = {v.name: v.shape for v in slave.table}
    first = dict(zip(shapes, firsts))
    each = dependencies(slave, first)
    if not any_host:
        each = dict.fromkeys(each, NO_DEPENDENCIES)
    elif any(shapes[name] for name in slave.derivative_inputs):
        each = {name: {} if one["dependencies"] else one for name, one in each.items()}
    for section in ("Outputs", "InitialUnknowns"):
        node = SubElement(parent, section)
        for v in slave.table:
            if v.name not in each:
                continue
            depends = each[v.name] if section == "Outputs" else {}
            for k in range(first[v.name], first[v.name] + v.size):
                SubElement(node, "Unknown", {"index": str(k)} | depends)
