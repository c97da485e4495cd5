"""Every key of a case file and of the FMUs that it builds; also as a JSON schema.

Each key has its unit, default, range and meaning.
"""

from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path
from typing import Any

from ..fmi.errors import BadInput, near
from ..fmi.option_classes import ANY, EACH, Key, keys
from ..fmi.tree import import_part
from ..fmi.variables import Variable
from .schema import Case

SETTABLE = ("parameter", "input", "structuralParameter")
"""Causalities of variables that a case can set."""


def part_function(package: str | None, name: str) -> Callable[..., Any] | None:
    """Return function `name` of a package's module `build`, None if there is none."""
    try:
        return getattr(import_part(f"{package}.build"), name, None) if package else None
    except ImportError:
        return None


def declared_variables(table: Any, folder: Path) -> list[Variable] | None:
    """Return the variables of the FMU that a participant's table builds, if its part declares them.

    Raises
    ------
    BadInput
        If the part does not exist, or with the faults of its build options.
    """
    if table.package and not _is_installed(table.package):
        raise BadInput(f"package: expected an installed one with `build`, got {table.package!r}")
    declared = part_function(table.package, "declared_variables")
    try:
        return declared(table.build, folder) if declared else None
    except BadInput as error:
        raise BadInput([f"build.{line}" for line in error.faults]) from None


def _is_installed(package: str) -> bool:
    try:
        import_part(f"{package}.build")
    except ImportError:
        return False
    return True


def case_keys(tree: dict[str, Any], folder: Path) -> list[Key]:
    """Return every key that a case file may have, then those of the participants that it builds.

    Parameters
    ----------
    tree : dict
        TOML tree of a case. Its `participants` determine the parts.
    folder : Path
        Folder of the case.
    """
    all_keys = keys(Case.model_json_schema())
    for name, table in _built(tree).items():
        before = f"participants.{name}."
        schema = part_function(table["package"], "options_schema")
        if schema:
            all_keys += keys(schema(), f"{before}build.")
        all_keys += [_key(one, before) for one in _settable(table, folder)]
    return all_keys


def key_at(tree: dict[str, Any], path: str, folder: Path) -> Key | None:
    """Return the key at a dotted path of a case, None for one that is not declared."""
    parts = path.split(".")
    for key in case_keys(tree, folder):
        pairs = list(zip_longest(key.path.split("."), parts))
        if all(wanted == part or (wanted in (ANY, EACH) and part) for wanted, part in pairs):
            return key
    return None


