"""HTML pages without external files: templates, scripts, libraries and data in one file."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader

from ..fmi.quantities import short
from .figures import PALETTE
from .maps import STYLE
from .packing import packed
from .pictures import PALETTE_DARK
from .words import entry_in_words

TEMPLATES = Path(__file__).parent / "templates"
LIBRARIES = ("d3.min.js", "plot.min.js")
"""Released files of D3 and Observable Plot in templates/vendor, in the order of their use."""


def value_in_words(value: float, unit: str) -> str:
    """Return a value with a handy unit; angles in degrees."""
    return f"{np.degrees(value):.4g} deg" if unit == "rad" else short(value, unit)


def with_sign(value: Any) -> Any:
    """Return a value of a template; in texts, the sign of uncertainties replaces its ASCII form."""
    return value.replace(" +- ", " \N{PLUS-MINUS SIGN} ") if isinstance(value, str) else value


def write_page(path: Path, template: str, data: dict[str, Any], **content: Any) -> Path:
    """Write a page from a template.

    Parameters
    ----------
    path : Path
    template : str
        Name of a file in templates.
    data : dict
        Data that the scripts of the page draw.
    **content
        Values of the template.
    """
    loader = FileSystemLoader(TEMPLATES)
    templates = Environment(loader=loader, autoescape=True, finalize=with_sign)
    templates.filters |= {"entry": entry_in_words, "words": value_in_words}
    libraries = b"\n".join((TEMPLATES / "vendor" / name).read_bytes() for name in LIBRARIES)
    colours = {"palette": PALETTE, "palette_dark": PALETTE_DARK, "style": STYLE}
    text = templates.get_template(template).render(
        data=json.dumps(data | colours).replace("<", "\\u003c"),
        libraries=packed(libraries),
        **content,
    )
    path.write_text(text, encoding="utf-8")
    return path
