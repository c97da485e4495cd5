"""Content of an FMU's model description, cached by content of the FMU.

FMPy creates an object for each element of each array. For a film of 40 x 40 cells that takes a
third of a second.
"""

import pickle
import re
import zipfile
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
from fmpy.model_description import ValidationError

from ..fmi import fields
from ..fmi.archive import check_archive
from ..fmi.cache import cache_folder, write_whole
from ..fmi.errors import BadInput, file_fault

NEEDS = f"VendorAnnotations/Tool[@name='{fields.VENDOR}']/Needs"
"""Annotation of an FMU of this tool."""


class DescribedFmu:
    """FMU for co-simulation, known by its model description.

    Parameters
    ----------
    name, path, sizes, elements
        See `fmi2.FmuParticipant`.

    Raises
    ------
    BadInput
        If the file is not an FMU for co-simulation.
    """

    version, derivative_flag = "2", "providesDirectionalDerivative"
    _is_cached = True  # whether the description is cached

    def __init__(self, name, path, sizes=None, elements=()):
        self.name, self.path, self.sizes = name, Path(path), sizes or {}
        self.elements = frozenset(elements)
        self._is_cached = self._is_cached and not self.elements
        if self._is_cached and (cached := cached_description(self.path)):
            self.description, self.fields = cached
        else:
            self._read_description()
        root = self._before_the_variables()
        self._reserved = _reserved_references(root)
        needs = root.find(NEEDS)
        self.reads_ends = needs is not None and "inputs" in needs.attrib
        offered = root.find("CoSimulation")
        flag = None if offered is None else offered.get(self.derivative_flag)
        self._standard_derivative = flag in ("true", "1")

    def __repr__(self):
        return f"<FMU {self.path.name}, FMI {self.description.fmiVersion}>"

    def _read_description(self):
        """Read description and fields; raise `BadInput` if the file is no co-simulation FMU."""
        key = f"fmu: {self.path}"
        try:
            with zipfile.ZipFile(self.path) as archive:
                check_archive(archive, self.path, "fmu: ")
                names = archive.namelist()
                if "modelDescription.xml" not in names:
                    inside = [one for one in names if one.endswith("/modelDescription.xml")]
                    hint = f"; zip the content of the folder of {inside[0]}" if inside else ""
                    raise BadInput(
                        f"{key}: expected an FMU, got no modelDescription.xml in it{hint}"
                    )
                _check_encoding(archive.read("modelDescription.xml"), key)
            self._check_kind(key)
            self.description: Any = fmpy.read_model_description(str(self.path), validate=False)
            _complete(self.description, self._model_description)
        except BadInput:
            raise
        except OSError as error:
            raise BadInput(f"fmu: {file_fault(self.path, error)}") from None
        except zipfile.BadZipFile:
            raise BadInput(f"{key}: expected an FMU, got another file") from None
        except Exception as error:  # FMPy raises errors of many kinds
            got = f"{key}: expected a valid modelDescription.xml, got"
            raise BadInput([f"{got} {text}" for text in _problems(self.path, error)]) from None
        try:
            self.fields = fields.gather_fields(self.description, self.sizes, self.elements)
        except ValueError as error:
            raise BadInput(f"{key}: {error}") from None
        if self._is_cached:
            cache_description(self.path, self.description, self.fields)

    def _check_kind(self, key):
        """Raise `BadInput` if the FMU has another version of FMI, or no co-simulation."""
        root = self._before_the_variables()
        version = root.get("fmiVersion", "")
        if not version.startswith(self.version):
            got = f"FMI {version}" if version else "no fmiVersion"
            raise BadInput(f"{key}: expected FMI 2.0 or 3.0, got {got}; export it with FMI 2.0")
        if root.find("CoSimulation") is None:
            kinds = {"ModelExchange": "Model Exchange", "ScheduledExecution": "Scheduled Execution"}
            got = " and ".join(name for tag, name in kinds.items() if root.find(tag) is not None)
            raise BadInput(
                f"{key}: expected an FMU for co-simulation, got {got or 'no interface'}; export it "
                "for co-simulation"
            )

    def check_library(self):
        """Raise `BadInput` if the FMU has no library for this platform, with those that it has."""
        platform = fmpy.platform if self.version == "2" else fmpy.platform_tuple
        identifier = self.description.coSimulation.modelIdentifier
        expected = f"binaries/{platform}/{identifier}{fmpy.sharedLibraryExtension}"
        with zipfile.ZipFile(self.path) as archive:
            names = archive.namelist()
        if expected in names:
            return
        files = [name.split("/") for name in names]
        platforms = sorted({file[1] for file in files if file[0] == "binaries" and file[2:]})
        if platform in platforms:
            got = ", ".join(
                n for n in names if n.startswith(f"binaries/{platform}/") and n[-1] != "/"
            )
        else:
            got = f"libraries for {', '.join(platforms)} only" if platforms else "no library"
        has_sources = any(file[0] == "sources" and file[1:] != [""] for file in files)
        hint = f"export it for {platform}"
        if has_sources:
            hint = f"it has source code: compile it with `fmpy compile {self.path.name}`"
        raise BadInput(f"fmu: {self.path}: expected {expected}, got {got}; {hint}")

    @property
    def only_once(self):
        """Identity of an FMU that a process can instantiate only once; None for others."""
        offered = self.description.coSimulation
        identity = offered.modelIdentifier, self.description.guid
        return identity if offered.canBeInstantiatedOnlyOncePerProcess else None

    @property
    def has_derivatives(self):
        """True if the FMU has the standard derivative, or reserved references for one."""
        return self._standard_derivative or bool(self._reserved)

    @property
    def can_redo(self):
        """True if the FMU can save and restore its state."""
        return bool(self.description.coSimulation.canGetAndSetFMUstate)

    @property
    def can_vary_steps(self):
        """True if the steps may differ in length."""
        return bool(self.description.coSimulation.canHandleVariableCommunicationStepSize)

    @property
    def can_serialise(self):
        """True if the FMU can serialise its saved states."""
        return bool(self.description.coSimulation.canSerializeFMUstate)

    @property
    def can_interpolate(self) -> bool:
        """True if a step follows inputs along their derivatives.

        An FMU of this tool that extrapolates them to the end of the step is none of these.
        """
        return bool(self.description.coSimulation.canInterpolateInputs) and not self.reads_ends

    @property
    def declares_units(self):
        """True if the FMU declares any unit; otherwise its variables are in SI."""
        return any(field.unit != "1" for field in self.fields.values())

    def _model_description(self):
        """Return the root of the XML, for content that FMPy does not read."""
        with zipfile.ZipFile(self.path) as archive:
            return ElementTree.fromstring(archive.read("modelDescription.xml"))

    def _before_the_variables(self):
        """Return the root of the XML, read up to the variables, which are most of it."""
        with (
            zipfile.ZipFile(self.path) as archive,
            archive.open("modelDescription.xml") as file,
        ):
            events = ElementTree.iterparse(file, ("start",))
            _, root = next(events)
            for _, node in events:
                if node.tag == "ModelVariables":
                    break
        return root


