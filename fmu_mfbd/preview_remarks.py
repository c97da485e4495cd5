"""Messages of a preview on gas pressure, profiles, clearance and openings."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.preview import Message
from ..master.fmi.quantities import short
from .dynamics.parameters import Parameters
from .dynamics.tables import GasTable
from .finite_elements.mesh import Mesh
from .input_tables import Tables
from .options import Build
from .preview_picture import Shapes
from .profile_judgement import UNUSUAL_DROP, UNUSUAL_OVALITY, judge_profile

USUAL_MASS = 0.1e3, 10e3
"""Mass of a piston over the cube of its diameter [kg/m^3], our own choice: 500 to 1040 is usual."""
CLEARANCE_DIFFERENCE = 0.3e-3
"""Difference of skirt and bore radius from the clearance [m] above which it is worth a remark: a
mesh is drawn at the nominal diameter or a few tenths below."""
RADIUS_TOLERANCE = 20e-6
"""Tolerance of a bore radius below that of the skirt [m], for meshes of one nominal diameter."""
LEAST_GAS, HIGH_GAS = 0.05e6, 30e6
"""Highest gas pressures [Pa] below and above those of engines."""
HIGHEST_MOTORED_PRESSURE = 0.7e6
"""Highest gas pressure without combustion, unthrottled, at a compression ratio of 5 [Pa]."""
ABSOLUTE_PRESSURES = 0.7e5, 1.5e5
"""Mean gas pressure of the exhaust stroke in absolute pressure [Pa]."""
LEAST_EXHAUST = -0.3e5
"""Mean gauge pressure in the exhaust below that of engines, our own choice [Pa]."""
EXHAUST = {720: (225.0, 345.0), 360: (150.0, 210.0)}
"""Crank angles after firing top dead centre with an open exhaust, by the length of the cycle
[deg]."""
WIDEST_ROWS = 30.0
"""Crank angle between rows of a gas table above which a straight line is no gas, our choice [deg].
"""
FIRING_RANGE = 60.0
"""Crank angle next to firing top dead centre that contains the highest gas pressure [deg]."""
ELASTIC_INTERFERENCE = 1e-3
"""Interference over bore radius that a flexible skirt can take by deflection, our own choice."""
COLD = ("skirt_growth_lower", "skirt_growth_upper", "bore_growth_lower", "bore_growth_upper")
"""Parameters of thermal growth."""
FEWEST_OPENING_CELLS = 3
"""Cells that an opening in the skirt should be wide, for its edge to be within half of them."""


class BodyPreview(NamedTuple):
    """A rigid body, and the data of its mesh.

    Parameters
    ----------
    body : ReducedPiston or ReducedBlock
        Without modes.
    skirt : ndarray of bool, shape (c, a), or None
        Cells of the film grid with the skirt under them, where that is known.
    mesh : Mesh, optional
        None without one.
    tie : str
        Tie of a piston's pin bores; empty without modes and without a mesh.
    boss_length : float, optional
        Length of each boss that slides on the pin [m]; None with another tie.
    """

    body: Any
    skirt: np.ndarray | None = None
    mesh: Mesh | None = None
    tie: str = ""
    boss_length: float | None = None


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


def messages_on_fit(
    build: Build, piston: BodyPreview, block: BodyPreview, chosen: Parameters, shapes: Shapes
) -> list[Message]:
    """Return messages on clearance, heat and profile."""
    out: list[Message] = []
    fit = block.body.radius - piston.body.radius
    if fit < -RADIUS_TOLERANCE:
        text = (
            f"block, piston: expected a bore radius of at least the skirt's, "
            f"{1e3 * piston.body.radius:.6g} mm, got {1e3 * block.body.radius:.6g} mm, "
            f"{_um(-fit)} less"
        )
        out.append(Message("fault", text))
    elif abs(fit - chosen.radial_clearance) > CLEARANCE_DIFFERENCE:
        text = (
            f"radial_clearance = {_um(chosen.radial_clearance)}, bore minus skirt radius is "
            f"{_um(fit)}: the film goes by radial_clearance"
        )
        out.append(Message("warning", text))
    flexible = bool(build.piston.modes) and not build.piston.rigid
    out += _interference(shapes, block.body.radius, flexible)
    grown = [name for name in COLD if getattr(chosen, name)]
    is_hot = build.piston.is_hot or build.block.is_hot
    if not grown and shapes.walls is None and not is_hot:
        text = f"thermal growth not set ({', '.join(COLD)}): hot clearance equals cold clearance"
        out.append(Message("remark", text))
    for part, body in (("skirt", build.piston), ("bore", build.block)):
        if body.is_hot and (twice := [name for name in grown if name.startswith(part)]):
            text = (
                f"{', '.join(twice)}: expected 0 with a hot shape of the {part}, which they add to"
            )
            out.append(Message("warning", text))
    if build.piston.profiles and (chosen.barrel or chosen.ovality):
        text = (
            f"barrel = {_um(chosen.barrel)} and ovality = {_um(chosen.ovality)} "
            "are added to the measured profile; set them to 0 if it holds them"
        )
        out.append(Message("remark", text))
    for name, share in (("barrel", UNUSUAL_DROP), ("ovality", UNUSUAL_OVALITY)):
        if (value := getattr(chosen, name)) > (most := share * 2 * piston.body.radius):
            text = f"{name} = {_um(value)}: expected at most {_um(most)} in engines; check its unit"
            out.append(Message("warning", text))
    low, high = (share * (2.0 * piston.body.radius) ** 3 for share in USUAL_MASS)
    if not low < piston.body.mass < high:
        text = f"expected {low:.3g} to {high:.3g} kg for its diameter; check its unit"
        out.append(Message("warning", f"mass of the piston = {piston.body.mass:.4g} kg: {text}"))
    if not build.piston.profiles and not chosen.barrel:
        text = f"barrel = {_um(0.0)}: a straight skirt carries on its edges"
        out.append(Message("warning", text))
    return out + [Message("warning", line) for line in _thin_openings(shapes.film)]


def _interference(shapes: Shapes, radius: float, flexible: bool) -> list[Message]:
    """Return a message if the skirt is wider than the bore, cold or else hot.

    It is a fault, unless the skirt is flexible and yields.
    """
    for state in ("cold", "hot"):
        least = narrowest(shapes, state == "hot")
        if least.gap <= 0.0:
            yields = flexible and state == "hot" and -least.gap <= ELASTIC_INTERFERENCE * radius
            text = (
                f"radial_clearance: expected a skirt that fits into the bore, got one that is "
                f"wider by {_um(-least.gap)} when {state}, at {least.angle:.4g} deg, "
                f"{1e3 * least.height:.3g} mm above the pin"
            )
            return [Message("warning" if yields else "fault", text)]
    return []


def messages_on_gas(table: GasTable) -> list[Message]:
    """Return messages on a gas pressure that is unusual, as from a wrong unit or reference.

    The exhaust stroke shows whether the pressure is absolute: then it is near 1 bar.
    """
    degrees = np.degrees(table.angle) % 720.0
    high = float(table.pressure.max())
    subject = f"highest gas pressure = {short(high, 'Pa')}"
    if high < LEAST_GAS:
        return [Message("warning", f"{subject}: check pressure_unit")]
    out: list[Message] = []
    if high > HIGH_GAS:
        out.append(Message("warning", f"{subject}: engines have less than 30 MPa"))
    elif high < HIGHEST_MOTORED_PRESSURE:
        text = f"{subject}: expected above 0.7 MPa, which compression reaches; check pressure_unit"
        out.append(Message("remark", text))
    cycle = 720 if table.cycle > 3.0 * np.pi else 360
    peak = float((degrees[table.pressure.argmax()] + cycle / 2) % cycle - cycle / 2)
    if abs(peak) > FIRING_RANGE:
        out.append(
            Message("warning", f"{subject} at {peak:.4g} deg: expected near 0 deg, where it fires")
        )
    gaps = np.degrees(np.diff(table.angle))
    if gaps.max() > WIDEST_ROWS:
        text = (
            f"gas pressure: expected rows at most {WIDEST_ROWS:g} deg apart, got {gaps.max():.4g} "
            f"deg after {np.degrees(table.angle[gaps.argmax()]):.4g} deg"
        )
        out.append(Message("warning", text))
    angles = np.radians(np.arange(*EXHAUST[cycle]))
    mean = float(np.interp(angles, table.angle, table.pressure, period=table.cycle).mean())
    if ABSOLUTE_PRESSURES[0] < mean < ABSOLUTE_PRESSURES[1]:
        text = (
            f"mean gas pressure in the exhaust = {short(mean, 'Pa')}: the table seems absolute; "
            "expected gauge pressure, about 0 there; subtract about 1 bar from the second column"
        )
        out.append(Message("warning", text))
    elif abs(peak) <= FIRING_RANGE and not LEAST_EXHAUST < mean < ABSOLUTE_PRESSURES[1]:
        text = (
            f"mean gas pressure in the exhaust = {short(mean, 'Pa')}: expected gauge pressure near "
            "0; check that the table is neither absolute nor reduced twice"
        )
        out.append(Message("remark", text))
    return out


def messages_on_profiles(
    build: Build, tables: Tables, piston: BodyPreview, block: BodyPreview
) -> list[Message]:
    """Return the messages on measured profiles of skirt and bore."""
    skirt = piston.body.skirt_lower, piston.body.skirt_upper, piston.body.radius
    bore = float(block.body.heights[0]), float(block.body.heights[-1]), None
    messages = []
    for name, part, shapes, ends in (
        ("piston", build.piston, tables.skirt, skirt),
        ("block", build.block, tables.bore, bore),
    ):
        for table, shape in zip(part.profiles, shapes):
            where = f"build.{name}.profiles, {Path(table.file).name}"
            for kind, text in judge_profile(shape, *ends):
                messages.append(Message(kind, f"{where}: {text}"))
    return messages


def _um(length: float) -> str:
    """Return a length [m] as text."""
    return f"{1e6 * length:.4g} \N{MICRO SIGN}m"


def _thin_openings(film: np.ndarray) -> list[str]:
    """Return a remark if the openings in the skirt are few cells wide."""
    widest = max((run for line in film.T for run in runs(~line)), default=FEWEST_OPENING_CELLS)
    if widest >= FEWEST_OPENING_CELLS:
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
