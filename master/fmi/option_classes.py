"""Description of option classes: every key with its unit, default, range and meaning.

The source is the JSON schema that pydantic makes of a class, so the class may belong to any
part. Bounds of a quantity with a unit are `ge`, `gt`, `le`, `lt`, in SI. The description of a
key is the text below it in its class, which is read when a schema is requested.
"""

import re
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cache
from itertools import takewhile
from typing import Annotated, Any, TypeGuard, TypeVar, cast, get_args

from pydantic import BaseModel, Strict, ValidationError

from .errors import BadInput, unknown
from .texts import texts_below

Schema = Mapping[str, Any]
Options = TypeVar("Options", bound=BaseModel)
LOW = {"minimum": "", "ge": "", "exclusiveMinimum": "above ", "gt": "above "}
HIGH = {"maximum": "", "le": "", "exclusiveMaximum": "below ", "lt": "below "}
Flag = Annotated[bool, Strict()]
"""Value true or false. Without `Strict`, pydantic accepts 1 and "yes" as well."""
ANY = "NAME"
"""Placeholder in a dotted key for a name that the user chooses."""
ADVANCED: dict[str, Any] = {"advanced": True}
"""Mark of a key that few cases need, for `json_schema_extra` of its field."""
EACH = "N"
"""Placeholder in a dotted key for the index of a list entry, from 0."""


@dataclass(frozen=True)
class Key:
    """One key of an option class.

    path : dotted; default : as written, empty if there is none or the key is required; allowed :
    choices or range; meaning : one sentence; whole : whether it is a whole number; advanced :
    whether few cases need it.
    """

    path: str
    unit: str
    default: str
    allowed: str
    meaning: str
    required: bool = False
    whole: bool = False
    advanced: bool = False

    @property
    def name(self) -> str:
        """Last part of the path."""
        return self.path.rpartition(".")[-1]


def with_meanings(schema: dict[str, Any], kind: type[BaseModel]) -> None:
    """Add the text below each key of a class to its schema, in place: for `json_schema_extra`.

    pydantic's `use_attribute_docstrings` would read the source of every class at import. That
    takes a tenth of a start, and only `keys` needs it.
    """
    for one in reversed(kind.__mro__[: kind.__mro__.index(BaseModel)]):
        for name, meaning in texts_below(one).items():
            if field := kind.model_fields.get(name):
                schema["properties"][field.alias or name]["description"] = meaning


def validated(kind: type[Options], options: Mapping[str, Any]) -> Options:
    """Return the options of a class; raise `BadInput` with every fault."""
    try:
        return kind.model_validate(without_flags(dict(options), kind))
    except ValidationError as error:
        raise BadInput(sentences(error, kind)) from None


NUMBERS = {int, float}
ANYTHING = {bool, dict, list, Any}
"""Types of values that may be true or false, or contain it."""


def without_flags(value: Any, kind: Any) -> Any:
    """Return a value of a type with true and false as text where only numbers are valid.

    pydantic would read true as 1.
    """
    kinds = _kinds(kind)
    if isinstance(value, bool):
        return str(value).lower() if kinds & NUMBERS and not kinds & ANYTHING else value
    if isinstance(value, list):
        return [without_flags(one, kind) for one in cast(list[Any], value)]
    if not isinstance(value, Mapping):
        return value
    fields: dict[str, Any] = {}
    for one in kinds:
        if isinstance(one, type) and issubclass(one, BaseModel):
            fields |= {f.alias or name: f.annotation for name, f in one.model_fields.items()}
    table = cast(Mapping[str, Any], value)
    return {key: without_flags(one, fields.get(key, kind)) for key, one in table.items()}


@cache
def _kinds(kind: Any) -> frozenset[Any]:
    """Return a type and the types in it."""
    inner = (_kinds(one) for one in get_args(kind) if isinstance(one, Hashable))
    return frozenset({kind}).union(*inner)


