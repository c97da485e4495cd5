"""Wrong inputs of the command line: each ends at once with exit code 2 and a sentence that says
what is allowed, and with no traceback.
"""

import sys
import time

import pytest

from piston_cosim.master.case.schema import find_case
from piston_cosim.master.commands.app import main

LONGEST = 5.0
"""Seconds for one; CPU time of this process, for a busy machine is none of the command's making."""
CASE = "data_sheet"


def sets(*rows):
    """Changes of the shipped data sheet, each with what `check` says of it."""
    return [(["check", CASE, "--set", change, "--picture", "x.png"], said) for change, said in rows]


KEYS = sets(
    ("viscosty=1 Pa s", "did you mean viscosity"),
    ("nothing", "write KEY=VALUE"),
    ("=3", "write KEY=VALUE"),
    ("mass_=1 kg", "nowhere in the case"),
    ("radius=1 mm", "give its dotted path"),
    ("participants.bodie.role=x", "did you mean bodies"),
    ("participants.bodies.parameters.barel=1 um", "did you mean barrel"),
    ("participants.bodies.build.pisston.modes=3", "did you mean piston"),
    ("participants.bodies.build.piston.mods=3", "unknown key (did you mean modes"),
    ("coupling.metod=newton", "unknown key (did you mean method"),
    ("wires.7.tolerance=1 nm", "no table wires.7"),
    ("wires=3", "list"),
    ("time=3", "dictionary"),
    ("pictures.0.tile=x", "unknown key (did you mean title"),
)
VALUES = sets(
    ("viscosity=12", "a unit of Pa.s is needed"),
    ("viscosity=12 bar", "a unit of Pa.s is needed"),
    ("viscosity=thick", "write a number and a unit"),
    ("viscosity=-1 mPa s", "allowed is 1e-05 to 1000 Pa.s"),
    ("viscosity=true", "not a quantity in Pa.s"),
    ("radial_clearance=1 m", "allowed is 1e-06 to 0.001 m"),
    ("radial_clearance=0 um", "allowed is 1e-06 to 0.001 m"),
    ("crank_speed=1e9 rpm", "allowed is 0 to 3000 rad/s"),
    ("crank_speed=1000 Hz m", "a unit of rad/s is needed"),
    ("crank_free=0.5", "whole number"),
    ("crank_free=2", "allowed is 0 to 1"),
    ("cavitation_model=jof", "did you mean jfo"),
    ("viscosity_law=water", "allowed are constant, vogel_1921"),
    ("boundary_friction_coefficient=3", "allowed is 0 to 2"),
    ("participants.ehd.build.grid=[40]", "grid"),
    ("participants.ehd.build.grid=[2, 2]", "between 4 and 1000"),
    ("participants.ehd.build.grid=[42, 40]", "build both FMUs with the same grid"),
    ("participants.bodies.build.grid=[3, 40]", "greater than or equal to 4"),
    ("participants.ehd.build.oil=olive", "known oils are"),
    ("participants.ehd.build.oil_library=no.toml", "name one by oil"),
    ("participants.ehd.build.mask=no.csv", "no.csv"),
    ("participants.ehd.build.inputs=['viscosity']", "possible inputs are"),
    ("time.stop=720", "must be text, with its unit"),
    ("time.stop=7 bar", "a unit of rad is needed"),
    ("time.stop=-1 deg", "must be positive"),
    ("time.stop=720.3 deg", "no multiple of time.step"),
    ("time.step=0 deg", "must be positive"),
    ("time.angular_speed=bodies.speed", "give it a value"),
    ("coupling.method=magic", "there are newton"),
    ("coupling.order=['ehd']", "must name each participant once"),
    ("coupling.max_iterations=0", "greater than or equal to 1"),
    ("coupling.relaxation=2", "less than or equal to 1"),
    ("wires.0.tolerance=1 kg", "a unit of m is needed"),
    ("wires.0.from=bodies.film", "did you mean film"),
    ("wires.0.from=film", "match pattern"),
    ("wires.1.to=ehd.film_thickness", "an input takes one"),
    ("record.every=0", "greater than or equal to 1"),
    ("record.every=0 deg", "must be positive"),
    ("record.every=4 bar", "a unit of s is needed"),
    ("record.every=1 ms", "record.every: '1 ms' is in ms: a unit of rad is needed"),
    ("record.fields=['ehd.pressur']", "did you mean pressure"),
    ("summary.minimum_film_thickness_m=least ehd.pressure", "write 'min|max|mean|last"),
    ("summary.minimum_film_thickness_m=min ehd.pressure", "takes scalar numbers"),
    ("pictures.0.kind=pie", "'lines', 'map' or 'section'"),
    ("pictures.0.time=24", "must be text, with its unit"),
    ("pictures.0.time=24 degrees north", "write a time, a crank angle, e.g. '24 deg'"),
    ("pictures.0.time=mean bodies.side_force", "or 'min|max participant.variable'"),
    ("pictures.0.time=max bodies.side_forc", "did you mean side_force"),
    ("pictures.0.file=../x.png", "plain file name"),
    ("label=a/b", "plain file name"),
    ("participants.ehd.package=fmu_oil", "no installed package"),
)
GEOMETRY = sets(
    ("rod_length=60 mm", "must exceed crank_radius"),
    ("rod_centre=300 mm", "must lie within"),
    ("bore_radius=50 mm", "the bore radius of bodies is 55 mm"),
    ("skirt_length=80 mm", "the skirt length of bodies is 82.8 mm"),
    ("skirt_lower=40 mm", "must lie below"),
    ("bore_upper=200 mm", "the skirt travels"),
    ("gas.file=no.csv", "no such file"),
    ("gas.pressure_unit=1 mm", "a unit of Pa is needed"),
    ("piston.rigid.mass=0 kg", "greater than 0"),
    ("piston.modes=20", "a rigid body has none"),
    ("pressure_lower_edge=-1 bar", "must not be below cavitation_pressure"),
)
COMMANDS = [
    (["chek", CASE], "check"),
    (["run"], "CASE"),
    (["run", "data_shet"], "did you mean data_sheet"),
    (["check", "no_such_folder/case.toml"], "nor one of"),
    (["run", CASE, "--only", "flexible"], "the case has"),
    (["run", CASE, "--plots", "perhaps"], "perhaps"),
    (["keys", "viscousity"], "did you mean viscosity"),
    (["study", CASE, "modes"], "unknown study 'modes'"),
    (["sweep", CASE, "--vary", "radial_clearance"], "write KEY=LOW..HIGH:COUNT"),
    (["sweep", CASE, "--vary", "radial_clearance=1um..3s:3"], "units of one kind"),
    (["sweep", CASE, "--vary", "radial_clearanse=1um;2um"], "did you mean radial_clearance"),
    (["results", "plot", "no.h5"], "no such file"),
    (["results", "report", "no.h5"], "no such file"),
    (
        ["results", "fields", "no.h5", "--field", "ehd.pressure", "--output", "p.csv"],
        "no such file",
    ),
    (["results", "recover", "no.h5", "--time", "1 ms"], "no such file"),
    (["results", "snapshot", "no.h5", "--participant", "bodies", "--output", "s"], "no.h5"),
    (["fmu", "check", "no.fmu"], "no such file"),
    (["fmu", "info", "no.fmu"], "no such file"),
    (["fmu", "build", "engine"], "the case builds"),
    (["fmu", "build", "ehd", "--grid", "40"], "CIRCUMFERENTIALxAXIAL"),
    (["plot", "a b.h5", "--format", "svg"], "results plot 'a b.h5' --format svg"),
    (["compare", "a.h5", "b.h5"], "piston-cosim results compare a.h5 b.h5"),
    (["check", "film.fmu"], "piston-cosim fmu check film.fmu"),
    (["export", "fmu", "x", "--output", "y"], "piston-cosim fmu export x --output y"),
    (["export", "ssp", "x", "--output", "y"], "piston-cosim fmu export ssp x --output y"),
    (["results", "plott"], 'Did you mean "plot"'),
    (["verify", "rings"], "there are ehd"),
    (["new", "e"], "--bore is needed"),
    (["new", "e", "--bore", "86", "--stroke", "86", "--rod", "40"], "must be longer"),
    (["new", "e", "--bore", "86 kg", "--stroke", "86", "--rod", "143"], "20 to 600 mm"),
    (["new", "e", "--bor", "86"], "--bore"),
    (["new", "e", "--bore", "86", "--stroke", "86", "--rod", "143", "--mesh", "no.msh"], "no.msh"),
]
FILES = [
    ("title = ", "Invalid value"),
    ("", "time: Field required"),
    ("a = 1", "unknown key"),
    (b"\xff\xfe\x00", "case.toml"),
]
WRONG = KEYS + VALUES + GEOMETRY + COMMANDS


