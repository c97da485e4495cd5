"""Option classes, looked at from outside: every key with its unit, default, range and meaning, and
the known key nearest to one that is none.

What is read is the JSON schema that pydantic makes of a class, so that a class of another part is
looked at without being known. A bound of a quantity with a unit stands there as `ge`, `gt`, `le`,
`lt`, in SI; a description is the text below the key in its class, read when a schema is asked for.
"""

import ast
import inspect
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import pairwise
from textwrap import dedent
from typing import Any

from pydantic import BaseModel

Schema = Mapping[str, Any]
LOW = {"minimum": "", "ge": "", "exclusiveMinimum": "above ", "gt": "above "}
HIGH = {"maximum": "", "le": "", "exclusiveMaximum": "below ", "lt": "below "}
ANY = "NAME"
"""Stands in a dotted key for a name that the user gives, ..."""
EACH = "N"
"""... and for an entry of a list, counted from 0."""


@dataclass(frozen=True)
class Key:
    """One key.

    path : dotted; default : as it would be written, empty where there is none or the key is
    required; allowed : choices or range; meaning : one sentence.
    """

    path: str
    unit: str
    default: str
    allowed: str
    meaning: str
    required: bool = False

    @property
    def name(self) -> str:
        """Its last part."""
        return self.path.rpartition(".")[-1]


def with_meanings(schema: dict[str, Any], kind: type[BaseModel]) -> None:
    """Give each key in the schema of a class the text below it, in place: a class's
    `json_schema_extra`. pydantic's `use_attribute_docstrings` reads the source of every class when
    it is made, a tenth of a start, for what `keys` alone asks for.
    """
    for one in reversed(kind.__mro__[: kind.__mro__.index(BaseModel)]):
        for name, meaning in _texts_below(one):
            if field := kind.model_fields.get(name):
                schema["properties"][field.alias or name]["description"] = meaning


def _texts_below(kind: type) -> Iterator[tuple[str, str]]:
    """Each annotated name of a class that has a text below it, and the text."""
    (found,) = ast.parse(dedent(inspect.getsource(kind))).body
    assert isinstance(found, ast.ClassDef)
    for one, below in pairwise(found.body):
        if isinstance(one, ast.AnnAssign) and isinstance(below, ast.Expr):
            assert isinstance(one.target, ast.Name) and isinstance(below.value, ast.Constant)
            yield one.target.id, inspect.cleandoc(str(below.value.value))


def near(name: str, known: Iterable[str]) -> str:
    """ " (did you mean ...?)", or nothing where no known name is like it."""
    close = get_close_matches(name, list(known), 2, 0.6)
    return f" (did you mean {' or '.join(close)}?)" if close else ""


def near_key(schema: Schema, place: Sequence[str | int]) -> str:
    """The same for the last part of a place that pydantic names, which is no key there."""
    *parents, last = place
    known = [name for here in _tables(schema, schema, parents) for name in here["properties"]]
    return near(str(last), known)


def _tables(schema: Schema, node: Schema, place: Sequence[str | int]) -> list[Schema]:
    """Tables at a place; of a choice between several all of them. Parts that name the chosen one
    are passed over.
    """
    found = []
    for option in options(schema, node):
        if not place:
            found += [option] if "properties" in option else []
            continue
        first, *rest = place
        child = _child(option, first)
        found += _tables(schema, option if child is None else child, rest)
    return found


def _child(node: Schema, part: str | int) -> Schema | None:
    """What a table or list has at one of its keys; None without it."""
    if isinstance(part, int):
        return node.get("items")
    own = node.get("properties", {}).get(part)
    other = node.get("additionalProperties")
    return own or (other if isinstance(other, Mapping) else None)


def options(schema: Schema, node: Schema) -> list[Schema]:
    """What a value may be: references followed, a choice taken apart, `null` left out."""
    if "$ref" in node:
        target = schema["$defs"][node["$ref"].rpartition("/")[-1]]
        return options(schema, target)
    if "anyOf" in node:
        return [one for option in node["anyOf"] for one in options(schema, option)]
    return [] if node.get("type") == "null" else [node]


def keys(schema: Schema, before: str = "") -> list[Key]:
    """Every key of a class, nested ones after the table that holds them, each once."""
    return list({key.path: key for key in _keys(schema, schema, before)}.values())


def _keys(schema: Schema, table: Schema, before: str) -> Iterator[Key]:
    for name, node in table.get("properties", {}).items():
        path = f"{before}{name}"
        choices = options(schema, node)
        yield Key(
            path=path,
            unit=next((unit for one in choices if (unit := _unit(one))), ""),
            default=_default(node),
            allowed=" or ".join(dict.fromkeys(filter(None, map(_allowed, choices)))),
            meaning=" ".join(node.get("description", "").split()).removesuffix("."),
            required=name in table.get("required", ()),
        )
        for one in choices:
            yield from _inside(schema, one, path)


def _inside(schema: Schema, node: Schema, path: str) -> Iterator[Key]:
    """Keys of the tables inside a value."""
    if "properties" in node:
        yield from _keys(schema, node, f"{path}.")
    for inner, part in ((node.get("additionalProperties"), ANY), (node.get("items"), EACH)):
        if isinstance(inner, Mapping):
            for one in options(schema, inner):
                yield from _inside(schema, one, f"{path}.{part}")


def _unit(node: Schema) -> str:
    """Unit of a quantity, or of those in a list of a fixed length; "" without one."""
    first = next(iter(node.get("prefixItems", ())), {})
    unit = node.get("unit", first.get("unit", ""))
    return "" if unit == "1" else unit


def _default(node: Schema) -> str:
    """The default as text; empty for none, and for an empty table or list."""
    value = node.get("default")
    if value is None or value == [] or isinstance(value, dict):
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else f"{value}".replace("'", '"')


def _allowed(node: Schema) -> str:
    """Choices or range of a value; otherwise what it is."""
    if "enum" in node:
        return ", ".join(map(str, node["enum"]))
    if "const" in node:
        return str(node["const"])
    low = next((f"{word}{node[key]:g}" for key, word in LOW.items() if key in node), "")
    high = next((f"{word}{node[key]:g}" for key, word in HIGH.items() if key in node), "")
    if low and high:
        return f"{low} to {high}"
    if low:
        return low if low.startswith("above") else f"{low} or more"
    if high:
        return high if high.startswith("below") else f"{high} or less"
    if "properties" in node:
        return "a table"
    kinds = {"boolean": "true, false", "array": "a list", "object": "a table", "integer": "a count"}
    return "" if "unit" in node else kinds.get(str(node.get("type")), "")
