"""Verification of the bodies against closed forms and independent codes.

The command line and the tests use these figures.
"""

import itertools
from importlib.util import find_spec
from typing import Any

import numpy as np
import scipy.linalg as la

from piston_cosim.fmu_mfbd.finite_elements.deck import tetrahedra, with_middles
from piston_cosim.fmu_mfbd.finite_elements.element import (
    consistent_mass,
    quadrature,
    rigid_motions,
    stiffness,
)
from piston_cosim.fmu_mfbd.finite_elements.faces import face_load
from piston_cosim.fmu_mfbd.finite_elements.mesh import read_mesh
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED
from piston_cosim.fmu_mfbd.mechanism.chain import BLOCK
from piston_cosim.fmu_mfbd.mechanism.floating_frame import (
    FlexibleBody,
    Y,
)
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import (
    Coefficients,
    Motion,
    Prediction,
    coefficients,
    predict,
)
from piston_cosim.fmu_mfbd.mechanism.loads import no_forces
from piston_cosim.fmu_mfbd.mechanism.piston_motion import LATERAL, Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import (
    CrankMotion,
    Mechanism,
    height,
)
from piston_cosim.fmu_mfbd.mechanism.solution import solve_motion
from piston_cosim.fmu_mfbd.reduction.bases import (
    Elastic,
    characteristic_constraint_modes,
    craig_bampton,
    expected_pressure,
    orthonormal_modes,
    pressure_modes,
    static_answers,
)
from piston_cosim.fmu_mfbd.reduction.frame_integrals import Z, floating_frame_integrals
from piston_cosim.fmu_mfbd.reduction.interpolation import (
    SurfaceReading,
    interpolation,
    radial_and_axial,
)
from piston_cosim.fmu_mfbd.reduction.smooth_prior import (
    ALONG,
    pressure_root,
    smooth_pressure_modes,
    surface_answers,
)
from piston_cosim.models import MODELS

from .checks import at_most, bounded, compared
from .exudyn import CrankedPiston, Drive, FullPiston, exudyn_motion, own_motion
from .links import Link, chain_of, increments_of
from .tied import PISTON, tied_forces, tied_pin

CLOSED_FORM, OTHER_CODE = "closed form", "independent code"
STEEL = dict(young=210e9, poisson=0.3)


def rigid_body(mass: float, centre: tuple[float, float], inertia: float) -> FlexibleBody:
    """Return a rigid body: mass [kg], centre of mass (x, y) from A [m], inertia about A [kg m2]."""
    none = np.zeros(0)
    square = np.zeros((0, 0))
    return FlexibleBody(
        mass=float(mass),
        S=mass * np.asarray(centre, dtype=float),
        I0=float(inertia),
        T=np.zeros((2, 0)),
        b=none,
        B=square,
        g=none,
        G=square,
        stiffness=none,
        damping=none,
    )


def checks():
    """Quick figures."""
    yield from slider_crank_checks()
    yield from element_checks()
    yield from bar_checks()
    yield from pendulum_checks()
    yield from order_check()


def slow_checks():
    """Figures on the meshes of the shipped case (minutes)."""
    yield from deflection_checks()
    yield from exudyn_checks()


def slider_crank_checks():
    """Rigid slider-crank at 3000 rpm, no gas, piston guided on the bore axis."""
    names = (
        "height of the pin point [m]",
        "acceleration of the pin point [m/s2]",
        "side force [N]",
        "pin force along y [N]",
        "crank torque [N m]",
    )
    references = {
        30: (0.13399491, -2846.7789, -181.47237, -896.73536, 21.352215),
        60: (None, None, -150.83006),
        90: (None, None, 25.33294),
    }
    reason = "printed with seven to eight digits: tests/mfbd checks the equations to 1e-9"
    for degrees, row in references.items():
        rows = [
            (name, computed, reference, 2.5e-7)
            for name, reference, computed in zip(names, row, guided_piston(np.radians(degrees)))
            if reference is not None
        ]
        yield from compared(f"Slider-crank {degrees} deg", rows, CLOSED_FORM, reason)


