"""Hot shapes of skirt and bore, against closed forms and direct evaluation."""

from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import brentq

from piston_cosim.fmu_mfbd.body_options import Block, Piston, TemperatureField
from piston_cosim.fmu_mfbd.build import prepare
from piston_cosim.fmu_mfbd.dynamics.build_options import BuildOptions, PistonOptions
from piston_cosim.fmu_mfbd.dynamics.clearance import measured, skirt_gap, surfaces
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.finite_elements.deck import MeshFault
from piston_cosim.fmu_mfbd.finite_elements.element import rigid_motions, stiffness, thermal_load
from piston_cosim.fmu_mfbd.finite_elements.materials import Material
from piston_cosim.fmu_mfbd.finite_elements.mesh import Mesh
from piston_cosim.fmu_mfbd.finite_elements.node_values import (
    DISPLACEMENT,
    TEMPERATURE,
    read_node_values,
)
from piston_cosim.fmu_mfbd.finite_elements.ring import Ring, ring_mesh
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.geometry.profile import MeasuredShape, table_shape
from piston_cosim.fmu_mfbd.preview import preview
from piston_cosim.fmu_mfbd.reduction.hot_shape import (
    Table,
    _places,
    hot_shape,
    on_table,
    read_table,
    thermal_shape,
    without_motion,
)
from piston_cosim.fmu_mfbd.reduction.reading import read_body
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedBlock, ReducedPiston, load
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.tests.mfbd.conftest import OUTER, quiet
from piston_cosim.tests.mfbd.test_materials import (
    ALUMINIUM,
    IRON,
    between_plates,
    lame_two_layers,
    lined_ring,
)
from piston_cosim.tests.verification.cases.bodies import box_mesh

PLAIN = Parameters(radial_clearance=25e-6, barrel=0.0, ovality=0.0)
E, NU, ALPHA = 75e9, 0.33, 21e-6
TURNS = rigid_motions


def solved(points, tets, rise, held):
    """Displacement of a body under heat, with some degrees of freedom held."""
    K = stiffness(points, tets, E, NU)
    f = thermal_load(points, tets, E, NU, ALPHA, rise).ravel()
    free = np.flatnonzero(~held.ravel())
    u = np.zeros(held.size)
    u[free] = sp.linalg.spsolve(K[free][:, free], f[free])
    return u.reshape(-1, 3)


# loads and static shapes


def test_free_body_grows_evenly():
    """A ring with curved elements: u = alpha dT r, to round-off."""
    mesh = ring_mesh(Ring(20e-3, 30e-3, 12e-3, 2 * np.pi, (12, 2, 2)))
    points = mesh.points
    held = np.zeros((len(points), 3), dtype=bool)
    a, b, c = np.argmax(points[:, 0]), np.argmin(points[:, 0]), np.argmax(points[:, 1])
    held[a] = held[b, 1:] = held[c, 2] = True
    u = solved(points, mesh.tets, np.full(len(points), 100.0), held)
    even = ALPHA * 100.0 * points
    q, *_ = np.linalg.lstsq(rigid_motions(points), (u - even).ravel(), rcond=None)
    rest = u - even - (rigid_motions(points) @ q).reshape(-1, 3)
    assert np.abs(rest).max() < 1e-9 * np.abs(even).max()


def test_bar_with_linear_temperature_by_closed_form():
    """Free bar, T = g x: u_x = alpha g (x^2 - y^2 - z^2)/2, u_y = alpha g x y, u_z = alpha g x z.

    Its strain is alpha T 1, so that the bar has no stress.
    """
    points, tets = box_mesh((6, 2, 2), (0.1, 0.01, 0.01))
    x, y, z = points.T
    held = np.zeros((len(points), 3), dtype=bool)
    held[np.linalg.norm(points, axis=1) == 0.0] = True
    held[np.argmax(np.where((y == 0) & (z == 0), x, -1)), 1:] = True
    held[np.argmax(np.where((x == 0) & (z == 0), y, -1)), 2] = True
    u = solved(points, tets, 1000.0 * x, held)
    exact = ALPHA * 1000.0 * np.stack([(x**2 - y**2 - z**2) / 2, x * y, x * z], axis=1)
    off = u - exact
    q, *_ = np.linalg.lstsq(rigid_motions(points), off.ravel(), rcond=None)
    off -= (rigid_motions(points) @ q).reshape(-1, 3)
    assert np.abs(off).max() < 1e-6 * np.abs(exact).max()