def _built(tree: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the tables of the participants that a package builds, by name."""
    tables = tree.get("participants", {})
    if not isinstance(tables, dict):
        return {}
    return {
        name: table
        for name, table in tables.items()
        if isinstance(table, dict) and isinstance(table.get("package"), str)
    }


def _settable(table: dict[str, Any], folder: Path) -> list[Variable]:
    """Return the variables that `parameters` may set; invalid build options have no effect."""
    declared = part_function(table["package"], "declared_variables")
    if declared is None:
        return []
    try:
        variables = declared(table.get("build", {}), folder)
    except BadInput:
        variables = declared(None, folder)
    return [one for one in variables if one.causality in SETTABLE and not one.shape]


def choices_of(table: dict[str, Any], parameter: str) -> tuple[str, ...]:
    """Return the choices of a parameter of a participant's table, () if its part declares none."""
    variables = _settable(table, Path()) if table.get("package") else []
    return next((one.choices for one in variables if one.name == parameter), ())


def _key(variable: Variable, before: str) -> Key:
    """Return a parameter of an FMU as a key of the case."""
    unit = "" if variable.unit == "1" else variable.unit
    return Key(
        path=f"{before}parameters.{variable.name}",
        unit=unit,
        default=_number(variable.start) + (f" {unit}" if unit else ""),
        allowed=range_of(variable),
        meaning=variable.description,
        whole=variable.type == "Integer",
        advanced=variable.advanced,
    )


def _number(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def range_of(variable: Variable) -> str:
    """Return the choices or the range of a variable as text."""
    if variable.choices:
        return ", ".join(variable.choices)
    low, high = variable.minimum, variable.maximum
    if low is None and high is None:
        return ""
    if low is not None and high is not None:
        return f"{low:g} to {high:g}"
    return f"{low:g} or more" if high is None else f"{high:g} or less"


SYNONYMS = {
    "gap": ("clearance", "film_thickness"),
    "play": ("clearance",),
    "lubricant": ("oil", "viscosity"),
    "oil": ("viscosity",),
    "profile": ("barrel", "ovality", "skirt_profile"),
    "rpm": ("crank_speed",),
    "stiffness": ("young",),
    "weight": ("mass",),
    "solver": ("method", "tolerance", "max_iterations"),
    "mesh": ("grid",),
    "combustion": ("gas",),
}
"""Word that users search for -> words in the names of keys."""


def chosen_keys(all_keys: list[Key], word: str) -> tuple[list[Key], bool]:
    """Return the keys that a word selects, and whether it is the path of a table.

    A dotted path, or part of one, selects the table. Any other word selects the keys whose name,
    meaning or synonym contains it. Keys whose name contains it come first.

    Raises
    ------
    BadInput
        If no key matches.
    """
    wanted = word.split(".")
    chosen = [key for key in all_keys if _has(key.path.split("."), wanted)]
    if any(key.name != wanted[-1] for key in chosen):
        return chosen, True
    text = word.lower()
    names = (text, *SYNONYMS.get(text, ()))
    by_name = [key for key in all_keys if any(name in key.path.lower() for name in names)]
    by_meaning = [key for key in all_keys if text in key.meaning.lower() and key not in by_name]
    if chosen := list(dict.fromkeys([*chosen, *by_name, *by_meaning])):
        return chosen, False
    parts = {part for key in all_keys for part in key.path.split(".")} - {ANY, EACH}
    words = {text for part in parts for text in part.split("_")}
    close = near(wanted[-1], sorted({*parts, *words, *SYNONYMS}))
    question = close or "; `piston-cosim keys` lists all keys"
    raise BadInput(f"WORD: expected a word of a key, got {word!r}{question}")


def _has(path: list[str], wanted: list[str]) -> bool:
    return any(path[k : k + len(wanted)] == wanted for k in range(len(path)))


def library_oils(tree: dict[str, Any]) -> list[Any]:
    """Return the oils that the films of a case can select by name."""
    packages = dict.fromkeys(table["package"] for table in _built(tree).values())
    functions = filter(None, (part_function(package, "library_oils") for package in packages))
    return [oil for function in functions for oil in function()]


def matching_oils(oils: list[Any], word: str) -> list[Any]:
    """Return all oils for the word oil or lubricant, else those whose name or title contains it."""
    if word.lower() in ("oil", "oils", "lubricant"):
        return oils
    text = word.lower().replace("-", "_")
    return [oil for oil in oils if text in f"{oil.name} {oil.title}".lower().replace("-", "_")]


def json_schema(tree: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the JSON schema of a case and its participants, for editors.

    It contains the `build` and `parameters` that the part of each participant declares. No key is
    required, because the case may extend another one.
    """
    schema = Case.model_json_schema()
    general = schema["properties"]["participants"]
    general["properties"] = {}
    for name, table in _built(tree).items():
        own = {"properties": {}}
        if options := part_function(table["package"], "options_schema"):
            inner = options()
            _adapt(inner, f"{table['package']}.")
            schema["$defs"] |= {
                f"{table['package']}.{key}": one for key, one in inner.pop("$defs", {}).items()
            }
            own["properties"]["build"] = inner
        own["properties"]["parameters"] = {
            "type": "object",
            "additionalProperties": False,
            "properties": {one.name: _property(one) for one in _settable(table, folder)},
        }
        general["properties"][name] = {"allOf": [{"$ref": "#/$defs/ParticipantTable"}, own]}
    _adapt(schema, "")
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _adapt(node: Any, before: str) -> None:
    """Add a prefix to all references to definitions, and require no key, in place."""
    if isinstance(node, dict):
        if "$ref" in node:
            node["$ref"] = "#/$defs/" + before + node["$ref"].rpartition("/")[-1]
        if isinstance(node.get("required"), list):
            del node["required"]
    for value in node.values() if isinstance(node, dict) else node:
        if isinstance(value, (dict, list)):
            _adapt(value, before)


def _property(variable: Variable) -> dict[str, Any]:
    """Return a parameter as a JSON schema property; one with a unit is a string."""
    described: dict[str, Any] = {"description": f"{variable.description}. {_range_text(variable)}"}
    if variable.choices:
        return described | {"enum": list(variable.choices), "default": variable.start}
    if variable.unit != "1":
        return described | {"type": "string", "unit": variable.unit}
    bounds = {"minimum": variable.minimum, "maximum": variable.maximum}
    limits = {word: bound for word, bound in bounds.items() if bound is not None}
    return described | {"type": ["number", "string"], "default": variable.start} | limits


def _range_text(variable: Variable) -> str:
    """Return default, unit and range as a sentence."""
    key = _key(variable, "")
    unit = f" {key.unit}" if key.unit else ""
    allowed = f"; allowed {key.allowed}{unit}" if key.allowed else ""
    return f"Default {key.default}{allowed}."
