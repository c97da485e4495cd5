"""Open an FMU of either version of the standard as a participant."""

import zipfile
from contextlib import suppress

from .fmi2 import FmuParticipant
from .fmi3 import Fmu3Participant


def open_fmu(name, path):
    """Participant for an FMU of either version of the standard."""
    with suppress(OSError, KeyError, zipfile.BadZipFile), zipfile.ZipFile(path) as archive:
        if b'fmiVersion="3' in archive.open("modelDescription.xml").read(2000):
            return Fmu3Participant(name, path)
    return FmuParticipant(name, path)
