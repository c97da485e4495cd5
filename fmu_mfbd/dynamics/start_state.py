"""Start from where another run stood: its outputs at an instant, as `piston-cosim snapshot` writes
them.
"""

import json
from math import floor, pi
from pathlib import Path

SCALARS = (
    "crank_angle",
    "rotation_speed",
    "lateral_displacement",
    "rocking_angle",
    "lateral_velocity",
    "rocking_velocity",
)
FIELDS = ("modal_coordinate", "modal_velocity")


def read_start(path):
    """Motion of the bodies at an instant.

    Parameters
    ----------
    path : Path
        JSON file of outputs by name, numbers or lists of numbers.

    Returns
    -------
    dict
        SCALARS [SI] and FIELDS, empty for rigid bodies; the crank angle without whole four-stroke
        cycles, within -2 pi to 2 pi.

    Raises
    ------
    ValueError
        Naming what is missing or not a number.
    """
    name = Path(path).name
    try:
        found = json.loads(Path(path).read_text())
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise ValueError(
            f"start: {name} is no JSON table of outputs (make one with piston-cosim snapshot)"
        )
    missing = [key for key in SCALARS if key not in found]
    if missing:
        raise ValueError(f"start: {name} lacks {', '.join(missing)}")
    out = {key: found.get(key, []) for key in SCALARS + FIELDS}
    try:
        out = {
            key: [float(v) for v in value] if key in FIELDS else float(value)
            for key, value in out.items()
        }
    except (TypeError, ValueError):
        raise ValueError(f"start: {name} holds something else than numbers") from None
    out["crank_angle"] -= 4 * pi * floor((out["crank_angle"] + 2 * pi) / (4 * pi))
    return out


def check_modes(start, modes):
    """Raise ValueError unless a start belongs to bodies of so many modes, piston and block
    together.
    """
    for key in FIELDS:
        if len(start[key]) != modes:
            raise ValueError(
                f"start: {len(start[key])} values of {key} where these bodies have {modes} modes; a run keeps them "
                "if its case names them in record.fields"
            )
