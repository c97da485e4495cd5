"""A case from a few lengths: values by hand, marks of what is estimated, and what is refused."""

import sys
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.commands.new import Sizes, command
from piston_cosim.master.engine.measures import measures
from piston_cosim.master.engine.new import CYCLE, SIZES, engine, unusual, write_case
from piston_cosim.master.engine.piston_mesh import mesh_of_sizes, shape
from piston_cosim.master.engine.verdicts import verdicts
from piston_cosim.master.fmi.errors import BadInput

SQUARE = {"bore": "86", "stroke": "86 mm", "rod": 143}


def test_sizes_by_hand():
    made = engine(SQUARE | {"speed": "6000", "pin_offset": "-0.5"})
    assert made["bore"] == pytest.approx(0.086, rel=1e-14)
    assert made["speed"] == pytest.approx(200 * pi, rel=1e-14)
    assert made["pin_offset"] == pytest.approx(-0.5e-3, rel=1e-14)
    assert made.swept_volume == pytest.approx(pi / 4 * 0.086**3, rel=1e-14)
    assert made["mass"] == pytest.approx(500 * 0.086**3, rel=1e-14)
    assert made["rod_inertia"] == pytest.approx(made["rod_mass"] * 0.3 * 0.7 * 0.143**2, rel=1e-12)
    assert made.skirt_radius == pytest.approx(0.043 - 21.5e-6, rel=1e-12)
    assert made.top == pytest.approx(sqrt(0.186**2 - 0.5e-3**2), rel=1e-14)
    assert made.stated == {"bore", "stroke", "rod", "speed", "pin_offset"}


def test_gas_pressure_by_hand():
    motored = engine(SQUARE | {"compression": "10"}, motored=True)
    pressure = dict(zip(CYCLE, motored.gas_pressure(CYCLE)))
    assert pressure[0.0] == pytest.approx(1e5 * (10**1.33 - 1), rel=1e-12)
    assert pressure[-180.0] == pressure[-360.0] == 0.0
    assert pressure[90.0] == pytest.approx(pressure[-90.0], rel=1e-12)
    fired = engine(SQUARE, "60 bar")
    assert fired.gas_pressure(CYCLE).max() == pytest.approx(6e6, rel=1e-9)
    bare = engine(SQUARE | {"compression": "10.5"}, motored=True).gas_pressure(CYCLE)
    # nothing burns before ignition, all of it well after
    before, after = CYCLE < -8, (CYCLE > 90) & (CYCLE < 180)
    assert np.array_equal(fired.gas_pressure(CYCLE)[before], bare[before])
    gain = (fired.gas_pressure(CYCLE)[after] + 1e5) / (bare[after] + 1e5)
    assert gain == pytest.approx(1 + fired.gain, rel=1e-4)  # 1 - exp(-5 (98/60)^1.5) = 1 - 3e-5


def test_the_case_is_sound_and_marks_its_estimates(tmp_path):
    made = engine(SQUARE | {"mass": "0.35 kg"})
    seen = write_case(made, tmp_path / "own")
    assert seen.faults == []
    assert seen.figure("bodies.swept_volume").value == pytest.approx(made.swept_volume, rel=1e-5)
    text = (tmp_path / "own" / "case.toml").read_text()
    assert text.count("our estimate: ") >= 12 and "# mass: given;" in text
    tree = read_tree(tmp_path / "own" / "case.toml")
    assert tree["participants"]["bodies"]["parameters"]["crank_radius"] == "43 mm"


