"""Start from where another run stood: its outputs at an instant, as `piston-cosim snapshot` writes them."""

import json
from math import floor, pi
from pathlib import Path

SCALARS = ("crank_angle", "rotation_speed", "lateral_displacement", "rocking_angle", "lateral_velocity", "rocking_velocity")
FIELDS = ("modal_coordinate", "modal_velocity")


def read_start(path, modes):
    """Motion of the bodies at an instant.

    Parameters
    ----------
    path : Path
        JSON file of outputs by name, numbers or lists of numbers.
    modes : int
        Of piston and block together.

    Returns
    -------
    dict
        SCALARS [SI] and FIELDS; the crank angle without whole four-stroke cycles, within -2 pi to 2 pi.

    Raises
    ------
    ValueError
        Naming what is missing, not a number, or of other bodies.
    """
    name = Path(path).name
    try:
        found = json.loads(Path(path).read_text())
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise ValueError(f"start: {name} is no JSON table of outputs (make one with piston-cosim snapshot)")
    out = {key: found.get(key) for key in SCALARS} | {key: found.get(key, [] if modes == 0 else None) for key in FIELDS}
    missing = [key for key, value in out.items() if value is None]
    if missing:
        raise ValueError(f"start: {name} lacks {', '.join(missing)}; a run keeps them if its case says so in record.fields")
    for key in FIELDS:
        if len(out[key]) != modes:
            raise ValueError(f"start: {name} has {len(out[key])} values of {key}, these bodies {modes} modes")
    try:
        out = {key: [float(v) for v in value] if key in FIELDS else float(value) for key, value in out.items()}
    except (TypeError, ValueError):
        raise ValueError(f"start: {name} holds something else than numbers") from None
    out["crank_angle"] -= 4 * pi * floor((out["crank_angle"] + 2 * pi) / (4 * pi))
    return out
