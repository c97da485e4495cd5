"""Pages of the site that are made of the sources, given to mkdocs as if they lay in `docs`.

Texts of the repository (README, cases, changelog) with their links put right; commands, parameters
and option classes by introspection; every equation by its label. mkdocs calls `on_config` and
`on_files`.
"""

import ast
import inspect
import os
import posixpath
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).parents[1]
PARTS = ("fmu_ehd", "fmu_mfbd", "master")
ROOMS = ("__init__.py", "models", *PARTS)
TEXTS = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "models/lubrication_template/README.md": "tutorials/own_film.md",
    "models/engine/README.md": "tutorials/engine.md",
    "models/numerical_example/README.md": "cases/numerical_example.md",
    "models/numerical_example/PAPER.md": "cases/paper.md",
    "models/fired_motorcycle/README.md": "cases/fired_motorcycle.md",
    "models/data_sheet/README.md": "cases/data_sheet.md",
    "models/journal_bearing/README.md": "cases/journal_bearing.md",
    "models/floating_pin/README.md": "cases/floating_pin.md",
    "models/crank_bearings/README.md": "cases/crank_bearings.md",
    "models/yielding_bosses/README.md": "cases/yielding_bosses.md",
    "models/twin/README.md": "cases/twin.md",
    "models/flexible_twin/README.md": "cases/flexible_twin.md",
    "models/elastic_tube/README.md": "cases/elastic_tube.md",
    "models/two_mass_oscillator/README.md": "cases/two_mass_oscillator.md",
}
"""File of the repository -> page of the site."""

LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)]*)?\)")
LABEL = r"\(([A-Z]\d+[a-z]?)\)"
DEFINED = re.compile(rf'^\s*(?:""")?(?P<text>Eq\. {LABEL}:.*)')
NAMED = re.compile(r"#[^\n]*?\b(Eqs?\. [^\n]*)")
OPTION_CLASSES = {
    "The case file": "master.case.schema",
    "Build options of the lubrication FMU": "fmu_ehd.build",
    "Build options of the body FMU": "fmu_mfbd.options",
}


def on_config(config):
    """The package under its name, for mkdocstrings: the folder itself may have any."""
    package = scratch("package") / "piston_cosim"
    for path in (path for room in ROOMS for path in found_in(ROOT / room)):
        target = package / path.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(set_apart(path.read_text()))
    return config


def scratch(name):
    """An empty folder for what is made on the way."""
    folder = ROOT / "build" / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def found_in(room):
    """Python files of a room, or the file that it is."""
    return [room] if room.is_file() else sorted(room.rglob("*.py"))


def set_apart(code):
    """The code with equations in its docstrings as blocks that Markdown leaves as they stand."""
    made, inside = [], None
    for line in code.split("\n"):
        match = DEFINED.match(line)
        indent = len(line) - len(line.lstrip())
        if inside is not None and not match and not (line.strip() and indent >= inside + 4):
            made.append(" " * inside + "```")
            inside = None
        if match and inside is None and '"""' not in line:
            inside = indent
            made += ["", " " * inside + "```text"]
        if inside is not None and '"""' in line:
            line = line.replace('"""', f'\n{" " * inside}```\n{" " * inside}"""')
            inside = None
        made.append(line)
    return "\n".join(made)


def on_files(files, config):
    """All pages that no file of `docs` holds."""
    pages = {page: moved(source, page) for source, page in TEXTS.items()}
    pages |= pictures() | reference() | theory()
    for page, content in pages.items():
        files.append(File.generated(config, page, content=content))
    os.chdir(scratch("notebooks"))  # where they run: what they write goes there
    return files


def on_page_markdown(markdown, page, config, files):
    """A file of `docs` names others by where they lie in the repository, as do all texts there."""
    if page.file.generated_by is None:
        markdown = linked_up(markdown, f"docs/{page.file.src_uri}", page.file.src_uri)
    return markdown


# ---- texts of the repository


def moved(source, page):
    """A text of the repository as a page."""
    return fenced(linked_up((ROOT / source).read_text(), source, page))


def linked_up(text, source, page):
    """The text with links that lead to pages; those to files that are none lead nowhere."""
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

    return LINK.sub(relinked, text)


def fenced(text):
    """Code blocks without the word that the tests look for behind the language."""
    return re.sub(r"(?m)^```(\w+) \w+$", r"```\1", text)


def pictures():
    """Pictures that texts show, as files of the site."""
    return {
        f"pictures/{path.relative_to(ROOT)}": path.read_bytes()
        for path in (ROOT / "models").rglob("*.png")
    }


