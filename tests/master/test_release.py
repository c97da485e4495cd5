"""What a release says of itself: one version everywhere, and a short changelog."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
CHANGELOG = (ROOT / "CHANGELOG.md").read_text()
LARGEST, LONGEST = 15_000, 25
"""Bytes of the changelog, and words of an entry."""


@pytest.mark.parametrize(
    "file, before",
    [
        ("CITATION.cff", r"(?m)^version: "),
        ("conda.recipe/recipe.yaml", r'(?m)^  version: "'),
        ("docs/figures.md", r"version "),
    ],
)
def test_the_version_is_the_same_everywhere(file, before):
    match = re.search(before + r"(\d+\.\d+\.\d+)", (ROOT / file).read_text())
    assert match and match[1] == VERSION


def test_the_changelog_begins_with_the_version():
    released = re.findall(r"(?m)^## \[?(\d+\.\d+\.\d+|Unreleased)\]?", CHANGELOG)
    assert VERSION in released[:2] and set(released[:2]) <= {"Unreleased", VERSION, *released[1:]}


def test_the_changelog_is_short():
    assert len(CHANGELOG.encode()) <= LARGEST


def test_an_entry_is_one_short_sentence():
    entries = re.findall(r"(?m)^- (.+(?:\n  .+)*)", CHANGELOG)
    assert len(entries) > 50
    for entry in entries:
        text = re.sub(r"\]\([^)]*\)", "", entry)
        assert len(text.split()) <= LONGEST, entry
        assert entry.endswith(".") and not re.search(r"[.!?] [A-Z]", text), entry


def test_the_kinds_of_change_are_those_of_keep_a_changelog():
    kinds = set(re.findall(r"(?m)^### (.+)$", CHANGELOG))
    assert kinds <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
