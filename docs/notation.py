"""Translator from the plain notation of the docstrings to rendered mathematics.

The docstrings write equations in plain text: `h_T/sigma = H/2 (1 + erf(H/sqrt 2))`. The functions
here translate this notation to LaTeX, and LaTeX to MathML, which browsers draw without a script.

A fraction bar without spaces takes the factor before it, a spaced one the whole product. Its
denominator is the next factor. This is the meaning that the notation has in Python.
"""

import html
import re
from typing import NamedTuple

from latex2mathml.converter import convert

GREEK = (
    "alpha beta gamma delta epsilon eps zeta eta theta kappa lambda mu nu xi pi rho sigma tau "
    "phi chi psi omega Gamma Delta Lambda Phi Psi Omega"
).split()
FUNCTIONS = "exp ln lg sin cos tan arccos arctan tanh min max det".split()
"""Functions that LaTeX knows by name."""
OPERATORS = "asin erf argmin rms mean median range diag tr div grad floor size".split()
"""Further functions, in upright letters."""
SPACE = '<mspace width="0.17em"></mspace>'
UNITS = r"(?:m|rad|km|deg|N)/(?:s2|s|mm)\b"
SYMBOL = rf"(?:{'|'.join(sorted(GREEK, key=len, reverse=True))}|So|[A-Za-z])"
"""A letter or the name of a Greek one."""
RELATIONS = {
    "<-": r"\leftarrow ",
    "->": r"\to ",
    "<=": r"\le ",
    ">=": r"\ge ",
    "+=": r"\;\text{+=}\;",
    "+-": r"\pm ",
    "..": r"\dots ",
    "=": "=",
    "<": r"<",
    ">": r">",
    "~": r"\sim ",
    "+": "+",
    "-": "-",
    ",": r",\;",
    ";": r";\;",
    ":": r":\;",
    "!": "!",
    "%": r"\%",
}
BRACKETS = {"(": ")", "[": "]", "{": "}"}
TOKEN = re.compile(
    rf"""
    (?P<space>\s+)
  | (?P<text>`[^`]*` | Eqs?\.\ \([A-Z]\d+[a-z]?\)(?:(?:,|\ to|\ and)\ \([A-Z]\d+[a-z]?\))*
      | \([A-Z]\d+\)(?=,|$) | {UNITS}
      | [A-Za-z]{{2,}}'s\b | [A-Z][a-z]+\d{{4}} | \b[a-z]+-[a-z]{{3,}}\b)
  | (?P<number>\d+(?:\.\d+)?(?:e[-+]?\d+)?)
  | (?P<name>[A-Za-z][A-Za-z0-9]*)
  | (?P<prime>'+)
  | (?P<subscript>_(?:\{{[^}}]*\}}|(?:\([^()]*\))+|\d/\d(?=\(|$|\s)|[A-Za-z]\+1,[a-z]|[a-z]\+1
      |[A-Za-z0-9]+(?:,[A-Za-z](?![A-Za-z']))?))
  | (?P<power>\^)
  | (?P<sign><-|->|<=|>=|\+=|\+-|\.\.|[-+*/=<>~,;:.!%|()\[\]{{}}])
    """,
    re.VERBOSE,
)


class Unreadable(ValueError):
    """A text that does not follow the notation."""


class Token(NamedTuple):
    """A token, and whether a space is before it and after it."""

    kind: str
    text: str
    before: bool
    after: bool


def tokens_of(text):
    """Return the tokens of a text."""
    found, position, spaced = [], 0, True
    while position < len(text):
        match = TOKEN.match(text, position)
        if match is None:
            raise Unreadable(f"{text!r}: unknown character {text[position]!r}")
        position = match.end()
        if match.lastgroup == "space":
            spaced = True
            continue
        after = position == len(text) or text[position].isspace()
        found.append(Token(match.lastgroup or "", match[0], spaced, after))
        spaced = False
    return found


def is_word(token):
    """Return whether a token is a word of English rather than a symbol."""
    if token is None or token.kind not in ("name", "text"):
        return False
    text = token.text
    known = text in FUNCTIONS or text in OPERATORS or text in ("sqrt", "sum", "int", "inf")
    if text == "do":
        return True
    return token.kind == "text" or not (known or re.fullmatch(rf"d?{SYMBOL}\d*", text))


