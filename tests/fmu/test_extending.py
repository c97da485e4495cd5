"""The changes that CONTRIBUTING describes need the files that it names, for Python and native FMUs.

Each is made in a copy of the package, which a new process runs.
"""

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from ..command import script
from .test_installed import FILES, PARTS, ROOT

VISCOSITY_LAW = {
    "fmu_ehd/laws/oil.py": [
        ('"walther_1931", "two_point")', '"walther_1931", "two_point", "reynolds_1886")'),
        (
            "    return x.viscosity + 0.0 * temperature\n",
            "    if kind == VISCOSITY_LAWS.reynolds_1886:\n"
            "        return x.viscosity * np.exp(-0.03 * (temperature - ZERO_CELSIUS))\n"
            "    return x.viscosity + 0.0 * temperature\n",
        ),
    ]
}
CAVITATION_MODEL = {
    "fmu_ehd/laws/cavitation.py": [
        (
            '    "full_film": Cavitation(False, False, False),\n',
            '    "full_film": Cavitation(False, False, False),\n'
            '    "clipped": Cavitation(False, True, True),\n',
        )
    ]
}
OUTPUT = {
    "fmu_ehd/state.py": [
        (
            "    stored_energy: Annotated[",
            '    twice_the_power: Annotated[float, "W", "Twice the friction power", 100.0]\n'
            "    stored_energy: Annotated[",
        )
    ],
    "fmu_ehd/step.py": [
        (
            "        stored_energy=",
            "        twice_the_power=2.0 * acting.powers.friction,\n        stored_energy=",
        )
    ],
}
COUPLING_METHOD = {
    "master/coupling/methods/__init__.py": [
        ('"constant", "explicit")', '"constant", "explicit", "picard")'),
        ("from .quasi_newton", "from .picard import Picard\nfrom .quasi_newton"),
        (
            '    if coupling.method == "explicit":\n',
            '    if coupling.method == "picard":\n        return Picard()\n'
            '    if coupling.method == "explicit":\n',
        ),
    ]
}
PICARD = '''
import numpy as np
from .solution import Solution


class Picard:
    """Fixed-point iteration without relaxation."""

    def memory(self):
        return None

    def solve(self, macro_step, guess, memory=None):
        at = macro_step.evaluate(guess)
        history = [macro_step.interface.measure(at.residual, at.outputs)]
        while history[-1] > 1.0:
            at = macro_step.evaluate(np.where(macro_step.interface.feedback, at.outputs, at.used))
            history.append(macro_step.interface.measure(at.residual, at.outputs))
        return Solution(at.used, tuple(history), len(history) - 1, 0)
'''
COMMAND_OPTION = {
    "master/commands/list.py": [
        ("def command():\n", "def command(titles: bool = True):\n"),
        (
            '    Example: piston-cosim list\n    """\n',
            "    Example: piston-cosim list\n\n"
            "    Parameters\n    ----------\n    titles : bool\n        Show the titles.\n"
            '    """\n',
        ),
        ('tree.get("title", "")', 'tree.get("title", "") if titles else ""'),
    ]
}

FILM = """
import json, sys
import numpy as np
from pathlib import Path
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import build_native_fmu
from piston_cosim.master.fmi.compiler import this_platform
from piston_cosim.master.participants.fmi2 import FmuParticipant

folder = Path(sys.argv[1])
here = [this_platform()]
files = {
    "python": build_fmu("fmu_ehd", {"grid": [12, 10]}, folder, print),
    "native": build_native_fmu("fmu_ehd", {"grid": [12, 10]}, folder, print, platforms=here),
}
angle = 2 * np.pi * (np.arange(12) + 0.5) / 12
rise = (np.arange(10) - 4.5) / 10
film = 2e-5 * (1 + 0.5 * np.cos(angle)[:, None]) * (1 + 0.4 * rise)
runs = json.loads(sys.argv[2])
found = {}
for kind, path in files.items():
    for name, given in runs.items():
        one = FmuParticipant("film", path)
        chosen = {
            key: one.fields[key].choices[value] if isinstance(value, str) else value
            for key, value in given.items()
        }
        one.start(chosen | {"film_thickness": film, "sliding_velocity": film * 0 + 5.0}, 0.0, 1.0)
        one.step(0.0, 1e-4)
        found[f"{kind} {name}"] = {
            key: np.asarray(one.get(key)).tolist()
            for key in ("pressure", "friction_power", "twice_the_power")
        }
        one.close()
print("FOUND", json.dumps(found))
"""


def changed(folder, *changes):
    """Copy the package into a folder and make changes; return the environment that runs it."""
    package = folder / "piston_cosim"
    package.mkdir()
    without = shutil.ignore_patterns("__pycache__", "*.so", "build")
    for name in FILES:
        shutil.copy(ROOT / name, package)
    for name in PARTS:
        shutil.copytree(ROOT / name, package / name, ignore=without)
    for change in changes:
        for name, edits in change.items():
            text = (package / name).read_text()
            for old, new in edits:
                assert text.count(old) == 1, f"{name}: {old!r} stands there {text.count(old)} times"
                text = text.replace(old, new)
            (package / name).write_text(text)
    return os.environ | {"PYTHONPATH": str(folder)}


@pytest.mark.slow
def test_law_cavitation_model_and_output_in_both_films(tmp_path):
    environment = changed(tmp_path, VISCOSITY_LAW, CAVITATION_MODEL, OUTPUT)
    hot = {"oil_temperature_lower_edge": 313.15, "oil_temperature_upper_edge": 313.15}
    runs = {
        "law": hot | {"viscosity_law": "reynolds_1886", "viscosity": 0.1},
        "constant": hot | {"viscosity_law": "constant", "viscosity": 0.1 * np.exp(-0.03 * 40.0)},
        "clipped": {"cavitation_model": "clipped"},
        "reynolds": {"cavitation_model": "reynolds"},
    }
    told = script(FILM, tmp_path, json.dumps(runs), env=environment)
    found = json.loads(told.partition("FOUND ")[2])
    for kind in ("python", "native"):
        law, constant = found[f"{kind} law"], found[f"{kind} constant"]
        # one exp of the C library or of numpy, another one of the test: round-off of 1e-15 each
        np.testing.assert_allclose(law["pressure"], constant["pressure"], rtol=1e-12)
        assert np.max(law["pressure"]) > 1e3
        assert found[f"{kind} clipped"]["pressure"] == found[f"{kind} reynolds"]["pressure"]
        assert law["twice_the_power"] == 2.0 * law["friction_power"] != 0.0


def test_coupling_method_and_command_option(tmp_path):
    environment = changed(tmp_path, COUPLING_METHOD, COMMAND_OPTION)
    (tmp_path / "piston_cosim/master/coupling/methods/picard.py").write_text(PICARD)
    summary = tmp_path / "summary.json"
    run = ["run", "two_mass_oscillator", "--set", "time.stop=0.05 s", "--no-plots"]
    run += ["--set", "coupling.method=picard", "--set", "coupling.predictor=0"]
    commands = [[*run, "--summary-json", str(summary)], ["list", "--no-titles"]]
    for command in commands:
        whole = [sys.executable, "-m", "piston_cosim", *command]
        done = subprocess.run(whole, env=environment, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    assert "two_mass_oscillator" in done.stdout
    assert "order of" not in done.stdout  # of its title
    assert json.loads(summary.read_text())["mean_iterations"] > 1.0
