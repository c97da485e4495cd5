"""Sparse symmetric positive definite systems: the direct solver at hand, and answers kept on disk,
so that a stopped reduction goes on where it was.
"""

import hashlib
import os
import shutil
import sys
import time
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

LOOSE = (
    "the body can still move rigidly (fewer than three held nodes, or all in one line), has a loose piece or an "
    "inverted element"
)


class SuperLU:
    """Factors by SuperLU of scipy: fine to some 60 000 degrees of freedom, out of the question
    above 200 000.

    Of the other solvers, PARDISO's is the one wheel that installs everywhere: scikit-sparse
    (CHOLMOD) is compiled against SuiteSparse, python-mumps against MUMPS, and its last wheel wants
    NumPy 1.

    Parameters
    ----------
    K : scipy.sparse matrix, shape (n, n)
        Symmetric positive definite.

    Raises
    ------
    ValueError
        At non-positive pivots.
    """

    def __init__(self, K):
        self._lu = splu(
            K.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        pivots = self._lu.U.diagonal()
        bad = np.sum(pivots <= SMALLEST_PIVOT * np.abs(pivots).max())
        if bad:
            raise ValueError(f"the stiffness has {bad} non-positive pivots: {LOOSE}")

    def solve(self, load):
        """K^-1 load, shape (n,) or (n, k)."""
        return self._lu.solve(np.ascontiguousarray(load))


class Pardiso:
    """Cholesky factors by PARDISO of the MKL through pypardiso, on all cores; parameters and errors
    as for `SuperLU`.

    ImportError without pypardiso.
    """

    FACTORISE, SOLVE, RELEASE, MEMORY, SYMMETRIC, NOT_POSITIVE = 12, 33, -1, -2, 2, -4
    AT_ONCE = (
        16  # right-hand sides a call: a million rows of sixty need more than the factors leave
    )

    def __init__(self, K):
        from pypardiso import PyPardisoSolver
        from pypardiso.pardiso_wrapper import PyPardisoError

        self._solver = PyPardisoSolver(mtype=self.SYMMETRIC)
        self._upper = sp.triu(K, format="csr")
        self._upper.sort_indices()
        self._solver.set_iparm(1, 1)  # the settings below, not the defaults
        self._solver.set_iparm(2, 3)  # nested dissection on all cores
        self._solver.set_iparm(24, 1)  # factorisation that scales to many cores
        try:
            self._call(self.FACTORISE, np.zeros((K.shape[0], 1)))
        except PyPardisoError as error:
            if error.value != self.NOT_POSITIVE:
                raise MemoryError(
                    f"PARDISO cannot factorise {K.shape[0]} degrees of freedom: {error}"
                ) from None
            raise ValueError(f"the stiffness has a non-positive pivot: {LOOSE}") from None
        push = np.random.default_rng(1).standard_normal(K.shape[0])
        if (
            np.abs(self.solve(push)).max() * K.diagonal().max() > 1 / SMALLEST_PIVOT
        ):  # a pivot that is round-off passes above
            raise ValueError(f"the stiffness is singular: {LOOSE}")

    def solve(self, load):
        """K^-1 load, shape (n,) or (n, k)."""
        columns = np.asarray(load).reshape(len(load), -1)
        parts = np.array_split(columns, -(-columns.shape[1] // self.AT_ONCE), axis=1)
        return np.hstack(
            [self._call(self.SOLVE, np.asfortranarray(part)) for part in parts]
        ).reshape(load.shape)

    def _call(self, phase, columns):
        before = self._solver.libmkl.MKL_Set_Num_Threads_Local(os.cpu_count())
        try:
            self._solver.set_phase(phase)
            return self._solver._call_pardiso(self._upper, columns)
        finally:
            self._solver.libmkl.MKL_Set_Num_Threads_Local(before)

    def __del__(self):
        if (
            hasattr(self, "_upper") and not sys.is_finalizing()
        ):  # PARDISO's own memory outlives the object otherwise
            self._call(self.RELEASE, np.zeros((1, 1)))


SMALLEST_PIVOT = 1e-12  # of the largest one


def factorise(K):
    """Factors of a symmetric positive definite matrix: PARDISO where it is installed, else
    SuperLU.
    """
    try:
        return Pardiso(K)
    except ImportError:
        return SuperLU(K)


class Remembering:
    """Factorises as above, and keeps every solution on disk by the content of matrix and load.

    An eigenvalue solver that starts from the same vector asks for the same solutions again: a
    reduction that was stopped replays them and goes on. Only the factors are made anew.

    Parameters
    ----------
    folder : Path
        Where the solutions go, one folder a matrix; `forget` clears what this object has used.
    say : callable
        Takes a sentence every ten seconds of solving.
    """

    def __init__(self, folder, say):
        self.folder, self._say, self._used = Path(folder), say, []

    def __call__(self, K):
        """Object with `solve`, as of `factorise`."""
        place = self.folder / _digest(K.data, K.indices, K.indptr)
        self._used.append(place)
        return _Remembered(K, place, self._say)

    def forget(self):
        """Remove the solutions kept."""
        for place in self._used:
            shutil.rmtree(place, ignore_errors=True)


class _Remembered:
    """One matrix with its solutions on disk; factorised when the first new solution is needed."""

    EVERY = 10.0  # seconds between sentences

    def __init__(self, K, place, say):
        self._K, self._place, self._say, self._factors = K, place, say, None
        self._count, self._begin = 0, time.monotonic()
        self._spoken = self._begin
        if place.is_dir():
            say(f"goes on with {len(list(place.glob('*.npy')))} solutions found on disk")
        else:
            self._factorise()
            place.mkdir(parents=True, exist_ok=True)

    def _factorise(self):
        begin = time.monotonic()
        self._say(f"factorising {self._K.shape[0]} degrees of freedom")
        self._factors, self._K = factorise(self._K), None
        if time.monotonic() - begin > self.EVERY:
            self._say(
                f"factorised by {type(self._factors).__name__} in {time.monotonic() - begin:.0f} s"
            )

    def solve(self, load):
        """K^-1 load, shape (n,) or (n, k)."""
        load = np.ascontiguousarray(load)
        path = self._place / f"{_digest(load)}.npy"
        self._count += 1
        if path.exists():
            return np.load(path)
        if self._factors is None:
            self._factorise()
        answer = self._factors.solve(load)
        with open(path.with_suffix(".part"), "wb") as file:
            np.save(file, answer)
        os.replace(path.with_suffix(".part"), path)
        if time.monotonic() - self._spoken > self.EVERY:
            self._spoken = time.monotonic()
            self._say(f"{self._count} solutions, {self._spoken - self._begin:.0f} s")
        return answer


def _digest(*arrays):
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(str(array.shape).encode() + np.ascontiguousarray(array).data)
    return digest.hexdigest()[:24]