def test_ring_with_radial_gradient_by_closed_form():
    """Long cylinder between plates, T = T_a (b - r)/(b - a).

    u = (1 + nu)/(1 - nu) alpha/r (I(r) + ((1 - 2 nu) r^2 + a^2)/(b^2 - a^2) I(b)),
    I(r) = int_a^r T r dr      [Timoshenko1970] art. 151 with eps_z = 0
    """
    a, b, hot = 43e-3, 51e-3, 80.0
    mesh = ring_mesh(Ring(a, b, 6e-3, 2 * np.pi, (36, 2, 2)))
    radius = np.hypot(*mesh.points[:, :2].T)
    K = stiffness(mesh.points, mesh.tets, E, NU)
    rise = hot * (b - radius) / (b - a)
    load = thermal_load(mesh.points, mesh.tets, E, NU, ALPHA, rise)
    u = between_plates(mesh.points, K, load)

    def moment(r):
        return hot / (b - a) * (b * (r**2 - a**2) / 2 - (r**3 - a**3) / 3)

    spread = ((1 - 2 * NU) * radius**2 + a**2) / (b**2 - a**2) * moment(b)
    exact = (1 + NU) / (1 - NU) * ALPHA / radius * (moment(radius) + spread)
    radial = (u[:, :2] * mesh.points[:, :2]).sum(axis=1) / radius
    assert np.abs(radial - exact).max() < 1e-3 * exact.max()


def test_iron_liner_in_an_aluminium_wall():
    """The bore of a lined ring between plates grows between free iron and free aluminium.

    Closed form by layers, u = A r + B/r.
    """
    points, mesh, inner = lined_ring()
    own = {key: np.where(inner, IRON[key], ALUMINIUM[key]) for key in IRON}
    K = stiffness(points, mesh.tets, own["young"], own["poisson"])
    rise = np.full(len(points), 80.0)
    heat = own["young"], own["poisson"], own["expansion"], rise
    u = between_plates(points, K, thermal_load(points, mesh.tets, *heat))
    at = mesh.nodes("bore")
    growth = (u[at, :2] * points[at, :2]).sum(axis=1) / 43e-3
    assert growth.mean() == pytest.approx(lined_growth(80.0), rel=1e-3)


def lined_growth(rise, radii=(43e-3, 45.5e-3, 51e-3), layers=(IRON, ALUMINIUM)):
    """Return the growth of the bore of two layers between plates."""
    A, B, *_ = lame_two_layers(radii, layers, rise=rise)
    return A * radii[0] + B / radii[0]


def test_heated_piston_is_free_at_its_pin(coarse):
    """Even heat: u = alpha dT (r - pin), without a motion of the pin bores."""
    folder, table = coarse
    options = Piston(**table["piston"] | {"mesh": str(folder / "piston.msh")})
    mesh = read_body(options, quiet)
    mesh = Mesh(mesh.points, mesh.tets, mesh.faces, material=Material(E, NU, 2700.0, ALPHA))
    u = thermal_shape(mesh, np.full(len(mesh.points), 150.0), piston=True)
    same, motion = without_motion(mesh, u)
    even, _ = without_motion(mesh, ALPHA * 150.0 * mesh.points)
    np.testing.assert_allclose(u, even, atol=1e-9 * np.abs(even).max())
    np.testing.assert_allclose(same, u, atol=1e-9 * np.abs(u).max())
    assert np.abs(motion).max() < 1e-12


def test_piston_that_moves_rigidly_keeps_its_shape(coarse):
    folder, table = coarse
    mesh = read_body(Piston(**table["piston"] | {"mesh": str(folder / "piston.msh")}), quiet)
    q = np.array([3e-5, -2e-5, 1e-5, 1e-4, -2e-4, 3e-4])
    rest, motion = without_motion(mesh, (rigid_motions(mesh.points) @ q).reshape(-1, 3))
    assert np.abs(rest).max() < 1e-16 and motion == pytest.approx(q, rel=1e-9)


# shapes from files


def growing(points):
    """Displacement that is oval, conical and longer: quadratic in x, y, z [m]."""
    x, y, z = points.T
    oval, cone = 1.5e-3, 0.05
    return np.stack([(oval + cone * y) * x, 2e-3 * y + 0.05 * y**2, (cone * y - oval) * z], axis=1)