def guided_piston(angle: float) -> tuple[float, ...]:
    """Return height, acceleration [m/s2] and loads of a guided piston at a crank angle.

    The loads are side force [N], pin force along y [N] and crank torque [N m].
    """
    mechanism = Mechanism(
        crank_radius=0.0288,
        rod_length=0.110,
        offset=0.0,
        rod_mass=0.35,
        rod_inertia=6e-4,
        rod_centre=30 / 110,
        pin_mass=0.0,
    )
    body = rigid_body(0.315, (0.0, 0.0), 1e-4)
    crank = CrankMotion(angle, 100 * np.pi, 0.0)
    still = Motion(np.zeros(2), np.zeros(2), np.zeros(2))
    load = Load(0.0, 0.0, 0.0, 0.0, np.zeros(0))
    out = tied_forces(tied_pin(body, mechanism, 0.0), load, still, crank)
    return (
        height(mechanism, 0.0, angle).height,
        out.motion.acceleration[PISTON, Y],
        -out.residual[LATERAL],
        out.joint_wrench[PISTON, Y],
        out.torque,
    )


def element_checks():
    """Ten-node tetrahedron: rigid motions, mass properties, and FElupe where it is installed."""
    points, tets = box_mesh((2, 2, 3), (0.1, 0.2, 0.3))
    integrals = floating_frame_integrals(
        consistent_mass(points, tets, 2700.0), points, np.zeros((len(points), 3, 0))
    )
    mass = 2700.0 * 0.1 * 0.2 * 0.3
    inertia = mass * (0.1**2 + 0.2**2) / 3
    rows = (
        ("mass [kg]", integrals.mass, mass, 1e-12),
        ("first moment along x [kg m]", integrals.S[0], mass * 0.05, 1e-12),
        ("moment of inertia about the corner [kg m2]", integrals.I0, inertia, 1e-12),
    )
    reason = "the consistent mass is exact for degree 2"
    yield from compared("Box of ten-node tetrahedra", rows, CLOSED_FORM, reason)
    points = points + 4e-3 * np.sin(25 * points[:, [1, 2, 0]])
    K = stiffness(points, tets, **STEEL)
    case = "Warped ten-node tetrahedron"
    force = np.abs(K @ rigid_motions(points)).max() / np.abs(K).max()
    row = "force of rigid-body motions over norm of K", force, 1e-12
    yield from bounded(case, [row], CLOSED_FORM, "round-off")
    eigenvalues = np.linalg.eigvalsh(K.toarray())
    rigid = np.sum(eigenvalues < 1e-10 * eigenvalues[-1])
    row = "number of rigid-body modes", rigid, 6, 0.0
    yield from compared(case, [row], CLOSED_FORM, "a count", "absolute")
    rows = [
        (f"{name}, difference from FElupe", difference, 1e-12)
        for name, difference in felupe_difference(points, tets)
    ]
    yield from bounded(case, rows, OTHER_CODE, "same quadrature, other order of the sums")


def felupe_difference(points, tets):
    """Yield the largest difference of stiffness and of mass to those of FElupe.

    Each is divided by the largest entry. If FElupe is not installed, nothing is yielded.
    """
    try:
        import felupe
    except ImportError:
        return
    ours = {
        "stiffness": stiffness(points, tets, **STEEL),
        "mass": consistent_mass(points, tets, 2700.0),
    }
    for (name, matrix), side in zip(ours.items(), (3, 4)):
        region = felupe.RegionQuadraticTetra(
            felupe.Mesh(points, tets, "tetra10"),
            quadrature=felupe.quadrature.Scheme(*quadrature(side)),  # pyright: ignore[reportArgumentType]
        )
        body = felupe.SolidBody(
            felupe.LinearElastic(E=STEEL["young"], nu=STEEL["poisson"]),
            felupe.FieldContainer([felupe.Field(region, dim=3)]),
            density=2700.0,
        )
        assembled: Any = body.assemble
        theirs = assembled.matrix() if name == "stiffness" else assembled.mass()
        yield name, abs(matrix - theirs).max() / abs(theirs).max()


def box_mesh(cells, size):
    """Box of 10-node tetrahedra, six in each cell, straight edges: points (n, 3), tets (e, 10)."""
    lines = [np.linspace(0.0, length, n + 1) for n, length in zip(cells, size)]
    points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape([n + 1 for n in cells])
    tets = []
    for order in itertools.permutations(
        range(3)
    ):  # the six paths from one corner of a cell to the opposite one
        corner, path = np.zeros(3, int), [(0, 0, 0)]
        for axis in order:
            corner[axis] = 1
            path.append(tuple(corner))
        tet = np.stack(
            [number[tuple(slice(c, c + n) for c, n in zip(at, cells))].ravel() for at in path],
            axis=1,
        )
        odd = la.det(np.eye(3)[list(order)]) < 0
        tets.append(tet[:, [1, 0, 2, 3]] if odd else tet)
    return with_middles(points, tetrahedra(np.concatenate(tets)))


