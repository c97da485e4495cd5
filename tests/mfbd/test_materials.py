"""Materials by element set, against closed forms and an independent assembly."""

import numpy as np
import pytest
import scipy.linalg as la
import skfem
from scipy.sparse.linalg import eigsh, spsolve
from skfem.helpers import ddot, dot, eye, sym_grad, trace

from piston_cosim.fmu_mfbd.body_options import Piston
from piston_cosim.fmu_mfbd.finite_elements.element import (
    consistent_mass,
    corner_stress,
    lame_constants,
    nodal_stress,
    rigid_mass,
    stiffness,
)
from piston_cosim.fmu_mfbd.finite_elements.faces import face_load
from piston_cosim.fmu_mfbd.finite_elements.materials import (
    ElementSets,
    material_of,
    replacement_remarks,
    units_of,
)
from piston_cosim.fmu_mfbd.finite_elements.mesh import MeshFault, read_mesh, read_raw
from piston_cosim.fmu_mfbd.finite_elements.ring import Ring, ring_mesh
from piston_cosim.fmu_mfbd.reduction.mode_tables import recover
from piston_cosim.fmu_mfbd.reduction.reduce import read_body, reduce_piston
from piston_cosim.fmu_mfbd.reduction.reduced_body import Anatomy, load, save
from piston_cosim.fmu_mfbd.reduction.store import contents
from piston_cosim.fmu_mfbd.reduction.symmetry import is_mirrored
from piston_cosim.tests.mfbd.test_foreign_decks import (
    ABAQUS,
    ANSYS,
    NASTRAN,
    SECTIONS,
    TEN,
    grid,
    solids,
)
from piston_cosim.tests.verification.cases.bodies import box_mesh

ALUMINIUM = {"young": 75e9, "poisson": 0.33, "density": 2700.0, "expansion": 21e-6}
IRON = {"young": 110e9, "poisson": 0.26, "density": 7200.0, "expansion": 10.5e-6}
"""Values of the size in tables of materials; the tests need two different ones only."""
DECKS = {
    "alu.inp": ABAQUS
    + SECTIONS
    + "*MATERIAL, NAME=alu\n*ELASTIC\n75000., 0.33\n*DENSITY\n2.7e-9\n*EXPANSION\n2.1e-5\n"
    "*MATERIAL, NAME=IRON\n*DENSITY\n7.2E-9,\n*ELASTIC, TYPE=ISOTROPIC\n110000., 0.26, 20.\n"
    "100000., 0.26, 300.\n*EXPANSION, ZERO=20.\n1.05D-5\n*STEP\n",
    "alu.bdf": NASTRAN
    + grid(np.eye(10, 3), "", 21)
    + "CTETRA,2,2,21,22,23,24,25,26\n,27,28,29,30\nPSOLID,1,3\nPSOLID,2,4\nPARAM,WTMASS,1.-3\n"
    "MAT1,3,75000.,,0.33,2.7-6,2.1-5\nMAT1,4,110000.,43650.79365,,7.2-6,1.05-5\n",
    "alu.cdb": ANSYS
    + "MP,EX,1,75000,\t! MPa\nMP,NUXY,1,0.33\nMP,DENS,1,2.7e-9\nMP,ALPX,1,2.1e-5\n"
    + "".join(
        f"MPTEMP,R5.0,1,1,0.\nMPDATA,R5.0,1,{label},2,1,{value},\n"
        for label, value in (("EX", 110000), ("PRXY", 0.26), ("DENS", 7.2e-9), ("ALPX", 1.05e-5))
    )
    + solids((1, 1, TEN), (1, 2, TEN)),
}


@pytest.mark.parametrize("name", DECKS)
def test_two_materials_of_a_deck_in_millimetres(name, tmp_path):
    path = tmp_path / name
    path.write_text(DECKS[name])
    deck = read_raw(path)
    sets = ElementSets({}, deck.materials, deck.properties, 1e-3)
    material = material_of(sets, 2, {}, {})
    for key in ALUMINIUM:  # Nastran's nu from E and G has ten digits
        both = [ALUMINIUM[key], IRON[key]]
        np.testing.assert_allclose(getattr(material, key), both, rtol=1e-8)
    assert [text.split(":")[0] for text in deck.remarks] == ["material IRON"] * (name == "alu.inp")


def test_units_of_a_deck_by_hand():
    """A tonne per mm3 is 1e12 kg/m3, and a slinch (lbf s2/in, 175.1268 kg) per in3 1.0687e7."""
    assert units_of(1e-3)["density"] == pytest.approx(1e12)
    inch = units_of(0.0254)
    assert inch["density"] == pytest.approx(175.126835 / 0.0254**3, rel=1e-8)
    assert inch["young"] == pytest.approx(6894.757293, rel=1e-9)


