"""The command `piston-cosim reduce` and its library.

Tests cover one body or both, files, printed lines and continuing after a stop.
"""

import csv
import re
from functools import partial

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_mfbd.finite_elements.solver import CachedFactorise, factorise
from piston_cosim.fmu_mfbd.offline import reduce

from ..command import call
from .conftest import quiet


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_one_body_from_a_small_table(coarse, cache, tmp_path):
    folder, options = coarse
    [block] = reduce({"grid": [16, 12], "block": options["block"]}, folder, tmp_path / "out", quiet)
    assert (
        block.name == "block"
        and block.degrees_of_freedom == 3 * block.nodes
        and len(block.modes) == 10
    )
    assert 0 < block.seconds < 600 and 1e7 < block.peak_memory < 1e11
    assert [file.name for file in block.files] == [
        "block.npz",
        "block-modes.csv",
        "block-modes.vtu",
        "block-modes.png",
    ]
    with open(tmp_path / "out" / "block-modes.csv") as file:
        rows = list(csv.reader(file))
    assert rows[0][1] == "frequency [Hz]" and len(rows) == 11
    assert float(rows[3][1]) == block.modes[2].frequency
    assert (tmp_path / "out" / "block-modes.png").stat().st_size > 20_000


def test_command_line(coarse, cache, tmp_path):
    folder, options = coarse
    (tmp_path / "bodies.toml").write_text(f"""grid = [16, 12]
[block]
mesh = "{folder}/block.msh"
density = "2700 kg/m^3"
young = "75 GPa"
poisson = 0.33
modes = 3
""")
    words = ("reduce", "bodies.toml")
    done = call(*words, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "degrees of freedom" in done.stdout and "results/bodies/bodies/block.npz" in done.stdout
    said = " ".join(done.stdout.split())
    assert re.search(
        r"the modes miss up to [\d.e+]+ % .* smooth pressure, [\d.e+]+ % under a", said
    )
    [block] = pc.reduce_bodies(tmp_path / "bodies.toml", tmp_path / "again", {"block.modes": 2})
    assert len(block.modes) == 2 and (tmp_path / "again" / "block.npz").is_file()
    assert f"mass {block.mass:.6g} kg" in done.stdout
    wrong = call(*words, "--set", "block.young=1 mm", folder=tmp_path)
    assert wrong.returncode == 2 and "block.young" in wrong.stderr


class Stopped(Exception):
    pass


def test_a_stopped_reduction_goes_on(coarse, cache, tmp_path, monkeypatch):
    """A reduction that stops at its twentieth solution replays these and gives the same bytes.

    It leaves no files behind.
    """
    from piston_cosim.fmu_mfbd.finite_elements import solver

    folder, options = coarse
    table, solved = {"grid": [16, 12], "block": options["block"] | {"basis": "craig_bampton"}}, []

    class Stopping:
        def __init__(self, K, limit):
            self._factors, self._limit = factorise(K), limit

        def solve(self, load):
            if len(solved) == self._limit:
                raise Stopped
            solved.append(1)
            return self._factors.solve(load)

    monkeypatch.setattr(solver, "factorise", lambda K: Stopping(K, 20))
    with pytest.raises(Stopped):
        reduce(table, folder, tmp_path / "a", quiet)
    assert len(list((cache / "bodies" / "unfinished").rglob("*.npy"))) == 20
    said = []
    monkeypatch.setattr(solver, "factorise", lambda K: Stopping(K, -1))
    reduce(table, folder, tmp_path / "a", said.append)
    assert any("continuing with 20 cached solutions" in text for text in said)
    replayed = len(solved)
    assert not list((cache / "bodies" / "unfinished").rglob("*.npy"))
    solved.clear()
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "fresh"))
    reduce(table, folder, tmp_path / "b", quiet)
    assert len(solved) == replayed
    one, other = (np.load(tmp_path / name / "block.npz") for name in "ab")
    for key in set(one) - {"seconds", "peak_memory"}:
        np.testing.assert_array_equal(one[key], other[key])


