"""Case files: search and TOML tree."""

import re
import tomllib
from collections.abc import Iterable
from os.path import relpath
from pathlib import Path
from typing import Any

from ...models import MODELS
from ..fmi.errors import BadInput, file_fault, near
from .changes import changed
from .composed import expanded, extended


def case_names():
    """Return the names of the installed cases: folders of `models` with a case.toml."""
    return sorted(p.name for p in MODELS.iterdir() if (p / "case.toml").is_file())


def find_case(name: str, folder: Path = Path()) -> Path:
    """Return the path of a case file, from its path, its folder or an installed case's name.

    Relative paths start from `folder`.
    """
    for candidate in (folder / name, folder / name / "case.toml", MODELS / name / "case.toml"):
        if candidate.is_file():
            return candidate.resolve()
    known = case_names()
    question = near(Path(name).name, known) or "; `piston-cosim list` lists the cases"
    raise BadInput(
        f"case: expected a file, a folder with case.toml or the name of a case, "
        f"got {name!r}{question}"
    )


def name_of_case(path: Path) -> str:
    """Return the name of a case: its folder, or its file if that is not case.toml."""
    return path.parent.name if path.name == "case.toml" else path.stem


def read_tree(path: Path, changes: Iterable[tuple[str, Any]] = ()) -> dict[str, Any]:
    """Return the TOML tree of a case or SSP with `changes` (pairs of dotted key and value).

    Raises `BadInput` for a file that is not TOML, and for every change that cannot be made.
    """
    return changed(expanded(_read(Path(path))), changes, Path(path).parent)


def _read(path, extending=()):
    """Return the tree of a file; `extending` are the files of the cases that extend it."""
    try:
        if path.suffix == ".ssp":
            from .ssp import read_ssp  # slow to import

            return read_ssp(path)
        text = path.read_text(encoding="utf-8-sig")
        tree = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{path}, {_toml_fault(error, text)}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(file_fault(path, error)) from None
    if "extends" not in tree:
        return tree
    home = find_case(str(tree["extends"]), path.parent)
    if home in (extending := (*extending, path.resolve())):
        raise BadInput(f"extends: expected another case, got {tree['extends']!r}")
    place = relpath(home.parent, path.resolve().parent)
    return extended(_read(home, extending), tree, place, path.parent)


LONGEST_LINE = 60
"""Maximum number of characters of a line of a file in a message."""


def _toml_fault(error: tomllib.TOMLDecodeError, text: str) -> str:
    """Return the fault of a text that is not TOML, with its line."""
    place = re.search(r"line (\d+)", str(error))
    lines = text.splitlines() or [""]
    number = min(int(place[1]), len(lines)) if place else len(lines)
    line = lines[number - 1].strip()[:LONGEST_LINE]
    if re.match("Cannot (overwrite|declare|mutate)", str(error)):
        return f"line {number}: expected each key and table once, got {line!r} a second time"
    return f"line {number}: expected KEY = VALUE with texts in quotes, got {line!r}"
