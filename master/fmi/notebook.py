"""HTML tables by which objects appear in notebooks."""

from collections.abc import Mapping
from html import escape

LEFT = ' style="text-align: left"'


def html_table(title: str, rows: Mapping[str, object]) -> str:
    """Return a table with a caption and a row for each entry."""
    cells = "".join(
        f"<tr><th{LEFT}>{escape(name)}</th><td{LEFT}>{escape(str(value))}</td></tr>"
        for name, value in rows.items()
    )
    return f"<table><caption{LEFT}>{escape(title)}</caption>{cells}</table>"
