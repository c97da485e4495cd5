"""Documentation inside an FMU: a page with requirements and interface, and licences."""

from collections.abc import Sequence
from html import escape
from importlib.metadata import files
from pathlib import Path

from .description import AUTHOR, COPYRIGHT, LICENCE
from .requirements import PACKAGES
from .slave import FieldSlave
from .variables import END, Variable

OWN_LICENCE = Path(__file__).parents[2] / "LICENSE"
ICON = Path(__file__).parent / "icon.png"
"""Drawn by docs/icon.py."""

PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font: 15px/1.5 sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; }}
table {{ border-collapse: collapse; }}
th, td {{ border-bottom: 1px solid #ccc; padding: 0.2em 0.8em 0.2em 0; text-align: left; }}
</style>
</head>
<body>
<h1>{title}</h1>
<p>{description}. By {author}, licence {licence}.</p>
<h2>Requirements</h2>
<p>{needs}</p>
<h2>Steps</h2>
<p>The usual step is {step:g} s. {inputs} If a step cannot be
solved, the FMU discards it, logs the reason and does not change its state. States can be saved,
restored and serialised.</p>
{tables}
</body>
</html>
"""

OF_PYTHON = """The FMU requires {hosts}, and Python 3.11 or newer with {packages}. If the host is
not Python, the FMU starts the Python of the environment variable PISTON_COSIM_PYTHON. The next
choices are that of VIRTUAL_ENV, the one that last built such an FMU on the machine, and python3. If
the host is a Python without the packages, they are those of PISTON_COSIM_PYTHON of the same
version. At
the first start the FMU compiles its code for about a minute and logs it. All FMUs of the same code
share the compiled code in PISTON_COSIM_CACHE or in the user's cache."""

OF_ITSELF = """The FMU runs in any host on {platforms}. It is machine code and needs no Python. At
its start it rejects choices of physics that it does not support, with a message."""

READS_ENDS = f"""Inputs of a step are values at the {END}. If an importer sets them at the
beginning, put the rows of its input tables one step earlier."""

EXTRAPOLATES = """ An importer that knows only those at its beginning also sets their derivatives
(fmi2SetRealInputDerivatives). The FMU then extrapolates them to the end."""

TITLES = {
    "input": "Inputs",
    "output": "Outputs",
    "parameter": "Parameters",
    "constant": "Constants",
}


def documentation(
    slave: FieldSlave, version: str, any_host: bool, platforms: Sequence[str] = ()
) -> dict[str, bytes]:
    """Return page and licences, path in the FMU to bytes.

    Parameters
    ----------
    slave : FieldSlave
    version : {"2.0", "3.0"}
    any_host : bool
        Whether the FMU runs in hosts that are not Python.
    platforms : sequence of str
        Platforms of an FMU that needs no Python.
    """
    needs = (
        OF_ITSELF.format(platforms=", ".join(platforms))
        if platforms
        else OF_PYTHON.format(
            hosts="any host on Linux x86-64" if any_host else "a host that is Python",
            packages=", ".join(PACKAGES),
        )
    )
    page = PAGE.format(
        title=escape(slave.name),
        description=escape(slave.description or ""),
        author=escape(AUTHOR),
        licence=LICENCE,
        needs=needs,
        step=slave.experiment.step,
        inputs=_of_inputs(slave, any_host and version == "2.0"),
        tables="\n".join(_table(slave.table, causality) for causality in TITLES),
    )
    licences = {"license.txt": f"{COPYRIGHT}\n\n{OWN_LICENCE.read_text()}"}
    if not platforms:
        licences |= _of_pythonfmu()
    return {"documentation/index.html": page.encode()} | {
        f"documentation/licenses/{name}": text.encode() for name, text in licences.items()
    }


def _of_inputs(slave: FieldSlave, extrapolates: bool) -> str:
    """Return when a step reads its inputs."""
    if slave.interpolates_inputs:
        return "The FMU interpolates its inputs by their derivatives at the beginning of a step."
    return READS_ENDS + EXTRAPOLATES * extrapolates


def _of_pythonfmu() -> dict[str, str]:
    """Return the licence of pythonfmu, a part of which is inside the FMU."""
    for file in files("pythonfmu") or ():
        if file.name.startswith("LICEN"):
            return {"pythonfmu.txt": file.read_text()}
    return {}


def _table(table: Sequence[Variable], causality: str) -> str:
    """Return the HTML table of the variables of a causality, empty if there are none."""
    rows = [_row(v) for v in table if v.causality == causality]
    if not rows:
        return ""
    heads = "".join(
        f"<th>{head}</th>" for head in ("name", "shape", "unit", "start", "range", "meaning")
    )
    body = "\n".join(rows)
    return f"<h2>{TITLES[causality]}</h2>\n<table>\n<tr>{heads}</tr>\n{body}\n</table>"


def _row(v: Variable) -> str:
    start = f"{v.start:g}" if isinstance(v.start, int | float) else v.start
    bounds = ["" if limit is None else f"{limit:g}" for limit in (v.minimum, v.maximum)]
    limits = " to ".join(bounds) if any(bounds) and v.causality != "constant" else ""
    shape = " x ".join(map(str, v.shape))
    unit = "" if v.unit == "1" else v.unit
    start = "" if v.causality == "output" else start
    limits = ", ".join(f"{k} {name}" for k, name in enumerate(v.choices, 1)) or limits
    cells = (v.name, shape, unit, start, limits, v.description)
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"
