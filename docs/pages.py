"""Hooks of mkdocs: pages that are made of the sources, next to the files of `docs`.

Texts of the repository (README, cases, changelog) get links that work on the site. Commands,
options and variables come from introspection, equations from the docstrings.
"""

import inspect
import os
import posixpath
import re
import shutil
import tomllib
from pathlib import Path

import equations
import gallery
from mkdocs.exceptions import PluginError
from mkdocs.plugins import event_priority
from mkdocs.structure.files import File

ROOT = Path(__file__).parents[1]
PARTS = ("fmu_ehd", "fmu_mfbd", "master")
PACKAGE = ("__init__.py", "models", *PARTS)
TEXTS = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "models/lubrication_template/README.md": "tutorials/own_film.md",
    "models/engine/README.md": "tutorials/engine.md",
    "models/numerical_example/PAPER.md": "cases/paper.md",
    **{f"models/{case}/README.md": f"cases/{case}.md" for case in gallery.cases()},
    **{f"models/measured/{study}/README.md": f"studies/{study}.md" for study in gallery.studies()},
}
"""File of the repository -> page of the site."""

PICTURED = r"index\.md|gallery\.md|theory/index\.md|(cases|how_to|notebooks|tutorials)/.*"
"""Pages that must show a picture."""
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)]*)?\)")
MADE = re.compile(r"page `([\w/]+)` of the site")
"""A page that exists on the site only, in a text of the repository."""


@event_priority(100)  # before mkdocstrings, which looks for the folder of the copy
def on_config(config):
    """Copy the package under its name for mkdocstrings; set version, repository and navigation."""
    os.environ.pop("MPLBACKEND", None)  # notebooks draw into the page
    package = scratch("package") / "piston_cosim"
    for path in (path for part in PACKAGE for path in python_files(ROOT / part)):
        target = package / path.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(equations.with_mathematics(path.read_text()))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    config.repo_url = project.get("urls", {}).get("Repository") or "source/"
    config.repo_name = f"{project['name']} {project['version']}"
    accuracy = next(entry["Accuracy"] for entry in config.nav if "Accuracy" in entry)
    accuracy.append({"Published studies": [f"studies/{name}.md" for name in gallery.studies()]})
    measured = sorted(path.name for path in (ROOT / "docs/measurements").glob("*.md"))
    if measured:
        accuracy.append({"Measurements": [f"measurements/{name}" for name in measured]})
    return config


def scratch(name):
    """Return an empty folder for intermediate files."""
    folder = ROOT / "build" / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def python_files(path):
    """Return the Python files of a folder, or the file itself."""
    return [path] if path.is_file() else sorted(path.rglob("*.py"))


def on_files(files, config):
    """Add all pages that no file of `docs` holds."""
    pages = {page: moved(source, page) for source, page in TEXTS.items()}
    pages |= pictures() | reference() | equations.pages() | {"gallery.md": gallery.page()}
    pages |= {"assets/math.woff": equations.math_font()}
    for page, content in pages.items():
        files.append(File.generated(config, page, content=content))
    os.chdir(scratch("notebooks"))  # the folder in which notebooks run and write
    return files


def on_page_markdown(markdown, page, config, files):
    """Resolve links of a file of `docs`, which are relative to the repository, and formulas."""
    source = page.file.src_uri
    if page.file.generated_by is None:
        markdown = linked_up(markdown, f"docs/{source}", source)
        markdown = equations.with_mathematics(markdown, dedent=4)
    return equations.with_formulas(markdown, source) if source.startswith("theory/") else markdown


def on_post_page(output, page, config):
    """Reject a page without a picture where a picture is required; cut paths of this machine."""
    name = page.file.src_uri
    has_run = (
        not name.startswith("notebooks/") or config.plugins["mkdocs-jupyter"].config["execute"]
    )
    if has_run and re.fullmatch(PICTURED, name) and "<img" not in output:
        raise PluginError(f"{name}: expected at least one picture, got none")
    if name.startswith("notebooks/"):
        output = equations.with_formulas_in_paragraphs(output)
    return output.replace(f"{ROOT}/", "")  # what notebooks print must not depend on the machine