def test_case_over_body_over_deck_and_the_statement():
    sets = ElementSets({"liner": np.array([1])}, ["A", "B", "A"], {"A": ALUMINIUM, "B": IRON})
    material = material_of(sets, 3, {"young": 80e9}, {"LINER": {"density": 7000.0}, "A": {}})
    assert np.all(material.young == 80e9) and material.density.tolist() == [2700.0, 7000.0, 2700.0]
    assert material.names() == ["A", "LINER"] and material.expansion[1] == 10.5e-6
    assert replacement_remarks(sets, {"young": 80e9, "density": None}) == [
        "young of the case replace those of the file in 2 elements of A, 1 elements of B; omit "
        "them to use those of the file"
    ]
    assert replacement_remarks(sets, {"young": None}) == []
    one = material_of(sets, 3, IRON, {})
    assert one.young == 110e9 and not one.names()


def test_faults_name_set_property_unit_and_range():
    lacking = {"A": {key: ALUMINIUM[key] for key in ("young", "density")}, "B": IRON}
    sets = ElementSets({"s": np.array([0, 1])}, ["A", "A", "B"], lacking, 1e-3)
    with pytest.raises(MeshFault) as raised:
        material_of(sets, 3, {}, {}, "m.inp: ")
    text = str(raised.value)
    assert "m.inp: poisson of A: expected 0 to 0.5 1, got nothing for 2 elements" in text
    assert "materials.A.poisson" in text
    # values in SI read as those of a deck in mm
    assert "m.inp: young of A: expected 1e+08 to 1e+12 Pa, got 7.5e+16 Pa" in text
    bare = ElementSets({}, ["none", "B"], lacking)
    with pytest.raises(MeshFault, match="young of no set: .* got nothing for 1 elements; give you"):
        material_of(bare, 2, {}, {})
    with pytest.raises(MeshFault, match="materials.t: expected a set of elements of s, A, B"):
        material_of(sets, 3, IRON, {"t": {}})
    with pytest.raises(MeshFault, match="materials.A: expected a set without .* got 2 shared"):
        material_of(sets, 3, IRON, {"s": {}, "A": {}})


def halves(points, tets):
    """Material of a box whose half beyond the middle of x is iron."""
    middle = points[tets[:, :4], 0].mean(axis=1) > np.ptp(points[:, 0]) / 2
    return {key: np.where(middle, IRON[key], ALUMINIUM[key]) for key in IRON}


def test_mass_and_frequencies_by_an_independent_assembly():
    """The vector forms of scikit-fem with fields of lambda, mu and rho instead of ours."""
    points, tets = box_mesh((4, 2, 1), (80e-3, 30e-3, 20e-3))
    own = halves(points, tets)
    lame = lame_constants(own["young"], own["poisson"])
    mesh = skfem.MeshTet2(points.T.copy(), tets.T.copy())
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP2()), intorder=4)

    @skfem.BilinearForm
    def elastic(u, v, w):
        strain = sym_grad(u)
        volume = eye(w.first * trace(strain), 3)
        return ddot(volume + 2.0 * w.shear * strain, sym_grad(v))

    @skfem.BilinearForm
    def inertia(u, v, w):
        return w.density * dot(u, v)

    field = np.ones(basis.dx.shape)
    values = {"first": lame.first, "shear": lame.shear, "density": own["density"]}
    values = {key: one[:, None] * field for key, one in values.items()}
    K, M = elastic.assemble(basis, **values), inertia.assemble(basis, **values)
    reference = la.eigh(K.toarray(), M.toarray(), eigvals_only=True)
    K = stiffness(points, tets, own["young"], own["poisson"])
    M = consistent_mass(points, tets, own["density"])
    omega = la.eigh(K.toarray(), M.toarray(), eigvals_only=True)
    np.testing.assert_allclose(omega[6:], reference[6:], rtol=2e-6)  # 1e-6 of a frequency
    # half of the volume 48 cm3 of each: 0.0648 kg and 0.1728 kg
    assert M.sum() / 3 == pytest.approx(24e-6 * (2700 + 7200), rel=1e-10)
    whole = rigid_mass(points, tets, own["density"])
    assert whole[0, 0] == pytest.approx(24e-6 * (2700 + 7200), rel=1e-10)
    # centre 20 mm and 60 mm: moment m x in the rotation about z
    assert whole[1, 5] == pytest.approx(24e-6 * (2700 * 20e-3 + 7200 * 60e-3), rel=1e-10)