# ---- reference


def reference():
    """Public names, commands, case files, parameters, and all modules of the parts."""
    pages = {
        "reference/api.md": api(),
        "reference/commands.md": commands(),
        "reference/case.md": options(),
        "reference/parameters.md": parameters(),
    }
    return pages | {f"reference/{part}.md": modules(part) for part in PARTS}


def api():
    """Every public name where it is defined."""
    import piston_cosim as pc

    lines = ["# `import piston_cosim as pc`", "", inspect.getdoc(pc).partition("Each is")[0], ""]
    lines[2] = fence(lines[2].split("\n", 1)[1])
    for name, (module, inside) in zip(pc._PLACES, public()):
        lines += [f"## pc.{name}", "", f"::: {f'piston_cosim.{module}.{inside}'.rstrip('.')}"]
        lines += ["    options:", "      show_root_heading: false", "      heading_level: 3", ""]
    return "\n".join(lines)


def commands():
    """What cyclopts says of every command and its options."""
    from piston_cosim.master.commands.app import app

    text = app.generate_docs(output_format="markdown", recursive=True)
    return re.sub(r"(?s)## Table of Contents.*?\*\*Commands\*\*:", "", text)


def options():
    """Option classes: every table of a case file and of the build options, and its keys."""
    from importlib import import_module

    from pydantic import BaseModel

    lines = ["# Keys of a case file", ""]
    for title, place in OPTION_CLASSES.items():
        module = import_module(f"piston_cosim.{place}")
        lines += [f"## {title}", ""]
        for name, thing in vars(module).items():
            if (
                inspect.isclass(thing)
                and issubclass(thing, BaseModel)
                and thing.__module__ == module.__name__
            ):
                lines += [f"### {name}", "", fence(inspect.getdoc(thing) or ""), ""]
                lines += table(("key", "type", "default", "meaning"), keys_of(thing))
    return "\n".join(lines)


def keys_of(model):
    """Rows of a pydantic class: key, type, default, meaning."""
    described = model.model_json_schema()["properties"]
    for name, info in model.model_fields.items():
        kind = str(info.annotation).replace("typing.", "")
        kind = re.sub(r"<class '([\w.]+)'>|(?:piston_cosim[\w.]*\.)", lambda m: m[1] or "", kind)
        default = "required" if info.is_required() else repr(info.get_default())
        if info.default_factory is not None:
            default = "its own defaults"
        key = info.alias or name
        yield f"`{key}`", f"`{kind}`", f"`{default}`", described[key]["description"]


