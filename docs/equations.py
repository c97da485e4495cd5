"""Equations of the site: every one by its label, rendered, with links to the lines that compute it.

The docstrings define the equations and comments name them where they are computed. The pages of
`docs/theory` write formulas in LaTeX, `$h$` in a line or `$$ ... \\tag{E1} $$`. They refer to an
equation by `{E1}`.
"""

import ast
import html
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import notation
from fontTools import subset
from fontTools.ttLib import TTFont

ROOT = Path(__file__).parents[1]
PARTS = {
    "fmu_ehd": "Lubrication",
    "fmu_mfbd": "Bodies",
    "master": "Coupling",
    "models": "Models of cases",
    "tests/verification/cases": "Verification",
}
"""Folder -> title of its equations."""

LABEL = r"\(([A-Z]\d+[a-z]?)\)"
DEFINED = re.compile(rf'^\s*(?:""")?(?P<text>Eq\. {LABEL}:.*)')
NAMED = re.compile(r"#[^\n]*?\b(Eqs?\. [^\n]*)")
DISPLAYED = re.compile(r"(?ms)^\$\$\s*([^$]+?)\s*\\tag\{([^}]*)\}\s*\$\$$")
INLINE = re.compile(r"\$([^$\n]+)\$")


@dataclass
class Equation:
    """One equation: where it is defined, its text, and the lines that compute it."""

    label: str
    file: str
    line: int
    text: str
    computed: list[tuple[str, int, str]] = field(default_factory=list)

    @property
    def code(self):
        """File and line of the code: where it is computed, or else defined."""
        return self.computed[0][:2] if self.computed else (self.file, self.line)


@cache
def sources():
    """Return file -> lines, of all code that computes."""
    paths = [path for part in PARTS for path in sorted((ROOT / part).rglob("*.py"))]
    return {path.relative_to(ROOT).as_posix(): path.read_text().split("\n") for path in paths}


@cache
def equations() -> dict[str, Equation]:
    """Return every equation by its label, in the order of the files."""
    found = {}
    for file, lines in sources().items():
        for number, line in enumerate(lines, 1):
            match = DEFINED.match(line)
            if match:
                label = re.search(LABEL, line)[1]
                found[label] = Equation(label, file, number, whole(lines, number, match))
    for file, lines in sources().items():
        for number, line in enumerate(lines, 1):
            for label in labels_named(line):
                if label in found:
                    found[label].computed.append((file, number, code_at(lines, number)))
    return found


def whole(lines, number, match):
    """Return the text of an equation that begins in a line, with the lines indented below it."""
    indent = match.start("text")
    text = [match["text"]]
    for line in lines[number:]:
        if not line.strip() or not line.startswith(" " * (indent + 4)) or DEFINED.match(line):
            break
        text.append(line[indent:])
    return "\n".join(text).replace('"""', "").rstrip()


def labels_named(line) -> Iterator[str]:
    """Yield the labels in a comment: "# Eq. (E1)", "# Eqs. (E1), (E2)", "# Eqs. (E1) to (E3)"."""
    for comment in NAMED.findall(line):
        yield from re.findall(LABEL, comment)
        for letter, first, last in re.findall(r"\(([A-Z])(\d+)\) to \([A-Z](\d+)\)", comment):
            yield from (f"{letter}{k}" for k in range(int(first) + 1, int(last)))


def code_at(lines, number):
    """Return the code that a comment in a line is about: before it, or else below it."""
    before = lines[number - 1].partition("#")[0].strip()
    below = (line.strip() for line in lines[number:] if line.strip()[:1] not in ("", "#"))
    return before or next(below, "")


# ---- rendering


def with_mathematics(code, dedent=0):
    """Return Python code or Markdown with its equations rendered as HTML.

    Equations of Python code are in docstrings, those of Markdown are blocks indented by `dedent`.
    """
    lines, made, number = code.split("\n"), [], 0
    while number < len(lines):
        line = lines[number]
        match = DEFINED.match(line)
        if match is None:
            made.append(line)
            number += 1
            continue
        text = whole(lines, number + 1, match)
        indent = line[dedent : len(line) - len(line.lstrip())]
        count = text.count("\n") + 1
        quotes = "\n".join(lines[number : number + count]).count('"""')
        opened = line.lstrip().startswith('"""')
        made += [f'{indent}"""'] * opened + ["", indent + block(text, match[2]), ""]
        made += [f'{indent}"""'] * (quotes - opened)
        number += count
    return "\n".join(made)


def block(text, label, number=None):
    """Return a displayed equation of a docstring with its label."""
    return framed(notation.rendered(text), number or f"<span>({label})</span>")


def framed(formula, numbers):
    """Return a displayed formula beside its labels."""
    return f'<div class="equation"><div class="formula">{formula}</div>{numbers}</div>'