def answer(arguments, monkeypatch, capsys):
    """Exit code and all that is printed, by the command line in this process."""
    monkeypatch.setattr(sys, "argv", ["piston-cosim", *arguments])
    begin = time.process_time()
    with pytest.raises(SystemExit) as ended:
        main()
    assert time.process_time() - begin < LONGEST
    printed = capsys.readouterr()
    return ended.value.code, " ".join((printed.out + printed.err).split())


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")


@pytest.mark.parametrize("arguments, said", WRONG, ids=lambda one: str(one)[-60:])
def test_wrong_inputs(arguments, said, monkeypatch, capsys):
    code, printed = answer(arguments, monkeypatch, capsys)
    assert code == 2, printed
    assert said in printed and "Traceback" not in printed


@pytest.mark.parametrize("text, said", FILES)
def test_wrong_files(text, said, tmp_path, monkeypatch, capsys):
    (tmp_path / "case.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    code, printed = answer(["check", str(tmp_path)], monkeypatch, capsys)
    assert code == 2 and said in printed and "Traceback" not in printed


def test_wrong_results(tmp_path, monkeypatch, capsys):
    (tmp_path / "text.h5").write_text("no results")
    code, printed = answer(["results", "report", "text.h5"], monkeypatch, capsys)
    assert code == 2 and "Traceback" not in printed


def test_a_mesh_that_is_none(tmp_path, monkeypatch, capsys):
    folder = find_case("fired_motorcycle").parent
    text = (folder / "case.toml").read_text().replace("piston.msh.xz", "piston.msh")
    (tmp_path / "case.toml").write_text(text)
    (tmp_path / "piston.msh").write_text("no mesh")
    for name in ("block.msh.xz", "gas_pressure.csv", "skirt_profile.csv"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    code, printed = answer(["check", "."], monkeypatch, capsys)
    assert code == 2 and "no mesh that can be read" in printed and "Traceback" not in printed


def test_there_are_enough_of_them():
    assert len(WRONG) + len(FILES) >= 60 and len({str(one) for one, _ in WRONG}) == len(WRONG)
