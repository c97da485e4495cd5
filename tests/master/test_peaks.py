"""Position of the pressure peak around a skirt, by hand."""

import numpy as np
import pytest

from piston_cosim.master.case.shown import Axis
from piston_cosim.master.engine.peaks import side_peaks

AXIS = Axis(
    label="angle",
    unit="deg",
    range=(0, 360),
    centred=90,
    marks={"thrust": 90, "anti-thrust": 270},
)
AROUND = 24
"""Cells of 15 deg: 90 deg is cell 6, 270 deg is cell 18."""


def pressures(*instants):
    """Fields (instants, 24, 2) from {cell: pressure}; the upper row holds half of the lower one."""
    fields = np.zeros((len(instants), AROUND, 2))
    for field, cells in zip(fields, instants):
        for cell, value in cells.items():
            field[cell] = value, value / 2
    return fields


def test_peaks_of_both_sides_by_hand():
    thrust, anti = side_peaks(
        AXIS,
        pressures(
            {6: 2.0, 9: 3.0, 18: 1.0},  # 45 deg off, 50 % above the line; anti-thrust on its line
            {6: 2.0, 4: 2.2, 18: 0.4},  # 30 deg off, but 10 % only; anti-thrust below half
            {6: 1.0, 7: 2.0, 18: 0.6},  # one cell of 15 deg off, twice the line's
            {6: 0.5, 3: 1.4},  # below half of the side's highest: not counted
        ),
    )
    assert (thrust.side, anti.side) == ("thrust", "anti-thrust")
    assert (thrust.distance, thrust.excess) == pytest.approx((45.0, 0.5))
    assert thrust.instants == 3 and thrust.share == pytest.approx(2 / 3)
    assert anti[1:] == pytest.approx((0.0, 0.0, 0.0, 2))


def test_an_even_number_of_cells_that_straddles_the_line_has_two_cells_on_it():
    straddled = AXIS.model_copy(update={"centred": 97.5})
    (thrust,) = side_peaks(straddled, pressures({5: 1.0, 6: 2.0, 8: 3.0}))
    assert (thrust.distance, thrust.excess) == pytest.approx((37.5, 0.5))


def test_a_side_without_pressure_has_no_peak():
    assert side_peaks(AXIS, np.zeros((3, AROUND, 2))) == []