def bar(cells=(80, 4, 2)):
    """Steel bar 0.5 x 0.02 x 0.01 m: points, K, M, nodes of both ends."""
    points, tets = box_mesh(cells, (0.5, 0.02, 0.01))
    ends = [np.flatnonzero(points[:, 0] == x) for x in (0.0, points[:, 0].max())]
    return points, stiffness(points, tets, **STEEL), consistent_mass(points, tets, 7850.0), ends


def craig_bampton_free(points, K, M, ends, modes):
    """Return the free-free frequencies [Hz] of a body with two rigid ends.

    The basis has 12 constraint modes and `modes` fixed-interface modes.

    Eq. (N4):  Psi = [R_b; -K_ii^-1 K_ib R_b], R_b the rigid motions of one end
    """
    fixed = np.concatenate(ends)
    body = Elastic(K, M, fixed)
    moves = np.zeros((K.shape[0], 12))
    for k, end in enumerate(ends):
        rows = (3 * end[:, None] + np.arange(3)).ravel()
        moves[rows, 6 * k : 6 * k + 6] = rigid_motions(points[end] - points[end].mean(axis=0))
    moves[body.free] -= body.solve((K @ moves)[body.free])  # Eq. (N4)
    shapes = np.hstack([moves, body.full(craig_bampton(body, modes))])
    square = la.eigh(shapes.T @ (K @ shapes), shapes.T @ (M @ shapes), eigvals_only=True)
    return np.sqrt(np.abs(square)) / (2 * np.pi)


def bar_checks():
    """Craig-Bampton reduction of a slender steel bar whose ends are rigid."""
    points, K, M, ends = bar()
    body = Elastic(K, M, np.concatenate(ends))
    fixed = orthonormal_modes(body, craig_bampton(body, 8))[1] / (2 * np.pi)
    exact = craig_bampton_free(points, K, M, ends, 120)[6:9]
    clamped = 213.041, 422.001, 585.289, 1142.306
    reason = "another mesh of ten-node tetrahedra: half as many elements change these by 1.5e-3"
    for case, name, found, references in (
        ("Bar with fixed ends", "fixed-interface frequency [Hz]", fixed, clamped),
        ("Free bar", "free-free frequency, full model [Hz]", exact, (212.374, 422.909, 583.981)),
    ):
        rows = [(name, *both, 1.5e-3) for both in zip(found, references)]
        yield from compared(case, rows, OTHER_CODE, reason)
    reduced = craig_bampton_free(points, K, M, ends, 8)[6:9]
    bounds = 0.043e-2, 0.053e-2, 0.10e-2
    rows = [
        (f"frequency f{k}, excess over the full model", excess, bound, 0.02)
        for k, excess, bound in zip((7, 8, 9), reduced / exact - 1, bounds)
    ]
    reason = "the reference has two to three digits and another mesh"
    yield from compared("Bar reduced to 12 + 8 coordinates", rows, OTHER_CODE, reason)


def beam_in_frame():
    """Return a slender steel bar as a FlexibleBody that bends in x, y.

    Its long axis is along x. One end is clamped in the frame, whose point A is at that end.
    """
    points, K, M, ends = bar((16, 2, 2))
    body = Elastic(K, M, ends[0])
    modes, omega = orthonormal_modes(body, craig_bampton(body, 6))
    modes = body.full(modes).reshape(len(points), 3, -1)
    integrals = floating_frame_integrals(M, points - [0.0, 0.01, 0.005], modes)
    return flexible_body(integrals, omega)


def flexible_body(integrals, omega):
    """Return a body without damping from its `floating_frame_integrals` and frequencies [rad/s]."""
    arrays: dict[str, Any] = {
        name: np.ascontiguousarray(value) if np.ndim(value) else value
        for name, value in integrals._asdict().items()
    }
    return FlexibleBody(**arrays, stiffness=omega**2, damping=np.zeros_like(omega))


