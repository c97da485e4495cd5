"""A flexible block of two cylinders.

Its reduction is compared with independent assemblies and direct solutions of the whole mesh,
its step with that of the rigid block.
"""

import dataclasses
import importlib.util
from typing import NamedTuple

import numpy as np
import pytest
import scipy.sparse.linalg as spla
import skfem
from scipy.spatial import KDTree
from skfem import Basis, ElementTetP2, ElementVector, MeshTet2
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

from piston_cosim.fmu_mfbd.dynamics.monoblock import BlockParameters, Cylinder, MountedMonoblock
from piston_cosim.fmu_mfbd.finite_elements.element import rigid_motions
from piston_cosim.fmu_mfbd.finite_elements.mesh import read_mesh
from piston_cosim.fmu_mfbd.mechanism.bdf2 import STATIC
from piston_cosim.fmu_mfbd.monoblock.build import declared_variables, prepare
from piston_cosim.fmu_mfbd.reduction.monoblock import (
    Plan,
    bearing_shares,
    free_block,
    readings,
    reduce_monoblock,
)
from piston_cosim.master.case.reading import find_case
from piston_cosim.master.fmi.errors import BadInput

MESH = find_case("flexible_twin").parent / "block.msh.xz"
YOUNG, POISSON, DENSITY = 110e9, 0.26, 7200.0
HEAD, CRANK = 20.0, 25.0
PLAN = Plan((-0.065, 0.065), 3, 4, (24, 24), 0.098, 0.36, 8, 70)
STEP = 1e-4


class Whole(NamedTuple):
    """The block unreduced and reduced."""

    body: object
    reduced: object


@pytest.fixture(scope="module")
def whole():
    mesh = read_mesh(MESH, dict.fromkeys(PLAN.surfaces()))
    body = free_block(mesh, (YOUNG, POISSON, DENSITY), HEAD, CRANK)
    return Whole(body, reduce_monoblock(body, PLAN, lambda text: None))


def test_mass_of_a_block_with_head_and_crank(whole):
    """Volumes of tetrahedra from one corner times the density; chords of bores are worth 2e-3."""
    mesh = whole.body.mesh
    corners = mesh.points[mesh.tets[:, :4]]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6
    own = DENSITY * volume
    np.testing.assert_allclose(np.diag(whole.reduced.rigid_mass)[:3], own + HEAD + CRANK, rtol=2e-3)


@pytest.mark.slow
def test_free_frequencies_against_an_independent_assembly(whole):
    """Free frequencies agree with those of scikit-fem, after six rigid motions.

    Vector elements, elasticity, quadrature and the order of nodes are those of scikit-fem. Its
    facet forms give the mass of head and crank. Quadratures differ on curved elements by 1e-4.
    """
    mesh = whole.body.mesh
    tet = MeshTet2(np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.tets.T))
    basis = Basis(tet, ElementVector(ElementTetP2()), intorder=5)
    K = linear_elasticity(*lame_parameters(YOUNG, POISSON)).assemble(basis)
    heavy = skfem.BilinearForm(lambda u, v, w: dot(u, v))
    M = DENSITY * heavy.assemble(basis)
    bearings = np.vstack([f for name, f in mesh.faces.items() if name.startswith("bearing")])
    for faces, mass in ((mesh.faces["deck"], HEAD), (bearings, CRANK)):
        middles = mesh.points[faces[:, :3]].mean(axis=1)
        away, facets = KDTree(tet.p[:, tet.facets].mean(axis=1).T).query(middles)
        assert away.max() < 1e-12
        on = skfem.FacetBasis(tet, ElementVector(ElementTetP2()), facets=np.sort(facets))
        products = heavy.assemble(on)
        area = products.sum() / 3
        M = M + products * (mass / area)
    found = spla.eigsh(K, 14, M, sigma=-1e5, v0=np.ones(K.shape[0]))[0]
    assert np.abs(found[:6]).max() < 1e-4 * found[6]
    np.testing.assert_allclose(whole.reduced.omega[:8], np.sqrt(found[6:]), rtol=1e-4)


