"""The offline part: options, cache, interpolation, splines."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.build import prepare, reduced_bodies
from piston_cosim.fmu_mfbd.dynamics.build_options import BoreGrid, BuildOptions
from piston_cosim.fmu_mfbd.finite_elements.mesh import read_mesh
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.geometry.modal_field import modal_field, read, spread
from piston_cosim.fmu_mfbd.offline import reduce
from piston_cosim.fmu_mfbd.reduction import store
from piston_cosim.fmu_mfbd.reduction.interpolation import covered, interpolation
from piston_cosim.master.fmi.errors import BadInput

from ..command import script
from .conftest import quiet
from .pin_models import crank_options, options


def test_all_faults_of_the_table_at_once(coarse):
    folder, options = coarse
    wrong = {
        "grid": [16, 2],
        "piston": options["piston"]
        | {"mesh": "none.msh", "yung": "3 GPa", "density": "-2700 kg/m^3"},
        "block": options["block"] | {"young": "75 mm", "basis": "guyan"},
    }
    with pytest.raises(BadInput) as caught:
        prepare(wrong, folder, print)
    text = "\n".join(caught.value.faults)
    for piece in (
        "grid.1: expected a value of at least 4, got 2",
        "piston.density: expected a value of at least 500 kg/m^3, got '-2700 kg/m^3'",
        "got unknown key 'yung'; did you mean 'young'?",
        "block.young: expected a quantity in Pa, got '75 mm'",
        "block.basis: expected one of",
        "got unknown choice 'guyan'",
    ):
        assert piece in text, text
    assert len(caught.value.faults) == 5


def test_all_contradictions_of_a_table_at_once(tmp_path):
    sheet = {"mass": "1 kg", "centre": ["0 mm", "9 mm"], "inertia": "3 g m^2", "radius": "40 mm"}
    piston = {"rigid": sheet, "skirt_lower": "-20 mm", "modes": 3, "train_on": "film.h5"}
    block = {"rigid": {"radius": "40 mm"}, "bore_lower": "60 mm", "bore_upper": "200 mm"}
    with pytest.raises(BadInput) as caught:
        prepare({"piston": piston, "block": block}, tmp_path, print)
    assert caught.value.faults == [
        "piston.skirt_upper: expected a value for a rigid body, got nothing",
        "piston.modes: expected 0 for a rigid body, got 3",
        "piston.train_on: expected it with basis = 'trained' only, got one of both",
    ]


def test_reduction_is_cached_by_content(coarse, tmp_path, monkeypatch):
    folder, options = coarse
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    small = options | {
        "piston": options["piston"] | {"modes": 4},
        "block": options["block"] | {"modes": 3},
    }
    said = []
    first = prepare(small, folder, said.append)[1]
    assert said
    said.clear()
    assert prepare(small, folder, said.append)[1] == first and not said
    offset = small | {"piston": small["piston"] | {"pin_offset": "0.7 mm"}}
    moved = prepare(offset, folder, said.append)[1]
    assert moved[0] != first[0] and moved[1:] == first[1:] and not said
    with pytest.raises(
        BadInput, match=r"expected an axis within 1\.4 mm of pin_offset = 7 mm, got"
    ):
        prepare(small | {"piston": small["piston"] | {"pin_offset": "7 mm"}}, folder, said.append)
    assert prepare(small | {"grid": [16, 10]}, folder, said.append)[1] != first and said
    assert not list(tmp_path.rglob("*partial*"))


def test_interpolation_reproduces_smooth_fields(bodies):
    mesh = read_mesh(bodies[0] / "piston.msh", {"skirt": None})
    angle, height = cell_centres(40, 30, -16e-3, 8e-3)
    N = interpolation(mesh.points, mesh.faces["skirt"], angle, height, 28e-3)
    np.testing.assert_allclose(N.sum(axis=1), 1.0, atol=1e-13)
    turn = np.arctan2(mesh.points[:, 0], mesh.points[:, 2])
    field = np.cos(3 * turn) * (1 + 40 * mesh.points[:, 1])
    wanted = np.cos(3 * angle)[:, None] * (1 + 40 * height)
    # quadratic interpolation over elements of 15 degrees: (3 pi/12)^3/ (9 sqrt 3 * 8) of the
    # amplitude 1.4
    np.testing.assert_allclose((N @ field).reshape(40, 30), wanted, atol=6e-3)


def test_a_point_in_a_hole_reads_the_nearest_edge():
    """A sheet on a cylinder of radius 1 with a narrow slot; the field is the angle."""
    turn, height = (line.ravel() for line in np.meshgrid(0.1 * np.arange(7), np.arange(7.0)))
    points = np.stack([np.sin(turn), height, np.cos(turn)], axis=1)
    triangles = []
    for row, column in np.argwhere(np.ones((6, 6), dtype=bool)):
        if not (column == 2 and 1 <= row < 5):
            low = 7 * row + column
            triangles += [[low, low + 1, low + 8], [low, low + 8, low + 7]]
    at = np.array([0.15, 0.2005, 0.24, 0.26]), np.array([0.5, 3.0])
    reading = interpolation(points, np.array(triangles), *at, 1.0)
    wanted = [[0.15, 0.15], [0.2005, 0.2], [0.24, 0.2], [0.26, 0.3]]
    np.testing.assert_allclose((reading @ turn).reshape(4, 2), wanted, atol=1e-12)
    there = covered(points, np.array(triangles), *at, 1.0)
    assert there.tolist() == [[True, True], [True, True], [True, False], [True, False]]


def test_folding_by_symmetry_changes_nothing():
    """Values that have the symmetry of their classes read the same folded and unfolded."""
    rng = np.random.default_rng(1)
    kind = np.tile([0, 1, 2, 3], 4)
    folded = modal_field(rng.standard_normal((12, 4, 16)), kind)
    values = np.stack([read(folded, 0, 4, unit).T for unit in np.eye(16)], axis=-1)
    plain = modal_field(values)
    q, force = rng.standard_normal(16), rng.standard_normal((4, 12))
    np.testing.assert_allclose(read(plain, 0, 4, q), read(folded, 0, 4, q), atol=1e-14)
    np.testing.assert_allclose(spread(plain, 0, force), spread(folded, 0, force), atol=1e-13)
    assert folded.table.size * 4 == plain.table.size * 4 / 3  # 4 of 12 angles stand for all


def test_modes_of_a_symmetric_body_are_even_or_odd():
    """A tube whose elements mirror has symmetry classes and orthonormal modes.

    The small piston, whose elements do not mirror, has no classes.
    """
    from piston_cosim.fmu_mfbd.finite_elements.element import consistent_mass, stiffness
    from piston_cosim.fmu_mfbd.reduction.bases import (
        Elastic,
        Modes,
        craig_bampton,
        orthonormal_modes,
    )
    from piston_cosim.fmu_mfbd.reduction.symmetry import class_parts, symmetric_modes
    from piston_cosim.tests.verification.cases.bodies import box_mesh

    points, tets = box_mesh((2, 3, 2), (0.02, 0.05, 0.03))
    for axis in (0, 2):
        image = points.copy()
        image[:, axis] *= -1
        tets = np.vstack([tets, len(points) + tets[:, [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]])
        points, place = np.unique(
            np.round(np.vstack([points, image]), 12) + 0.0, axis=0, return_inverse=True
        )
        tets = place.ravel()[tets]
    M = consistent_mass(points, tets, 2700.0)
    body = Elastic(stiffness(points, tets, 7e10, 0.3), M, np.flatnonzero(points[:, 1] == 0.0))
    modes, omega = orthonormal_modes(body, craig_bampton(body, 10))
    whole = Modes(body.full(modes), omega)
    pure, frequency, kind = symmetric_modes(body, whole, points)
    np.testing.assert_allclose(frequency, omega, rtol=1e-8)
    assert set(kind) >= {0, 1, 2}
    parts = np.stack(class_parts(pure.reshape(len(points), 3, -1), points))
    for k, c in enumerate(kind):
        others = np.delete(np.arange(4), c)
        assert np.abs(parts[others, :, :, k]).max() <= 1e-12 * np.abs(parts[c, :, :, k]).max()
    assert (symmetric_modes(body, whole, points + [1e-3, 0, 0]).kind == -1).all()


def test_a_body_already_reduced(coarse, tmp_path, monkeypatch):
    """One file holds all: the FMU built of it is that of its mesh, reports need nothing else."""
    folder, options = coarse
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "cache"))
    small = options | {
        "piston": options["piston"] | {"modes": 4},
        "block": options["block"] | {"modes": 3},
    }
    made = reduced_bodies(small, folder, quiet)["piston"]
    (tmp_path / "own.npz").write_bytes(made.read_bytes())

    def of_file(name):
        return small | {"piston": {"reduced": str(tmp_path / name)}}

    resolved, files = prepare(of_file("own.npz"), folder, quiet)
    assert files == prepare(small, folder, quiet)[1] and resolved["piston"]["modes"] == 4
    assert "shapes" in np.load(reduced_bodies(of_file("own.npz"), folder, quiet)["piston"])
    assert "shapes" not in np.load(files[0])
    with np.load(tmp_path / "own.npz") as new:
        np.savez(tmp_path / "old.npz", **{name: new[name] for name in new if name != "skirt"})
    np.savez(tmp_path / "poor.npz", mass=1.0)
    for table, words in (
        (of_file("own.npz") | {"grid": [12, 12]}, r"expected 144 rows of .* in own\.npz, got"),
        (of_file("old.npz"), r"reduced: expected skirt in old\.npz, got nothing; run"),
        (
            small | {"piston": {"reduced": str(tmp_path / "own.npz"), "modes": 0}},
            r"piston\.modes: expected 4, the number in own\.npz, got 0",
        ),
        (
            small | {"piston": {"reduced": str(tmp_path / "own.npz"), "basis": "trained"}},
            r"piston\.basis: expected nothing with reduced, got a value",
        ),
        (of_file("poor.npz"), r"piston\.reduced: expected S, I0, .* in poor\.npz, got nothing"),
        (small | {"piston": {"modes": 3}}, "piston: expected one of mesh, reduced and rigid, got"),
    ):
        with pytest.raises(BadInput, match=words):
            prepare(table, folder, quiet)
    (tmp_path / "slim.npz").write_bytes(files[0].read_bytes())
    words = r"reduced: expected points, tets, skin, shapes.* in slim\.npz, got"
    with pytest.raises(BadInput, match=words):
        reduce(of_file("slim.npz"), folder, tmp_path, quiet)


def test_build_options_come_back_from_json_and_defaults_are_left_out():
    plain = options(True)
    pin = replace(plain.floating_pin, pin_shapes=3, small_end="eye.npz", small_end_modes=9)
    block = replace(plain.block, bore_from_outside=BoreGrid(12, 20))
    crank = crank_options(("big_end", "main_bearing")).crank_bearings
    built = replace(plain, block=block, floating_pin=pin, crank_bearings=crank, mounted=True)
    assert BuildOptions.from_json(built.to_json()) == built
    content = plain.to_json()
    assert content.keys() == {"grid", "piston", "block", "floating_pin"}
    assert content["floating_pin"].keys() == {"grid", "boss_length", "small_end_length"}
    assert content["block"].keys() == {"file", "modes"}
    content["piston"] |= {"profiles": []}
    assert BuildOptions.from_json(content) == plain


def test_what_an_fmu_runs_needs_no_library_of_the_offline_part():
    """The FMU's host has numpy, scipy and numba only."""
    code = (
        "import sys, piston_cosim.fmu_mfbd.slave\n"
        "print({'skfem', 'meshio', 'matplotlib', 'pydantic'} & set(sys.modules))"
    )
    assert script(code).strip() == "set()"


def test_bodies_that_are_kept_are_found_without_what_reduces_them():
    """scipy and scikit-fem take a quarter of a start."""
    code = "import sys, piston_cosim.fmu_mfbd.build\nprint({'skfem', 'scipy'} & set(sys.modules))"
    assert script(code).strip() == "set()"


def test_whoever_changes_how_bodies_are_reduced_gets_new_ones(tmp_path, monkeypatch):
    part = tmp_path / "fmu_mfbd"
    for room in store.SOURCES:
        shutil.copytree(Path(store.__file__).parents[1] / room, part / room)
    shipped = store.code_digest.__wrapped__()
    monkeypatch.setattr(store, "__file__", str(part / "reduction" / "store.py"))
    assert store.code_digest.__wrapped__() == shipped
    for room in store.SOURCES:
        before = store.code_digest.__wrapped__()
        (part / room / "__init__.py").write_text("CHANGED = 1\n")
        assert store.code_digest.__wrapped__() != before
