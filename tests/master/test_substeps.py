"""Steps of a participant's own, without FMUs: what its inputs and its steps are.

Eq. (X9):  u(t) = 1 + 2 t - 3 t^2 / 2 + 4 t^3 / 6 at t = 1/2: 1.7083333, slopes 1, -1, 4
"""

import numpy as np
import pytest

from piston_cosim.master.fmi.errors import BadInput, Discard, Finished
from piston_cosim.master.participants.substeps import Substeps, shifted
from piston_cosim.master.participants.table import TableParticipant

COURSE = np.array([1.0, 2.0, -3.0, 4.0])


def test_a_polynomial_seen_from_another_point():
    found = shifted(COURSE, 0.5)
    expected = [1 + 1 - 3 / 8 + 4 / 48, 2 - 1.5 + 0.5, -1.0, 4.0]  # Eq. (X9)
    np.testing.assert_allclose(found, expected, rtol=1e-15)
    np.testing.assert_allclose(shifted(found, -0.5), COURSE, rtol=1e-14)


class Note:
    """A participant that notes what it is told."""

    name, ended = "note", ""

    def __init__(self, can_interpolate):
        self.can_interpolate, self.told, self.steps = can_interpolate, [], []

    def set(self, name, value):
        self.told.append(float(value))

    def set_course(self, name, course):
        self.told.append([float(value) for value in course])

    def step(self, time, step):
        self.steps.append((time, step))


def test_the_input_moves_from_step_to_step():
    note = Note(False)
    substeps = Substeps(note, 0.3)
    substeps.set_course("u", np.array([1.0, 2.0]))
    substeps.step(5.0, 1.0)
    assert note.steps == [(5.0, 0.25), (5.25, 0.25), (5.5, 0.25), (5.75, 0.25)]
    assert note.told == [1.5, 2.0, 2.5, 3.0]  # at the end of each of its steps
    note = Note(True)
    substeps = Substeps(note, 0.5)
    substeps.set_course("u", np.array([1.0, 2.0]))
    substeps.step(0.0, 1.0)
    assert note.told == [[1.0, 2.0], [2.0, 2.0]]  # from the beginning of each of its steps


def test_one_step_length_is_kept_to_the_bit():
    note = Note(False)
    substeps = Substeps(note, 0.1, fixed=True)
    substeps.step(0.0, 0.30000000000000004)
    assert [step for _, step in note.steps] == [0.1, 0.1, 0.1]
    with pytest.raises(Discard, match="a multiple of 0.1 s"):
        substeps.step(0.0, 0.25)


def test_the_end_inside_a_macro_step_is_not_its_end():
    note = Note(False)
    note.ended = "enough"
    with pytest.raises(Finished, match="enough"):
        Substeps(note, 0.5).step(0.0, 1.0)
    Substeps(note, 1.0).step(0.0, 1.0)


def signal(folder, text, kind, start=0.0, stop=2.0):
    path = folder / "signal.csv"
    path.write_text(text)
    table = TableParticipant("signal", path, kind)
    table.start({}, start, stop)
    return table


def test_a_table_between_and_at_its_rows(tmp_path):
    text = "# measured\ntime [ms], speed [rpm], lift [mm]\n0, 60, 1\n1000, 120, 2\n2000, 0, 4\n"
    for kind, between in (("hold", 1e-3), ("linear", 1.5e-3)):
        table = signal(tmp_path, text, kind)
        assert table.fields["speed"].unit == "rad.s-1" and table.fields["lift"].unit == "m"
        assert table.get("speed") == pytest.approx(2 * np.pi, rel=1e-14)
        table.step(0.0, 0.5)
        assert table.get("lift") == pytest.approx(between, rel=1e-14)
        saved = table.deserialise(table.serialise(table.save()))
        table.step(0.5, 0.5)
        assert table.get_many(["lift"])["lift"] == pytest.approx(2e-3, rel=1e-14)
        table.restore(saved)
        assert table.get("lift") == pytest.approx(between, rel=1e-14)


def test_a_table_that_ends_too_early(tmp_path):
    text = "time [s], x\n1, 1\n2, 2\n"
    with pytest.raises(BadInput, match="table: expected times from 1 s to 3 s, got"):
        signal(tmp_path, text, "linear", 1.0, 3.0)
    assert signal(tmp_path, text, "hold", 1.0, 3.0).get("x") == 1.0
    with pytest.raises(BadInput, match="expected at least four rows for cubic, got 2"):
        signal(tmp_path, text, "cubic", 1.0, 2.0)
