"""Piston slap over 100 designs of a look-alike engine, compared with a published study of designs.

    python -m piston_cosim.models.measured.piston_slap.study DESIGNS.csv --output FOLDER

DESIGNS.csv has the columns of `FACTORS`, and optionally `noise_db` of the published study. Without
it, the designs are a Latin hypercube over the published ranges. README.md in this folder states
what the factors mean here.
"""

import argparse
import csv
import re
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq
from scipy.signal import butter, sosfiltfilt
from scipy.stats import bootstrap, qmc, spearmanr

from piston_cosim.master.engine import new
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs import sweep
from piston_cosim.master.runs.pool import LocalPool

CASE = Path(__file__).parent / "case.toml"
FACTORS = {
    "clearance_um": (15.0, 85.0),
    "peak_pressure_location_deg": (12.0, 17.0),
    "skirt_length_mm": (21.0, 25.0),
    "skirt_profile": (1.0, 3.0),
    "skirt_ovality": (1.0, 3.0),
    "pin_offset_mm": (0.5, 1.3),
}
"""Factors of the published study with their ranges."""
CLEARANCE, OFFSET = (list(FACTORS).index(name) for name in ("clearance_um", "pin_offset_mm"))
NOISE, PRODUCT = "noise_db", "clearance x pin_offset"
COUNT, SEED = 100, 1
BARREL, OVALITY = 18.0, 90.0  # [um] for each unit of the coded profile and ovality
ABOVE = 14.24  # [mm] of skirt above the pin, as in case.toml
BODY = "participants.bodies"
BAND = 500.0  # [Hz], lower limit of the side force that is taken for noise, our own choice
DEGREES = np.arange(-360.0, 360.5, 0.5)


class Effect(NamedTuple):
    """Change of the noise with a factor: `slope` [dB] per standard deviation and `error` of it."""

    slope: float
    error: float

    @property
    def t(self) -> float:
        """Slope over its standard error [-]."""
        return self.slope / self.error


def designs_of(path):
    """Return designs, shape (designs, factors), and their published noise [dB] or None."""
    if path is None:
        low, high = zip(*FACTORS.values())
        return qmc.scale(qmc.LatinHypercube(len(FACTORS), seed=SEED).random(COUNT), low, high), None
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    designs = np.array([[float(row[name]) for name in FACTORS] for row in rows])
    return designs, np.array([float(row[NOISE]) for row in rows]) if NOISE in rows[0] else None


def gas_table(location):
    """Return the table of a gas pressure with its peak at `location` [deg] after firing TDC."""
    made = new.engine({"bore": "89 mm", "stroke": "79.5 mm", "rod": "138.1 mm"})

    def pressure(delay):
        heat = new.PETROL._replace(start=new.PETROL.start + delay)
        return made.pressure(DEGREES, made.gain, heat)

    def late(delay):
        p = pressure(delay)
        k = int(p.argmax())
        rise, fall = p[k] - p[k - 1], p[k] - p[k + 1]
        return DEGREES[k] + 0.25 * (rise - fall) / (rise + fall) - location  # top of a parabola

    return new.gas_table(DEGREES, pressure(brentq(late, -12.0, 12.0, xtol=1e-3)))


def changes_of(design, folder):
    """Return the changes of the case for a design; write its gas pressure into `folder`."""
    clearance, location, below, profile, ovality, offset = design
    gas = folder / f"gas_{location:.2f}.csv"
    gas.write_text(gas_table(location))
    return [
        ("native", True),
        ("record.every", 100000),
        (f"{BODY}.parameters.radial_clearance", f"{clearance / 2} um"),
        (f"{BODY}.build.gas.file", str(gas.resolve())),
        (f"{BODY}.build.piston.skirt_lower", f"{-below} mm"),
        ("participants.ehd.parameters.skirt_length", f"{below + ABOVE} mm"),
        (f"{BODY}.parameters.barrel", f"{BARREL * profile} um"),
        (f"{BODY}.parameters.ovality", f"{OVALITY * ovality} um"),
        (f"{BODY}.build.piston.pin_offset", f"{offset} mm"),
    ]


def effects(designs, noise):
    """Return the `Effect` of each factor, and of clearance times pin offset.

    Least squares of noise = a_0 + sum a_i z_i + a z_clearance z_offset, with z = (x - mean) /
    deviation.
    """
    z = (designs - designs.mean(axis=0)) / designs.std(axis=0)
    columns = np.column_stack([np.ones(len(z)), z, z[:, CLEARANCE] * z[:, OFFSET]])
    slopes = np.linalg.lstsq(columns, noise)[0]
    rest = noise - columns @ slopes
    variance = rest @ rest / (len(z) - len(slopes)) * np.linalg.inv(columns.T @ columns)
    errors = np.sqrt(np.diag(variance))
    return {
        name: Effect(float(a), float(error))
        for name, a, error in zip([*FACTORS, PRODUCT], slopes[1:], errors[1:])
    }


