"""Rigid bodies of a data sheet with mass, centre, inertia and cylinder."""

import numpy as np

from ..body_options import Block, Piston
from .reduced_body import ReducedBlock, ReducedPiston, no_modes, no_modes_in_motion


def rigid_piston(options: Piston, grid: tuple[int, int]) -> ReducedPiston:
    """Return the piston of `options.rigid`.

    Eq. (J14):  S = m (c - a),   I0 = I + m |c - a|^2

    c is the centre of mass and a the pin point A, both from the skirt's axis at the height of A; I
    is about c.

    Parameters
    ----------
    options : Piston
    grid : (int, int)
        Cells around and along the skirt.
    """
    sheet = options.rigid
    lower = options.skirt_lower
    upper = options.skirt_upper
    assert sheet and lower is not None and upper is not None  # validated
    arm = np.array(sheet.centre) - np.array([options.pin_offset, 0.0])
    around, along = grid
    return ReducedPiston(
        mass=sheet.mass,
        S=sheet.mass * arm,  # Eq. (J14)
        I0=sheet.inertia + sheet.mass * float(arm @ arm),
        radius=sheet.radius,
        skirt_lower=lower,
        skirt_upper=upper,
        pin_offset=options.pin_offset,
        **no_modes_in_motion(around * along),
    )


def rigid_block(options: Block, grid: tuple[int, int]) -> ReducedBlock:
    """Return the block of `options.rigid`; `grid` : cells around and along the skirt."""
    sheet = options.rigid
    assert sheet and options.bore_lower is not None and options.bore_upper is not None  # validated
    around, _ = grid
    heights = np.linspace(options.bore_lower, options.bore_upper, options.stations)
    return ReducedBlock(
        **no_modes(around, options.stations),
        heights=heights,
        radius=sheet.radius,
    )
