"""What a report of a piston shows beyond the case's pictures: values by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import find_peaks

from piston_cosim.master.case.schema import Case
from piston_cosim.master.engine import sections
from piston_cosim.master.engine.answer import headlines
from piston_cosim.master.engine.friction import friction_pressure
from piston_cosim.master.engine.impacts import impacts, prominent_peaks
from piston_cosim.master.engine.measures import measures
from piston_cosim.master.engine.sections import STROKES, own_strokes, special, strokes
from piston_cosim.master.engine.verdicts import verdicts
from piston_cosim.master.results.recorded import Envelope
from piston_cosim.master.results.words import handy_unit, names_of

from .by_hand import InMemory

BODIES = {"bodies": {"role": "bodies"}, "ehd": {"role": "lubrication"}}


UNITS = {
    "side_force": "N",
    "cylinder_pressure": "Pa",
    "pin_force_x": "N",
    "pin_force_y": "N",
    "lateral_displacement": "m",
    "lateral_velocity": "m/s",
    "rocking_angle": "rad",
    "rocking_velocity": "rad/s",
    "piston_kinetic_energy": "J",
    "elastic_energy": "J",
    "piston_velocity": "m/s",
    "piston_position": "m",
}


def run(angles, **ports):
    """Results of a run: crank angles [deg], and ports of `bodies` at the same instants."""
    series = {f"bodies.{name}": (own, UNITS.get(name, "1")) for name, own in ports.items()}
    series["bodies.crank_angle"] = (np.radians(angles), "rad")
    return InMemory(np.arange(len(angles)) * 1e-3, series, case={"participants": BODIES})


def add(results, **series):
    """Let a run know more {participant: {port: (values, unit)}}."""
    for name, ports in series.items():
        results.known |= {f"{name}.{port}": one for port, one in ports.items()}
    return results


def skin(name, skirt):
    """Three corners of a body with two modes."""
    modes = np.arange(18.0).reshape(3, 3, 2)
    return SimpleNamespace(
        name=name,
        points=np.eye(3),
        triangles=np.array([[0, 1, 2]]),
        modes=modes,
        skirt=skirt,
        von_mises=lambda coordinates: coordinates @ np.ones((2, 3)),
    )


def test_strokes_begin_at_firing_top_dead_centre():
    fired = run([0.0, 725.0], cylinder_pressure=[0.0, 1e6])
    shown = strokes({"a": run([-360.0, 10.0]), "b": fired})
    assert [(one.begin, one.name) for one in shown] == [
        (-360, "intake"),
        (-180, "compression"),
        (0, "expansion"),
        (180, "exhaust"),
        (360, "intake"),
        (540, "compression"),
        (720, "expansion"),
    ]
    assert len(STROKES) == 4
    assert {one.begin: one.mark for one in shown if one.mark} == {
        0: "firing TDC",
        720: "firing TDC",
    }


@pytest.mark.parametrize("gas", [{}, {"cylinder_pressure": [0.0, 0.0]}])
def test_a_motored_run_without_gas_has_dead_centres_and_no_row_of_gas(gas):
    runs = {"a": run([0.0, 400.0], side_force=[1.0, 2.0], **gas)}
    found = special(Case.model_construct(), runs)
    assert [(one.begin, one.name, one.mark) for one in found.phases] == [
        (0, "", "TDC"),
        (180, "", "BDC"),
        (360, "", "TDC"),
    ]
    assert not [one for part in found.sections for one in part.drawn if "Gas" in one.title]


def test_strokes_of_another_cylinder_stand_where_its_own_crank_angle_says():
    """It fires when the first one stands at 180 deg."""
    both = run([-360.0, 360.0], cylinder_pressure=[0.0, 1e6])
    add(both, rear={"crank_angle": (np.radians([-540.0, 180.0]), "rad")})
    own = own_strokes({"a": both}, "rear")
    assert own is not None
    assert [(one.begin, one.end, one.name) for one in own] == [
        (-360, -180, "exhaust"),
        (-180, 0, "intake"),
        (0, 180, "compression"),
        (180, 360, "expansion"),
    ]
    late = run([-360.0, 360.0], cylinder_pressure=[0.0, 1e6])
    add(late, rear={"crank_angle": (np.radians([0.0, 720.0]), "rad")})
    assert own_strokes({"a": both, "b": late}, "rear") is None


def test_edges_of_the_skirt_move_with_the_tilt():
    # turned about +z by 2 mrad, a point 10 mm above the pin goes 20 um towards -x
    runs = {
        "r": run(
            [0.0, 90.0],
            lateral_displacement=[5e-6, 5e-6],
            rocking_angle=[2e-3, 0.0],
            piston_position=[0.1, 0.1],
        )
    }
    case = Case.model_construct()
    skins = {"r": {"bodies": [skin("piston", (-0.02, 0.01))]}}
    chart = special(case, runs, skins).sections[0].drawn[0]
    lower, upper = chart.curves
    assert lower.y == pytest.approx([45.0, 5.0]) and upper.y == pytest.approx([-15.0, 5.0])
    assert lower.x == pytest.approx([0.0, 90.0]) and chart.cursor


def test_peaks_are_those_of_scipy():
    rng = np.random.default_rng(0)
    for size in range(60):
        for values in (rng.integers(0, 6, size) / 1.0, rng.random(size)):  # with plateaus, without
            expected, _ = find_peaks(values, prominence=0.3)
            assert prominent_peaks(values, 0.3) == expected.tolist()


def test_impacts_lose_the_energy_from_a_peak_to_the_next_minimum():
    """Peaks of 1 mJ and 0.2 mJ count, a ripple of 0.05 mJ does not. Minima are 0.1 and 0.05 mJ."""
    runs = {
        "r": run(
            [0, 1, 2, 3, 4, 5, 6],
            piston_kinetic_energy=[0, 1e-3, 1e-4, 1.5e-4, 1e-4, 3e-4, 5e-5],
            lower_edge_velocity=[0, 0.02, 0, 0, 0, 0.05, 0],
            upper_edge_velocity=[0, -0.03, 0, 0, 0, 0.04, 0],
        )
    }
    found = impacts(runs["r"], "bodies")
    assert [(one.row, one.edge, one.side, one.velocity) for one in found] == [
        (1, "upper", "anti-thrust", -0.03),
        (5, "lower", "thrust", 0.05),
    ]
    assert [one.loss for one in found] == pytest.approx([9e-4, 2.5e-4])
    section = special(Case.model_construct(), runs).sections[0]
    chart = next(one for one in section.drawn if "lost" in one.title)
    (curve,) = chart.curves
    assert curve.x == pytest.approx([1.0, 5.0]) and curve.y == pytest.approx([0.9, 0.25])


def test_coefficient_of_friction_over_load_and_speed():
    """The coefficient of friction is drawn over viscosity x speed / load.

    9 mPa s x 50 mm = 4.5e-4 Pa s m; times 10 m/s by 900 + 100 N is 4.5e-6.
    The friction force of (5 + 15) N gives a coefficient of 0.02.
    A step that carries 30 N is left out.
    """
    results = run([0.0, 1.0], piston_velocity=[-10.0, 3.0])
    results.case = {"participants": BODIES | {"ehd": {"role": "lubrication"}}}
    results.case["participants"]["ehd"]["parameters"] = {
        "viscosity": "9 mPa s",
        "skirt_length": "50 mm",
    }
    forces = {
        "friction_force_hydrodynamic": [-5.0, 1.0],
        "friction_force_asperity": [-15.0, 0.0],
        "radial_force_thrust_side": [900.0, 30.0],
        "radial_force_anti_thrust_side": [-100.0, 0.0],
    }
    add(results, ehd={name: (own, "N") for name, own in forces.items()})
    drawn = sections._stribeck({"r": results}, "bodies", "ehd")
    ((curve,),) = (chart.curves for chart in drawn)
    assert curve.x == pytest.approx([4.5]) and curve.y == pytest.approx([0.02])


def test_without_the_skirt_the_pin_is_shown():
    runs = {"r": run([0.0, 90.0], lateral_displacement=[5e-6, 7e-6])}
    chart = special(Case.model_construct(), runs).sections[0].drawn[0]
    assert chart.curves[0].y == pytest.approx([5.0, 7.0]) and "pin" in chart.title


def bearing_run():
    """Results of a shell: the axial friction force is round-off, the friction is a torque."""
    results = run([0.0, 90.0], piston_velocity=[1.0, 2.0])
    of_film = {
        "friction_force_hydrodynamic": ([1e-16, -1e-16], "1"),
        "friction_torque": ([0.2, 0.3], "N.m"),
        "friction_power": ([20.0, 30.0], "W"),
        "minimum_film_thickness": ([2e-6, 3e-6], "m"),
        "maximum_pressure": ([25.8e6, 1e6], "Pa"),
    }
    add(results, ehd=of_film)
    results.fields["ehd.pressure"] = ([[[1e6, 22.5e6]], [[2e6, 3e6]]], "Pa")
    highest = Envelope(np.array([[2e6, 25.8e6]]), "max", "Pa", "", every_step=True)
    results.envelopes["ehd.pressure"] = highest
    return results


def test_friction_of_a_bearing_is_a_torque_and_no_side_is_thrust():
    found = special(Case.model_construct(), {"a": bearing_run()}).sections
    titles = [one.title for section in found for one in section.drawn]
    assert "Friction torque on the shell" in titles and "Minimum film thickness" in titles
    assert not [title for title in titles if "skirt" in title or "side" in title]


def test_envelopes_hold_every_step_and_say_so():
    """The highest pressure of all steps, 25.8 MPa, is between two recorded instants."""
    found = special(Case.model_construct(), {"a": bearing_run()}).sections
    (section,) = (one for one in found if one.title.startswith("Envelopes"))
    assert [one.title for one in section.drawn] == ["Maximum pressure of the last period"]
    assert section.drawn[0].fields[0] == pytest.approx(np.array([[2.0, 25.8]]))
    assert section.text == "The envelopes hold every accepted macro step of the last period."


def test_nothing_special_of_a_case_without_a_crank():
    results = run([0.0])
    results.known.clear()
    assert special(Case.model_construct(), {"r": results}) == sections.Special()


def engine(surfaces=(), names=("front", "rear")):
    """Results of two cylinders, a film on each surface of each, at 0 and 90 deg."""
    parts, wires, series, fields = {}, [], {}, {}
    for k, name in enumerate(names):
        build = {"grid": [8, 10], "film_surfaces": list(surfaces)}
        parts[name] = {"role": "bodies", "build": build}
        series[name] = {
            "crank_angle": ([0.0, np.pi / 2], "rad"),
            "side_force": ([0.0, 100.0 * (k + 1)], "N"),
            "side_force_demand": ([0.0, 100.0], "N"),
            "piston_position": ([0.2, 0.1], "m"),
            "lateral_displacement": ([0.0, 1e-6], "m"),
            "rocking_angle": ([0.0, 0.0], "rad"),
        }
        for surface in [one["name"] for one in surfaces] or [""]:
            film, dot = f"{name}_{surface or 'film'}", f"{surface}." if surface else ""
            parts[film] = {"role": "lubrication", "parameters": {"bore_radius": "50 mm"}}
            series[film] = {"friction_power": ([10.0, 10.0], "W")}
            gap = f"{name}.{dot}film_thickness"
            wires.append({"from": gap, "to": f"{film}.film_thickness"})
            fields |= {gap: ([], "m"), f"{film}.pressure": ([], "Pa")}
    case = {"participants": parts, "wires": wires}
    return add(InMemory([0.0, 1e-3], {}, fields, case), **series)


def test_each_cylinder_is_named():
    results = engine()
    results.fields.clear()
    case = Case.model_construct(summary={})
    shown = special(case, {"r": results})
    titles = [one.title for one in shown.sections]
    assert {"Motion of the piston: front", "Forces: rear"} <= {*titles}
    table = measures(case, results)
    lines = headlines(table)
    assert lines["side force, front"].startswith("100 N on the thrust side")
    assert lines["side force, rear"].startswith("200 N on the thrust side")
    said = {one.what: one.colour for one in verdicts(results, table)}
    assert said["side force of front"] == "green" and said["side force of rear"] == "red"


def test_fmep_of_two_cylinders_is_over_the_displacement_of_both():
    """20 W for 1 ms over 2 pi 0.05^2 0.1 m3, of a period of 1 ms."""
    results = engine()
    results.period = 1e-3
    found = friction_pressure(results)
    assert found == pytest.approx(20e-3 / (2 * np.pi * 0.05**2 * 0.1), rel=1e-12)


def test_fields_lie_on_the_rows_of_their_surface():
    """Ten rows over 40 mm: rows 2 to 5 go from 4 to 20 mm above the lower edge."""
    surfaces = [{"name": "lower", "rows": [2, 5]}, {"name": "upper", "rows": [7, 10]}]
    results = engine(surfaces)
    around = sections.fields_around(results, "front", (-0.01, 0.03))
    assert {*around} == {
        *("front.lower.film_thickness", "front_lower.pressure"),
        *("front.upper.film_thickness", "front_upper.pressure"),
    }
    assert around["front_lower.pressure"] == pytest.approx((-0.006, 0.01))
    assert around["front.upper.film_thickness"] == pytest.approx((0.014, 0.03))
    # of a pin's bearing nothing lies there
    results.case["wires"][0]["from"] = "front.boss_left.film_thickness"
    assert "front_lower.pressure" not in sections.fields_around(results, "front", (0.0, 1.0))


def test_names_tell_surfaces_and_participants_apart():
    ports = ["a.lower.film_thickness", "b_film.pressure", "c.pressure"]
    assert list(names_of(ports).values()) == [
        "film thickness (lower)",
        "pressure, b film",
        "pressure, c",
    ]


@pytest.mark.parametrize(
    "unit, largest, shown",
    [("Pa", 5.6e5, "kPa"), ("m", -1.9e-4, "um"), ("m", 0.0, None), ("1", 3e-4, None)],
)
def test_units_of_handy_size(unit, largest, shown):
    assert handy_unit(unit, largest) == shown
