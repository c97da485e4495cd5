"""Moving pictures of recorded fields."""

import pytest
from PIL import Image

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results import movie
from piston_cosim.master.results.movie import PER_SECOND, write_movie
from piston_cosim.master.results.pictures import draw_values

from .test_page import INSTANTS, TREE, written


@pytest.fixture
def case():
    return check_case(TREE, "case.toml")


@pytest.fixture
def results(tmp_path):
    with written(tmp_path / "run.h5") as one:
        yield one


def test_every_chosen_instant_is_a_frame(case, results, tmp_path, monkeypatch):
    shown = []

    def looked_at(panel, one, row):
        shown.append((one.values.copy(), row.low, row.high))
        draw_values(panel, one, row)

    monkeypatch.setattr(movie, "draw_values", looked_at)
    target = tmp_path / "run.gif"
    chosen = write_movie(case, results, ["bodies.film_thickness"], 4, target)
    assert chosen.tolist() == [0, 6, 12, INSTANTS - 1]
    with Image.open(target) as picture:
        assert picture.n_frames == 4
        # a gif counts in hundredths of a second
        assert picture.info["duration"] == pytest.approx(1000 / PER_SECOND, abs=10)
    held = results.dataset("bodies.film_thickness")[:][chosen] * 1e6
    there = results.there("bodies.film_thickness")
    for (image, low, high), values in zip(shown, held, strict=True):
        assert image.data[there] == pytest.approx(values[there])
        assert (low, high) == pytest.approx((held[:, there].min(), held[:, there].max()))


def test_without_fields_those_of_the_case(case, results, tmp_path):
    assert len(write_movie(case, results, [], 2, tmp_path / "run.gif")) == 2
    assert (tmp_path / "run.gif").stat().st_size > 1000


def test_a_run_without_maps_needs_fields(results, tmp_path):
    case = check_case({k: v for k, v in TREE.items() if k != "pictures"}, "case.toml")
    with pytest.raises(BadInput, match=r"expected one of bodies\.film_thickness,"):
        write_movie(case, results, [], 5, tmp_path / "a.gif")
