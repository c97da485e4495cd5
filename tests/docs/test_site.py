"""The site: built strictly by one command, every link leads somewhere, nothing is missing."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

import piston_cosim as pc

for needed in ("mkdocs", "material", "mkdocstrings", "mkdocs_jupyter"):
    pytest.importorskip(needed)

ROOT = Path(__file__).parents[2]
CODE = ("fmu_ehd", "fmu_mfbd", "master", "models")


class Page(HTMLParser):
    """Where a page can be entered, where its links lead, and its words."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.words = set(), set(), []
        self.feed(path.read_text())

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.anchors |= {given[key] for key in ("id", "name") if given.get(key)}
        self.links |= {given[key] for key in ("href", "src") if given.get(key)}

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self):
        return "".join(self.words)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Path in the site -> page."""
    folder = tmp_path_factory.mktemp("site")
    built = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    assert not (folder / "pages.py").exists()
    return {path.relative_to(folder): Page(path) for path in folder.rglob("*.html")}, folder


def test_every_link_leads_somewhere(site):
    pages, folder = site
    dead = []
    for path, page in pages.items():
        if path.name == "404.html":
            continue
        for link in page.links:
            target, _, anchor = link.partition("#")
            if re.match(r"[a-z]+:|//", target):
                continue
            goal = (folder / path.parent / target).resolve() if target else folder / path
            goal = goal / "index.html" if goal.is_dir() else goal
            known = pages.get(goal.relative_to(folder.resolve()) if target else path)
            if not goal.exists() or (anchor and known and anchor not in known.anchors):
                dead.append(f"{path}: {link}")
    assert dead == []


@pytest.mark.parametrize("name", pc.__all__)
def test_every_public_name_is_in_the_reference(site, name):
    pages, _ = site
    page = pages[Path("reference/api/index.html")]
    assert f"pc{name.lower()}" in {anchor.replace(".", "") for anchor in page.anchors}
    thing = getattr(pc, name)
    place = name if name == "variables" else thing.__name__
    assert any(anchor.endswith(f".{place}") for anchor in page.anchors)


def test_every_command_and_every_option_is_in_the_reference(site):
    from piston_cosim.master.commands.app import COMMANDS, app

    pages, _ = site
    text = pages[Path("reference/commands/index.html")].text
    missing = []
    for command in COMMANDS:
        assert f"piston-cosim {command}" in text
        part = text.split(f"piston-cosim {command}")[-1]
        found = app
        for word in command.split():
            found = found[word]
        for argument in found.assemble_argument_collection():
            missing += [
                (command, n) for n in argument.names if n.startswith("--") and n not in part
            ]
    assert missing == []


def test_every_equation_stands_on_the_page_of_theory(site):
    pages, _ = site
    page = pages[Path("theory/index.html")]
    defined = set()
    for part in CODE:
        for path in (ROOT / part).rglob("*.py"):
            found = re.findall(r'(?m)^\s*(?:""")?Eq\. \(([A-Z]\d+[a-z]?)\):', path.read_text())
            defined |= set(found)
    assert len(defined) > 150
    assert defined - page.anchors == set()
    assert all(f"Eq. ({label}):" in page.text for label in defined)
    assert page.text.count("computed in") >= len(defined)


def test_every_variable_of_the_fmus_is_in_the_reference(site):
    pages, _ = site
    text = pages[Path("reference/parameters/index.html")].text
    assert all(name in text for name in pc.Film.parameters())


def test_every_key_of_a_case_is_in_the_reference(site):
    from piston_cosim.master.case.schema import Case, Coupling, ParticipantTable, WireTable

    pages, _ = site
    text = pages[Path("reference/case/index.html")].text
    keys = {
        info.alias or name
        for table in (Case, Coupling, ParticipantTable, WireTable)
        for name, info in table.model_fields.items()
    }
    assert {key for key in keys if key not in text} == set()


def test_nothing_of_this_machine_is_on_the_site(site):
    pages, _ = site
    assert [path for path, page in pages.items() if str(ROOT) in page.text] == []
