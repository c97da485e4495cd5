"""Links of the texts lead to files and headings of the repository, not of the site alone."""

import re
from pathlib import Path

import pytest

from .test_prose import documents

ROOT = Path(__file__).parents[2]
LINK = re.compile(r"\]\(([^)\s#:]*)(?:#([^)\s]*))?\)")
MADE = re.compile(r"page `(\w+)/(\w+)` of the site")


def anchors(path):
    """Return the anchors of the headings of a Markdown file, as GitHub and mkdocs make them."""
    text = re.sub(r"(?ms)^```.*?^```$", "", path.read_text())
    heads = re.findall(r"(?m)^#+ (.*)$", text)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("path", documents(), ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_to_files_of_the_repository(path):
    dead = []
    for target, anchor in LINK.findall(re.sub(r"(?ms)^```.*?^```$", "", path.read_text())):
        goal = path.parent / target if target else path
        if not goal.exists() or (anchor and anchor not in anchors(goal)):
            dead.append(f"{target}#{anchor}")
    assert dead == []


def test_pages_that_only_the_site_has_are_made():
    pages = (ROOT / "docs/pages.py").read_text()
    named = {name for path in documents() for name in MADE.findall(path.read_text())}
    assert {f"reference/{page}" for folder, page in named if folder == "reference"} <= {
        *re.findall(r'"(reference/\w+)\.md"', pages)
    }
    assert {page for folder, page in named if folder != "reference"} == {"equations"}
