"""Films between walls of given temperatures, as a case runs them."""

from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.slave import Mfbd
from piston_cosim.master.engine.overview import conditions

from .runs import EXAMPLE, run_tree, small_tree

BUILD = "participants.bodies.build.temperatures"
OIL = ("participants.ehd.build.oil", "sae_5w_30")
BORE = ("participants.bodies.parameters.bore_expansion", "20e-6 1/K")
SAME = ("lateral_displacement", "rocking_angle", "side_force", "film_power", "thermal_opening")


def finished(folder, *changes, stop="20 deg"):
    tree = small_tree(("time.stop", stop), BORE, OIL, *changes)
    record = {"fields": ["bodies.film_thickness", "ehd.pressure"], "every": 20}
    return run_tree(EXAMPLE, tree | {"record": record, "pictures": []}, folder / "o.h5")


def test_even_temperatures_are_those_of_oil_and_inputs(tmp_path):
    """The run of the short form, to the tolerance of the interface."""
    walls = {"skirt": "400 K", "bore": "390 K"}
    given = finished(tmp_path, (BUILD, walls))
    known = {name: given.series(f"bodies.{name}").values for name in SAME}
    friction = given.series("ehd.friction_power").values
    (told,) = [text for text in conditions(given, ["ehd"]) if "clearance" in text]
    by_hand = [
        *(
            (f"participants.ehd.parameters.oil_temperature_{e}_edge", "395 K")
            for e in ("lower", "upper")
        ),
        ("participants.bodies.parameters.piston_temperature", "400 K"),
        ("participants.bodies.parameters.bore_temperature", "390 K"),
    ]
    other = finished(tmp_path, *by_hand)
    for name, values in known.items():
        same = other.series(f"bodies.{name}").values
        np.testing.assert_allclose(values, same, rtol=0, atol=1e-3 * np.abs(same).max())
    np.testing.assert_allclose(friction, other.series("ehd.friction_power").values, rtol=1e-3)
    assert "cold" in told and "hot" in told


@pytest.mark.parametrize("prefixes", [("",), ("lower.", "upper.")])
def test_field_inputs_have_every_cell_once(prefixes):
    """Of one film, whose variables have no prefix, and of several."""
    slave = object.__new__(Mfbd)
    films = [SimpleNamespace(prefix=prefix) for prefix in prefixes]
    slave.built = SimpleNamespace(film_grids=lambda: films)
    name = "skirt_temperature_field"
    values = {f"{prefix}{name}": np.full((4, 3), 400.0) for prefix in prefixes}
    assert slave._wall_field(values, name).shape == (12 * len(prefixes),)


def test_hot_walls_conserve_energy_and_oil(tmp_path):
    """Pressure on the slope of a hot bore is a force along the axis, so that the account closes."""
    walls = {"skirt": ["110 degC", "130 degC"], "bore": ["100 degC", "160 degC"]}
    results = finished(tmp_path, (BUILD, walls), stop="60 deg")
    summary = results.summary
    assert abs(summary["energy_created_share_max"]) < 0.01
    assert results.series("ehd.mass_imbalance").values.max() < 1e-12
    assert results.series("bodies.interface_work_error").values.max() < 1e-12
    assert np.ptp(results.series("bodies.thermal_opening").values) == pytest.approx(0.0, abs=1e-18)