def write_csv(path, mesh, u, columns="x,y,z", scale=1e3):
    place = mesh.points * scale
    names = f"{columns},ux,uy,uz"
    np.savetxt(path, np.hstack([place, u * scale]), delimiter=",", header=names, comments="")
    return path


@pytest.fixture
def piston(bodies, tmp_path):
    """Return the small piston with a hot shape, and its mesh."""
    folder, table = bodies
    path = tmp_path / "hot.csv"
    given = {"file": str(path), "length_unit": "1 mm"}
    own = table["piston"] | {"mesh": str(folder / "piston.msh"), "hot_shape": given}
    options = Piston(**own)
    mesh = read_body(options, quiet)
    write_csv(path, mesh, growing(mesh.points))
    return options, mesh


def test_hot_shape_by_direct_evaluation(piston):
    """The material at each cell by its own equation y + u_y = Y, on the exact cylinder."""
    options, mesh = piston
    grid = (40, 40)
    shape = hot_shape(options, grid, quiet)
    mean, motion = without_motion(mesh, growing(mesh.points))
    q = shape.motion
    np.testing.assert_allclose(q, motion, atol=1e-12)
    y = mesh.points[mesh.nodes("skirt"), 1]
    lower, upper = y.min(), y.max()

    def at(theta, height):
        point = np.array([[OUTER * np.sin(theta), height, OUTER * np.cos(theta)]])
        x, up, z = (growing(point) - (rigid_motions(point) @ q).reshape(-1, 3))[0]
        return x * np.sin(theta) + z * np.cos(theta), up

    turn = np.linspace(0, 2 * np.pi, 97)[:-1]
    low = np.mean([at(one, lower)[1] for one in turn])
    high = np.mean([at(one, upper)[1] for one in turn])
    assert (shape.lower, shape.upper) == pytest.approx((low, high), rel=1e-3)
    angle, hot = cell_centres(*grid, lower + low, upper + high)
    exact = np.empty((2, 40, 40))
    for i, theta in enumerate(angle):
        for j, place in enumerate(hot):
            cold = brentq(lambda h: h + at(theta, h)[1] - place, lower - 1e-3, upper + 1e-3)  # noqa: B023
            exact[:, i, j] = at(theta, cold)
    for own, right in zip((shape.radial, shape.axial), exact):
        assert np.abs(own - right).max() < 1e-3 * np.abs(right).max()


def test_gap_contains_hot_shape_and_moved_profile(piston):
    """Profile 40 um at the upper end, linear from the lower one, in a skirt that lengthens."""
    options, mesh = piston
    shape = hot_shape(options, (16, 12), quiet)
    y = mesh.points[mesh.nodes("skirt"), 1]
    lower, upper = y.min() + shape.lower, y.max() + shape.upper
    angle, height = cell_centres(16, 12, lower, upper)
    cone = MeasuredShape(np.array([0.0]), np.array([y.min(), y.max()]), np.array([[0.0], [40e-6]]))
    gap = measured((cone,), angle, height, shape)
    cold = height - shape.axial
    np.testing.assert_allclose(gap, 40e-6 * (cold - y.min()) / np.ptp(y), atol=1e-12)
    body = SimpleNamespace(skirt_lower=lower, skirt_upper=upper)
    parts = PistonOptions("", 0, 0.0, (cone,), shape)
    whole = skirt_gap(body, angle, height, parts, PLAIN)
    np.testing.assert_allclose(whole, 25e-6 + gap - shape.radial, atol=1e-12)
    plain = measured((cone,), angle, height)
    np.testing.assert_array_equal(plain, table_shape(cone, angle, height))


def frd(points, u, labels):
    """Text of an frd file of CalculiX with coordinates and DISP."""
    lines = ["    1C", f"    2C{len(points):30d}{1:38d}"]
    lines += [f" -1{k:10d}" + "".join(f"{v:12.5E}" for v in p) for k, p in zip(labels, points)]
    lines += [" -3", "    1PSTEP                         1           1           1"]
    lines += [f"  100CL  101 1.000000000{len(points):12d}                     0    1           1"]
    lines += [" -4  DISP        4    1", " -5  D1          1    2    1    0"]
    lines += [f" -1{k:10d}" + "".join(f"{v:12.5E}" for v in p) for k, p in zip(labels, u)]
    return "\n".join([*lines, " -3", " 9999"]) + "\n"


