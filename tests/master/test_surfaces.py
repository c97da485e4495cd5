"""Where cylinders and films of an engine are drawn: places by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.engine.stands import side_by_side, stands
from piston_cosim.master.engine.surfaces import films_of, rod_turn
from piston_cosim.master.results.solids import Solid, Stand
from piston_cosim.master.results.words import entry_in_words

from .by_hand import InMemory

INSTANTS = np.array([0.0, 1.0])
SIDES = [np.array([[0.0, -0.02, 0.05], [0.05, 0.03, 0.0], [-0.05, 0.03, 0.0]])]
FILMS = {"low": "skirt", "left": "boss_left", "right": "boss_right", "eye": "small_end"}
CELLS = (6, 2)
MOTION = np.array([[1e-3, 0.2, 0.0], [-2e-3, 0.1, 0.1]])


def wires(body):
    """From each film's surface of a body."""
    return [
        {"from": f"{body}.{surface}.film_thickness", "to": f"{film}.film_thickness"}
        for film, surface in FILMS.items()
    ]


def results(piston, films=FILMS, other=()):
    """Results of a piston on a floating pin at two instants; the crank at 30 and 90 deg."""
    bodies = {
        "role": "bodies",
        "build": {"floating_pin": {"small_end_length": "36 mm"}, "piston": piston},
        "parameters": {"crank_radius": "40 mm", "rod_length": "150 mm", "crank_offset": "2 mm"},
    }
    film = {"role": "lubrication", "parameters": {"bore_radius": "18 mm", "skirt_length": "25 mm"}}
    fields = {f"{name}.pressure": (np.arange(24.0).reshape(2, *CELLS), "Pa") for name in films}
    series = {
        "bodies.crank_angle": (np.radians([30.0, 90.0]), "rad"),
        "bodies.lateral_displacement": (MOTION[:, 0], "m"),
    }
    parts = {"bodies": bodies} | dict.fromkeys(films, film)
    case = {"participants": parts, "wires": [*wires("bodies"), *other]}
    return InMemory(INSTANTS, series, fields, case)


def piston(points, fields):
    count = len(points)
    return Solid(
        "piston",
        points,
        np.zeros((0, 3), int),
        np.zeros((count, 3, 0)),
        np.zeros((2, 0)),
        MOTION,
        film=(-0.02, 0.03),
        fields=fields,
        stand=Stand(0.065),
    )


def test_every_film_of_a_floating_pin_lies_in_its_shell():
    """Bosses beside an eye of 36 mm; those of a mesh where its bore begins, here at 22 mm."""
    said = []
    skirt = {"low.pressure": (-0.02, 0.03)}
    rigid = films_of(results({"rigid": {}}), [piston(*SIDES, skirt)], said.append)
    ends = {one.name: (one.points[:, 2].min(), one.points[:, 2].max()) for one in rigid}
    assert ends["eye"] == pytest.approx((-0.0125, 0.0125))
    assert ends["left"] == pytest.approx((-0.043, -0.018))
    assert ends["right"] == pytest.approx((0.018, 0.043))
    heights = next(one for one in rigid if one.name == "low").points[:, 1]
    assert (heights.min(), heights.max()) == pytest.approx((-0.02, 0.03))
    bore = np.array([[0.018, 0.0, z] for z in (-0.05, -0.022, 0.022, 0.05)])
    meshed = films_of(results({"mesh": "a.inp"}), [piston(bore, skirt)], said.append)
    ends = {one.name: (one.points[:, 2].min(), one.points[:, 2].max()) for one in meshed}
    assert ends["left"] == pytest.approx((-0.047, -0.022))
    assert ends["right"] == pytest.approx((0.022, 0.047))
    assert said == [] and {one.stand for one in meshed} == {Stand(0.065)}
    motions = {one.name: one.motion for one in meshed}
    assert motions["left"] == pytest.approx(MOTION)
    assert motions["low"] == pytest.approx(MOTION * [0, 1, 0])  # on the bore
    assert motions["eye"][:, :2] == pytest.approx(MOTION[:, :2])


def test_the_eye_turns_with_the_rod():
    """As Eq. (K3) has it: sin psi = -(e + x_A + r sin theta)/L; e = -2 mm of the crank's axis."""
    turn = rod_turn(results({"rigid": {}}), "bodies")
    aside = [-0.002 + 1e-3 + 0.04 * 0.5, -0.002 - 2e-3 + 0.04]
    assert 0.15 * np.sin(turn) == pytest.approx(np.negative(aside))


def test_films_of_the_crank_lie_where_it_turns():
    """Crank of 40 mm at 30 and 90 deg, its axis 2 mm beside the bore's: the pin left of it."""
    run = results({"rigid": {}}, {"big": "", "main": ""})
    surfaces = {"big": "big_end", "main": "main_bearing"}
    run.case["wires"] = [
        {"from": f"bodies.{one}.film_thickness", "to": f"{film}.film_thickness"}
        for film, one in surfaces.items()
    ]
    big, main = films_of(run, [], lambda text: None)
    pin = np.array([[0.002 - 0.02, 0.04 * np.sqrt(0.75)], [0.002 - 0.04, 0.0]])
    assert big.motion is not None and main.motion is not None
    assert big.motion[:, :2] == pytest.approx(pin)
    assert big.motion[:, 2] == pytest.approx(rod_turn(run, "bodies"))
    assert main.motion == pytest.approx(np.array([[0.002, 0.0, 0.0]] * 2))
    assert np.hypot(*big.points[:, :2].T) == pytest.approx(np.full(len(big.points), 0.018))


def test_a_film_of_a_place_that_is_not_known_is_left_out_aloud():
    said = []
    found = films_of(results({"rigid": {}}), [piston(*SIDES, {"other": (0.0, 1.0)})], said.append)
    assert [one.name for one in found] == ["left", "right", "eye"]
    assert said == ["low: omitted, because its position is unknown"]


@pytest.mark.parametrize("said", ["parameters", "build"])
def test_cylinders_stand_where_the_block_says(said):
    block = {said: {"cylinder_z": ["-65 mm", "65 mm"], "bank_angle": "30 deg"}}
    run = SimpleNamespace(
        case={
            "participants": {"a": {"role": "bodies"}, "b": {"role": "bodies"}, "block": block},
            "wires": [
                {"from": "b.force_on_block_x", "to": "block.cylinder_1.force_x"},
                {"from": "a.force_on_block_x", "to": "block.cylinder_2.force_x"},
            ],
        }
    )
    expected = {"b": Stand(-0.065, np.radians(30)), "a": Stand(0.065, np.radians(30))}
    assert {name: tuple(one) for name, one in stands(run).items()} == {
        name: pytest.approx(tuple(one)) for name, one in expected.items()
    }


def test_cylinders_of_which_nothing_is_said_do_not_touch():
    bodies = [piston(*SIDES, {}), piston(*SIDES, {})]
    placed = side_by_side([bodies[0], Solid("piston", *vars_of(bodies[1]), owner="rear")])
    assert [one.stand.along for one in placed] == pytest.approx([-0.075, 0.075])  # 3 radii apart


def vars_of(solid):
    return solid.points, solid.triangles, solid.modes, solid.coordinates


def test_entries_of_a_summary_in_words():
    words = {
        "mean_friction_power_w": "mean friction power [W]",
        "mean_supply_m3_s": "mean supply [m³/s]",
        "block_velocity_y_max_m_s": "block velocity y max [m/s]",
        "mount_moment_z_min_nm": "mount moment z min [N m]",
        "contact_share": "contact share",
    }
    assert {name: entry_in_words(name) for name in words} == words
