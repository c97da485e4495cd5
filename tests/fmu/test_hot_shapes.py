"""The built FMU of hot bodies: its film thickness contains the hot shape."""

import numpy as np

from ..mfbd.conftest import OUTER, write_bodies
from .pairs import open_fmu
from .runs import make


def test_heat_closes_the_film(tmp_path):
    """Piston 20 K above its mesh: alpha dT R = 11.8 um less than the cold film."""
    folder, table = write_bodies(tmp_path, 16, 1, (6, 4))
    (folder / "heat.csv").write_text("y,0\n0,40\n")
    field = {"table": "heat.csv", "length_unit": "mm", "temperature_unit": "degC"}
    for body in (table["piston"], table["block"]):
        body["modes"] = 0
    hot = {"expansion": "21e-6 1/K", "temperature_field": field}
    thickness = []
    for own in ({}, hot):
        build = table | {"piston": table["piston"] | own}
        one = open_fmu("bodies", make("fmu_mfbd", build, folder))
        one.start({"radial_clearance": 25e-6, "barrel": 0.0}, 0.0, 1.0)
        thickness.append(np.asarray(one.get("film_thickness")))
        one.close()
    cold, warm = thickness
    # read on 16 curved elements around
    np.testing.assert_allclose(cold - warm, 21e-6 * 20.0 * OUTER, rtol=2e-3)