def test_solutions_are_told_apart_by_matrix_and_load(tmp_path):
    import scipy.sparse as sp

    same = partial(np.testing.assert_allclose, rtol=4 * np.finfo(float).eps)  # PARDISO rounds
    remembering = CachedFactorise(tmp_path, quiet)
    one, other = (remembering(k * sp.identity(3, format="csc")) for k in (2.0, 4.0))
    load = np.array([1.0, 2.0, 3.0])
    for _ in range(2):
        same(one.solve(load), load / 2)
        same(other.solve(load), load / 4)
        same(one.solve(2 * load), load)
    remembering.forget()
    assert not list(tmp_path.iterdir())


def test_recovery_at_an_instant(coarse, cache, tmp_path):
    """Recovery from a results file gives the shape of one mode of the block and its stresses.

    The file contains the modal coordinates.
    """
    import json

    import h5py
    import meshio

    from piston_cosim.fmu_mfbd.build import reduced_bodies
    from piston_cosim.master.case.reading import find_case, read_tree

    folder, options = coarse
    (folder / "case.toml").touch()
    tree = read_tree(find_case("numerical_example"))
    tree["participants"]["bodies"]["build"] = options
    coordinates = np.zeros((3, 22))
    coordinates[1, 12 + 1] = 1e-7
    with h5py.File(tmp_path / "run.h5", "w", libver="latest") as file:
        file.attrs.update(case=json.dumps(tree), title="")
        file["time"] = file["fields/time"] = [0.0, 1e-3, 2e-3]
        file["fields/bodies/modal_coordinate"] = coordinates
        file["fields/bodies/modal_coordinate"].attrs.update(unit="1", description="")
    words = ("results", "recover", "run.h5", "--case", folder)
    done = call(*words, "--time", "1.1 ms", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (
        "1 ms  piston: displacement up to 0 \N{MICRO SIGN}m, von Mises stress up to 0 MPa at x "
        in done.stdout
    )
    assert "mm (jump between elements 0 MPa)" in done.stdout
    shapes = np.load(reduced_bodies(options, folder, quiet)["block"])["shapes"]
    mesh = meshio.read(tmp_path / "run-1000us-block.vtu")
    np.testing.assert_allclose(mesh.point_data["displacement"], 1e-7 * shapes[:, :, 1])
    assert mesh.point_data["von_mises"].max() > 0
    wrong = call(*words, "--time", "1 kg", folder=tmp_path)
    assert wrong.returncode == 2


def test_rigid_bodies_are_named_and_left_alone(cache, tmp_path):
    """A data sheet has neither mesh nor modes: a sentence each, and nothing is written."""
    from piston_cosim.master.api.bodies import build_table
    from piston_cosim.master.case.reading import find_case, read_tree

    path = find_case("data_sheet")
    said = []
    table = build_table(read_tree(path))
    assert reduce(table, path.parent, tmp_path / "bodies", said.append) == []
    assert said == [
        f"{name}: rigid, of a data sheet; there is nothing to reduce or to recover"
        for name in ("piston", "block")
    ]
    assert not (tmp_path / "bodies").exists()


def test_ties_by_option(coarse, cache):
    """The rigid tie is stiffer than a mean over both bosses.

    Patches cannot slide on a pin, so that their default is the rigid tie.
    """
    from piston_cosim.fmu_mfbd.build import reduced_bodies

    folder, options = coarse
    piston = options["piston"] | {"modes": 6, "basis": "craig_bampton"}
    ties = (None, "rbe2", "rbe3", "sliding")
    *tables, sliding = [{"grid": [16, 12], "piston": piston | {"tie": tie}} for tie in ties]
    files = [reduced_bodies(table, folder, quiet)["piston"] for table in tables]
    default, rbe2, rbe3 = (np.load(file)["omega"] for file in files)
    assert np.all(rbe2 > rbe3) and np.array_equal(default, rbe2)
    with pytest.raises(pc.BadInput, match="'pin_bore': nodes .* set piston.tie to rbe2 or rbe3"):
        reduced_bodies(sliding, folder, quiet)
