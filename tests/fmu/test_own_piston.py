"""From nothing to a report of an own slipper piston in five commands, outside any checkout.

Its numbers agree with a careful run by hand. Needs the extra `mesh`.
"""

import json
import lzma
import subprocess
import sys

import h5py
import numpy as np
import pytest

from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.engine.friction import friction_pressure
from piston_cosim.master.results.file import Results

gmsh = pytest.importorskip("gmsh", reason="the extra `mesh` is not installed")
pytestmark = pytest.mark.slow

SHORT = {
    "participants.bodies.build.piston.modes": 0,
    "participants.bodies.parameters.start_crank_angle": '"-20 deg"',
    "time.stop": '"60 deg"',
}
"""Through firing, rigid: what the film is given shows without a reduction."""


def piston_cosim(folder, *words):
    call = [sys.executable, "-m", "piston_cosim", *words]
    done = subprocess.run(call, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Return a folder with the case "own"."""
    folder = tmp_path_factory.mktemp("user")
    sizes = ("--bore", "86", "--stroke", "86", "--rod", "143", "--piston", "slipper")
    assert "no faults" in piston_cosim(folder, "new", "own", *sizes)
    return folder


def run(place, name, **changes):
    """Results of the short run with other changes, by key with __ for the dots."""
    given = SHORT | {key.replace("__", "."): value for key, value in changes.items()}
    sets = [word for key, value in given.items() for word in ("--set", f"{key}={value}")]
    piston_cosim(place, "run", "own", *sets, "--no-plots", "--output", name)
    return h5py.File(place / name / "base.h5")


def friction(file):
    return file["ehd/friction_power"][:]


@pytest.fixture(scope="module")
def automatic(place):
    with run(place, "automatic") as file:
        yield file


def test_five_commands_to_a_report(place):
    """new (above), check, run, report; the first screen has what an engineer asks for."""
    assert "covered share 53.1%" in piston_cosim(place, "check", "own")
    screen = piston_cosim(place, "run", "own", "--set", "participants.bodies.build.piston.modes=20")
    for word in ("minimum film", "FMEP", "demand", "slap", "checks"):
        assert word in screen
    report = piston_cosim(place, "results", "report", "results/own/base.h5")
    assert "report" in report and (place / "report/report.html").is_file()
    with Results(place / "results/own/base.h5") as results:
        found = friction_pressure(results)
        height, time = results.series("bodies.piston_position").values, results.time
        power = results.series("ehd.friction_power").values
    work = np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(time))
    volume = np.pi * 0.043**2 * 0.086  # [m3], of the sizes given
    # the pin turns round between two rows: a parabola within 1 deg, (pi/180)^2 / 8 of the stroke
    assert found == pytest.approx(work / volume, rel=4e-5)
    assert np.ptp(height) == pytest.approx(0.086, rel=4e-5)


def test_the_automatic_mask_is_the_skirt_of_the_mesh(place, automatic):
    """An explicit mask of the same cells gives the same bits.

    They are cells whose centre lies on the skirt's mesh: two panels of half width 0.36 bores.
    """
    radius = 0.043 - 0.25e-3 * 0.086
    angle = np.radians(np.arange(64) * 360 / 64)
    inside = np.abs(radius * np.cos(angle)) < 0.36 * 0.086
    mask = np.repeat(inside[:, None], 40, axis=1).astype(int).tolist()
    with run(place, "explicit", participants__ehd__build__mask=json.dumps(mask)) as file:
        np.testing.assert_array_equal(friction(file), friction(automatic))
    everywhere = run(place, "everywhere", participants__ehd__build__mask='"none"')
    with everywhere as file:  # and it is worth something
        assert friction(file).mean() > 1.2 * friction(automatic).mean()


def test_a_profile_of_24_angles_is_a_dense_one(place):
    """A measured shape at 24 angles agrees to 5 % with one at 180 angles.

    Splines through cos 2 theta at 24 angles are 0.01 um off.
    """
    tree = read_tree(place / "own/case.toml")
    given = tree["participants"]["bodies"]["parameters"]
    barrel, ovality = (float(given[name].split()[0]) for name in ("barrel", "ovality"))
    found = []
    for count in (24, 180):
        angle = np.arange(count) * 360.0 / count
        height = np.linspace(-27.52, 13.76, 31)
        along = barrel * ((height - height.mean()) / (np.ptp(height) / 2)) ** 2
        around = ovality / 4 * (1 + np.cos(np.radians(2 * angle)))
        rows = ["height," + ",".join(f"{one:.9g}" for one in angle)]
        rows += [
            f"{at:.9g}," + ",".join(f"{drop + more:.9g}" for more in around)
            for at, drop in zip(height, along)
        ]
        (place / "own" / f"profile{count}.csv").write_text("\n".join(rows) + "\n")
        shape = f'[{{ file = "profile{count}.csv", angle_unit = "1 deg", height_unit = "1 mm", '
        shape += 'value_unit = "1 um" }]'
        with run(
            place,
            f"profile{count}",
            participants__bodies__build__piston__profiles=shape,
            participants__bodies__parameters__barrel='"0 um"',
            participants__bodies__parameters__ovality='"0 um"',
        ) as file:
            found.append([friction(file).mean(), file["ehd/maximum_pressure"][:].max()])
    few, dense = np.array(found)
    assert few == pytest.approx(dense, rel=0.05)


@pytest.mark.parametrize("ending", ["msh", "inp", "bdf"])
def test_gmshs_own_decks_give_the_same_run(place, automatic, ending):
    """Meshes as .msh and .inp give the same run to round-off, and as .bdf to 1e-5.

    A .bdf has ten decimals of a metre, 5e-11 m of gaps of 20 um.
    """
    plain = place / "piston.msh"
    plain.write_bytes(lzma.decompress((place / "own/piston.msh.xz").read_bytes()))
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(str(plain))
    gmsh.option.setNumber("Mesh.BdfFieldFormat", 2)
    gmsh.write(str(place / "own" / f"deck.{ending}"))
    gmsh.finalize()
    changes = dict(participants__bodies__build__piston__mesh=f'"deck.{ending}"')
    if ending == "bdf":  # names no surfaces
        surfaces = {
            "skirt": '{ shape = "cylinder", radius = "42.9785 mm", lower = "-27.52 mm", '
            'upper = "13.76 mm" }',
            "crown": '{ shape = "plane", height = "30.96 mm" }',
            "pin_bore": '{ shape = "bore", radius = "10.75 mm" }',
        }
        text = ", ".join(f"{name} = {one}" for name, one in surfaces.items())
        changes["participants__bodies__build__piston__surfaces"] = f"{{ {text} }}"
    with run(place, ending, **changes) as file:
        tolerance = 1e-5 if ending == "bdf" else 1e-10
        np.testing.assert_allclose(friction(file), friction(automatic), rtol=tolerance)
