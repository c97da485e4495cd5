"""Scalars of a whole film in one pass over its cells."""

import numpy as np

from ..master.fmi.compiled import compiled


def halves(n_circumferential):
    """How much of each circumferential cell belongs to the thrust half, and the sine of its angle.

    Parameters
    ----------
    n_circumferential : int

    Returns
    -------
    share, sine : ndarray, shape (n_c,)
        1 on the thrust side (+x; i runs from +z towards +x), 0 on the other, 1/2 on the pin axis;
        sin(theta) [-].
    """
    sine = np.sin((np.arange(n_circumferential) + 0.5) * 2.0 * np.pi / n_circumferential)
    return np.where(np.abs(sine) < 1e-12, 0.5, (sine > 0.0).astype(float)), sine


@compiled
def summarise(
    film_thickness, pressure, pressure_force, viscous, boundary, power, contact_area, share, sine
):
    """Extremes and sums of a film; pairs are (thrust, anti-thrust half).

    Parameters ---------- film_thickness, pressure, pressure_force, viscous, boundary, power,
    contact_area : ndarray, shape (n_c, n_a)
        [m], [Pa], [N], [N], [N], [W], [-].
    share, sine : ndarray, shape (n_c,)
        From `halves`.

    Returns
    -------
    thinnest : pair of float
        [m].
    highest : float
        [Pa].
    radial : pair of float
        Force across the thrust plane, >= 0 pushes apart [N].
    friction : pair of float
        Axial force on the skirt [N].
    hydrodynamic, asperity, power, area : float
        Sums of viscous, boundary [N] and power [W], mean of the contact area fraction [-].
    """
    n_c, n_a = film_thickness.shape
    thinnest, radial, friction = np.zeros(2), np.zeros(2), np.zeros(2)
    thinnest[:] = np.inf
    highest, hydrodynamic, asperity, total, area = -np.inf, 0.0, 0.0, 0.0, 0.0
    for i in range(n_c):
        low, normal, wet, dry = np.inf, 0.0, 0.0, 0.0
        for j in range(n_a):
            low = min(low, film_thickness[i, j])
            highest = max(highest, pressure[i, j])
            normal += pressure_force[i, j]
            wet += viscous[i, j]
            dry += boundary[i, j]
            total += power[i, j]
            area += contact_area[i, j]
        hydrodynamic += wet
        asperity += dry
        for side in range(2):
            part = share[i] if side == 0 else 1.0 - share[i]
            if part > 0.0:
                thinnest[side] = min(thinnest[side], low)
            radial[side] += part * abs(sine[i]) * normal
            friction[side] += part * (wet + dry)
    return (
        (thinnest[0], thinnest[1]),
        highest,
        (radial[0], radial[1]),
        (friction[0], friction[1]),
        hydrodynamic,
        asperity,
        total,
        area / (n_c * n_a),
    )
