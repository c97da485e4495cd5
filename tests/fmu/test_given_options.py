"""A film has no cells where the piston's mesh has no skirt, unless the case says otherwise."""

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.given import build_options
from piston_cosim.master.case.reading import find_case, read_tree

PATH = find_case("fired_motorcycle")


def mask(surfaces=None, wires=(), **film):
    """Mask of the film of the shipped case, rigid, with changes of surfaces, wires and film."""
    tree = read_tree(PATH)
    bodies = tree["participants"]["bodies"]["build"]
    for body in ("piston", "block"):
        bodies[body]["modes"] = 0
    bodies |= {"film_surfaces": surfaces} if surfaces else {}
    tree["participants"]["ehd"]["build"] |= film
    tree["wires"] = [*wires] or tree["wires"]
    options = build_options(check_case(tree, PATH), PATH.parent, lambda text: None)
    return options["ehd"]["mask"]


@pytest.fixture(autouse=True, scope="module")
def own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PISTON_COSIM_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


def test_the_film_has_the_skirt_of_the_mesh():
    """The shipped skirt is whole but for both pin holes (17 mm, at 0 and 180 deg)."""
    cells = np.array(mask())
    assert cells.shape == (40, 40)
    assert cells[0, 20] == cells[20, 20] == 0  # on the pin axis, at its height
    assert cells[3:18].all() and cells[23:38].all()
    # a hole of 8.5 mm in a cylinder of 36.5 mm, in cells of 5.73 x 0.675 mm: 1 % of its area
    gone = (cells == 0).sum() / 2.0 * 5.73 * 0.675
    assert gone == pytest.approx(np.pi * 8.5**2, rel=0.05)
    # of one of two surfaces: its own rows
    ends = ("film_thickness", "sliding_velocity", "_pressure_force", "_friction_force")
    wires = [
        {
            key: text.replace("bodies.", "bodies.upper.") if str(text).endswith(ends) else text
            for key, text in wire.items()
        }
        for wire in read_tree(PATH)["wires"]
    ]
    surfaces = [{"name": "lower", "rows": [1, 18]}, {"name": "upper", "rows": [19, 40]}]
    np.testing.assert_array_equal(mask(surfaces, wires, grid=[40, 22]), cells[:, 18:])


@pytest.mark.parametrize("given", ["none", "own.csv"])
def test_what_the_case_says_stands(given):
    assert mask(mask=given) == given
