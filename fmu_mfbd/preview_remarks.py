"""Remarks of a preview on gas pressure, profiles, clearance and openings."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.quantities import short
from .build import Tables
from .dynamics.parameters import Parameters
from .finite_elements.mesh import Mesh
from .options import Build
from .preview_picture import Shapes
from .profile_judgement import judge_profile

MISFIT = 0.3e-3
"""Difference of skirt and bore radius from the clearance [m] above which it is worth a remark: a
mesh is drawn at the nominal diameter or a few tenths below."""
LEAST_GAS, HIGH_GAS, IMPOSSIBLE_GAS = 0.05e6, 30e6, 100e6
"""Highest gas pressures [Pa] below, above and far above those of engines."""
ABSOLUTE = 0.7e5, 1.3e5
"""Lowest gas pressure of a table in absolute pressure [Pa]."""
COLD = ("skirt_growth_lower", "skirt_growth_upper", "bore_growth_lower", "bore_growth_upper")
"""Parameters that heat brings."""
FEWEST = 3
"""Cells that an opening in the skirt should be wide, for its edge to lie within half of them."""


class BodyPreview(NamedTuple):
    """A body as rigid as a data sheet, and what a mesh says besides.

    Parameters
    ----------
    body : ReducedPiston or ReducedBlock
        Without modes.
    skirt : ndarray of bool, shape (c, a), or None
        Cells of the film grid with the skirt under them, where that is known.
    mesh : Mesh, optional
        None without one.
    """

    body: Any
    skirt: np.ndarray | None = None
    mesh: Mesh | None = None


class NarrowestGap(NamedTuple):
    """Smallest clearance of the concentric piston [m], at theta [deg] and y' [m]."""

    gap: float
    angle: float
    height: float


def narrowest(shapes: Shapes, hot: bool) -> NarrowestGap:
    """Return the smallest clearance of the concentric, undeformed piston where there is a film."""
    gap = np.where(shapes.film, shapes.clearance(hot), np.inf)
    i, j = np.unravel_index(gap.argmin(), gap.shape)
    degrees = float(np.degrees(shapes.angle[i])) % 360.0
    return NarrowestGap(float(gap[i, j]), degrees, float(shapes.height[j]))


def remarks_on_fit(
    build: Build, piston: BodyPreview, block: BodyPreview, chosen: Parameters, shapes: Shapes
) -> list[str]:
    """Return remarks on clearance, heat and profile."""
    out = []
    fit = block.body.radius - piston.body.radius
    if abs(fit - chosen.radial_clearance) > MISFIT:
        out.append(
            f"radial_clearance = {_um(chosen.radial_clearance)}, bore minus skirt radius "
            f"is {_um(fit)}: the film goes by radial_clearance"
        )
    least = narrowest(shapes, hot=True)
    if least.gap <= 0.0:
        out.append(
            f"the skirt is wider than the bore by {_um(-least.gap)} when hot, at "
            f"{least.angle:.4g} deg, {1e3 * least.height:.3g} mm above the pin"
        )
    if not any(getattr(chosen, name) for name in COLD):
        out.append(f"no thermal growth given ({', '.join(COLD)}): hot is as cold")
    if build.piston.profiles and (chosen.barrel or chosen.ovality):
        out.append(
            f"barrel = {_um(chosen.barrel)} and ovality = {_um(chosen.ovality)} "
            "are added to the measured profile; set them to 0 if it holds them"
        )
    if not build.piston.profiles and not chosen.barrel:
        out.append(f"barrel = {_um(0.0)}: a straight skirt carries on its edges")
    return out + _thin_openings(shapes.film)


def remarks_on_gas(pressure: np.ndarray) -> list[str]:
    """Return remarks on a gas pressure that is unusual, as from a wrong unit."""
    low, high = float(pressure.min()), float(pressure.max())
    told = f"highest gas pressure = {short(high, 'Pa')}"
    if high > IMPOSSIBLE_GAS or high < LEAST_GAS:
        return [f"{told}: check pressure_unit"]
    out = [f"{told}: engines have less than 30 MPa"] if high > HIGH_GAS else []
    if ABSOLUTE[0] < low < ABSOLUTE[1]:
        out.append(
            f"lowest gas pressure = {short(low, 'Pa')}: the table seems absolute; "
            "expected gauge pressure, about 0 in the exhaust"
        )
    return out


def faults_of_profiles(
    build: Build, tables: Tables, piston: BodyPreview, block: BodyPreview, remarks: list[str]
) -> list[str]:
    """Return the faults of measured profiles of skirt and bore, and append the other findings."""
    skirt = piston.body.skirt_lower, piston.body.skirt_upper, piston.body.radius
    bore = float(block.body.heights[0]), float(block.body.heights[-1]), None
    faults = []
    for name, part, shapes, ends in (
        ("piston", build.piston, tables.skirt, skirt),
        ("block", build.block, tables.bore, bore),
    ):
        for table, shape in zip(part.profiles, shapes):
            for kind, text in judge_profile(shape, *ends):
                chosen = faults if kind == "fault" else remarks
                chosen.append(f"build.{name}.profiles, {Path(table.file).name}: {text}")
    return faults


def _um(length: float) -> str:
    """Return a length [m] as text."""
    return f"{1e6 * length:.4g} \N{MICRO SIGN}m"


def _thin_openings(film: np.ndarray) -> list[str]:
    """Return a remark if the openings in the skirt are few cells wide."""
    widest = max((run for line in film.T for run in runs(~line)), default=FEWEST)
    if widest >= FEWEST:
        return []
    return [
        f"openings in the skirt are {widest} cells wide: their edges lie within half a cell; a "
        f"finer grid than {' x '.join(map(str, film.shape))} tells what that is worth"
    ]


def runs(flags: np.ndarray) -> list[int]:
    """Return the lengths of the runs of true values on a ring."""
    if flags.all() or not flags.any():
        return []
    turned = np.roll(flags, -int(np.argmin(flags)))  # begins with a false one
    edges = np.flatnonzero(np.diff(np.concatenate([turned, [False]]).astype(int)))
    return [int(end - begin) for begin, end in zip(edges[::2], edges[1::2])]
