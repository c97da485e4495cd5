"""What a run records without being asked."""

from types import SimpleNamespace

from piston_cosim.master.runs.recorder import Schedule, recorded_ports


def test_instants_of_runs_in_other_steps_are_the_same_numbers():
    """Steps of a tenth, a third of a tenth, and uneven ones record the same instants.

    They meet multiples of 0.1 s to round-off; the record holds the multiple itself.
    """

    def instants(times):
        schedule = Schedule(1, 0.25, 0.1)
        return [at for k, t in enumerate(times) if (at := schedule.instant(k, t)) is not None]

    tenths = instants([0.25 + k * 0.1 for k in range(30)])
    thirds = instants([0.25 + k * 0.1 / 3 for k in range(88)])
    uneven = instants(sorted([0.25 + 2.9 * k / 29 for k in range(30)] + [0.2501, 0.301, 2.333]))
    assert tenths == thirds == uneven == [0.25 + k * 0.1 for k in range(30)]


def participant(**shapes):
    return SimpleNamespace(
        fields={name: SimpleNamespace(shape=shape) for name, shape in shapes.items()}
    )


def test_rows_of_numbers_that_make_a_state_are_always_recorded():
    """The coordinates and rates of modes and bearings are always recorded, each once.

    Scalars are recorded anyway; of a film only the fields of the case are recorded.
    """
    participants = {
        "bodies": participant(
            lateral_velocity=(),
            modal_coordinate=(60,),
            modal_velocity=(60,),
            bearing_coordinate=(5,),
        ),
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
        "bodies.bearing_coordinate",
    ]
    case.record.fields = []
    for name in ("modal_velocity", "modal_coordinate", "bearing_coordinate"):
        del participants["bodies"].fields[name]  # rigid, with a tied pin
    assert recorded_ports(case, participants) == []
