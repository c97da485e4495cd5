"""Symmetry of reduced bodies about the thrust plane, and what assumes it."""

from dataclasses import replace
from types import SimpleNamespace

import meshio
import numpy as np
import pytest

from piston_cosim.fmu_mfbd.build import prepare, reduced_bodies
from piston_cosim.fmu_mfbd.dynamics.assembly import ReducedBodies
from piston_cosim.fmu_mfbd.dynamics.build_options import BuildOptions
from piston_cosim.fmu_mfbd.dynamics.half_films import half_films
from piston_cosim.fmu_mfbd.dynamics.model_faults import faults
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.dynamics.start_state import SCALARS, StartState
from piston_cosim.fmu_mfbd.preview import preview
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedBlock, ReducedPiston, load
from piston_cosim.fmu_mfbd.thrust_symmetry import (
    ODD_MODE,
    asymmetries_of_bodies,
    mirror_error,
    only_even,
)
from piston_cosim.master.fmi.errors import BadInput

from .conftest import quiet

THETA = np.radians(np.arange(0.0, 360.0, 45.0))  # 8 cells, the third one on the thrust line


def body(*modes):
    """Return modes on 8 x 2 cells with 1, 2, ... rad/s."""
    radial = np.stack([np.repeat(mode, 2) for mode in modes], axis=1)
    return SimpleNamespace(omega=np.arange(1.0, 1.0 + len(modes)), radial=radial)


def test_the_compliance_is_compared_with_its_image():
    """Eq. (J48) by hand: sin is even about 90 deg, cos is odd.

    Their sum is orthogonal to its image, so that the difference of both squares is sqrt 2.
    """
    even, odd = np.sin(THETA), np.cos(THETA)
    assert mirror_error(body(even, odd), 8) == pytest.approx(0.0, abs=1e-7)
    assert mirror_error(body(even + odd), 8) == pytest.approx(np.sqrt(2))
    assert only_even(body(even, np.cos(2 * THETA)), 8)
    assert not only_even(body(even, odd), 8)
    nearly = {"piston": body(even + 1e-4 * odd)}
    assert asymmetries_of_bodies(nearly, None, 8) == []
    assert len(asymmetries_of_bodies(nearly, None, 8, ODD_MODE)) == 1
    rigid = SimpleNamespace(omega=np.zeros(0), radial=np.zeros((16, 0)))
    assert mirror_error(rigid, 8) == 0.0 and not only_even(rigid, 8)
    skirt = np.ones((8, 2), dtype=bool)
    skirt[[1, 3], 0] = False
    assert asymmetries_of_bodies({"piston": body(even)}, skirt, 8) == []
    skirt[1, 0] = True
    (reason,) = asymmetries_of_bodies({"piston": body(even)}, skirt, 8)
    assert "openings of the skirt" in reason


@pytest.fixture
def even(coarse, kept, tmp_path):
    """Return folder and build table of bodies with symmetric modes, the piston from a file."""
    folder, options = coarse
    table = options | {name: options[name] | {"symmetric_film": True} for name in CHOSEN}
    made = reduced_bodies(table, folder, quiet)["piston"]
    (tmp_path / "piston.npz").write_bytes(made.read_bytes())
    return folder, table | {"piston": {"reduced": str(tmp_path / "piston.npz")}}


CHOSEN = ("piston", "block")


def test_a_file_of_even_modes_assumes_a_symmetric_film(even, coarse):
    """It is found from its modes, and so are a block and a mesh that are not symmetric."""
    folder, table = even
    assert prepare(table, folder, quiet)[0]["symmetric_film"] is True
    orders = {"orders": [{"order": 3, "amplitude": "2 um"}]}
    uneven = {
        r"build\.block\.orders \(odd part of": table["block"] | orders,
        r"build\.block \(mirrored loads": coarse[1]["block"],
    }
    for words, block in uneven.items():
        with pytest.raises(BadInput, match=words):
            prepare(table | {"block": block}, folder, quiet)


def test_a_mesh_that_is_not_its_mirror_image_is_rejected(even, tmp_path):
    """The tube of 16 cells is turned by 3 deg about its axis, for a check and for a reduction.

    The check also reports it if another body assumes the symmetry.
    """
    folder, table = even
    mesh = meshio.read(folder / "block.msh")
    cosine, sine = np.cos(np.radians(3.0)), np.sin(np.radians(3.0))
    mesh.points = mesh.points @ [[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]
    mesh.write(tmp_path / "turned.msh", "gmsh22", binary=False)
    turned = table | {"block": table["block"] | {"mesh": str(tmp_path / "turned.msh")}}
    with pytest.raises(BadInput, match="mesh that is its own mirror image"):
        prepare(turned, folder, quiet)
    turned["block"] = turned["block"] | {"symmetric_film": False}
    said = preview(turned, {}, folder).faults
    assert any(one.startswith("piston.reduced: ") and "block.mesh" in one for one in said)


def test_the_fmu_rejects_a_tilted_pin(even):
    """Also if an importer sets the parameter, whose case nobody checks."""
    folder, table = even
    resolved, (piston, block, *_) = prepare(table, folder, quiet)
    bodies = ReducedBodies(load(ReducedPiston, piston), load(ReducedBlock, block))
    options = BuildOptions.from_json(resolved)
    tilted = Parameters(pin_tilt=1e-4)
    said = [one for one in faults(bodies, options, tilted) if one.startswith("pin_tilt")]
    assert said == [
        "pin_tilt: expected 0 rad with modes of a symmetric film, got 0.0001 rad; use modes with "
        "symmetric_film = false"
    ]
    for given, parameters in (
        (options, Parameters()),
        (replace(options, symmetric_film=False), tilted),
    ):
        assert not any("pin_tilt" in one for one in faults(bodies, given, parameters))


def test_a_start_in_odd_modes_is_not_symmetric():
    """An odd mode with 2 rad/s, whose largest value is 1, by hand.

    A velocity of 6 nm/s has an amplitude of 3 nm. Even modes and 1 pm have no effect.
    """
    even, odd = np.sin(THETA), np.cos(THETA)
    bodies = {"piston": body(even), "block": body(even, odd)}
    still, rest = dict.fromkeys(SCALARS, 0.0), np.zeros(3)

    def reasons(coordinate, velocity):
        start = StartState(**still, modal_coordinate=coordinate, modal_velocity=velocity)
        return asymmetries_of_bodies(bodies, None, 8, start=start)

    assert reasons(np.array([1e-6, 2e-6, 1e-12]), rest) == []
    assert reasons(np.ones(2), rest) == []  # the build rejects another number of modes
    assert reasons(np.array([0, 0, 5e-9]), rest) == ["build.start (odd deflection of 5 nm)"]
    assert reasons(rest, np.array([0, 1, 6e-9])) == ["build.start (odd deflection of 3 nm)"]
    film = SimpleNamespace(skirt=SimpleNamespace(angle=THETA), bore=None)
    uneven = StartState(**still, modal_coordinate=np.array([0, 0, 5e-9]), modal_velocity=rest)
    assert half_films([film], [*bodies.values()], uneven) == ()