def swing(
    body: FlexibleBody,
    angular_velocity: float,
    bend: float,
    step: float,
    steps: int,
    spectral_radius: float = 1.0,
) -> list[Motion]:
    """Return the motion of a free flexible pendulum about A after each step, without gravity.

    The coordinates are [angle, modal coordinates].

    It starts turning at angular_velocity [rad/s], bent by `bend` [kg^1/2 m] in its lowest mode.
    """
    n = 1 + len(body.stiffness)
    start = Motion(np.zeros(n), np.zeros(n), np.zeros(n))
    start.velocity[0] = angular_velocity
    start.position[1] = bend
    now = _pendulum_step(body, start, coefficients(0.0, spectral_radius))
    c = coefficients(step, spectral_radius)
    auxiliary = now.acceleration
    history = [now]
    for _ in range(steps):
        predicted = predict(c, now, auxiliary)
        now = _pendulum_step(
            body, Motion(predicted.position, predicted.velocity, now.acceleration), c
        )
        auxiliary = predicted.auxiliary + c.to_auxiliary * now.acceleration
        history.append(now)
    return history


def _pendulum_step(body, predicted: Motion, c: Coefficients) -> Motion:
    """Solve for the end accelerations of the pendulum by Newton's method, with A at rest.

    The iteration starts from the accelerations of the predicted motion.
    """
    chain = chain_of([Link(body, BLOCK, angle=0)], coordinates=1)
    start = Prediction(predicted.position, predicted.velocity, np.zeros(len(predicted.position)))
    by = increments_of(c, len(start.position))
    still = CrankMotion(0.0, 0.0, 0.0)
    guess = predicted.acceleration
    return solve_motion(chain, no_forces(chain), start, guess, by, still, FIXED).now


def energy(body: FlexibleBody, now: Motion) -> float:
    """Kinetic and elastic energy of a body that turns about A at rest [J].

    Eq. (N5):  E = w^2 (I0 + 2 b.q + q.B q)/2 + w (g + G q).q' + q'.q'/2 + q.Omega^2 q/2
    """
    w = now.velocity[0]
    q = now.position[1:]
    dq = now.velocity[1:]
    # Eq. (N5)
    return (
        w**2 * (body.I0 + 2 * body.b @ q + q @ body.B @ q) / 2
        + w * (body.g + body.G @ q) @ dq
        + dq @ dq / 2
        + q @ (body.stiffness * q) / 2
    )


def pendulum_checks():
    """Check that a free flexible pendulum loses no energy.

    It turns at 30 rad/s while its lowest bending mode oscillates with 4.5 mm at the tip.
    """
    body = beam_in_frame()
    period = 2 * np.pi / np.sqrt(body.stiffness[0])
    levels = np.array([energy(body, now) for now in swing(body, 30.0, 2e-3, period / 100, 2000)])
    row = "energy drift", np.ptp(levels) / levels[0], 1e-10
    reason = (
        "spectral radius 1 conserves energy, and the error falls with the fourth power of the step"
    )
    yield from bounded("Flexible pendulum, 20 periods", [row], "conservation", reason)