def test_shares_of_bearings_by_the_lever():
    stands = np.array([0.13, -0.13, 0.0])
    np.testing.assert_allclose(bearing_shares(0.065, stands), [0.5, 0.0, 0.5])
    np.testing.assert_allclose(bearing_shares(-0.0975, stands), [0.0, 0.75, 0.25])
    np.testing.assert_allclose(bearing_shares(-0.2, stands), [0.0, 1.0, 0.0])


def directly(body, load):
    """Return the direct solution of the whole free mesh for nodal forces.

    The forces that accelerate the mesh are subtracted. Three nodes are held, which then have no
    reactions. The remaining rigid motion is subtracted.
    """
    rigid = rigid_motions(body.mesh.points)
    heavy = body.M @ rigid
    gram = np.linalg.inv(rigid.T @ heavy)
    load = load - heavy @ (gram @ (rigid.T @ load))
    x, y, z = body.mesh.points.T
    a, b, c = np.argmin(x + z), np.argmax(x - z), np.argmax(y)
    held = [3 * a, 3 * a + 1, 3 * a + 2, 3 * b + 1, 3 * b + 2, 3 * c]
    free = np.setdiff1d(np.arange(len(load)), held)
    out = np.zeros(len(load))
    K = body.K.tocsr()[free][:, free].tocsc()
    lu = spla.splu(
        K, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    out[free] = lu.solve(load[free])
    return out - rigid @ (gram @ (heavy.T @ out))


def test_cross_talk_is_the_meshs(whole):
    """The deflections of both bores agree with a direct solution of the whole mesh.

    A patch of pressure acts on the thrust side of one bore, gas on the deck and at the bearings.
    """
    reduced, body = whole.reduced, whole.body
    read = readings(body.mesh, PLAN)
    theta = np.pi / 2 + (np.arange(24) - 6) * 2 * np.pi / 24
    patch = np.maximum(np.cos(theta - np.pi / 2), 0.0)[:, None] ** 2
    force = 2e3 * patch * np.exp(-(((reduced.heights - 0.22) / 0.03) ** 2)) / 10
    load = read.bores[0].radial.T @ force.ravel()
    load = load + 5e4 * (read.deck[0] - read.bearing[0, 1])
    u = directly(body, load)
    modal = np.einsum("cs,csk->k", force, reduced.radial[0])
    modal = modal + 5e4 * (reduced.deck[0] - reduced.bearing[0, 1])
    q = modal / reduced.omega**2
    fields = [(one.radial @ u).reshape(24, 24) for one in read.bores]
    errors = [np.abs(field - table @ q).max() for field, table in zip(fields, reduced.radial)]
    own, other = (np.abs(field).max() for field in fields)
    print(f"own bore {own:.4g} m, the other {other:.4g} m, errors {errors}")
    assert 0.02 * own < other < own
    # 70 modes for both bores, 26 of them free or answers to forces on deck, bearings and mounts
    assert errors[0] < 0.05 * own
    assert errors[1] < 0.03 * other


def test_what_bends_a_bore(whole):
    """Static answers to the firing of cylinder 1 and of cylinder 2 are mirror images.

    Gas between deck and bearings of the other cylinder mirrors z to -z: theta to pi - theta, i to
    12 - i. The reading of points on edges of faces can use either of two faces, which gives 2e-5.
    """
    body = whole.reduced
    gas = 6.78e6 * np.pi * body.radius**2

    def fields(modal):
        return body.radial @ (modal / body.omega**2)

    lifted = [fields(gas * (body.deck[k] - body.bearing[k, 1])) for k in (0, 1)]
    image = lifted[1][::-1, (12 - np.arange(24)) % 24]
    np.testing.assert_allclose(lifted[0], image, rtol=0, atol=1e-4 * np.abs(image).max())
    top = np.where(body.heights > 0.34, 1.0, 0.0)
    area = body.radius * 2 * np.pi / 24 * (body.heights[1] - body.heights[0])
    wall = fields(np.einsum("s,csk->k", 6e6 * area * top, body.radial[0]))
    theta = np.pi / 2 + (np.arange(24) - 6) * 2 * np.pi / 24
    patch = np.maximum(np.sin(theta), 0.0)[:, None] ** 8
    patch = patch * np.exp(-(((body.heights - 0.29) / 0.03) ** 2))
    film = fields(np.einsum("cs,csk->k", 4.8e3 * patch / patch.sum(), body.radial[0]))
    said = {"deck": lifted[0], "wall": wall, "film": film}
    said = {name: 1e6 * np.abs(field).max(axis=(1, 2)) for name, field in said.items()}
    print({name: f"{own:.3g} um, the other {other:.3g}" for name, (own, other) in said.items()})
    for own, other in said.values():
        assert 0.2 * own < other < 0.7 * own


# the step


def twins_block():
    path = find_case("twin").parent / "mounted_block.py"
    spec = importlib.util.spec_from_file_location("mounted_block", path)
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


SPRINGS = np.array([[1.5e5, 3e5, 1.5e5]]) * np.array([1.0, 2.0, 1.5, 1.0])[:, None]


def mounted(reduced, **values):
    return MountedMonoblock(reduced, SPRINGS, BlockParameters(damping_time=3e-3, **values))


def pushes(n, size=1.0):
    """Return the loads of two cylinders in step n: a rough one each."""
    rng = np.random.default_rng(n)
    out = []
    for k in range(2):
        x, y, turn, bx, by, deck = size * 1e3 * rng.standard_normal(6)
        bore = size * 10.0 * rng.standard_normal((24, 24))
        out.append(Cylinder(x, y, 0.1 * turn, bx, by, deck + 100.0 * k, bore))
    return out


def run(model, steps, step=STEP):
    state = model.start(pushes(0))
    for n in range(1, steps + 1):
        before = state
        state = model.advance(before, pushes(n), step)
    return before, state


def test_power_of_forces_at_their_places(whole):
    """Modal forces have the power of the cylinders' forces along the motions they receive.

    It is F along q' (Eqs. (U31), (U32)). Deck and bearings are added separately.
    """
    model = mounted(whole.reduced)
    rng = np.random.default_rng(5)
    motion = rng.standard_normal(model.size)
    cylinders = pushes(3)
    seen = model.at_cylinders(motion, motion, motion)
    body = whole.reduced
    power = sum(
        one.force_x * at.acceleration_x
        + one.force_y * at.acceleration_y
        + one.moment * at.angular_velocity
        + np.sum(one.force_on_bore * at.bore_deflection)
        + one.force_on_deck * (deck @ motion[6:])
        + np.array([one.bearing_force_x, one.bearing_force_y]) @ bearing @ motion[6:]
        for one, at, deck, bearing in zip(cylinders, seen, body.deck, body.bearing)
    )
    assert model.total(cylinders) @ motion == pytest.approx(power, rel=1e-12)


def test_a_stiff_block_is_the_rigid_one(whole):
    """A stiff block approaches the twin's rigid block with the same mass and mounts.

    The modulus is multiplied by 1e4 and 1e6, which changes no shape. The difference is proportional
    to 1/modulus.
    """
    twin = twins_block()
    body = whole.reduced
    one = object.__new__(twin.MountedBlock)
    one.options = {"cylinders": 2}
    model = mounted(body)
    one.engine = twin.Engine(
        body.rigid_mass,
        model.mount_damping[:6, :6],
        model.mounts[:6, :6],
        body.cylinder_z,
        np.zeros(2),
    )
    still = np.zeros(6)
    state = twin.MountedBlockState(still, still, still, still, 0.0)
    for n in range(1, 31):
        values = {
            f"cylinder_{k}.{name}": value
            for k, push in enumerate(pushes(n), 1)
            for name, value in zip(twin.FORCES, push[:3])
        }
        state, told = one.advance(state, values, 0.0, STEP)
    apart, bent = [], []
    for times in (1e4, 1e6):
        stiff = mounted(dataclasses.replace(body, omega=np.sqrt(times) * body.omega))
        _, end = run(stiff, 30)
        apart.append(np.abs(end.position[:6] - state.position).max())
        seen = stiff.at_cylinders(end.position, end.velocity, end.acceleration)
        bent.append(max(np.abs(one.bore_deflection).max() for one in seen))
    size = np.abs(state.position).max()
    assert apart[1] < 1e-7 * size
    assert apart[0] / apart[1] == pytest.approx(100.0, rel=0.05)
    assert bent[0] / bent[1] == pytest.approx(100.0, rel=0.05)
    assert seen[1].acceleration_y == pytest.approx(told["cylinder_2.acceleration_y"], rel=1e-6)


@pytest.mark.parametrize("steps", [1, 2, 7])
@pytest.mark.parametrize("static", [1e9, 3e3])
def test_change_with_forces_is_the_difference(whole, steps, static):
    """Linear: any size of change; round-off of what is there besides."""
    model = mounted(whole.reduced, quasi_static_frequency=static)
    before, _ = run(model, steps)
    base = pushes(steps)
    direction = pushes(99, size=50.0)
    changed = [
        Cylinder(*(a + b for a, b in zip(one, other))) for one, other in zip(base, direction)
    ]
    ends = [model.advance(before, some, STEP) for some in (base, changed)]
    up, down = (model.at_cylinders(e.position, e.velocity, e.acceleration) for e in reversed(ends))
    for found, a, b in zip(model.change(ends[0], direction), up, down):
        for product, x, y in zip(found, a, b):
            wanted = np.asarray(x) - y
            np.testing.assert_allclose(product, wanted, atol=1e-9 * np.abs(wanted).max())


def test_energy_of_a_step(whole):
    """With the trapezoidal rule, work is the stored energy plus the losses.

    This includes modes without inertia and the losses of all other modes. The first two steps lose
    some energy, as does a smaller spectral radius.
    """
    model = mounted(whole.reduced, spectral_radius=1.0, quasi_static_frequency=6e3)
    assert 5 < (model.kinds == STATIC).sum() < len(whole.reduced.omega) - 5
    for steps in (3, 8):
        before, end = run(model, steps)
        stored = sum(model.energies(end))
        assert abs(model.energy_error(before, end)) < 1e-10 * stored
        assert model.lost(before, end) > 1e-6 * stored
    before, end = run(mounted(whole.reduced), 8)
    assert model.energy_error(before, end) > 0.0


# refusals

TABLE = {
    "mesh": "block.msh.xz",
    "density": "7200 kg/m^3",
    "young": "110 GPa",
    "poisson": 0.26,
    "cylinder_z": ["-65 mm", "65 mm"],
    "bearings": 3,
    "bore_lower": "98 mm",
    "bore_upper": "360 mm",
}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"cylinder_z": ["65 mm", "-65 mm"]}, "cylinder_z: expected rising places along"),
        ({"bore_lower": "370 mm"}, "bore_lower: expected a height below"),
        ({"modes": 20}, "modes: expected more than 10 free modes and"),
        ({"mesh": "nowhere.msh"}, "mesh: expected a file"),
        ({"youngs": "1 Pa"}, "unknown key"),
        ({"bore": {"around": 4}}, "around: expected a value of at least 8, got"),
    ],
)
def test_build_tables_that_are_refused(change, told):
    with pytest.raises(BadInput, match=told):
        declared_variables(TABLE | change, MESH.parent)


def test_a_surface_that_the_mesh_lacks_is_rejected():
    with pytest.raises(BadInput, match=r"block.msh.xz: surface 'bearing_4': expected outer faces"):
        prepare(TABLE | {"bearings": 5}, MESH.parent, lambda text: None)


def test_bores_that_are_not_there_are_refused():
    for plan, told in (
        (PLAN._replace(cylinder_z=(-0.06, 0.065)), "cylinder_z"),
        (PLAN._replace(upper=0.38), "bore_upper"),
    ):
        mesh = read_mesh(MESH, dict.fromkeys(plan.surfaces()))
        with pytest.raises(Exception, match=told):
            readings(mesh, plan)
