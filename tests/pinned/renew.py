"""Pinned runs of the shipped cases: what is run, what is measured, and how the values are renewed.

    python tests/pinned/renew.py [RUN ...]      old beside new, all runs or those named
    python tests/pinned/renew.py --write        and write the new ones to values.toml

A change of these values is a change of results: renew them only with the reason in the changelog.
"""

import sys
import tempfile
import tomllib
from pathlib import Path

import h5py
import numpy as np

import piston_cosim as pc

VALUES = Path(__file__).parent / "values.toml"


def mean(values, time):
    """Return the mean over time, by the trapezoidal rule; steps are not equal."""
    return np.trapezoid(values, time) / np.ptp(time)


# what is measured: recorded curve, what of it
MEASURES = {
    "maximum_pressure_pa": ("ehd/maximum_pressure", np.max),
    "minimum_film_m": ("ehd/minimum_film_thickness", np.min),
    "side_force_min_n": ("bodies/side_force", np.min),
    "side_force_max_n": ("bodies/side_force", np.max),
    "lateral_range_m": ("bodies/lateral_displacement", np.ptp),
    "rocking_range_rad": ("bodies/rocking_angle", np.ptp),
    "crank_torque_max_nm": ("bodies/crank_torque", np.max),
}


def read_values():
    """Table of pinned values: run -> case, variant, set, slow, and value of each measure."""
    return tomllib.loads(VALUES.read_text())


def measure(results):
    """Measures of a results file."""
    with h5py.File(results) as file:
        power = mean(file["ehd/friction_power"][:], file["time"][:])
        extremes = {name: float(what(file[curve][:])) for name, (curve, what) in MEASURES.items()}
        return {"mean_friction_power_w": float(power)} | extremes


def run(entry, folder):
    """Run a pinned entry in this process and measure it.

    Parameters
    ----------
    entry : dict
        case, variant, set (changes of the case, KEY = VALUE).
    folder : Path
        For the results.
    """
    path = folder / "run.h5"
    pc.open_case(entry["case"], entry["set"], entry["variant"]).run(path).close()
    return measure(path)


def renewed(text, name, values):
    """Return the file's text with new values of one run, and everything else unchanged."""
    head, rest = text.split(f'["{name}".values]\n', 1)
    _, start, tail = rest.partition('\n["')
    lines = "".join(f"{key} = {value!r}\n" for key, value in values.items())
    return f'{head}["{name}".values]\n{lines}{start}{tail}'


def main(arguments):
    """Run, print old beside new, and write if asked to."""
    chosen = [argument for argument in arguments if argument != "--write"]
    text = VALUES.read_text()
    for name, entry in read_values().items():
        if chosen and name not in chosen:
            continue
        with tempfile.TemporaryDirectory() as folder:
            values = run(entry, Path(folder))
        print(name)
        for key, new in values.items():
            old = entry["values"].get(key, float("nan"))
            print(f"    {key:24}{old:18.10g}{new:18.10g}{new / old - 1.0:12.1e}")
        text = renewed(text, name, values)
        if "--write" in arguments:
            VALUES.write_text(text)


if __name__ == "__main__":
    main(sys.argv[1:])
