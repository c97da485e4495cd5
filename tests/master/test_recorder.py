"""What a run records without being asked."""

from types import SimpleNamespace

from piston_cosim.master.runs.recorder import recorded_ports


def participant(**shapes):
    return SimpleNamespace(
        fields={name: SimpleNamespace(shape=shape) for name, shape in shapes.items()}
    )


def test_rows_of_numbers_that_make_a_state_are_always_recorded():
    """Of what the contract has bodies repeat: modal coordinates and their rates, not scalars, which
    are recorded anyway; each once; of a film nothing more than the case says.
    """
    participants = {
        "bodies": participant(lateral_velocity=(), modal_coordinate=(60,), modal_velocity=(60,)),
        "ehd": participant(film_fraction=(40, 40), oil_in_film=()),
        "other": participant(modal_coordinate=(3,)),
    }
    roles = {"bodies": "bodies", "ehd": "lubrication", "other": None}
    case = SimpleNamespace(
        participants={name: SimpleNamespace(role=role) for name, role in roles.items()},
        record=SimpleNamespace(fields=["bodies.modal_velocity", "ehd.pressure"]),
    )
    assert recorded_ports(case, participants) == [
        "bodies.modal_velocity",
        "ehd.pressure",
        "bodies.modal_coordinate",
    ]
    case.record.fields = []
    del (
        participants["bodies"].fields["modal_velocity"],
        participants["bodies"].fields["modal_coordinate"],
    )  # rigid
    assert recorded_ports(case, participants) == []
