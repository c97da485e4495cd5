"""A case whose film is its own mirror image computes one half of it, with the same results."""

from typing import Any

import h5py
import numpy as np

from .runs import EXAMPLE, run_tree, small_tree

ROUND_OFF = ("_error", "mass_imbalance")
"""Ends of the names of outputs that consist of round-off."""


def curves(path):
    """Return the recorded numbers and fields over the steps by name."""
    with h5py.File(path) as file:
        groups: Any = file
        return {
            f"{owner}.{name}": one[:]
            for owner in ("ehd", "bodies")
            for name, one in groups[owner].items()
            if not name.endswith(ROUND_OFF)
        }


def test_a_run_with_half_of_the_film_has_the_curves_of_the_whole_one(tmp_path):
    """Both runs take the same iterations, so that their curves differ by round-off alone."""
    found = []
    for symmetric in (True, False):
        tree = small_tree(("symmetric", symmetric), ("native", False), ("time.stop", "40 deg"))
        run_tree(EXAMPLE, tree, tmp_path / "o.h5").close()
        found.append(curves(tmp_path / "o.h5"))
    half, whole = found
    assert half.keys() == whole.keys()
    off = {name: np.abs(half[name] - curve).max() for name, curve in whole.items()}
    assert {n: d for n, d in off.items() if d > 1e-9 * np.abs(whole[n]).max()} == {}
