"""Common parts of all tables of a case file: names of ports and files, no unknown keys."""

import re
from typing import Annotated, Any, NamedTuple

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
)

from ..fmi.option_classes import with_meanings

Port = Annotated[str, Field(pattern=r"^\w+\.[\s\S]*$")]
"""Variable of a participant: "participant.variable", with the variable's name in the FMU."""


def _file_name(text: str) -> str:
    if text in ("", ".", "..") or re.search(r"[/\\\x00-\x1f]", text):
        raise ValueError(f"expected a file name without / and \\, got {text!r}")
    return text


FileName = Annotated[str, AfterValidator(_file_name)]
"""Name of a file in the output folder, without directories."""


REDUCTIONS = ("min", "max", "mean", "last")
TAKEN = ("coupling", "envelopes", "fields", "time")
"""Groups of a results file that are not participants."""


class Reduced(NamedTuple):
    """Content of "min|max|mean|last participant.variable"."""

    kind: str
    port: str


def reduced(text: str) -> Reduced:
    """Return kind and port of a summary entry."""
    kind, _, port = text.strip().partition(" ")
    return Reduced(kind, port.strip())


NOT_RESULTS = (
    *("title", "label", "monitor", "pictures", "axes", "window"),
    *("studies", "variants", "beside"),
)
"""Tables of a case that do not affect the results of a run."""


def with_effect(tree: dict[str, Any]) -> dict[str, Any]:
    """Return the tables of a case's TOML tree that affect the results of a run."""
    return {key: value for key, value in tree.items() if key not in NOT_RESULTS}


def titles(tree: dict[str, Any]) -> set[str | None]:
    """Return the titles of a case and its variants."""
    return {one.get("title") for one in (tree, *tree.get("variants", {}).values())}


class Table(BaseModel):
    """Table of a case file; unknown keys are errors.

    The text below a key is its meaning in `piston-cosim keys`.
    """

    model_config = ConfigDict(
        extra="forbid", populate_by_name=True, allow_inf_nan=False, json_schema_extra=with_meanings
    )