def order_check():
    """Check the observed order of the integrator in the step.

    The values are the modal coordinates of the pendulum after three quarters of a period.
    """
    body = beam_in_frame()
    period = 2 * np.pi / np.sqrt(body.stiffness[0])
    ends = []
    for n in (40, 80, 160):
        last = swing(body, 30.0, 2e-3, period / n, 3 * n // 4, 0.8)[-1]
        ends.append(last.position[1:])
    order = np.log2(np.linalg.norm(ends[0] - ends[1]) / np.linalg.norm(ends[1] - ends[-1]))
    row = "observed order", order, 2.0, 0.02
    reason = "the next order is 1/40 of the leading one at these steps"
    return compared(
        "Flexible pendulum, halved steps", [row], "order of the method", reason, "absolute"
    )


BODIES = {
    "piston": dict(surface="skirt", fixed="pin_bore", others=["crown"], density=2680.0, young=78e9),
    "block": dict(surface="bore", fixed="bolts", others=[], density=2700.0, young=72e9),
}


def shipped_body(name):
    """Return a body of the shipped case as a full model.

    The values are the mesh, the mass matrix, Elastic, the reading of the surface's grid, angles and
    heights.
    """
    kind = BODIES[name]
    mesh = read_mesh(
        MODELS / "numerical_example" / f"{name}.msh.xz",
        dict.fromkeys([kind["surface"], kind["fixed"], *kind["others"]]),
    )
    M = consistent_mass(mesh.points, mesh.tets, kind["density"])
    body = Elastic(
        stiffness(mesh.points, mesh.tets, kind["young"], 0.33), M, mesh.nodes(kind["fixed"])
    )
    at = mesh.points[mesh.nodes(kind["surface"])]
    angle, height = cell_centres(40, 40, at[:, 1].min(), at[:, 1].max())
    reading = radial_and_axial(
        interpolation(mesh.points, mesh.faces[kind["surface"]], angle, height, 28.2e-3), angle, 40
    )
    reading = SurfaceReading(*(one[:, body.free].tocsr() for one in reading))
    return mesh, M, body, reading, angle, height


def film_loads(angle, height, skirt_length):
    """Return pressure patches like those of a film, shape (patches, c a).

    They are on the thrust side and on the other side, at three heights, wide and narrow.
    """
    loads = []
    for side, width, share, length in itertools.product(
        (np.pi / 2, 3 * np.pi / 2), (0.35, 0.7), (0.25, 0.5, 0.75), (0.2, 0.35)
    ):
        middle = height[0] + share * (height[-1] - height[0])
        around = np.maximum(
            0.0, 1 - (np.remainder(angle - side + np.pi, 2 * np.pi) - np.pi) ** 2 / width**2
        )
        along = np.maximum(0.0, 1 - (height - middle) ** 2 / (length * skirt_length) ** 2)
        loads.append(np.outer(around, along).ravel())
    return np.array(loads)


def deflection_error(body, read, shapes, loads, full):
    """Return the largest relative error of the static deflection in a basis over all loads.

    The error is the root mean square over the grid.
    """
    modes, omega = orthonormal_modes(body, shapes)
    reduced = (read @ modes) @ ((modes.T @ loads) / omega[:, None] ** 2)
    return np.max(np.linalg.norm(reduced - full, axis=0) / np.linalg.norm(full, axis=0))


BOUNDS = {
    ("piston", "craig_bampton"): (0.20, 0.11, 0.05),
    ("piston", "pressure_modes"): (0.08, 0.025, 0.01),
    ("piston", "smooth_pressure_modes"): (0.16, 0.06, 0.035),
    ("piston", "characteristic_constraint_modes"): (0.19, 0.09, 0.04),
    ("block", "craig_bampton"): (0.30, 0.20, 0.18),
    ("block", "pressure_modes"): (0.10, 0.04, 0.025),
    ("block", "smooth_pressure_modes"): (0.16, 0.095, 0.055),
    ("block", "characteristic_constraint_modes"): (0.30, 0.15, 0.09),
}
"""Largest error with 20, 40, 60 modes: measured on these meshes, with a quarter to spare for others
alike. These patches press on the thrust sides, for which `pressure_modes` are made. A film presses
near the pin too.
"""


COUNTS = (20, 40, 60)
"""Numbers of modes."""


def bases_of(name, mesh, body, reading, angle, height, extra):
    """Yield basis, number of modes and shapes of every basis of a body; the last is the default."""
    surface = BODIES[name]["surface"]
    weight = expected_pressure(angle, len(height))
    for modes in COUNTS:
        first = static_answers(body, extra, modes)
        yield "pressure_modes", modes, pressure_modes(body, reading.radial, weight, modes, first)
    root = pressure_root(angle, height, ALONG[surface], np.ones(len(weight), dtype=bool))
    answers = surface_answers(body, reading, root)
    smooth = smooth_pressure_modes(
        body, reading.radial, answers, max(COUNTS), static_answers(body, extra, max(COUNTS))
    )
    nested = {
        "craig_bampton": craig_bampton(body, max(COUNTS)),
        "characteristic_constraint_modes": characteristic_constraint_modes(
            body, mesh.nodes(surface), max(COUNTS)
        ),
        "smooth_pressure_modes": np.roll(smooth, extra.shape[1], axis=1),
    }
    for basis, shapes in nested.items():
        for modes in COUNTS:
            yield basis, modes, shapes[:, :modes]


def deflection_checks():
    """Check the static deflection under film-like patches, gas and inertia.

    The reference is the full finite-element model.
    """
    for name in BODIES:
        mesh, M, body, reading, angle, height = shipped_body(name)
        read = reading.radial
        loads = read.T @ film_loads(angle, height, 27e-3).T
        full = read @ body.solve(loads)
        extra = (
            rigid_loads(mesh, M)[body.free] if name == "piston" else np.empty((len(body.free), 0))
        )
        for basis, modes, shapes in bases_of(name, mesh, body, reading, angle, height, extra):
            yield at_most(
                f"{name}, {modes} {basis}",
                "error of the deflection under film patches [-]",
                deflection_error(body, read, shapes, loads, full),
                BOUNDS[name, basis][COUNTS.index(modes)],
                "full model",
                "truncation of the basis",
            )
        if name == "piston":
            yield from load_checks(body, mesh, read, shapes, extra)


def rigid_loads(mesh, M):
    """Gas pressure on the crown and unit accelerations along y, x and about A, (3 n, 4)."""
    gas = face_load(mesh.points, mesh.faces["crown"])
    fields = [np.tile(v, (len(mesh.points), 1)) for v in ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0))] + [
        mesh.points @ Z.T
    ]
    return np.column_stack([gas.ravel()] + [M @ field.ravel() for field in fields])


