"""A case whose film is its own mirror image computes one half of it, with the same results."""

import h5py
import numpy as np

from .runs import EXAMPLE, run_tree, small_tree


def curves(path):
    """Return the recorded numbers and fields over the steps by name."""
    found = {}
    with h5py.File(path) as file:
        for owner in ("ehd", "bodies"):
            found |= {f"{owner}.{name}": one[:] for name, one in file[owner].items()}
    return found


def test_a_run_with_half_of_the_film_has_the_curves_of_the_whole_one(tmp_path):
    """Both runs take the same iterations, so that their curves differ by round-off alone."""
    found = []
    for symmetric in (True, False):
        tree = small_tree(("symmetric", symmetric), ("native", False), ("time.stop", "40 deg"))
        run_tree(EXAMPLE, tree, tmp_path / "o.h5").close()
        found.append(curves(tmp_path / "o.h5"))
    half, whole = found
    assert half.keys() == whole.keys()
    for name in whole.keys() - {"ehd.mass_imbalance"}:
        a, b = whole[name], half[name]
        assert np.abs(a - b).max() <= 1e-9 * max(np.ptp(a), np.abs(a).max()), name
