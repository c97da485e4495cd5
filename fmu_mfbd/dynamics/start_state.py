"""Start from the state of another run.

The state is the file of outputs at one instant that `piston-cosim results snapshot` writes.
"""

import json
from dataclasses import dataclass, field, fields
from math import floor, pi
from pathlib import Path
from typing import Any

import numpy as np


@dataclass(frozen=True)
class StartState:
    """Motion of the bodies at an instant, by the names of the outputs.

    Parameters
    ----------
    crank_angle, rotation_speed : float
        Without whole four-stroke cycles, within -2 pi to 2 pi [rad]; [rad/s].
    lateral_displacement, rocking_angle : float
        [m], [rad]
    lateral_velocity, rocking_velocity : float
        [m/s], [rad/s]
    modal_coordinate, modal_velocity : ndarray, shape (k,)
        Piston, then block [kg^1/2 m], [kg^1/2 m/s]; empty for rigid bodies.
    bearing_coordinate, bearing_velocity : ndarray, shape (n,)
        Coordinates of pin, crank and their shells, and their rates. Empty without their films.
    """

    crank_angle: float
    rotation_speed: float
    lateral_displacement: float
    rocking_angle: float
    lateral_velocity: float
    rocking_velocity: float
    modal_coordinate: np.ndarray
    modal_velocity: np.ndarray
    bearing_coordinate: np.ndarray = field(default_factory=lambda: np.zeros(0))
    bearing_velocity: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def position(self, joints: int = 0) -> np.ndarray:
        """Return all coordinates in the order of `mechanism.cylinder`.

        The first `joints` of bearings are those of plays and of the pin's angle.
        """
        rigid = self.lateral_displacement, self.rocking_angle
        before, after = np.split(self.bearing_coordinate, [joints])
        return np.array([*rigid, *before, *self.modal_coordinate, *after])

    def velocity(self, joints: int = 0) -> np.ndarray:
        """Return the time derivatives of `position`."""
        rigid = self.lateral_velocity, self.rocking_velocity
        before, after = np.split(self.bearing_velocity, [joints])
        return np.array([*rigid, *before, *self.modal_velocity, *after])


FIELDS = ("modal_coordinate", "modal_velocity", "bearing_coordinate", "bearing_velocity")
SCALARS = tuple(one.name for one in fields(StartState) if one.name not in FIELDS)


def read_start(path: Path | str) -> StartState:
    """Read the motion of the bodies at an instant.

    Parameters
    ----------
    path : Path
        JSON file of outputs by name, numbers or lists of numbers; those of `FIELDS` are optional.

    Returns
    -------
    StartState

    Raises
    ------
    ValueError
        With what is missing or not a number.
    """
    name = Path(path).name
    try:
        outputs = json.loads(Path(path).read_text())
    except ValueError:
        outputs = None
    if not isinstance(outputs, dict):
        raise ValueError(
            f"start: expected a JSON table of outputs in {name}, got other content; "
            "`piston-cosim results snapshot` writes one"
        )
    missing = [key for key in SCALARS if key not in outputs]
    if missing:
        raise ValueError(f"start: expected {', '.join(missing)} in {name}, got nothing")
    try:
        motion: dict[str, Any] = {key: float(outputs[key]) for key in SCALARS}
        for key in FIELDS:
            motion[key] = np.array([float(v) for v in outputs.get(key, [])])
    except (TypeError, ValueError):
        raise ValueError(f"start: expected numbers in {name}, got other values") from None
    motion["crank_angle"] -= 4 * pi * floor((motion["crank_angle"] + 2 * pi) / (4 * pi))
    return StartState(**motion)


def check_start(start: StartState, modes: int, bearings: int) -> None:
    """Raise ValueError unless a start has these numbers of modes and of coordinates of bearings.

    `modes` is the number of modes of piston and block.
    """
    each = zip(
        FIELDS, (modes, modes, bearings, bearings), ("mode", "mode", "coordinate", "coordinate")
    )
    for key, count, of in each:
        if len(values := getattr(start, key)) != count:
            raise ValueError(
                f"start: expected {count} values of {key}, one per {of}, got {len(values)}; "
                "a run records them every record.every"
            )
