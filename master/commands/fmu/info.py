"""`piston-cosim fmu info`."""

from pathlib import Path

from rich.table import Table

from ...fmi.errors import BadInput
from ...participants.open import open_fmu
from ..common import console, wide_console


def command(fmu: Path):
    """Print what an FMU offers: capabilities, parameters with ranges, inputs, outputs.

    Example: piston-cosim fmu info film.fmu

    Parameters
    ----------
    fmu
        An FMI 2.0 or 3.0 FMU.
    """
    if not fmu.is_file():
        raise BadInput(f"{fmu}: no such file")
    participant = open_fmu("fmu", fmu)
    model = participant.description
    console.print(f"[bold]{model.modelName}[/]  FMI {model.fmiVersion}  {model.description or ''}")
    console.print(
        f"save and restore state: {participant.can_redo}   "
        f"serialise: {participant.can_serialise}   "
        f"directional derivative: {participant.has_derivatives}"
    )
    table = Table(
        "causality", "name", "shape", "unit", "start", "allowed", "nominal", "description", box=None
    )
    table.columns[1].no_wrap = True  # a name that is cut is none
    for field in sorted(
        participant.fields.values(),
        key=lambda f: ("parameter", "input", "output", "local").index(f.causality),
    ):
        table.add_row(
            field.causality,
            field.name,
            "x".join(map(str, field.shape)),
            field.unit,
            field.start or "",
            _allowed(field),
            "" if field.nominal is None else f"{field.nominal:g}",
            field.description,
        )
    wide_console(broken=False).print(table, soft_wrap=True)


def _allowed(field):
    """Range of a variable as text, an open end empty."""
    if field.minimum is None and field.maximum is None:
        return ""
    return "..".join("" if x is None else f"{x:g}" for x in (field.minimum, field.maximum))
