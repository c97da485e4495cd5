"""Rigid bodies of a data sheet with mass, centre, inertia and cylinder."""

import numpy as np

from ..body_options import Block, Piston
from .reduced_body import ReducedBlock, ReducedPiston


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
        T=np.zeros((2, 0)),
        b=np.zeros(0),
        B=np.zeros((0, 0)),
        g=np.zeros(0),
        G=np.zeros((0, 0)),
        omega=np.zeros(0),
        kind=np.zeros(0, dtype=int),
        gas_force=np.zeros(0),
        radial=np.zeros((around * along, 0)),
        axial=np.zeros((around * along, 0)),
        radius=sheet.radius,
        skirt_lower=lower,
        skirt_upper=upper,
        pin_offset=options.pin_offset,
    )


def rigid_block(options: Block, grid: tuple[int, int]) -> ReducedBlock:
    """Return the block of `options.rigid`; `grid` : cells around and along the skirt."""
    sheet = options.rigid
    assert sheet and options.bore_lower is not None and options.bore_upper is not None  # validated
    around, _ = grid
    heights = np.linspace(options.bore_lower, options.bore_upper, options.stations)
    return ReducedBlock(
        omega=np.zeros(0),
        kind=np.zeros(0, dtype=int),
        radial=np.zeros((around, options.stations, 0)),
        axial=np.zeros((around, options.stations, 0)),
        heights=heights,
        radius=sheet.radius,
    )
