"""Content of an FMU's model description, cached by content of the FMU.

FMPy creates an object for each element of each array. For a film of 40 x 40 cells that takes a
third of a second.
"""

import pickle
import zipfile
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy

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
        if self._is_cached and (kept := cached_description(self.path)):
            self.description, self.fields = kept
        else:
            self._read_description()
        root = self._before_the_variables()
        self._reserved = _reserved_references(root)
        needs = root.find(NEEDS)
        self._reads_ends = needs is not None and "inputs" in needs.attrib
        offered = root.find("CoSimulation")
        flag = None if offered is None else offered.get(self.derivative_flag)
        self._standard_derivative = flag in ("true", "1")

    def __repr__(self):
        return f"<FMU {self.path.name}, FMI {self.description.fmiVersion}>"

    def _read_description(self):
        """Read description and fields; raise `BadInput` if the file is no co-simulation FMU."""
        one = f"participants.{self.name}: {self.path}"
        try:
            with zipfile.ZipFile(self.path) as archive:
                check_archive(archive, self.path)
            self.description: Any = fmpy.read_model_description(str(self.path), validate=False)
        except BadInput:
            raise
        except OSError as error:
            raise BadInput(f"participants.{self.name}: {file_fault(self.path, error)}") from None
        except zipfile.BadZipFile:
            raise BadInput(f"{one}: expected an FMU, got another file") from None
        except Exception:  # FMPy raises errors of many kinds
            raise BadInput(
                f"{one}: expected an FMU, got an invalid modelDescription.xml; "
                "`fmpy validate` lists its faults"
            ) from None
        if self.description.coSimulation is None or not self.description.fmiVersion.startswith(
            self.version
        ):
            raise BadInput(
                f"{one}: expected an FMU for co-simulation of FMI {self.version}.0, got another"
            )
        try:
            self.fields = fields.gather_fields(self.description, self.sizes, self.elements)
        except ValueError as error:
            raise BadInput(f"{one}: {error}") from None
        if self._is_cached:
            cache_description(self.path, self.description, self.fields)

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
        return bool(self.description.coSimulation.canInterpolateInputs) and not self._reads_ends

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