@pytest.mark.parametrize("suffix", [".frd", ".vtu", ".csv"])
def test_files_of_displacements(suffix, tmp_path):
    points, _ = box_mesh((2, 1, 1), (8.0, 4.0, 4.0))
    u = growing(points)
    path = tmp_path / f"u{suffix}"
    if suffix == ".frd":
        path.write_text(frd(points, u, range(3, 3 + len(points))))
    elif suffix == ".vtu":
        data = {"U": u, "stress": np.zeros((len(points), 6)), "T": points[:, 0]}
        meshio.Mesh(points, [("vertex", np.arange(len(points))[:, None])], data).write(path)
    else:
        rows = np.column_stack([np.arange(3, 3 + len(points)), u])
        np.savetxt(path, rows, delimiter=";", header="node;ux;uy;uz", comments="", fmt="%.17g")
    given = read_node_values(path, DISPLACEMENT)
    np.testing.assert_allclose(given.values, u, rtol=1e-5)
    assert suffix == ".vtu" or given.labels[0] == 3
    if suffix == ".vtu":
        assert read_node_values(path, TEMPERATURE).values[:, 0].tolist() == points[:, 0].tolist()
        with pytest.raises(MeshFault, match="u.vtu: expected field 'V', got U; set field to its"):
            read_node_values(path, DISPLACEMENT, "V")


@pytest.mark.parametrize(
    ("scale", "unit", "fault"),
    [
        ((1e3, 1e3), "1 m", r"check length_unit = 1 m, mesh_unit, axes and origin"),
        ((1e3, 1e6), "1 mm", r"deformation of surface 'skirt' of 0.56 to 1.12e\+03 um, got"),
        ((1e3, 1.0), "1 mm", r"deformation of surface 'skirt' of 0.56 to 1.12e\+03 um, got"),
    ],
)
def test_wrong_units_are_rejected(scale, unit, fault, piston, tmp_path):
    options, mesh = piston
    path = tmp_path / "hot.csv"
    place, size = scale
    table = np.hstack([mesh.points * place, growing(mesh.points) * size])
    np.savetxt(path, table, delimiter=",", header="x,y,z,ux,uy,uz", comments="")
    given = {"file": str(path), "length_unit": unit}
    wrong = options.model_copy(update={"hot_shape": type(options.hot_shape)(**given)})
    with pytest.raises(MeshFault, match=fault):
        hot_shape(wrong, (16, 12), quiet)


def test_nodes_and_contents_that_do_not_fit(piston, tmp_path):
    options, mesh = piston
    path = tmp_path / "hot.csv"
    shifted = Mesh(mesh.points + [0, 0, 1e-3], mesh.tets, mesh.faces)
    write_csv(path, shifted, growing(mesh.points))
    with pytest.raises(MeshFault, match="hot_shape: .*hot.csv: expected finite values at .* none"):
        hot_shape(options, (16, 12), quiet)
    named = options.model_copy(
        update={"hot_shape": options.hot_shape.model_copy(update={"field": "U"})}
    )
    with pytest.raises(MeshFault, match="hot.csv: field: expected nothing for a CSV file"):
        hot_shape(named, (16, 12), quiet)
    path.write_text("x,y,ux\n1,2,3\n")
    with pytest.raises(
        MeshFault, match="a first row with node or x,y,z and ux,uy,uz, got 'x,y,ux'"
    ):
        hot_shape(options, (16, 12), quiet)
    path.write_text("node,ux,uy,uz\n1,2,3,a\n")
    with pytest.raises(MeshFault, match="hot.csv: row 2: expected 4 numbers, got '1,2,3,a'"):
        hot_shape(options, (16, 12), quiet)


# temperatures


