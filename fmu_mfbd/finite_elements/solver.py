"""Sparse symmetric positive definite systems: direct solvers, and a cache of their solutions.

After an interruption, a reduction continues with the cached solutions.
"""

import hashlib
import os
import shutil
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from .element import Sparse

LOOSE = (
    "hold at least three nodes, not all on one line, against rigid motions, and look for loose "
    "pieces and inverted elements"
)
SMALLEST_PIVOT = 1e-12  # of the largest one
LARGEST_SUPERLU = 60_000  # degrees of freedom that SuperLU factorises
THREADS = "PISTON_COSIM_THREADS", "OMP_NUM_THREADS"
"""Environment variables with the number of threads. The command line copies the user's
OMP_NUM_THREADS to the first one before it sets the second one for small matrices."""


class Factors(Protocol):
    """Factors of a symmetric positive definite matrix K, (n, n)."""

    def solve(self, load: np.ndarray) -> np.ndarray:
        """Return K^-1 load, (n,) or (n, k)."""
        ...


Factorise = Callable[[Sparse], Factors]


class SuperLU:
    """Factors of scipy's SuperLU, for up to `LARGEST_SUPERLU` degrees of freedom.

    Parameters
    ----------
    K : scipy.sparse matrix, shape (n, n)
        Symmetric positive definite.

    Raises
    ------
    ValueError
        If pivots are not positive.
    """

    def __init__(self, K: Sparse):
        self._lu = splu(
            K.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        pivots = self._lu.U.diagonal()
        bad = np.sum(pivots <= SMALLEST_PIVOT * np.abs(pivots).max())
        if bad:
            raise ValueError(
                f"mesh: expected a positive stiffness, got {bad} pivots that are negative or "
                f"round-off; {LOOSE}"
            )

    def solve(self, load: np.ndarray) -> np.ndarray:
        """Return K^-1 load, (n,) or (n, k)."""
        return self._lu.solve(np.ascontiguousarray(load))


class Pardiso:
    """Cholesky factors of the MKL's PARDISO with the number of `threads`.

    Parameters and errors are those of `SuperLU`. It raises ImportError without pypardiso, and
    MemoryError if there is too little memory. PARDISO is the only one of the faster solvers with
    wheels for all platforms.
    """

    FACTORISE, SOLVE, RELEASE, MEMORY, SYMMETRIC, NOT_POSITIVE = 12, 33, -1, -2, 2, -4
    # right-hand sides of one call: sixty of 1e6 rows do not fit in memory beside the factors
    AT_ONCE = 16

    def __init__(self, K: Sparse):
        from pypardiso import PyPardisoSolver  # pyright: ignore[reportMissingImports]
        from pypardiso.pardiso_wrapper import (  # pyright: ignore[reportMissingImports]
            PyPardisoError,
        )

        self._solver = PyPardisoSolver(mtype=self.SYMMETRIC)
        self._upper = sp.csr_matrix(sp.triu(K))
        self._upper.sort_indices()
        self._solver.set_iparm(1, 1)  # the settings below, not the defaults
        self._solver.set_iparm(2, 3)  # nested dissection in threads
        self._solver.set_iparm(24, 1)  # factorisation that scales to many cores
        try:
            self._call(self.FACTORISE, np.zeros((K.shape[0], 1)))
        except PyPardisoError as error:
            if error.value != self.NOT_POSITIVE:
                raise MemoryError(
                    f"PARDISO cannot factorise {K.shape[0]} degrees of freedom: {error}"
                ) from None
            raise ValueError(
                f"mesh: expected a positive stiffness, got a non-positive pivot; {LOOSE}"
            ) from None
        push = np.random.default_rng(1).standard_normal(K.shape[0])
        # PARDISO accepts pivots that are round-off; a random load detects them
        if np.abs(self.solve(push)).max() * K.diagonal().max() > 1 / SMALLEST_PIVOT:
            raise ValueError(f"mesh: expected a regular stiffness, got a singular one; {LOOSE}")

    def solve(self, load: np.ndarray) -> np.ndarray:
        """Return K^-1 load, (n,) or (n, k)."""
        columns = np.asarray(load).reshape(len(load), -1)
        parts = np.array_split(columns, -(-columns.shape[1] // self.AT_ONCE), axis=1)
        return np.hstack(
            [self._call(self.SOLVE, np.asfortranarray(part)) for part in parts]
        ).reshape(load.shape)

    def _call(self, phase, columns):
        before = self._solver.libmkl.MKL_Set_Num_Threads_Local(threads())
        try:
            self._solver.set_phase(phase)
            return self._solver._call_pardiso(self._upper, columns)
        finally:
            self._solver.libmkl.MKL_Set_Num_Threads_Local(before)

    def __del__(self):
        # PARDISO's own memory outlives the object otherwise
        if hasattr(self, "_upper") and not sys.is_finalizing():
            self._call(self.RELEASE, np.zeros((1, 1)))


def threads() -> int:
    """Return the number of threads of PARDISO, the first setting of `THREADS`.

    The default is the number of processors.
    """
    setting = next((os.environ[name] for name in THREADS if os.environ.get(name)), "")
    first = setting.partition(",")[0]  # one number for each level of nesting
    return int(first) if first.isdigit() and int(first) else os.cpu_count() or 1


def factorise(K: Sparse) -> Factors:
    """Factorise a symmetric positive definite matrix by PARDISO, or by SuperLU without pypardiso.

    Raises
    ------
    ValueError
        As for `SuperLU`, and if pypardiso is missing and a matrix has more than `LARGEST_SUPERLU`
        rows.
    MemoryError
        As for `Pardiso`.
    """
    try:
        return Pardiso(K)
    except ImportError:
        if K.shape[0] > LARGEST_SUPERLU:
            raise ValueError(
                f"mesh: expected at most {LARGEST_SUPERLU} degrees of freedom without the extra "
                f"`large`, got {K.shape[0]}; run pip install 'piston_cosim[large]'"
            ) from None
        return SuperLU(K)


class Cost(NamedTuple):
    """Measured cost of a factorisation, and the orders by which it grows.

    size : degrees of freedom; seconds : processor time; gigabytes : peak memory.
    """

    size: int
    seconds: float
    gigabytes: float
    order_of_time: float
    order_of_memory: float

    def of(self, size: int) -> tuple[float, float]:
        """Return seconds and gigabytes for a number of degrees of freedom."""
        ratio = size / self.size
        return self.seconds * ratio**self.order_of_time, self.gigabytes * (
            ratio**self.order_of_memory
        )


COSTS = {
    "SuperLU": (Cost(47_880, 3.0, 1.2, 1.5, 1.2), Cost(34_914, 18.0, 2.1, 2.7, 1.6)),
    "PARDISO": (Cost(47_880, 1.0, 0.23, 1.5, 1.2), Cost(34_914, 1.4, 0.24, 2.0, 4 / 3)),
}
"""Costs of a plate two elements thick and of a cube, by solver. The orders are those of nested
dissection for PARDISO, and measured for SuperLU."""


def expected_cost(size: int) -> str:
    """Return a sentence with the expected processor time and memory of a factorisation."""
    solver = "PARDISO" if find_spec("pypardiso") else "SuperLU"
    (least, small), (most, large) = (cost.of(size) for cost in COSTS[solver])
    return (
        f"about {least:.2g} s of processor time and {small:.2g} GB by {solver} if thin-walled, "
        f"{most:.0f} s and {large:.2g} GB if solid"
    )


class CachedFactorise:
    """`factorise` with a cache of all solutions on disk, by the content of matrix and load.

    An eigenvalue solver with the same start vector needs the same solutions again. After an
    interruption, only the factors are recomputed.

    Parameters
    ----------
    folder : Path
        Folder of the solutions. `forget` removes those that this object has used.
    say : callable
        Prints a sentence at the start, then at most every ten seconds.
    """

    def __init__(self, folder: Path | str, say: Callable[[str], None]):
        self.folder = Path(folder)
        self._say = say
        self._used = []

    def __call__(self, K: Sparse) -> Factors:
        """Factorise a matrix, as `factorise` does."""
        folder = self.folder / _digest(K.data, K.indices, K.indptr)
        self._used.append(folder)
        return _CachedFactors(K, folder, self._say)

    def forget(self) -> None:
        """Remove the cached solutions."""
        for folder in self._used:
            shutil.rmtree(folder, ignore_errors=True)


class _CachedFactors:
    """Matrix with solutions on disk.

    It is factorised at once, or if there are solutions, at the first one that is missing.
    """

    EVERY = 10.0  # seconds between sentences

    def __init__(self, K: Sparse, folder: Path, say: Callable[[str], None]):
        self._K = K
        self._folder = folder
        self._say = say
        self._factors = None
        self._count = 0
        self._begin = time.monotonic()
        self._last = self._begin
        if folder.is_dir():
            say(f"continuing with {len(list(folder.glob('*.npy')))} cached solutions")
        else:
            self._factors = self._factorise()
            folder.mkdir(parents=True, exist_ok=True)

    def _factorise(self) -> Factors:
        begin = time.monotonic()
        size = self._K.shape[0]
        self._say(f"factorising {size} degrees of freedom: {expected_cost(size)}")
        factors = factorise(self._K)
        del self._K  # the factors contain all that is needed
        seconds = time.monotonic() - begin
        if seconds > self.EVERY:
            self._say(f"factorised by {type(factors).__name__} in {seconds:.0f} s")
        return factors

    def solve(self, load: np.ndarray) -> np.ndarray:
        """Return K^-1 load, (n,) or (n, k)."""
        load = np.ascontiguousarray(load)
        path = self._folder / f"{_digest(load)}.npy"
        self._count += 1
        with suppress(FileNotFoundError):
            return np.load(path)
        if self._factors is None:
            self._factors = self._factorise()
        answer = self._factors.solve(load)
        part = path.with_suffix(f".{os.getpid()}.part")
        # another process that reduces the same body clears the folder when it has finished
        with suppress(FileNotFoundError):
            with open(part, "wb") as file:
                np.save(file, answer)
            os.replace(part, path)
        if time.monotonic() - self._last > self.EVERY:
            self._last = time.monotonic()
            self._say(f"{self._count} solutions, {self._last - self._begin:.0f} s")
        return answer


def _digest(*arrays: np.ndarray) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(str(array.shape).encode() + np.ascontiguousarray(array).data)
    return digest.hexdigest()[:24]
