"""A run judged: every limit from both sides, on results made by hand."""

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.engine.answer import answer, headlines, row_of
from piston_cosim.master.engine.friction import (
    contact_share,
    friction_pressure,
    friction_pressures,
)
from piston_cosim.master.engine.measures import DESIGN, measures
from piston_cosim.master.engine.oil_balance import oil_balance
from piston_cosim.master.engine.verdicts import bdf2_error, verdicts
from piston_cosim.master.results.words import entry_shown

from .by_hand import write_results

PATH = find_case("data_sheet")
ROUGHNESS = 0.54e-6


def judged(folder, **given):
    """Return {what: verdict} of the run of `made`."""
    with made(folder, **given) as results:
        case = check_case(results.case, PATH)
        return {one.what: one for one in verdicts(results, measures(case, results))}


def made(
    folder, film=5e-6, pressure=3e6, periods=2, knock=0.0, field=None, tree=None, more=(), **summary
):
    """Write results of `periods` periods of 720 deg in steps of 10 deg.

    In the first period the film is half as thick and all else is twice as large.
    The side force is 1 kN sin(phi/2), in phase with its demand from gas and inertia.
    `knock` times the same amplitude is added 90 deg out of phase.
    `field`: pressure and film fraction at two instants; `more`: other columns.
    """
    tree = tree or read_tree(PATH)
    angle = np.radians(np.arange(-360, 720 * periods - 359, 10.0))
    begins = np.arange(angle.size) >= angle.size - 73
    columns = {
        "bodies/crank_angle": (angle, "rad"),
        "bodies/lateral_displacement": (np.sin(angle / 2) * 1e-5, "m"),
        "ehd/minimum_film_thickness": (
            film + 5e-6 * (np.arange(angle.size) != angle.size - 72),
            "m",
        ),
        "ehd/maximum_pressure": (np.full(angle.size, pressure), "Pa"),
        "bodies/side_force_demand": (1e3 * np.sin(angle / 2), "N"),
        "bodies/side_force": (1e3 * (np.sin(angle / 2) + knock * np.cos(angle / 2)), "N"),
        "bodies/piston_position": (0.2 + 0.072 * np.cos(angle), "m"),
        "ehd/friction_power": (100.0 + 40.0 * np.cos(angle), "W"),
        "ehd/boundary_friction_share": (np.full(angle.size, 0.04), "1"),
        "ehd/contact_area_fraction": (np.full(angle.size, 1e-3), "1"),
        "bodies/piston_kinetic_energy": (2e-3 * np.cos(angle / 4) ** 2, "J"),
        "bodies/lower_edge_velocity": (np.full(angle.size, -0.05), "m/s"),
        "bodies/upper_edge_velocity": (np.full(angle.size, 0.04), "m/s"),
        "bodies/rocking_angle": (np.radians(0.1) * np.sin(angle / 2), "rad"),
        "ehd/oil_in_film": (np.full(angle.size, 3e-7), "m3"),
        "ehd/flow_lower_edge": (1e-7 * np.cos(angle) + 2e-8, "m3/s"),
        "ehd/flow_upper_edge": (np.full(angle.size, -2e-8), "m3/s"),
        "ehd/flow_openings": (np.zeros(angle.size), "m3/s"),
    }
    gap = np.full((2, 40, 40), 1e-5)
    gap[1, 30, 9] = film  # cell 31 of 40 has its centre on 270 deg
    gap[1, 5, 5] = 0.2 * film  # less than the film is anywhere: there is none
    for name, (values, unit) in columns.items():
        early = 1.0 if name == "bodies/crank_angle" else 0.5 if "minimum" in name else 2.0
        columns[name] = values * np.where(begins, 1.0, early), unit
    fields = {"bodies/film_thickness": (gap, "m")}
    if field is not None:
        fields |= {"ehd/pressure": (field[0], "Pa"), "ehd/film_fraction": (field[1], "1")}
    said = {"steps": 10, "unconverged_steps": 0, "interface_work_imbalance": 0.0} | summary
    time = (angle - angle[0]) / 100.0
    return write_results(
        folder / "run.h5",
        time,
        columns | dict(more),
        fields,
        time[-73:-71] if periods >= 1 else time[:2],
        case=tree,
        summary=said | {"periods": int(periods)},
        period={"length": 4 * np.pi / 100.0, "shown": 0, "turning": ["bodies.crank_angle"]},
    )


def missed(share, **of_bodies):
    """Summary entries of a run whose modes leave out so much of the film thickness."""
    errors = {f"truncation_error_{body}": error for body, error in of_bodies.items()}
    return errors if share is None else errors | {"truncation_error_film": share}


