"""What `reducing` makes of messages and errors of a reduction."""

import pytest

from piston_cosim.fmu_mfbd.finite_elements.deck import MeshFault
from piston_cosim.fmu_mfbd.reducing import reducing
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.fmi.phases import UNDER_WAY


def test_the_first_message_begins_the_phase():
    said = []
    with reducing("small_end", None, said.append) as say:
        assert not UNDER_WAY
        say("60 modes")
        say("solved")
        assert [one.name for one in UNDER_WAY] == ["reducing small_end"]
    assert not UNDER_WAY
    assert said == ["small_end: 60 modes", "small_end: solved"]


@pytest.mark.parametrize(
    ("error", "table", "faults"),
    [
        (MeshFault(["a.msh: one", "a.msh: two"]), "block", ["a.msh: one", "a.msh: two"]),
        (ValueError("modes: expected 3"), "big_end.shell", ["big_end.shell.modes: expected 3"]),
        (ValueError("modes: expected 3"), "", ["modes: expected 3"]),
        (
            MemoryError(),
            "piston",
            [
                "piston.modes: expected a reduction that fits into memory, got too many nodes or "
                "modes"
            ],
        ),
    ],
)
def test_errors_become_faults_of_the_table(error, table, faults):
    with pytest.raises(BadInput) as raised, reducing("body", None, print, table):
        raise error
    assert raised.value.faults == faults