def test_a_diesels_gas_by_hand():
    """A supercharged charge, a lean heat release, and an exhaust without back pressure."""
    sizes = SQUARE | {"compression": 16}
    made = engine(sizes)
    assert made["intake_pressure"] == 2e5 and made["viscosity"] == 10e-3
    assert made["ovality"] == pytest.approx(1.5e-3 * 0.086, rel=1e-14)
    assert made.gain == pytest.approx(6.4 * 15 / 16**1.33, rel=1e-14)
    pressure = dict(zip(CYCLE, made.gas_pressure(CYCLE)))
    assert pressure[-360.0] == 0.0
    assert pressure[-340.0] == pytest.approx(1e5 * (1 - np.exp(-1)), rel=1e-12)
    assert pressure[-181.0] == pytest.approx(1e5, rel=2e-4)  # exp(-179/20)
    # polytrope from 2 bar absolute before the heat release at -4 deg
    before = made.volume_ratio(np.array([-5.0]))[0] ** -1.33
    assert pressure[-5.0] == pytest.approx(2e5 * before - 1e5, rel=1e-12)
    assert pressure[360.0] < 2e-4 * pressure[180.0]
    assert 10e6 < max(pressure.values()) < 15e6
    still = engine(sizes, motored=True)
    assert still["intake_pressure"] == 1e5 and still.gas_pressure(CYCLE)[0] == 0.0
    assert engine(sizes | {"intake_pressure": "3 bar"})["intake_pressure"] == 3e5


ENGINES = {
    "moped": {"bore": 52, "stroke": 52, "rod": 95, "speed": 7000},
    "motorcycle": {"bore": 79, "stroke": 71, "rod": 118, "speed": 6500},
    "car": {"bore": 86, "stroke": 86, "rod": 143, "speed": 4000},
    "diesel": {"bore": 85, "stroke": 97, "rod": 150, "speed": 3000, "compression": 16.5},
    "truck": {"bore": 130, "stroke": 158, "rod": 268, "speed": 1400, "compression": 17.5},
}
"""Engines of 0.11, 0.35, 0.50, 0.55 and 2.1 l a cylinder."""


@pytest.mark.parametrize("name", ENGINES)
def test_the_grid_of_a_new_case_has_no_warning(name, tmp_path):
    seen = write_case(engine(ENGINES[name]), tmp_path / name)
    assert (seen.faults, seen.warnings) == ([], [])
    assert [one for one in seen.remarks if "thermal growth not set" not in one] == []
    assert seen.figure("bodies.cells_around").value % 2 == 0  # a cell on the anti-thrust line


@pytest.mark.slow
@pytest.mark.parametrize("piston", [None, "slipper"])
@pytest.mark.parametrize("name", ENGINES)
def test_a_run_of_a_new_case_settles_without_a_warning(name, piston, tmp_path):
    """All checks pass, but that of a rigid skirt's pressure, which says what to do."""
    if piston:
        pytest.importorskip("gmsh")
    sizes = Sizes(**{key: str(value) for key, value in ENGINES[name].items()})
    command(tmp_path / name, sizes=sizes, piston=piston)
    path = tmp_path / name / "case.toml"
    with pc.open_case(path).run(tmp_path / "base.h5") as results:
        found = verdicts(results, measures(check_case(results.case, path), results))
    assert "periodicity" in {one.what for one in found}
    for one in found:
        stiff = one.what == "pressure" and piston is None
        assert one.outcome == "pass" or (stiff and "--piston slipper" in one.text), one.text


def test_a_mesh_brings_its_skirt(tmp_path):
    mesh = find_case("fired_motorcycle").parent / "piston.msh.xz"
    made = engine({"bore": 73, "stroke": 59.5, "rod": 108})
    seen = write_case(made, tmp_path / "own", mesh)
    assert seen.faults == []
    tree = read_tree(tmp_path / "own" / "case.toml")
    # the mesh's skirt is from -14 to 13 mm, the rule's from -23.4 to 11.7
    assert tree["participants"]["ehd"]["parameters"]["skirt_length"] == "27 mm"
    assert (tmp_path / "own" / "piston.msh.xz").is_file()


def test_the_command(tmp_path, capsys):
    command(tmp_path / "own", sizes=Sizes(bore="86", stroke="86", rod="143"))
    printed = capsys.readouterr().out
    assert "no faults" in printed and "499.56 cm^3" in printed and "piston-cosim run" in printed


