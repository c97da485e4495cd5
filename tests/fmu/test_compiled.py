"""A kernel kept on disk is true to all it is made of: an edit in what it calls takes effect."""

import json
import os
import shutil
from pathlib import Path

import pytest

from piston_cosim.master.fmi.tree import code_digest

from ..command import script

ROOT = Path(__file__).parents[2]


@pytest.fixture
def tree(tmp_path):
    """A copy of the project, its compiled kernels included."""
    for name in ("fmu_ehd", "fmu_mfbd", "master"):
        shutil.copytree(ROOT / name, tmp_path / "piston_cosim" / name)
    shutil.copy(ROOT / "__init__.py", tmp_path / "piston_cosim")
    return tmp_path / "piston_cosim"


def value(tree):
    """What `posture` gives in a new process of the copy, and how many kernels it had to compile."""
    code = """
import json
import numpy as np
from numba.core import event
compiled = event.RecordingListener()
event.register("numba:compile", compiled)
from piston_cosim.fmu_mfbd.dynamics.carrier import FIXED
from piston_cosim.fmu_mfbd.dynamics.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.dynamics.piston_motion import posture
from piston_cosim.fmu_mfbd.dynamics.slider_crank import CrankMotion, Mechanism
mechanism = Mechanism(0.05, 0.15, 0.0, 0.5, 1e-3, 0.3, 0.1)
crank = CrankMotion(1.0, 300.0, 0.0)
value = posture(mechanism, FIXED, Motion(*np.zeros((3, 2))), crank).link.axial_acceleration
starts = [one for _, one in compiled.buffer if one.is_start]
print(json.dumps([__import__("piston_cosim").__file__, float(value), len(starts)]))
"""
    environment = os.environ | {"PYTHONPATH": str(tree.parent), "HOME": str(tree.parent)}
    file, found, count = json.loads(script(code, env=environment))
    assert file == str(tree / "__init__.py")
    return found, count


CODE = '''"""A module."""
import numpy  # of arrays


def double(x):
    """Return the double."""
    return 2 * x  # twice
'''


@pytest.mark.parametrize(
    "edited, same",
    [
        (("Return the double.", "Return 2 x.\n\n    Eq. (A1)"), True),
        (("# twice", "# the double"), True),
        (("import numpy", "\n\nimport numpy"), True),
        (("return 2 * x", "return 3 * x"), False),
        (("    return 2", '    "# x"\n    return 2'), False),
    ],
)
def test_the_digest_of_code_ignores_its_text(edited, same):
    one, other = CODE.encode(), CODE.replace(*edited).encode()
    assert (code_digest(one) == code_digest(other)) == same


def test_an_edited_leaf_takes_effect(tree):
    """In another file than the kernel called."""
    file = tree / "fmu_mfbd/dynamics/slider_crank.py"
    text = file.read_text()
    assert "axial = py + f1 *" in text
    before, _ = value(tree)
    assert value(tree) == (before, 0)  # kept
    file.write_text(text.replace("axial = py + f1 *", "axial = 2.0 * py + f1 *"))
    assert value(tree)[0] != pytest.approx(before, rel=1e-6)
    file.write_text(text)
    assert value(tree)[0] == before