def sentences(error: ValidationError, kind: type[BaseModel]) -> list[str]:
    """Return the faults of an option class, "KEY: expected X, got Y; hint" each."""
    by_key: dict[str, list[str]] = {}
    # a value of one of the possible types has faults of this type only
    typed = {key_of(fault) for fault in error.errors() if fault["type"] in RIGHT_TYPE}
    for fault in error.errors():
        if fault["type"].endswith("_type") and key_of(fault) in typed:
            continue
        for sentence in _sentences(fault, kind):
            by_key.setdefault(key_of(fault) if _of_choice(fault) else sentence, []).append(sentence)
    return [_either(several) for several in by_key.values()]


RIGHT_TYPE = (
    "finite_number",
    "greater_than",
    "greater_than_equal",
    "less_than",
    "less_than_equal",
)
"""Faults of values that have the expected type."""
OPTION = re.compile(r"(str|bool|int|float|(list|dict|tuple|constrained|function)[\[-].*)")
"""Part of a pydantic location that names one of several types, not a key."""


EXPECTED = re.compile(r"(.*?: expected )(.*)(, got .*)")


def key_of(fault: Any) -> str:
    """Return the dotted key of a pydantic fault."""
    return ".".join(str(part) for part in takewhile(is_key, fault["loc"]))


def is_key(part: str | int) -> bool:
    """Return whether a part of a pydantic location is a key, not a type."""
    return isinstance(part, int) or not OPTION.fullmatch(part)


def _of_choice(fault: Any) -> bool:
    """Return whether a fault is about a value that may have several types."""
    return not all(map(is_key, fault["loc"]))


def _either(sentences: list[str]) -> str:
    """Return one sentence about a value that has none of its possible types."""
    parts = [match.groups() for one in sentences if (match := EXPECTED.fullmatch(one))]
    if len(parts) < 2:
        return sentences[-1]
    starts, wanted, ends = zip(*parts, strict=True)
    return f"{starts[-1]}{' or '.join(dict.fromkeys(wanted))}{ends[-1]}"


def _sentences(fault: Any, kind: type[BaseModel]) -> list[str]:
    """Return a pydantic fault as sentences; those of a validator may begin with a key."""
    where = key_of(fault)
    if fault["type"] == "value_error":
        return [
            f"{where}{': ' if line.startswith('expected ') else '.'}{line}".removeprefix(".")
            for line in str(fault["ctx"]["error"]).splitlines()
        ]
    return [_sentence(fault, where, kind)]


def _sentence(fault: Any, where: str, kind: type[BaseModel]) -> str:
    """Return the sentence of a fault that pydantic itself reports."""
    context = fault.get("ctx", {})
    if fault["type"] == "extra_forbidden":
        *parents, last = fault["loc"]
        schema = kind.model_json_schema()
        known = [name for here in _tables(schema, schema, parents) for name in here["properties"]]
        return f"{where}: {unknown('key', last, known)}"
    if fault["type"] == "missing":
        return f"{where}: expected a value, got nothing"
    if fault["type"] in ("literal_error", "enum"):
        choices = [text.strip(" '") for text in re.split(",| or ", context["expected"])]
        return f"{where}: {unknown('choice', fault['input'], choices)}"
    expected = WANTED.get(fault["type"], "another value").format(**context)
    if fault["type"].startswith(("greater_than", "less_than")):
        schema = kind.model_json_schema()
        expected = f"{expected} {_unit_at(schema, schema, fault['loc'])}".rstrip()
    return f"{where or 'case'}: expected {expected}, got {_shown(fault['input'])}"


def _shown(value: Any) -> str:
    """Return a value as it appears in a sentence."""
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, (list, tuple)):
        items = cast(Sequence[Any], value)
        return f"a list of {len(items)}" if len(items) > 3 else repr(list(items))
    return f"the date {value}" if isinstance(value, date) else repr(value)


WANTED = {
    "string_type": 'a string with a unit if it has one, such as "720 deg"',
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "finite_number": "a finite number",
    "list_type": "a list",
    "tuple_type": "a list",
    "set_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "mapping_type": "a table",
    "greater_than": "a value above {gt:g}",
    "greater_than_equal": "a value of at least {ge:g}",
    "less_than": "a value below {lt:g}",
    "less_than_equal": "a value of at most {le:g}",
    "too_short": "a list of at least {min_length} entries",
    "too_long": "a list of at most {max_length} entries",
    "string_pattern_mismatch": 'a name such as "participant.variable"',
}
"""Expected value by pydantic's name of the fault."""


