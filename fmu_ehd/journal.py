"""A parallel journal in its shell: gap, force of the film, and the position that carries a load.

x points to the cell i = 0 and y to a quarter of a revolution further, from the axis of the shell:

Eq. (E14):  h = C - x cos a - y sin a
Eq. (E15):  F = sum of pressure force (-cos a, -sin a) + circumferential force (-sin a, cos a)
Eq. (E16):  F(x, y, q) + W = 0,   q_k = sum of p O_k - f T_k,   h opens by sum_k O_k q_k

a is the angle of a cell, a = 2 pi i / n, C the radial clearance and W the load on the journal. p
and f are the nodal forces of pressure and friction. O_k and T_k are a shape of an elastic shell
outward and around, for unit stiffness, with the coordinate q_k.

Newton's method solves Eq. (E16) with the exact tangent of the steady film, and damps the shells:

Eq. (E17):  (dR/dq - 4 r/r_max) dq = -R,   R_k = sum of p O_k - f T_k - q_k,   r = |R|

r_max is the largest r so far. This is an implicit step of dq/dt = R, whose length grows as R
decreases [Kelley1998]. Without damping, soft shells can converge to a balance that they do not
reach from rest, or diverge.

If that fails, the search starts again at other positions. Near an opening, Newton's method can
move the journal into the shell.

Stiffness and damping refer to a small motion about the balance, with shells that follow:

    F(x + dx) = F(x) - K dx - D d(dx)/dt

All shapes have the stiffness K_f of film and shells, and the damping D_f of a squeeze. The shells
follow by S = -K_ee^-1 K_ef, without inertia:

Eq. (E18):  K = L K_f R,   D = L D_f R,   R = [I, S],   L = [I, -K_fe K_ee^-1]

K_f is that of the steady film, and D_f is symmetric, because cavities keep their oil and their
boundaries rest. These are the coefficients of [Lund1978]. In motion that is slow against a
revolution, the oil of a cavity follows too, if the film does not reform at grooves.

References
----------
[Kelley1998] C. T. Kelley, D. E. Keyes, Convergence analysis of pseudo-transient continuation, SIAM
J. Numerical Analysis 35 (1998) 508.
[Lund1978] J. W. Lund, K. K. Thomsen, A calculation method and data for the dynamic coefficients of
oil-lubricated journal bearings, Topics in Fluid Film Bearing, ASME 1978, 1-28.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from .common.faults import NotConverged
from .common.grid import Array
from .state import Memory

MOST_POSITIONS = 60
START_ECCENTRICITY = 0.5  # of the clearance, along the load
LARGEST_APPROACH = 0.3  # of the thinnest film, by which an iteration may lower it
LARGEST_MOVE = 0.3  # of the clearance, largest displacement of an iteration
NOT_CARRIED = "no position of the journal carries the load"
LARGEST_DAMPING = 4.0  # largest damping of the shells over their stiffness, Eq. (E17)
OTHER_STARTS = (
    (0.3, 0.25),
    (0.3, -0.25),
    (0.9, 0.0),
    (0.3, 0.5),
    (0.3, -0.5),
    (0.8, 0.25),
    (0.8, -0.25),
)
"""Further starts: eccentricity over the clearance, and angle from the load over pi."""


class ElasticShell(Protocol):
    """Modes of a shell, or of a journal, on the cells of its film.

    omega : ndarray, shape (k,), angular eigenfrequencies [rad/s]; outward, onward : ndarray, shape
    (n_c, n_a, k), displacement that opens the film, and around it [kg^-1/2].
    """

    @property
    def omega(self) -> Array: ...
    @property
    def outward(self) -> Array: ...
    @property
    def onward(self) -> Array: ...


def shell_fault(shell: ElasticShell, grid: tuple[int, int]) -> str:
    """Return a sentence if an elastic shell does not have modes on the cells of a grid, else ""."""
    if not all(hasattr(shell, name) for name in ("omega", "outward", "onward")):
        return (
            "shells: expected modes such as elastic_shell of fmu_mfbd.shell.build returns, got "
            f"{type(shell).__name__}; FMUs are not supported"
        )
    if shell.outward.shape != (*grid, len(shell.omega)):
        return f"shells: expected modes on {grid} cells, got {shell.outward.shape}"
    return ""


class Shapes(NamedTuple):
    """Shapes in which the film thickness changes, and the forces against them.

    outward, onward : ndarray, shape (cells, m), O and T [m] per unit of the coordinate;
    load, stiffness : ndarray, shape (m,), external force, and force per unit of the coordinate.
    """

    outward: Array
    onward: Array
    load: Array
    stiffness: Array

    def thickness(self, coordinates: Array, shape: tuple[int, int]) -> Array:
        """Return the change of the film thickness, shape `shape` [m]."""
        return (self.outward @ coordinates).reshape(shape)

    def push(self, pressure: Array, circumferential: Array) -> Array:
        """Return the forces of a film on the shapes, shape (m,)."""
        return pressure.ravel() @ self.outward - circumferential.ravel() @ self.onward


class SettledFilm(NamedTuple):
    """Steady film of a film thickness.

    outputs : of a short step about it, by name;
    by_shape : ndarray, shape (m, m), derivative of the forces on the shapes to their coordinates;
    state : of the film before the short step.
    """

    outputs: dict[str, Any]
    by_shape: Array
    state: Memory


class Balance(NamedTuple):
    """Coordinates of the shapes, their film, and the forces out of balance.

    coordinates, push, residual : ndarray, shape (m,), of the shapes, force of the film, and R of
    Eq. (E17);
    thickness : ndarray, shape (n_c, n_a), film thickness [m];
    film : SettledFilm.
    """

    coordinates: Array
    push: Array
    residual: Array
    thickness: Array
    film: SettledFilm


def outward(n: int) -> Array:
    """Return the directions of n cells from the axis of the shell, shape (2, n)."""
    angle = 2.0 * np.pi / n * np.arange(n)
    return np.array([np.cos(angle), np.sin(angle)])


def gap(clearance: Array | float, position: Array, shape: tuple[int, int]) -> Array:
    """Return the film thickness at a position of the journal, Eq. (E14).

    Parameters
    ----------
    clearance : float or ndarray, shape `shape`
        C [m].
    position : ndarray, shape (2,)
        x, y [m].
    shape : tuple of int
        Cells around and along.

    Returns
    -------
    ndarray, shape `shape`
        h [m].
    """
    around, _ = shape
    nearer = (position @ outward(around))[:, None]
    return np.ascontiguousarray(np.broadcast_to(clearance - nearer, shape))  # Eq. (E14)


def film_force(pressure: Array, circumferential: Array | None = None) -> Array:
    """Return the force of the film on the journal, Eq. (E15).

    Parameters
    ----------
    pressure, circumferential : ndarray, shape (n_c, n_a)
        Nodal forces of a bearing [N]. If `circumferential` is omitted, the force of the pressure.

    Returns
    -------
    ndarray, shape (2,)
        F [N].
    """
    x, y = radial = outward(len(pressure))
    force = -radial @ pressure.sum(axis=1)
    if circumferential is not None:
        force += np.array([-y, x]) @ circumferential.sum(axis=1)  # Eq. (E15)
    return force


def shapes_of(
    shells: Sequence[ElasticShell], shape: tuple[int, int], load: Array | None = None
) -> Shapes:
    """Return the displacement of a journal under a load, then the modes of its shells.

    Parameters
    ----------
    shells : sequence of ElasticShell
    shape : tuple of int
        Cells around and along.
    load : ndarray, shape (2,), optional
        W [N]. If omitted, the journal does not move.

    Returns
    -------
    Shapes
    """
    around, along = shape
    cells = around * along
    x, y = np.repeat(outward(around), along, axis=1)
    still = np.zeros((cells, 0))
    first = (still, still) if load is None else (np.stack([-x, -y], 1), np.stack([y, -x], 1))
    opened = [(one.outward / one.omega).reshape(cells, -1) for one in shells]
    turned = [(one.onward / one.omega).reshape(cells, -1) for one in shells]
    sides = np.hstack([first[0], *opened]), np.hstack([first[-1], *turned])
    external = np.zeros(0) if load is None else load
    elastic = np.ones(sides[0].shape[1] - len(external))
    padded = np.concatenate([external, 0.0 * elastic])
    return Shapes(*sides, padded, np.concatenate([0.0 * external, elastic]))


def by_shapes(
    tangent: Callable[[Array], tuple[Array, ...]], shapes: Shapes, shape: tuple[int, int]
) -> Array:
    """Return the change of the forces on shapes by their coordinates, of the last step of a film.

    Parameters
    ----------
    tangent : callable
        Changes of the nodal forces for changes of the film thickness, shape (m, n_c, n_a) [m].
    shapes : Shapes
    shape : tuple of int
        Cells around and along.

    Returns
    -------
    ndarray, shape (m, m)
    """
    normal, _, circumferential = tangent(shapes.outward.T.reshape(-1, *shape))
    columns = [shapes.push(*forces) for forces in zip(normal, circumferential)]
    return np.transpose(columns) - np.diag(shapes.stiffness)


def condensed(matrix: Array, by_shape: Array, shapes: Shapes) -> Array:
    """Return a matrix of all shapes for a journal whose shells follow, Eq. (E18).

    Parameters
    ----------
    matrix : ndarray, shape (m, m)
        K_f [N/m] or D_f [N s/m].
    by_shape : ndarray, shape (m, m)
        -K_f, as `by_shapes` returns it.
    shapes : Shapes

    Returns
    -------
    ndarray, shape (2, 2)
    """
    free = shapes.stiffness == 0.0
    elastic = by_shape[np.ix_(~free, ~free)]
    rows, columns = np.repeat(np.eye(len(free))[None, :, free], 2, axis=0)
    columns[~free] = -np.linalg.solve(elastic, by_shape[np.ix_(~free, free)])
    rows[~free] = -np.linalg.solve(elastic.T, by_shape[np.ix_(free, ~free)].T)
    return rows.T @ matrix @ columns  # Eq. (E18)


def stiffness(tangent: Callable[[Array], tuple[Array, ...]], shape: tuple[int, int]) -> Array:
    """Return -dF/d(x, y) of the last step of a film in a rigid shell, shape (2, 2) [N/m].

    `tangent` and `shape` are those of `by_shapes`.
    """
    return -by_shapes(tangent, shapes_of((), shape, np.zeros(2)), shape)


class Search(NamedTuple):
    """Search for the balance of a journal and its shells, Eq. (E16).

    settled : callable, `SettledFilm` of a film thickness, which continues from a state;
    shapes : of `shapes_of`;
    clearance : ndarray, shape (n_c, n_a), C of each cell [m];
    roughness_rms : replaces a thinner film in the limit of an iteration [m], because contact lets
    surfaces overlap;
    tolerance : largest |F + W| over |W|, and of the shells the root of the energy out of balance
    over that of the load.
    """

    settled: Callable[[Array, Memory], SettledFilm]
    shapes: Shapes
    clearance: Array
    roughness_rms: float
    tolerance: float

    def balance(self, state: Memory) -> Balance:
        """Return the balance, from a state of the film.

        Raises
        ------
        NotConverged
            If no position carries the load; the error of the first search.
        """
        starts = (
            ((START_ECCENTRICITY, 0.0), *OTHER_STARTS)
            if np.any(self.shapes.load)
            else ((START_ECCENTRICITY, 0.0),)
        )
        troubles: list[NotConverged] = []
        for eccentricity, angle in starts:
            try:
                return self._by_newton(eccentricity, np.pi * angle, state)
            except NotConverged as trouble:
                troubles.append(trouble)
            except np.linalg.LinAlgError:
                troubles.append(NotConverged(f"{NOT_CARRIED}: the film has no stiffness"))
        raise troubles[0]

    def _by_newton(self, eccentricity: float, angle: float, state: Memory) -> Balance:
        """Return the balance by Eq. (E17) from a position of the journal."""
        shapes = self.shapes
        elastic = shapes.stiffness > 0.0
        size = np.hypot.reduce(shapes.load) or 1.0
        coordinates = eccentricity * self.clearance.min() * shapes.load / size
        if angle != 0.0:
            x, y = coordinates[:2]
            coordinates[:2] = (
                x * np.cos(angle) - y * np.sin(angle),
                x * np.sin(angle) + y * np.cos(angle),
            )
        at = self._at(coordinates, state)
        most = np.finfo(float).tiny
        for _ in range(MOST_POSITIONS):
            if self._unbalanced(at) <= self.tolerance:
                return at
            unbalanced = float(np.linalg.norm(at.residual[elastic]))
            most = max(most, unbalanced)
            damping = LARGEST_DAMPING * unbalanced / most * shapes.stiffness
            damped = at.film.by_shape - np.diag(damping)
            change = np.linalg.solve(damped, -at.residual)  # Eq. (E17)
            part = self._part(at, change)
            at = self._at(at.coordinates + part * change, at.film.state)
        free = shapes.stiffness == 0.0
        raise NotConverged(
            f"{NOT_CARRIED}: forces {at.residual[free]} N remain at {at.coordinates[free]} m"
        )

    def _at(self, coordinates: Array, state: Memory) -> Balance:
        """Return the film and the forces out of balance at coordinates of journal and shells."""
        shapes = self.shapes
        thickness = self.clearance + shapes.thickness(coordinates, self.clearance.shape)
        film = self.settled(thickness, state)
        forces = (film.outputs[f"nodal_{name}_force"] for name in ("pressure", "circumferential"))
        push = shapes.push(*forces)
        residual = push + shapes.load - shapes.stiffness * coordinates  # Eq. (E16)
        return Balance(coordinates, push, residual, thickness, film)

    def _unbalanced(self, at: Balance) -> float:
        """Return the larger share of a load out of balance, of the journal and its shells [-]."""
        free = self.shapes.stiffness == 0.0
        sizes = np.linalg.norm(self.shapes.load), np.linalg.norm(at.push[~free])
        tiny = np.finfo(float).tiny
        return max(
            float(np.linalg.norm(at.residual[one])) / max(float(size), tiny)
            for one, size in zip((free, ~free), sizes)
        )

    def _part(self, at: Balance, change: Any) -> float:
        """Return the part of a change of the coordinates that an iteration may take, 0 to 1."""
        opened = self.shapes.thickness(change, self.clearance.shape)
        return _part(at.thickness, opened, self.clearance.min(), self.roughness_rms)


def _part(thickness: Array, opened: Array, clearance: float, roughness_rms: float) -> float:
    """Return the part of a change of the film thickness that an iteration may take, 0 to 1."""
    least = float(thickness.min())
    lowest = least - LARGEST_APPROACH * max(least, roughness_rms)
    tiny = np.finfo(float).tiny
    far = LARGEST_MOVE * clearance / max(float(np.abs(opened).max()), tiny)
    shut = ((thickness - lowest) / np.maximum(-opened, tiny)).min()
    return min(1.0, far, float(shut))
