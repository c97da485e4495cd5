"""Verification of a film that slides around.

It compares journal bearings with closed forms, published tables and independent solutions.

The journal's displacement (x, y) from the axis of the shell gives the film thickness by Eq. (E14),
and pressure its force by Eq. (E15); U = R omega is the velocity of its surface.

Long bearing (Sommerfeld), full film, and short one (Ocvirk), pressure where it is positive; e
eccentricity over C, phi attitude angle, M moment about the axis of the journal:

Eq. (V5):  F/L = 12 pi mu U (R/C)^2 e / ((2 + e^2) s),   M/L = 4 pi mu U R^2/C (1 + 2 e^2) / ((2 +
           e^2) s),   s^2 = 1 - e^2
Eq. (V6):  F = mu U L^3/(4 C^2) e/s^4 (16 e^2 + pi^2 s^2)^(1/2),   tan phi = pi s / (4 e)
Eq. (V7):  M = 2 pi mu U R L (R/C) / s + F C e sin(phi) / 2

Short bearing whose journal moves, pressure p averaged over its length; the mobility method
[Booker1965] asks which velocity carries a load:

Eq. (V8):  p = max(-mu L^2 (dh/dt + omega/2 dh/dtheta) / h^3, 0)

References
----------
[Raimondi1958] A. A. Raimondi, J. Boyd, A solution for the finite journal bearing and its
application to analysis and design III, ASLE Trans. 1 (1958) 194-209.
[Ocvirk1952] F. W. Ocvirk, Short-bearing approximation for full journal bearings, NACA TN 2808
(1952).
[Booker1965] J. F. Booker, Dynamically loaded journal bearings: mobility method of solution, J.
Basic Eng. 87 (1965) 537-546.
[Butenschoen1976] H.-J. Butenschoen, Das hydrodynamische, zylindrische Gleitlager endlicher Breite
unter instationaerer Belastung, Diss. Karlsruhe 1976; its coefficients as MBDyn's hydrodynamic plain
bearing holds them.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyval
from scipy.integrate import solve_ivp
from scipy.optimize import root
from scipy.sparse import lil_matrix
from scipy.sparse.linalg import spsolve

from piston_cosim.fmu_ehd import journal as journals
from piston_cosim.fmu_ehd.common.faults import NotConverged
from piston_cosim.fmu_ehd.common.grid import Array, Flags
from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.fmu_ehd.step_parts import begin

from .checks import Check, at_most, compared, conserved
from .motored import film_after

Checks = Iterator[Check]
SPARSE = "independent sparse solution"
OTHER_MEAN = "second order in the cell size: faces use another mean of the film"

RADIUS = 0.05  # of the shell [m]
CLEARANCE = 5e-5  # C [m]
SPEED = 10.0  # U [m/s]
VISCOSITY = 0.02  # [Pa s]
QUADRATURE = 720  # points around of a short film
NEWTON = 25  # iterations of a step of a moving journal
STEADY = 1e9  # length of a step after which a film is steady [s]

# [Raimondi1958], full bearing: (L/D, e) -> Sommerfeld number S, attitude angle [deg], friction
# (R/C) f, flow Q/(R C N L) and the share of it that leaks at the sides
TABLE = {
    (1.0, 0.4): (0.264, 63.10, 5.79, 3.99, 0.497),
    (1.0, 0.6): (0.121, 50.58, 3.22, 4.33, 0.680),
    (1.0, 0.8): (0.0446, 36.24, 1.70, 4.62, 0.842),
    (0.5, 0.4): (0.779, 61.45, 17.0, 4.29, 0.552),
    (0.5, 0.6): (0.319, 48.14, 8.10, 4.85, 0.730),
    (0.5, 0.8): (0.0923, 33.31, 3.26, 5.41, 0.874),
    (0.25, 0.4): (2.83, 60.86, 61.1, 4.37, 0.567),
    (0.25, 0.6): (1.07, 46.72, 26.7, 4.99, 0.746),
    (0.25, 0.8): (0.261, 31.04, 8.80, 5.60, 0.884),
}


class Steady(NamedTuple):
    """load: F [N]; attitude: phi [deg]; moment: M, of friction [N m]; outputs: of the film."""

    load: float
    attitude: float
    moment: float
    outputs: dict[str, Any]


def angles(shape: tuple[int, int]) -> Array:
    """Theta of the cells around [rad], the first at 0."""
    theta: Array = np.arange(0.0, shape[0]) * (2.0 * np.pi / shape[0])
    return theta


def bearing(shape: tuple[int, int], length: float, **changes: Any) -> LubricationModel:
    """Model of a bearing of a length [m]."""
    given: dict[str, Any] = (
        dict(bore_radius=RADIUS, skirt_length=length, oil=Oil(viscosity=VISCOSITY)) | changes
    )
    return LubricationModel(Parameters(shape, surface="bearing", minimum_flow_film=1e-9, **given))


def steady(model: LubricationModel, film_thickness: Array, speed: float = SPEED) -> dict[str, Any]:
    """Return the outputs of a steady film under a rotating journal."""
    films = [film_thickness] * 2
    return film_after(model.parameters, films, step=STEADY, turning=speed).outputs


def eccentric(shape: tuple[int, int], eccentricity: float) -> Array:
    """Film thickness of a parallel journal, thickest at theta = 0 [m]."""
    return journals.gap(CLEARANCE, np.array([-eccentricity * CLEARANCE, 0.0]), shape)


def journal(ratio: float, eccentricity: float, shape: tuple[int, int], **changes: Any) -> Steady:
    """Steady bearing of L/D = `ratio`."""
    model = bearing(shape, 2.0 * RADIUS * ratio, **changes)
    outputs = steady(model, eccentric(shape, eccentricity))
    x, y = journals.film_force(outputs["nodal_pressure_force"])
    # the journal lies at theta = pi, the load is the opposite of the film's force
    attitude = np.degrees(np.arctan2(-y, x))
    moment = outputs["friction_power"] * RADIUS / SPEED
    return Steady(float(np.hypot(x, y)), float(attitude), moment, outputs)


def grooved(shape: tuple[int, int]) -> Flags:
    """Return an axial groove, one cell wide, where the film is thickest."""
    cells = np.zeros(shape, dtype=bool)
    cells[0] = True
    return cells


# ---- steady bearings


def table_checks() -> Checks:
    """Finite bearings that conserve oil, fed by an axial groove at the thickest film."""
    shape = (120, 24)
    for (ratio, eccentricity), (number, angle, friction, flow, side) in TABLE.items():
        found = journal(
            ratio,
            eccentricity,
            shape,
            open_cells=grooved(shape),
            cavity_shear="full_film",
        )
        length = 2.0 * RADIUS * ratio
        turns = SPEED / (2.0 * np.pi * RADIUS)
        scale = RADIUS / CLEARANCE
        leak = -found.outputs["flow_lower_edge"] - found.outputs["flow_upper_edge"]
        sommerfeld = VISCOSITY * turns * 2.0 * RADIUS * length / found.load * scale**2
        side_flow = leak / (RADIUS * CLEARANCE * turns * length)
        rows = (
            ("Sommerfeld number S", sommerfeld, number, 0.016),
            ("attitude angle [deg]", found.attitude, angle, 0.016),
            ("friction (R/C) f", found.moment / RADIUS / found.load * scale, friction, 0.016),
            ("side flow Q/(R C N L)", side_flow, flow * side, 0.016),
        )
        case = f"Journal bearing L/D={ratio:g}, e={eccentricity:g}, groove, jfo, 120x24"
        source = "published table (Raimondi and Boyd 1958)"
        reason = "three digits on a coarse grid of 1958, recomputed by others within 1.5 %"
        yield from compared(case, rows, source, reason)
        yield conserved(case, "mass imbalance [-]", found.outputs["mass_imbalance"], 1e-13)


def butenschoen_rotation(ratio: float, e: float) -> tuple[float, float]:
    """Return Sommerfeld number and attitude angle [deg] of a steady bearing.

    The Sommerfeld number is F psi^2/(mu omega B D), with psi = C/R.

    Eq. (V11):  So_D = (B/D)^2 e/(2 s^4) (pi^2 s^2 + 16 e^2)^(1/2) a1 (1 - e)/(-a2 - e),   phi =
                arctan(pi s/(2 e)) sum of b_k e^k,   s^2 = 1 - e^2
    """
    square = 1.0 - e**2
    a1 = polyval(ratio, [1.1642, -1.9456, 7.1161, -10.1073, 5.0141])
    a2 = polyval(ratio, [-1.000026, -0.023634, -0.4215, -0.038817, -0.090551])
    b = [
        polyval(ratio, [1.152624, -0.104565]),
        polyval(ratio, [-2.5905, 0.798745]),
        polyval(ratio, [8.73393, -2.3291]),
        polyval(ratio, [-13.3414, 3.424337]),
        polyval(ratio, [6.6294, -1.591732]),
    ]
    # Eq. (V11)
    short = 0.5 * ratio**2 * e / square**2 * np.sqrt(np.pi**2 * square + 16.0 * e**2)
    angle = np.arctan(np.pi * np.sqrt(square) / (2.0 * e)) * polyval(e, b)
    return float(short * a1 * (1.0 - e) / (-a2 - e)), float(np.degrees(angle))


def butenschoen_squeeze(ratio: float, e: float) -> float:
    """Sommerfeld number F psi^2/(mu de/dt B D) of a journal that nears its shell and does not turn.

    Eq. (V12):  So_V = 4 (B/D)^2 s^-5 ((pi/2 - arccos(e)/2)(1 + 2 e^2) + 3/2 e s) a3 (1 - e)/(-a4 -
                e)
    """
    square = 1.0 - e**2
    a3 = polyval(ratio, [0.70038, 3.2415, -12.2486, 18.895, -9.3561])
    a4 = polyval(ratio, [-0.999935, 0.0157434, -0.74224, 0.42278, -0.368928])
    # Eq. (V12)
    around = 0.5 * (np.pi - np.arccos(e)) * (1.0 + 2.0 * e**2) + 1.5 * e * np.sqrt(square)
    return float(4.0 * ratio**2 * around / square**2.5 * a3 * (1.0 - e) / (-a4 - e))


def squeezed(ratio: float, e: float, rate: float) -> float:
    """F on a journal that nears its shell with de/dt = `rate` [1/s], alone [N]."""
    shape = (120, 24)
    step = 1e-5
    parameters = bearing(shape, 2.0 * RADIUS * ratio).parameters
    past = e - 6.0 * step * rate
    films = [eccentric(shape, past + k * step * rate) for k in range(7)]
    outputs = film_after(parameters, films, step=step).outputs
    return float(np.hypot(*journals.film_force(outputs["nodal_pressure_force"])))


def butenschoen_checks() -> Checks:
    """Rotation and squeeze of finite bearings against the formulae that dynamics programs use."""
    shape = (120, 24)
    turning = SPEED / RADIUS
    rate = 1.0
    source = "fitted formulae (Butenschoen 1976)"
    for ratio in (0.25, 0.5, 1.0):
        length = 2.0 * RADIUS * ratio
        unit = VISCOSITY * length * 2.0 * RADIUS * (RADIUS / CLEARANCE) ** 2
        for e in (0.4, 0.6, 0.8):
            case = f"Journal bearing B/D={ratio:g}, e={e:g}, jfo, 120x24"
            found = journal(ratio, e, shape, open_cells=grooved(shape), cavity_shear="full_film")
            number, angle = butenschoen_rotation(ratio, e)
            nearing = squeezed(ratio, e, rate) / unit / rate
            rows = (
                ("So_D of rotation", found.load / unit / turning, number, 0.04),
                ("So_V of squeeze", nearing, butenschoen_squeeze(ratio, e), 0.04),
            )
            reason = "the fit differs by up to 3.9 % from the table of 1958"
            yield from compared(case, rows, source, reason)
            row = "attitude angle [deg]", found.attitude, angle, 2.5
            reason = "the fit differs by up to 2.2 deg from the table of 1958"
            yield from compared(case, [row], source, reason, "absolute")


def long_bearing_checks() -> Checks:
    """Infinitely long bearing with a full film."""
    e = 0.6
    shape = (240, 4)
    # a shell of 1 mm radius and 2 m length leaks at its ends nothing that counts
    radius, length = 1e-3, 2.0
    model = bearing(shape, length, bore_radius=radius, cavitation_model="full_film")
    outputs = steady(model, eccentric(shape, e))
    inner = outputs["nodal_pressure_force"] * [0.0, 2.0, 2.0, 0.0]  # ends left out
    x, y = journals.film_force(inner) / length
    s = np.sqrt(1.0 - e**2)
    stress = VISCOSITY * SPEED * (radius / CLEARANCE) ** 2
    load = 12.0 * np.pi * stress * e / ((2.0 + e**2) * s)  # Eq. (V5)
    moment = 4.0 * np.pi * stress * CLEARANCE * (1.0 + 2.0 * e**2) / ((2.0 + e**2) * s)
    friction = outputs["friction_power"] * radius / SPEED / length
    rows = (
        ("load F/L [N/m]", np.hypot(x, y), load, 2e-3),
        ("friction moment M/L [N]", friction, moment, 2e-3),
    )
    case, source = (
        "Long journal bearing, e=0.6, full film, 240 cells",
        "closed form (Sommerfeld 1904)",
    )
    reason = "second order in the cell size, and 1e-3 of the length at its ends"
    yield from compared(case, rows, source, reason)
    row = "attitude angle [deg]", np.degrees(np.arctan2(-y, x)), 90.0, 1e-6
    yield from compared(case, [row], source, "symmetry", "absolute")


def short_load(length: float, e: float) -> float:
    """F of Eq. (V6) [N]."""
    square = 1.0 - e**2
    scale = VISCOSITY * SPEED * length**3 / (4.0 * CLEARANCE**2)
    return scale * e / square**2 * np.sqrt(16.0 * e**2 + np.pi**2 * square)  # Eq. (V6)


def short_bearing_checks() -> Checks:
    """Short bearing, pressure below zero cut off."""
    ratio = 0.02
    length = 2.0 * RADIUS * ratio
    for e in (0.3, 0.6, 0.8):
        s = np.sqrt(1.0 - e**2)
        found = journal(ratio, e, (180, 24), cavitation_model="gumbel", cavity_shear="full_film")
        load = short_load(length, e)
        angle = np.arctan2(np.pi * s, 4.0 * e)  # Eq. (V6)
        # Eq. (V7)
        couette = 2.0 * np.pi * VISCOSITY * SPEED * RADIUS * length * RADIUS / CLEARANCE / s
        moment = couette + 0.5 * load * CLEARANCE * e * np.sin(angle)
        rows = (
            ("load F [N]", found.load, load, 5e-3),
            ("attitude angle [deg]", found.attitude, np.degrees(angle), 5e-3),
            ("friction moment M [N m]", found.moment, moment, 5e-3),
        )
        case = f"Short journal bearing L/D=1/50, e={e:g}, half Sommerfeld, 180x24"
        reason = "length over diameter squared, 4e-4, and second order in the cell size"
        yield from compared(case, rows, "closed form (Ocvirk 1952)", reason)


def balance_checks() -> Checks:
    """Power of the journal and its moment about its own axis, and forces on both surfaces."""
    shape = (90, 12)
    e = 0.7
    found = journal(0.5, e, shape)
    _, y = journals.film_force(found.outputs["nodal_pressure_force"])
    step = 2.0 * np.pi / shape[0]
    lever = CLEARANCE * e * np.sin(step) / step  # the cosine by differences over two cells
    name = "friction power over speed, compared with the moment about the journal [N m]"
    row = name, found.moment, -found.outputs["friction_torque"] - lever * y, 1e-9
    case = "Journal bearing L/D=0.5, e=0.7, jfo, 90x12"
    yield from compared(case, [row], "moment balance", "round-off of a summation by parts")


# ---- grooves and holes


def circumferential_groove_checks() -> Checks:
    """Bearing at rest, fed in the middle by a groove all around.

    Eq. (V9):  Q = pi R C^3 p_s (1 + 3/2 e^2) / (3 mu l),   l length of each land
    """
    shape = (120, 21)
    length = 0.042
    supply = 3e5
    cells = np.zeros(shape, dtype=bool)
    cells[:, 10] = True
    e = 0.5
    model = bearing(shape, length, open_cells=cells, opening_supply="own", pressure_openings=supply)
    outputs = steady(model, eccentric(shape, e), 0.0)
    # Eq. (V9)
    flow = np.pi * RADIUS * CLEARANCE**3 * supply * (1.0 + 1.5 * e**2) / (3.0 * VISCOSITY * 0.02)
    row = "flow [m3/s]", outputs["flow_openings"], flow, 1e-9
    case = "Circumferential groove, e=0.5, at rest, 120x21"
    reason = "the pressure is linear along each land, so the grid is exact"
    yield from compared(case, [row], "closed form", reason)


def plain_reynolds(
    film_thickness: Array, turning: float, length: float, fed: Flags, supply: float
) -> Array:
    """Return the pressure of a full film by an independent solution.

    Finite differences between cell centres of div(h^3 grad p)/(12 mu) = U/2 dh/dx are solved by
    scipy's sparse solver. `fed` cells have the pressure `supply` [Pa].
    """
    n_c, n_a = film_thickness.shape
    dx = 2.0 * np.pi * RADIUS / n_c
    dy = length / n_a
    matrix = lil_matrix((n_c * n_a, n_c * n_a))
    right = np.zeros(n_c * n_a)
    for i in range(n_c):
        for j in range(n_a):
            row = i * n_a + j
            if fed[i, j]:
                matrix[row, row] = 1.0
                right[row] = supply
                continue
            for k, m, across, along in (
                ((i - 1) % n_c, j, dx, dy),
                ((i + 1) % n_c, j, dx, dy),
                (i, j - 1, dy, dx),
                (i, j + 1, dy, dx),
            ):
                inside = 0 <= m < n_a
                other = film_thickness[k, m] if inside else film_thickness[i, j]
                mean = (0.5 * (film_thickness[i, j] + other)) ** 3 / (12.0 * VISCOSITY)
                # a fed neighbour begins at the face
                distance = across if inside and not fed[k, m] else 0.5 * across
                weight = mean * along / distance
                matrix[row, row] += weight
                if inside:
                    matrix[row, k * n_a + m] -= weight
            slope = film_thickness[(i + 1) % n_c, j] - film_thickness[(i - 1) % n_c, j]
            right[row] = -0.5 * turning * 0.5 * slope * dy
    return np.asarray(spsolve(matrix.tocsr(), right)).reshape(n_c, n_a)


def fed_checks() -> Checks:
    """Check a hole and an axial groove shorter than the bearing, in a full film that rotates."""
    length = 0.05
    supply = 2e5
    shape = (180, 60)
    film = eccentric(shape, 0.4)
    for name, rows, columns in (
        ("hole", slice(6, 12), slice(24, 36)),
        ("axial groove", slice(4, 6), slice(10, 50)),
    ):
        cells = np.zeros(shape, dtype=bool)
        cells[rows, columns] = True
        model = bearing(
            shape,
            length,
            open_cells=cells,
            opening_supply="own",
            pressure_openings=supply,
            cavitation_model="full_film",
        )
        outputs = steady(model, film)
        pressure = plain_reynolds(film, SPEED, length, cells, supply)
        area = np.where(cells, 0.0, model.area.max())
        load = np.hypot(*journals.film_force(pressure * area))
        leak = (film[:, [0, -1]] ** 3 * pressure[:, [0, -1]]).sum() * model.fixed.domain.cells.dx
        leak /= 12.0 * VISCOSITY * 0.5 * model.fixed.domain.cells.dy
        force = journals.film_force(outputs["nodal_pressure_force"])
        figures = (
            ("load [N]", np.hypot(*force), load, 1e-3),
            ("flow [m3/s]", outputs["flow_openings"], leak, 4e-3),
        )
        case = f"Bearing L/D=0.5, e=0.4, full film, {name} with supply, 180x60"
        yield from compared(case, figures, SPARSE, OTHER_MEAN)


def misalignment_checks() -> Checks:
    """Check the moments of the pressure on a journal tilted in its shell."""
    shape = (90, 30)
    length = 0.05
    y = (np.arange(shape[1]) + 0.5) / shape[1] - 0.5
    theta = angles(shape)[:, None]
    film = CLEARANCE * (1.0 + 0.4 * np.cos(theta) + 0.5 * y * np.cos(theta - 0.8))
    model = bearing(shape, length, cavitation_model="full_film")
    force = steady(model, film)["nodal_pressure_force"]
    pressure = plain_reynolds(film, SPEED, length, np.zeros(shape, dtype=bool), 0.0)
    rows = []
    for name, direction in (("cosine", np.cos(theta)), ("sine", np.sin(theta))):
        ours, exact = (
            float((one * y * length * direction).sum())
            for one in (force, pressure * model.area.max())
        )
        rows.append((f"moment, {name} part [N m]", ours, exact, 2e-3))
    case = "Bearing L/D=0.5, e=0.4, tilted by half its clearance, full film, 90x30"
    yield from compared(case, rows, SPARSE, OTHER_MEAN)


# ---- journals that move


class Motion(NamedTuple):
    """Positions of a journal, ndarray of shape (n, 2) [m], at times [s].

    imbalance: largest of a step [-].
    """

    times: Array
    positions: Array
    imbalance: float


class Rotor:
    """Rigid journal in a bearing, alone with its film.

    The motion m x'' = F + W is integrated by the trapezoidal rule. Without mass, F + W = 0 at the
    end of each step. Newton's method uses the exact tangent.

    Parameters
    ----------
    model : LubricationModel
    load : callable
        W(t), ndarray of shape (2,) [N].
    mass : float
        [kg].
    """

    def __init__(self, model: LubricationModel, load: Callable[[float], Array], mass: float = 0.0):
        self.model = model
        self.load = load
        self.mass = mass
        self.still = np.zeros(model.parameters.shape)
        self.turning = np.full(model.parameters.shape, SPEED)

    def film(self, position: Array) -> Array:
        """Film thickness [m]."""
        return journals.gap(CLEARANCE, position, self.still.shape)

    def move(self, position: Array, step: float, steps: int) -> Motion:
        """Motion from a position [m] on, at rest and with a mass in equilibrium."""
        state, _ = self.model.start(self.film(position), self.still, self.turning)
        positions = [position]
        velocity = np.zeros(2)
        total = np.zeros(2)
        imbalance = 0.0
        for k in range(1, steps + 1):
            before = positions[-1]
            last = velocity
            position = before + step * last
            for _ in range(NEWTON):
                after, outputs = self.model.advance(
                    state, self.film(position), self.still, step, self.turning
                )
                load = self.load(k * step)
                sum_of_forces = journals.film_force(outputs["nodal_pressure_force"]) + load
                velocity = (position - before) / step
                missing = sum_of_forces
                stiffness = self.stiffness()
                if self.mass > 0.0:
                    velocity = 2.0 * velocity - last
                    missing = 0.5 * (total + sum_of_forces) - self.mass * (velocity - last) / step
                    stiffness = 0.5 * stiffness + 2.0 * self.mass / step**2 * np.eye(2)
                if np.abs(missing).max() < 1e-10 * np.abs(load).max():
                    break
                change = np.linalg.solve(stiffness, missing)
                room = 0.3 * (CLEARANCE - np.hypot(*position))
                position = position + change * min(1.0, room / np.hypot(*change))
            else:
                raise NotConverged(f"journal at {k * step:g} s: forces {missing} N remain")
            state = after
            total = sum_of_forces
            imbalance = max(imbalance, outputs["mass_imbalance"])
            positions.append(position)
        times: Array = np.arange(0.0, steps + 1.0) * step
        return Motion(times, np.array(positions), imbalance)

    def stiffness(self) -> Array:
        """-dF/dx of the step just taken, shape (2, 2) [N/m]."""

        def by_pressure(thinner):
            normal, *_ = self.model.tangent(thinner)
            return normal, None, 0.0 * normal

        return journals.stiffness(by_pressure, self.still.shape)


def short_film_force(position: Array, velocity: Array, length: float, turns: float) -> Array:
    """F of a short film on a journal, pressure cut off below zero, Eqs. (E14), (E15), (V8) [N].

    Parameters
    ----------
    position, velocity : ndarray, shape (2,)
        [m], [m/s].
    length : float
        L [m].
    turns : float
        omega [rad/s].
    """
    theta = 2.0 * np.pi / QUADRATURE * np.arange(QUADRATURE)
    cos = np.cos(theta)
    sin = np.sin(theta)
    x, y = position
    h = CLEARANCE - x * cos - y * sin
    vx, vy = velocity
    growth = -vx * cos - vy * sin + 0.5 * turns * (x * sin - y * cos)
    pressure = np.maximum(-VISCOSITY * length**2 * growth / h**3, 0.0)  # Eq. (V8)
    area = 2.0 * np.pi / QUADRATURE * RADIUS * length
    return -area * np.array([pressure @ cos, pressure @ sin])


def mobility_orbit(
    length: float, load: Callable[[float], Array], times: Array, start: Array
) -> Array:
    """Return the positions of a massless journal in a short bearing, shape (n, 2) [m].

    At each instant the journal has the velocity with which the film, Eq. (V8), carries the load.
    """
    omega = SPEED / RADIUS
    guess = np.zeros(2)

    def velocity(time, place):
        nonlocal guess
        force = load(time)

        def missing(speed):
            film = short_film_force(CLEARANCE * place, CLEARANCE * speed, length, omega)
            return (film + force) / np.abs(force).max()

        guess = root(missing, guess, tol=1e-12).x
        return guess

    found = solve_ivp(
        velocity, (0.0, times[-1]), start / CLEARANCE, t_eval=times, rtol=1e-6, atol=1e-8
    )
    return CLEARANCE * found.y.T


def orbit_checks() -> Checks:
    """Check the orbit of a massless journal in a short bearing against the mobility method.

    One load rotates and one swings.
    """
    ratio = 0.04
    length = 2.0 * RADIUS * ratio
    omega = SPEED / RADIUS
    size = short_load(length, 0.4)

    def rotating(time):
        return size * np.array([np.cos(0.7 * omega * time), np.sin(0.7 * omega * time)])

    def swinging(time):
        return size * np.array([1.0, 0.6 * np.sin(omega * time)])

    start = np.array([0.2, 0.1]) * CLEARANCE
    for name, load in (("rotating", rotating), ("swinging", swinging)):
        steps = 120
        step = 2.0 * 2.0 * np.pi / omega / steps
        model = bearing((90, 16), length, cavitation_model="gumbel")
        motion = Rotor(model, load).move(start, step, steps)
        exact = mobility_orbit(length, load, motion.times, start)
        distance = np.linalg.norm(motion.positions - exact, axis=1)
        farthest = (np.linalg.norm(one, axis=1).max() for one in (motion.positions, exact))
        case = (
            f"Short journal bearing L/D=1/25, {name} load, two revolutions, half Sommerfeld, 90x16"
        )
        source = "mobility method on Ocvirk's film (Booker 1965)"
        reason = "second order in the cell size, length over diameter squared"
        yield from compared(case, [("largest eccentricity [m]", *farthest, 8e-3)], source, reason)
        quantity = "distance of the orbits, rms over the clearance [-]"
        rms = np.sqrt(np.mean(distance**2)) / CLEARANCE
        yield at_most(case, quantity, rms, 6e-3, source, reason)


def critical_mass(stiffness: Array, damping: Array) -> float:
    """Mass of a rigid rotor above which it whirls of itself, K and D of shape (2, 2) [kg].

    Eq. (V10):  det(K - m nu^2 + i nu D) = 0 for a real nu
    """
    cross = np.array([[0.0, 1.0], [-1.0, 0.0]])

    def mixed(a, b):
        """det of a matrix is bilinear in its columns: the mixed part."""
        return float(np.sum(a * (cross @ b @ cross.T)))

    # Eq. (V10): imaginary part gives k = m nu^2, real part nu^2
    k = mixed(stiffness, damping) / np.trace(damping)
    rest = stiffness - k * np.eye(2)
    return k * np.linalg.det(damping) / np.linalg.det(rest)


def film_coefficients(length: float, e: float, model: str) -> tuple[Array, Array]:
    """Return K and D of a bearing about its steady position, shape (2, 2) [N/m], [N s/m].

    They follow from the tangents of a steady and of a short step.
    """
    shape = (360, 24)
    film = bearing(shape, length, cavitation_model=model)
    rotor = Rotor(film, lambda time: np.zeros(2))
    thickness = rotor.film(np.array([-e * CLEARANCE, 0.0]))
    state, _ = film.start(thickness, rotor.still, rotor.turning)
    state, _ = film.advance(state, thickness, rotor.still, STEADY, rotor.turning)
    stiffness = rotor.stiffness()
    short = 1e-6
    length_of_step = begin(state.film, short, film.fixed.domain.cells).start.length
    film.advance(state, thickness, rotor.still, short, rotor.turning)
    # the balance holds dh over the length of the step: K + D / H_e
    return stiffness, (rotor.stiffness() - stiffness) * length_of_step


def whirl_checks() -> Checks:
    """Onset of whirl of a rigid rotor in a short bearing."""
    ratio = 0.02
    length = 2.0 * RADIUS * ratio
    omega = SPEED / RADIUS
    for e in (0.3, 0.5):
        place = np.array([-e * CLEARANCE, 0.0])
        small = 1e-6 * CLEARANCE
        stiffness = np.empty((2, 2))
        damping = np.empty((2, 2))
        for k, to in enumerate(np.eye(2)):
            ends = [
                (
                    short_film_force(place + by * to, np.zeros(2), length, omega),
                    short_film_force(place, by * omega * to, length, omega),
                )
                for by in (-small, small)
            ]
            by_place, by_velocity = np.subtract(*ends)
            stiffness[:, k] = by_place / (2.0 * small)
            damping[:, k] = by_velocity / (2.0 * small * omega)
        found = critical_mass(*film_coefficients(length, e, "gumbel"))
        load = short_load(length, e)
        masses = found, critical_mass(stiffness, damping)
        both = (omega * np.sqrt(mass * CLEARANCE / load) for mass in masses)
        row = "onset of whirl, omega sqrt(m C / W)", *both, 1e-2
        case = f"Short journal bearing L/D=1/50, e={e:g}, half Sommerfeld, 360x24"
        reason = "first order, because the pressure is cut off inside a cell"
        yield from compared(case, [row], "short bearing by quadrature", reason)


def checks() -> Checks:
    """All of a bearing, in order."""
    for case in (
        table_checks,
        butenschoen_checks,
        long_bearing_checks,
        short_bearing_checks,
        balance_checks,
        circumferential_groove_checks,
        fed_checks,
        misalignment_checks,
        orbit_checks,
        whirl_checks,
    ):
        yield from case()