def test_table_over_radius_and_height(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("height,0,40\n-10,150,110\n30,250,170\n")
    field = TemperatureField(table=str(path), length_unit="1 mm", temperature_unit="degC")
    points = np.array([[0, -0.02, 0], [0.02, 0.01, 0], [0.03, 0.05, 0.04]])
    values = on_table(read_table(path, field), points)
    np.testing.assert_allclose(values - 273.15, [150.0, 170.0, 170.0])
    path.write_text("height,0,40\n-10,150\n")
    with pytest.raises(MeshFault, match="t.csv, line 2: expected a height and 2 temperatures"):
        read_table(path, field)


def heated(bodies, tmp_path, **other):
    """Build table of the small bodies with 120 K of even heat in both."""
    folder, table = bodies
    path = tmp_path / "t.csv"
    path.write_text("height,0\n0,140\n")
    field = {"table": str(path), "length_unit": "1 mm", "temperature_unit": "degC"}
    own = {"expansion": "21e-6 1/K", "temperature_field": field, "modes": 0}
    out = table | {name: table[name] | own for name in ("piston", "block")}
    return folder, out | other


def test_heat_in_build_and_check(coarse, kept, tmp_path):
    folder, table = heated(coarse, tmp_path)
    options, files = prepare(table, folder, quiet)
    options = BuildOptions.from_json(options)
    body, block = load(ReducedPiston, files[0]), load(ReducedBlock, files[1])
    even = 21e-6 * 120.0
    # read on chords of 16 elements with curved edges
    np.testing.assert_allclose(options.piston.hot.radial, even * OUTER, rtol=1e-3)
    assert body.skirt_upper - body.skirt_lower == pytest.approx(24e-3 * (1 + even), rel=1e-5)
    # the block is held at its lower end, and grows freely far above it
    assert options.block.hot.radial[:, -8].mean() == pytest.approx(even * (OUTER + 25e-6), rel=0.02)
    assert abs(options.block.hot.radial[:, 0]).max() < 1e-9
    (film,) = surfaces(body, block, options)
    np.testing.assert_allclose(film.skirt.gap, -options.piston.hot.radial)
    given = {"radial_clearance": 25e-6, "barrel": 0.0, "skirt_growth_upper": 1e-6}
    seen = preview(table, given, folder)
    assert seen.figure("skirt_hot_growth").value == pytest.approx(even * OUTER, rel=1e-3)
    length = seen.figure("skirt_length").value
    assert length == pytest.approx(body.skirt_upper - body.skirt_lower, rel=1e-12)
    assert any("skirt_growth_upper: expected 0 with a hot shape" in one for one in seen.warnings)
    assert seen.figure("clearance_cold").value == pytest.approx(25e-6)


def test_bad_input_names_every_fault(coarse, kept, tmp_path):
    folder, table = heated(coarse, tmp_path)
    (tmp_path / "t.csv").write_text("height,0\n0,14\n")
    for name in ("piston", "block"):
        table[name]["temperature_field"]["temperature_unit"] = "K"
    with pytest.raises(BadInput) as raised:
        prepare(table, folder, quiet)
    assert len(raised.value.faults) == 2
    for fault in raised.value.faults:
        assert "temperature_field: " in fault
        assert "t.csv: expected 200 to 1500 K, got 14 to 14 K; check temperature_unit" in fault
    del table["piston"]["expansion"], table["block"]["expansion"]
    with pytest.raises(
        BadInput, match="expansion of no set: expected 0 to 0.0001 1/K, got nothing"
    ):
        prepare(table, folder, quiet)


def test_kelvin_that_are_declared_as_degrees_are_rejected(coarse, tmp_path):
    folder, table = coarse
    path = tmp_path / "t.csv"
    path.write_text("height,0,28\n-15,413,403\n15,473,463\n")
    field = {"table": str(path), "length_unit": "1 mm", "temperature_unit": "degC"}
    own = {"mesh": str(folder / "piston.msh"), "expansion": "21e-6 1/K", "temperature_field": field}
    with pytest.raises(MeshFault, match="up to 226.9 degC, got .* set temperature_unit to K"):
        hot_shape(Piston(**table["piston"] | own), (16, 12), quiet)
    right = own | {"temperature_field": field | {"temperature_unit": "K"}}
    hot_shape(Piston(**table["piston"] | right), (16, 12), quiet)


@pytest.mark.parametrize("unit", ["1 m", "0.01 mm"])
def test_table_of_another_length_unit_is_rejected(unit, coarse, tmp_path):
    """Its values would be constant over the body."""
    folder, table = coarse
    path = tmp_path / "t.csv"
    path.write_text("height,0,20\n-15,140,130\n15,200,190\n")
    field = {"table": str(path), "length_unit": unit, "temperature_unit": "degC"}
    own = {"mesh": str(folder / "piston.msh"), "expansion": "21e-6 1/K", "temperature_field": field}
    with pytest.raises(MeshFault) as raised:
        hot_shape(Piston(**table["piston"] | own), (16, 12), quiet)
    for fault, name in zip(raised.value.faults, ("radii", "heights"), strict=True):
        assert fault.startswith(f"piston.temperature_field: {path}: expected {name} that cover ")
        assert fault.endswith("check length_unit")


@pytest.mark.parametrize(
    "radii, fits",
    [((0, 60), True), ((37, 60), True), ((0, 23), False), ((0, 38), False)],
)
def test_radii_of_a_table_reach_into_a_hollow_body(radii, fits):
    """Radii that count from the bore of 37 mm end at its wall of 23 mm, far from the body."""
    points = np.array([[37e-3, 0.0, 0.0], [60e-3, 0.1, 0.0]])
    table = Table(1e-3 * np.array(radii), np.array([0.0, 0.1]), np.full((2, 2), 400.0))
    assert (not _places(table, points)) == fits


def test_options_that_exclude_each_other():
    sheet = {"rigid": {"radius": "40 mm"}, "bore_lower": "0 mm", "bore_upper": "1 mm"}
    shape = {"file": "u.csv", "length_unit": "1 mm"}
    with pytest.raises(ValueError, match="hot_shape: expected nothing with a data sheet"):
        Block(**sheet, hot_shape=shape)
    field = {"length_unit": "1 mm", "temperature_unit": "degC"}
    with pytest.raises(ValueError, match="expected either file or table, got neither"):
        TemperatureField(**field)
    with pytest.raises(ValueError, match="field: expected it with file only, got it with table"):
        TemperatureField(**field, table="t.csv", field="T")
    with pytest.raises(ValueError, match="temperature_field: expected nothing with hot_shape"):
        Block(mesh="a.inp", hot_shape=shape, temperature_field=field | {"table": "t.csv"})


@pytest.fixture
def block(bodies, tmp_path):
    """Return the table of the small block, and its mesh."""
    folder, table = bodies
    own = table["block"] | {"mesh": str(folder / "block.msh")}
    return own, read_body(Block(**own), quiet)


def test_rigid_motion_of_a_bore_stays(block, tmp_path):
    """Growth 1e-3 R with shift t and small turns w: u_r = (t + w x r) e_r + 1e-3 R."""
    own, mesh = block
    q = np.array([20e-6, 100e-6, -10e-6, 2e-4, 1e-4, -3e-4])
    growth = 1e-3 * mesh.points * [1, 0, 1]
    u = growth + (rigid_motions(mesh.points) @ q).reshape(-1, 3)
    given = {"file": str(write_csv(tmp_path / "u.csv", mesh, u)), "length_unit": "mm"}
    shape = hot_shape(Block(**own, hot_shape=given), (40, 40), quiet)
    # the rigid motion is exact at the nodes, and small against the growth's round-off
    assert shape.motion == pytest.approx(q, rel=1e-6) and shape.lower == shape.upper == 0.0
    radius = OUTER + 25e-6
    angle, _ = cell_centres(40, 1, 0.0, 1.0)
    theta, y = angle[:, None], np.linspace(50e-3, 155e-3, 24)
    x, z = radius * np.sin(theta), radius * np.cos(theta)
    y = y - (q[1] + q[5] * x - q[3] * z)  # of the material at the heights of the table
    along_x, along_z = q[0] + q[4] * z - q[5] * y, q[2] + q[3] * y - q[4] * x
    exact = 1e-3 * radius + along_x * np.sin(theta) + along_z * np.cos(theta)
    inside = (y > 50e-3) & (y < 155e-3)
    assert np.abs(shape.radial - exact)[inside].max() < 1e-3 * np.abs(exact).max()


def test_temperature_of_each_node(block, tmp_path):
    """The same linear field from a table and from nodes gives the same shape."""
    own, mesh = block
    _, y, _ = mesh.points.T
    rise = np.column_stack([1e3 * mesh.points, 100.0 + 1e3 * y])
    np.savetxt(tmp_path / "n.csv", rise, delimiter=",", header="x,y,z,temperature", comments="")
    (tmp_path / "t.csv").write_text("y,0\n50,150\n155,255\n")
    shapes = []
    for source in ({"file": "n.csv"}, {"table": "t.csv"}):
        ((key, name),) = source.items()
        field = {key: str(tmp_path / name), "length_unit": "mm", "temperature_unit": "degC"}
        options = Block(**own, expansion="21e-6 1/K", temperature_field=field)
        shapes.append(hot_shape(options, (16, 12), quiet).radial)
    np.testing.assert_allclose(*shapes, atol=1e-9 * np.abs(shapes[0]).max())
    assert shapes[0].max() == pytest.approx(21e-6 * 225.0 * OUTER, rel=0.05)
