"""The description of an FMU: who made it, its run, constants, documentation.

It contains nothing of the machine on which it was built.
"""

import ast
import getpass
import re
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest
from lxml import etree

import piston_cosim as pc
from piston_cosim.fmu_ehd.variables import DERIVATIVE_INPUTS, DERIVATIVE_OUTPUTS
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.export import experiment_ahead
from piston_cosim.master.commands.fmu.info import command as info
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.fmi.requirements import PACKAGES
from piston_cosim.master.fmi.slave import Experiment

from .runs import coarse, export, needs_compiler, small_tree

SMALL = coarse()


@pytest.fixture(scope="module")
def engine():
    return export(small_tree())


@pytest.fixture(scope="module")
def film_3():
    needs_compiler(native=False)
    return build_fmu("fmu_ehd", {"grid": [12, 10]}, Path("."), version="3.0")


@pytest.fixture(params=["fmu", "bodies_fmu", "engine", "film_3"])
def any_fmu(request):
    return request.getfixturevalue(request.param)


def test_info_is_short_and_its_table_is_asked_for(any_fmu, capsys):
    info(any_fmu)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 11 and max(map(len, lines)) <= 120
    heads = {line.split()[0] for line in lines[1:] if line.strip()}
    assert heads >= {"made", "step", "connect", "set", "details"}
    model = fmpy.read_model_description(str(any_fmu))
    assert f"{float(model.defaultExperiment.stepSize):g} s" in "\n".join(lines)
    scalars = [one for one in model.modelVariables if "[" not in one.name and not one.dimensions]
    last = {one.causality: one.name for one in scalars}
    info(any_fmu, all_=True)
    table = capsys.readouterr().out
    assert last["output"] in table and last["parameter"] in table


def test_description_says_who_made_it(any_fmu):
    model = fmpy.read_model_description(str(any_fmu))
    assert (model.author, model.license) == ("the piston-cosim developers", "BSD-3-Clause")
    assert model.copyright.startswith("Copyright (c)") and re.fullmatch(r"\d.*", model.version)
    assert model.generationDateAndTime == "2026-11-22T00:00:00Z"


def test_fmi_3_has_arrays_and_terminals(film_3):
    variables = {v.name: v for v in fmpy.read_model_description(str(film_3)).modelVariables}
    assert [int(d.start) for d in variables["film_thickness"].dimensions] == [12, 10]
    assert variables["film_thickness"].unit == "m"
    with zipfile.ZipFile(film_3) as archive:
        told = archive.read("terminalsAndIcons/terminalsAndIcons.xml")
    schemas = Path(fmpy.__file__).parent / "schema" / "fmi3"
    root = etree.fromstring(told)
    etree.XMLSchema(file=str(schemas / "fmi3TerminalsAndIcons.xsd")).assertValid(root)
    members = {m.get("variableName") for m in root.iter("TerminalMemberVariable")}
    assert members == {*DERIVATIVE_INPUTS, *DERIVATIVE_OUTPUTS}


