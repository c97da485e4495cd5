"""Judgement of a measured profile: coverage, sign, turn, diameter and dust; and a smooth table.

Every limit is our own choice. A profile of a skirt is the radial distance inside its nominal
radius, positive inwards.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..master.fmi.preview import Message
from .geometry.profile import MeasuredShape, table_shape

LEAST_COVERAGE, COMPLETE_COVERAGE = 0.5, 0.99
"""Covered share of the length below which a table is rejected, and below which it is incomplete."""
UNUSUAL_DEVIATION, LARGEST_DEVIATION = 1e-3, 5e-3
"""Deviations that are unusual, and that no skirt has [m]."""
SMALLEST_FORM = 2e-6
"""Barrel, ovality and range of values [m] below which they are no form of a skirt."""
TURNED = np.radians(20.0)
"""Angle of the ovality from the pin axis, above which a table seems turned [rad]."""
UNUSUAL_OVALITY, UNUSUAL_DROP = 3.9e-3, 0.79e-3
"""Ovality and drop of the ends over the diameter that are unusual: nearly twice those of `new`."""
LEAST_DUST = 5e-6
"""Smallest height of a grain of dust [m]."""
LEAST_DUST_OVER_NOISE = 8.0
"""Smallest height of a grain of dust over the standard deviation of the noise."""
MOST_DUST = 0.01
"""Share of the values that can be dust; more of them are features of the surface."""
FEWEST_HEIGHTS, FEWEST_ANGLES = 5, 12
"""Lines of a table from which it can be smoothed in this direction: with fewer angles, the fourth
order of a skirt is no noise."""
OVAL_ANGLES = 4
"""Angles from which a table has an ovality."""


class Form(NamedTuple):
    """Shape of a profile between two heights.

    Parameters
    ----------
    barrel : float
        Drop of the mean parabola at the ends, positive if the skirt is widest between them [m].
    ovality : float
        Diameter across the thrust faces minus diameter along the pin, if turned so [m].
    turn : float
        Angle of the smallest diameter from the pin axis, -pi/2 to pi/2 [rad].
    """

    barrel: float
    ovality: float
    turn: float


class Grain(NamedTuple):
    """Grain of dust: its row and column in the table, and its gap over that of the surface [m]."""

    row: int
    column: int
    gap: float


class SmoothShape(NamedTuple):
    """Smooth profile, and what the smoothing removed.

    Parameters
    ----------
    shape : MeasuredShape
    order : int
        Highest order of its Fourier series around [-].
    noise : float
        Root mean square of the removed differences without the grains [m].
    grains : list of Grain
        Empty if more values than `MOST_DUST` differ, which then are features of the surface.
    rough : int
        Number of those values.
    """

    shape: MeasuredShape
    order: int
    noise: float
    grains: list[Grain]
    rough: int


def form_of(shape: MeasuredShape, lower: float, upper: float) -> Form:
    """Return barrel and ovality of a profile, the parabola by least squares.

    Eq. (I15):  mean over theta of gap = a + b t + barrel t^2,      t = -1 to 1 between the heights
                ovality/4 exp(2 i turn) = 2 mean of gap exp(2 i theta)

    Parameters
    ----------
    shape : MeasuredShape
    lower, upper : float
        Heights [m].
    """
    angle = np.arange(72) * (np.pi / 36)
    gap = table_shape(shape, angle, np.linspace(lower, upper, 21))
    barrel = float(np.polyfit(np.linspace(-1.0, 1.0, 21), gap.mean(axis=0), 2)[0])  # Eq. (I15)
    if shape.angle.size < OVAL_ANGLES:
        return Form(barrel, 0.0, 0.0)
    second = 2.0 * np.mean(gap.mean(axis=1) * np.exp(2j * angle))  # Eq. (I15)
    return Form(barrel, 4.0 * float(abs(second)), float(np.angle(second)) / 2)


def judge_profile(
    shape: MeasuredShape, lower: float, upper: float, radius: float | None
) -> list[Message]:
    """Return the findings about a measured shape.

    Parameters
    ----------
    shape : MeasuredShape
    lower, upper : float
        Ends of the skirt or the bore in the heights of the table [m].
    radius : float or None
        Nominal radius of the skirt [m]. None for a bore, which has no usual sign and form.
    """
    low, high = float(shape.height[0]), float(shape.height[-1])
    share = covered_share(shape, lower, upper)
    span = f"{_mm(lower)} to {_mm(upper)} mm, got {_mm(low)} to {_mm(high)} mm"
    if share < LEAST_COVERAGE:
        text = f"expected heights over {span}; check height_unit and the origin of the heights"
        return [Message("fault", text)]
    largest = float(np.abs(shape.value).max())
    if largest > LARGEST_DEVIATION:
        text = f"expected deviations below {_mm(LARGEST_DEVIATION)} mm, got {_mm(largest)} mm"
        hint = "check value_unit, or subtract the nominal radius from radii"
        return [Message("fault", f"{text}; {hint}")]
    messages = []
    if share < COMPLETE_COVERAGE:
        text = f"expected heights over {span}; the first and the last row continue to the ends"
        messages.append(Message("warning", text))
    if largest > UNUSUAL_DEVIATION:
        text = f"expected deviations below {_um(UNUSUAL_DEVIATION)}, got {_um(largest)}"
        messages.append(Message("warning", f"{text}; check value_unit"))
    if radius is not None and 0 < (step := float(np.ptp(shape.value))) < SMALLEST_FORM:
        text = f"expected values that differ by more than {_um(SMALLEST_FORM)}, got {_um(step)}"
        hint = "check value_unit, or subtract the nominal radius from radii"
        messages.append(Message("warning", f"{text}; {hint}"))
    if radius is not None:
        form = form_of(shape, max(low, lower), min(high, upper))
        messages += _of_form(shape, form, 2 * radius)
    return messages + _of_surface(shape)


def covered_share(shape: MeasuredShape, lower: float, upper: float) -> float:
    """Return the share of the length from `lower` to `upper` [m] within the heights of a table.

    A single row covers all heights.
    """
    if shape.height.size == 1:
        return 1.0
    low, high = max(shape.height[0], lower), min(shape.height[-1], upper)
    return float(max(high - low, 0.0)) / (upper - lower)


def _of_form(shape: MeasuredShape, form: Form, diameter: float) -> list[Message]:
    """Return findings about sign, turn and diameter."""
    messages = []
    oval = form.ovality > SMALLEST_FORM
    concave = shape.height.size > 2 and form.barrel < -SMALLEST_FORM
    turned = oval and abs(form.turn) > TURNED
    degrees = float(np.degrees(form.turn))
    if concave:
        text = f"expected a skirt that narrows towards its ends, got {_um(-form.barrel)} wider ends"
        hint = "values are positive inwards; change their sign if they grow with the diameter"
        messages.append(Message("warning", f"{text}; {hint}"))
    elif turned:
        text = (
            f"expected the smallest diameter at 0 deg, along the pin, got it at {degrees:.0f} deg"
        )
        hint = "angles count from the pin axis towards thrust; turn the table or check its sign"
        messages.append(Message("warning", f"{text}; {hint}"))
    if oval and (
        form.ovality > UNUSUAL_OVALITY * diameter or form.barrel > UNUSUAL_DROP * diameter
    ):
        text = (
            f"expected a usual form, got an ovality of {_um(form.ovality)} in diameter and a drop "
            f"of {_um(form.barrel)} in radius; if values are diameters, halve value_unit"
        )
        messages.append(Message("warning", text))
    if half_turn(shape):
        text = "expected radii, got the same values at opposite angles"
        hint = "if they are differences of diameters, halve value_unit"
        messages.append(Message("remark", f"{text}; {hint}"))
    return messages


def half_turn(shape: MeasuredShape) -> bool:
    """Return whether all values at opposite angles are equal, as those of a gauge for diameters."""
    count = shape.angle.size
    if count < OVAL_ANGLES or count % 2:
        return False
    opposite = np.roll(shape.value, count // 2, axis=1)
    even = np.allclose(np.diff(shape.angle), 2 * np.pi / count, rtol=1e-3, atol=0.0)
    same = np.allclose(shape.value, opposite, rtol=0.0, atol=1e-9)
    return even and same and bool(np.ptp(shape.value))


def _of_surface(shape: MeasuredShape) -> list[Message]:
    """Return findings about dust and roughness of the table."""
    smooth = smooth_shape(shape)
    messages = []
    for grain in smooth.grains if smooth else ():
        side = "outside" if grain.gap < 0 else "inside"
        text = (
            f"expected a smooth surface, got a single value {_um(abs(grain.gap))} {side} it at "
            f"{place_of(shape, grain)}; dust or a scratch is removed by piston-cosim profile"
        )
        messages.append(Message("warning", f"{text} --smooth"))
    if smooth and smooth.rough:
        text = (
            f"expected a smooth surface, got {smooth.rough} values more than {_um(LEAST_DUST)} off"
        )
        messages.append(Message("remark", f"{text} it; steps and grooves are splines in the film"))
    return messages


def place_of(shape: MeasuredShape, grain: Grain) -> str:
    """Return angle and height of a grain as text."""
    angle = np.degrees(shape.angle[grain.column])
    return f"{angle:.4g} deg, {_mm(float(shape.height[grain.row]))} mm"


def smooth_shape(shape: MeasuredShape) -> SmoothShape | None:
    """Return a smooth profile without grains of dust, None for a table that is too small.

    Around, it is a Fourier series by least squares. Along, each coefficient is a cubic smoothing
    spline. Generalised cross-validation chooses their smoothness. Grains are the largest
    differences, which are replaced one after the other.
    """
    values = shape.value.copy()
    grains: list[Grain] = []
    while True:
        fitted = _fit(shape.angle, shape.height, values)
        if fitted is None:
            return None
        smooth, order = fitted
        off = shape.value - smooth
        for grain in grains:
            values[grain.row, grain.column] = smooth[grain.row, grain.column]
        rest = values - smooth
        noise = 1.4826 * float(np.median(np.abs(rest)))
        row, column = np.unravel_index(np.abs(rest).argmax(), rest.shape)
        if abs(rest[row, column]) <= max(LEAST_DUST, LEAST_DUST_OVER_NOISE * noise):
            break
        if len(grains) >= max(1, MOST_DUST * values.size):
            rough = int((np.abs(off) > max(LEAST_DUST, LEAST_DUST_OVER_NOISE * noise)).sum())
            smooth, order = _fit(shape.angle, shape.height, shape.value) or fitted
            rms = float(np.sqrt(np.mean((shape.value - smooth) ** 2)))
            return SmoothShape(replace(shape, value=smooth), order, rms, [], rough)
        grains.append(Grain(int(row), int(column), 0.0))
        values[row, column] = smooth[row, column]
    known = [one._replace(gap=float(off[one.row, one.column])) for one in grains]
    rms = float(np.sqrt(np.mean(rest**2)))
    return SmoothShape(replace(shape, value=smooth), order, rms, known, 0)


def _fit(angle: np.ndarray, height: np.ndarray, values: np.ndarray):
    """Return smooth values and the order around, None if both directions have too few lines."""
    if angle.size < FEWEST_ANGLES and height.size < FEWEST_HEIGHTS:
        return None
    order, basis = _orders(angle, values)
    series = np.linalg.lstsq(basis, values.T, rcond=None)[0]  # (coefficients, k)
    if height.size >= FEWEST_HEIGHTS:
        from scipy.interpolate import make_smoothing_spline  # slow to import

        along = (height - height[0]) / np.median(np.diff(height))
        series = np.array([make_smoothing_spline(along, one)(along) for one in series])
    return (basis @ series).T, order


def _orders(angle: np.ndarray, values: np.ndarray) -> tuple[int, np.ndarray]:
    """Return order and basis (m, 2 order + 1) of the series with the least cross-validation."""
    if angle.size < FEWEST_ANGLES:
        return angle.size // 2, np.eye(angle.size)
    best = np.inf, 0, np.ones((angle.size, 1))
    for order in range((angle.size - 1) // 2):
        turns = np.outer(angle, np.arange(1, order + 1))
        basis = np.hstack([np.ones((angle.size, 1)), np.cos(turns), np.sin(turns)])
        left = values.T - basis @ np.linalg.lstsq(basis, values.T, rcond=None)[0]
        score = float(np.sum(left**2)) / (angle.size - basis.shape[1]) ** 2
        if score < best[0]:
            best = score, order, basis
    return best[1:]


def _um(length: float) -> str:
    """Return a length [m] as text."""
    return f"{1e6 * length:.3g} \N{MICRO SIGN}m"


def _mm(length: float) -> str:
    """Return a length [m] as a number in mm."""
    return f"{1e3 * length:.4g}"
