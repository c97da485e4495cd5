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

pytestmark = pytest.mark.slow  # .ci/run builds the site next to the tests
ROOT = Path(__file__).parents[2]
CODE = ("fmu_ehd", "fmu_mfbd", "master", "models", "tests/verification/cases")
DEFINED = r'(?m)^\s*(?:""")?Eq\. \(([A-Z]\d+[a-z]?)\):'
STORY = ("film", "contact", "bodies", "coupling")
"""Pages of the theory after the first one."""


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
        part = text.split(f"piston-cosim {command}¶")[-1]
        found = app
        for word in command.split():
            found = found[word]
        for argument in found.assemble_argument_collection():
            names = [
                n for n in argument.names if re.match("--(?!empty-)", n)
            ]  # --empty-X: cyclopts'
            missing += [(command, n) for n in names if n not in part]
    assert missing == []


def defined_labels():
    """Return the labels of all equations that the code defines."""
    texts = [path.read_text() for part in CODE for path in (ROOT / part).rglob("*.py")]
    return {label for text in texts for label in re.findall(DEFINED, text)}


def test_every_equation_is_rendered_on_its_page_with_links_to_its_code(site):
    pages, folder = site
    page = pages[Path("theory/equations/index.html")]
    labels = defined_labels()
    assert len(labels) > 250
    assert labels - page.anchors == set()
    shown = re.findall(
        r'(?s)<div id="([A-Z]\d+[a-z]?)" title=.*?><div class="equation">(.*?)</div></div>',
        (folder / "theory/equations/index.html").read_text(),
    )
    assert {label for label, html in shown if "<math" in html} == labels
    assert page.text.count("computed in") >= len(labels)


def test_no_page_shows_an_equation_as_plain_text(site):
    pages, folder = site
    source = ("source/", "changelog/")  # source code, and releases before
    plain = {
        path: re.findall(DEFINED, page.text)
        for path, page in pages.items()
        if not path.as_posix().startswith(source)
    }
    assert {path: labels for path, labels in plain.items() if labels} == {}
    notebooks = (folder / "notebooks").rglob("*.html")
    assert [path for path in notebooks if re.search(r"<(p|li)>[^<]*\$", path.read_text())] == []


def test_every_formula_of_the_theory_has_a_label_and_a_link_to_its_code(site):
    pages, folder = site
    formulas = 0
    for name in ("index.html", *(f"{page}/index.html" for page in STORY)):
        text = (folder / "theory" / name).read_text()
        _, *blocks = text.split('<div class="equation">')
        assert all("#__codelineno" in block and "/equations/#" in block for block in blocks), name
        assert "$" not in pages[Path("theory") / name].text.replace("$ ", "")
        formulas += len(blocks)
    assert formulas >= 30


def test_every_page_of_the_navigation_leads_to_the_next(site):
    pages, folder = site
    for name in ("getting_started", "gallery", "theory/film", "cases/twin", "reference/case"):
        assert "md-footer__link--next" in (folder / name / "index.html").read_text(), name


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
