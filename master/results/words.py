"""Names of variables and summary entries in words, and units that suit their values."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..fmi.quantities import from_si, registry, unit_text

WITH_PREFIX = ("m", "Pa", "N", "W", "J", "s", "m/s")
"""SI units that are shown with a prefix by default."""
MICRO = ("um", "urad", "us", "uN", "uW", "uJ", "um/s")
"""Units without a micro sign, as in a case file."""


def scaled(values, unit: str, wanted: str | None):
    """Return values in the wanted unit, from SI `unit`, and the label of the unit."""
    shown = unit_shown(unit, wanted)
    if not wanted:
        return values, shown
    zero = from_si(0.0, unit, wanted)  # not 0 for degC
    return np.asarray(values) * (from_si(1.0, unit, wanted) - zero) + zero, shown


def unit_shown(unit: str, wanted: str | None) -> str:
    """Return the label of the wanted unit; default: the SI `unit`, "" for pure numbers."""
    shown = (wanted or ("" if unit == "1" else unit)).replace(".", " ")
    return f"\N{MICRO SIGN}{shown[1:]}" if shown in MICRO else shown


def labelled(text: str, unit: str) -> str:
    """Return a text with its unit, if there is one."""
    return f"{text} [{unit}]" if unit else text


ENDINGS = {
    "_m3_s": "m³/s",
    "_m_s": "m/s",
    "_nm": "N m",
    "_pa": "Pa",
    "_w": "W",
    "_j": "J",
    "_rad": "rad",
    "_n": "N",
    "_m": "m",
    "_s": "s",
}
"""Suffixes of summary entries that have a unit, and the unit."""


def entry_in_words(name: str) -> str:
    """Return a summary entry in words: mean_friction_power_w -> "mean friction power [W]"."""
    return labelled(*words_and_unit(name))


def words_and_unit(name: str) -> tuple[str, str]:
    """Return a summary entry in words, and its SI unit, "" for a pure number."""
    ending = next((one for one in ENDINGS if name.endswith(one)), "")
    return name.removesuffix(ending).replace("_", " "), ENDINGS.get(ending, "")


class ShownEntry(NamedTuple):
    """Summary entry in words, with values in `unit`, "" for pure numbers."""

    words: str
    unit: str
    values: np.ndarray

    @property
    def label(self) -> str:
        """The words with the unit."""
        return labelled(self.words, self.unit)


def entry_shown(name: str, values: Sequence[float]) -> ShownEntry:
    """Return a summary entry in words with a unit that suits its values."""
    array = np.asarray(values, float)
    words, unit = words_and_unit(name)
    largest = max(np.abs(array[np.isfinite(array)]), default=0.0)
    shown, label = scaled(array, unit, "deg" if unit == "rad" else handy_unit(unit, largest))
    return ShownEntry(words, label, shown)


def handy_unit(unit: str, largest: float) -> str | None:
    """Return the prefixed unit that suits a value in the SI `unit`, None if that is as good."""
    if unit not in WITH_PREFIX or not np.isfinite(largest) or largest == 0.0:
        return None
    return unit_text(registry().Quantity(float(abs(largest)), unit).to_compact().units)


def name_of(port: str) -> str:
    """Return the variable of "participant.variable" in words, with its film surface; or "time"."""
    *where, name = port.partition(".")[2].split(".")
    surface = f" ({', '.join(where)})" if where else ""
    return (name + surface).replace("_", " ") or port


def names_of(ports: Sequence[str]) -> dict[str, str]:
    """Return the names of several variables; equal ones with their participants."""
    words = [name_of(port) for port in ports]
    owner = {port: port.partition(".")[0].replace("_", " ") for port in ports}
    return {
        port: f"{name}, {owner[port]}" if words.count(name) > 1 else name
        for port, name in zip(ports, words)
    }


def common_words(ports):
    """Return the words that the variables' names share, or else all names."""
    words = [port.partition(".")[2].split("_") for port in ports]
    shared = [column[0] for column in zip(*words) if len(set(column)) == 1]
    return " ".join(shared) or ", ".join(name_of(port) for port in ports)
