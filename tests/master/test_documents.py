"""Equations can be found.

Each label is defined once and is cited where it is computed; each citation has an entry.
"""

import ast
import inspect
import re
import tomllib
from collections import Counter
from pathlib import Path

import pytest

import piston_cosim as pc
from piston_cosim.master.commands.app import COMMANDS, GROUPS, app

ROOT = Path(__file__).parents[2]
LABEL = r"\(([A-Z]\d+[a-z]?)\)"
CITATION = re.compile(r"\[([A-Z][A-Za-z]+\d{4}[a-z]?)\]")


@pytest.fixture(scope="module")
def texts(trees):
    """File -> text of all code that computes."""
    return {path: path.read_text() for path in trees}


def defined(text):
    """Labels that a text defines: "Eq. (E1):  ..."."""
    return re.findall(rf'(?m)^\s*(?:""")?Eq\. {LABEL}:', text)


def computed(text):
    """Labels in comments: "# Eq. (E1)", "# Eqs. (E1), (E2)", "# Eqs. (E1) to (E3)"."""
    labels = []
    for comment in re.findall(r"#[^\n]*?\b(Eqs?\. [^\n]*)", text):
        labels += re.findall(LABEL, comment)
        for letter, first, last in re.findall(r"\(([A-Z])(\d+)\) to \([A-Z](\d+)\)", comment):
            labels += [f"{letter}{k}" for k in range(int(first), int(last))]
    return labels


def test_every_equation_has_a_label_of_its_own(texts):
    count = Counter(label for text in texts.values() for label in defined(text))
    assert {label for label, times in count.items() if times > 1} == set()


def test_every_equation_is_defined_and_stands_where_it_is_computed(texts):
    labels = {label for text in texts.values() for label in defined(text)}
    assert labels == {label for text in texts.values() for label in computed(text)}


def test_every_citation_can_be_looked_up(texts):
    listed = set(CITATION.findall((ROOT / "docs" / "references.md").read_text()))
    assert {key for text in texts.values() for key in CITATION.findall(text)} - listed == set()


def test_no_docstring_reads_like_a_link(trees):
    """`a[0] [s]` in plain words is a link to s for the site, which then is not built."""
    linked = [
        (path.name, found)
        for path, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))
        for found in re.findall(
            r"\S+\] ?\[\S+", re.sub(r"`[^`]*`", "", ast.get_docstring(node) or "")
        )
    ]
    assert linked == []


def test_every_file_that_a_document_names_is_there():
    path = re.compile(
        r"\b(?:fmu_ehd|fmu_mfbd|master|models|tests|docs)/[\w/]+\.(?:py|toml|csv|md|png|c|h)\b"
    )
    named = {name for document in documents() for name in path.findall(document.read_text())}
    assert named
    assert {name for name in named if not (ROOT / name).exists()} == set()


def documents():
    """Texts for readers."""
    return [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "models").rglob("*.md")]


def blocks(language):
    """(file, code) of all code blocks of a language."""
    fence = re.compile(rf"(?ms)^```{language}(?: \w+)?\n(.*?)^```$")
    return [(path.name, code) for path in documents() for code in fence.findall(path.read_text())]


def test_python_in_documents_is_python_and_names_what_is_public():
    named = set()
    for name, code in blocks("python"):
        compile(code, name, "exec")
        named |= set(re.findall(r"\bpc\.(\w+)", code))
    assert named >= {"open_case", "Film"}
    assert named - set(pc.__all__) == set()


def test_cases_in_documents_are_toml():
    found = blocks("toml")
    assert len(found) >= 5
    for _, code in found:
        tomllib.loads(code)


def arguments(command):
    """Arguments of a command, e.g. "results plot", with their descriptions."""
    return found(command).assemble_argument_collection(
        default_parameter=app.default_parameter, parse_docstring=True
    )


def found(command):
    """App of a command."""
    one = app
    for word in command.split():
        one = one[word]
    return one


def test_commands_in_documents_are_there_with_their_options():
    wrong = []
    for name, code in [*blocks(""), *blocks("bash")]:
        for words in re.findall(r"(?m)piston-cosim (\w+.*)$", code):
            typed = re.sub("`.*", "", words.partition("   ")[0]).split()
            command = " ".join(typed[:2] if typed[0] in GROUPS else typed[:1])
            options = {word for word in typed if word.startswith("--")}
            known = {"--help"}
            if command in COMMANDS:
                known |= {name for argument in arguments(command) for name in argument.names}
            if command not in COMMANDS or options - known:
                wrong.append((name, words))
    assert wrong == []


def test_the_shell_completes_every_command():
    script = app.generate_completion(shell="bash")
    names = {name for command in COMMANDS for name in command.split()}
    assert [name for name in names if name not in script] == []
    assert "--summary-json" in script


def test_the_overview_has_the_summary_of_every_command():
    for command, summary in COMMANDS.items():
        assert inspect.getdoc(found(command).default_command).splitlines()[0] == summary


def test_every_option_has_words():
    silent = [
        (command, argument.name)
        for command in COMMANDS
        for argument in arguments(command)
        if not argument.parameter.help and argument.name != "*"  # a group of options, none itself
    ]
    assert silent == []
