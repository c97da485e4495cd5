"""Rows of separated text files, as spreadsheets of all countries write them."""

import csv
import re
from pathlib import Path

SEPARATORS = "\t;,"
"""Separators of columns. That of a file is the first of them in its last row of numbers; default:
blanks.
"""
FIRST_NUMBER = re.compile(r'\s*["+-]*[\d.,]+\S*?[\s;,]+\S')
"""Begin of a row of several numbers."""
BLANKS = re.compile(r"\s+(?!\[|[^\[\]]*\])")
"""Blanks between columns, which are not those of a unit in brackets."""
DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*")


def read_rows(path: Path | str) -> list[tuple[int, list[str]]]:
    """Return number and cells of each row that is neither empty nor a comment with #.

    Columns are separated by tabs, semicolons, commas or blanks. A decimal comma becomes a point if
    the columns have another separator. A byte-order mark is ignored.

    Raises
    ------
    OSError, UnicodeDecodeError
        If the file cannot be read; `errors.file_fault` returns their sentences.
    """
    lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    used = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and line.strip()[0] != "#"]
    whole = [line for _, line in used]
    last = "".join(([line for line in whole if FIRST_NUMBER.match(line)] or whole)[-1:])
    separator = next((one for one in SEPARATORS if one in last), None)
    if separator is None:
        rows = [BLANKS.split(line.strip()) for _, line in used]
    else:
        rows = list(csv.reader([line for _, line in used], delimiter=separator))
    if separator != ",":
        rows = [[_with_point(cell) for cell in row] for row in rows]
    return [(n, row) for (n, _), row in zip(used, rows)]


def _with_point(cell: str) -> str:
    """Return a number with a decimal comma as one with a point, any other text unchanged."""
    return cell.replace(",", ".") if DECIMAL_COMMA.fullmatch(cell) else cell
