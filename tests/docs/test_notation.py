"""The translator of the plain notation, with formulas whose meaning is easy to lose."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
pytest.importorskip("latex2mathml")
KEPT = {"fmu_ehd": {"t", "g", "beta"}, "fmu_ehd/laws": {"H"}}
"""Folder -> symbols with another meaning elsewhere, by the table of docs/theory/index.md."""


@pytest.fixture(scope="module")
def notation():
    specification = importlib.util.spec_from_file_location("notation", DOCS / "notation.py")
    module = importlib.util.module_from_spec(specification)
    sys.modules["notation"] = module
    specification.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    "plain, latex",
    [
        # a spaced bar takes the product, a tight one ends at another fraction
        ("a b / (c + d)", r"\frac{ab}{c+d}"),
        ("h/2 dp/dy", r"\frac{h}{2}\frac{dp}{dy}"),
        ("e/(2 s)", r"\frac{e}{2s}"),
        # an exponent ends before a bar, but for square roots
        ("H^2/4", r"\frac{H^{2}}{4}"),
        ("(2 pi)^-1/2", r"\left(2\pi\right)^{-1/2}"),
        # sums and extrema do not enter a fraction
        ("sum p/q", r"\sum\frac{p}{q}"),
        ("max_j |a| / |b|", r"\max_{j}\frac{\left|a\right|}{\left|b\right|}"),
        ("share / max|v / s|", r"\frac{\text{share}}{\max\left|\frac{v}{s}\right|}"),
        # x between two operands is a product sign, elsewhere a variable
        ("M x S", r"M\timesS"),
        ("C - x cos a", r"C-x\cosa"),
        ("u^(i)(s)", r"u^{\left(i\right)}\left(s\right)"),
        ("x_A''", r"x_{A}^{\prime\prime}"),
        ("[F, 0; G, E]", r"\begin{bmatrix}F&0\\G&E\end{bmatrix}"),
        ("F_5/2(H)", r"F_{5/2}\left(H\right)"),
        ("of the bore", r"\text{ofthebore}"),
    ],
)
def test_a_formula_keeps_its_meaning(notation, plain, latex):
    assert re.sub(r"\\[;,]|\s", "", notation.latex(plain)) == latex.replace(" ", "")


@pytest.mark.parametrize("text", ["a # b", "a / ", "(a", "/ b )"])
def test_what_is_no_formula_is_an_error(notation, text):
    with pytest.raises(notation.Unreadable):
        notation.latex(text)


def test_words_around_a_formula_become_text(notation):
    html = notation.rendered("Eq. (X1):  h = R + c      c the clearance of a skirt")
    assert re.sub(r"<math.*?</math>", "*", html) == (
        "<div><span>*</span><span>* the clearance of a skirt</span></div>"
    )


def test_no_symbol_of_the_table_has_two_meanings():
    text = (DOCS / "theory/index.md").read_text().partition("## Symbols")[2]
    rows = [line.split("|") for line in text.split("\n") if line.startswith("| $")]
    for column in (1, 2):
        names = [name.strip() for row in rows for name in row[column].split(",")]
        assert len(names) > 30 and len(names) == len(set(names))


@pytest.mark.parametrize("folder", KEPT)
def test_equations_keep_symbols_for_their_meaning(folder):
    """`t` is time, `g` of the modes, `H` the macro step, and `beta` the tilt."""
    label = re.compile(r'(?m)^\s*(?:""")?Eq\. \(\w+\):(.*(?:\n {8,}\S.*)*)')
    texts = [path.read_text() for path in (DOCS.parent / folder).rglob("*.py")]
    used = {
        name for text in texts for one in label.findall(text) for name in re.findall(r"\w+", one)
    }
    assert used and used & KEPT[folder] == set()