def parameters():
    """Every variable of both FMUs, as they declare it."""
    from piston_cosim.fmu_ehd.variables import variables as of_film
    from piston_cosim.fmu_mfbd import variables as of_bodies
    from piston_cosim.fmu_mfbd.dynamics.build_options import FilmGrid
    from piston_cosim.fmu_mfbd.dynamics.parameters import CRANK_PARAMETERS, SpaceParameters

    grid, modes = (40, 40), 120
    films = (FilmGrid("", grid),)
    bodies = [*of_bodies.inputs(films), *of_bodies.outputs(films, modes), *of_bodies.parameters()]
    skirt = of_film(grid)
    known = {variable.name for variable in skirt}
    bearing = [v for v in of_film(grid, surface="bearing") if v.name not in known]
    told = {variable.name for variable in bodies}
    own = [*of_bodies.space_outputs(), *of_bodies.parameters(SpaceParameters)]
    space = [variable for variable in own if variable.name not in told]
    of_crank = [
        *(
            one
            for name, what in of_bodies.OF_CRANK.items()
            for one in of_bodies.crank_outputs(name, *what)
        ),
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
    """Row of a variable."""
    ends = [variable.minimum, variable.maximum]
    allowed = (
        "" if ends == [None, None] else " to ".join("" if e is None else f"{e:g}" for e in ends)
    )
    allowed = ", ".join(variable.choices) or allowed
    shape = "x".join(map(str, variable.shape))
    name = f"`{variable.name}`" + (f" {shape}" if shape else "")
    return name, variable.causality, variable.unit, variable.start, allowed, variable.description


def public():
    """(module, name in it) of every public name; without a name the module itself is public."""
    import piston_cosim as pc

    for name, place in pc._PLACES.items():
        module, colon, inside = place.partition(":")
        yield module, inside if colon else name


def modules(part):
    """All modules of a part with their docstrings; public names have a page of their own."""
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
    """Lines of a Markdown table."""
    made = [heads, ["---"] * len(heads), *rows]
    cells = [[str(cell).replace("|", "\\|").replace("\n", " ") for cell in row] for row in made]
    return [*(f"| {' | '.join(row)} |" for row in cells), ""]


def fence(text):
    """A text as it stands."""
    return f"```text\n{text.strip()}\n```"


# ---- theory


@dataclass
class Equation:
    """One equation: where it is defined, its text, and the lines that compute it."""

    label: str
    file: str
    line: int
    text: str
    computed: list[tuple[str, int, str]] = field(default_factory=list)


def sources():
    """File -> lines, of all code that computes."""
    paths = [path for part in (*PARTS, "models") for path in sorted((ROOT / part).rglob("*.py"))]
    return {path.relative_to(ROOT).as_posix(): path.read_text().split("\n") for path in paths}


def equations(texts) -> dict[str, Equation]:
    """Every equation by its label, in the order of the files."""
    found = {}
    for file, lines in texts.items():
        for number, line in enumerate(lines, 1):
            match = DEFINED.match(line)
            if match:
                label = re.search(LABEL, line)[1]
                found[label] = Equation(label, file, number, whole(lines, number, match))
    for file, lines in texts.items():
        for number, line in enumerate(lines, 1):
            for label in labels_named(line):
                if label in found:
                    found[label].computed.append((file, number, code_at(lines, number)))
    return found


def whole(lines, number, match):
    """Text of an equation that begins in a line, with the lines indented below it."""
    indent = match.start("text")
    text = [match["text"]]
    for line in lines[number:]:
        if not line.strip() or not line.startswith(" " * (indent + 4)) or DEFINED.match(line):
            break
        text.append(line[indent:])
    return "\n".join(text).replace('"""', "").rstrip()


def labels_named(line) -> Iterator[str]:
    """Labels in a comment: "# Eq. (E1)", "# Eqs. (E1), (E2)", "# Eqs. (E1) to (E3)"."""
    for comment in NAMED.findall(line):
        yield from re.findall(LABEL, comment)
        for letter, first, last in re.findall(r"\(([A-Z])(\d+)\) to \([A-Z](\d+)\)", comment):
            yield from (f"{letter}{k}" for k in range(int(first) + 1, int(last)))


def code_at(lines, number):
    """The code that a comment in a line is about: before it, or else below it."""
    before = lines[number - 1].partition("#")[0].strip()
    below = (line.strip() for line in lines[number:] if line.strip()[:1] not in ("", "#"))
    return before or next(below, "")


def theory():
    """The page of all equations, and a page of each file that they lead to."""
    texts = sources()
    found = equations(texts)
    lines = [
        "# Theory: every equation",
        "",
        "An equation has a label of its own and stands in the docstring of what computes it; the "
        "line that does names it in a comment. This page is made of both. Symbols are explained "
        "in the reference of the module; works in [references](references.md).",
        "",
    ]
    reached = set()
    file = part = None
    for one in found.values():
        home = one.file.split("/")[0]
        if home != part:
            part = home
            lines += [f"## {TITLES[part]}", ""]
        if one.file != file:
            file = one.file
            doc = ast.get_docstring(ast.parse("\n".join(texts[file]))) or file
            lines += [f"### {doc.split(chr(10) * 2)[0].replace(chr(10), ' ')}", ""]
        lines += [f'<a id="{one.label}"></a>', "", fence(one.text), ""]
        where = [linked(one.file, one.line, "defined"), *places(one)]
        lines += [*(f"- {text}" for text in where), ""]
        reached |= {one.file, *(name for name, _, _ in one.computed)}
    pages = {"theory.md": "\n".join(lines)}
    for name in sorted(reached):
        code = "\n".join(texts[name])
        head = f"---\nsearch:\n  exclude: true\n---\n# {name}\n\n"
        pages[f"source/{name}.md"] = f'{head}````python linenums="1"\n{code}\n````\n'
    return pages


TITLES = {
    "fmu_ehd": "Lubrication",
    "fmu_mfbd": "Bodies",
    "master": "Coupling",
    "models": "Models of cases",
}


def places(equation):
    """Links to the lines that compute an equation, with the code there."""
    for file, line, code in equation.computed:
        yield f"{linked(file, line, 'computed')}: `{code.replace('`', '')}`"


def linked(file, line, word):
    """A link to a line of a source page."""
    return f'{word} in <a href="../source/{file}/#__codelineno-0-{line}">{file}:{line}</a>'
