"""What a release says of itself: one version everywhere, and a short changelog."""

import re
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
VERSION = PROJECT["version"]
CHANGELOG = (ROOT / "CHANGELOG.md").read_text()
LARGEST, LONGEST = 17_500, 25
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


def test_the_citation_has_the_license():
    assert f"\nlicense: {PROJECT['license']}\n" in (ROOT / "CITATION.cff").read_text()


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


@pytest.mark.parametrize("name, script", [("ci", ".ci/run"), ("release", ".ci/release")])
def test_a_workflow_calls_the_script_of_the_checkout(name, script):
    workflow = yaml.safe_load((ROOT / f".github/workflows/{name}.yml").read_text())
    (job,) = workflow["jobs"].values()
    assert script in [step.get("run") for step in job["steps"]]
    assert (ROOT / script).stat().st_mode & 0o100


def test_conda_and_container_install_the_release_wheel():
    recipe = yaml.safe_load((ROOT / "conda.recipe/recipe.yaml").read_text())
    assert {"path": "../dist"} in recipe["source"]
    assert "piston_cosim-${{ version }}-py3-none-any.whl" in recipe["build"]["script"]
    image = (ROOT / "Containerfile").read_text()
    assert "COPY dist/*.whl" in image and "gcc" not in image
    assert "dist" not in (ROOT / ".dockerignore").read_text().split()


def test_the_index_of_measurements_has_every_page():
    folder = ROOT / "docs/measurements"
    linked = set(re.findall(r"\]\((\w+\.md)\)", (folder / "README.md").read_text()))
    assert linked == {path.name for path in folder.glob("*.md")} - {"README.md"}
