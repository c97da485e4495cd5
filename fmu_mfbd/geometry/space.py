"""Film geometry of a piston that moves in space.

Shift along the pin (z), roll (about x) and yaw (about y) change film thickness and sliding
velocity. Coordinates are [z, roll, yaw] of pin point A and small. Arrays are (n_circumferential,
n_axial), and the grid moves with the skirt, as in `film`.
"""

from typing import NamedTuple

import numpy as np

from .film import BoreSplines, FilmSurface, NodalForces, Window, on_rows


class Levers(NamedTuple):
    """Derivatives of film thickness and sliding velocity by the coordinates.

    Parameters
    ----------
    thickness : ndarray, shape (3, c, a)
        Change of film thickness by each coordinate [-], [m], [m].
    sliding : ndarray, shape (c, a)
        Change of sliding velocity with the velocity of roll [m].
    """

    thickness: np.ndarray
    sliding: np.ndarray

    def opening(self, coordinates: np.ndarray) -> np.ndarray:
        """Return the change of film thickness by coordinates, or its rate by velocities, (c, a)."""
        return np.tensordot(coordinates, self.thickness, 1)

    def forces(self, film: NodalForces) -> np.ndarray:
        """Return the generalised forces, (3,) [N], [N m], [N m].

        Eq. (G7):  Q_k = sum F dh/dq_k + sum f dv/dq'_k        the transpose of Eqs. (H9), (H10)
        """
        # Eq. (G7)
        rolling = float((self.sliding * film.friction).sum())
        return np.tensordot(self.thickness, film.pressure, 2) + [0.0, rolling, 0.0]


def levers(surface: FilmSurface, around: np.ndarray, window: Window) -> Levers:
    """Return the derivatives of a film surface.

    Eq. (H9):   h = .. - (z + roll y' + yaw p) cos theta + yaw dw/dtheta
    Eq. (H10):  v = .. - roll' R cos theta
                p the pin offset, w the bore's widening, R the skirt's radius; .. Eqs. (H1), (H2)

    They are of first order: A moves by z, and the skirt rotates by roll and yaw about A, at the
    distance p from its axis. A point (R sin theta - p, y', R cos theta) from A moves outwards by
    (z + roll y' + yaw p) cos theta. Yaw about the skirt's own axis has no effect in a round bore:
    barrel and ovality move with the grid, and pressure on a round wall has no moment about its
    axis. A bore that is not round is read at theta + yaw.

    Parameters
    ----------
    surface : FilmSurface
    around : ndarray, shape (knots, c)
        Result of `slope_around` for its bore.
    window : Window
    """
    skirt = surface.skirt
    cosine = np.cos(skirt.angle)[:, None] * np.ones_like(skirt.gap)
    # Eq. (H9)
    turned = -skirt.pin_offset * cosine
    if len(around):
        rows = np.ascontiguousarray(around[window.first : window.first + window.knots])
        turned = turned + on_rows(window, window.value, rows).T
    thickness = np.array([-cosine, -skirt.height * cosine, turned])
    return Levers(thickness, -skirt.radius * cosine)  # Eq. (H10)


def slope_around(bore: BoreSplines) -> np.ndarray:
    """Return dw/dtheta of the undeformed bore, (knots, c) [m], as spline coefficients.

    The Fourier series over the grid's angles is exact for orders below half their number. An order
    of half their number has no slope on the grid.
    """
    count = bore.shape.shape[1]
    orders = np.arange(count // 2 + 1.0)
    if count % 2 == 0:
        orders[-1] = 0.0
    return np.fft.irfft(1j * orders * np.fft.rfft(bore.shape, axis=1), count, axis=1)