class Reader:
    """A reader of the tokens of one formula, by recursive descent."""

    def __init__(self, text):
        self.source = text
        self.tokens = tokens_of(text)
        self.index = 0
        self.bars = 0

    def peek(self, ahead=0):
        """Return a token ahead, or None."""
        position = self.index + ahead
        return self.tokens[position] if 0 <= position < len(self.tokens) else None

    def at(self, *texts):
        """Return whether the next token is one of these signs."""
        token = self.peek()
        return token is not None and token.kind == "sign" and token.text in texts

    def take(self, text=None):
        """Return the next token and move on."""
        token = self.peek()
        if token is None or (text is not None and token.text != text):
            raise Unreadable(f"{self.source!r}: expected {text!r} at token {self.index}")
        self.index += 1
        return token

    def terms(self, stop=()):
        """Yield (LaTeX, is prose) of the terms up to a closing sign: operators and products."""
        while self.peek() is not None and not self.at(*stop):
            if self.starts_prose():
                yield self.prose(), True
                if self.is_times():
                    self.take()
                    yield r"\times ", False
            elif self.is_factor():
                yield self.product(), False
            else:
                token = self.take()
                if token.text == "." and token.after:
                    yield ".", False
                elif token.text == "/" and self.is_factor():
                    yield "/", False
                elif token.text == "<" and not token.after:
                    yield r"\langle ", False
                elif token.text == ">" and not token.before:
                    yield r"\rangle ", False
                elif token.text in RELATIONS:
                    yield RELATIONS[token.text], False
                else:
                    raise Unreadable(f"{self.source!r}: {token.text!r} has no operand")

    def formula(self, stop=()):
        """Return the LaTeX of everything up to a closing sign."""
        parts = [rf"\;\text{{{part}}}\;" if prose else part for part, prose in self.terms(stop)]
        return re.sub(r"\\;(?=,|$)|^\\;(?=\\text)", "", "".join(parts))

    def starts_prose(self):
        """Return whether a word, or an article before a word, is next."""
        token, following = self.peek(), self.peek(1)
        called = (token.text in OPERATORS and is_word(following)) or self.is_spoken_sum()
        if is_word(token) or called:
            divided = following and following.text == "/" and not is_word(self.peek(-1))
            return not (self.applies(1) or self.has_mark(1) or divided)
        return token.text == "a" and is_word(following) and not self.applies(2)

    def is_spoken_sum(self, ahead=0):
        """Return whether a token ahead is the word sum in a sentence."""
        token, following = self.peek(ahead), self.peek(ahead + 1)
        if token is None or token.text != "sum":
            return False
        return following is None or is_word(following) or following.text == ","

    def applies(self, ahead):
        """Return whether a token ahead is a bracket without a space before it."""
        token = self.peek(ahead)
        return token is not None and token.text in ("(", "[") and not token.before

    def has_mark(self, ahead):
        """Return whether a token ahead is an index, a prime or a power."""
        token = self.peek(ahead)
        return token is not None and token.kind in ("subscript", "prime", "power")

    def prose(self):
        """Return consecutive words."""
        words = [self.take().text]
        while self.peek() is not None and self.peek().before and self.starts_prose():
            words.append(self.take().text)
        return " ".join(words)

    def is_factor(self):
        """Return whether a factor is next."""
        token = self.peek()
        if token is None:
            return False
        if token.text == "|":
            return not (self.bars and not token.before)
        return token.kind in ("name", "number", "text") or token.text in BRACKETS

    def product(self):
        """Return the factors up to the next operator, with their fractions."""
        factors = [self.factor()]
        while True:
            token = self.peek()
            if token is None or token.text in ("-", "+"):
                break
            if token.text == "/" and self.denominator_follows():
                self.take()
                first = numerator_start(factors, spaced=token.before)
                above = "".join(factors[first:])
                factors[first:] = [self.fraction(above, self.factor(below=True))]
            elif token.text == "." and self.is_factor_at(1):
                self.take()
                factors.append(r"\cdot ")
            elif token.text in ("x", "o") and self.is_binary(token):
                self.take()
                factors.append(r"\times " if token.text == "x" else r"\circ ")
            elif self.is_factor() and not self.starts_prose():
                factors.append(r"\," + self.factor())
            else:
                break
        return "".join(factors)

    def denominator_follows(self):
        """Return whether a factor that is no word of a sentence comes after the next token."""
        words = is_word(self.peek(1)) and is_word(self.peek(2))
        return self.is_factor_at(1) and not words and not self.is_spoken_sum(1)

    def is_factor_at(self, ahead):
        """Return whether a factor begins at a token ahead."""
        self.index += ahead
        factor = self.is_factor()
        self.index -= ahead
        return factor

    def is_times(self):
        """Return whether x after words is a product sign."""
        token, following = self.peek(), self.peek(1)
        return (
            token is not None
            and token.text == "x"
            and token.after
            and self.is_factor_at(1)
            and following.text not in ("and", "or", "is")
        )

    def is_binary(self, token):
        """Return whether x or o is a product sign: it is between two operands."""
        return (
            token.before
            and token.after
            and self.is_factor_at(1)
            and not is_word(self.peek(1))
            and self.peek(-1).text not in ("x", "o")
        )

    @staticmethod
    def fraction(above, below):
        """Return a fraction without the brackets that its bar replaces."""
        above, below = (part.removeprefix(r"\,") for part in (above, below))
        lead = r"\," if above != above.lstrip() else ""
        return lead + rf"\frac{{{bare(above)}}}{{{bare(below)}}}"

    def factor(self, below=False):
        """Return one factor with its marks: index, primes, power; or one below a fraction bar."""
        token = self.take()
        if token.text in BRACKETS:
            base = self.bracket(token.text)
        elif token.text == "|":
            self.bars += 1
            inside = self.formula(("|",))
            self.take("|")
            self.bars -= 1
            base = rf"\left|{inside}\right|"
        elif token.kind == "number":
            base = re.sub(r"e([-+]?)0*(\d+)$", r"\\cdot 10^{\1\2}", token.text).replace("{+", "{")
        elif token.text == "sqrt":
            return rf"\sqrt{{{bare(self.factor())}}}"
        elif token.text in ("sum", "int"):
            return self.marked("\\" + token.text)
        elif token.text in FUNCTIONS or token.text in OPERATORS:
            return self.applied(token.text, below or token.text not in ("max", "min"))
        elif is_word(token) and re.match(r"_[a-z]{2}", getattr(self.peek(), "text", "")):
            return rf"\text{{{token.text}{self.take().text}}}"
        else:
            base = letters(token)
        base = self.marked(base)
        while token.kind == "name" and self.applies(0):
            following = self.take().text
            base = self.marked(base + self.bracket(following))
        return base

    def applied(self, name, alone):
        """Return a function with its argument in brackets, or with the next factor alone."""
        known = rf"\{name}" if name in FUNCTIONS else rf"\operatorname{{{name}}}"
        made = self.marked(known)
        if self.applies(0):
            return self.marked(made + self.bracket(self.take().text))
        if alone and self.is_factor() and not self.starts_prose():
            return rf"{made}\,{self.factor()}"
        return made + " "

    def bracket(self, opening):
        """Return the rest of a bracket: a matrix where it holds a semicolon."""
        bars, self.bars = self.bars, 0
        closing = BRACKETS[opening]
        rows = [[]]
        while not self.at(closing):
            stop = (closing, ",", ";") if opening == "[" else (closing,)
            rows[-1].append(self.formula(stop))
            if self.at(";"):
                rows.append([])
            if not self.at(closing):
                self.take()
        self.take(closing)
        self.bars = bars
        if len(rows) > 1:
            body = r"\\".join("&".join(row) for row in rows)
            return rf"\begin{{bmatrix}}{body}\end{{bmatrix}}"
        left, right = (sign.replace("{", r"\{").replace("}", r"\}") for sign in (opening, closing))
        return rf"\left{left}{RELATIONS[','].join(rows[0])}\right{right}"

    def marked(self, base):
        """Return a factor with the marks that follow it."""
        below = above = ""
        while (token := self.peek()) is not None and not token.before:
            if token.kind == "prime":
                above += r"\prime " * len(self.take().text)
            elif token.kind == "subscript":
                below += index_of(self.take().text[1:])
            elif token.kind == "power":
                self.take()
                above += self.power()
            elif token.text == "*" and base != token.text:
                self.take()
                above += "*"
                if self.peek() and self.peek().kind == "name" and not self.peek().before:
                    below += index_of(self.take().text)
            elif token.text == "~" and token.after | (not self.is_factor_at(1)):
                self.take()
                base = rf"\tilde{{{base}}}"
            elif base.endswith("]") and token.text == "x":
                self.take()
                below += r"\times "
            elif token.text == "!" and not token.before:
                self.take()
                base += "!"
            else:
                break
        return (
            base
            + (f"_{{{below}}}" if below else "")
            + (f"^{{{above}}}" if above else "")
            + (" " if base[-1:].isalpha() and not (below or above) else "")
        )

    def power(self):
        """Return an exponent."""
        if self.at("(", "{"):
            opening = self.take().text
            inside = self.bracket(opening)
            single = re.fullmatch(r"\\left\(\w ?\\right\)", inside)
            return inside if single else slashed(bare(inside))
        sign = self.take().text if self.at("-", "+", "*") else ""
        if sign in ("+", "*"):
            return sign
        token = self.take()
        if token.kind == "number":
            if token.text == "1" and self.at("/") and self.peek(1).text == "2":
                self.take()
                return f"{sign}1/{self.take().text}"
            tail = self.peek()
            if tail is not None and tail.kind == "name" and not tail.before:
                return f"{sign}{token.text}{letters(self.take())}"
            return sign + token.text
        if token.kind != "name":
            raise Unreadable(f"{self.source!r}: {token.text!r} is no exponent")
        name = token.text
        short = re.fullmatch(r"[a-z]{2}", name) and name not in GREEK
        return sign + (name if short else letters(token))