def lined_ring(cells=(36, 3, 2), liner=2.5e-3, wall=8e-3, bore=43e-3):
    """Ring about z whose first layer of blocks is a liner, and the rows of its elements."""
    mesh = ring_mesh(Ring(bore, bore + wall, 6e-3, 2 * np.pi, cells))
    x, y, z = mesh.points.T
    old = bore + wall * np.array([0.0, 1.0 / cells[1], 1.0])
    radius = np.hypot(x, y)
    new = np.interp(radius, old, [bore, bore + liner, bore + wall])
    points = np.stack([x * new / radius, y * new / radius, z], axis=1)
    inner = np.hypot(*points[mesh.tets[:, :4], :2].mean(axis=1).T) < bore + liner
    return points, mesh, inner


def between_plates(points, K, load):
    """Displacement of a ring between frictionless plates, with zero mean motion in its plane."""
    x, y, z = points.T
    held = np.zeros((len(points), 3), dtype=bool)
    held[:, 2] = np.isclose(np.abs(z), z.max())
    held[np.argmax(x), 1] = held[np.argmax(y), 0] = held[np.argmin(y), 0] = True
    free = np.flatnonzero(~held.ravel())
    out = np.zeros(held.size)
    out[free] = spsolve(K[free][:, free], load.ravel()[free])
    return out.reshape(-1, 3)


def lame_two_layers(radii, layers, pressure=0.0, rise=0.0):
    """Return A and B of u = A r + B/r of both layers of a long cylinder between plates.

    sigma_r = 2 (lambda + mu) A - 2 mu B/r^2 - beta is -p inside, 0 outside and continuous, as u is.
    beta is (3 lambda + 2 mu) times the free expansion under an even rise of temperature.
    """
    a, c, b = radii
    (one, two) = [lame_constants(layer["young"], layer["poisson"]) for layer in layers]
    beta, other = (
        (3 * lame.first + 2 * lame.shear) * layer["expansion"] * rise
        for lame, layer in zip((one, two), layers)
    )

    def stress(lame, r):
        return [2 * (lame.first + lame.shear), -2 * lame.shear / r**2]

    rows = np.array(
        [
            [*stress(one, a), 0, 0],
            [0, 0, *stress(two, b)],
            [*stress(one, c), *(-np.array(stress(two, c)))],
            [c, 1 / c, -c, -1 / c],
        ]
    )
    scale = np.abs(rows).max(axis=0)
    return np.linalg.solve(rows / scale, [beta - pressure, other, beta - other, 0]) / scale


def test_lined_ring_under_pressure_by_lame():
    """36 blocks around, as shipped meshes have nodes; the growth of the bore within 1 %."""
    points, mesh, inner = lined_ring()
    own = {key: np.where(inner, IRON[key], ALUMINIUM[key]) for key in IRON}
    K = stiffness(points, mesh.tets, own["young"], own["poisson"])
    load = face_load(points, mesh.faces["bore"]) * 1e7
    u = between_plates(points, K, load)
    radii = (43e-3, 45.5e-3, 51e-3)
    A, B, C, D = lame_two_layers(radii, (IRON, ALUMINIUM), 1e7)
    radius = np.hypot(*points[:, :2].T)
    radial = (u[:, :2] * points[:, :2]).sum(axis=1) / radius
    exact = np.where(radius < 45.5e-3, A * radius + B / radius, C * radius + D / radius)
    assert np.abs(radial / exact - 1).max() < 0.01
    # mean hoop stress at the bore: 2 (lambda + mu) A + 2 mu B/r^2, which jumps at the liner
    lame = lame_constants(IRON["young"], IRON["poisson"])
    hoop = 2 * (lame.first + lame.shear) * A + 2 * lame.shear * B / 43e-3**2
    stress = corner_stress(points, mesh.tets, u, own["young"], own["poisson"])
    x, y, z = points.T
    at = np.flatnonzero(np.isclose(radius, 43e-3) & (y == y.min()))
    assert nodal_stress(mesh.tets, stress, own["young"])[at, 0] == pytest.approx(hoop, rel=0.03)


def test_node_between_materials_has_the_stress_of_the_stiffer():
    """A box of two halves under the same strain: stress E eps in each, nu = 0."""
    points, tets = box_mesh((2, 1, 1), (2.0, 1.0, 1.0))
    young = np.where(points[tets[:, :4], 0].mean(axis=1) > 1.0, 2.0, 1.0)
    stress = corner_stress(points, tets, points * [0, 1, 0], young, 0.0)
    mean = nodal_stress(tets, stress, young)
    np.testing.assert_allclose(mean[:, 1], np.where(points[:, 0] < 1.0, 1.0, 2.0), atol=1e-12)


