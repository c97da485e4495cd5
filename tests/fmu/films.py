"""The rigid piston of `data_sheet` with any number of films on its skirt."""

from collections.abc import Sequence
from typing import Any

from piston_cosim.master.case.reading import find_case, read_tree

PATH = find_case("data_sheet")
SKIRT = 82.8e-3
"""Length of the skirt [m]."""


def one_film(grid: tuple[int, int], stop: str) -> dict[str, Any]:
    """Return the case's TOML tree on a grid up to `stop`, without pictures."""
    tree = read_tree(PATH)
    tree["time"]["stop"] = stop
    for table in tree["participants"].values():
        table["build"]["grid"] = list(grid)
    fields = ["bodies.film_thickness", "ehd.pressure"]
    keep = {"record": {"fields": fields, "every": 10}, "summary": {}, "monitor": {}}
    return {**tree, **keep, "pictures": [], "axes": []}


def several_films(
    grid: tuple[int, int], stop: str, bands: Sequence[tuple[int, int]]
) -> dict[str, Any]:
    """Return the same case with a film on each band of rows (first and last, from 1).

    The participants are film_1, film_2 .., on the surfaces band_1, band_2 ..
    """
    tree = one_film(grid, stop)
    around, along = grid
    film = tree["participants"].pop("ehd")
    surfaces, wires = [], []
    for k, (first, last) in enumerate(bands, 1):
        rows = last - first + 1
        surfaces.append({"name": f"band_{k}", "rows": [first, last]})
        length = f"{SKIRT * rows / along!r} m"
        tree["participants"][f"film_{k}"] = film | {
            "build": {"grid": [around, rows]},
            "parameters": film["parameters"] | {"skirt_length": length},
        }
        for wire in tree["wires"]:
            named = {key: _renamed(text, k) for key, text in wire.items() if "." in str(text)}
            wires.append(wire | named)
    tree["participants"]["bodies"]["build"]["film_surfaces"] = surfaces
    order = [f"film_{k}" for k in range(1, len(bands) + 1)]
    tree["coupling"]["order"] = [*order, "bodies"]
    tree["record"]["fields"] = [f"bodies.band_{k}.film_thickness" for k in range(1, len(bands) + 1)]
    return tree | {"wires": wires}


def _renamed(port: Any, k: int) -> Any:
    """Return a port of the single film or its surface as that of the k-th."""
    if not isinstance(port, str):
        return port
    return port.replace("bodies.", f"bodies.band_{k}.").replace("ehd.", f"film_{k}.")


def even_bands(along: int, count: int) -> list[tuple[int, int]]:
    """So many bands of as many rows each, none left out."""
    rows = along // count
    return [(k * rows + 1, (k + 1) * rows) for k in range(count)]
