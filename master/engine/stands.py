"""Where the cylinders of an engine stand: along its crankshaft, and by their bank angles."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..case.contract import players
from ..fmi.quantities import to_si
from ..results.file import Results
from ..results.solids import Solid, Stand

APART = 1.5
"""Diameters between cylinders of which nothing is said."""


def stands(results: Results) -> dict[str, Stand]:
    """Participant in the role `bodies` -> where its cylinder stands, as an engine block says to
    which wires lead: those to its `cylinder_K`, its parameters or build options `cylinder_z` and
    `bank_angle`.
    """
    bodies = players(results.case, "bodies")
    found = {}
    for wire in results.case.get("wires", ()):
        body = wire["from"].partition(".")[0]
        block, _, port = wire["to"].partition(".")
        numbered = re.match(r"cylinder_(\d+)\.", port)
        if body not in bodies or not numbered:
            continue
        table = results.case["participants"][block]
        given = table.get("build", {}) | table.get("parameters", {})
        k = int(numbered[1]) - 1
        if "cylinder_z" in given:
            bank = _of_cylinder(given.get("bank_angle", "0 deg"), k, "rad")
            found[body] = Stand(_of_cylinder(given["cylinder_z"], k, "m"), bank)
    return found


def _of_cylinder(given, k, unit):
    """A cylinder's own of values given for each, or the one given for all."""
    return float(to_si(given[k] if isinstance(given, list) else given, unit))


def side_by_side(solids: Sequence[Solid]) -> list[Solid]:
    """Bodies of cylinders of which nothing is known, one beside the other."""
    owners = list(dict.fromkeys(solid.owner for solid in solids))
    reach = max((float(np.abs(solid.points[:, [0, 2]]).max()) for solid in solids), default=0.0)
    step = APART * 2 * reach
    return [
        replace(solid, stand=Stand(step * (owners.index(solid.owner) - (len(owners) - 1) / 2)))
        for solid in solids
    ]
