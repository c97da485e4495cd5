"""Code blocks of the pages run in their order, in an empty folder; shell commands do elsewhere.

Cases end after two steps, apart from runs whose stop time the page itself sets. Rigid ones have
a coarse grid.
"""

import re
import tomllib
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

import piston_cosim as pc
from piston_cosim.fmu_mfbd.build import declared_variables
from piston_cosim.master.api import cases
from piston_cosim.master.case.reading import read_tree

from ..command import call
from ..fmu.runs import coarse, run_tree

ROOT = Path(__file__).parents[2]
OWN_PISTON = ROOT / "docs/how_to/own_piston.md"


def blocks(page, language):
    """Return the code blocks of a page in a language, "" for those without one."""
    found = re.findall(r"(?ms)^```(\w*)[^\n]*\n(.*?)^```$", page.read_text())
    return [text for name, text in found if name == language]


@pytest.mark.parametrize(
    "name, sweep",
    [
        ("README.md", False),
        ("docs/python.md", False),
        ("docs/getting_started.md", False),
        pytest.param("docs/python.md", True, marks=pytest.mark.slow),
    ],
)
def test_python_of_a_page_runs(name, sweep, tmp_path, monkeypatch):
    """The quick test omits runs side by side, which take longer to start than all other blocks."""
    pytest.importorskip("xarray")
    monkeypatch.chdir(tmp_path)

    def opened(source, changes=None, variant=None):
        small = {"time.stop": "2 deg"} | (dict(coarse()) if variant == "rigid" else {})
        case = cases.open_case(source, small | (changes or {}), variant)
        timed = [k for k, one in enumerate(case.tree.get("pictures", [])) if "time" in one]
        return case.changed({f"pictures.{k}.time": "1 deg" for k in timed})

    monkeypatch.setattr(pc, "open_case", opened)
    code = "\n".join(
        one
        for one in blocks(ROOT / name, "python")
        if sweep or not re.search(r"pc\.(sweep|sensitivities)\(", one)
    )
    assert code.startswith("import piston_cosim as pc\n")
    try:
        exec(compile(code, name, "exec"), {})
    finally:
        plt.close("all")


def merged(tree, other):
    """Return a tree of tables with those of another one over it."""
    if not isinstance(tree, dict) or not isinstance(other, dict):
        return other
    return tree | {key: merged(tree.get(key, {}), value) for key, value in other.items()}


@pytest.fixture(scope="module")
def engine(tmp_path_factory):
    """Return the folder of the case `my_engine`, with the profile of the page."""
    folder = tmp_path_factory.mktemp("own")
    sizes = "--bore", 86, "--stroke", 86, "--rod", 143, "--speed", "6000 rpm"
    assert call("new", "my_engine", *sizes, folder=folder).returncode == 0
    (profile,) = (one for one in blocks(OWN_PISTON, "") if one.startswith("height,"))
    (folder / "my_engine/my_profile.csv").write_text(profile)
    return folder / "my_engine"


@pytest.mark.parametrize("block", blocks(OWN_PISTON, "toml"))
def test_tables_of_an_own_piston_run(block, engine, tmp_path):
    """Tables run for two steps. Those of the reader's own mesh lack only its files."""
    if block.startswith("extends"):
        variant = engine.parent / "smaller/case.toml"
        variant.parent.mkdir()
        variant.write_text(block)
        tree, path = read_tree(variant), variant
        assert tree["participants"]["bodies"]["parameters"]["radial_clearance"] == "20 um"
    else:
        path = engine / "case.toml"
        head = "" if block.startswith("[") else "[participants.bodies.build.piston]\n"
        tree = merged(read_tree(path), tomllib.loads(head + block))
    if "my_piston" in block:
        build = tree["participants"]["bodies"]["build"]
        build["piston"].pop("rigid", None)
        with pytest.raises(pc.BadInput) as caught:
            declared_variables(build, path.parent)
        assert [one for one in caught.value.faults if "expected a file in" not in one] == []
    else:
        tree["time"]["stop"] = "2 deg"
        run_tree(path, tree, tmp_path / "run.h5").close()
