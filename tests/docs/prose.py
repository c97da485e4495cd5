"""Check prose against the project's rules for plain English.

`python tests/docs/prose.py FILE...` prints the findings of Markdown files. A sentence has a verb,
at most 25 words, at most one pair of brackets, no chain of semicolons, and no word of `AVOID`.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

from markdown_it import MarkdownIt

WORDS = 25
"""Largest number of words in a sentence or a table cell. Code or an equation is one word."""

AVOID = {
    r"\brefus(ed|e|es|al)\b": "rejects, is not supported, raises",
    r"\bsaid (no|yes)\b|\bsays (no|yes|so|which|where|why)\b": "reports, rejects",
    r"\b(is|are|was|were) (said|told)\b|\btells\b|\btold\b": "reports, prints, shows",
    r"\bwith(out)? (a|one) word\b|\ba word (of|is)\b": "message, report",
    r"\bmade (anew|again)\b|\banew\b": "rebuilt, recomputed",
    r"\bstands? (in|at|on|for itself|beside|next to|there)\b|\blies? (in|at|beside|there)\b": "is",
    r"\bone text\b": "one implementation",
    r"\bin (its|their) place\b|\bin place of\b": "instead of, replaces",
    r"\bnothing of (its|their) own\b": "omit, or: separately",
    r"\b(of|on) (its|their) own\b": "separate, its own X",
    r"\bslaves?\b": "model class, FMU",
    r"\bbeside\b": "next to, compared with, side by side",
    r"\bworth\b": "accuracy, useful",
    r"\bverdicts?\b": "check: pass, warning, fail",
    r"\bhouse\b|\brooms?\b": "package, folder",
    r"\bmarch(es|ed|ing)?\b": "advances in time",
    r"\bheard\b|\bhears?\b": "receives",
    r"\bnamed? (so|thus)\b|\bby name alone\b": "state the name",
    r"\b(comes?|came) from nowhere\b|\bfrom nowhere\b": "spurious energy",
    r"\bas (it|they) (stands?|lies?)\b": "unchanged",
    r"\bone to one\b|\bto the letter\b": "exactly",
    r"\b(where|if) it is not given\b|\bwithout it\b": "if omitted",
    r"\bwhat is (kept|given|offered|asked)\b": "name the subject",
    r"\bto the bit\b": "bit for bit",
    r"\bby far\b|\bof course\b|\bsimply\b|\bjust\b|\beasily\b": "omit",
    r"\bred checks?\b|\bgreen checks?\b|\bamber\b": "failed check, passed check, warning",
}
"""Pattern that plain text avoids -> what to write instead."""

FRAGMENT = re.compile(
    r"(Of (a|an|the|what|those|each|it|them|which)|Those (of|that)|What (?![^.]*\?)|Nothing of"
    r"|Without it|With it,|That (a|an|the) )\b"
)

VERBS = frozenset(
    """accept access account act adapt add adjust advance affect agree allow appear apply
    approach approximate ask assume attach average avoid balance base be become begin bend
    bring build cache calculate call cancel carry cause cavitate change check choose cite
    clamp clear click close come compare compile complete comply compute conserve consider
    consist contain continue control converge convert copy correspond cost count couple
    cover create cut damp deal decide declare decrease define deflect deform deliver depend
    derive describe detect determine deviate differ dip disable disagree discard display
    divide do document download draw drive drop edit enable end ensure enter equal estimate
    evaluate exceed exchange execute exist exit expand expect explain export express extend
    extract fail fall fill find finish fit fix float flow follow form fulfil gain generate
    get give go group grow handle happen have help hold ignore implement import improve
    include increase indicate inherit initialise initialize inspect install integrate
    interpolate introduce involve iterate join keep know lack lead learn leave let lift
    limit link list load lock look lose lower lubricate make mark match matter mean measure
    meet miss model modify mount move multiply need neglect normalise note number obey
    obtain occur offer omit open operate order overlap override own pass pay perform permit
    place plot point possess predict press prevent print process produce project propagate
    prove provide publish put raise reach react read receive recommend recompute record
    reduce refer reject relate relax release rely remain remember remove repeat replace
    report represent reproduce request require resolve respect respond rest restart restore
    restrict result retry return reuse rise rock rotate round run satisfy save say scale
    score search see select send separate serve set share shift show shrink simulate skip slap
    slide slip solve specify speed split squeeze start state stay stop store subtract
    succeed sum support suppress surface surround switch take tend test thin tilt transfer
    translate transmit treat try turn type unload update use validate vanish vary verify
    view wait want warm warn wear weigh work write yield""".split()
)
IRREGULAR = frozenset(
    """is are was were am been has had does did can could may might must shall should will
    would cannot goes went came became began bent brought built chose chosen cost cut drew
    drawn fell fallen found gave given gone got grew grown held kept knew known led left let
    lost made meant met needn't paid put ran read rose run said saw seen sent set showed
    shown split spoke stood stopped took taken thought told wrote written don't doesn't
    isn't""".split()
)


