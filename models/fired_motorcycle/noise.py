"""Equivalent radiated power of a flexible block in a run, over crank angle and by frequency.

    python -m piston_cosim.models.fired_motorcycle.noise RUN.h5 [CASE]

The run has recorded the field modal_velocity at even intervals. CASE has the meshes. Default: the
case with the name of the results folder, then the shipped case with the title of the run. The
radiation efficiency is 1, so the power is an upper bound at low frequencies.

References
----------
[Cremer2005] L. Cremer, M. Heckl, B. A. T. Petersson, Structure-borne sound, 3rd ed., Springer 2005,
ch. 7: radiated power, radiation efficiency.
"""

from argparse import ArgumentParser
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.finite_elements.faces import normal_products
from piston_cosim.fmu_mfbd.reduction.reduced_body import Anatomy, ReducedBlock, load
from piston_cosim.master.commands.common import bodies_of, case_folder
from piston_cosim.master.commands.usage import faults_of
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.figures import add_legend, save, subplots
from piston_cosim.master.results.file import Results
from piston_cosim.master.results.instants import crank_angle

AIR = 413.0
"""Density times speed of sound of air at 20 degC and 1 bar [kg/(m2 s)]."""
REFERENCE = 1e-12
"""Reference power of levels [W]."""
SIDES = (("+x", 0, 1), ("-x", 0, -1), ("+y", 1, 1), ("-y", 1, -1), ("+z", 2, 1), ("-z", 2, -1))
"""Name, axis and sign of the outward normal's largest component."""
ON_BORE = 1e-2
"""Largest distance of the corners of the bore's faces from it, relative to its radius."""
EVEN = 1e-2
"""Tolerance of a whole number of intervals, relative to an interval."""
NEAR = 1e-6
"""Relative tolerance of the length of a period."""
FEWEST = 8
"""Minimum number of even instants per period."""


class Spectrum(NamedTuple):
    """Radiated power of the last period by side [W].

    power : over the crank angle [rad]; mean : at each frequency [Hz], with the mean power as sum.
    """

    angle: np.ndarray
    power: dict[str, np.ndarray]
    frequency: np.ndarray
    mean: dict[str, np.ndarray]


def radiation(block: ReducedBlock, anatomy: Anatomy) -> dict[str, np.ndarray]:
    """Return R of each side for mass-normalised modes, all outer faces but the bore's [m2/kg].

    Eq. (J25):  P = rho c q'^T R q',   R of Eq. (M19)      power of a side, radiation efficiency 1
    """
    corners = anatomy.points[anatomy.skin[:, :3]]
    away = np.hypot(corners[..., 0], corners[..., 2])
    on_bore = (np.abs(away - block.radius) < ON_BORE * block.radius).all(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    sign = np.sign(np.take_along_axis(normal, axis[:, None], 1)[:, 0])
    faces = {
        name: anatomy.skin[~on_bore & (axis == its_axis) & (sign == its_sign)]
        for name, its_axis, its_sign in SIDES
    }
    return {
        name: normal_products(anatomy.points, own, anatomy.shapes)
        for name, own in faces.items()
        if len(own)
    }


def spectrum(results: Results, owner: str, products: dict[str, np.ndarray]) -> Spectrum:
    """Return the power that the last modes of the recorded ones radiate in the last period.

    A cubic spline interpolates their velocities at equidistant instants, with the largest recorded
    interval.

    Eq. (W3):  P_m = rho c c_m V_m^* R V_m / n^2,   V the discrete Fourier transform of q', c_m = 2
               except for the constant part and n/2
    """
    crank = crank_angle(results)
    if crank is None or f"{owner}.modal_velocity" not in results.recorded:
        raise BadInput(
            f"{results.path}: expected a crank angle and {owner}.modal_velocity, got none; set "
            "record.fields and record.every = '1 deg'"
        )
    period = results.last
    instants = period.instants
    length = np.ptp(instants)
    if not period.period or length < (1.0 - NEAR) * period.period:
        raise BadInput(f"{results.path}: expected a period with recorded ends, got {length:.4g} s")
    n = int(length / np.diff(instants).max() + EVEN)
    if n < FEWEST:
        raise BadInput(f"{results.path}: expected {FEWEST} even instants in a period, got {n}")
    # the first instant is the last one of the previous period
    time = instants[0] + length / n * np.arange(1.0, n + 1.0)
    modes = len(next(iter(products.values())))
    velocity = period.dataset(f"{owner}.modal_velocity")[:][:, -modes:]
    velocity = make_interp_spline(instants, velocity)(time)
    transformed = np.fft.rfft(velocity, axis=0)
    twice = np.full(len(transformed), 2.0)
    twice[0] = 1.0
    if n % 2 == 0:
        twice[-1] = 1.0
    power, mean = {}, {}
    for side, product in products.items():
        power[side] = AIR * np.einsum("tk,kl,tl->t", velocity, product, velocity)  # Eq. (J25)
        square = np.einsum("mk,kl,ml->m", transformed.conj(), product, transformed).real
        mean[side] = AIR * twice * square / n**2  # Eq. (W3)
    return Spectrum(np.interp(time, *crank), power, np.arange(len(transformed)) / length, mean)


def level(power):
    """Return levels of powers [W] relative to 1 pW [dB]."""
    return 10.0 * np.log10(np.maximum(power, 1e-30 * REFERENCE) / REFERENCE)


def main(file: Path, case: str | None = None) -> None:
    """Print the mean power of each side, and draw all over crank angle and frequency."""
    results, tables = bodies_of(file)
    folder = case_folder(results, case)
    for owner, table in tables.items():
        files = reduced_bodies(table, folder, print, shapes=True)
        block = load(ReducedBlock, files["block"])
        if not len(block.omega):
            raise BadInput("block.modes: expected a flexible block, got a rigid one")
        sound = spectrum(results, owner, radiation(block, load(Anatomy, files["block"])))
        figure, (over, by) = subplots(2, 1, figsize=(11, 7.5))
        total = sum(sound.power.values()), sum(sound.mean.values())
        sides = {side: (sound.power[side], sound.mean[side]) for side in sound.power}
        for side, (power, mean) in {**sides, "all sides": total}.items():
            print(f"{owner} {side:9}  {level(power.mean()):5.1f} dB re 1 pW, {power.mean():.3g} W")
            over.plot(np.degrees(sound.angle), level(power), label=side)
            by.semilogx(sound.frequency[1:], level(mean[1:]), label=side)
        over.set(xlabel="crank angle [deg]", ylabel="radiated power [dB re 1 pW]")
        by.set(xlabel="frequency [Hz]", ylabel="mean power [dB re 1 pW]")
        add_legend(over)
        print(save(figure, results.path.with_name(f"{results.path.stem}-{owner}-noise.png")))


if __name__ == "__main__":
    parser = ArgumentParser(prog=f"python -m {__spec__.name}")
    parser.add_argument("file", type=Path, help="results file of a run with a flexible block")
    parser.add_argument("case", nargs="?", help="case whose folder contains the meshes")
    try:
        main(**vars(parser.parse_args()))
    except (BadInput, OSError) as error:
        parser.error("\n".join(faults_of(error)))
