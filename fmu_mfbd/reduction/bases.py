"""Reduction bases: sets of displacement shapes of a body."""

from typing import NamedTuple

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, eigsh

from ..finite_elements.element import Sparse, rigid_motions
from ..finite_elements.solver import Factorise, Factors, factorise

EQUAL_TOLERANCE = 1e-6
"""Entries of a shape with a smaller relative difference are equal up to round-off [-]."""


class Modes(NamedTuple):
    """Mass-orthonormal modes as columns [kg^-1/2], and ascending angular frequencies [rad/s]."""

    shapes: np.ndarray
    omega: np.ndarray


class Elastic:
    """Stiffness and mass of the free degrees of freedom, factorised once.

    Fixed nodes move rigidly with the frame (RBE2).

    Parameters
    ----------
    K : scipy.sparse matrix, shape (3 n, 3 n)
        Stiffness [N/m].
    M : scipy.sparse matrix, shape (3 n, 3 n)
        Mass [kg].
    fixed_nodes : ndarray of int
        Nodes that do not move.
    factors : callable
        Factorises a matrix: `solver.factorise` or a `solver.CachedFactorise`.

    Raises
    ------
    ValueError
        If the body can still move rigidly, or the stiffness has a non-positive pivot.
    """

    def __init__(
        self,
        K: Sparse,
        M: Sparse,
        fixed_nodes: np.ndarray,
        factors: Factorise = factorise,
    ):
        fixed = np.zeros(K.shape[0] // 3, dtype=bool)
        fixed[fixed_nodes] = True
        self.free = np.flatnonzero(np.repeat(~fixed, 3))
        self.size = K.shape[0]
        self.K = K.tocsr()[self.free][:, self.free].tocsc()
        self.M = M.tocsr()[self.free][:, self.free].tocsc()
        self.factors = factors
        self._lu: Factors = factors(self.K)

    def solve(self, load: np.ndarray) -> np.ndarray:
        """Return the displacement under nodal forces, both of the free degrees of freedom."""
        return self._lu.solve(load)

    def forget_factors(self) -> None:
        """Release the memory of the factors; `solve` is not possible afterwards."""
        del self._lu

    def full(self, shapes: np.ndarray) -> np.ndarray:
        """Return shapes, (free, k), on all degrees of freedom, (3 n, k), 0 at fixed nodes."""
        out = np.zeros((self.size, shapes.shape[1]))
        out[self.free] = shapes
        return out


class MeanElastic(Elastic):
    """Body whose mean motions over given surfaces are zero (RBE3).

    Eq. (J5):  K u + C^T lambda = f,   C u = 0
               row of C: sum_i w_i R_i^T u_i, w_i the area of node i, R_i a rigid motion there

    Parameters
    ----------
    K, M, factors
        As for `Elastic`.
    conditions : ndarray, shape (m, 3 n)
        C, m >= r, see `mean_conditions`.
    rigid : ndarray, shape (3 n, r)
        Rigid-body motions that K leaves free.
    """

    def __init__(
        self,
        K: Sparse,
        M: Sparse,
        conditions: np.ndarray,
        rigid: np.ndarray,
        factors: Factorise = factorise,
    ):
        self.size = K.shape[0]
        self.free = np.arange(self.size)
        self.K = K.tocsc()
        self.M = M.tocsc()
        # r suitable supports make K regular; the small system cancels their reactions
        r = rigid.shape[1]
        touched = np.flatnonzero(conditions.any(axis=0))
        order = la.qr(rigid[touched].T, mode="r", pivoting=True)[-1]
        self._loose = np.setdiff1d(self.free, touched[order[:r]])
        self.factors = factors
        self._lu = factors(self.K[self._loose][:, self._loose].tocsc())
        self._C = conditions
        self._R = rigid
        self._answer = self._supported(conditions.T)
        small = np.block(
            [
                [conditions @ self._answer, -conditions @ rigid],
                [rigid.T @ conditions.T, np.zeros((r, r))],
            ]
        )
        self._small = la.lu_factor(small)

    def _supported(self, load):
        out = np.zeros(load.shape)
        out[self._loose] = self._lu.solve(load[self._loose])
        return out

    def solve(self, load: np.ndarray) -> np.ndarray:
        """Return the displacement under nodal forces on all degrees of freedom, Eq. (J5)."""
        first = self._supported(load)
        unknown = la.lu_solve(self._small, np.concatenate([self._C @ first, self._R.T @ load]))
        m = len(self._C)
        return first - self._answer @ unknown[:m] + self._R @ unknown[m:]  # Eq. (J5)


def mean_conditions(points: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return C of Eq. (J5) for the mean motion of a surface, (6, 3 n).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]
    weight : ndarray, shape (n,)
        Area of each node [m2].
    """
    motions = rigid_motions(points - np.average(points, axis=0, weights=weight))
    return (motions * np.repeat(weight, 3)[:, None]).T / weight.sum()


def craig_bampton(body: Elastic, modes: int) -> np.ndarray:
    """Return fixed-interface normal modes, lowest frequencies first.

    Eq. (J1):  K phi = omega^2 M phi, interface fixed

    With one master (the frame point A, or the ground) the constraint modes are the rigid motions,
    which the floating frame contains.

    Parameters
    ----------
    body : Elastic
    modes : int
        Number of modes.

    Returns
    -------
    ndarray, shape (free, modes)

    References
    ----------
    [Craig1968]. Checked in tests/verification/test_mfbd.py.
    """
    return _lowest(body.K, body.M, body.solve, modes)  # Eq. (J1)


def _lowest(K, M, solve, modes):
    """Return the shapes of the lowest frequencies; `solve` applies K^-1."""
    inverse = LinearOperator(K.shape, matvec=solve, dtype=float)  # pyright: ignore
    start = _start(K.shape[0])
    _, shapes = eigsh(K, modes, M, sigma=0.0, OPinv=inverse, v0=start, tol=1e-10)  # pyright: ignore
    return shapes


def pressure_modes(
    body: Elastic,
    radial: Sparse,
    weight: np.ndarray,
    modes: int,
    first: np.ndarray,
    psi: np.ndarray | None = None,
) -> np.ndarray:
    """Return static shapes under the pressure patterns of the largest compliance, and given shapes.

    Eq. (J2):  D W G W^T D p = mu p,   phi = G W^T D p,   largest mu first
               G = K^-1, or K^-1 - Psi Psi^T: the compliance without that of the given shapes

    W reads the normal displacement at the points of a regular grid, W^T distributes forces at these
    points, and D is the expected force. mu decreases fast, so that few shapes are sufficient for
    film pressures.

    Parameters
    ----------
    body : Elastic
    radial : scipy.sparse matrix, shape (grid points, free)
        W [-].
    weight : ndarray, shape (grid points,)
        Diagonal of D [-].
    modes : int
        Number of shapes in all, the first ones included.
    first : ndarray, shape (free, k)
        Shapes that must be in the basis, k < modes (`static_answers`).
    psi : ndarray, shape (free, k), optional
        Psi with Psi^T K Psi = 1, the span of the first shapes.

    Returns
    -------
    ndarray, shape (free, modes)

    References
    ----------
    Our own choice, based on [Castanier2001]. Checked by `piston-cosim verify mfbd`.
    """
    diagonal: Sparse = sp.diags(weight)
    radial = diagonal @ radial
    spread = radial.T.tocsr()
    count = modes - first.shape[1]
    points = radial.shape[0]

    def answer(load):
        whole = body.solve(load)
        return whole if psi is None else whole - psi @ (psi.T @ load)

    def compliance(p):
        return radial @ answer(spread @ p.ravel())

    operator = LinearOperator((points, points), matvec=compliance, dtype=float)  # pyright: ignore
    _, patterns = eigsh(operator, count, v0=_start(points), tol=1e-8)  # pyright: ignore
    shapes = answer(spread @ patterns)  # Eq. (J2)
    return np.hstack([shapes, first])


def static_answers(body: Elastic, loads: np.ndarray, modes: int | float) -> np.ndarray:
    """Return the static deflection under loads that a basis must represent exactly.

    Parameters
    ----------
    body : Elastic
    loads : ndarray, shape (free, k)
        Loads, most important first.
    modes : int or float
        Number of modes of the basis, of which at most half are used for these loads. A float is the
        error of a basis of unknown size, which includes all loads.
    """
    if isinstance(modes, int):
        loads = loads[:, : modes // 2]
    if loads.shape[1]:
        return body.solve(loads)
    return np.empty((body.K.shape[0], 0))


def expected_pressure(angle: np.ndarray, n_axial: int) -> np.ndarray:
    """Return the expected film pressure on skirt or bore, largest across the pin.

    Eq. (J4):  weight = 0.1 + sin^2 theta      at (theta_i, height_j), j fastest

    A nearly round skirt also carries load near the pin, where this weight is small.
    """
    return np.repeat(0.1 + np.sin(angle) ** 2, n_axial)  # Eq. (J4)


def _start(size: int) -> np.ndarray:
    """Return the start vector of a Lanczos run, always the same for a reproducible reduction."""
    return np.random.default_rng(1).standard_normal(size)


def orthonormal_modes(body: Elastic, shapes: np.ndarray) -> Modes:
    """Combine shapes into modes that are orthonormal in mass and orthogonal in stiffness.

    Eq. (J3):  Phi^T M Phi = I,   Phi^T K Phi = diag(omega^2)

    Parameters
    ----------
    body : Elastic
    shapes : ndarray, shape (free, k)
        Independent shapes of any size.

    Returns
    -------
    Modes
        Shapes (free, k); the first entry of each that is as large as any other is positive.

    Raises
    ------
    ValueError
        If the shapes depend on each other.
    """
    shapes = of_unit_energy(body, shapes)
    mass = shapes.T @ (body.M @ shapes)
    square, turn = la.eigh((mass + mass.T) / 2)
    # Eq. (J3)
    modes = (shapes @ turn / np.sqrt(square))[:, ::-1]
    size = np.abs(modes)
    # equal entries of a symmetric body differ by round-off, which must not choose the sign
    first = (size > (1.0 - EQUAL_TOLERANCE) * size.max(axis=0)).argmax(axis=0)
    modes = modes * np.sign(modes[first, np.arange(modes.shape[1])])
    return Modes(modes, 1.0 / np.sqrt(square[::-1]))


def of_unit_energy(body: Elastic, shapes: np.ndarray) -> np.ndarray:
    """Combine shapes, (free, k), so that Psi^T K Psi = 1.

    Arguments and errors are those of `orthonormal_modes`.
    """
    if not shapes.shape[1]:
        return shapes
    shapes = shapes / np.sqrt(np.einsum("ik,ik->k", shapes, body.K @ shapes))
    gram = shapes.T @ (body.K @ shapes)
    strength, turn = la.eigh((gram + gram.T) / 2)
    dependent = np.count_nonzero(strength < 1e-13 * strength[-1])
    if dependent:
        raise ValueError(
            f"modes: expected independent shapes, got {dependent} dependent ones of "
            f"{len(strength)}; ask for fewer modes"
        )
    return shapes @ (turn / np.sqrt(strength))


def characteristic_constraint_modes(body: Elastic, interface: np.ndarray, modes: int) -> np.ndarray:
    """Return the lowest eigenmodes of the body after static condensation to its interface.

    Eq. (J6):  K_cc x = omega^2 M_cc x,  phi = Psi x
               K_cc = Psi^T K Psi,  M_cc = Psi^T M Psi,  Psi = [1; -K_ii^-1 K_ic]

    Parameters
    ----------
    body : Elastic
    interface : ndarray of int
        Nodes of the film surface; fixed nodes are omitted.
    modes : int

    Returns
    -------
    ndarray, shape (free, modes)

    References
    ----------
    [Castanier2001]
    """
    chosen = np.isin(body.free, (3 * np.asarray(interface)[:, None] + np.arange(3)).ravel())
    inner = np.flatnonzero(~chosen)
    outer = np.flatnonzero(chosen)
    within = body.factors(body.K[inner][:, inner].tocsc())
    link = body.K[inner][:, outer].tocsr()

    def extend(x):
        """Return Psi x."""
        out = np.empty(body.K.shape[0])
        out[outer] = x
        out[inner] = -within.solve(link @ x)
        return out

    def stiff(x):
        """Return K_cc x."""
        return (body.K @ extend(x.ravel()))[outer]

    def heavy(x):
        """Return M_cc x."""
        f = body.M @ extend(x.ravel())
        return f[outer] - link.T @ within.solve(f[inner])

    def answer(f):
        """Return K_cc^-1 f, the body's own compliance at the interface."""
        load = np.zeros(body.K.shape[0])
        load[outer] = f.ravel()
        return body.solve(load)[outer]

    size = (len(outer), len(outer))
    K_cc = LinearOperator(size, matvec=stiff, dtype=float)  # pyright: ignore
    M_cc = LinearOperator(size, matvec=heavy, dtype=float)  # pyright: ignore
    shapes = _lowest(K_cc, M_cc, answer, modes)
    return np.column_stack([extend(x) for x in shapes.T])  # Eq. (J6)
