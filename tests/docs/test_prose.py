"""Texts that users read follow the rules of `prose.py`."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

from piston_cosim.master.case.keys import case_keys, part_function
from piston_cosim.master.case.reading import case_names, find_case, read_tree
from piston_cosim.master.case.schema import Case
from piston_cosim.master.commands.app import app
from piston_cosim.master.fmi.slave import FieldSlave

from .prose import of_markdown, of_text

ROOT = Path(__file__).parents[2]
RESULTS = (
    "engine/answer",
    "engine/places",
    "engine/sections",
    "engine/verdicts",
)
LOG = ("runs/extrapolation", "runs/repetition", "coupling/components", "coupling/ledger")
MODELS = (
    "engine.crankshaft",
    "engine.gas_pressure",
    "journal_bearing.shaft",
    "lubrication_template.axial_film",
    "lubrication_template.dry_contact",
    "ring_pack.ring_pack",
    "twin.mounted_block",
)


def findings(texts):
    """Return what is wrong with (position, text) pairs, as lines."""
    return [
        f"{place}: {fault}: {part}"
        for place, text in texts
        if " " in text
        for fault, part in of_text(text)
    ]


def documents():
    """Return the Markdown files of the project, without what a build writes."""
    folders = (ROOT / "docs", ROOT / "models")
    return [*ROOT.glob("*.md"), *(path for folder in folders for path in folder.rglob("*.md"))]


@pytest.mark.parametrize("path", documents(), ids=lambda path: str(path.relative_to(ROOT)))
def test_documents(path):
    wrong = [f"{line}: {fault}: {text}" for line, fault, text in of_markdown(path.read_text())]
    assert wrong == []


def described(name):
    """Yield (position, text) of the keys of a case and of the variables of its FMUs."""
    path = find_case(name)
    tree = read_tree(path)
    for key in case_keys(tree, path.parent):
        yield key.path, key.meaning
    for participant, table in tree["participants"].items():
        if declared := part_function(table.get("package"), "declared_variables"):
            for variable in declared(table["build"], path.parent):
                yield f"{participant}.{variable.name}", variable.description


@pytest.mark.parametrize("name", case_names())
def test_keys_and_variables(name):
    assert findings(described(name)) == []


@pytest.mark.parametrize(
    "schema",
    [
        Case.model_json_schema,
        *(part_function(one, "options_schema") for one in ("fmu_ehd", "fmu_mfbd")),
        *(part_function(f"fmu_mfbd.{one}", "options_schema") for one in ("monoblock", "shell")),
    ],
)
def test_tables(schema):
    found = schema()
    tables = {"": found} | found.get("$defs", {})
    texts = [(name, one["description"]) for name, one in tables.items() if "description" in one]
    assert texts and findings(texts) == []


@pytest.mark.parametrize("name", MODELS)
def test_variables_of_a_model(name):
    module = import_module(f"piston_cosim.models.{name}")
    (model,) = (
        one
        for one in vars(module).values()
        if isinstance(one, type)
        and issubclass(one, FieldSlave)
        and one.__module__ == module.__name__
    )
    texts = [(one.name, one.description) for one in model.variables({"grid": (4, 4)})]
    assert texts and findings(texts) == []


def strings(path):
    """Yield (line, text) of the strings of a file but its docstrings; values in them are "0"."""
    tree = ast.parse(path.read_text())
    nodes = list(ast.walk(tree))
    skipped = {one.value for one in nodes if isinstance(one, ast.Expr)}
    skipped |= {part for one in nodes if isinstance(one, ast.JoinedStr) for part in one.values}
    for one in nodes:
        if one in skipped:
            continue
        if isinstance(one, ast.JoinedStr):
            parts = (part.value if isinstance(part, ast.Constant) else "0" for part in one.values)
            yield one.lineno, "".join(map(str, parts))
        elif isinstance(one, ast.Constant) and isinstance(one.value, str):
            yield one.lineno, one.value


@pytest.mark.parametrize("name", RESULTS + LOG)
def test_messages_of_a_run(name):
    texts = list(strings(ROOT / f"master/{name}.py"))
    assert texts and findings(texts) == []


def test_help():
    text = app.generate_docs(output_format="markdown", recursive=True)
    assert text.count("Example:") > 20
    assert list(of_markdown(text)) == []
