"""The FMI 3.0 twin: true arrays, the same results to the bit as FMI 2.0."""

import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.contract import swap
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.compiler import compiler
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

CELLS = (12, 10)


@pytest.fixture(scope="module")
def twin():
    if not compiler():
        pytest.skip("no C compiler")
    return build_fmu("fmu_ehd", {"grid": list(CELLS)}, ".", version="3.0")


def test_description_is_valid_with_arrays_and_terminals(twin):
    assert validate_fmu(str(twin)) == []
    variables = {v.name: v for v in fmpy.read_model_description(str(twin)).modelVariables}
    assert [int(d.start) for d in variables["film_thickness"].dimensions] == list(CELLS)
    assert variables["film_thickness"].unit == "m"
    with zipfile.ZipFile(twin) as archive:
        told = archive.read("terminalsAndIcons/terminalsAndIcons.xml")
        assert archive.read("terminalsAndIcons/icon.png").startswith(b"\x89PNG")
    schemas = Path(fmpy.__file__).parent / "schema" / "fmi3"
    root = etree.fromstring(told)
    etree.XMLSchema(file=str(schemas / "fmi3TerminalsAndIcons.xsd")).assertValid(root)
    members = {m.get("variableName") for m in root.iter("TerminalMemberVariable")}
    assert members == {
        "film_thickness",
        "sliding_velocity",
        "nodal_pressure_force",
        "nodal_friction_force",
    }


def test_without_compiler_there_is_no_twin(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(BadInput, match="C compiler"):
        build_fmu("fmu_ehd", {"grid": list(CELLS)}, ".", version="3.0")


def test_master_runs_fmi_3_to_the_same_bits(twin, fmu, tmp_path):
    path = find_case("numerical_example")
    small = [
        ("participants.bodies.build.grid", list(CELLS)),
        ("time.stop", "5 deg"),
        ("participants.bodies.build.piston.modes", 0),
        ("participants.bodies.build.block.modes", 0),
    ]
    results = []
    for file in (fmu, twin):
        tree, left_out = swap(read_tree(path, small), "ehd", file)
        assert left_out == []
        case, output = check_case(tree, path), tmp_path / f"{file.stem}.h5"
        run(open_system(case, path.parent, print), case, tree, output)
        results.append(Results(output).series("bodies.lateral_displacement")[0])
    assert np.array_equal(*results)
    assert np.ptp(results[0]) > 0
