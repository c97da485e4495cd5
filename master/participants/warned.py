"""Warnings that an FMU logs during a run."""

import re
from collections.abc import Iterable
from typing import NamedTuple

NUMBER = re.compile(r"[-+]?\d+\.?\d*([eE][-+]?\d+)?")
MOST_KINDS = 50
"""Maximum number of kinds of warnings. All others count as one kind."""
MOST_CHARACTERS = 1000
"""Maximum number of characters of a warning that is kept."""


class LoggedWarning(NamedTuple):
    """First warning of a kind.

    text : the first text; time : beginning of its step [s], None at the start; count : number of
    warnings of the kind.
    """

    text: str
    time: float | None
    count: int

    @property
    def sentence(self) -> str:
        """Return the warning with its time and count."""
        at = "at the start" if self.time is None else f"t = {self.time:.6g} s"
        return f"{at}, {self.count} time{'' if self.count == 1 else 's'}: {self.text}"


def kind_of(text: str) -> str:
    """Return a text without its numbers."""
    return NUMBER.sub("#", text)


NamedWarning = tuple[str, LoggedWarning]
"""Participant and its warning."""


def merged(earlier: Iterable[NamedWarning], later: Iterable[NamedWarning]) -> list[NamedWarning]:
    """Return the first warning of each kind of two parts of a run, with the counts of both."""
    kinds: dict[tuple[str, str], NamedWarning] = {}
    for name, warning in (*earlier, *later):
        key = name, kind_of(warning.text)
        first = kinds[key][1] if key in kinds else warning._replace(count=0)
        kinds[key] = name, first._replace(count=first.count + warning.count)
    return list(kinds.values())


class LoggedWarnings:
    """Warnings by kind. Warnings that differ in their numbers only are of one kind."""

    def __init__(self) -> None:
        self._kinds: dict[str, LoggedWarning] = {}

    def add(self, text: str, time: float | None) -> None:
        """Count a warning; keep its text if it is the first of its kind."""
        kind = kind_of(text[:MOST_CHARACTERS])
        if kind not in self._kinds and len(self._kinds) >= MOST_KINDS:
            kind = ""
        first = self._kinds.get(kind, LoggedWarning(text[:MOST_CHARACTERS], time, 0))
        self._kinds[kind] = first._replace(count=first.count + 1)

    def all(self) -> list[LoggedWarning]:
        """Return the first warning of each kind, in the order in which they appeared."""
        return list(self._kinds.values())
