"""Second grid of a case, with fewer cells in every film that allows it."""

from copy import deepcopy
from math import ceil, sqrt
from typing import Any, NamedTuple

from ..case.contract import interface, players
from ..fmi.errors import BadInput
from ..fmi.quantities import times

COARSENING = sqrt(2.0)
"""Cells of the grid over those of the second one, in each direction."""
GRID_SAFETY = 3.0
"""Factor of safety on the difference between two grids [Roache1994]. If their ratio is 1.41, it is
the factor of an order of 2 with the safety 3, and that of an order of 1 with the safety 1.25."""


FEWEST_CELLS = 6
"""Fewest cells of a direction that a second grid can have fewer of: it has at least 4."""


class Surface(NamedTuple):
    """Surface of a film: the participant of its body, and the prefix of its fields there."""

    body: str
    prefix: str


def coarser(tree: dict[str, Any]) -> dict[str, Any]:
    """Return the tree with fewer cells in all films but `kept_films`, an even number around.

    Raises `BadInput` if a film has no grid or few cells, or if all of them keep theirs.
    """
    coarser = deepcopy(tree)
    tables = coarser["participants"]
    films, unrefined, ratio = players(tree, "lubrication"), kept_films(tree), ratio_of(tree)
    lacking = [name for name in films if "grid" not in tables[name].get("build", {})]
    if lacking or not films:
        got = (
            f"none in {', '.join(lacking)}" if lacking else 'no participant with role "lubrication"'
        )
        raise BadInput(f"expected films with build.grid, got {got}")
    if {*films} <= unrefined:
        raise BadInput("expected a film on the grid of its body without build.mask, got none")
    for name, table in tables.items():
        build = table.get("build", {})
        if "grid" in build and name not in unrefined:
            if min(build["grid"]) < FEWEST_CELLS:
                raise BadInput(
                    f"{name}.build.grid: expected at least {FEWEST_CELLS} cells in each direction, "
                    f"got {build['grid']}"
                )
            build["grid"] = [max(4, 2 * round(n / ratio / 2)) for n in build["grid"]]
    for body, build in _banded(tree).items():
        _scale_bands(coarser, body, build["grid"][1])
    return coarser


def _scale_bands(made, body, rows):
    """Give the film surfaces of a body, and their films, the rows of its second grid."""
    tables = made["participants"]
    build = tables[body]["build"]
    fewer = build["grid"][1] = fitting_rows(rows, _edges(build))
    of_surface = {_surface(made, film): film for film in players(made, "lubrication")}
    for band in build["film_surfaces"]:
        below, last = band["rows"][0] - 1, band["rows"][1]
        first, end = round(below * fewer / rows), round(last * fewer / rows)
        band["rows"] = [first + 1, end]
        film = tables.get(of_surface.get(Surface(body, f"{band['name']}.")), {})
        if "skirt_length" in film.get("parameters", {}):
            longer = (end - first) / fewer * rows / (last - below)
            parameters = film["parameters"]
            parameters["skirt_length"] = times(parameters["skirt_length"], longer)
            film["build"]["grid"][1] = end - first


def fitting_rows(rows: int, edges: list[int]) -> int:
    """Return the rows of the second grid, 0.5 to 0.8 of `rows`, that are nearest to all edges."""

    def misfit(count):
        error = max(abs(edge * count / rows - round(edge * count / rows)) for edge in edges)
        return round(error, 3), abs(rows / count - COARSENING)

    return min(range(ceil(rows / 2), int(rows / 1.25) + 1), key=misfit)


def kept_films(tree: dict[str, Any]) -> set[str]:
    """Return the films that keep their cells, and the bodies whose grid they have.

    A mask has one entry per cell, and shells of pin and crank have separate grids.
    """
    tables, films = tree["participants"], players(tree, "lubrication")
    surfaces = {film: _surface(tree, film) for film in films}
    masked = {film for film in films if tables[film].get("build", {}).get("mask", "none") != "none"}
    separate = {film for film in films if _has_separate_grid(tables, surfaces[film])}
    bodies = {surfaces[film].body for film in masked - separate}
    same = {film for film in films if surfaces[film].body in bodies}
    return masked | separate | same | (bodies & {*tables})


def _has_separate_grid(tables, surface):
    """Return whether a surface has another grid than its body."""
    build = tables.get(surface.body, {}).get("build", {})
    bands = [f"{one['name']}." for one in build.get("film_surfaces", ())]
    return "grid" in build and surface.prefix not in ("", "skirt.", *bands)


def _surface(tree, film):
    """Return the surface of a film."""
    side = interface(tree.get("wires", ()), film, "lubrication")
    return Surface(side.owner, side.surface) if side else Surface("", "")


def _banded(tree):
    """Return the build tables of bodies with several film surfaces."""
    builds = {name: table.get("build", {}) for name, table in tree["participants"].items()}
    return {name: build for name, build in builds.items() if build.get("film_surfaces")}


def _edges(build):
    """Return the number of rows below each end of the film surfaces of a body."""
    return [edge for one in build["film_surfaces"] for edge in (one["rows"][0] - 1, one["rows"][1])]


def ratio_of(tree: dict[str, Any]) -> float:
    """Return the cells of the grid over those of the second one, in each direction."""
    grids = [(build["grid"][1], _edges(build)) for build in _banded(tree).values()]
    return min((rows / fitting_rows(rows, edges) for rows, edges in grids), default=COARSENING)


def grid_safety(ratio: float) -> float:
    """Return the factor of safety on the difference between grids of a ratio, see `GRID_SAFETY`."""
    return min(GRID_SAFETY, max(3.0 / (ratio**2 - 1.0), 1.25 / (ratio - 1.0)))