def settled(distance):
    """Summary entries of a run whose last period is so far from the one before."""
    return {"periodic": distance < 1e-3, "settled": "In words", "period_distance": distance}


def test_without_conjugates_there_is_no_energy_balance(tmp_path):
    tree = read_tree(PATH)
    for wire in tree["wires"]:
        wire.pop("conjugate", None)
    balance = judged(tmp_path, tree=tree)["energy balance"]
    assert balance.colour == "amber" and '"ehd.nodal_pressure_force"' in balance.text


def test_a_sound_run_is_green_whatever_its_first_period_was(tmp_path):
    """The film of the first one, 2.5 um, would do; its side force is twice what is asked for."""
    found = judged(tmp_path, **settled(2e-4))
    assert {one.colour for one in found.values()} == {"green"}
    assert set(found) == {
        "convergence",
        "interface work",
        "film",
        "pressure",
        "side force",
        "periodicity",
    }
    assert found["periodicity"].text == "In words."


def ledgered(refused=0, share=0.049, made=0.0):
    """Summary entries of the ledger: two participants that exchanged 2 J, one took more."""
    return {
        "energy_refused_steps": refused,
        "energy_created_share_max": share,
        "energy_taken_ehd_j": -2.0,
        "energy_taken_bodies_j": 2.0 + 2.0 * made if made < 0 else 2.0 / (1.0 - made),
    }


@pytest.mark.parametrize(
    "given, what, colour",
    [
        ({"film": 3.01 * ROUGHNESS}, "film", "green"),
        ({"film": 2.99 * ROUGHNESS}, "film", "amber"),
        ({"film": 0.99 * ROUGHNESS}, "film", "red"),
        ({"pressure": 49e6}, "pressure", "green"),
        ({"pressure": 51e6}, "pressure", "amber"),
        ({"pressure": 101e6}, "pressure", "red"),
        (settled(9e-4), "periodicity", "green"),
        (settled(2e-3), "periodicity", "amber"),
        ({"knock": 0.24}, "side force", "green"),
        ({"knock": 0.26}, "side force", "amber"),
        ({"knock": 0.76}, "side force", "red"),
        ({"unconverged_steps": 1}, "convergence", "red"),
        ({"unsettled_steps": 1}, "convergence", "amber"),
        ({"interface_work_imbalance": -2e-3}, "interface work", "amber"),
        ({"interface_work_imbalance": 0.02}, "interface work", "red"),
        ({"interface_work_imbalance": float("nan")}, "interface work", "red"),
        (ledgered(), "energy balance", "green"),
        (ledgered(refused=1), "energy balance", "amber"),
        (ledgered(share=0.051), "energy balance", "amber"),
        (ledgered(made=0.0009), "energy balance", "green"),
        (ledgered(made=0.0011), "energy balance", "amber"),
        (ledgered(made=0.011), "energy balance", "red"),
        (ledgered(made=-0.2, share=-float("inf")), "energy balance", "green"),
        (missed(0.0199, piston=0.3), "truncation", "green"),
        (missed(0.021, block=1e-4), "truncation", "amber"),
        (missed(0.11, piston=1e-4), "truncation", "red"),
        (missed(None, piston=1e-4), "truncation", "amber"),
        (missed(0.01, piston=0.01) | {"odd_part_film": 0.019}, "symmetry", "green"),
        (missed(0.01, piston=0.01) | {"odd_part_film": 0.021}, "symmetry", "red"),
        ({"truncation_error": "unknown: recorded once"}, "truncation", "amber"),
    ],
)
def test_limits(given, what, colour, tmp_path):
    assert judged(tmp_path, **given)[what].colour == colour


def test_a_rigid_skirt_overstates_the_pressure(tmp_path):
    hint = "A rigid skirt does not yield, so it overstates the pressure. Make it flexible: "
    assert hint in judged(tmp_path, pressure=51e6)["pressure"].text
    assert hint not in judged(tmp_path, pressure=49e6)["pressure"].text
    tree = read_tree(PATH)
    piston = tree["participants"]["bodies"]["build"]["piston"]
    del piston["rigid"]
    assert hint not in judged(tmp_path, pressure=51e6, tree=tree)["pressure"].text
    piston["modes"] = 0
    assert hint in judged(tmp_path, pressure=51e6, tree=tree)["pressure"].text