def with_formulas(markdown, page):
    """Return a page of the theory with its formulas as MathML and its labels as links."""

    def displayed(match):
        parts = re.split(r"\\qquad\s*", match[1])
        formula = "".join(f"<span>{notation.mathml(part, display=True)}</span>" for part in parts)
        numbers = "".join(numbered(label) for label in match[2].split(", "))
        return framed(f"<div>{formula}</div>", numbers)

    def numbered(label):
        file, line = equations()[label].code
        return (
            f'<span><a href="../{up}theory/equations/#{label}">({label})</a> '
            f'<a href="../{up}source/{file}/#__codelineno-0-{line}">code</a></span>'
        )

    def referred(match):
        equations()[match[1]]  # an unknown label is an error
        return f"[({match[1]})](equations.md#{match[1]})"

    up = "" if page.endswith("index.md") else "../"
    parts = re.split(r"(?ms)(^```.*?^```$|`[^`\n]+`)", markdown)
    for index in range(0, len(parts), 2):
        part = DISPLAYED.sub(displayed, parts[index])
        if "$$" in part:
            raise notation.Unreadable(f"{page}: a displayed formula has no label: {part[:200]}")
        part = INLINE.sub(lambda match: notation.mathml(match[1]), part)
        parts[index] = re.sub(r"\{([A-Z]\d+[a-z]?)\}", referred, part)
    return "".join(parts)


def with_formulas_in_paragraphs(page):
    """Return the HTML of a notebook with the formulas of its text as MathML."""

    def rendered(match):
        return INLINE.sub(lambda part: notation.mathml(html.unescape(part[1])), match[0])

    return re.sub(r"(?s)<p>.*?</p>", rendered, page)


@cache
def math_font():
    """Return STIX Two Math in WOFF with the characters of the site's formulas."""
    package = Path(find_spec("ziamath").origin).parent
    font = TTFont(package / "fonts" / "STIXTwoMath-Regular.ttf")
    options = subset.Options(layout_features=["*"])
    subsetter = subset.Subsetter(options)
    blocks = ((0x20, 0x7F), (0xA0, 0x100), (0x2B0, 0x400), (0x2000, 0x2070), (0x20D0, 0x2150))
    blocks += ((0x2190, 0x21A8), (0x2200, 0x22C8), (0x2308, 0x230C), (0x23B4, 0x23E2))
    blocks += ((0x27E8, 0x27EA), (0x1D400, 0x1D468), (0x1D6A4, 0x1D714))
    subsetter.populate(unicodes=[code for first, end in blocks for code in range(first, end)])
    subsetter.subset(font)
    font.flavor = "woff"
    target = ROOT / "build" / "math.woff"
    font.save(target)
    return target.read_bytes()


# ---- pages


def pages():
    """Return the page of all equations, and a page of each source file that they lead to."""
    lines = [
        "# All equations",
        "",
        "Every equation has a label. The docstring of the code defines it, and a comment names it "
        "at the line that computes it. The build of this site renders the text of the docstring. "
        "The reference of each module explains the symbols. The [references](../references.md) "
        "list the sources.",
        "",
    ]
    reached = set()
    file = part = None
    for equation in equations().values():
        home = next(one for one in PARTS if equation.file.startswith(f"{one}/"))
        if home != part:
            part = home
            lines += [f"## {PARTS[part]}", ""]
        if equation.file != file:
            file = equation.file
            doc = ast.get_docstring(ast.parse("\n".join(sources()[file]))) or file
            lines += [f"### {doc.split(chr(10) * 2)[0].replace(chr(10), ' ')}", ""]
        number = f'<span><a href="#{equation.label}">({equation.label})</a></span>'
        shown = block(equation.text, equation.label, number)
        lines += [f'<div id="{equation.label}" title="{quoted(equation.text)}">{shown}</div>', ""]
        defined = linked(equation.file, equation.line, "defined")
        lines += [*(f"- {text}" for text in (defined, *code_links(equation))), ""]
        reached |= {equation.file, *(name for name, _, _ in equation.computed)}
    made = {"theory/equations.md": "\n".join(lines)}
    listed = "\n".join(f"- [{name}]({name}.md)" for name in sorted(reached))
    made["source/index.md"] = f"# Source files with equations\n\n{listed}\n"
    for name in sorted(reached):
        code = "\n".join(sources()[name])
        head = f"---\nsearch:\n  exclude: true\n---\n# {name}\n\n"
        made[f"source/{name}.md"] = f'{head}````python linenums="1"\n{code}\n````\n'
    return made


def quoted(text):
    """Return a text as the value of an HTML attribute on one line."""
    return html.escape(text).replace("\n", "&#10;")


def code_links(equation):
    """Yield links to the lines that compute an equation, with the code there."""
    for file, line, code in equation.computed:
        yield f"{linked(file, line, 'computed')}: `{code.replace('`', '')}`"


def linked(file, line, word):
    """Return a link to a line of a source page."""
    return f'{word} in <a href="../../source/{file}/#__codelineno-0-{line}">{file}:{line}</a>'
