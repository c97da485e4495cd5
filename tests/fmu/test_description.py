"""What an FMU says of itself: who made it, its run, constants, documentation; nothing of the
machine it was built on.
"""

import getpass
import re
import sys
import zipfile
from html.parser import HTMLParser
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.schema import check_case, find_case, read_tree
from piston_cosim.master.fmi.builder import build_fmu

PATH = find_case("numerical_example")
SMALL = [
    ("participants.bodies.build.grid", [12, 10]),
    ("participants.ehd.build.grid", [12, 10]),
    ("participants.bodies.build.piston.modes", 0),
    ("participants.bodies.build.block.modes", 0),
]


@pytest.fixture(scope="module")
def engine():
    return export_fmu(check_case(read_tree(PATH, SMALL), PATH), PATH.parent, print)


@pytest.fixture(scope="module")
def film_3(fmu):
    return build_fmu("fmu_ehd", {"grid": [12, 10]}, Path("."), version="3.0")


@pytest.fixture(params=["fmu", "bodies_fmu", "engine", "film_3"])
def any_fmu(request):
    return request.getfixturevalue(request.param)


def test_description_is_valid_and_says_who_made_it(any_fmu):
    assert validate_fmu(str(any_fmu)) == []
    model = fmpy.read_model_description(str(any_fmu))
    assert (model.author, model.license) == ("the piston-cosim developers", "BSD-3-Clause")
    assert model.copyright.startswith("Copyright (c)") and re.fullmatch(r"\d.*", model.version)
    assert model.generationDateAndTime == "2026-11-22T00:00:00Z"


def test_engine_has_the_words_and_the_run_of_its_case(engine):
    """720 deg in steps of 1 deg at 6000 rpm: 0.02 s by 2.78e-5 s; velocities agree to 1e-6 of their
    nominal value, what a wire without a tolerance is given.
    """
    model = fmpy.read_model_description(str(engine))
    assert model.modelName == model.coSimulation.modelIdentifier == "numerical_example"
    assert model.description.startswith("Motored single")
    usual = model.defaultExperiment
    assert float(usual.stopTime) == pytest.approx(0.02, rel=1e-12)
    assert float(usual.stepSize) == pytest.approx(1 / 36000, rel=1e-12)
    assert float(usual.tolerance) == pytest.approx(1e-6, rel=1e-12)


def test_constants_are_no_parameters(fmu, film_3):
    for path in (fmu, film_3):
        model = fmpy.read_model_description(str(path))
        (cells,) = [v for v in model.modelVariables if v.name == "n_axial"]
        assert (cells.causality, cells.variability, cells.start) == ("local", "constant", "10")


class Cells(HTMLParser):
    """Texts of all table cells; an error where tags do not close."""

    def __init__(self):
        super().__init__()
        self.open, self.cells = [], []

    def handle_starttag(self, tag, attrs):
        self.open += [tag] if tag != "meta" else []

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.cells += [data] if self.open and self.open[-1] == "td" else []


def test_documentation_lists_every_variable_and_the_licences(any_fmu):
    model = fmpy.read_model_description(str(any_fmu))
    with zipfile.ZipFile(any_fmu) as archive:
        page = archive.read("documentation/index.html").decode()
        own = archive.read("documentation/licenses/license.txt").decode()
        packager = archive.read("documentation/licenses/pythonfmu.txt").decode()
    parser = Cells()
    parser.feed(page)
    assert parser.open == []
    names = {v.name.partition("[")[0] for v in model.modelVariables} - {"time"}
    assert names <= set(parser.cells)
    assert "Redistribution and use" in own and "MIT" in packager


def test_nothing_of_the_building_machine_is_inside(any_fmu):
    told = [sys.prefix, sys.base_prefix, str(Path.home()), str(Path(__file__).parents[2])]
    told += [getpass.getuser()] if len(getpass.getuser()) > 5 else []
    with zipfile.ZipFile(any_fmu) as archive:
        for name in archive.namelist():
            data = archive.read(name)
            assert [word for word in told if word.encode() in data] == [], name
