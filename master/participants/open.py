"""Open an FMU of either version of the standard as a participant."""

import re
import zipfile
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from .substeps import Substeps

THIRD = re.compile(rb"""fmiVersion\s*=\s*["']3""")
EVENTS = re.compile(rb"""hasEventMode\s*=\s*["'](true|1)["']""")


def open_fmu(
    name: str,
    path: Path,
    sizes: Mapping[str, int] | None = None,
    step: float | None = None,
    elements: Iterable[str] = (),
    event_mode: bool = True,
) -> Any:
    """Return the participant of an FMU of either version of the standard.

    Parameters
    ----------
    name : str
        Name in the system.
    path : Path
    sizes : dict of str to int, optional
        Values of structural parameters.
    step : float, optional
        Longest step inside a macro step [s].
    elements : iterable of str, optional
        Elements of arrays ("y[2]") that are fields too, next to their array.
    event_mode : bool
        Whether to use the Event Mode and the clocks of an FMU that declares them.
    """
    participant = _kind(path, event_mode)(name, path, sizes, elements)
    participant.event_mode = event_mode
    if step is None and participant.can_vary_steps:
        return participant
    return Substeps(participant, step, fixed=not participant.can_vary_steps)


def _kind(path, event_mode):
    from .clocks import ClockedFmu3  # FMPy is slow to import, and checking a case does not need it
    from .fmi2 import FmuParticipant
    from .fmi3 import Fmu3Participant

    with suppress(OSError, KeyError, zipfile.BadZipFile), zipfile.ZipFile(path) as archive:
        text = archive.read("modelDescription.xml")
        if THIRD.search(text[: text.find(b"<ModelVariables")]):
            has_clocks = event_mode and b"<Clock" in text and EVENTS.search(text)
            return ClockedFmu3 if has_clocks else Fmu3Participant
    return FmuParticipant
