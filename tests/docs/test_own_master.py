"""The page "Your own master": its program alone gives what `run` gives."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np

import piston_cosim as pc

from ..command import call
from ..fmu.runs import coarse

PAGE = Path(__file__).parents[2] / "docs/tutorials/own_master.md"
STEPS = 20
PRINTED = "ehd.minimum_film_thickness", "ehd.maximum_pressure", "bodies.side_force"


def test_the_program_of_the_page_gives_what_run_gives(tmp_path):
    """The FMUs start with the values of the case, its variant and `--set`.

    Both iterate until the film changes by less than 1 pm, a ten-millionth of the thinnest film.
    Forces then agree to about 1e-7.
    """
    _, program = re.findall(r"(?ms)^```(python)\n(.*?)^```$", PAGE.read_text())[0]
    (tmp_path / "own_master.py").write_text(program)
    changes = dict(coarse(("viscosity", "12 mPa s"), ("crank_speed", "5000 rpm")))
    asked = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    for name, file in (("ehd", "film.fmu"), ("bodies", "bodies.fmu")):
        words = ["numerical_example", "--variant", "rigid", *asked, "--output", file]
        assert call("fmu", "build", name, "--case", *words, folder=tmp_path).returncode == 0
    command = [sys.executable, "own_master.py", "film.fmu", "bodies.fmu", str(STEPS)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rows = np.array([line.split() for line in done.stdout.splitlines()[:STEPS]], float)
    exact = {"time.stop": f"{STEPS} deg", "wires.0.tolerance": "1 pm", "wires.1.tolerance": 1e-9}
    case = pc.open_case("numerical_example", changes | exact, "rigid")
    results = case.run(tmp_path / "run.h5")
    for column, port in enumerate(PRINTED, 1):
        values = results.series(port).values[1:]
        assert np.abs(rows[:, column] / values - 1.0).max() < 1e-6, port
