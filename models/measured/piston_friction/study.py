"""Compare the skirt friction of runs with a fit to motoring tests of piston and rings.

    python -m piston_cosim.models.measured.piston_friction.study RUN.h5...

README.md in this folder states the source of the fit and what it covers.
"""

import math
import sys

from piston_cosim.master.engine.friction import friction_pressure
from piston_cosim.master.fmi.quantities import to_si
from piston_cosim.master.results.file import Results

HEADS = (
    *("run", "computed, skirt [kPa]", "fit, piston [kPa]", "fit, rings [kPa]"),
    *("film [um]", "film of the fit [um]"),
)


def fit(bore: float, stroke: float, speed: float) -> tuple[float, float]:
    """Return the friction mean effective pressures of piston and rings, without gas pressure.

    Eq. (X45):  p_piston = 294 c / B,   p_rings = 4.06e4 (1 + 1000/n) / B^2
                in kPa with B in mm, c = 2 S n the mean piston speed in m/s, and n in rpm

    Parameters
    ----------
    bore, stroke : float
        B and S [m].
    speed : float
        Crank speed n [rad/s].

    Returns
    -------
    tuple of float
        Pressures over 720 deg [Pa].

    References
    ----------
    [Patton1989], as reproduced from a thesis, see README.md.
    """
    width, rpm = 1e3 * bore, speed * 30.0 / math.pi
    mean = stroke * rpm / 30.0
    # Eq. (X45)
    return 1e3 * 294.0 * mean / width, 1e3 * 4.06e4 * (1.0 + 1000.0 / rpm) / width**2


def uniform_film(pressure: float, viscosity: float, length: float, bore: float, mean: float):
    """Return the film thickness of a full skirt whose shear has a friction pressure [m].

    Eq. (X46):  h = 2 pi^2 mu L c / (B p)
                the velocity of the piston is taken as sinusoidal; 720 deg have four strokes

    Parameters
    ----------
    pressure, viscosity, length, bore, mean : float
        p over 720 deg [Pa], mu [Pa s], length L of the skirt [m], B [m], mean piston speed c [m/s].
    """
    # Eq. (X46)
    return 2.0 * math.pi**2 * viscosity * length * mean / (bore * pressure)


def row(path: str) -> str:
    """Return the row of a run in Markdown."""
    results = Results(path)
    film, bodies = (results.case["participants"][name]["parameters"] for name in ("ehd", "bodies"))
    bore, length = 2.0 * to_si(film["bore_radius"], "m"), to_si(film["skirt_length"], "m")
    stroke, viscosity = 2.0 * to_si(bodies["crank_radius"], "m"), to_si(film["viscosity"], "Pa.s")
    speed = to_si(bodies["crank_speed"], "rad/s")
    period = friction_pressure(results)
    assert period is not None and results.period is not None
    computed = period * 4.0 * math.pi / (speed * results.period)
    piston, rings = fit(bore, stroke, speed)
    films = (
        uniform_film(pressure, viscosity, length, bore, stroke * speed / math.pi)
        for pressure in (computed, piston)
    )
    numbers = (*(1e-3 * one for one in (computed, piston, rings)), *(1e6 * one for one in films))
    name = f"{results.path.parent.name} {results.path.stem}"
    return f"| {name} | {' | '.join(f'{number:.3g}' for number in numbers)} |"


def main() -> None:
    """Print the table of the runs."""
    print(f"| {' | '.join(HEADS)} |\n{'|---' * len(HEADS)}|")
    print("\n".join(map(row, sys.argv[1:])))


if __name__ == "__main__":
    main()