# ---- texts of the repository


def moved(source, page):
    """Return a text of the repository as a page."""
    return fenced(linked_up((ROOT / source).read_text(), source, page))


def linked_up(text, source, page):
    """Return a text whose links lead to pages; a link to any other file becomes its path."""
    home = posixpath.dirname(source)

    def relinked(match):
        picture, words, target, anchor = match.groups()
        if ":" in target:
            return match[0]
        path = posixpath.normpath(posixpath.join(home, target))
        if path.startswith("docs/"):
            goal = path.removeprefix("docs/")
        elif picture or path.endswith(".png"):
            goal = f"pictures/{path}"
        else:
            goal = TEXTS.get(path) or TEXTS.get(f"{path}/README.md")
        if goal is None:
            return f"{words} (`{path}`)"
        away = posixpath.relpath(goal, posixpath.dirname(page) or ".")
        return f"{picture}[{words}]({away}{anchor or ''})"

    up = "../" * page.count("/")
    return MADE.sub(rf"page [`\1`]({up}\1.md)", LINK.sub(relinked, text))


def fenced(text):
    """Return a text without the words after the language of a code block, which tests use."""
    return re.sub(r"(?m)^```(\w+) \w+$", r"```\1", text)


def pictures():
    """Return the pictures of the cases as files of the site."""
    return {
        f"pictures/{path.relative_to(ROOT)}": path.read_bytes()
        for path in (ROOT / "models").rglob("*.png")
    }


# ---- reference


def reference():
    """Return the pages of public names, commands, case files, variables and modules."""
    pages = {
        "reference/api.md": api(),
        "reference/commands.md": commands(),
        "reference/case.md": options(),
        "reference/parameters.md": parameters(),
    }
    return pages | {f"reference/{part}.md": modules(part) for part in PARTS}


def api():
    """Return the page of all public names."""
    import piston_cosim as pc

    lines = ["# `import piston_cosim as pc`", "", inspect.getdoc(pc).partition("Each is")[0], ""]
    lines[2] = fence(lines[2].split("\n", 1)[1])
    for name, (module, inside) in zip(pc._PLACES, public()):
        lines += [f"## pc.{name}", "", f"::: {f'piston_cosim.{module}.{inside}'.rstrip('.')}"]
        lines += ["    options:", "      show_root_heading: false", "      heading_level: 3", ""]
    return "\n".join(lines)


def commands():
    """Return the page of all commands and their options."""
    from piston_cosim.master.commands.app import app

    text = app.generate_docs(output_format="markdown", recursive=True)
    return re.sub(r"(?s)## Table of Contents.*?\*\*Commands\*\*:", "", text)


def options():
    """Return the page of all keys of a case file and of the build options, by table."""
    from piston_cosim.master.case.keys import case_keys
    from piston_cosim.master.case.reading import find_case, read_tree

    path = find_case("data_sheet")
    tables = {}
    for key in sorted(case_keys(read_tree(path), path.parent), key=lambda key: key.advanced):
        name = key.path.rpartition(".")[0] + " (few cases need these)" * key.advanced
        default = "required" if key.required else key.default
        row = f"`{key.name}`", key.unit, default, key.allowed, key.meaning
        tables.setdefault(name or "case", []).append(row)
    lines = ["# Keys of a case file", ""]
    for name, rows in tables.items():
        if ".parameters" not in name:  # the page of the variables contains them
            heads = ("key", "unit", "default", "allowed", "meaning")
            lines += [f"## {name}", "", *table(heads, rows)]
    return "\n".join(lines)