def measured(rows, output):
    """Return two measures of slap from the rows of a sweep: name -> [dB] of every design.

    Energy is the largest loss of kinetic energy in an impact. Force is the root mean square of
    the side force above `BAND`.
    """
    forces = []
    for row in rows:
        with Results(output / row["results"]) as results:
            force = results.series("bodies.side_force").values[1:]  # the first one is of no step
            rate = 1.0 / np.diff(results.time[:2])[0]
        band = sosfiltfilt(butter(4, BAND, "high", fs=rate, output="sos"), force)
        forces.append(np.sqrt(np.mean(band**2)))
    energies = np.array([row["slap_energy_j"] for row in rows])
    return {"energy": 10.0 * np.log10(energies), "force": 20.0 * np.log10(forces)}


def run_designs(designs, output, workers):
    """Run every design; return the rows of the sweep."""
    output.mkdir(parents=True, exist_ok=True)
    named = [dict(zip(FACTORS, map(float, design))) for design in designs]
    points = sweep.checked_points(
        CASE, list(zip(named, (changes_of(one, output) for one in designs)))
    )
    sweep.build_all(sweep.unfinished(points, output), CASE.parent, print)

    def watch(row, done, total):
        print(f"{done}/{total}  {row['status']}  {row['message']}", flush=True)

    with LocalPool(workers) as pool:
        rows = sweep.sweep(points, CASE.parent, output, pool, watch)
    if failed := [row for row in rows if row["status"] != "done"]:
        raise SystemExit(f"{len(failed)} of {len(rows)} designs failed; call again to try again")
    return rows


def table(studies):
    """Return lines of a table: effects [dB per standard deviation] with t values by study."""
    heads = [text for study in studies for text in (study, "t")]
    lines = [f"{'factor':28s}" + "".join(f"{head:>11s}" for head in heads)]
    for name in [*FACTORS, PRODUCT]:
        figures = [(one[name].slope, one[name].t) for one in studies.values()]
        lines.append(f"{name:28s}" + "".join(f"{a:+11.2f}{ratio:+11.1f}" for a, ratio in figures))
    return lines


def draw(studies, path):
    """Draw the effects of every factor with twice their standard errors."""
    figure, panel = plt.subplots(layout="constrained", figsize=(7, 4))
    names = [*FACTORS, PRODUCT]
    for shift, (study, one) in enumerate(studies.items()):
        rows = np.arange(len(names)) + 0.27 * shift - 0.135 * (len(studies) - 1)
        errors = [2.0 * one[name].error for name in names]
        panel.barh(rows, [one[name].slope for name in names], 0.25, xerr=errors, label=study)
    words = [re.sub("_(um|deg|mm)$", "", name).replace("_", " ") for name in names]
    panel.set_yticks(range(len(names)), words)
    panel.invert_yaxis()
    panel.axvline(0.0, color="black", linewidth=0.8)
    panel.set_xlabel("effect on the slap [dB per standard deviation of the factor]")
    panel.grid(axis="x", alpha=0.3)
    panel.legend()
    figure.savefig(path, dpi=110)


def correlation(ours, theirs):
    """Return the rank correlation of two noises with its 95 % interval."""
    pairs = bootstrap(
        (ours, theirs),
        lambda a, b: spearmanr(a, b).statistic,
        n_resamples=2000,
        paired=True,
        vectorized=False,
        random_state=SEED,
    )
    return spearmanr(ours, theirs).statistic, *pairs.confidence_interval


def main(path, output, workers):
    """Run the study; print effects and rank correlations, and draw effects.png."""
    designs, published = designs_of(path)
    measures = measured(run_designs(designs, output, workers), output)
    studies = {name: effects(designs, noise) for name, noise in measures.items()}
    if published is not None:
        studies["published"] = effects(designs, published)
    print(*table(studies), sep="\n")
    if published is not None:
        for name, noise in measures.items():
            middle, low, high = correlation(noise, published)
            print(
                f"rank correlation of {name} with the published noise: {middle:.2f}, "
                f"95 % interval {low:.2f} to {high:.2f}"
            )
    draw(studies, output / "effects.png")
    print(f"picture  {output / 'effects.png'}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("designs", type=Path, nargs="?", help="table of designs, CSV")
    parser.add_argument("--output", type=Path, default=Path("results/piston_slap"))
    parser.add_argument("--workers", type=int, help="processes; default: all processors")
    arguments = parser.parse_args()
    main(arguments.designs, arguments.output, arguments.workers)
