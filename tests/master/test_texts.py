"""Descriptions of variables, which are the texts below them."""

from typing import Annotated, NamedTuple

import pytest

from piston_cosim.master.fmi.texts import description


class Outputs(NamedTuple):
    """Outputs of a test."""

    speed: Annotated[float, "m/s", 1.0]
    """Speed of the wall; a text of two lines
    becomes one sentence.
    """
    force: Annotated[float, "N", 1.0]


def test_a_description_is_one_sentence_without_its_full_stop():
    expected = "Speed of the wall; a text of two lines becomes one sentence"
    assert description(Outputs, "speed") == expected


def test_a_variable_without_a_description_is_named():
    with pytest.raises(TypeError, match="Outputs.force: expected its description below it"):
        description(Outputs, "force")
