"""Each notebook runs as it stands, in an empty folder; what it claims it asserts itself."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.py"))


def test_there_are_six():
    assert len(NOTEBOOKS) == 6


LONG = ("bearing", "first_piston", "response_surface")
"""Notebooks of more than 10 s, which .ci/nightly runs, here and for the site."""


@pytest.mark.parametrize(
    "notebook",
    [pytest.param(one, marks=[pytest.mark.slow] * (one.stem in LONG)) for one in NOTEBOOKS],
    ids=lambda path: path.stem,
)
def test_a_notebook_runs(notebook, tmp_path):
    cells = notebook.read_text().split("# %%")
    assert cells[0] == "" and cells[1].startswith(" [markdown]\n# # ")
    run = subprocess.run(
        [sys.executable, notebook],
        cwd=tmp_path,
        env=os.environ | {"MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    assert "Warning" not in run.stderr
