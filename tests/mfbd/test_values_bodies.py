"""Numbers of bodies from a mesh.

They are mass and moments of a tube, torsion of a clamped tube, and a block on springs. The
meshes are those of conftest. The piston is a tube from -16 to 20 mm, 24 to 28 mm in radius. The
block is a tube from 50 to 155 mm, 28.025 to 36 mm in radius, held at its lower end.
"""

from dataclasses import fields
from math import pi, sqrt

import meshio
import numpy as np
import pytest

from piston_cosim.fmu_mfbd.build import reduced_bodies
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedPiston
from piston_cosim.master.fmi.errors import BadInput

from .conftest import SHEET, quiet, sheets

BLOCK = dict(inner=28.025e-3, outer=36e-3, length=105e-3)


@pytest.fixture
def reduce(coarse, tmp_path, monkeypatch):
    """Return a function that reduces one of the coarse bodies with a changed table."""
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    folder, options = coarse

    def reduced(name, **changes):
        table = {"grid": options["grid"], name: options[name] | changes}
        return dict(np.load(reduced_bodies(table, folder, quiet)[name]))

    return reduced


def tube_volume(inner, outer, length):
    return pi * (outer**2 - inner**2) * length


def test_mass_moments_and_pin_offset(reduce):
    """A tube about an axis at x = -d from A has the mass and moments of the closed form.

    They are m, S = m (-d, 2 mm) and I0 = m [(R^2 + r^2)/4 + L^2/12 + (2 mm)^2 + d^2]. The tolerance
    is 1e-3: sixteen parabolas around a circle miss 5e-4 of its area.
    """
    body = reduce("piston", modes=0, skirt_lower="-15 mm", skirt_upper="7 mm", pin_offset="0.9 mm")
    parts = {part.name: body[part.name] for part in fields(ReducedPiston)}
    body = vars(ReducedPiston(**parts).about(0.9e-3))
    mass = 2700.0 * tube_volume(24e-3, 28e-3, 36e-3)
    assert body["mass"] == pytest.approx(mass, rel=1e-3)
    assert body["S"] / body["mass"] == pytest.approx(np.array([-0.9e-3, 2e-3]), abs=1e-9)
    turned = (28e-3**2 + 24e-3**2) / 4.0 + 36e-3**2 / 12.0 + 2e-3**2 + 0.9e-3**2
    assert body["I0"] / body["mass"] == pytest.approx(turned, rel=1e-3)
    assert body["skirt_lower"] == -15e-3 and body["skirt_upper"] == 7e-3
    assert body["radius"] == pytest.approx(28e-3, rel=1e-9)


def test_a_mesh_in_other_axes_and_units(reduce, coarse):
    """All moments are independent of the axes, origin and units of the file.

    In the file thrust is +y, head -x and pin +z. Lengths are in mm and the origin is at (3, 5, -7)
    mm. Point (X, Y, Z) is at (3 - Y, 5 + X, -7 + Z). The tube's centre of mass is above A and to
    its side, so that a mirrored axis shows.
    """
    folder, _ = coarse
    mesh = meshio.read(folder / "piston.msh")
    x, y, z = 1e3 * mesh.points.T
    mesh.points = np.stack([3.0 - y, 5.0 + x, -7.0 + z], axis=1)
    meshio.write(folder / "turned.msh", mesh, file_format="gmsh22", binary=True)
    straight = reduce("piston", modes=0, pin_offset="0.9 mm")
    body = reduce(
        "piston",
        mesh="turned.msh",
        mesh_unit="1 mm",
        axes=["y", "-x", "z"],
        origin=["3 mm", "5 mm", "-7 mm"],
        modes=0,
        pin_offset="0.9 mm",
    )
    for key in ("mass", "S", "I0", "skirt_lower", "skirt_upper"):
        np.testing.assert_allclose(body[key], straight[key], rtol=1e-9, atol=1e-12)


def frequencies_of_torsion(body):
    """Frequencies [Hz] of the modes that move no point of the bore radially or axially."""
    moved = np.abs(body["radial"]).max(axis=(0, 1)) + np.abs(body["axial"]).max(axis=(0, 1))
    return body["omega"][moved < 1e-2 * moved.max()] / (2.0 * pi)


@pytest.mark.parametrize("young, poisson, density", [(75e9, 0.33, 2700.0), (120e9, 0.1, 4100.0)])
def test_torsion_of_a_clamped_tube(reduce, young, poisson, density):
    """The frequency f = sqrt(G/rho)/(4 L), G = E/[2 (1 + nu)], is exact for a circular tube.

    The tube is clamped at one end. The tolerance is 5e-3 for four quadratic elements along a
    quarter wave and sixteen around.
    """
    body = reduce(
        "block",
        basis="craig_bampton",
        modes=30,
        stations=12,
        young=f"{young} Pa",
        poisson=poisson,
        density=f"{density} kg/m^3",
    )
    expected = sqrt(young / (2.0 * (1.0 + poisson)) / density) / (4.0 * BLOCK["length"])
    assert frequencies_of_torsion(body)[0] == pytest.approx(expected, rel=5e-3)


def test_bore_ends_and_stations(reduce):
    body = reduce("block", modes=0, stations=12, bore_lower="60 mm", bore_upper="148 mm")
    assert body["heights"] == pytest.approx(np.linspace(60e-3, 148e-3, 12), rel=1e-12)
    with pytest.raises(BadInput, match="bore_upper: expected within surface 'bore',"):
        reduce("block", modes=0, bore_lower="40 mm")


def sheet(tmp_path, monkeypatch, **piston):
    """Arrays of a piston of a data sheet."""
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    return dict(np.load(reduced_bodies(sheets(piston), tmp_path, quiet)["piston"]))


def test_a_data_sheet_is_a_body_without_modes(tmp_path, monkeypatch):
    """A data sheet gives S = 1.39 (1, 26.5) mm kg and I0 = 0.003 + 1.39 (1^2 + 26.5^2) mm2.

    The mass is m = 1.39 kg, the centre is at (1.5, 26.5) mm from the axis, and A is at 0.5 mm.
    """
    body = sheet(tmp_path, monkeypatch, pin_offset="0.5 mm")
    assert body["S"] == pytest.approx([1.39e-3, 36.835e-3])
    assert body["I0"] == pytest.approx(0.003 + 1.39 * 703.25e-6)
    assert (body["mass"], body["radius"]) == pytest.approx((1.39, 54.95e-3))
    assert (body["skirt_lower"], body["skirt_upper"]) == pytest.approx((-45.5e-3, 37.3e-3))
    assert body["omega"].size == body["radial"].size == 0


@pytest.mark.parametrize(
    "piston, words",
    [
        (dict(skirt_upper=None), "skirt_upper: expected a value for a rigid"),
        (dict(modes=20), "modes: expected 0 for a rigid body, got 20"),
        (dict(mesh="piston.msh"), "piston: expected one of mesh, reduced and"),
        (dict(rigid=SHEET | {"mass": "0 kg"}), "mass: expected a value above 0 kg, got '0 kg'"),
    ],
)
def test_a_data_sheet_that_is_not_whole_is_refused(piston, words, tmp_path, monkeypatch):
    with pytest.raises(BadInput, match=words):
        sheet(tmp_path, monkeypatch, **piston)
