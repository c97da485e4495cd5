"""Calibration of synthetic engines: intervals at 95 % cover the true numbers.

Each engine is a run of `data_sheet` whose oil and clearance are drawn at random. Its curve with
normal noise is the measurement, from which a calibration finds both again.
"""

import numpy as np
import pytest

from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.results.compare import Measured, deviations, have_bands
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.calibration import calibrate
from piston_cosim.master.runs.design_space import DesignSpace, range_of
from piston_cosim.master.runs.pool import LocalPool
from piston_cosim.master.runs.sensitivities import Runs, use_of

ENGINES = 20
PATH = find_case("data_sheet")
ANGLE = "bodies.crank_angle"
NUMBERS = "viscosity=4 mPa s..8 mPa s", "radial_clearance=40um..60um"
CHANGES = [
    *((f"participants.{name}.build.grid", [16, 12]) for name in ("bodies", "ehd")),
    ("native", True),
    ("time.step", "2 deg"),
    ("record.fields", []),
    ("pictures", []),
]


def measured(results, port, factor, unit, noise, has_band, rng):
    """Return a curve of a run, every 10 deg with noise, as a measured file has it."""
    angle, curve = (results.last.series(one).values for one in (ANGLE, port))
    places = np.arange(np.degrees(angle[0]) + 10.0, np.degrees(angle[-1]), 10.0)
    values = np.interp(places, np.degrees(angle), factor * curve)
    values = values + noise * rng.standard_normal(places.size)
    band = (values - 2.0 * noise, values + 2.0 * noise) if has_band else ()
    return {ANGLE: Measured(places, "deg"), port: Measured(values, unit, *band)}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("port", "factor", "unit", "noise", "has_band"),
    [
        # ranges of about 40 um and 45 N; each curve hardly tells both numbers apart
        ("bodies.lateral_displacement", 1e6, "um", 1.0, True),
        ("ehd.friction_force_hydrodynamic", 1.0, "N", 0.25, False),
    ],
)
def test_intervals_cover_the_numbers_of_synthetic_engines(
    tmp_path, port, factor, unit, noise, has_band
):
    tree = read_tree(PATH, CHANGES)
    ranges = [range_of(tree, text, PATH.parent, "--vary") for text in NUMBERS]
    bounds = [(low, high) for _, low, high in ranges]
    rng = np.random.default_rng(7)
    errors = []
    with use_of(tmp_path), LocalPool(1) as executor:
        space = DesignSpace(tuple(number for number, *_ in ranges))
        runs = Runs(tree, PATH, space, tmp_path, executor)
        for _ in range(ENGINES):
            truth = np.array([rng.uniform(0.8 * low, 0.8 * high) for low, high in bounds])
            (row,) = runs.rows([truth])
            with Results(row["results"]) as results:
                columns = measured(results, port, factor, unit, noise, has_band, rng)

            def residuals(designs, columns=columns):
                shown = []
                for row in runs.rows(designs):
                    with Results(row["results"]) as results:
                        shown.append(deviations(results.last, columns))
                return shown

            fit = calibrate(residuals, bounds, have_bands(columns))
            errors.append((fit.shares - truth) / fit.half_widths)
    covered = (np.abs(errors) <= 1.0).sum(axis=0)
    print(f"covered {covered}, rms error in half widths {np.sqrt(np.mean(np.square(errors), 0))}")
    # 19 expected; the rms is 1 / 1.96, and its deviation a sixth of it
    assert (covered >= 18).all() and np.sqrt(np.mean(np.square(errors))) < 0.75