def _tables(schema: Schema, node: Schema, place: Sequence[str | int]) -> list[Schema]:
    """Return the tables at a location; for a choice between several tables all of them.

    Parts of the location that name a type are skipped.
    """
    tables: list[Schema] = []
    for option in options(schema, node):
        if not place:
            tables += [option] if "properties" in option else []
            continue
        first, *rest = place
        child = _child(option, first)
        tables += _tables(schema, option if child is None else child, rest)
    return tables


def _unit_at(schema: Schema, node: Schema, place: Sequence[str | int]) -> str:
    """Return the unit of the value at a location; "" if there is none."""
    for option in options(schema, node):
        if not place:
            unit = _unit(option)
        else:
            child = _child(option, place[0])
            unit = _unit_at(schema, option if child is None else child, place[1:])
        if unit:
            return unit
    return ""


def _child(node: Schema, part: str | int) -> Schema | None:
    """Return the child of a table or list at one of its keys; None if there is none."""
    if isinstance(part, int):
        return node.get("items")
    own = node.get("properties", {}).get(part)
    other: Any = node.get("additionalProperties")
    return own or (other if _is_schema(other) else None)


def options(schema: Schema, node: Schema) -> list[Schema]:
    """Return the possible schemas of a value, with references resolved and without `null`."""
    if "$ref" in node:
        target = schema["$defs"][node["$ref"].rpartition("/")[-1]]
        return options(schema, target)
    if "anyOf" in node:
        return [one for option in node["anyOf"] for one in options(schema, option)]
    return [] if node.get("type") == "null" else [node]


def keys(schema: Schema, before: str = "") -> list[Key]:
    """Return every key of a class once; keys of a nested table follow that table."""
    return list({key.path: key for key in _keys(schema, schema, before)}.values())


def _keys(schema: Schema, table: Schema, before: str, advanced: bool = False) -> Iterator[Key]:
    for name, node in table.get("properties", {}).items():
        path = f"{before}{name}"
        choices = options(schema, node)
        types = [one.get("type") for one in choices]
        own = advanced or node.get("advanced", False)
        yield Key(
            path=path,
            unit=next((unit for one in choices if (unit := _unit(one))), ""),
            default=_default(node),
            allowed=" or ".join(dict.fromkeys(text for one in choices if (text := _allowed(one)))),
            meaning=" ".join(node.get("description", "").split()).removesuffix("."),
            required=name in table.get("required", ()),
            whole="integer" in types and "number" not in types,
            advanced=own,
        )
        for one in choices:
            yield from _inside(schema, one, path, own)


def _inside(schema: Schema, node: Schema, path: str, advanced: bool) -> Iterator[Key]:
    """Yield the keys of the tables inside a value."""
    if "properties" in node:
        yield from _keys(schema, node, f"{path}.", advanced)
    for inner, part in ((node.get("additionalProperties"), ANY), (node.get("items"), EACH)):
        if _is_schema(inner):
            for one in options(schema, inner):
                yield from _inside(schema, one, f"{path}.{part}", advanced)


def _is_schema(value: object) -> TypeGuard[Schema]:
    return isinstance(value, Mapping)


def _unit(node: Schema) -> str:
    """Return the unit of a quantity or of a list of fixed length; "" if there is none."""
    first: Schema = next(iter(node.get("prefixItems", ())), node)
    unit = node.get("unit", first.get("unit", ""))
    return "" if unit == "1" else unit


def _default(node: Schema) -> str:
    """Return the default as text; empty if there is none, or for an empty table or list."""
    value = node.get("default")
    if value is None or value == [] or isinstance(value, dict):
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else f"{value}".replace("'", '"')


def _allowed(node: Schema) -> str:
    """Return the choices or the range of a value; otherwise its type."""
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
