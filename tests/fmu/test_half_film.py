"""A case whose film is its own mirror image computes one half of it, with the same results."""

import numpy as np

from piston_cosim.master.fmi.symmetry import odd_part

from .runs import EXAMPLE, datasets, run_tree, small_tree

ROUND_OFF = ("_error", "mass_imbalance")
"""Ends of the names of outputs that consist of round-off."""


def test_a_run_with_half_of_the_film_has_the_curves_of_the_whole_one(tmp_path):
    """Both runs take the same iterations, so that their curves differ by round-off alone.

    Remembered products multiply round-off to 1e-5 of the tolerance, which is therefore tight.
    """
    found = []
    exact = ("wires.0.tolerance", "0.01 nm"), ("wires.1.tolerance", 1e-8)
    for whole in ([], [("symmetric", False)]):
        tree = small_tree(*whole, ("native", False), ("time.stop", "40 deg"), *exact)
        run_tree(EXAMPLE, tree, tmp_path / "o.h5").close()
        found.append(datasets(tmp_path / "o.h5"))
    half, whole = found
    assert not odd_part(half["fields/ehd/pressure"], 1).any()
    assert odd_part(whole["fields/ehd/pressure"], 1).any()
    assert half.keys() == whole.keys()
    curves = [n for n in whole if ("ehd/" in n or "bodies/" in n) and not n.endswith(ROUND_OFF)]
    assert "fields/ehd/pressure" in curves and "bodies/lateral_displacement" in curves
    for name in curves:
        assert np.abs(half[name] - whole[name]).max() <= 1e-9 * np.abs(whole[name]).max(), name