def test_materials_in_the_options_and_the_key_of_the_cache(tmp_path):
    path = tmp_path / "alu.inp"
    path.write_text(ABAQUS + "*SURFACE, NAME=skirt\nALL, S1\n*SURFACE, NAME=crown\nALL, S2\n")
    with open(path, "a") as file:
        file.write("*SURFACE, NAME=pin_bore\nALL, S3\n")
    said = []
    bare = Piston(mesh=str(path))
    with pytest.raises(MeshFault, match="young of no set: expected 1e.08 to 1e.12 Pa, got nothing"):
        read_body(bare, said.append)
    table = {"density": "2.7 g/cm^3", "young": "75 GPa", "poisson": 0.33, "expansion": "21e-6 1/K"}
    by_set = Piston(mesh=str(path), materials={"all": table})
    assert read_body(by_set, said.append).material.young == 75e9 and said == []
    assert "materials" in contents(by_set) and "materials" not in contents(bare)
    with pytest.raises(ValueError, match="young"):
        Piston(mesh=str(path), materials={"all": {"young": "75 MPa"}})


def test_materials_that_are_not_mirrored():
    points, tets = box_mesh((2, 2, 2), (2.0, 2.0, 2.0))
    points = points - 1.0
    mesh = ring_mesh(Ring(1.0, 2.0, 1.0, 1.0, (8, 1, 2)))
    middle = mesh.points[mesh.tets[:, :4]].mean(axis=1)
    for axis, mirrored in ((0, False), (2, True)):
        name = np.where(middle[:, 0] > 0, "a", "b")
        material = material_of(ElementSets(), len(mesh.tets), IRON, {})._replace(name=name)
        halved = type(mesh)(mesh.points, mesh.tets, mesh.faces, material=material)
        assert is_mirrored(mesh, axis) and is_mirrored(halved, axis) == mirrored


def deck_of(path, mesh, upper, surfaces):
    """Write an Abaqus deck of a mesh with a set `upper` of elements."""
    lines = [
        "*NODE",
        *(f"{k},{x!r},{y!r},{z!r}" for k, (x, y, z) in enumerate(mesh.points.tolist(), 1)),
    ]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=ALL")
    lines += [",".join(map(str, [k, *(row + 1)])) for k, row in enumerate(mesh.tets, 1)]
    lines += ["*ELSET, ELSET=UPPER", *(str(k + 1) for k in np.flatnonzero(upper))]
    for name in surfaces:
        lines += [f"*NSET, NSET={name}", *(str(k + 1) for k in mesh.nodes(name))]
    path.write_text("\n".join(lines) + "\n")


def test_reduced_piston_of_two_materials(coarse, tmp_path):
    """Mass by hand of volumes, frequencies as of the assembled matrices, and recovered stress."""
    folder, table = coarse
    names = ("skirt", "crown", "pin_bore")
    whole = read_body(Piston(**table["piston"] | {"mesh": str(folder / "piston.msh")}), print)
    upper = whole.points[whole.tets[:, :4], 1].mean(axis=1) > 2e-3
    deck_of(tmp_path / "piston.inp", whole, upper, names)
    iron = {"density": "7200 kg/m^3", "young": "110 GPa", "poisson": 0.26}
    own = table["piston"] | {"mesh": str(tmp_path / "piston.inp"), "tie": "rbe2", "modes": 6}
    own |= {"basis": "craig_bampton", "materials": {"upper": iron}}
    body, anatomy, properties, *_ = reduce_piston(Piston(**own), (16, 12), lambda text: None)
    volume = rigid_mass(whole.points, whole.tets, np.where(upper, 7200.0, 2700.0))[0, 0]
    assert body.mass == pytest.approx(volume, rel=1e-10)
    assert properties.rigid_mass[0, 0] == pytest.approx(volume, rel=1e-10)
    young, poisson = np.where(upper, 110e9, 75e9), np.where(upper, 0.26, 0.33)
    K = stiffness(whole.points, whole.tets, young, poisson)
    M = consistent_mass(whole.points, whole.tets, np.where(upper, 7200.0, 2700.0))
    free = np.setdiff1d(np.arange(K.shape[0]), (3 * whole.nodes("pin_bore")[:, None] + [0, 1, 2]))
    K, M = K[free][:, free].tocsc(), M[free][:, free].tocsc()
    value = np.sort(eigsh(K, 6, M, sigma=0.0, return_eigenvectors=False))
    np.testing.assert_allclose(body.omega, np.sqrt(value), rtol=1e-6)
    save(tmp_path / "body.npz", body, anatomy, properties)
    stored = load(Anatomy, tmp_path / "body.npz")
    np.testing.assert_array_equal(stored.young, young)
    assert recover(stored, np.ones(6)).peak.value > 0.0


def test_rows_of_a_part_of_a_deck(tmp_path):
    path = tmp_path / "alu.inp"
    path.write_text(DECKS["alu.inp"])
    mesh = read_mesh(path, {}, part="IRON")
    assert mesh.sets.members["IRON"].tolist() == [0] and list(mesh.sets.materials) == ["IRON"]
