"""The page "Couple your FMUs": its script and its case file run, and give the closed form."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import piston_cosim as pc

from ..command import call

PAGE = Path(__file__).parents[2] / "docs/tutorials/couple.md"


def blocks(language):
    """Code blocks of the page."""
    return re.findall(rf"(?ms)^```{language}\n(.*?)^```$", PAGE.read_text())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the page's Python and its case file, both of which were run."""
    folder = tmp_path_factory.mktemp("couple")
    (folder / "script.py").write_text("\n".join(blocks("python")))
    (folder / "case.toml").write_text(blocks("toml")[0])
    words = [sys.executable, "script.py"]
    script = subprocess.run(words, cwd=folder, check=True, capture_output=True, text=True)
    assert "1000 steps," in script.stdout and "evaluations per step" in script.stdout
    assert call("run", "case.toml", "--output", "results", folder=folder).returncode == 0
    return folder


def test_the_script_is_as_short_as_promised():
    assert len(blocks("python")[1].splitlines()) <= 20


def test_the_script_gives_the_closed_form(folder):
    """The error of the script is 2.8 % of 1 m after 1 s, and 0.13 % after 0.1 s.

    Inputs held at the end of a step are of order 1, so the error is proportional to the step of 1
    ms.
    """
    results = pc.open_results(folder / "coupled.h5")
    t = results.time
    exact = (np.cos(2 * np.pi * t) + np.cos(6 * np.pi * t)) / 2
    found = results.series("left.displacement").values
    assert np.abs(found - exact).max() < 0.03
    assert np.abs(found[:100] - exact[:100]).max() < 0.002


@pytest.mark.parametrize("inputs, named", [("held", 0.028), ("mean", 0.00012), ("linear", 0.00006)])
def test_the_errors_of_inputs_are_those_of_the_page(folder, inputs, named):
    changes = {f"participants.{name}.fmu": str(folder / "mass.fmu") for name in ("left", "right")}
    case = pc.open_case(folder / "case.toml", changes | {"coupling.inputs": inputs})
    results = case.run(folder / f"{inputs}.h5")
    t = results.time
    exact = (np.cos(2 * np.pi * t) + np.cos(6 * np.pi * t)) / 2
    error = np.abs(results.series("left.displacement").values - exact).max()
    assert error == pytest.approx(named, rel=0.05)  # two digits
    assert f"{named:.5f}".rstrip("0") in PAGE.read_text()


def test_the_case_file_is_the_same_run(folder):
    runs = [
        pc.open_results(folder / name).series("left.displacement").values
        for name in ("coupled.h5", "results/base.h5")
    ]
    assert np.array_equal(*runs)
