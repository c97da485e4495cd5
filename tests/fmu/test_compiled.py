"""A kernel kept on disk is true to all it is made of: an edit in what it calls takes effect."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

STEP = """
import json, sys
import numpy as np
from piston_cosim.fmu_{part}.slave import {slave}
from piston_cosim.master.participants.local import LocalParticipant
assert sys.modules["piston_cosim"].__file__.startswith({tree!r})
one = LocalParticipant("one", {slave}(instance_name="one", resources={resources!r}))
one.start({parameters!r}, 0.0, 1.0)
one.step(0.0, 2e-5)
print(json.dumps(float(np.sum(one.get({output!r})))))
"""
PARTS = {
    "ehd": dict(
        slave="Ehd",
        parameters={"roughness_rms": 1e-6, "film_thickness": 1.5e-6},
        output="nodal_pressure_force",
    ),
    "mfbd": dict(slave="Mfbd", parameters={"crank_speed": 300.0}, output="sliding_velocity"),
}
LEAVES = {
    "ehd": ("fmu_ehd/hermite.py", "value = y0 +", "value = 2.0 * y0 +"),
    "mfbd": ("fmu_mfbd/dynamics/slider_crank.py", "slope = -xi / f", "slope = -2.0 * xi / f"),
}


class Tree:
    """A copy of the project, its compiled kernels included, and a step of one part in it."""

    def __init__(self, folder, part, fmu):
        self.part, self.tree = part, folder / "piston_cosim"
        self.resources = folder / "resources"
        for name in ("fmu_ehd", "fmu_mfbd", "master"):
            shutil.copytree(ROOT / name, self.tree / name)
        shutil.copy(ROOT / "__init__.py", self.tree)
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
        self.environment = os.environ | {"PYTHONPATH": str(folder), "HOME": str(folder)}

    def step(self):
        """The sum of a field after a step, in a new process."""
        chosen = PARTS[self.part]
        code = STEP.format(
            part=self.part, tree=str(self.tree), resources=str(self.resources), **chosen
        )
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, env=self.environment
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)


@pytest.fixture(params=["ehd", pytest.param("mfbd", marks=pytest.mark.slow)])
def tree(request, tmp_path, fmu, bodies_fmu):
    """Each part with the FMU whose resources its slave is given."""
    return Tree(tmp_path, request.param, {"ehd": fmu, "mfbd": bodies_fmu}[request.param])


def test_an_edited_leaf_takes_effect(tree):
    before = tree.step()
    file, old, new = LEAVES[tree.part]
    text = (tree.tree / file).read_text()
    assert old in text
    (tree.tree / file).write_text(text.replace(old, new))
    assert tree.step() != pytest.approx(before, rel=1e-6)
    (tree.tree / file).write_text(text)
    assert tree.step() == before
