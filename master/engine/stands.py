"""Positions of the cylinders of an engine along its crankshaft, and their bank angles."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..case.contract import players
from ..fmi.quantities import to_si
from ..results.file import Results
from ..results.solids import Solid, Stand

CYLINDER_DISTANCE = 1.5
"""Distance of cylinders with unknown positions, in diameters."""


def stands(results: Results) -> dict[str, Stand]:
    """Return the position of each participant with the role `bodies`, as an engine block states it.

    The wires to `cylinder_K` of the block identify the cylinders. Its parameters or build
    options `cylinder_z` and `bank_angle` are the positions.
    """
    bodies = players(results.case, "bodies")
    by_body = {}
    for wire in results.case.get("wires", ()):
        body = wire["from"].partition(".")[0]
        block, _, port = wire["to"].partition(".")
        numbered = re.match(r"cylinder_(\d+)\.", port)
        if body not in bodies or not numbered:
            continue
        table = results.case["participants"][block]
        values = table.get("build", {}) | table.get("parameters", {})
        k = int(numbered[1]) - 1
        if "cylinder_z" in values:
            bank = _of_cylinder(values.get("bank_angle", "0 deg"), k, "rad")
            by_body[body] = Stand(_of_cylinder(values["cylinder_z"], k, "m"), bank)
    return by_body


def _of_cylinder(value, k, unit):
    """Return the value of a cylinder from a list, or the value for all cylinders."""
    return float(to_si(value[k] if isinstance(value, list) else value, unit))


def side_by_side(solids: Sequence[Solid]) -> list[Solid]:
    """Return the bodies of cylinders with unknown positions next to each other."""
    owners = list(dict.fromkeys(solid.owner for solid in solids))
    reach = max((float(np.abs(solid.points[:, [0, 2]]).max()) for solid in solids), default=0.0)
    step = CYLINDER_DISTANCE * 2 * reach
    return [
        replace(solid, stand=Stand(step * (owners.index(solid.owner) - (len(owners) - 1) / 2)))
        for solid in solids
    ]
