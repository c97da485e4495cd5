"""Wrong inputs of the command line and of files.

Each ends at once with exit code 2. Its messages name the key, the expected value and the given
value in plain words. No existing file is lost.
"""

import re
import shlex
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import h5py
import pytest

import piston_cosim as pc
from piston_cosim.master.case.check import CheckedCase, check
from piston_cosim.master.case.reading import find_case
from piston_cosim.master.commands.app import main
from piston_cosim.master.commands.usage import faults_of
from piston_cosim.master.fmi.errors import BadInput, near

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
    "crank_free=0.5",
    "participants.ehd.build.grid=[42, 40]",
    "participants.ehd.package=os",
    "participants.ehd.build.oil=olive",
    "participants.ehd.build.mask=no.csv",
    "participants.ehd.build.inputs=['viscosity']",
    "time.stop=-1 deg",
    "time.angular_speed=bodies.speed",
    "coupling.order=['ehd']",
    "wires.1.to=ehd.film_thickness",
    "record.every=0",
    "record.every=0 deg",
    "summary.minimum_film_thickness_m=least ehd.pressure",
    "summary.minimum_film_thickness_m=min ehd.pressure",
    "pictures.0.kind=pie",
    "pictures.0.file=../x.png",
    "participants.ehd.package=fmu_oil",
    "viscosity=[1]",
    "native=['film']",
    "coupling.step_control=mine",
    "participants.ehd.fmu=film.fmu",
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
    "run data_sheet --plots perhaps",
    "fmu check no.fmu",
    "verify rings",
    "new e --bore 86 --stroke 86 --rod 143 --mesh no.msh",
    "run data_sheet --lubrication text.fmu",
    "run data_sheet --lubrication engine=text.fmu",
    "run data_sheet --bodies folder",
    "run data_sheet --output",
    "new e --bore 86 --stroke 86 --rod 143 --mesh text.msh",
    "new e --bore 86 --stroke 86 --rod 143 --step no.step",
    "new e --bore 86 --stroke 86 --rod 143 --step a.step --piston full",
    "sweep data_sheet --vary 'radial_clearance=1um;2 kg'",
    "sweep data_sheet --vary 'radial_clearance=20um;30um' --workers 0",
    "reduce two_mass_oscillator",
    "run data_sheet --lubrication jfo --lubrication jfo",
    "results plot",
    "results report good.h5 --measured words.csv",
    "results movie good.h5 --field ehd.pressure",
    "results scalars good.h5 --output folder",
    "results scalars other.h5 --output kept.csv",
    "results fields good.h5 --field left.pressure --output f.csv",
    "results fields good.h5 --field left.x --output f.txt",
    "results snapshot good.h5 --participant left --time 'nan s' --output kept.json",
    "results recover good.h5 --time '1 ms'",
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
SNAPSHOT = "results snapshot good.h5 --participant left --output k.json"
SAID = {
    f"{SHEET} nothing": "--set: expected KEY=VALUE, got 'nothing'",
    f"{SHEET} viscosty=1": "viscosty: expected a key of the case, got",
    f"{SHEET} modes=3": "modes: expected a dotted path, got a name",
    f"{SHEET} participants.bodie.role=x": "role: expected a table participants.bodie in",
    f"{SHEET} participants.bodies.parameters.barel=1": "got unknown parameter or input 'barel'",
    f"{SHEET} participants.bodies.build.piston.mods=3": "mods: expected one of density, young,",
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
    f"{SHEET} viscosity=nan": "viscosity: expected a finite number, got nan",
    f"{SHEET} participants.ehd.timeout='0 s'": "timeout: expected a positive time, got '0 s'",
    f"{SHEET} native=yes": "native: expected true or false or a list, got 'yes'",
    f"{SHEET} piston.symmetric_film=1": "symmetric_film: expected true or false, got 1",
    f"{SHEET} coupling.advanced.halvings=true": "halvings: expected a whole number, got 'true'",
    f"{SHEET} coupling.advanced.halvings=1e9": "halvings: expected a value of at most 50, got 1",
    f"{SHEET} coupling.relaxation=true": "relaxation: expected a number, got 'true'",
    f"{SHEET} bodies.build.grid=[true,40]": "grid.0: expected a whole number, got 'true'",
    "run data_sheet --jobs 1.5": "--jobs: expected a whole number, got '1.5'",
    "run data_sheet --lubrication jof": "--lubrication: expected one of jfo, reynolds, gumbel, f",
    "run data_sheet --lubrication x.py:Film": "--lubrication: expected an existing FMU or FILE.py",
    "run data_sheet --lubrication x.py": "expected an existing FMU or FILE.py:CLASS, got 'x.py'",
    "results scalars good.h5 --output s.xlsx": "--output: expected a file .csv, got 's.xlsx'",
    "results plot good.h5 folder/../good.h5": "expected different files, got 'folder/../good.h5'",
    "results report good.h5 --measured text.csv": "expected a header 'participant.variable [unit]'",
    f"{SNAPSHOT} --time '-1 ms'": "expected a time of the run, 0 s to 50 ms, got '-1 ms'",
    "results scalars good.h5 --output good.h5": "--output: expected no results file, which",
    f"{SNAPSHOT[:-6]}good.h5 --time '1 ms'": "--output: expected no results file, which only",
    "run data_sheet --output ''": "--output: expected a value, got ''",
    "run data_sheet --output=": "--output: expected a value, got ''",
    "profile text.csv --output text.csv": "--output: expected another file than the profile",
    "profile text.csv --radius '-5 mm'": "--radius: expected a value above 0 m, got '-5 mm'",
    "profile text.csv --value-unit '0 um'": "expected a value other than 0 m, got '0 um'",
    "profile text.csv --skirt-lower -45": "--skirt-lower: expected a quantity in m, got '-45'",
    "bearing --radius 25 --load=-1kN": "--radius: expected a quantity in m, got '25'; write",
    "bearing --length 1mm": "--speed: expected a quantity in rad/s, got nothing",
    "bearing --set load=2": "--set: expected --load instead, got load=...",
    "run data_shet": "expected a file, a folder with case.toml or the name of a case",
    "keys viscousity": "expected a word of a key, got 'viscousity'; did you mean 'viscosity'",
    "study numerical_example mode": "study: expected one of modes, choice, grid,",
    f"{VARY} crank_speed": "expected KEY=LOW..HIGH:COUNT or",
    f"{VARY} crank_speed=1rpm..2rpm:1": "expected 2 to 100000 values in a range, got 1",
    "results plot no.h5": "no.h5: expected a results file, got no such file",
    "results plot text.h5": "text.h5: expected the results file of a run, got another file",
    "results report good.h5 --measured falling.csv": "expected rising numbers in the first column",
    "results report good.h5 --measured words.csv": "line 2: expected 2 numbers, got '1, a'",
    "results report good.h5 --measured no.csv": "no.csv: expected an existing file, got no such",
    "results movie good.h5": "got nothing; the file has no fields, name them in record.fields",
    "results plot cut.h5": "expected the results file of a run, got a truncated one",
    "results plot empty.h5": "expected the results file of a run, got another file",
    "results plot cut_off.h5": "got an interrupted run; piston-cosim resume cut_off.h5.checkpoint",
    "results plot folder": "folder: expected a results file, got a folder",
    "results report good.h5 --measured good.h5": "expected a text file, got a binary one",
    "results scalars good.h5 --output text.csv/x.csv": "expected a folder, got the file",
    f"{SNAPSHOT} --time 0.02": "expected a time, a crank angle or min|max participant.variable",
    f"{SNAPSHOT} --time '0,02 s'": "write for example '0.02 s'",
    "results snapshot good.h5 --participant lft --time 1s --output k.json": "mean 'left'?",
    "check data_sheet --pictures x.png": "unknown option '--pictures'; did you mean '--picture'?",
    "check data_sheet --picture x.xyz": "expected a file .png, .svg, .pdf, got 'x.xyz'",
    "check data_sheet --picture /proc/x/y.png": "a folder that can be written, got '/proc'",
    "check good.h5": "good.h5: expected a text file, got a binary one",
    "check ''": "expected a file, a folder with case.toml or the name of a case, got ''",
    "chek data_sheet": "got unknown command 'chek'; did you mean 'check'?",
    "check data_sheet more": "expected the arguments of the command, got 'more'; see --help",
    "run data_sheet --output /proc/x": "expected a folder that can be written, got '/proc'",
    "run data_sheet --variant rigd": "got unknown variant 'rigd'; did you mean 'rigid'?",
    "resume data_sheet": "expected a file *.h5.checkpoint, got",
    "fmu build body": "got unknown participant 'body'; did you mean 'bodies'?",
    "fmu build ehd --platform windows": "--platform: expected it with --native, got 'windows'",
    "fmu export data_sheet --output x.zip": "expected a file *.fmu or *.ssp, got 'x.zip'",
    "fmu info good.h5": "good.h5: expected an FMU, got another file",
    "fmu info folder": "folder: expected a file, got a folder",
    f"{VARY} 'viscosity=5..10:3'": "expected a quantity in Pa.s, got '5'; write for example",
    f"{VARY} 'start_crank_angle=0..360:3'": "write for example '360 deg'",
    f"{VARY} 'start_crank_angle=0..360 deg:3'": "give both ends in units of one kind",
    f"{VARY} 'rod_length=1m;2m' --vary 'rod_length=1m;2m'": "expected different keys, got part",
    f"{VARY} 'rod_length=1m;2m' --output text.h5": "--output: expected a folder, got the file",
    f"{VARY} 'radial_clearance=9um;8um' --time-limit '-1 s'": "--time-limit: expected",
    f"{VARY} 'radial_clearance=9um;8um' --time-limit 5": "a quantity in s, got '5'; write for",
    "study data_sheet grid": "got 'grid'; add a table studies.grid, see `keys studies`",
    "reduce numerical_example --set piston.modes=-3": "from 0 to 200 or an error of 0.01 % to",
    "reduce numerical_example --set 'piston.young=75 MPa'": "of at least 1e+08 Pa, got '75 MPa'",
    "reduce numerical_example --set piston.density=2.7": "write for example '2.7 kg/m^3'",
    "new 'a\"b' --bore 86 --stroke 86 --rod 143": "expected a folder name without quotes",
    "new text.h5 --bore 86 --stroke 86 --rod 143": "NAME: expected a folder, got the file",
    "new e --bore 86,5 --stroke 86 --rod 143": "write for example '86.5 mm'",
    "new e --bore 0.086 --stroke 86 --rod 143": "--bore: expected 20 to 600 mm, got '0.086'",
    f"{NEW} --speed -3000": "--speed: expected 10 to 30000 rpm, got '-3000'",
    f"{NEW} --compresion 10": "did you mean '--compression' or '--compression-height'?",
    f"{NEW} --piston sliper": "got unknown choice 'sliper'; did you mean 'slipper'?",
    f"{NEW} --mass 400 --mass 500": "--mass: expected one value, got several",
    "results movie good.h5 --output m.avi": "expected a file *.gif or *.pvd, got 'm.avi'",
    "results movie good.h5 --frames 1": "--frames: expected at least 2, got 1",
    "fmu build engine": "got unknown participant 'engine'",
    "resume no.h5.checkpoint": "expected an existing file, got no such file",
    "resume text.h5.checkpoint": "expected a checkpoint of this version, got another file",
    "new kept --bore 86 --stroke 86 --rod 143": "expected a new or empty folder, got an",
    "new e": "expected a value in mm, got nothing",
    "new e --bore 86 --stroke 86 --rod 44": "expected more than 45.15 mm, 1.05 times",
    "new e --bore '86 kg' --stroke 86 --rod 143": "expected 20 to 600 mm, got '86 kg'",
    f"{NEW} --compression 1": "expected 2 to 30, got '1'",
    f"{NEW} --skirt-above 50": "expected less than the compression height,",
    f"{NEW} --rod-centre 150": "expected less than the rod, 143 mm, got 150",
    f"{NEW} --peak-pressure 10": "expected 21.8 bar of compression to 873 bar",  # 10.5^1.33 - 1
    f"{NEW} --peak-pressure '6 m'": "--peak-pressure: expected 0.1 to 500 bar, got '6 m'",
}
"""Calls, and a part of what is said of them."""
WRONG_CASES = {
    ("223 mm", "0,223 m"): "with a decimal point, got '0,223 m'; write for example '0.223 m'",
    ('"223 mm"', "223 mm"): "line 46: expected KEY = VALUE with texts in quotes, got 'rod_length",
    ("50 um", "50 mm"): "radial_clearance: expected 1e-06 to 0.001 m, got 50 mm",
    ("5.6 mPa s", "5.6 cSt"): "viscosity: expected a quantity in Pa.s, got '5.6 cSt'",
    ("1680 rpm", "28 Hz"): "crank_speed: expected a quantity in rad/s, got '28 Hz'",
    ("1680 rpm", "1680 1/min"): "got '1680 1/min'; write for example '3000 rpm'",
    ("1680 rpm", "0 rpm"): "expected an angular speed above 0 with crank angles, got 0 rad/s",
    ("-360 deg", "-360"): "start_crank_angle: expected a quantity in rad, got '-360'; write for ex",
    ("1.39 kg", "0 kg"): "mass: expected a value above 0 kg, got '0 kg'",
    ("26.5 mm", '26.5 mm", "0 mm'): "centre: expected a list of at most 2 entries, got",
    ("-45.5 mm", "45.5 mm"): "skirt_lower: expected a height below skirt_upper = 0.0373 m, got",
    ('pin_offset = "0 mm"', 'pin_offset = "80 mm"'): "pin_offset: expected at most 27.4",
    ("54.95 mm", "55.173 mm"): "expected a skirt radius below the bore radius, 0.055 m, got",
    ('bore_radius = "55', 'bore_radius = "45'): "expected 55 mm, the bore radius of bodies, got 45",
    ("82.8 mm", "82 mm"): "skirt_length: expected 82.8 mm, the skirt length of bodies, got 82 mm",
    ('step = "1 deg"', 'step = "0 deg"'): "time.step: expected a positive value, got '0 deg'",
    ('step = "1 deg"', 'step = "0.7 deg"'): "the nearest are 719.6 deg and 720.3 deg",
    ('stop = "720 deg"', "stop = 720"): 'expected a string with a unit if it has one, such as "720',
    ("[coupling]", "[couplng]"): "got unknown key 'couplng'; did you mean 'coupling'?",
    ('body = "bodies"', 'body = "body"'): "unknown participant 'body'; did you mean 'bodies'?",
    ("grid = [40, 40]", "grid = [2, 40]"): "grid.0: expected a value of at least 4, got 2",
    (
        'file = "maps.png"',
        'file = "motion.png"',
    ): "different files, got 'motion.png' twice",
    ('"mrad"', '"mm"'): "units.bodies.rocking_angle: expected a unit of rad, got 'mm'",
    ("[record]", "[time]"): "line 73: expected each key and table once, got '[time]' a second time",
    (
        "ovality = ",
        "barrel = ",
    ): "each key and table once, got 'barrel = \"200 um\"' a sec",
    ('label = "rigid"', 'extends = "."'): "extends: expected another case, got '.'",
    ('label = "rigid"', 'extends = "no"'): "or the name of a case, got 'no'; `piston-cosim list`",
    ("[summary]", '[window]\n"max ehd.maximum_pressure" = ["9 Pa", "5 Pa"]\n[summary]'): "expected "
    "[low, high], got ['9 Pa', '5 Pa']",
    (
        "1 MPa",
        "1 GPa",
    ): "expected pressure_unit near '1 MPa' as in the header, got '1e+03 MPa'",
    ('angle_unit = "1 deg"', 'angle_unit = "1 rad"'): "angle_unit near '1 deg' as in the header",
    ("strokes = 4", "strokes = 2"): "expected a cycle of 360 deg, got 720 deg; check angle_unit",
    ("gas_pressure.csv", ""): "gas.file: expected a file in",
    ("gas_pressure.csv", "."): "gas.file: expected a file in",
}
"""Replacements in the text of a shipped case, and a part of a fault."""
DOUBTFUL_CASES = {
    ("1.39 kg", "1390 kg"): "piston = 1390 kg: expected 0.133 to 13.3 kg for its diameter; check",
    ("0.54 um", "54 um"): "roughness_rms = 54 \N{MICRO SIGN}m: expected 0 m to 10",
    ("5.6 mPa s", "5.6 Pa s"): "viscosity = 5.6 Pa",
    ("200 um", "2 mm"): "ovality = 2000 \N{MICRO SIGN}m: expected at most 428.6",
    ("720 deg", "1e12 deg"): "time.stop = 1e12 deg: the run has 1e+12 macro steps",
    (
        'step = "1 deg"',
        'step = "90 deg"',
    ): "at least 72 macro steps in a period of 720 deg",
    (
        "[participants.ehd.build]",
        "[participants.ehd.build]\noil = 'sae_0w_20'",
    ): "viscosity: no ef",
    ("[time]", '[time]\nperiod = "180 deg"'): "period = 180 deg: expected a multiple of 720 deg",
    ('barrel = "40 um"', 'barrel = "0 um"'): "a straight skirt carries on its edges",
}
"""Replacements in it, and a part of a warning."""
WRONG_TABLES = {
    "angle,p\na,b\n": "expected rows of numbers, got none",
    "": "expected rows of numbers, got none",
    "0,1,5\n720,1,5\n": "got 3; decimal commas need ; or tabs between columns",
    "0,1\n720,nan\n": "line 2: expected numbers, got 'nan'",
    "a;p\n0;1,2,3\n720;1\n": "line 2: expected numbers, got '1,2,3'",
    "0,1\n360,1\n720,1\nEND\n": "line 4: expected numbers, got 'END'",
    b"\xff\xfe0\0,\x001\0": "expected a text file in UTF-8, got another encoding; save",
    "0,1\n100,1\n200,1\n300,1\n400,1\n": "got 400 deg; check angle_unit and",
    "0,1\n720,5\n": "expected pressure 1e+06 Pa at the end as at the start, got pressure 5e+06 Pa",
    b"Winkel [\xb0],p\n0,1\n720,1\n": "expected a text file in UTF-8, got another encoding; save",
    b"\x89HDF\x00\xff": "expected a text file, got a binary one",
}
"""Contents of a gas table, and a part of the fault."""
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
    names = "text.h5 text.fmu text.toml text.msh text.csv text.py text.h5.checkpoint "
    names += "cut_off.h5.checkpoint"
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
    (folder / "cut.h5").write_bytes(run.path.read_bytes()[:40000])
    (folder / "empty.h5").touch()
    return folder


