"""Descriptions and archives of FMUs that other tools write, and the cause of each rejection."""

import zipfile
from pathlib import Path

import pytest

import piston_cosim as pc
from piston_cosim.master.fmi.errors import BadInput

from ..command import call
from .c_fmus import Variable
from .reported import Y, fmu, folder, last, refused, run  # noqa: F401


def test_booleans_written_as_0_and_1():
    switch = Variable("b", 200, "parameter", "Boolean", 'start="1"')
    a = fmu("a", [switch, Y], START="m->b[0]=1", OUT="m->r[1]=m->b[0]")
    assert last(run({"a": a}), "a.y") == 1.0
    for value in (False, True):
        assert last(run({"a": a}, parameters={"a": {"b": value}}), "a.y") == value


def repacked(name, text=None, library="binaries/linux64/odd.so", more=()):
    """Return a copy of an FMU with another description (function of the text) or library."""
    source = fmu("source")
    with zipfile.ZipFile(source) as archive, zipfile.ZipFile(name, "w") as target:
        described = archive.read("modelDescription.xml")
        target.writestr("modelDescription.xml", text(described) if text else described)
        target.writestr(library, archive.read("binaries/linux64/odd.so"))
        for one in more:
            target.writestr(one, "x")
    return name


def replaced(old, new):
    return lambda text: text.replace(old, new)


TWICE = b'<ScalarVariable name="y" valueReference="2" causality="output"><Real/></ScalarVariable>'


@pytest.mark.parametrize(
    "text, words",
    [
        (replaced(b'"2.0"', b'"1.0"'), "expected FMI 2.0 or 3.0, got FMI 1.0"),
        (
            replaced(b"CoSimulation", b"ModelExchange"),
            "expected an FMU for co-simulation, got Model Exchange",
        ),
        (
            replaced(b'"output" variability="continuous"', b'"parameter" variability="continuous"'),
            'got Variable "y" (line 7) has an illegal combination of causality="parameter" and '
            'variability="continuous"',
        ),
        (
            replaced(b"<Real />", b'<Real start="1,5"/>'),
            "y: expected Real values as start, got",
        ),
        (
            replaced(b"</ModelVariables>", TWICE + b"</ModelVariables>"),
            "expected variables with different names, got 'y' in lines 7 and 7",
        ),
        (
            replaced(b'modelName="odd"', 'modelName="größe"'.encode("latin-1")),
            "expected modelDescription.xml in UTF-8, got other bytes in line 2",
        ),
        (replaced(b"<Real", b"<Double"), "got ERROR (line 7, column 0)"),
        (replaced(b"<Real", b'<Real max="far"'), "y: expected a number as max, got 'far'"),
        (lambda text: b"", "expected a valid modelDescription.xml, got"),
    ],
)
def test_faults_of_a_description_have_a_cause_and_a_line(text, words):
    faults = refused({"a": repacked("a.fmu", text)})
    assert words in faults and faults.startswith("participants.a.fmu: ")
    assert faults.count("participants.a") == len(faults.splitlines())


@pytest.mark.parametrize(
    "library, more, words",
    [
        (
            "binaries/win64/odd.dll",
            (),
            "expected binaries/linux64/odd.so, got libraries for win64 only; export it for linux64",
        ),
        (
            "sources/odd.c",
            (),
            "got no library; it has source code: compile it with `fmpy compile a.fmu`",
        ),
        (
            "binaries/linux64/other.so",
            ("binaries/win64/odd.dll",),
            "expected binaries/linux64/odd.so, got binaries/linux64/other.so",
        ),
    ],
)
def test_an_fmu_without_a_library_for_this_machine(library, more, words):
    a = repacked("a.fmu", library=library, more=more)
    assert words in refused({"a": a})
    assert call("fmu", "info", a).returncode == 0
    with pytest.raises(BadInput, match="expected binaries/linux64/odd.so"):
        pc.open_fmu(a).start({}, 0.0, 1.0)


def test_an_fmu_with_files_outside():
    a = repacked("a.fmu", more=["../x"])
    words = "expected files inside it, got path '../x'"
    assert refused({"a": a}) == f"participants.a.fmu: {Path(a).absolute()}: {words}"


def test_an_fmu_that_was_zipped_with_its_folder(folder):  # noqa: F811
    with zipfile.ZipFile("a.fmu", "w") as archive:
        archive.writestr("engine/modelDescription.xml", "")
    words = "no modelDescription.xml in it; zip the content of the folder of engine/modelDescr"
    assert words in refused({"a": "a.fmu"})


def test_further_files_in_an_fmu():
    terminals = '<fmiTerminalsAndIcons fmiVersion="3.0"/>'
    files = {
        "terminalsAndIcons/terminalsAndIcons.xml": terminals,
        "extra/org.x/a.txt": "x",
        "binaries/win64/odd.dll": "x",
        "documentation/index.html": "<script>alert(1)</script>",
    }
    assert last(run({"a": fmu("a", files=files, STEP="m->r[1]=1")}), "a.y") == 1.0
