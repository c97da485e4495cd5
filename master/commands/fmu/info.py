"""`piston-cosim fmu info`."""

from pathlib import Path
from typing import Annotated
from zipfile import ZipFile

from cyclopts import Parameter
from rich.table import Table

from ...case.keys import range_of
from ...case.wires import TUNABLE, kind_of
from ...fmi.variables import END
from ...participants.open import open_fmu
from ..common import print_line, wide_console

ORDER = ("input", "output", "parameter", "structuralParameter", "calculatedParameter", "local")
"""Causalities in the order of the table."""
WIDTH = 100
"""Characters in a line of names."""


def command(
    fmu: Path,
    /,
    *,
    all_: Annotated[bool, Parameter(name="--all")] = False,
):
    """Print the interface of an FMU.

    The command prints what to connect, what to set, the step and the author.

    Example: piston-cosim fmu info film.fmu --all

    Parameters
    ----------
    fmu
        File of the FMU, FMI 2.0 or 3.0.
    all_
        Print a table of all variables with units, start values and ranges.
    """
    participant = open_fmu("fmu", fmu)
    if all_:
        print_table(sorted(participant.fields.values(), key=_order))
        return
    for line in summary(participant, fmu):
        print_line(line, markup=False)


def _order(field):
    return ORDER.index(field.causality) if field.causality in ORDER else len(ORDER)


def summary(participant, fmu):
    """Yield the most important properties of the FMU, about ten lines."""
    model = participant.description
    fields = participant.fields.values()
    yield f"{model.modelName}, FMI {model.fmiVersion}: {model.description or 'no description'}"
    origin = [model.author, model.generationTool, model.generationDateAndTime, model.license]
    yield f"made by    {', '.join(filter(None, origin)) or 'not stated'}"
    with ZipFile(fmu) as archive:
        names = sorted({n.split("/")[1] for n in archive.namelist() if n.startswith("binaries/")})
    yield f"runs on    {', '.join(filter(None, names)) or 'no platform: it has no binaries'}"
    usual = model.defaultExperiment
    step = usual and usual.stepSize and f"{float(usual.stepSize):g} s"
    stop = usual and usual.stopTime and f", default stop time {float(usual.stopTime):g} s"
    yield f"step       {step or 'not stated'}{stop or ''}"
    abilities = {
        "save and restore state": participant.can_redo,
        "serialise state": participant.can_serialise,
        "directional derivatives": participant.has_derivatives,
    }
    shown = (f"{name}: {'yes' if able else 'no'}" for name, able in abilities.items())
    yield f"abilities  {', '.join(shown)}"
    inputs = [f for f in fields if f.causality == "input"]
    if any(END in field.description for field in inputs):
        derivatives = getattr(model.coSimulation, "canInterpolateInputs", False)
        known = "; input derivatives extrapolate them to it" if derivatives else ""
        yield f"inputs     values at the {END}{known}"
    for head, causality in (("connect", "input"), ("", "output"), ("set", "parameter")):
        yield f"{head:10s} {_listed([f for f in fields if f.causality == causality], causality)}"
    if tunable := [f for f in fields if kind_of(f) == TUNABLE]:
        yield f"{'feed':10s} {_listed(tunable, TUNABLE)}"
    yield "details    --all prints all variables"


def _listed(fields, causality):
    """Return the number of variables and as many names with units as fit in a line."""
    text = f"{len(fields)} {causality}{'' if len(fields) == 1 else 's'}"
    for k, field in enumerate(fields):
        unit = "" if field.unit in ("", "1") else f" [{field.unit}]"
        shape = f" ({'x'.join(map(str, field.shape))})" if field.shape else ""
        part = f"{', ' if k else ': '}{field.name}{shape}{unit}"
        if len(text) + len(part) > WIDTH:
            return f"{text}, {len(fields) - k} more"
        text += part
    return text


def _start_of(field):
    """Return the start value as text, without the round-off of a real number."""
    if field.type == "Real" and field.start:
        return " ".join(f"{float(number):.12g}" for number in field.start.split())
    return field.start or ""


def print_table(fields):
    """Print variables as a table."""
    table = Table(
        "causality", "name", "shape", "unit", "start", "allowed", "nominal", "description", box=None
    )
    table.columns[1].no_wrap = True  # a name in two lines cannot be copied
    for field in fields:
        table.add_row(
            kind_of(field),
            field.name,
            "x".join(map(str, field.shape)),
            field.unit,
            _start_of(field),
            ", ".join(f"{k} {name}" for name, k in field.choices.items()) or range_of(field),
            "" if field.nominal is None else f"{field.nominal:g}",
            field.description,
        )
    wide_console(broken=False).print(table, soft_wrap=True)
