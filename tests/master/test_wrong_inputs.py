"""Wrong inputs of the command line and of files.

Each ends at once with exit code 2. Its messages name the key, the expected value and the given
value in plain words. No existing file is lost.
"""

import re
import shlex
import shutil
import sys
import time
import zipfile
from pathlib import Path

import h5py
import pytest

import piston_cosim as pc
from piston_cosim.master.case.reading import find_case
from piston_cosim.master.commands.app import main

LONGEST = 5.0
"""Processor time of one wrong input [s]."""
MOST_WORDS = 25
"""Words of a message."""
FORM = re.compile(r"\S.*?: expected .*\S, got \S.*")
FOREIGN = re.compile(
    "Traceback|pydantic|Input should|Errno|zipfile|h5py|HDF5|tomllib|ValidationError|Value error|"
    "KeyError|OSError|Exception|NoneType|could not convert|invalid literal|Field required|utf-8|"
    "codec|yclopts|nable to|dictionary|JSONDecode|Expecting|<class"
)
"""Words of other programs."""
KEPT = ("kept.csv", "kept.fmu", "kept.ssp", "kept.json", "kept/kept.txt")
"""Files that exist before and stay the same."""
CASE = "data_sheet"
SET = [
    "radius=1 mm",
    "pictures.0.tile=x",
    "crank_speed=1e9 rpm",
    "crank_free=0.5",
    "participants.ehd.build.grid=[42, 40]",
    "participants.ehd.build.oil=olive",
    "participants.ehd.build.mask=no.csv",
    "participants.ehd.build.inputs=['viscosity']",
    "time.stop=-1 deg",
    "time.angular_speed=bodies.speed",
    "coupling.order=['ehd']",
    "wires.0.tolerance=1 kg",
    "wires.1.to=ehd.film_thickness",
    "record.every=0",
    "record.every=0 deg",
    "record.every=4 bar",
    "summary.minimum_film_thickness_m=least ehd.pressure",
    "summary.minimum_film_thickness_m=min ehd.pressure",
    "pictures.0.kind=pie",
    "pictures.0.time=24",
    "pictures.0.file=../x.png",
    "participants.ehd.package=fmu_oil",
    "viscosity=[1]",
    "time.step=3",
    "wires.0.tolerance=-1 nm",
    "native=['film']",
    "native=3",
    "coupling.step_control=mine",
    "participants.ehd.fmu=film.fmu",
    "participants.ehd.timeout=0 s",
    "participants.ehd.role=[1]",
    "beside=['x']",
]
"""Changes of the shipped data sheet that `run` rejects."""
CHECK = [
    "rod_length=60 mm",
    "rod_centre=300 mm",
    "skirt_length=80 mm",
    "skirt_lower=40 mm",
    "bore_upper=200 mm",
    "gas.file=no.csv",
    "piston.modes=20",
    "pressure_lower_edge=-1 bar",
]
"""Changes of it that `check` rejects."""
COMMANDS = [
    "run data_sheet --only flexible",
    "run data_sheet --plots perhaps",
    "fmu check no.fmu",
    "results plott",
    "verify rings",
    "new e --bore 86 --stroke 86 --rod 143 --mesh no.msh",
    "run data_sheet --lubrication text.fmu",
    "run data_sheet --lubrication engine=text.fmu",
    "run data_sheet --bodies folder",
    "run data_sheet --output kept.csv",
    "run data_sheet --summary-json kept.csv/s.json",
    "run data_sheet --output",
    "resume folder",
    "new e --bore 86 --stroke 86 --rod 143 --mesh text.msh",
    "new e --bore 86 --stroke 86 --rod 143 --step no.step",
    "new e --bore 86 --stroke 86 --rod 143 --step a.step --piston full",
    "check folder --pictur x.png",
    "sweep data_sheet --vary 'radial_clearance=1um;2 kg'",
    "sweep data_sheet --vary 'radial_clearance=1um;2um' --workers many",
    "sweep data_sheet --vary 'radial_clearance=1um;2um' --time-limit soon",
    "sweep data_sheet --vary 'radial_clearance=20um;30um' --workers 0",
    "reduce two_mass_oscillator",
    "run data_sheet --lubrication jof",
    "run data_sheet --lubrication jfo --lubrication jfo",
    "results plot",
    "results plot good.h5 --format bmp",
    "results report good.h5 --measured text.csv",
    "results report good.h5 --measured words.csv",
    "results movie good.h5 --field ehd.pressure",
    "results scalars good.h5 --output folder",
    "results scalars other.h5 --output kept.csv",
    "results fields good.h5 --field left.pressure --output f.csv",
    "results fields good.h5 --field left.x --output f.txt",
    "results snapshot good.h5 --participant left --time '9 s' --output kept.json",
    "results snapshot good.h5 --participant left --time 'nan s' --output kept.json",
    "results snapshot good.h5 --participant left --time '24 deg' --output kept.json",
    "results snapshot good.h5 --participant left --time 'max left.disp' --output kept.json",
    "results recover good.h5 --time '1 ms'",
    "results noise good.h5",
    "fmu build ehd --grid 2x2",
    "fmu build ehd --grid axb",
    "fmu build ehd --native --platform amiga",
    "fmu export data_sheet --output kept.ssp --set viscosity=1",
    "fmu export data_sheet --output kept.ssp --native",
    "fmu export two_mass_oscillator --output kept.fmu",
    "fmu build no.py:Film --output kept.fmu",
    "fmu build text.py:Film --output kept.fmu",
    "fmu info zip.fmu",
]
"""Calls. The folder holds files of other content, see `elsewhere`."""
NEW = "new e --bore 86 --stroke 86 --rod 143"
SHEET = "run data_sheet --no-plots --set"
VARY = "sweep data_sheet --vary"
SAID = {
    f"{SHEET} nothing": "--set: expected KEY=VALUE, got 'nothing'",
    f"{SHEET} viscosty=1": "viscosty: expected a key of the case, got",
    f"{SHEET} modes=3": "modes: expected a dotted path, got a name",
    f"{SHEET} participants.bodie.role=x": "role: expected a table participants.bodie in",
    f"{SHEET} participants.bodies.parameters.barel=1": "got unknown parameter or input 'barel'",
    f"{SHEET} participants.bodies.build.piston.mods=3": "mods: expected one of mesh_unit, axes,",
    f"{SHEET} participants.ehd.build.oill=x": "oill: expected one of grid, surface,",
    f"{SHEET} coupling.metod=newton": "metod: expected one of method,",
    f"{SHEET} wires.7.tolerance=1": "expected a table wires.7 in the case, got nothing",
    f"{SHEET} viscosity='12 bar'": "viscosity: expected a quantity in Pa.s, got '12 bar'",
    f"{SHEET} bore_radius='2 km'": "bore_radius: expected 0.001 to 1 m, got 2 km",
    f"{SHEET} wires.0.from=bodies.film": "expected one of bodies.film_thickness,",
    f"{SHEET} pictures.0.x=bodies.crank_angl": "png: expected one of bodies.film_thickness,",
    f"{SHEET} time.stop='7 bar'": "time.stop: expected a quantity in rad, got '7 bar'",
    f"{SHEET} time.until_periodic=-1": "until_periodic: expected a value of at least 0,",
    f"{SHEET} time.until_periodic=abc": "until_periodic: expected a number, got 'abc'",
    f"{SHEET} coupling.windows=2": "coupling.windows: expected in coupling.advanced, got",
    "run data_shet": "expected a file, a folder with case.toml or the name of a case",
    "keys viscousity": "expected a word of a key, got 'viscousity'; did you mean 'viscosity'",
    "study numerical_example mode": "study: expected one of modes, choice, grid,",
    f"{VARY} crank_speed=1rpm..2:2": "give both ends in units of one kind",
    f"{VARY} crank_speed": "expected KEY=LOW..HIGH:COUNT or",
    f"{VARY} crank_speed=1rpm..2rpm:1": "expected 2 to 100000 values in a range, got 1",
    "results plot no.h5": "no.h5: expected a results file, got no such file",
    "results plot text.h5": "text.h5: expected the results file of a run, got another file",
    "results report good.h5 --measured falling.csv": "expected rising numbers in the first column",
    "results report good.h5 --measured no.csv": "no.csv: expected an existing file, got no such",
    "results movie good.h5": "--field: expected no name, got nothing",
    "results movie good.h5 --output m.avi": "expected a file *.gif or *.pvd, got 'm.avi'",
    "results movie good.h5 --frames 1": "--frames: expected at least 2, got 1",
    "fmu build engine": "got unknown participant 'engine'",
    "resume no.h5.checkpoint": "expected an existing file, got no such file",
    "resume text.h5.checkpoint": "expected a checkpoint of this version, got another file",
    "new kept --bore 86 --stroke 86 --rod 143": "expected a new or empty folder, got an",
    "new e": "expected a value in mm, got nothing",
    "new e --bore 86 --stroke 86 --rod 44": "expected more than 45.15 mm, 1.05 times",
    "new e --bore '86 kg' --stroke 86 --rod 143": "expected 20 to 600 mm, got '86 kg'",
    "new e --bore nan --stroke 86 --rod 143": "expected 20 to 600 mm, got 'nan'",
    f"{NEW} --compression 1": "expected 2 to 30, got '1'",
    f"{NEW} --skirt-above 50": "expected less than the compression height,",
    f"{NEW} --rod-centre 150": "expected less than the rod, 143 mm, got 150",
    f"{NEW} --peak-pressure 10": "expected 21.8 bar of compression to 873 bar",  # 10.5^1.33 - 1
    f"{NEW} --peak-pressure '6 m'": "--peak-pressure: expected 0.1 to 500 bar, got '6 m'",
}
"""Calls, and a part of what is said of them."""
FILES = ["title = ", "", "a = 1", b"\xff\xfe\x00", "title = 3", "[time]\nstop = 1", "wires = 3"]
"""Contents of a case file."""
CALLS = [
    *(["run", CASE, "--no-plots", "--set", change] for change in SET),
    *(["check", CASE, "--picture", "x.png", "--set", change] for change in CHECK),
    *map(shlex.split, COMMANDS),
]