ENCODING = re.compile(rb"""^[^>]*encoding\s*=\s*["'](?!utf-8)|^\xff\xfe|^\xfe\xff""", re.IGNORECASE)
"""Declaration of another encoding than UTF-8, or the first bytes of UTF-16."""


def _check_encoding(text, key):
    """Raise `BadInput` if XML without another encoding has bytes that are not UTF-8."""
    try:
        text.decode()
    except UnicodeDecodeError as wrong:
        if not ENCODING.match(text):
            line = len(text[: wrong.start].splitlines())
            raise BadInput(
                f"{key}: expected modelDescription.xml in UTF-8, got other bytes in line {line}"
            ) from None


MOST_PROBLEMS = 5
"""Maximum number of faults of a description in a message."""


def _problems(path, error):
    """Return the faults of a description that FMPy rejects with an error, with their lines."""
    own = [str(error)] if type(error) is Exception else []  # FMPy's own names the variable
    try:
        fmpy.read_model_description(str(path))
    except ValidationError as invalid:
        more = ["further faults"] * (len(invalid.problems) > MOST_PROBLEMS)
        return [*own, *invalid.problems[:MOST_PROBLEMS], *more]
    except Exception as other:  # that of lxml has the line
        error = other
    return own or [
        str(error) if isinstance(error, SyntaxError) else f"{type(error).__name__}: {error}"
    ]


OF_TYPES = ("unit", "min", "max", "nominal", "relativeQuantity")
"""Attributes that a variable takes from its declared type, unless it has its own."""


def _complete(description, root):
    """Add to FMPy's variables the attributes of their declared types, and those that it drops.

    FMPy never reads relativeQuantity of a variable, nor the range of unsigned integers.

    root : callable that returns the root of the XML.
    """
    own = _dropped(root()) if description.modelVariables else {}
    for variable in description.modelVariables:
        for key, value in own.get((variable.alias or variable).name, {}).items():
            setattr(variable, key, value in ("true", "1") if key == "relativeQuantity" else value)
        for key in OF_TYPES if variable.declaredType else ():
            if getattr(variable, key) is None:
                setattr(variable, key, getattr(variable.declaredType, key))


def _dropped(root):
    """Return the attributes of `OF_TYPES` that FMPy drops, by the name of the variable."""
    variables = root.find("ModelVariables")
    return {
        name: {key: node.get(key) for key in OF_TYPES if node.get(key) is not None}
        for parent in (() if variables is None else variables)
        if (name := parent.get("name")) is not None
        for node in (parent, *parent)
        if node.get("relativeQuantity") is not None or node.tag.startswith("UInt")
    }


def _reserved_references(root):
    """Return the first reserved references by field of seeds and of products, if there are any."""
    first = {
        kind: {
            node.get("name"): int(node.get("valueReference"))
            for node in root.findall(f"{NEEDS}/DirectionalDerivative/{kind.capitalize()}")
        }
        for kind in ("seed", "product")
    }
    return {kind: references for kind, references in first.items() if references}


def cached_description(path: Path) -> tuple[Any, dict[str, fields.Field]] | None:
    """Return the cached description without its variables, and their fields; else None."""
    with suppress(Exception):  # whatever a damaged pickle raises
        return pickle.loads(_cached_path(path).read_bytes())
    return None


def cache_description(path: Path, description: Any, gathered: dict[str, fields.Field]) -> None:
    """Remove the variables from a description, and cache it with the fields if possible."""
    for name in ("modelVariables", "outputs", "derivatives", "initialUnknowns"):
        getattr(description, name).clear()
    with suppress(OSError):
        write_whole(_cached_path(path), pickle.dumps((description, gathered)))


def _cached_path(path):
    """Return the path of the cached description."""
    digest = sha256(Path(path).read_bytes() + _readers()).hexdigest()[:24]
    return cache_folder("descriptions") / f"{Path(path).stem}-{digest}.pickle"


@cache
def _readers():
    """Return the versions of the code that reads descriptions, on which the cache depends."""
    files = (__file__, str(fields.__file__))
    return b"".join([fmpy.__version__.encode(), *(Path(file).read_bytes() for file in files)])
