"""Engines of any number of cylinders on one block, made of the case `twin`."""

from copy import deepcopy
from typing import Any, NamedTuple

from piston_cosim.master.case.reading import find_case, read_tree

PATH = find_case("twin")
PITCH = 0.13
"""Between neighbouring cylinders [m]."""


class Cylinder(NamedTuple):
    """Crank angle behind the first cylinder and bank angle [deg]; position along the crank [m]."""

    behind: float
    bank: float
    z: float


def in_line(*behind: float) -> list[Cylinder]:
    """Cylinders in a row about the middle of the crank."""
    middle = (len(behind) - 1) / 2
    return [Cylinder(angle, 0.0, PITCH * (k - middle)) for k, angle in enumerate(behind)]


ENGINES = {
    "single": in_line(0.0),
    "twin, 180 deg": in_line(0.0, 180.0),
    "twin, 360 deg": in_line(0.0, 360.0),
    # pins at 0 and 180 deg, banks as well: both pistons move outwards together, fire 360 deg apart
    "boxer": [Cylinder(0.0, 0.0, -PITCH / 4), Cylinder(360.0, 180.0, PITCH / 4)],
    # firing order 1-3-4-2
    "in-line four": in_line(0.0, 540.0, 180.0, 360.0),
}


def engine_tree(
    cylinders: list[Cylinder], grid: tuple[int, int], stop: str, tolerance: str = "1 nm"
) -> dict[str, Any]:
    """Return a case's TOML tree without pictures: participants cylinder_1, film_1 .. and block.

    No step is repeated in parts, which the other cylinders would have too.
    """
    whole = read_tree(PATH)
    parts = whole["participants"]
    count = len(cylinders)
    block = deepcopy(parts["block"])
    block["build"]["cylinders"] = count
    block["parameters"] |= {
        "cylinder_z": [f"{one.z!r} m" for one in cylinders],
        "bank_angle": [f"{one.bank!r} deg" for one in cylinders],
    }
    participants, wires = {}, []
    for k, one in enumerate(cylinders, 1):
        body, film = deepcopy(parts["front"]), deepcopy(parts["front_film"])
        body["parameters"] |= {
            "start_crank_angle": f"{-360.0 - one.behind!r} deg",
            "impact_resolution": "1 m",
        }
        for table in (body, film):
            table["build"]["grid"] = list(grid)
        participants |= {f"cylinder_{k}": body, f"film_{k}": film}
        wires += [
            {key: _renamed(text, k) for key, text in wire.items()}
            for wire in whole["wires"]
            if not any("rear" in str(text) for text in wire.values())
        ]
    for wire in wires:
        if wire["to"].endswith(".film_thickness"):
            wire["tolerance"] = tolerance
        elif wire["to"].endswith(".sliding_velocity"):
            wire["tolerance"] = 1e-6
    names = range(1, count + 1)
    order = [*(f"film_{k}" for k in names), *(f"cylinder_{k}" for k in names), "block"]
    time = whole["time"] | {"stop": stop, "angular_speed": "cylinder_1.crank_speed"}
    return {
        "title": "engine",
        "label": "engine",
        "time": time,
        "participants": participants | {"block": block},
        "wires": wires,
        "coupling": {"method": "newton", "order": order},
        "record": {"fields": [f"cylinder_{k}.film_thickness" for k in names], "every": 1},
    }


def _renamed(text: Any, k: int) -> Any:
    """Return a port of the front cylinder as that of the k-th."""
    if not isinstance(text, str):
        return text
    text = text.replace("front_film.", f"film_{k}.").replace("front.", f"cylinder_{k}.")
    return text.replace("block.cylinder_1.", f"block.cylinder_{k}.")


def alone(tree: dict[str, Any], k: int) -> dict[str, Any]:
    """Return the single-piston case of the k-th cylinder, in a block that does not move."""
    body, film = f"cylinder_{k}", f"film_{k}"
    participants = {name: deepcopy(tree["participants"][name]) for name in (body, film)}
    del participants[body]["build"]["mounted"]
    wires = [
        wire
        for wire in tree["wires"]
        if {wire["from"].split(".")[0], wire["to"].split(".")[0]} == {body, film}
    ]
    return tree | {
        "participants": participants,
        "wires": wires,
        "time": tree["time"] | {"angular_speed": f"{body}.crank_speed"},
        "coupling": {"method": "newton", "order": [film, body]},
        "record": {"fields": [f"{body}.film_thickness"], "every": 1},
    }


def held(tree: dict[str, Any]) -> dict[str, Any]:
    """Return the same engine on mounts that do not yield."""
    tree = deepcopy(tree)
    parameters = tree["participants"]["block"]["parameters"]
    parameters |= {f"stiffness_{axis}": ["1e30 N/m"] * 4 for axis in "xyz"}
    return tree
