"""FMUs of the C models beside: compiled, and packed with a description."""

import subprocess
import tempfile
import zipfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

from piston_cosim.master.fmi.compiler import compiler

from .runs import needs_compiler

MODELS = Path(__file__).parent / "c_models"
FLAGS = ("-O1", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC")


def compile_model(source, library, *flags):
    """Compile a shared library of a C source; skip the test if there is no compiler.

    `not_offered.c` adds the functions that the source does not offer.
    """
    needs_compiler(native=False)
    sources = [source, MODELS / "not_offered.c"]
    subprocess.run([compiler(), *FLAGS, *flags, *sources, "-o", library, "-lm"], check=True)


def pack(fmu, description, library, name=None):
    """Write an FMU: its description, and its library for Linux under the name of its model."""
    place = "x86_64-linux" if 'fmiVersion="3.0"' in description else "linux64"
    with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as target:
        target.writestr("modelDescription.xml", description)
        target.write(library, f"binaries/{place}/{name or Path(library).name}")
    return fmu


class Variable(NamedTuple):
    """A variable of a model description.

    In FMI 2.0 `attributes` belong to the element of its type; in FMI 3.0 `inside` is its content.
    """

    name: str
    reference: int
    causality: str
    kind: str = "Real"
    attributes: str = ""
    variability: str = ""
    inside: str = ""


VARIABILITY = {"Real": "continuous", "Float64": "continuous", "Float32": "continuous", "Clock": ""}
"""Of types that are not discrete."""


def _element(one, version):
    usual = "fixed" if "arameter" in one.causality else VARIABILITY.get(one.kind, "discrete")
    variability = one.variability or usual
    shared = f'name="{one.name}" valueReference="{one.reference}" causality="{one.causality}" '
    shared += f'variability="{variability}"' if variability else ""
    if version == "2.0":
        inner = f"<{one.kind} {one.attributes}/>"
        return f"<ScalarVariable {shared}>{inner}</ScalarVariable>"
    return f"<{one.kind} {shared} {one.attributes}>{one.inside}</{one.kind}>"


def describe(version, identifier, variables, flags="", states=True, before="", varies=True):
    """Return a modelDescription.xml.

    Parameters
    ----------
    version, identifier : str
        Of FMI, and of the library.
    variables : sequence of Variable
        Outputs are those of their causality. They are known at initialization, but for those with
        clocks.
    flags, before : str
        Further capabilities, and elements before the variables.
    states : bool
        Whether the FMU saves its state.
    varies : bool
        Whether its steps may differ in length.
    """
    outputs = [one for one in enumerate(variables, 1) if one[1].causality == "output"]
    if version == "2.0":
        head = 'guid="1"'
        state = "canGetAndSetFMUstate"
        rows = "".join(f'<Unknown index="{k}"/>' for k, _ in outputs)
        known = f"<InitialUnknowns>{rows}</InitialUnknowns>"
        rows = f"<Outputs>{rows}</Outputs>"
    else:
        head = 'instantiationToken="1"'
        state = "canGetAndSetFMUState"
        known = "".join(
            f'<InitialUnknown valueReference="{one.reference}"/>'
            for _, one in outputs
            if "clocks=" not in one.attributes
        )
        rows = "".join(f'<Output valueReference="{one.reference}"/>' for _, one in outputs)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="{version}" modelName="{identifier}" {head}>
  <CoSimulation modelIdentifier="{identifier}"
    canHandleVariableCommunicationStepSize="{str(varies).lower()}"
    {state}="{str(states).lower()}" {flags}/>
  {before}
  <ModelVariables>{"".join(_element(one, version) for one in variables)}</ModelVariables>
  <ModelStructure>{rows}{known}</ModelStructure>
</fmiModelDescription>
"""


THIRD = {"Real": "Float64", "Integer": "Int32"}
"""FMI 3.0 types of FMI 2.0 types."""


@cache
def _reported(parts):
    """Return the library of c_models/reported.c with its parts, compiled once."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "odd.so"
        flags = [f"-D{name}={text}" for name, text in parts]
        compile_model(MODELS / "reported.c", library, "-Wno-unused", "-pthread", *flags)
        return library.read_bytes()


def make_reported(path, version, variables, *, files=(), states=True, **described):
    """Write an FMU of c_models/reported.c.

    Parameters
    ----------
    path : path-like
    version : str
        Of FMI, "2.0" or "3.0".
    variables : sequence of Variable
        With types of FMI 2.0; reals, integers, Booleans and texts count from 0, 100, 200 and 300.
    files : dict of str to text
        Further files in the FMU.
    states : bool
        See `describe`.
    **described
        Parts of the model in capital letters, and parameters of `describe`.
    """
    parts = {name: text for name, text in described.items() if name.isupper()}
    how = {name: value for name, value in described.items() if name not in parts}
    if version == "3.0":
        variables = [one._replace(kind=THIRD.get(one.kind, one.kind)) for one in variables]
    text = describe(version, "odd", variables, states=states, **how)
    place = "x86_64-linux" if version == "3.0" else "linux64"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text)
        archive.writestr(f"binaries/{place}/odd.so", _reported(tuple(parts.items())))
        for name, content in dict(files).items():
            archive.writestr(name, content)
    return Path(path)
