"""The three packages never import each other; kernels know no FMI."""

import ast
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

from ..command import script

ROOT = Path(__file__).parents[2]
PARTS = ("fmu_ehd", "fmu_mfbd", "master")
NAMES = {"piston_cosim", "models", *PARTS}
OF_KERNELS = {
    f"master.fmi.{name}" for name in ("compiled", "block", "noted", "odd_cells", "symmetry")
}
"""What kernels are made with, which knows nothing of FMI either."""
OUTER = {
    "user_input.py",
    "declaration.py",
    "slave.py",
    "native.py",
    "variables.py",
    "build.py",
    "options.py",
    "body_options.py",
    "reducing.py",
    "offline.py",
    "alone.py",
    "bearing.py",
    "preview.py",
    "preview_remarks.py",
    "preview_temperatures.py",
    "input_tables.py",
    "temperature_options.py",
    "native_walls.py",
    "profile_judgement.py",
    "profile_reader.py",
    "thrust_symmetry.py",
    "truncations.py",
}


def test_child_processes_import_no_module_from_the_folder():
    """Without -P, `python -m` and `python -c` put the current folder with its numpy.py first."""
    own = (path.read_text() for part in PARTS for path in (ROOT / part).rglob("*.py"))
    assert not [text for text in own if re.search(r'sys\.executable, "-[mc]"', text)]


def test_import_contracts_hold():
    run = subprocess.run(
        [
            sys.executable,
            "-c",
            "from importlinter.cli import lint_imports_command; lint_imports_command()",
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stdout + run.stderr


def imports(trees, *folders):
    """(path in the project, node) of each `from ... import ...` in folders."""
    for path, tree in trees.items():
        place = path.relative_to(ROOT)
        if place.parts[0] in folders:
            yield from ((place, one) for one in ast.walk(tree) if isinstance(one, ast.ImportFrom))


def test_kernels_know_no_fmi(trees):
    guilty = [
        f"{place}: {node.module}"
        for place, node in imports(trees, "fmu_ehd", "fmu_mfbd")
        if place.name not in OUTER
        and "master" in (node.module or "").split(".")
        and node.module not in OF_KERNELS
        and [alias.name for alias in node.names]
        not in (["file_fault"], ["read_rows"])  # readers of files
    ]
    assert guilty == []


def test_inside_the_project_every_import_is_relative(trees):
    """An FMU carries the same tree under a name of its own."""
    guilty = [
        f"{place}: {node.module}"
        for place, node in imports(trees, *PARTS)
        if not node.level and node.module.split(".")[0] in NAMES
    ]
    assert guilty == []


def test_every_room_is_installed(trees):
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    files = {path.relative_to(ROOT) for path in trees if path.name == "__init__.py"}
    # the root, models without those of a case, and `piston-cosim verify`
    rooms = {Path(), Path("models"), Path("tests/verification/cases")}
    rooms |= {path.parent for path in files if path.parts[0] in PARTS}
    assert set(listed) == {".".join(["piston_cosim", *room.parts]) for room in rooms}


ON_CONDA_FORGE = {"matplotlib": "matplotlib-base"}


def test_the_conda_recipe_needs_what_the_package_needs():
    """Version, dependencies with their bounds, and the command, from one list to the other."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    recipe = (ROOT / "conda.recipe" / "recipe.yaml").read_text()
    needed = [re.fullmatch(r"([\w-]+)(.*)", text) for text in project["dependencies"]]
    wanted = [f"{ON_CONDA_FORGE.get(one[1], one[1])} {one[2]}" for one in needed if one]
    run = recipe.partition("\n  run:\n")[2].partition("\n  run_constraints:")[0]
    listed = [line.strip().removeprefix("- ") for line in run.splitlines()]
    assert listed == ["__linux", f"python {project['requires-python']}", *wanted]
    constrained = recipe.partition("run_constraints:\n")[2].partition("\ntests:")[0]
    extra = project["optional-dependencies"]["xarray"]
    said = [line.strip(" -").replace(" ", "") for line in constrained.splitlines() if line]
    assert said == extra
    ((name, target),) = project["scripts"].items()
    assert f"- {name} = {target}" in recipe


HEAVY = (
    "numba",
    "numpy",
    "scipy",
    "matplotlib",
    "h5py",
    "pint",
    "pydantic",
    "skfem",
    "meshio",
    "fmpy",
    "gmsh",
    "xarray",
    "dask",
)


RUN = ("scipy.integrate", "scipy.ndimage", "scipy.optimize", "matplotlib", "numba")
"""What answers, judges and draws is imported when a run is done: a second of its start."""
CHECK = ("numba", "matplotlib.pyplot", "fmpy", "h5py", "pandas", "sympy", "jinja2", "gmsh")
CHECK += ("scipy.interpolate", "scipy.optimize", "scipy.ndimage", "scipy.integrate")


def test_commands_import_little(tmp_path):
    """`python -m piston_cosim` imports only the modules that a command needs.

    numpy alone takes as long as all of `--help`, other modules take 0.05 to 0.6 s.
    """
    check = ["check", "numerical_example", "--picture", str(tmp_path / "check.png")]
    first = [(["--help"], HEAVY), (["--version"], HEAVY), (check, CHECK)]
    for calls in (first, [(["run", "--help"], RUN)]):
        assert script(LOADED, json.dumps(calls)).splitlines()[-1] == "[]"
    assert (tmp_path / "check.png").read_bytes().startswith(b"\x89PNG")


LOADED = """
import json, runpy, sys
loaded = []
for arguments, avoided in json.loads(sys.argv[1]):
    sys.argv = ["piston-cosim", *arguments]
    try:
        runpy.run_module("piston_cosim", run_name="__main__")
    except SystemExit as ended:
        assert not ended.code, ended.code
    loaded += [(arguments, name) for name in avoided if name in sys.modules]
print(loaded)
"""


def test_importing_the_package_does_not_change_the_environment():
    """Matplotlib's backend stays the caller's: a notebook shows pictures by its own."""
    code = """
import os, pkgutil, sys
before = dict(os.environ)
import piston_cosim
import piston_cosim.master as master
for name in piston_cosim.__all__:
    getattr(piston_cosim, name)
for module in pkgutil.walk_packages(master.__path__, "piston_cosim.master."):
    __import__(module.name)
assert dict(os.environ) == before, os.environ.items() ^ before.items()
assert "matplotlib.pyplot" not in sys.modules
"""
    script(code)
