"""Verification of the lubrication model against closed forms and published values.

Each case is a function that yields its checks; `checks` chains them.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

from piston_cosim.fmu_ehd.balance import storage
from piston_cosim.fmu_ehd.balance.film_step import FilmSolution
from piston_cosim.fmu_ehd.balance.films import rough_film, smooth_film
from piston_cosim.fmu_ehd.balance.storage import ContentHistory, EulerStep
from piston_cosim.fmu_ehd.common.faults import NotConverged
from piston_cosim.fmu_ehd.common.grid import LOWER, Array, Edges, Entrainment, unlimited_supply
from piston_cosim.fmu_ehd.common.quantities import CONDUCTIVITY_A, COUETTE, STORED
from piston_cosim.fmu_ehd.laws import asperity, oil, roughness
from piston_cosim.fmu_ehd.laws.friction import ShearConstants, ShearInputs, viscous_force
from piston_cosim.fmu_ehd.parameters import Parameters

from . import bearings
from .checks import Check, at_most, compared, conserved, ordered
from .grids import FilmStep, Grid, flooded_edges
from .motored import DEGREE, motored, motored_tangent_error, motored_until, physics

FLOOR = 1e-9  # [m], minimum flow film of cases that never touch it
SECOND_ORDER = "second order in the cell size"
CLOSED_FORM, SERIES = "closed form", "closed form (series)"
MOVING_FRONTS = "independent solution of the moving fronts"
TABLE, QUADRATURE = "recomputed table", "numerical quadrature"

Checks = Iterator[Check]


class Pad(NamedTuple):
    """Load, drag on the moving surface and highest pressure of a pad [-]."""

    load: float
    drag: float
    peak: float


class SqueezePlate(NamedTuple):
    """Load and highest pressure of a squeezed plate [-]."""

    load: float
    peak: float


class OscillatingSqueeze(NamedTuple):
    """A film that ruptures and reforms.

    times : ndarray, shape (n,), ends of the steps [-];
    width : ndarray, shape (n,), width of the full film at each side [-], 0.5 where it is full;
    imbalance : largest mass imbalance of a step; pressure : highest at the end [-].
    """

    times: Array
    width: Array
    imbalance: float
    pressure: float


class RandomFilms(NamedTuple):
    """Statistics of steps of random films.

    failures: steps that did not converge or left the range of film fraction; iterations: most
    factorisations in a step; imbalance: largest mass imbalance.
    """

    failures: int
    iterations: int
    imbalance: float


def flow_film(film_thickness: Array, viscosity: float) -> Array:
    """Quantities of a film between smooth surfaces."""
    quantities, _ = smooth_film(film_thickness, np.full_like(film_thickness, viscosity), FLOOR)
    return quantities


def steady(
    grid: Grid,
    film_thickness: Array,
    sliding: float,
    viscosity: float,
    edges: Edges | None = None,
    model: str = "jfo",
    around: bool = False,
) -> FilmSolution:
    """Return the steady film under a surface that slides with velocity `sliding` [m/s].

    The surface slides along j, or along i if `around`. The other surface is at rest.
    """
    moving = np.full(grid.shape, 0.5 * sliding)
    still = np.zeros(grid.shape)
    return FilmStep(grid, model).solve(
        flow_film(film_thickness, viscosity),
        Entrainment(moving, still) if around else Entrainment(still, moving),
        edges or flooded_edges(grid.shape),
        EulerStep(film_thickness, np.inf),
        np.ones(grid.shape, dtype=bool),
    )


def centres(cells: int) -> Array:
    """Cell centres of the unit interval."""
    return (np.arange(cells) + 0.5) / cells


# ---- sliders without cavitation


def inclined_pad(cells: int, ratio: float = 1.0) -> Pad:
    """Return the infinite pad h = 1 + K (1 - x), all in units of 1.

    Eq. (V1):  W* = (6/K^2) [ln(1+K) - 2K/(2+K)],   F* = 4 ln(1+K)/K - 6/(2+K),
               p*max = 3K / [2 (1+K) (2+K)]
    """
    grid = Grid((1, cells), 1.0, 1.0)
    h = 1.0 + ratio * (1.0 - centres(cells)[None])
    film = steady(grid, h, 1.0, 1.0)
    viscous = viscous_force(
        ShearInputs(
            film.pressure,
            film.film_fraction,
            -np.ones(grid.shape),
            flow_film(h, 1.0),
            np.zeros(grid.shape),
            np.full(grid.shape, grid.cell_area),
            ShearConstants(0.0, 0.0, grid.cells.dy, 1.0),
        )
    )
    p = film.pressure[0]
    peak = p.argmax()
    # parabola through the three highest cells
    square, slope, value = np.polyfit([-1.0, 0.0, 1.0], p[peak - 1 : peak + 2], 2)
    return Pad(p.mean(), viscous.sum(), value - slope**2 / (4.0 * square))


def inclined_pad_checks() -> Checks:
    """Infinite inclined pad, and its observed order."""
    # Eq. (V1)
    exact = Pad(6.0 * (np.log(2.0) - 2.0 / 3.0), 4.0 * np.log(2.0) - 2.0, 0.25)
    names = "load W*", "drag F*", "highest pressure p*"
    rows = zip(names, inclined_pad(320), exact, [2e-5] * 3)
    yield from compared("Infinite inclined pad K=1, 320 cells", rows, CLOSED_FORM, SECOND_ORDER)
    best: Any = minimize_scalar(
        lambda ratio: -inclined_pad(320, ratio).load, bounds=(1.0, 1.4), method="bounded"
    )
    case = "Infinite inclined pad with the highest load, 320 cells"
    ratio = [("film ratio K", best.x, 1.18870, 2e-4)]
    yield from compared(case, ratio, CLOSED_FORM, SECOND_ORDER)
    load = [("load W*", -best.fun, 0.160243, 3e-5)]
    yield from compared(case, load, CLOSED_FORM, SECOND_ORDER + " and six printed digits")
    coarse, fine = (abs(inclined_pad(n).load - exact.load) for n in (40, 160))
    case = "Infinite inclined pad K=1, 40 to 160 cells"
    reason = "the leading error term dominates from 40 cells on"
    yield from ordered(case, "load", np.log2(coarse / fine) / 2.0, 0.05, reason)


def coarse_checks() -> Checks:
    """Check the default number of cells: errors that second order allows."""
    load = [("load W*", inclined_pad(40).load, 6.0 * (np.log(2.0) - 2.0 / 3.0), 1.2e-3)]
    reason = SECOND_ORDER + ", 64 times the error at 320 cells"
    yield from compared("Infinite inclined pad K=1, 40 cells", load, CLOSED_FORM, reason)
    load = [("load W h^3/(mu V L^4)", squeeze_plate(40).load, 0.421731, 3e-3)]
    yield from compared("Square parallel squeeze plate, 40x40", load, SERIES, SECOND_ORDER)
    coarse, fine = (squeeze_plate(n).load - 0.4217314 for n in (20, 40))
    case = "Square parallel squeeze plate, 20 to 40 cells"
    reason = "leading error term, and a logarithm at the corners"
    yield from ordered(case, "load", np.log2(coarse / fine), 0.1, reason)
    squeeze = oscillating_squeeze(40, 5e-4)
    end = squeeze.times[squeeze.width < 0.5][-1] + 5e-4
    case = "Oscillating squeeze, 40 cells, step 5e-4"
    rows = [("time of complete reformation", end, 0.7324, 4e-3)]
    reason = "the time a front takes to cross a cell"
    yield from compared(case, rows, MOVING_FRONTS, reason, "absolute")


def finite_pad_checks() -> Checks:
    """Finite inclined pad K=1 with p = 0 on four edges."""
    for breadth, load, peak, centre in (
        (4.0, 0.13459, 0.2492, 0.5707),
        (1.0, 0.06927, 0.1574, 0.5820),
    ):
        n = 61
        grid = Grid((n, n), breadth, 1.0, ring=False)
        h = np.broadcast_to(2.0 - centres(n)[None], grid.shape).copy()
        p = steady(grid, h, 1.0, 1.0).pressure
        rows = (
            ("load W*", p.mean(), load, 1e-3),
            ("highest pressure p*", p.max(), peak, 1e-3),
            ("centre of pressure x/L", (p * centres(n)).sum() / p.sum(), centre, 3e-4),
        )
        case = f"Finite inclined pad K=1, B/L={breadth:g}, 61x61"
        yield from compared(case, rows, TABLE, SECOND_ORDER + " and four printed digits")


# ---- squeeze


def squeeze_plate(cells: int) -> SqueezePlate:
    """Square parallel plates that approach each other, in units of 1."""
    grid = Grid((cells, cells), 1.0, 1.0, ring=False)
    h = np.ones(grid.shape)
    still = np.zeros(grid.shape)
    film = FilmStep(grid).solve(
        flow_film(h, 1.0),
        Entrainment(still, still),
        flooded_edges(grid.shape),
        EulerStep(h + 1.0, 1.0),
        np.ones(grid.shape, dtype=bool),
    )
    return SqueezePlate(film.pressure.mean(), film.pressure.max())


def squeeze_plate_checks() -> Checks:
    """Square parallel squeeze plate."""
    names = "load W h^3/(mu V L^4)", "highest pressure"
    rows = zip(names, squeeze_plate(61), (0.421731, 0.88404), (2e-3, 2e-3))
    yield from compared("Square parallel squeeze plate, 61x61", rows, SERIES, SECOND_ORDER)


def oscillating_squeeze(cells: int, step: float, end: float = 0.75) -> OscillatingSqueeze:
    """Return the film between plates that move as h = 0.375 + 0.125 cos(4 pi t).

    (h^3 p')' = 2 d(f h)/dt, with p = 0.025 at both ends.
    """
    grid = Grid((1, cells), 1.0, 1.0)
    film_step = FilmStep(grid)
    edges = flooded_edges(grid.shape, 0.025)
    still = Entrainment(np.zeros(grid.shape), np.zeros(grid.shape))
    content = np.full(grid.shape, 0.5)
    past = ContentHistory(content, np.zeros(grid.shape), np.zeros(grid.shape), 0.0)
    full = np.ones(grid.shape, dtype=bool)
    times: Array = np.arange(1.0, round(end / step) + 1.0) * step
    width = np.empty(times.size)
    imbalance = 0.0
    pressure = 0.0
    for k, time in enumerate(times):
        h = np.full(grid.shape, 0.375 + 0.125 * np.cos(4.0 * np.pi * time))
        begin = storage.euler_step(past, step, grid.cells)
        film = film_step.solve(flow_film(h, 1.0 / 6.0), still, edges, begin, full)
        past = ContentHistory(film.content, (film.content - past.content) / step, past.growth, step)
        full = film.full
        width[k] = _full_width(film)
        imbalance = max(imbalance, film.mass_imbalance)
        pressure = film.pressure.max()
    return OscillatingSqueeze(times, width, imbalance, pressure)


def _full_width(film: FilmSolution) -> float:
    """Return the width of the full film from y = 0.

    The front cell counts by its filling between the film fractions of its neighbours.
    """
    full = film.full[0]
    if full.all():
        return 0.5
    front = int(np.argmin(full))
    fraction = film.film_fraction[0]
    beyond = fraction[min(front + 1, full.size - 1)]
    share = (fraction[front] - beyond) / (1.0 - beyond) if beyond < 1.0 else 0.0
    return (front + min(max(share, 0.0), 1.0)) / full.size


def oscillating_squeeze_checks() -> Checks:
    """Check the oscillating squeeze film on 80 cells.

    The rows are rupture, width of the full film, complete reformation, mass balance and order in
    the step.
    """
    times, width, imbalance, _ = oscillating_squeeze(80, 2e-4)
    case = "Oscillating squeeze, 80 cells, step 2e-4"
    ruptured = np.flatnonzero(width < 0.5)
    reason = "one step of 2e-4 and the time a front takes to cross a cell"
    rows = [
        ("rupture time", times[ruptured[0]], 0.25008, 5e-4),
        ("time of complete reformation", times[ruptured[-1]] + 2e-4, 0.7324, 2e-3),
    ]
    yield from compared(case, rows, MOVING_FRONTS, reason, "absolute")
    known = (0.26, 0.0448), (0.30, 0.0236), (0.50, 0.0391), (0.66, 0.1002), (0.72, 0.2936)
    rows = [("minimum width of the full film", width.min(), 0.02301, 4e-3)] + [
        (f"width of the full film at t = {time}", np.interp(time, times, width), reference, 4e-3)
        for time, reference in known
    ]
    yield from compared(case, rows, MOVING_FRONTS, "a third of a cell", "absolute")
    yield conserved(case, "largest mass imbalance of a step [-]", imbalance)
    runs = [oscillating_squeeze(80, step, 0.74) for step in (1e-3, 5e-4, 2.5e-4)]
    at = np.arange(0.3, 0.7201, 1e-3)
    case = "Oscillating squeeze, 80 cells, steps 1e-3 to 2.5e-4"
    order = order_of_halving([np.interp(at, run.times, run.width) for run in runs])
    reason = "the front moves from cell to cell"
    yield from ordered(case, "width of the full film in the step", order, 0.2, reason)
    order = order_of_halving([run.pressure for run in runs])
    reason = "the leading error term dominates"
    yield from ordered(case, "pressure after reformation in the step", order, 0.1, reason)


def order_of_halving(values: Sequence[Any]) -> float:
    """Return the observed order from three runs, each with half the step of the one before.

    It uses root mean square differences of their values.
    """
    coarse, fine = (np.sqrt(np.mean((a - b) ** 2)) for a, b in pairwise(values))
    return np.log2(coarse / fine)


def motored_order(parameters: Parameters, name: str, uneven: float) -> float:
    """Return the observed order in the step of one field of the motored skirt over a revolution.

    The steps are 2, 1 and 0.5 degrees.

    Parameters
    ----------
    parameters : Parameters
    name : str
        Field among the outputs.
    uneven : float
        Steps are longer and shorter in turn by this share [-]; 1/3: each long one twice the short
        one before it.
    """
    values = []
    for step in (2.0, 1.0, 0.5):
        k = np.arange(1, round(360.0 / step) + 1)
        history = motored_until(parameters, (k + uneven * (k % 2)) * step * DEGREE).history
        every = round(4.0 / step)
        values.append(np.array([outputs[name] for outputs in history[every - 1 :: every]]))
    # without the first 8 degrees, where a first step of first order still shows
    return order_of_halving([v[2:] for v in values])


def step_order_checks() -> Checks:
    """Order in the time step of a film that is full, and of one that ruptures and reforms."""
    full = "forces of a full film", "nodal_pressure_force", "full_film", 0.05
    ruptured = "film fraction of a ruptured film", "film_fraction", "jfo", 0.2
    for uneven, steps in ((0.0, "equal steps"), (1.0 / 3.0, "alternating steps 2:1")):
        case = f"Motored skirt 12x10, {steps}, 2 to 0.5 degrees"
        for (what, field, model, tolerance), reason in (
            (full, "the leading error term dominates"),
            (ruptured, "fronts move from cell to cell"),
        ):
            order = motored_order(Parameters((12, 10), cavitation_model=model), field, uneven)
            yield from ordered(case, f"{what} in the step", order, tolerance, reason)


# ---- cavitation in sliding


def pocket_slider(cells: int, sliding: float = 1.0) -> tuple[float, ...]:
    """Solve the mass-conserving pocket slider, 20 mm long, with a pocket 2 to 5 mm from the inlet.

    Returns
    -------
    flow [m2/s], distance of the reformation from the inlet [m], highest pressure [Pa] and load per
    width above ambient [N/m].
    """
    length = 20e-3
    ambient = 100e3
    cavitation_pressure = 50e3
    grid = Grid((1, cells), 1.0, length)
    x = length * centres(cells)
    h = np.where((x > 2e-3) & (x < 5e-3), 10e-6, 1e-6)[None]
    if sliding < 0.0:
        h = np.ascontiguousarray(h[:, ::-1])
    film = steady(grid, h, sliding, 0.01, flooded_edges(grid.shape, ambient - cavitation_pressure))
    p = film.pressure[0] + cavitation_pressure
    fraction = film.film_fraction[0]
    full = film.full[0]
    if sliding < 0.0:
        p = p[::-1]
        fraction = fraction[::-1]
        full = full[::-1]
    front = np.flatnonzero(~full)[-1]  # the last cavitated cell, partly passed by the front
    share = (fraction[front] - fraction[front - 1]) / (1.0 - fraction[front - 1])
    # where the straight pressure behind the front meets zero
    reformation = (front + 1.5 - share) * length / cells
    load = (p - ambient).sum() * length / cells
    return abs(film.edge_flow[LOWER]), reformation, p.max(), load


def pocket_slider_checks() -> Checks:
    """Pocket slider in both directions of sliding."""
    names = "flow [m2/s]", "position of reformation [m]", "highest pressure [Pa]", "load [N/m]"
    exact = 5.0020833e-7, 4.212927e-3, 475e3, 2779.753
    reason = "first order, because the film ruptures one cell before the pocket"
    for sliding in (1.0, -1.0):
        rows = zip(names, pocket_slider(2000, sliding), exact, (2e-6, 1e-3, 3e-3, 5e-3))
        case = f"Pocket slider, 2000 cells, sliding {sliding:+g} m/s"
        yield from compared(case, rows, CLOSED_FORM, reason)


def parabolic_slider(cells: int, curvature: float) -> tuple[float, float, float]:
    """Return exit x*/L, highest pressure and load [-] of the slider h = 1 + c (2x - 1)^2.

    All is in units of 1, under the Reynolds condition.
    """
    grid = Grid((1, cells), 1.0, 1.0)
    h = 1.0 + curvature * (2.0 * centres(cells)[None] - 1.0) ** 2
    p = steady(grid, h, 1.0, 1.0, model="reynolds").pressure[0]
    last = np.flatnonzero(p > 0.0)[-1]
    # p ends as (x* - x)^2, so sqrt(p) is straight there
    a = np.sqrt(p[last - 2])
    b = np.sqrt(p[last - 1])
    return (last - 1 + 0.5 + b / (a - b)) / cells, p.max(), p.mean()


def parabolic_slider_exact(curvature: float) -> tuple[float, float, float]:
    """Return the values of `parabolic_slider` by quadrature.

    Eq. (V2):  dp/dx = 6 (h - h*) / h^3,   h* = h(x*),   x* from p(x*) = 0

    p is highest at 1 - x*, where h = h* too.
    """

    def h(x):
        return 1.0 + curvature * (2.0 * x - 1.0) ** 2

    def pressure(x, end):
        # Eq. (V2)
        value, _ = quad(lambda s: 6.0 * (h(s) - h(end)) / h(s) ** 3, 0.0, x, epsabs=1e-13)
        return value

    end: Any = brentq(lambda x: pressure(x, x), 0.501, 0.95, xtol=1e-13)
    load, _ = quad(pressure, 0.0, end, args=(end,), epsabs=1e-11)
    return end, pressure(1.0 - end, end), load


def parabolic_slider_checks() -> Checks:
    """Parabolic slider with Reynolds exit."""
    names = "exit x*/L", "highest pressure p*", "load W*"
    reason = "second order, and the exit within a fifth of a cell"
    for curvature in (0.5, 1.0, 2.0, 10.0):
        both = parabolic_slider(640, curvature), parabolic_slider_exact(curvature)
        case = f"Parabolic slider c={curvature:g}, Reynolds exit, 640 cells"
        rows = zip(names, *both, (5e-4, 2e-4, 1e-4))
        yield from compared(case, rows, "closed form by quadrature", reason)


def journal_bearing(
    shape: tuple[int, int], ratio: float, eccentricity: float
) -> tuple[float, float]:
    """Return the Sommerfeld number and the attitude angle [deg] of a journal bearing.

    p = 0 where the film is thickest, and the exit is Reynolds'.

    Eq. (V3):  h = C (1 + e cos phi),   So = F psi^2 / (B D mu w)

    with sliding along phi, R = C = mu = w = 1, B/D = `ratio`.
    """
    n_c, _ = shape
    grid = Grid(shape, 2.0 * np.pi, 2.0 * ratio, ring=False)
    angle = 2.0 * np.pi * centres(n_c)
    h = np.broadcast_to((1.0 + eccentricity * np.cos(angle))[:, None], shape).copy()
    p = steady(grid, h, 1.0, 1.0, model="reynolds", around=True).pressure
    mean = p.mean(axis=1)
    along = (mean * np.cos(angle)).sum() * 2.0 * np.pi / n_c
    across = (mean * np.sin(angle)).sum() * 2.0 * np.pi / n_c
    sommerfeld = np.hypot(along, across) / 2.0  # Eq. (V3)
    return sommerfeld, np.degrees(np.arctan2(across, -along))


def journal_bearing_checks() -> Checks:
    """Journal bearings of B/D = 1 and 1/4."""
    for ratio, eccentricity, load, attitude in (
        (1.0, 0.4, 0.6108, 62.57),
        (1.0, 0.6, 1.3146, 50.54),
        (1.0, 0.8, 3.5663, 36.24),
        (0.25, 0.4, 0.0560, None),
        (0.25, 0.6, 0.1476, None),
        (0.25, 0.8, 0.6043, None),
        (0.25, 0.9, 2.1595, None),
    ):
        shape = (240, 31) if eccentricity > 0.8 else (160, 31)
        size = "x".join(map(str, shape))
        case = f"Journal bearing B/D={ratio:g}, e={eccentricity:g}, Reynolds exit, {size}"
        sommerfeld, angle = journal_bearing(shape, ratio, eccentricity)
        rows = [("Sommerfeld number", sommerfeld, load, 3e-3)]
        yield from compared(case, rows, TABLE, SECOND_ORDER)
        if attitude:
            rows = [("attitude angle [deg]", angle, attitude, 0.1)]
            yield from compared(case, rows, TABLE, SECOND_ORDER, "absolute")


# ---- oil and roughness


def oil_checks() -> Checks:
    """Vogel law of one engine oil."""
    celsius = np.array([60.0, 100.0, 150.0])
    viscosity = oil.Oil("vogel_1921").low_shear_viscosity(celsius + oil.ZERO_CELSIUS)
    names = (f"viscosity at {t:g} C [Pa s]" for t in celsius)
    rows = zip(names, viscosity, (25.6e-3, 8.16e-3, 3.21e-3), [2e-3] * 3)
    case = "Engine oil, Vogel law"
    yield from compared(case, rows, "published constants", "three printed digits")
    engine = oil.Oil("vogel_1921", shear_thinning_law="cross_1965")
    rate = 10.0 ** (2.5 + 0.0213 * 100.0)
    halfway, _ = oil.thinning(engine.thinning, rate, oil.ZERO_CELSIUS + 100.0)
    rows = [("mu/mu_0 at the critical shear rate", halfway, 0.87, 1e-12)]
    case = "Engine oil, Cross law at 100 C"
    yield from compared(case, rows, "definition", "the mean of 1 and 0.74")


def roughness_checks() -> Checks:
    """Factors of Patir and Cheng."""
    case = "Patir-Cheng"
    known = (0.5, 0.9070), (1.0, 1.6366), (2.0, 1.7460), (3.0, 1.1666), (6.0, 1.0299)
    rows = [
        (f"phi_f({h:g})", h * roughness.mean_inverse_gap(h).value, reference, 1e-4)
        for h, reference in known
    ]
    yield from compared(case, rows, QUADRATURE, "four printed decimals", "absolute")
    rows = []
    for gamma, c, r in ((1 / 9, 1.48, 0.42), (1.0, 0.9, 0.56), (9.0, 0.87, 1.5)):
        reference = 1.0 - c * np.exp(-2.0 * r) if gamma <= 1.0 else 1.0 + c * 2.0**-r
        factor = roughness.pressure_flow_factor(2.0, gamma).value
        rows.append((f"phi_x(2), gamma = {gamma:.3g}", factor, reference, 1e-12))
    for h, reference in ((1.0, 1.899 * np.exp(-0.87)), (8.0, 1.126 * np.exp(-2.0))):
        factor = roughness.shear_flow_factor(h, 1.0).value
        rows.append((f"Phi_s({h:g}), gamma = 1", factor, reference, 1e-12))
    yield from compared(case, rows, "published table", "the same formula")
    table = roughness.factor_table(1.0, 1.0, 1.0)
    rough, _ = rough_film(np.array([[2.0]]), np.ones((1, 1)), FLOOR, 1.0, table)
    flow = roughness.pressure_flow_factor(2.0, 1.0).value
    shear = 2.0 * roughness.mean_inverse_gap(2.0).value
    shear += roughness.sliding_stress_factor(2.0, 1.0).value
    rows = [
        ("average gap", rough[STORED].item(), roughness.average_gap(2.0).value, 1e-9),
        ("conductivity", rough[CONDUCTIVITY_A].item(), flow * 8.0 / 12.0, 1e-9),
        ("shear", rough[COUETTE].item(), 0.5 * shear, 1e-9),
    ]
    yield from compared("Rough film at h = 2 sigma", rows, "definition", "an entry of the table")


# ---- contact


def contact_checks() -> Checks:
    """Exact integrals of Greenwood and Tripp, and the table built on them."""
    separations = np.arange(4.0)
    for order, references in (
        (2.5, (6.16634e-1, 8.05623e-2, 5.42371e-3, 1.70873e-4)),
        (2.0, (0.5, 7.53398e-2, 5.76873e-3, 2.03435e-4)),
    ):
        rows = [
            (f"F_{order:g}({h:g})", asperity.gaussian_integral(order, h), reference, 1e-5)
            for h, reference in zip(separations, references)
        ]
        case = "Greenwood-Tripp integral"
        yield from compared(case, rows, QUADRATURE, "six printed digits")
    fitted, _ = asperity.fitted_integral(separations)
    ratio = fitted / asperity.gaussian_integral(2.5, separations)
    names = (f"error at Lambda = {h:g} [%]" for h in separations)
    rows = zip(names, 100.0 * (ratio - 1.0), (-10.7, -3.5, -9.2, -74.0), [0.5] * 4)
    case = "Greenwood-Tripp power fit"
    yield from compared(case, rows, "exact integral", "two printed digits", "absolute")
    offset = separations + 1.0 / 3.0  # between the table's points
    constants = asperity.ContactConstants(1.0, 1.0, 1.0, 0.1, 0.0, 0.0, asperity.contact_table())
    pressure = np.array([asperity.point_contact(gap, constants).pressure for gap in offset])
    error = np.abs(pressure / asperity.gaussian_integral(2.5, offset) - 1.0).max()
    yield at_most(
        "Greenwood-Tripp table",
        "largest relative error of F_2.5 [-]",
        error,
        1e-7,
        source="exact integral",
        reason="Hermite interpolation, fourth order, Lambda < 4",
    )


# ---- a motored skirt


def motored_checks() -> Checks:
    """Mass balance over a cycle and exactness of the tangent."""
    _, _, history = motored(Parameters((40, 40), roughness_rms=5e-7), 720)
    case = "Motored skirt 40x40, 720 degrees"
    imbalance = max(o["mass_imbalance"] for o in history)
    yield conserved(case, "largest mass imbalance of a step [-]", imbalance)
    yield at_most(
        case,
        "mean factorisations per step [-]",
        np.mean([o["solver_iterations"] for o in history]),
        2.0,
        source="design target",
        reason="the extrapolated pattern is the initial guess",
    )
    for name, changes in physics((12, 10)).items():
        yield at_most(
            "Motored skirt 12x10, tangent compared with central differences",
            f"largest error, {name} [-]",
            motored_tangent_error(Parameters((12, 10), **changes)),
            1e-7,
            source="definition",
            reason="third derivative times the difference squared",
        )


def checks() -> Checks:
    """All that are fast, in order."""
    for case in (
        inclined_pad_checks,
        coarse_checks,
        finite_pad_checks,
        squeeze_plate_checks,
        oscillating_squeeze_checks,
        step_order_checks,
        pocket_slider_checks,
        parabolic_slider_checks,
        journal_bearing_checks,
        bearings.checks,
        oil_checks,
        roughness_checks,
        contact_checks,
        motored_checks,
    ):
        yield from case()


def random_starved_films(count: int, seed: int = 0) -> RandomFilms:
    """Run steps of rough, partly empty films with random entrainment in both directions."""
    rng = np.random.default_rng(seed)
    failures = 0
    iterations = 0
    imbalance = 0.0
    for _ in range(count):
        n_c, n_a = rng.integers(4, 25, 2)
        shape = (int(n_c), int(n_a))
        width, length = 10.0 ** rng.uniform(-3.0, -1.0, 2)
        grid = Grid(shape, width, length, ring=bool(rng.integers(2)))
        edges = Edges(
            np.append(10.0 ** rng.uniform(2.0, 6.0, 4) * rng.integers(0, 2, 4), 0.0),
            np.append(rng.uniform(0.0, 1.0, 4), 1.0),
            unlimited_supply(shape),
        )
        # neighbours differ up to a hundredfold
        film = 10.0 ** rng.uniform(-6.5, -4.5) * 10.0 ** rng.uniform(-1.0, 1.0, shape)
        across, along = (
            10.0 * rng.standard_normal((2, *shape)) * rng.integers(0, 2, 2)[:, None, None]
        )
        content = (
            film
            * np.minimum(1.0, rng.uniform(0.0, 1.5) * rng.random(shape))
            * rng.uniform(0.7, 1.4)
        )
        guess = rng.random(shape) > 0.5
        begin = EulerStep(content, 10.0 ** rng.uniform(-6.0, -2.0))
        try:
            solution = FilmStep(grid).solve(
                flow_film(film, 0.01), Entrainment(across, along), edges, begin, guess
            )
        except NotConverged:
            failures += 1
            continue
        fraction = solution.film_fraction
        failures += not (-1e-12 <= fraction.min() and fraction.max() <= 1.0 + 1e-12)
        iterations = max(iterations, solution.iterations)
        imbalance = max(imbalance, solution.mass_imbalance)
    return RandomFilms(failures, iterations, imbalance)


def slow_checks() -> Checks:
    """Yield the checks that take too long for a test run."""
    failures, iterations, imbalance = random_starved_films(2000)
    case = "2000 random rough starved films"
    for what, value, bound, source, reason in (
        ("failures", failures, 0.0, "design target", "no step may fail"),
        (
            "most factorisations in a step",
            iterations,
            100.0,
            "termination",
            "the start is random, and a few patterns converge by single changes only",
        ),
    ):
        yield at_most(case, f"{what} [-]", value, bound, source, reason)
    yield conserved(case, "largest mass imbalance [-]", imbalance)
