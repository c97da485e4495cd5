"""Symmetry of the bodies about the thrust plane: reasons against it, and keys that assume it.

Motion in the plane of the crank and forces along x and y keep a symmetric film symmetric.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from ..master.fmi.quantities import short
from ..master.fmi.symmetry import odd_part
from .body_options import Block, Piston
from .dynamics.build_options import WallTemperatures
from .dynamics.clearance import measured
from .dynamics.half_films import (
    ODD_MODE,
    ODD_SHAPE,
    ODD_TEMPERATURE,
    mirror_error,
    odd_start,
    on_cells,
)
from .dynamics.start_state import StartState
from .geometry.grid import cell_centres
from .geometry.profile import BoreOrder, HotShape, MeasuredShape, fourier_bore
from .input_tables import Tables
from .options import Bodies
from .reduction.reduced_body import ReducedBlock, ReducedBody, ReducedPiston, load

ODD_COMPLIANCE = 0.01
"""Relative asymmetry of a surface's compliance, half of the limit of a film's odd part."""
IMAGES = {"boss_left.": "boss_right.", "boss_right.": "boss_left."}
"""Film surfaces that are mirror images of each other."""


def claims(build: Bodies) -> list[str]:
    """Return the options that assume a symmetric film.

    A file of a reduced body assumes it if all its modes are even about the thrust plane.
    """
    claimed = []
    for name, body in (("piston", build.piston), ("block", build.block)):
        if body is None or body.rigid:
            continue
        if body.reduced:
            with suppress(ValueError):  # a wrong file is a fault of the build
                if only_even(load(kind_of(body), Path(body.reduced)), build.grid[0]):
                    claimed.append(f"{name}.reduced")
        elif body.symmetric_film and body.modes:
            claimed.append(f"{name}.symmetric_film")
    return claimed


def kind_of(body: Piston | Block) -> type[ReducedPiston] | type[ReducedBlock]:
    """Return the class of a reduced body."""
    return ReducedPiston if isinstance(body, Piston) else ReducedBlock


def asymmetries(build: Bodies, tables: Tables, pin_tilt: float = 0.0) -> list[str]:
    """Return the reasons why bodies without modes are not their own mirror image.

    Parameters
    ----------
    build : Build or Bodies
    tables : Tables
        Its measured profiles and temperatures.
    pin_tilt : float
        Parameter of the FMU [rad].
    """
    angle, _ = cell_centres(*build.grid, 0.0, 1.0)
    reasons = []
    if pin_tilt:
        reasons.append(f"parameters.pin_tilt ({pin_tilt:g} rad)")
    if build.motion_in_space:
        reasons.append("build.motion_in_space (roll and yaw)")
    for name, profiles in (("piston", tables.skirt), ("block", tables.bore)):
        if odd := _odd_part(profiles, angle, ODD_SHAPE):
            reasons.append(f"build.{name}.profiles (odd part of {short(odd, 'm')})")
    if build.block:
        orders = [BoreOrder(one.order, one.amplitude, one.phase) for one in build.block.orders]
        odd = float(np.abs(odd_part(fourier_bore(orders, angle))).max())
        if odd > ODD_SHAPE:
            reasons.append(f"build.block.orders (odd part of {short(odd, 'm')})")
        if build.block.bore_from_outside:
            reasons.append("build.block.bore_from_outside (deflection of another participant)")
    return reasons + _odd_temperatures(tables.temperatures, angle)


def _odd_temperatures(temperatures: WallTemperatures | None, angle: np.ndarray) -> list[str]:
    """Return the walls whose temperature differs from its mirror image, or may do so."""
    reasons = []
    for name in ("skirt", "bore") if temperatures else ():
        wall = getattr(temperatures, name)
        if wall.varies:
            reasons.append(f"build.temperatures.{name} (field of another participant)")
        elif wall.table and (odd := _odd_part([wall.table], angle, ODD_TEMPERATURE)):
            reasons.append(f"build.temperatures.{name} (odd part of {short(odd, 'K')})")
    return reasons


def _odd_part(profiles: Sequence[MeasuredShape], angle: np.ndarray, round_off: float) -> float:
    """Return the largest odd part of the sum of tables, 0 for round-off, in their unit."""
    if not profiles:
        return 0.0
    rows = np.unique(np.concatenate([one.height for one in profiles]))
    between = np.linspace(rows[0], rows[-1], 4 * len(rows))
    shape = measured(profiles, angle, np.union1d(rows, between))
    odd = float(np.abs(odd_part(np.asarray(shape))).max())
    return odd if odd > round_off else 0.0


def asymmetries_of_bodies(
    bodies: Mapping[str, ReducedBody],
    skirt: np.ndarray | None,
    around: int,
    limit: float = ODD_COMPLIANCE,
    start: StartState | None = None,
) -> list[str]:
    """Return the reasons why reduced bodies are not their own mirror image.

    Parameters
    ----------
    bodies : mapping of str to ReducedPiston or ReducedBlock
    skirt : ndarray of bool, shape (c, a), optional
        Cells of the film grid with the skirt under them.
    around : int
        c.
    limit : float
        Largest relative asymmetry of a compliance [-].
    start : StartState, optional
        Motion at the start. Default: undeformed bodies.
    """
    reasons = []
    if odd := odd_start(start, [*bodies.values()], around):
        reasons.append(f"build.start (odd deflection of {short(odd, 'm')})")
    for name, body in bodies.items():
        error = mirror_error(body, around)
        if error > limit:
            reasons.append(
                f"build.{name} (mirrored loads deflect it differently, by {100 * error:.2g} %)"
            )
    if skirt is not None and (odd_part(skirt.astype(float)) != 0.0).any():
        reasons.append("build.piston (openings of the skirt)")
    return reasons


def asymmetries_of_heat(hot: Mapping[str, HotShape]) -> list[str]:
    """Return the reasons why hot shapes, by name of the body, are not their own mirror image."""
    reasons = []
    for name, shape in hot.items():
        odd = max(float(np.abs(odd_part(one)).max()) for one in (shape.radial, shape.axial))
        if odd > ODD_SHAPE:
            reasons.append(f"build.{name} (hot shape with an odd part of {short(odd, 'm')})")
    return reasons


def only_even(body: ReducedBody, around: int) -> bool:
    """Return whether a body has modes, and all of them are even about the thrust plane."""
    modes = on_cells(body, around)
    odd = np.linalg.norm(odd_part(modes), axis=(0, 1))
    size = np.linalg.norm(modes, axis=(0, 1))
    return bool(odd.size and (odd <= ODD_MODE * size).all())