def parameters():
    """Return the page of all variables of both FMUs."""
    from piston_cosim.fmu_ehd.variables import variables as of_film
    from piston_cosim.fmu_mfbd import variables as of_bodies
    from piston_cosim.fmu_mfbd.dynamics.block_force import BlockForce
    from piston_cosim.fmu_mfbd.dynamics.build_options import FilmGrid
    from piston_cosim.fmu_mfbd.dynamics.parameters import CRANK_PARAMETERS, SpaceParameters
    from piston_cosim.fmu_mfbd.dynamics.pin_outputs import PIN_OUTPUTS
    from piston_cosim.fmu_mfbd.dynamics.space_model import SpaceScalars
    from piston_cosim.master.fmi.variables import output_variable

    grid, modes = (40, 40), 120
    films = (FilmGrid("", grid),)
    bodies = [*of_bodies.inputs(films), *of_bodies.outputs(films, modes)]
    bodies += [*of_bodies.declared(BlockForce), *of_bodies.parameters()]
    skirt = of_film(grid)
    known = {variable.name for variable in skirt}
    bearing = [v for v in of_film(grid, surface="bearing") if v.name not in known]
    told = {variable.name for variable in bodies}
    own = [*of_bodies.declared(SpaceScalars), *of_bodies.parameters(SpaceParameters)]
    space = [variable for variable in own if variable.name not in told]
    of_pin = [output_variable(*row) for row in PIN_OUTPUTS]
    of_crank = [
        *(v for v in of_pin if v.name.startswith(tuple(CRANK_PARAMETERS))),
        *of_bodies.parameters(*CRANK_PARAMETERS.values()),
    ]
    crank = [variable for variable in of_crank if variable.name not in told]
    heads = ("name", "causality", "unit", "start", "allowed", "meaning")
    lines = ["# Variables of the FMUs", "", "Tables for 40 x 40 cells and 120 modes, in SI", ""]
    for title, rows in (
        ("Lubrication, `fmu_ehd`", skirt),
        ('Additional variables of a bearing (`surface = "bearing"`)', bearing),
        ("Bodies, `fmu_mfbd`", bodies),
        ("Additional variables of a piston in space (`motion_in_space`)", space),
        ("Additional variables of a crank on films (`big_end`, `main_bearing`)", crank),
    ):
        lines += [f"## {title}", "", *table(heads, map(row_of, rows))]
    return "\n".join(lines)


def row_of(variable):
    """Return the row of a variable."""
    from piston_cosim.master.case.keys import range_of

    shape = "x".join(map(str, variable.shape))
    name = f"`{variable.name}`" + (f" {shape}" if shape else "")
    return (
        name,
        variable.kind,
        variable.unit,
        variable.start,
        range_of(variable),
        variable.description,
    )


def public():
    """Yield (module, name in it) of every public name; an empty name stands for the module."""
    import piston_cosim as pc

    for name, place in pc._PLACES.items():
        module, colon, inside = place.partition(":")
        yield module, inside if colon else name


def modules(part):
    """Return the page of all modules of a part, without the public names."""
    lines = [f"# {part}", ""]
    elsewhere = list(public())
    for path in sorted((ROOT / part).rglob("*.py")):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        if (name, "") in elsewhere:
            continue
        lines += [f"::: piston_cosim.{name}", "    options:"]
        lines += ["      show_root_full_path: true", "      show_submodules: false"]
        if path.name == "__init__.py":
            lines += ["      members: false"]
        hidden = ["!^_", *(f"!^{one}$" for module, one in elsewhere if module == name)]
        lines += [f"      filters: [{', '.join(map(repr, hidden))}]", ""]
    return "\n".join(lines)


def table(heads, rows):
    """Return the lines of a Markdown table."""
    made = [heads, ["---"] * len(heads), *rows]
    cells = [[str(cell).replace("|", "\\|").replace("\n", " ") for cell in row] for row in made]
    return [*(f"| {' | '.join(row)} |" for row in cells), ""]


def fence(text):
    """Return a text as a block of code."""
    return f"```text\n{text.strip()}\n```"