def numerator_start(factors, spaced):
    """Return the index of the first factor above a fraction bar.

    The product reaches back to a sum, an integral, an extremum or, without spaces, to another
    fraction; a differential is alone.
    """
    if re.match(r"(?:\\,)?d[A-Za-z\\]", factors[-1]):
        return len(factors) - 1
    stops = (r"\sum", r"\int") if spaced else (r"\sum", r"\int", r"\frac")
    for index in range(len(factors) - 1, -1, -1):
        factor = factors[index].removeprefix(r"\,")
        if factor.startswith(stops) or re.fullmatch(r"\\(max|min)(_\{.*\})? *", factor):
            return min(index + 1, len(factors) - 1)
    return 0


def letters(token):
    """Return the LaTeX of a name: a symbol, a differential, or a word."""
    text = token.text
    if token.kind == "text" or text == "":
        return rf"\text{{{text.strip('`')}}}"
    if text == "inf":
        return r"\infty "
    match = re.fullmatch(rf"(d?)({SYMBOL})(\d*)", text)
    if match is None or (match[1] and match[2] == "So"):
        return rf"\text{{{text}}}"
    if text in GREEK or match[1] == "":
        match = re.fullmatch(rf"()({SYMBOL})(\d*)", text)
    lead, symbol, number = match.groups()
    symbol = symbol_of(symbol)
    return ("d" if lead else "") + symbol + (f"_{{{number}}}" if number else "")


