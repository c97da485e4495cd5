"""Model descriptions and fields of FMUs, cached by content of the FMU.

FMPy creates an object for each element of each array. For a film of 40 x 40 cells that takes a
third of a second.
"""

import pickle
import zipfile
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import fmpy

from ..fmi import fields
from ..fmi.archive import check_archive
from ..fmi.cache import cache_folder, write_whole
from ..fmi.errors import BadInput, file_fault


def read_description(
    name: str, path: Path, version: str, sizes: Mapping[str, int], elements: Iterable[str]
) -> tuple[Any, dict[str, fields.Field]]:
    """Return FMPy's model description of participant `name`, and its fields.

    A cached description contains no variables. Only descriptions of FMI 2.0 without `elements` are
    cached. Raises `BadInput` if the file is no co-simulation FMU of this version of FMI.
    """
    cached = None
    if version == "2" and not elements:
        with suppress(Exception):  # whatever a damaged pickle raises
            cached = _cached_path(path)
            return pickle.loads(cached.read_bytes())
    one = f"participants.{name}: {path}"
    try:
        with zipfile.ZipFile(path) as archive:
            check_archive(archive, path)
        description: Any = fmpy.read_model_description(str(path), validate=False)
    except BadInput:
        raise
    except OSError as error:
        raise BadInput(f"participants.{name}: {file_fault(path, error)}") from None
    except zipfile.BadZipFile:
        raise BadInput(f"{one}: expected an FMU, got another file") from None
    except Exception:  # FMPy raises errors of many kinds
        raise BadInput(
            f"{one}: expected an FMU, got an invalid modelDescription.xml; "
            "`fmpy validate` lists its faults"
        ) from None
    if description.coSimulation is None or not description.fmiVersion.startswith(version):
        raise BadInput(f"{one}: expected an FMU for co-simulation of FMI {version}.0, got another")
    try:
        gathered = fields.gather_fields(description, sizes, elements)
    except ValueError as error:
        raise BadInput(f"{one}: {error}") from None
    if cached:
        for part in ("modelVariables", "outputs", "derivatives", "initialUnknowns"):
            getattr(description, part).clear()
        with suppress(OSError):
            write_whole(cached, pickle.dumps((description, gathered)))
    return description, gathered


def _cached_path(path):
    """Return the path of the cached description."""
    digest = sha256(Path(path).read_bytes() + _readers()).hexdigest()[:24]
    return cache_folder("descriptions") / f"{Path(path).stem}-{digest}.pickle"


@cache
def _readers():
    """Return the versions of the code that reads descriptions, on which the cache depends."""
    files = (__file__, str(fields.__file__))
    return b"".join([fmpy.__version__.encode(), *(Path(file).read_bytes() for file in files)])
