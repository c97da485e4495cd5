"""A film has no cells where the piston's mesh has no skirt, unless the case says otherwise."""

from pathlib import Path

import numpy as np
import pytest

from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.given import build_options
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

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


def test_oil_is_kept_on_the_shipped_skirt():
    """Film, bore and edges hold what ring and splash brought, over four strokes."""
    grid = [20, 20]
    mask = np.array(builds(grid)["ehd"]["mask"]) == 0
    assert 20 <= mask.sum() <= 40  # 7 % of it
    p = Parameters((20, 20), oil_supply="bore_and_ring", initial_oil_layer=5e-6, open_cells=mask)
    model = LubricationModel(p)
    state, outputs = model.start(*motored_film(p.shape, 0.0))
    before = outputs["oil_in_film"] + outputs["oil_on_bore"]
    for k in range(1, 2 * 360 + 1):
        inputs = motored_film(p.shape, (k % 360) * DEGREE)
        state, outputs = model.advance(state, *inputs, DEGREE, oil_splash=1e-5)
        oil = outputs["oil_in_film"] + outputs["oil_on_bore"]
        assert oil - outputs["oil_supplied"] == pytest.approx(before, rel=1e-10)  # round-off
    assert state.layer.spilled.any()  # pressure drives some into the pin holes


@pytest.mark.parametrize("mask", ["none", "own.csv"])
def test_what_the_case_says_stands(mask):
    assert builds(mask=mask)["ehd"]["mask"] == mask