def test_without_compiler_there_is_no_twin(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(BadInput, match="C compiler"):
        build_fmu("fmu_ehd", {"grid": [12, 10]}, ".", version="3.0")


def test_engine_has_the_words_and_the_run_of_its_case(engine):
    """The description and the default run of the engine are those of its case.

    720 deg in steps of 1 deg at 6000 rpm are 0.02 s in steps of 2.78e-5 s. Velocities agree to 1e-6
    of their nominal value, the default tolerance of a wire.
    """
    model = fmpy.read_model_description(str(engine))
    assert model.modelName == model.coSimulation.modelIdentifier == "numerical_example"
    assert model.description.startswith("Motored single")
    usual = model.defaultExperiment
    assert float(usual.stopTime) == pytest.approx(0.02, rel=1e-12)
    assert float(usual.stepSize) == pytest.approx(1 / 36000, rel=1e-12)
    assert float(usual.tolerance) == pytest.approx(1e-6, rel=1e-12)


def test_a_part_alone_says_the_run_of_its_case_too(tmp_path):
    """The film built of a case by itself, before anything else is."""
    case = pc.open_case("numerical_example", dict(SMALL))
    film = pc.build_fmu(case, "ehd", output=tmp_path / "film.fmu")
    usual = experiment_ahead(check_case(case.tree, case.path), case.path.parent)
    assert usual == Experiment(pytest.approx(0.02), pytest.approx(1 / 36000), pytest.approx(1e-6))
    said = fmpy.read_model_description(str(film)).defaultExperiment
    told = [float(text) for text in (said.stopTime, said.stepSize, said.tolerance)]
    assert told == [usual.stop, usual.step, usual.tolerance]


def test_a_value_reference_stands_for_one_variable(any_fmu):
    """Through all types: what is no Real cannot be reached as one."""
    model = fmpy.read_model_description(str(any_fmu))
    references = [v.valueReference for v in model.modelVariables]
    assert len(set(references)) == len(references) > 50
    assert {v.type for v in model.modelVariables} - {"Real", "Float64"}


def test_only_the_code_that_runs_is_inside(any_fmu):
    """No verification, oracle, builder or preview; and no package but those it says it needs."""
    with zipfile.ZipFile(any_fmu) as archive:
        code = {n: archive.read(n) for n in archive.namelist() if n.endswith(".py")}
    names = {Path(name).stem for name in code}
    assert not names & {"verification", "exudyn_reference", "builder", "build", "preview", "solver"}
    assert {"slave", "fmi2slave"} <= names
    allowed = {*PACKAGES, "pythonfmu", *sys.stdlib_module_names}
    optional = {"pypardiso", "pythonfmu", "piston_cosim"}
    for name, text in code.items():
        for node in ast.walk(ast.parse(text)):
            imported = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level:
                imported = [node.module]
            tops = {one.partition(".")[0] for one in imported} - optional
            own = {top for top in tops if top.startswith("code_")}
            assert tops - own <= allowed, name


def test_a_second_grid_compiles_nothing(fmu, outside):
    """FMUs of two grids use the same compiled files.

    The name of the code depends on the sources alone, and kernels do not depend on sizes.
    """
    code = """
        film = [v.valueReference for v in model.modelVariables if v.name.startswith("film_thick")]
        one.setReal(film, [9e-6] * len(film))
        one.doStep(0.0, 1e-4)
        module = next(n for n in sys.modules if n.startswith("code_") and n.endswith(".reynolds"))
        from pathlib import Path
        home = Path(sys.modules[module].__file__).parents[1]
        kept = sorted((str(p), p.stat().st_mtime) for p in home.rglob("*.nb[ci]"))
        print(json.dumps(kept))
        """
    first = outside(PRELUDE, fmu, code)
    second = outside(PRELUDE, build_fmu("fmu_ehd", {"grid": [16, 8]}, Path(".")), code)
    assert second == first and len(first) > 20


PRELUDE = """
import json, sys
import fmpy
from fmpy.fmi2 import FMU2Slave
path = sys.argv[1]
model = fmpy.read_model_description(path)
one = FMU2Slave(
    guid=model.guid,
    unzipDirectory=fmpy.extract(path),
    modelIdentifier=model.coSimulation.modelIdentifier,
    instanceName="one",
)
one.instantiate()
one.setupExperiment()
one.enterInitializationMode()
one.exitInitializationMode()
"""


def test_constants_are_no_parameters_and_choices_are_enumerations(fmu, film_3):
    for path in (fmu, film_3):
        found = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
        cells, law = found["n_axial"], found["cavitation_model"]
        assert (cells.causality, cells.variability, cells.start) == ("local", "constant", "10")
        assert (law.type, law.start) == ("Enumeration", "1")
        items = {item.name: int(item.value) for item in law.declaredType.items}
        assert items == {"jfo": 1, "reynolds": 2, "gumbel": 3, "full_film": 4}


def test_documentation_lists_every_variable_and_the_licences(any_fmu):
    model = fmpy.read_model_description(str(any_fmu))
    with zipfile.ZipFile(any_fmu) as archive:
        page = archive.read("documentation/index.html").decode()
        own = archive.read("documentation/licenses/license.txt").decode()
        packager = archive.read("documentation/licenses/pythonfmu.txt").decode()
        icon = {"2.0": "model.png", "3.0": "terminalsAndIcons/icon.png"}[model.fmiVersion]
        assert archive.read(icon).startswith(b"\x89PNG")
    names = {v.name.partition("[")[0] for v in model.modelVariables} - {"time"}
    assert names <= set(etree.HTML(page).xpath("//td/text()"))
    assert "Redistribution and use" in own and "MIT" in packager


def test_nothing_of_the_building_machine_is_inside(any_fmu):
    told = [sys.prefix, sys.base_prefix, str(Path.home()), str(Path(__file__).parents[2])]
    told += [getpass.getuser()] if len(getpass.getuser()) > 5 else []
    with zipfile.ZipFile(any_fmu) as archive:
        for name in archive.namelist():
            data = archive.read(name)
            assert [word for word in told if word.encode() in data] == [], name