def is_verb(word: str) -> bool:
    """Return whether the word is a verb of the list, in its base, third-person or past form."""
    if word in IRREGULAR or word in VERBS:
        return True
    stems = [word[:-1], word[:-2], word[:-3] + "y", word[:-3]]
    return word.endswith(("s", "ed")) and any(stem in VERBS for stem in stems)


def faults(sentence: str) -> Iterator[str]:
    """Yield what is wrong with one sentence."""
    words = re.findall(r"[^\s]*\w[^\s]*", sentence)
    if len(words) > WORDS:
        yield f"{len(words)} words"
    if len(re.findall(r"\((?!s\))", sentence)) > 1:
        yield "more than one pair of brackets"
    if sentence.count(";") > 1:
        yield "chain of semicolons"
    for pattern, instead in AVOID.items():
        for match in re.finditer(pattern, sentence, re.IGNORECASE):
            yield f"'{match[0]}': write {instead}"


def is_fragment(sentence: str) -> bool:
    """Return whether a sentence of a paragraph lacks a verb or begins like a fragment."""
    words = re.findall(r"[a-z]+(?:'t)?", sentence.lower())
    return bool(FRAGMENT.match(sentence)) or (len(words) > 3 and not any(map(is_verb, words)))


def sentences(text: str) -> list[str]:
    """Split a paragraph at the ends of its sentences; abbreviations do not end one."""
    text = re.sub(
        r"\b(Eqs?|Figs?|Tab|Sec|vol|pp?|no|e\.g|i\.e|cf|approx|et al|vs)\. ", r"\1 ", text
    )
    return [part.strip() for part in re.split(r"(?<=[.!?:])\s+(?=[^a-z])", text) if part.strip()]


def inline(token) -> str:
    """Return the text of an inline token, with each code span or image as one word."""
    parts = []
    for child in token.children or []:
        if child.type in ("text", "html_inline"):
            parts.append(child.content if child.type == "text" else "")
        elif child.type == "code_inline":
            parts.append("CODE")
        elif child.type in ("softbreak", "hardbreak"):
            parts.append(" ")
    return re.sub(r"\$\$?[^$]*\$\$?", "EQUATION", "".join(parts)).strip()


def of_markdown(text: str) -> Iterator[tuple[int, str, str]]:
    """Yield (line, fault, sentence) for paragraphs, lists, headings and tables of Markdown."""
    inside, line = [], 0
    for token in (
        MarkdownIt("commonmark")
        .enable("table")
        .parse(re.sub(r"\A---\n.*?\n---\n", "", text, flags=re.DOTALL))
    ):
        if token.nesting == 1:
            inside.append(token.type)
        elif token.nesting == -1:
            inside.pop()
        if token.map:
            line = token.map[0] + 1
        if token.type != "inline":
            continue
        prose = "list_item_open" not in inside and inside[-1] == "paragraph_open"
        for sentence in sentences(inline(token)):
            for fault in faults(sentence):
                yield line, fault, sentence
            if prose and sentence.endswith(".") and is_fragment(sentence):
                yield line, "no verb, or a fragment", sentence


def of_text(text: str, *, prose: bool = False) -> Iterator[tuple[str, str]]:
    """Yield (fault, sentence) for plain text, such as a message or the description of an option."""
    text = re.sub(r"`[^`]*`", "CODE", " ".join(text.split()))
    for sentence in sentences(text):
        for fault in faults(sentence):
            yield fault, sentence
        if (prose and sentence.endswith(".") and is_fragment(sentence)) or FRAGMENT.match(sentence):
            yield "no verb, or a fragment", sentence


def main(paths: list[str]) -> int:
    """Print the findings of the files and return 1 if there are any."""
    count = 0
    for path in paths:
        for line, fault, sentence in of_markdown(Path(path).read_text()):
            print(f"{path}:{line}: {fault} | {sentence}")
            count += 1
    print(f"{count} findings in {len(paths)} files")
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
