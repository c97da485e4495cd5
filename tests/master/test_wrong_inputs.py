"""Wrong inputs of the command line, of files and of Python.

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
    "viscosty=1 Pa s",
    "nothing",
    "=3",
    "radius=1 mm",
    "participants.bodie.role=x",
    "participants.bodies.parameters.barel=1 um",
    "participants.bodies.build.pisston.modes=3",
    "participants.bodies.build.piston.mods=3",
    "coupling.metod=newton",
    "wires.7.tolerance=1 nm",
    "wires=3",
    "time=3",
    "pictures.0.tile=x",
    "viscosity=12 bar",
    "viscosity=-1 mPa s",
    "crank_speed=1e9 rpm",
    "crank_free=0.5",
    "cavitation_model=jof",
    "participants.ehd.build.grid=[40]",
    "participants.ehd.build.grid=[2, 2]",
    "participants.ehd.build.grid=[42, 40]",
    "participants.bodies.build.grid=[3, 40]",
    "participants.ehd.build.oil=olive",
    "participants.ehd.build.oil_library=no.toml",
    "participants.ehd.build.mask=no.csv",
    "participants.ehd.build.inputs=['viscosity']",
    "time.stop=7 bar",
    "time.stop=-1 deg",
    "time.stop=720.3 deg",
    "time.angular_speed=bodies.speed",
    "coupling.method=magic",
    "coupling.order=['ehd']",
    "coupling.max_iterations=0",
    "coupling.relaxation=2",
    "wires.0.tolerance=1 kg",
    "wires.0.from=bodies.film",
    "wires.0.from=film",
    "wires.1.to=ehd.film_thickness",
    "record.every=0",
    "record.every=0 deg",
    "record.every=4 bar",
    "record.every=1 ms",
    "record.fields=['ehd.pressur']",
    "summary.minimum_film_thickness_m=least ehd.pressure",
    "summary.minimum_film_thickness_m=min ehd.pressure",
    "pictures.0.kind=pie",
    "pictures.0.time=24",
    "pictures.0.time=mean bodies.side_force",
    "pictures.0.time=max bodies.side_forc",
    "pictures.0.file=../x.png",
    "participants.ehd.package=fmu_oil",
    "viscosity=nan Pa s",
    "viscosity=",
    "viscosity=[1]",
    "gas.file=../x.csv",
    "time.start=-1 s",
    "time.until_periodic=2",
    "time.until_periodic=abc",
    "time.least_periods=0",
    "time.step=3",
    "wires.0.tolerance=-1 nm",
    "wires.0.interpolation=quadratic",
    "native=['film']",
    "native=3",
    "record.periods=0",
    "record.checkpoint_every=-1",
    "coupling.inputs=later",
    "coupling.predictor=7",
    "coupling.step_control=mine",
    "participants.ehd.isolated=1.5",
    "participants.ehd.fmu=film.fmu",
    "participants.ehd.timeout=0 s",
    "participants.ehd.role=[1]",
    "label=",
    "beside=['x']",
    "observers.mine.a=1",
    "participants.bodies.build.block.bore_from_outside=true",
    "participants.bodies.build.start=no.json",
    "participants.bodies.build.piston.rigid=3",
    "participants.bodies.build.mounted=perhaps",
    "viscosity.unit=Pa s",
]
"""Changes of the shipped data sheet that `run` rejects."""
CHECK = [
    "rod_length=60 mm",
    "rod_centre=300 mm",
    "bore_radius=50 mm",
    "skirt_length=80 mm",
    "skirt_lower=40 mm",
    "bore_upper=200 mm",
    "gas.file=no.csv",
    "gas.pressure_unit=1 mm",
    "piston.rigid.mass=0 kg",
    "piston.modes=20",
    "pressure_lower_edge=-1 bar",
]
"""Changes of it that `check` rejects."""
COMMANDS = [
    "chek data_sheet",
    "run",
    "run data_shet",
    "check no_such_folder/case.toml",
    "run data_sheet --only flexible",
    "run data_sheet --plots perhaps",
    "keys viscousity",
    "study data_sheet modes",
    "sweep data_sheet --vary radial_clearance",
    "sweep data_sheet --vary radial_clearance=1um..3s:3",
    "results plot no.h5",
    "results snapshot no.h5 --participant bodies --output s",
    "fmu check no.fmu",
    "fmu build engine",
    "results plott",
    "verify rings",
    "new e",
    "new e --bore 86 --stroke 86 --rod 40",
    "new e --bore '86 kg' --stroke 86 --rod 143",
    "new e --bor 86",
    "new e --bore 86 --stroke 86 --rod 143 --mesh no.msh",
    "run folder",
    "run data_sheet --lubrication no.fmu",
    "run data_sheet --lubrication text.fmu",
    "run data_sheet --lubrication engine=text.fmu",
    "run data_sheet --bodies folder",
    "run data_sheet --output kept.csv",
    "run data_sheet --summary-json kept.csv/s.json",
    "run data_sheet --output",
    "resume no.h5.checkpoint",
    "resume kept.h5",
    "resume text.h5.checkpoint",
    "resume folder",
    "new kept --bore 86 --stroke 86 --rod 143",
    "new e --bore nan --stroke 86 --rod 143",
    "new e --bore 86 --stroke 86 --rod 143 --piston square",
    "new e --bore 86 --stroke 86 --rod 143 --peak-pressure '5 bar'",
    "new e --bore 86 --stroke 86 --rod 143 --peak-pressure '6 m'",
    "new e --bore 86 --stroke 86 --rod 143 --mesh text.msh",
    "new e --bore 86 --stroke 86 --rod 143 --step no.step",
    "new kept.csv --bore 86 --stroke 86 --rod 143",
    "new e --bore 86 --stroke 86 --rod 143 --step a.step --piston full",
    "check folder --pictur x.png",
    "check data_sheet --picture kept.csv/x.png",
    "list all",
    "sweep data_sheet --vary radial_clearance=1um..2um:1",
    "sweep data_sheet --vary radial_clearance=1um..2um",
    "sweep data_sheet --vary '=1um;2um'",
    "sweep data_sheet --vary 'radial_clearance=1um;2 kg'",
    "sweep data_sheet --vary 'radial_clearance=1um;2um' --workers many",
    "sweep data_sheet --vary 'radial_clearance=1um;2um' --time-limit soon",
    "sweep data_sheet --vary 'radial_clearance=20um;30um' --output kept.csv",
    "sweep data_sheet --vary 'radial_clearance=20um;30um' --workers 0",
    "sweep data_sheet --vary radial_clearance=1um..2um:1000000000",
    "study numerical_example mode",
    "reduce data_sheet --output kept.csv",
    "reduce two_mass_oscillator",
    "verify ehd --output kept.csv/v.md",
    "run data_sheet --lubrication jof",
    "run data_sheet --lubrication jfo --lubrication jfo",
    "run data_sheet --lubrication a.fmu --lubrication b.fmu",
    "results plot",
    "results plot text.h5",
    "results plot folder",
    "results plot other.h5",
    "results plot good.h5 --format bmp",
    "results plot good.h5 --output kept.csv",
    "results report good.h5 --measured text.csv",
    "results report good.h5 --measured falling.csv",
    "results report good.h5 --measured no.csv",
    "results report good.h5 --measured words.csv",
    "results movie good.h5",
    "results movie good.h5 --output m.avi",
    "results movie good.h5 --frames 1",
    "results movie good.h5 --field ehd.pressure",
    "results scalars good.h5 --output kept.csv/s.csv",
    "results scalars good.h5 --output folder",
    "results scalars other.h5 --output kept.csv",
    "results fields good.h5 --field left.pressure --output f.csv",
    "results fields good.h5 --field left.x --output f.txt",
    "results fields good.h5 --field left.displacement --output kept.csv/f.csv",
    "results snapshot good.h5 --participant lef --output s.json",
    "results snapshot good.h5 --participant left --output kept.csv/s.json",
    "results snapshot good.h5 --participant left --time '9 s' --output kept.json",
    "results snapshot good.h5 --participant left --time 'nan s' --output kept.json",
    "results snapshot good.h5 --participant left --time '24 deg' --output kept.json",
    "results snapshot good.h5 --participant left --time 'max left.disp' --output kept.json",
    "results recover good.h5 --time '1 ms'",
    "results noise good.h5",
    "results compare good.h5",
    "results compare good.h5 --period '3 kg'",
    "results compare good.h5 --period '9 s'",
    "fmu build ehd --fmi 4.0",
    "fmu build ehd --grid 2x2",
    "fmu build ehd --grid axb",
    "fmu build ehd --native --platform amiga",
    "fmu build ehd --output kept.csv/x.fmu",
    "fmu export data_sheet",
    "fmu export data_sheet --output kept.csv/x.fmu",
    "fmu export data_sheet --output kept.ssp --set viscosity=1",
    "fmu export data_sheet --output kept.ssp --native",
    "fmu export two_mass_oscillator --output kept.fmu",
    "fmu build no.py:Film --output kept.fmu",
    "fmu build text.py:Film --output kept.fmu",
    "fmu info text.fmu",
    "fmu info folder",
    "fmu info zip.fmu",
]
"""Calls. The folder holds files of other content, see `elsewhere`."""
FILES = ["title = ", "", "a = 1", b"\xff\xfe\x00", "title = 3", "[time]\nstop = 1", "wires = 3"]
"""Contents of a case file."""
CALLS = [
    *(["run", CASE, "--no-plots", "--set", change] for change in SET),
    *(["check", CASE, "--picture", "x.png", "--set", change] for change in CHECK),
    *map(shlex.split, COMMANDS),
]
PYTHON = [
    lambda: pc.open_case("data_shet"),
    lambda: pc.open_case("data_sheet", {"coupling.method": "nwton"}),
    lambda: pc.open_case("numerical_example", variant="soft"),
    lambda: pc.Film(viscosity="20 um"),
    lambda: pc.Film(surface="journal"),
    lambda: pc.open_results("no.h5"),
    lambda: pc.build_fmu("data_sheet", "engine"),
]
"""Calls of the Python interface that raise BadInput."""


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
    check_form(faults)
    assert not FOREIGN.search(printed), printed
    return faults


def check_form(faults):
    """Check the form and the length of messages."""
    assert faults
    for fault in faults:
        assert FORM.fullmatch(fault), fault
        assert len(fault.split()) <= MOST_WORDS, fault
        assert not FOREIGN.search(fault), fault


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


@pytest.mark.parametrize("call", PYTHON)
def test_wrong_calls_of_python(call):
    with pytest.raises(pc.BadInput) as raised:
        call()
    check_form(raised.value.faults)


def test_there_are_enough_of_them():
    assert len({str(one) for one in CALLS}) >= 60
