"""Noise that a flexible block would radiate in a run, over the crank angle and by frequency."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.util import write_csv
from scipy.interpolate import make_interp_spline

from ..fmi.errors import BadInput
from ..results.figures import PALETTE, add_legend, save, subplots
from ..results.file import Results
from ..results.instants import CRANK_ANGLE, crank_angle
from ..results.pictures import label_abscissa

AIR = 413.0
"""Density times speed of sound of air at 20 degC and 1 bar [kg/(m2 s)]."""
REFERENCE = 1e-12
"""Reference power of levels [W]."""
EVEN = 1e-2
"""Tolerance of a whole number of intervals, relative to an interval."""
CYCLES = (720.0, 360.0)
"""Lengths of a cycle [deg]. The first one that the run contains is used."""
PER_CYCLE = 8
"""Minimum number of equidistant instants per cycle."""


@dataclass(frozen=True)
class Noise:
    """Equivalent radiated power of the last cycle.

    It results from the elastic motion of the block's outer faces with radiation efficiency 1.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Crank angle [rad].
    time : ndarray, shape (n,)
        [s]
    power : dict of str to ndarray, shape (n,)
        Side -> rho c int v_n^2 dA [W].
    frequency : ndarray, shape (n // 2 + 1,)
        [Hz]
    spectrum : dict of str to ndarray, shape (n // 2 + 1,)
        Side -> mean power at each frequency [W]. Its sum is the mean of `power`.
    """

    angle: np.ndarray
    time: np.ndarray
    power: dict[str, np.ndarray]
    frequency: np.ndarray
    spectrum: dict[str, np.ndarray]

    @property
    def total(self) -> np.ndarray:
        """Power of all sides [W]."""
        return np.sum(list(self.power.values()), axis=0)

    @property
    def total_spectrum(self) -> np.ndarray:
        """Power of all sides by frequency [W]."""
        return np.sum(list(self.spectrum.values()), axis=0)


def level(power: Any) -> Any:
    """Return levels of powers [W] relative to 1 pW [dB]; -300 for zero."""
    return 10.0 * np.log10(np.maximum(power, REFERENCE * 1e-30) / REFERENCE)


def noise(results: Results, owner: str, radiation: Any) -> Noise:
    """Return the radiated power of a run that has recorded the modal velocities.

    The velocities are interpolated by a cubic spline at equidistant instants, with the largest
    recorded interval.

    Eq. (W3):  P_m = rho c c_m V_m^* R V_m / n^2,   V the discrete Fourier transform of q', c_m = 2
               except for the constant part and n/2

    Parameters
    ----------
    results : Results
    owner : str
        Participant with the block.
    radiation : fmu_mfbd.offline.Radiation

    Raises
    ------
    BadInput
        If velocities are not recorded, the run is shorter than a revolution, or there are too few
        instants.
    """
    port = f"{owner}.modal_velocity"
    if port not in results.recorded:
        raise BadInput(
            f"{results.path}: expected {port}, got none; add it to record.fields and set "
            "record.every = '1 deg'"
        )
    crank = crank_angle(results)
    if crank is None:
        raise BadInput(f"{results.path}: expected a crank angle, got none")
    instants = results.instants
    angle = np.interp(instants, *crank)
    first = _begin(results.path, angle)
    velocity = results.dataset(port)[first:, radiation.first :]
    length = instants[-1] - instants[first]
    n = int(length / np.diff(instants[first:]).max() + EVEN)
    if n < PER_CYCLE:
        raise BadInput(
            f"{results.path}: expected at least {PER_CYCLE} even instants in the last cycle, "
            f"got {n}; set record.every = '1 deg'"
        )
    # the first instant is the last one of the previous cycle
    time = instants[first] + length / n * np.arange(1.0, n + 1.0)
    velocity = make_interp_spline(instants[first:], velocity)(time)
    transformed = np.fft.rfft(velocity, axis=0)
    twice = np.full(len(transformed), 2.0)
    twice[0] = 1.0
    if n % 2 == 0:
        twice[-1] = 1.0
    power = {}
    spectrum = {}
    for side, products in radiation.products.items():
        # Eq. (J25) of the bodies
        power[side] = AIR * np.einsum("tk,kl,tl->t", velocity, products, velocity)
        square = np.einsum("mk,kl,ml->m", transformed.conj(), products, transformed).real
        spectrum[side] = AIR * twice * square / n**2  # Eq. (W3)
    frequency = np.arange(len(transformed)) / length
    return Noise(np.interp(time, *crank), time, power, frequency, spectrum)


def _begin(path, angle):
    """Return the index of the instant before the last cycle."""
    for length in np.radians(CYCLES):
        first = int(np.abs(angle - (angle[-1] - length)).argmin())
        spacing = angle[-1] - angle[-2]
        if abs(angle[-1] - length - angle[first]) < EVEN * spacing:
            return first
    raise BadInput(
        f"{path}: expected {CYCLES[1]:g} deg from an instant on, got "
        f"{np.degrees(np.ptp(angle)):.4g} deg"
    )


def write_noise(found: Noise, path: Path) -> list[Path]:
    """Write tables over time and by frequency, and a picture of both; names begin with `path`."""
    over = path.with_name(f"{path.name}-noise.csv")
    by = path.with_name(f"{path.name}-noise-spectrum.csv")
    picture = path.with_name(f"{path.name}-noise.png")
    path.parent.mkdir(parents=True, exist_ok=True)
    for file, first, columns, total in (
        (
            over,
            {"time [s]": found.time, "crank_angle [rad]": found.angle},
            found.power,
            found.total,
        ),
        (by, {"frequency [Hz]": found.frequency}, found.spectrum, found.total_spectrum),
    ):
        sides = {f"power {side} [W]": values for side, values in columns.items()}
        table = {**first, "power [W]": total, **sides}
        rows = np.empty(len(total), [(name, float) for name in table])
        for name, values in table.items():
            rows[name] = values
        write_csv(file, rows)
    return [over, by, save(draw(found), picture)]


def draw(found: Noise) -> Any:
    """Draw levels over crank angle and by frequency, for all sides and each of them."""
    figure, (over, by) = subplots(2, 1, figsize=(11, 7.5))
    degrees = np.degrees(found.angle)
    for panel, x, powers in (
        (over, degrees, {**found.power, "all sides": found.total}),
        (by, found.frequency[1:], {**found.spectrum, "all sides": found.total_spectrum}),
    ):
        for colour, (side, power) in zip((*PALETTE[1:], PALETTE[0]), powers.items()):
            bold = side == "all sides"
            panel.plot(
                x, level(power[-len(x) :]), lw=1.6 if bold else 0.8, label=side, color=colour
            )
    label_abscissa(over, CRANK_ANGLE, "deg")
    over.set_ylabel("radiated power [dB re 1 pW]")
    by.set_ylabel("mean power [dB re 1 pW]")
    by.set_xlabel("frequency [Hz]")
    by.set_xscale("log")
    for panel in (over, by):
        panel.grid(alpha=0.3)
        panel.margins(x=0)
        bottom, top = panel.get_ylim()
        panel.set_ylim(max(bottom, top - 80.0), top)
    add_legend(over)
    return figure