def test_what_the_modes_of_each_body_miss(tmp_path):
    found = judged(tmp_path, **missed(0.0275, piston=0.004, block=0.0175))
    assert found["truncation"].text == (
        "The truncation error of the modes is at most 2.8 % of the local film thickness "
        "(limit 2 %). It is 0.4 % of the piston deflection and 1.8 % of the block deflection. "
        "Increase piston.modes and block.modes."
    )
    edge = judged(tmp_path, **missed(0.01, piston=0.004, edge=0.18))["truncation"].text
    assert edge.endswith("Under a narrow patch at an edge of the skirt, the modes miss up to 18 %.")
    other = judged(tmp_path, **missed(None, block=0.0175))["truncation"].text
    assert "Record film_thickness of the bodies (record.fields)" in other


def test_the_worst_place_by_side_angle_and_height(tmp_path):
    said = judged(tmp_path)["film"].text
    # row 10 of 40 has its centre at 9.5/40 of the skirt
    assert (
        "anti-thrust side, angle from the pin axis 270 deg, height above the pin -25.8 mm" in said
    )
    assert "9.26 times the roughness" in said  # 5/0.54


def hill(width_around, width_along, cells=40, closed=0, at=9, full=10):
    """Return the pressure and the film fraction at two instants.

    The pressure is 0, then a box with its corner at (`at`, 20), where the film is full over `full`
    cells along. `closed` cells around and 4 cells along about (0, 30) have no film.
    """
    pressure, fraction = np.zeros((2, cells, 40)), np.full((2, cells, 40), 0.95)
    fraction[1] = 0.9
    around = np.arange(at, at + width_around) % cells
    pressure[1][np.ix_(around, np.arange(20, 20 + width_along))] = 1e6
    fraction[1][np.ix_(around, np.arange(27 - full, 27))] = 1.0
    fraction[np.ix_([0, 1], (np.arange(closed) - closed // 2) % cells, np.arange(28, 32))] = 1.0
    return pressure, fraction


@pytest.mark.parametrize(
    "field, colour, sentence",
    [
        (hill(4, 5), "green", "4 cells around and 5 along"),
        (hill(4, 5, full=0), "green", "4 cells around and 5 along"),
        (hill(5, 3), "amber", "5 cells around and 3 along"),
        (hill(1, 5), "red", "1 cell around"),
        (hill(6, 6, at=37), "green", "6 cells around"),  # across the seam of the ring
        (hill(4, 4, cells=41), "amber", "41 cells around are odd"),
        (hill(4, 4, closed=3), "green", "4 cells around and 4 along"),
        (hill(4, 4, closed=2), "amber", "An opening in the film is 2 cells wide"),
        (hill(4, 5, full=9), "amber", "The full film at the peak is 9 cells long (minimum 10)"),
    ],
)
def test_a_grid_too_coarse_for_what_was_found(tmp_path, field, colour, sentence):
    grid = judged(tmp_path, field=field)["grid"]
    assert grid.colour == colour and sentence in grid.text


def test_the_first_screen_by_hand(tmp_path):
    """The first screen shows the last period alone.

    The mean power is 100 W over a period of 4 pi/100 s, the volume pi 55^2 144 mm^3.
    The FMEP is then 9.182 kPa (Eq. (X12)).
    """
    volume = np.pi * 0.055**2 * 0.144
    with made(tmp_path, wall_time_s=3.0, **settled(2e-4)) as results:
        case = check_case(results.case, PATH)
        # whole periods of a cosine: trapezia are exact
        expected = 100.0 * 4 * np.pi / 100.0 / volume
        assert friction_pressure(results) == pytest.approx(expected, rel=1e-12)
        each = friction_pressures(results)
        first, last = (cycle.pressure for cycle in each)
        assert last == pytest.approx(expected, rel=1e-12)
        # twice the power but in its last row, of (140 + 280)/2 W for 10 deg, and the stroke
        assert first == pytest.approx(expected - 70.0 * np.radians(10) / 200 / volume, rel=1e-9)
        assert np.degrees([cycle.end for cycle in each]) == pytest.approx([360.0, 1080.0])
        shown = answer(case, results)
    said = shown.lines
    assert said["friction"] == "mean 100 W, FMEP 9.18 kPa over 720 deg"
    assert (
        said["minimum film"]
        == "5 µm at 370 deg, anti-thrust side, 270 deg, height above the pin -25.8 mm"
    )
    assert said["maximum pressure"] == "3 MPa at 360 deg"
    assert said["asperity contact"] == "4 % of the friction work, on at most 0.1 % of the skirt"
    assert said["side force"] == (
        "1 kN on the anti-thrust side at 540 deg; demand 1 kN on the anti-thrust side at 540 deg"
    )
    assert said["slap"] == (
        "2 mJ lost at 720 deg, lower edge at 50 mm/s on the anti-thrust side, "
        "height above the pin -45.5 mm"
    )
    assert said["lateral motion"] == "-10 to 10 µm"
    assert said["rocking angle"] == "-0.1 to 0.1 deg"
    assert said["oil"] == (
        "net 2.51 mm³ in through the lower edge, 2.51 mm³ out through the upper edge per period; "
        "throughput 5.33 mm³"
    )
    assert said["periodicity"] == "change of 0.0002 between the last two periods"
    assert said["run"] == "1440 deg (2 periods) in 10 steps, wall time 3 s"
    assert said["checks"] == "6 pass"
    assert len(shown.lines) <= 12


def test_a_row_of_a_sweep_by_hand(tmp_path):
    """The row has the measures, why their uncertainty is unknown, and the worst check."""
    with made(tmp_path, pressure=60e6) as results:
        row = row_of(check_case(results.case, PATH), results.path)
    assert row["minimum_film_thickness_m"] == 5e-6
    assert row["largest_rocking_angle_rad"] == pytest.approx(np.radians(0.1))
    assert row["slap_energy_j"] == pytest.approx(2e-3) and row["contact_share"] == pytest.approx(
        0.04
    )
    assert row["slap_energy_j_uncertainty"] == "record.fields lacks ehd.pressure"
    assert row["worst_check"] == "warning: pressure"
    assert not any(isinstance(value, dict) for value in row.values())


def test_a_measure_has_one_name_in_lines_and_tables(tmp_path):
    with made(tmp_path) as results:
        table = measures(check_case(results.case, PATH), results)
    for key in DESIGN:
        assert entry_shown(key, [1.0]).words == table.worst(key).label


def test_entries_of_a_sweep_have_the_uncertainty_of_equal_measures(tmp_path):
    """The largest side force is the maximum, 1 kN, and there is no contact at all."""
    more = {"ehd/contact_area_fraction": (np.zeros(145), "1")}
    with made(tmp_path, more=more, side_force_max_n=1e3) as results:
        case = check_case(results.case, PATH)
        row, force = (
            row_of(case, results.path),
            measures(case, results).of("side_force_n", "bodies"),
        )
    assert row["side_force_max_n_uncertainty"] == force.uncertainty.reason != ""
    assert row["contact_share_uncertainty"] == 0.0
    assert "lateral_displacement_min_m_uncertainty" not in row


def test_a_run_shorter_than_a_period_has_no_fmep_and_no_oil_per_period(tmp_path):
    with made(tmp_path, periods=0.5) as results:
        assert oil_balance(results, "ehd") is None
        assert "oil" not in headlines(measures(check_case(results.case, PATH), results))
        assert friction_pressure(results) is None


def test_contact_share_of_the_last_period_by_hand(tmp_path):
    """The contact share is that of the last period.

    The power is 1 W for 1 s, then 3 W for 1 s. The shares since the start, 0.5 and 0.2, are 0.5 J
    and 0.8 J of contact. The last period has 0.3 J of its 3 J.
    """
    with write_results(
        tmp_path / "run.h5",
        [0.0, 1.0, 2.0],
        {
            "ehd.friction_power": ([0.0, 1.0, 3.0], "W"),
            "ehd.boundary_friction_share": ([0.0, 0.5, 0.2], "1"),
        },
        case={"participants": {"ehd": {"role": "lubrication"}}},
        period={"length": 1.0, "shown": 1, "turning": []},
    ) as results:
        assert results.time.tolist() == [0.0, 1.0]
        assert contact_share(results, "ehd") == pytest.approx(0.1, rel=1e-12)


def test_local_error_of_bdf2_is_exact_for_a_cubic():
    """The cubic 3 t^3 has x'''/6 = 3, and steps of 1.5 after 0.5, then of 1 after 1.5."""
    time = np.array([0.0, 1.0, 1.5, 3.0, 4.0])
    wanted = [3 * (1.5 * 2.0) ** 2 / 3.5, 3 * (1.0 * 2.5) ** 2 / 3.5]
    assert bdf2_error(time, 3.0 * time**3) == pytest.approx(wanted)


@pytest.mark.parametrize("turn, colour", [(18.0, "green"), (23.0, "amber")])
def test_play_of_a_pin_is_judged_by_its_error_over_the_range(tmp_path, turn, colour):
    """The play of a pin is judged by its error over its range.

    The oscillation turns by `turn` a step, so that its local error is turn^3/9 of its range.
    Four times that is 1.4 % with 18 deg and 2.9 % with 23 deg.
    """
    angle = np.radians(turn) * np.arange(145)
    names = ("pin_displacement", "small_end_displacement")
    more = {f"bodies/{name}_{axis}": (1e-6 * np.cos(angle), "m") for name in names for axis in "xy"}
    assert judged(tmp_path, more=more)["play of the pin"].colour == colour