@pytest.mark.parametrize(
    "given, message",
    [
        ({"compression_height": "20"}, r"expected at least 23\.97 mm for pin boss and"),
        ({"pin_diameter": "30"}, r"expected at most 27\.52 mm, 0\.32 of the"),
        ({"skirt_above": "0"}, "expected a skirt above the pin axis, got 0"),
        (
            {"skirt_above": "25"},
            r"expected less than 23\.65 mm below a ring",
        ),
    ],
)
def test_sizes_that_make_no_piston(tmp_path, given, message):
    with pytest.raises(BadInput, match=message):
        mesh_of_sizes(engine(SQUARE | given), "slipper", tmp_path / "piston.msh.xz")


def test_sizes_of_a_wrong_unit_and_a_shipped_name_are_told(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    given = {"rod": "1430", "mass": "40000", "skirt_below": "200", "bore": "86", "stroke": "86"}
    command(Path("data_sheet"), sizes=Sizes(**given))
    said = capsys.readouterr().out
    for option in ("--rod = 1430 mm", "--mass = 40000 g", "--skirt-below = 200 mm"):
        assert f"warning  {option}: our estimate is" in said
    assert "data_sheet: a shipped case has this name" in said and "4 warnings, 2 remarks" in said
    usual = {"rod": "143", "mass": "400", "skirt_below": "30", "bore": "86", "stroke": "86"}
    assert unusual(engine(usual)) == []


def test_a_diesels_slipper_has_thick_walls():
    pytest.importorskip("gmsh")
    walls = []
    for ratio in (13.9, 14):
        made = engine(SQUARE | {"compression": ratio})
        piston = shape(made, "slipper")
        walls.append(1e3 * made.skirt_radius - np.array(piston.skirt_inside))
        assert shape(made, "full").skirt_inside[0] == 1e3 * made.skirt_radius - 0.032 * 86
    assert walls[1] == pytest.approx(1.5 * walls[0], rel=1e-12)


def test_without_gmsh_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "gmsh", None)
    monkeypatch.delitem(sys.modules, "piston_cosim.models.meshes", raising=False)
    sizes = Sizes(bore="86", stroke="86", rod="143")
    with pytest.raises(BadInput, match="expected gmsh for 'slipper', got none"):
        command(tmp_path / "own", sizes=sizes, piston="slipper")
    with pytest.raises(BadInput, match="expected one source of the piston, got"):
        command(tmp_path / "own", sizes=sizes, piston="full", mesh=tmp_path / "a.msh")
    command(tmp_path / "own", sizes=sizes, piston="data-sheet")
    build = read_tree(tmp_path / "own" / "case.toml")["participants"]["bodies"]["build"]
    assert "rigid" in build["piston"]


def test_every_size_says_what_it_is():
    assert all(size.meaning and (size.words or size.rule is None) for size in SIZES.values())


def test_a_step_file_is_meshed(tmp_path):
    gmsh = pytest.importorskip("gmsh")
    occ = gmsh.model.occ
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    cup, _ = occ.cut(
        [(3, occ.addCylinder(0, -25, 0, 0, 55, 0, 42.9))],
        [(3, occ.addCylinder(0, -25, 0, 0, 48, 0, 30))],
    )
    occ.cut(cup, [(3, occ.addCylinder(0, 0, -60, 0, 0, 120, 10))])
    occ.synchronize()
    gmsh.write(str(tmp_path / "cup.step"))
    gmsh.finalize()
    command(
        tmp_path / "own",
        sizes=Sizes(bore="86", stroke="86", rod="143"),
        step=tmp_path / "cup.step",
    )
    parameters = read_tree(tmp_path / "own" / "case.toml")["participants"]["ehd"]["parameters"]
    assert parameters["skirt_length"] == "55 mm"  # a plain cup: its wall is all skirt