def symbol_of(name):
    """Return the LaTeX of a letter."""
    if name == "So":
        return r"\mathrm{So}"
    if name == "eps":
        return r"\varepsilon "
    return rf"\{name} " if name in GREEK else name


def index_of(text):
    """Return the LaTeX of an index."""
    if text[:1] in "{(":
        groups = re.findall(r"[{(]([^{}()]*)[})]", text)
        inside = [
            group if re.fullmatch("[a-z]{2}", group) else Reader(group).formula()
            for group in groups
        ]
        return inside[0] if len(inside) == 1 else "".join(f"({one})" for one in inside)
    if re.fullmatch(r"\d/\d|\d+", text):
        return text
    parts = []
    for part in re.split(r"([,+])", text):
        match = re.fullmatch(rf"({SYMBOL})(\d*)", part)
        if match and part != "So":
            parts.append(symbol_of(match[1]) + match[2])
        elif re.fullmatch(r"[a-ceijklnqstxyz]{2}", part) and part not in ("at", "is", "in", "it"):
            parts.append(part)
        elif re.fullmatch(r"[,+]|\d+", part):
            parts.append(part)
        else:
            parts.append(rf"\mathrm{{{part}}}")
    return "".join(parts)


def bare(text):
    """Return a formula without the brackets that enclose all of it."""
    if not re.fullmatch(r"\\left(\(.*\\right\)|\[.*\\right\])", text):
        return text
    depth = 0
    for match in re.finditer(r"\\left|\\right(?!arrow)", text.replace(r"\leftarrow", "-" * 10)):
        depth += 1 if match[0] == r"\left" else -1
        if depth == 0 and match.end() < len(text) - 1:
            return text
    return text[6:-7]


