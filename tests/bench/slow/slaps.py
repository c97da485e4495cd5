"""Distance of runs from a finer one, and what they cost, by step, tolerance and resolution.

python tests/bench/slow/slaps.py CASE VARIANT BEGIN STOP [KEY=VALUE ...] RUN ... REFERENCE

A run is STEP,TOLERANCE,RESOLUTION: the macro step [deg], the tolerance of the first wire, which is
the film thickness [nm], and `impact_resolution` [nm]. 1e9 nm turns the parts off. Distances are
those of the curves at each 2 deg from BEGIN to STOP [deg] over their range, rms and largest. Values
of KEY are in JSON. `created_uj` is the sum of the energy that time integration creates in the steps
that create energy [uJ].

python tests/bench/slow/slaps.py data_sheet rigid 0 720 1,10,1e9 1,10,10 0.25,1,10
"""

import sys
from json import loads
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import piston_cosim as pc

CURVES = "lateral_displacement", "pin_displacement_y", "small_end_displacement_y"
COUNTS = "steps", "repeated_steps", "steps_without_parts", "residual_evaluations"


def curves_of(case, variant, begin, stop, changes, run):
    """Return the curves of a run by name; print its counts and its largest spurious energy."""
    step, tolerance, resolution = map(float, run.split(","))
    bodies = next(iter(pc.open_case(case).tree["participants"]))
    changes = changes | {
        "time.step": f"{step} deg",
        "time.stop": f"{stop} deg",
        "wires.0.tolerance": f"{tolerance} nm",
        "wires.1.tolerance": 1e-6 * tolerance,
        f"participants.{bodies}.parameters.impact_resolution": f"{resolution} nm",
        "record.fields": [],
    }
    with TemporaryDirectory() as folder:
        with pc.open_case(case, changes, variant).run(Path(folder) / "run.h5") as results:
            counts = [results.summary.get(name, 0) for name in COUNTS]
            power = results.series(f"{bodies}.power_error").values
            created = 1e6 * np.sum(np.diff(results.time) * np.maximum(power[1:], 0.0))
            share = results.summary["energy_created_share_max"]
            print(run, *counts, f"{share:.4f} {created:.3g}", flush=True)
            wanted = [one for one in results.ports if one.endswith("minimum_film_thickness")]
            wanted += [f"{bodies}.{one}" for one in CURVES]
            turned = results.series(f"{bodies}.crank_angle").values
            turned = np.degrees(np.unwrap(turned) - turned[0])
            instants = np.arange(begin + 2.0, stop - 1e-3, 2.0)
            return {
                one: np.interp(instants, turned, results.series(one).values)
                for one in wanted
                if one in results.ports
            }


def main(case, variant, begin, stop, *rest):
    """Print the counts of each run, then its distances from the last one."""
    changes = {
        key: loads(value) for key, value in (one.split("=", 1) for one in rest if "=" in one)
    }
    runs = [one for one in rest if "=" not in one]
    print("run", *COUNTS, "energy_created_share_max", "created_uj")
    where = case, variant, float(begin), float(stop), changes
    found = [curves_of(*where, run) for run in runs]
    for name, reference in found[-1].items():
        for run, curves in zip(runs[:-1], found):
            apart = np.abs(curves[name] - reference) / np.ptp(reference)
            print(f"{name} {run}: {np.sqrt(np.mean(apart**2)):.1e}, {apart.max():.1e}")


if __name__ == "__main__":
    main(*sys.argv[1:])
