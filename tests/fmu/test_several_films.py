"""Several films on one body, each a lubrication FMU of its own.

They equal one film with a groove. The report describes each of them.
"""

from functools import partial

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.commands.common import variant_trees
from piston_cosim.master.engine.answer import headlines
from piston_cosim.master.engine.measures import measures
from piston_cosim.master.engine.sections import special
from piston_cosim.master.engine.verdicts import verdicts

from .films import PATH, several_films
from .runs import run_tree
from .shipped import GRID, GROOVED, with_cut_out

computed = partial(run_tree, PATH)


@pytest.mark.slow
def test_two_films_beside_a_groove_are_one_film_with_a_groove(tmp_path):
    """The same equations are solved together or apart, in steps that agree to 1 pm of film.

    Films of 1e-5 m then differ by at most a tenth of that, motion by a few 1e-9 of its range.
    Friction agrees to 2e-12 until a cavity reaches the groove, and to 2e-7 from then on. The reason
    is not known.
    """
    trees = {"one": with_cut_out(), "two": several_films(GRID, "60 deg", GROOVED)}
    for tree in trees.values():
        for wire in tree["wires"]:
            wire |= {"tolerance": "1 pm"} if "largest_decrease" in wire else {}
            wire |= {"tolerance": 1e-6} if "sliding_velocity" in wire["to"] else {}
    masked, grooved = (computed(tree, tmp_path / f"{name}.h5") for name, tree in trees.items())
    for name in ("lateral_displacement", "rocking_angle", "side_force"):
        one, two = (r.series(f"bodies.{name}").values for r in (masked, grooved))
        assert np.abs(two - one).max() <= 2e-8 * np.ptp(one)
    power = sum(grooved.series(f"film_{k}.friction_power").values for k in (1, 2))
    assert power == pytest.approx(masked.series("ehd.friction_power").values, rel=1e-6)
    joined = [grooved.dataset(f"bodies.band_{k}.film_thickness")[:] for k in (1, 2)]
    whole = masked.dataset("bodies.film_thickness")[:]
    np.testing.assert_allclose(joined[0], whole[:, :, :9], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(joined[1], whole[:, :, 11:], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["two_films", pytest.param("four_films", marks=pytest.mark.slow)])
def test_as_many_iterations_as_with_one(results_of, name):
    """Interface Newton sees one system, however many films it is cut into."""
    one, several = (results_of(n).series("coupling.iterations").values for n in ("one_film", name))
    assert several.sum() <= one.sum() + 2
    assert several.max() <= 4


def test_uncertainty_of_two_films_from_a_second_grid(tmp_path):
    """The case with 21 rows for 40 and 4 deg for 2 deg is the second grid, its ratio is 40/21.

    The factor of the difference is then 1.25/(40/21 - 1), that of an order of 1. The same run
    differs by round-off only.
    """
    short = {"time.stop": "20 deg", "time.step": "2 deg", "record.every": 1}
    own = pc.open_case("grooved_skirt", short).run(tmp_path / "own.h5", uncertainty=True)
    films = ("lower_film", "upper_film")
    rows = {"lower": [1, 10], "upper": [12, 21]}
    second = {
        "time.step": "4 deg",
        "participants.bodies.build.grid": [20, 21],
        "participants.bodies.build.film_surfaces": [
            {"name": name, "rows": ends} for name, ends in rows.items()
        ],
    }
    for film in films:
        second[f"participants.{film}.build.grid"] = [20, 10]
        second[f"participants.{film}.parameters.skirt_length"] = f"{82.8 * 10 / 21:.12g} mm"
    coarse = pc.open_case("grooved_skirt", short | second).run(tmp_path / "coarse.h5")
    assert own.summary and coarse.summary
    for film in films:
        key = f"minimum_film_thickness_{film.removesuffix('_film')}_m"
        difference = 1.25 / (40 / 21 - 1) * (own.summary[key] - coarse.summary[key])
        entry = own.summary[f"uncertainty_grid_minimum_film_thickness_m_{film}"]
        assert entry == pytest.approx(difference, rel=1e-6)
    assert "uncertainty_kept" not in own.summary


def test_a_crown_land_beside_the_skirt(tmp_path):
    """Skirt and motion are those of the piston without a film on its land.

    The gap of the land follows from its shape, the motion of A and the tilt, row by row (Eq. (H1)).
    A tenth full of oil and without pressure, the land holds only the shear in that tenth. This is
    1e-5 of the forces that move the piston.
    """
    path = find_case("grooved_skirt")
    short = [("time.stop", "20 deg"), ("time.step", "2 deg"), ("record.every", 1)]
    tree = variant_trees(path, short, "crown_land")["crown_land"]
    land = run_tree(path, tree, tmp_path / "land.h5")
    alone = computed(read_tree(PATH, short), tmp_path / "alone.h5")
    motion = {}
    for name in ("lateral_displacement", "rocking_angle"):
        motion[name], whole = (r.series(f"bodies.{name}").values for r in (land, alone))
        assert np.abs(motion[name] - whole).max() <= 1e-4 * np.ptp(whole)
    film = land.dataset("bodies.upper.film_thickness")[-1]
    assert film.shape == (40, 6)
    angle = np.arange(40)[:, None] * np.pi / 20
    height = 62.14e-3 + (np.arange(6) + 0.5) * 2.07e-3
    aside = motion["lateral_displacement"][-1] - motion["rocking_angle"][-1] * height
    gap = 50e-6 + 250e-6 + 50e-6 * (1 + np.cos(2 * angle))  # clearance, land, ovality
    np.testing.assert_allclose(film, gap - aside * np.sin(angle), rtol=0, atol=1e-9)


def test_the_report_speaks_of_every_film(results_of):
    grooved = results_of("two_films")
    case = check_case(grooved.case, PATH)
    lines = headlines(measures(case, grooved))
    assert {"minimum film, film_1", "minimum film, film_2"} <= lines.keys()
    power = sum(grooved.series(f"film_{k}.friction_power").values for k in (1, 2))
    mean = np.diff(grooved.time) @ power[1:] / np.ptp(grooved.time)
    assert float(lines["friction"].split()[1]) == pytest.approx(mean, rel=5e-3)  # three digits
    judged = {one.what for one in verdicts(grooved, measures(case, grooved))}
    assert {"film of film_1", "film of film_2"} <= judged
    titles = [one.title for one in special(case, {"r": grooved}).sections]
    assert {"Friction: film_1", "Friction: film_2", "Motion of the piston", "Forces"} <= set(titles)
