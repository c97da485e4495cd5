"""Run a flexible piston with measured cylinder pressures, one run for each trace.

    python -m piston_cosim.models.measured.cylinder_pressure.study CASE TRACE...

A trace has two columns: crank angle [deg], 0 at firing top dead centre, and absolute pressure [Pa].
It can end where the valves open. README.md in this folder states how the cycle is completed.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import piston_cosim as pc

AMBIENT = 1e5
"""Pressure of crankcase and surroundings [Pa]."""
BLOWDOWN = 20.0
"""Angle in which the pressure falls to 1/e after the exhaust valve opens [deg], our own choice."""
DEGREES = np.arange(-360.0, 361.0)
GAS = "participants.bodies.build.gas"
SETTINGS = {
    "native": True,
    "time.until_periodic": 0,
    "time.stop": "720 deg",
    "participants.bodies.build.grid": [60, 60],
    "participants.ehd.build.grid": [60, 60],
    "participants.bodies.build.piston.modes": 140,
    f"{GAS}.pressure_unit": "1 Pa",
}
GAS_PRESSURE, FORCE = "bodies.cylinder_pressure", "bodies.side_force"
FILM, PRESSURE, POWER = "ehd.minimum_film_thickness", "ehd.maximum_pressure", "ehd.friction_power"
PANELS = {
    GAS_PRESSURE: ("gas pressure [MPa]", 1e-6),
    FORCE: ("side force [kN]", 1e-3),
    FILM: ("minimum film thickness [um]", 1e6),
    POWER: ("friction power [W]", 1.0),
}


def cycle(angle, pressure):
    """Return the gauge pressure at `DEGREES` [Pa] of a trace of absolute pressure.

    Before its first angle the pressure is the first one. After its last angle it falls to the first
    one exponentially.
    """
    first, last = pressure[0], pressure[-1]
    fallen = first + (last - first) * np.exp(-(DEGREES - angle[-1]) / BLOWDOWN)
    closed = np.interp(DEGREES, angle, pressure)
    return np.where(DEGREES <= angle[-1], closed, fallen) - AMBIENT


def gas_file(trace, folder):
    """Write the cycle of a trace as a table of gas pressure; return its path."""
    path = folder / f"{trace.name}.csv"
    rows = np.column_stack([DEGREES, cycle(*np.loadtxt(trace, unpack=True))])
    np.savetxt(path, rows, "%g", ",", header="crank angle [deg],gauge pressure [Pa]", comments="")
    return str(path.resolve())


def table(runs):
    """Return lines of a table with one row for each trace."""
    heads = "gas [MPa]", "side force [kN]", "film [um]", "film [MPa]", "friction [W]"
    lines = [f"{'trace':12s}" + "".join(f"{head:>17s}" for head in heads)]
    for name, results in runs.items():
        gas, force, film, pressure, power = (
            results.series(port).values for port in (GAS_PRESSURE, FORCE, FILM, PRESSURE, POWER)
        )
        mean = float(np.trapezoid(power, results.time) / np.ptp(results.time))
        figures = gas.max() / 1e6, force.max() / 1e3, film.min() * 1e6, pressure.max() / 1e6, mean
        lines.append(f"{name:12s}" + "".join(f"{figure:17.4g}" for figure in figures))
    return lines


def draw(runs, path):
    """Draw gas pressure, side force, film and friction of all traces over the crank angle."""
    figure, panels = plt.subplots(2, 2, layout="constrained", figsize=(9, 6), sharex=True)
    for panel, (port, (label, factor)) in zip(panels.flat, PANELS.items()):
        for name, results in runs.items():
            angle = np.degrees(results.series("bodies.crank_angle").values)
            panel.plot(angle, results.series(port).values * factor, label=name, linewidth=1.0)
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
    for panel in panels[1]:
        panel.set_xlabel("crank angle after firing top dead centre [deg]")
        panel.set_xticks(range(-360, 361, 90))
    panels[0, 0].legend()
    figure.savefig(path, dpi=110)


def main(case, traces, output, workers):
    """Run the case with every trace; print the table and draw curves.png."""
    output.mkdir(parents=True, exist_ok=True)
    files = [gas_file(trace, output) for trace in traces]
    opened = pc.open_case(case, SETTINGS)
    rows = pc.sweep(opened, {f"{GAS}.file": files}, output, workers)
    if failed := [row["message"] for row in rows if row["status"] != "done"]:
        raise SystemExit("\n".join(failed))
    results = [pc.open_results(output / row["results"]) for row in rows]
    runs = dict(zip([trace.name for trace in traces], results))
    print(*table(runs), sep="\n")
    draw(runs, output / "curves.png")
    print(f"picture  {output / 'curves.png'}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", help="case of a flexible piston with gas pressure")
    parser.add_argument("traces", type=Path, nargs="+", help="angle [deg] and pressure [Pa]")
    parser.add_argument("--output", type=Path, default=Path("results/cylinder_pressure"))
    parser.add_argument("--workers", type=int, help="processes; default: all processors")
    arguments = parser.parse_args()
    main(arguments.case, arguments.traces, arguments.output, arguments.workers)