def faults_of_call(arguments, monkeypatch, capsys):
    """Return the messages of a call that ends with exit code 2, checked for their form."""
    monkeypatch.setattr(sys, "argv", ["piston-cosim", *arguments])
    begin = time.process_time()
    with pytest.raises(SystemExit) as ended:
        main()
    assert time.process_time() - begin < LONGEST
    printed = capsys.readouterr().err
    assert ended.value.code == 2, printed
    faults = [line.strip()[2:] for line in printed.splitlines() if line.startswith("  - ")]
    assert faults and not FOREIGN.search(printed), printed
    for fault in faults:
        assert FORM.fullmatch(fault), fault
        assert len(fault.split()) <= MOST_WORDS, fault
    return faults


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Folder with files of other content, and with the results of a short run."""
    folder = tmp_path_factory.mktemp("files")
    names = "text.h5 text.fmu text.toml text.msh text.csv text.py text.h5.checkpoint"
    for name in names.split():
        (folder / name).write_text("no such content\n")
    for name in ("folder", "kept"):
        (folder / name).mkdir()
    for name in KEPT:
        (folder / name).write_text("kept")
    head = "left.displacement [m],right.displacement [m]\n"
    (folder / "falling.csv").write_text(f"{head}1,1\n0,2\n")
    (folder / "words.csv").write_text(f"{head}1,a\n2,b\n")
    with zipfile.ZipFile(folder / "zip.fmu", "w") as archive:
        archive.writestr("a.txt", "b")
    with h5py.File(folder / "other.h5", "w") as file:
        file["x"] = [1.0, 2.0]
    run = pc.open_case("two_mass_oscillator", {"time.stop": "0.05 s"}).run()
    shutil.copy(run.path, folder / "good.h5")
    return folder


@pytest.fixture(autouse=True)
def elsewhere(files, monkeypatch):
    monkeypatch.chdir(files)
    monkeypatch.setenv("COLUMNS", "200")


@pytest.mark.parametrize("arguments", CALLS, ids=lambda one: " ".join(one)[-60:])
def test_wrong_calls(arguments, monkeypatch, capsys):
    faults_of_call(arguments, monkeypatch, capsys)
    assert all(Path(name).read_text() == "kept" for name in KEPT)


@pytest.mark.parametrize("call", SAID)
def test_wrong_calls_are_told_by_their_key(call, monkeypatch, capsys):
    faults = faults_of_call(shlex.split(call), monkeypatch, capsys)
    assert any(SAID[call] in fault for fault in faults), faults


def test_faults_of_all_layers_at_once(monkeypatch, capsys):
    words = ["run", "numerical_example", "--set", "coupling.method=nwton", "--set", "time.stop=3"]
    words += ["--set", "participants.ehd.parameters.viscosity=20 um"]
    faults = faults_of_call(words, monkeypatch, capsys)
    assert len(faults) == 3
    assert any("got unknown method 'nwton'; did you mean 'newton'?" in fault for fault in faults)
    unknown_key = [*words, "--set", "viscosty=1 Pa s"]
    assert len(faults_of_call(unknown_key, monkeypatch, capsys)) == 4


@pytest.mark.parametrize("text", FILES)
def test_wrong_case_files(text, tmp_path, monkeypatch, capsys):
    (tmp_path / "case.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    faults_of_call(["check", str(tmp_path)], monkeypatch, capsys)


@pytest.mark.parametrize(
    "name, text",
    [
        ("piston.msh", "no mesh"),
        ("piston.msh", ""),
        ("gas_pressure.csv", "angle,pressure\na,b\n"),
        ("gas_pressure.csv", ""),
        ("gas_pressure.csv", "0,1\n10,2\n5,3\n"),
        ("gas_pressure.csv", "0,1\n10,nan\n"),
        ("skirt_profile.csv", "0,1,2\n"),
    ],
)
def test_wrong_files_of_a_case(name, text, tmp_path, monkeypatch, capsys):
    folder = find_case("fired_motorcycle").parent
    for file in ("block.msh.xz", "gas_pressure.csv", "skirt_profile.csv"):
        shutil.copy(folder / file, tmp_path)
    case = (folder / "case.toml").read_text()
    if name == "piston.msh":
        case = case.replace("piston.msh.xz", name)
    else:
        shutil.copy(folder / "piston.msh.xz", tmp_path)
    (tmp_path / "case.toml").write_text(case)
    (tmp_path / name).write_text(text)
    faults_of_call(["check", str(tmp_path)], monkeypatch, capsys)
