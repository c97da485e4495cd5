"""Moving pictures of recorded fields."""

import numpy as np
import pytest
from PIL import Image

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.shown import NEUTRAL
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results import movie
from piston_cosim.master.results.maps import FieldMap, Layer, map_row, masked
from piston_cosim.master.results.movie import PER_SECOND, write_movie
from piston_cosim.master.results.pictures import draw_values, map_figure

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
    exists = results.existing_cells("bodies.film_thickness")
    for (image, low, high), values in zip(shown, held, strict=True):
        assert image.data[exists] == pytest.approx(values[exists])
        assert (low, high) == pytest.approx((held[:, exists].min(), held[:, exists].max()))


def test_the_legend_has_the_lines_and_marks_of_all_instants():
    """The second instant alone has pressure, and a film that ruptures."""
    height = np.tile(np.arange(4.0), (8, 1))
    first, second = (
        FieldMap(
            "p [MPa]",
            "pressure",
            NEUTRAL,
            "",
            {
                "pressure": Layer(masked(pressure, None), "MPa"),
                "fraction": Layer(masked(fraction, None), ""),
            },
        )
        for pressure, fraction in ((0 * height, 1 + height), (height, height))
    )
    figure, panels = map_figure([map_row([first, second])], 1)
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert panels.shape == (1, 1)
    assert words == ["highest pressure", "film ruptures (film fraction 0.99)"]


def test_without_fields_those_of_the_case(case, results, tmp_path):
    assert len(write_movie(case, results, [], 2, tmp_path / "run.gif")) == 2
    assert (tmp_path / "run.gif").stat().st_size > 1000


def test_a_run_without_maps_needs_fields(results, tmp_path):
    case = check_case({k: v for k, v in TREE.items() if k != "pictures"}, "case.toml")
    with pytest.raises(BadInput, match=r"expected one of bodies\.film_thickness,"):
        write_movie(case, results, [], 5, tmp_path / "a.gif")
