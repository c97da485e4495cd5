"""A film has no cells where the piston's mesh has no skirt, unless the case says otherwise."""

from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.given import build_options
from piston_cosim.master.case.reading import find_case, read_tree

PATH = find_case("fired_motorcycle")


def builds(grid=None, **film):
    """Build options of the shipped case's participants, rigid, with changes of the film's."""
    tree = read_tree(PATH)
    if grid:
        for participant in ("bodies", "ehd"):
            tree["participants"][participant]["build"]["grid"] = grid
    for body in ("piston", "block"):
        tree["participants"]["bodies"]["build"][body]["modes"] = 0
    tree["participants"]["ehd"]["build"] |= film
    return build_options(check_case(tree, PATH), Path(PATH).parent, lambda text: None)


@pytest.fixture(autouse=True, scope="module")
def own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PISTON_COSIM_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


def test_the_film_has_the_skirt_of_the_mesh():
    """The shipped skirt is whole but for both pin holes (17 mm, at 0 and 180 deg)."""
    mask = np.array(builds()["ehd"]["mask"])
    assert mask.shape == (40, 40)
    assert mask[0, 20] == mask[20, 20] == 0  # on the pin axis, at its height
    assert mask[3:18].all() and mask[23:38].all()
    # a hole of 8.5 mm in a cylinder of 36.5 mm, in cells of 5.73 x 0.675 mm: 1 % of its area
    gone = (mask == 0).sum() / 2.0 * 5.73 * 0.675
    assert gone == pytest.approx(np.pi * 8.5**2, rel=0.05)


@pytest.mark.parametrize("mask", ["none", "own.csv"])
def test_what_the_case_says_stands(mask):
    assert builds(mask=mask)["ehd"]["mask"] == mask