@pytest.fixture(autouse=True)
def elsewhere(files, monkeypatch):
    monkeypatch.chdir(files)
    monkeypatch.setenv("COLUMNS", "200")


@pytest.mark.parametrize("arguments", CALLS, ids=lambda one: " ".join(one)[-60:])
def test_wrong_calls(arguments, monkeypatch, capsys):
    faults_of_call(arguments, monkeypatch, capsys)
    assert all(Path(name).read_text() == "kept" for name in KEPT)


def test_neither_hyphens_nor_capitals_count_in_similar_names():
    assert near("JFO", ["jfo", "gumbel"]) == "; did you mean 'jfo'?"
    assert near("--oil", ["--rod", "--bore"]) == ""
    assert near("--bor", ["--rod", "--bore"]) == "; did you mean '--bore'?"


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


def sheet_with(folder, change):
    """Return the check of a copy of the data sheet with a text replaced."""
    shipped = find_case(CASE)
    text = shipped.read_text()
    assert change[0] in text
    shutil.copy(shipped.parent / "gas_pressure.csv", folder)
    (folder / "case.toml").write_text(text.replace(*change, 1))
    try:
        return check(folder)
    except BadInput as error:
        return CheckedCase(folder, "", faults=error.faults)


@pytest.mark.parametrize("change", WRONG_CASES, ids=lambda change: change[1][:20])
def test_a_wrong_value_of_a_case_is_a_fault(change, tmp_path):
    faults = sheet_with(tmp_path, change).faults
    assert any(WRONG_CASES[change] in fault for fault in faults), faults
    for fault in faults:
        assert FORM.fullmatch(fault) and not FOREIGN.search(fault), fault
        assert len(fault.split()) <= MOST_WORDS, fault