def load_checks(body, mesh, read, shapes, extra):
    """Check crown and skirt under gas pressure and steady inertia against the full model.

    The basis has 60 pressure modes.
    """
    modes, omega = orthonormal_modes(body, shapes)
    crown = np.zeros((len(mesh.points), 3), dtype=bool)
    crown[mesh.nodes("crown"), 1] = True
    pick = crown.ravel()[body.free]
    for name, load in zip(
        ("gas pressure", "acceleration along y", "acceleration along x", "angular acceleration"),
        extra.T,
    ):
        full, reduced = body.solve(load), modes @ ((modes.T @ load) / omega**2)
        rows = []
        for part, choose in (("crown", lambda u: u[pick]), ("skirt", lambda u: read @ u)):
            error = np.linalg.norm(choose(reduced - full)) / np.linalg.norm(choose(full))
            rows.append((f"error of the deflection of the {part}", error, 1e-6))
        reason = "the basis contains the static shape of the load"
        yield from bounded(f"piston, {name}", rows, "full model", reason)


def exudyn_checks():
    """Check the shipped piston with 20 modes on the crank against Exudyn's floating-frame body.

    The steps are 10, 5 and 2.5 us over 2 ms, a motion of about 50 um. If Exudyn is not installed,
    there are no checks.
    """
    if find_spec("exudyn") is None:
        return
    mesh, M, held, *_ = shipped_body("piston")
    modes, omega = orthonormal_modes(held, craig_bampton(held, 20))
    modes = held.full(modes)
    gas = face_load(mesh.points, mesh.faces["crown"]).ravel()
    gas_shape = modes.T @ (gas / -gas[1::3].sum())
    integrals = floating_frame_integrals(M, mesh.points, modes.reshape(len(mesh.points), 3, -1))
    body = flexible_body(integrals, omega)
    mechanism = Mechanism(
        crank_radius=24.75e-3,
        rod_length=0.1,
        offset=1e-3,
        rod_mass=0.14,
        rod_inertia=2.2e-4,
        rod_centre=0.3,
        pin_mass=0.0,
    )
    drive = Drive(
        crank_angle=0.3,
        crank_speed=100 * np.pi,
        lateral_stiffness=2e7,
        turning_stiffness=2e4,
        gas_force=5e3,
        duration=1e-3,
    )
    piston = CrankedPiston(body, mechanism, gas_shape, drive)
    K = stiffness(mesh.points, mesh.tets, 78e9, 0.33)
    full = FullPiston(mesh.points, K, M, modes)
    apart = []
    for step, bound in ((1e-5, 0.0101e-6), (5e-6, 0.0059e-6), (2.5e-6, 0.0018e-6)):
        steps = round(2e-3 / step)
        own = own_motion(piston, step, steps, 0.8)
        other = exudyn_motion(full, piston, step, steps, 0.8)
        difference = np.abs(own - other)
        case = f"Piston compared with Exudyn, {step * 1e6:g} us"
        apart.append(difference[:, 0].max())
        yield at_most(
            case,
            f"lateral displacement of {np.abs(own[:, 0]).max() * 1e6:.1f} um, difference [m]",
            apart[-1],
            bound,
            OTHER_CODE,
            "differences between these codes at these steps in an earlier run",
        )
        rows = []
        for name, columns in (
            ("rocking angle", slice(1, 2)),
            ("modal coordinates", slice(2, None)),
        ):
            size, whole = (
                np.linalg.norm(values[:, columns], axis=1).max() for values in (difference, own)
            )
            rows.append((f"{name}, relative difference", size / whole, 2e-4 * (step / 1e-5) ** 2))
        reason = "the errors of both integrators are of second order with different factors"
        yield from bounded(case, rows, OTHER_CODE, reason)
    row = "order of the difference", np.log2(apart[0] / apart[-1]) / 2, 2.0, 0.2
    case = "Piston compared with Exudyn, quartered steps"
    reason = "both are of order 2, but a step of 10 us does not resolve the highest modes"
    yield from compared(case, [row], OTHER_CODE, reason, "absolute")