def slashed(text):
    """Return an exponent with its fractions on one line."""
    return re.sub(r"\\frac\{([^{}]*)\}\{([^{}]*)\}", in_line, text)


def in_line(match):
    """Return a fraction on one line."""
    above, below = match.groups()
    above = f"({above})" if re.search(r"[-+].*\w", above[1:]) else above
    return f"{above}/{below}"


def latex(text):
    """Return the LaTeX of a formula in plain notation."""
    reader = Reader(text)
    made = reader.formula()
    if reader.peek() is not None:
        raise Unreadable(f"{text!r}: {reader.peek().text!r} is left over")
    return made


def mathml(formula, display=False):
    """Return the MathML of a formula in LaTeX, inside a line or on lines of its own."""
    made = convert(formula, display="block" if display else "inline")
    made = made.replace("<mo>&#x02202;</mo>", "<mi>&#x02202;</mi>")
    made = re.sub(r"(<mi>(?:exp|ln|lg|sin|cos|tan)</mi>)(?=<m[ins])", rf"{SPACE}\1{SPACE}", made)
    return made.replace(' xmlns="http://www.w3.org/1998/Math/MathML"', "", 1)


def pieces(text):
    """Return the HTML of a chunk of an equation: words as text, formulas as MathML."""
    reader = Reader(text)
    made, formula = [], ""

    def flush():
        nonlocal formula
        if formula.strip():
            body = mathml(formula, display=True)
            made.append(body.replace('display="block"', 'display="inline" displaystyle="true"'))
        formula = ""

    for part, prose in reader.terms():
        if prose:
            flush()
            made.append(html.escape(part.replace("`", "")))
            continue
        if not formula and made and not made[-1].endswith("</math>") and part[0] in ",;:.":
            made[-1] += part[0]
            continue
        breaks = part.strip() in ("=", "+", "-", r"\leftarrow", r"\to", r"\le", r"\sim")
        if breaks and len(text) > 50 and formula:
            flush()
            formula = "{}"
        formula += part
        if part.startswith((",", ";", ":")):
            flush()
    flush()
    if reader.peek() is not None:
        raise Unreadable(f"{text!r}: {reader.peek().text!r} is left over")
    return " ".join(made).replace("> .", ">.")


def rows(text):
    """Return the rows of an equation, each a list of chunks that three spaces set apart."""
    lines = text.split("\n")
    label, space, first = re.match(r"(Eq\. \([A-Z]\d+[a-z]?\):)(\s*)(.*)", lines[0]).groups()
    base = len(label) + len(space)
    made = [first]
    for line in lines[1:]:
        indent = len(line) - len(line.lstrip())
        before = made[-1]
        unbalanced = sum(before.count(sign) for sign in "([{") > sum(
            before.count(sign) for sign in ")]}"
        )
        word = is_word(first_token(line))
        headed = re.match(r"\s*[\w ]+:\s", line)
        continues = word and not headed and (indent > base + 5 or ends_in_word(before))
        if (
            continues
            or unbalanced
            or before.endswith(("=", "+", " -"))
            or re.match(r"\s*[-+=/](?!\S*:)\s", line)
        ):
            made[-1] = f"{before} {line.strip()}"
        else:
            made.append(line.strip())
    return [re.split(r"\s{3,}|(?<=,)\s{2,}", row) for row in made]


def first_token(line):
    """Return the first token of a line."""
    return tokens_of(line)[0]


def ends_in_word(line):
    """Return whether a line ends with a word."""
    *others, last = tokens_of(line)
    return is_word(last) or (last.text == "a" and bool(others) and is_word(others[-1]))


def rendered(text):
    """Return the HTML of an equation of a docstring, its label included."""
    made = []
    for row in rows(text):
        chunks = "".join(f"<span>{pieces(chunk)}</span>" for chunk in row if chunk)
        made.append(f"<div>{chunks}</div>")
    return "".join(made)