@pytest.mark.parametrize("change", DOUBTFUL_CASES, ids=lambda change: change[1][:20])
def test_a_doubtful_value_of_a_case_is_a_warning(change, tmp_path):
    found = sheet_with(tmp_path, change)
    assert found.faults == []
    assert any(DOUBTFUL_CASES[change] in line for line in found.warnings), found.warnings


def test_a_damaged_file_is_a_fault():
    error = OSError("Can't synchronously read data (filter returned failure during read)")
    assert faults_of(error) == [
        "files: expected complete results files, got a damaged one; run again"
    ]


@pytest.mark.parametrize("text", WRONG_TABLES)
def test_a_wrong_gas_table_is_a_fault(text, tmp_path):
    path = tmp_path / "gas.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    faults = check(CASE, [("participants.bodies.build.gas.file", str(path))]).faults
    assert any(WRONG_TABLES[text] in fault for fault in faults), faults


@pytest.mark.parametrize("text", FILES)
def test_wrong_case_files(text, tmp_path, monkeypatch, capsys):
    (tmp_path / "case.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    faults_of_call(["check", str(tmp_path)], monkeypatch, capsys)


@pytest.mark.parametrize(
    "name, text",
    [
        ("piston.msh", "no mesh"),
        ("gas_pressure.csv", "0,1\n10,2\n5,3\n"),
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


@pytest.mark.parametrize("full", [False, True])
def test_output_that_cannot_be_written_ends_without_a_traceback(full):
    """Standard output is a pipe without a reader, as after `head`, or a full disk."""
    with open("/dev/full", "w") as disk:
        words = [sys.executable, "-m", "piston_cosim", "keys", "--json-schema"]
        target = disk if full else subprocess.PIPE
        run = subprocess.Popen(words, stdout=target, stderr=subprocess.PIPE, text=True)
    if run.stdout:
        run.stdout.close()
    message = run.stderr.read()
    assert run.wait() == 1
    assert message.strip() == ("stopped: No space left on device" if full else "")
