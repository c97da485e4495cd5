"""Public objects in consoles and notebooks: one short line."""

import re

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_mfbd.offline import BodyReport
from piston_cosim.master.results.recorded import RecordedField

LONGEST = 120
PLACE = r"\bat 0x[0-9a-f]+"


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """Kind -> object of all that a user holds."""
    folder = tmp_path_factory.mktemp("shown")
    case = pc.open_case("two_mass_oscillator", {"time.stop": "0.02 s"})
    results = case.run(folder / "run.h5")
    film = pc.Film((8, 4))
    film.start(1e-5, sliding_velocity=1.0)
    fmu = pc.open_fmu(pc.build_fmu("data_sheet", "ehd", options={"grid": [16, 8]}))
    body = BodyReport("piston", [], 10, 5, 30, 0.1, np.zeros(3), np.eye(3), 1.0, 1, [])
    yield {
        "Case": case,
        "Results": results,
        "Plots": results.plot,
        "Series": results.series("left.displacement"),
        "RecordedField": RecordedField(np.ones((8, 4)), 1e-3, "Pa", "Pressure"),
        "Film": film,
        "FMU": fmu,
        "BodyReport": body,
    }
    fmu.close()
    results.close()


KINDS = ["Case", "Results", "Plots", "Series", "RecordedField", "Film", "FMU", "BodyReport"]


@pytest.mark.parametrize("kind", KINDS)
def test_the_repr_is_one_short_line_without_an_address(shown, kind):
    text = repr(shown[kind])
    assert text.startswith(f"<{kind} ") and len(text) <= LONGEST and "\n" not in text
    assert not re.search(PLACE, text)


def test_lines_hold_the_size(shown):
    assert "8 x 4 cells" in repr(shown["Film"])
    assert "3 values from" in repr(shown["Series"])
    assert repr(shown["RecordedField"]) == "<RecordedField Pressure: 8 x 4 values from 1 to 1 Pa>"


def test_the_state_of_a_film_is_one_line(shown):
    assert repr(shown["Film"].state) == "<Memory of a film: 8 x 4 cells>"
