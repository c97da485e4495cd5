"""Preview of a lubrication FMU from its build options and parameters."""

from collections.abc import Mapping
from math import inf
from pathlib import Path
from typing import Any

from ..master.fmi.errors import BadInput
from ..master.fmi.preview import Figure, Preview
from ..master.fmi.quantities import short
from .build import prepare
from .laws.oil import Oil
from .options import BuildOptions
from .parameters import faults, parameters_of


def preview(options: Mapping[str, Any], parameters: Mapping[str, Any], folder: Path) -> Preview:
    """Return derived figures and faults of build options and parameters.

    Parameters
    ----------
    options : mapping
        From the case file.
    parameters : mapping
        Parameters of the case by name: numbers in SI, laws by their names, None if a value is
        invalid. The others have their defaults. If one is None, no contradictions are checked.
    folder : Path
        Folder of the case.

    Returns
    -------
    Preview
        Size of a cell, roughness, viscosity, and contradictions between parameters.
    """
    try:
        built = BuildOptions.read(prepare(options, folder, lambda line: None)[0])
    except BadInput as error:
        return Preview(faults=error.faults)
    valid = {name: value for name, value in parameters.items() if value is not None}
    numbers = {**built.oil, **valid}
    film = parameters_of(
        numbers, shape=built.grid, open_cells=built.open_cells, surface=built.surface
    )
    around, along = built.grid
    figures = [
        Figure("cell", "cell_around", film.sector_angle * film.bore_radius / around, "m"),
        Figure("cell", "cell_along", film.skirt_length / along, "m"),
        Figure("surface", "roughness_rms", film.roughness_rms, "m"),
    ]
    if film.oil.viscosity_law == "constant":
        figures.append(Figure("oil", "viscosity", film.oil.viscosity, "Pa.s"))
    if built.open_cells is not None:
        share = 1.0 - float(built.open_cells.mean())
        figures.append(Figure("cell", "film_share", share, "1", "cells of the mask with a film"))
    remarks: list[str] = []
    if not film.roughness_rms:
        remarks.append("roughness_rms = 0 \N{MICRO SIGN}m: smooth surfaces, which never touch")
    if "oil_temperature" in built.inputs and film.oil.viscosity_law == "constant":
        remarks.append("viscosity_law = 'constant': the oil temperature has no effect")
    contradictions = faults(film) if valid == parameters else []
    warnings = _without_effect(parameters, film.oil, options.get("oil"))
    warnings += [
        f"{one.name} = {short(one.value, one.unit)}: expected {short(low, one.unit)} to "
        f"{short(high, one.unit)} in engines; check its unit"
        for one in figures
        for low, high in [USUAL.get(one.name, (-inf, inf))]
        if not low <= one.value <= high
    ]
    return Preview(figures, contradictions, warnings, remarks)


USUAL = {"roughness_rms": (0.0, 10e-6), "viscosity": (0.5e-3, 2.0)}
"""Usual values by figure [m], [Pa.s]. The limits are our choice, far from those of engines."""
LAWS = {
    "viscosity": "constant",
    "vogel_viscosity": "vogel_1921",
    "vogel_b": "vogel_1921",
    "vogel_c": "vogel_1921",
    "walther_a": "walther_1931",
    "walther_m": "walther_1931",
    "viscosity_40": "two_point",
    "viscosity_100": "two_point",
}
"""Viscosity law that uses a parameter."""


def _without_effect(parameters: Mapping[str, Any], oil: Oil, name: str | None) -> list[str]:
    """Return a warning for each given parameter that the viscosity law does not use."""
    law = oil.viscosity_law
    of_oil = f" of the oil {name!r}" if name else ""
    return [
        f"{key}: no effect with viscosity_law = {law!r}{of_oil}; remove it, or set "
        f"viscosity_law = {LAWS[key]!r}"
        for key in parameters
        if key in LAWS and LAWS[key] != law
    ]
