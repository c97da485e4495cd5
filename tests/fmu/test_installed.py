"""What is installed works beside other people's packages called `models` and `master`."""

import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PARTS = ("fmu_ehd", "fmu_mfbd", "master", "models")
FILES = ("__init__.py", "__main__.py", "py.typed", "LICENSE", "README.md", "pyproject.toml")
CASES = {"elastic_tube", "fired_motorcycle", "numerical_example", "two_mass_oscillator"}


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """Copy the sources of a wheel, so that building leaves nothing in the checkout."""
    copy = tmp_path_factory.mktemp("source")
    for name in (*PARTS, "tests/verification/cases"):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in FILES:
        shutil.copy(ROOT / name, copy)
    (copy / "docs").mkdir()
    shutil.copy(ROOT / "docs/references.md", copy / "docs")
    return copy


LARGEST_WHEEL = 6_000_000
"""Bytes: 3.0 MB of reduced bodies, half of them the static shapes that their modes leave out, and
at most 3 MB of meshes, pages and code."""


@pytest.fixture(scope="module")
def wheel(source, tmp_path_factory):
    """Build the wheel."""
    return built(source, tmp_path_factory.mktemp("wheel"))


def built(source, folder):
    """Build the wheel of a source tree with a fixed date."""
    build = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", folder, source]
    dated = os.environ | {"SOURCE_DATE_EPOCH": "1700000000"}
    subprocess.run(build, check=True, capture_output=True, env=dated)
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module", params=["wheel", pytest.param("editable", marks=pytest.mark.slow)])
def python(request, source, tmp_path_factory):
    """Interpreter of an environment with the wheel, or with the checkout installed as editable."""
    folder = tmp_path_factory.mktemp(request.param)
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    interpreter = folder / "bin" / "python"
    site = next(folder.glob("lib/python*/site-packages"))
    dependencies = Path(pytest.__file__).parents[1]  # numpy and all others, as they are here
    (site / "dependencies.pth").write_text(f"{dependencies}\n")
    what = [request.getfixturevalue("wheel")] if request.param == "wheel" else ["-e", source]
    install = [str(interpreter), "-m", "pip", "install", "-q", "--no-deps", *map(str, what)]
    subprocess.run(install, check=True, capture_output=True)
    return interpreter


@pytest.fixture
def crowded(tmp_path):
    """Return a folder with foreign packages of the parts' names, which fail on import."""
    for name in PARTS:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise RuntimeError('not ours')\n")
    return tmp_path


def said(interpreter, folder, *words):
    """Return the output of a command that runs in a folder that is on the path."""
    done = subprocess.run(
        [str(interpreter), "-m", *words], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_cases_are_listed_and_run_and_the_version_is_told(python, crowded):
    assert set(said(python, crowded, "piston_cosim", "list").split()) >= CASES
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert said(python, crowded, "piston_cosim", "--version").strip() == version
    words = ("run", "two_mass_oscillator", "--only", "linear", "--no-plots", "--output", "here")
    said(python, crowded, "piston_cosim", *words, "--set", "time.stop=0.1 s")
    assert list((crowded / "here").glob("*.h5"))


def test_an_fmu_carries_the_same_tree(fmu):
    """Every source file of the FMU is the project's, at its place in the tree, to the byte."""
    with zipfile.ZipFile(fmu) as archive:
        code = archive.read("resources/slavemodule.txt").decode().removesuffix("_entry")
        inside = {
            name.removeprefix(f"resources/{code}/"): archive.read(name)
            for name in archive.namelist()
            if name.startswith(f"resources/{code}/")
        }
    assert {"__init__.py", "fmu_ehd/slave.py", "master/fmi/slave.py"} <= set(inside)
    assert all((ROOT / name).read_bytes() == data for name, data in inside.items())


def test_a_wheel_is_one_small_package_and_the_same_again(wheel, source, tmp_path):
    tops = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"piston_cosim"}
    assert wheel.stat().st_size < LARGEST_WHEEL
    shutil.rmtree(source / "build", ignore_errors=True)
    again = built(source, tmp_path)
    assert again.read_bytes() == wheel.read_bytes()


def test_a_wheel_says_whose_it_is(wheel):
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        text = archive.read(name).decode()
        beside = [n for n in archive.namelist() if "tests/" in n or "docs/" in n]
        beside = [n for n in beside if "tests/verification/cases/" not in n]  # `verify` runs them
        assert beside == ["piston_cosim/docs/references.md"]  # `cite` reads it
    lines = ("Keywords: co-simulation", "Classifier: Typing :: Typed", "Author: The piston-cosim")
    assert [line for line in lines if line not in text] == []


@pytest.mark.slow
def test_a_source_distribution_has_the_tests(tmp_path):
    pytest.importorskip("build")
    copy = tmp_path / "checkout"
    skipped = shutil.ignore_patterns("__pycache__", ".*_cache", "*.whl", "*.egg-info")
    for path in ROOT.iterdir():
        if path.name in (".git", ".venv", "build", "dist", "results"):
            continue
        if path.is_dir():
            shutil.copytree(path, copy / path.name, ignore=skipped)
        else:
            copy.mkdir(exist_ok=True)
            shutil.copy(path, copy)
    subprocess.run(
        [sys.executable, "-m", "build", "--sdist", copy], check=True, capture_output=True
    )
    (made,) = (copy / "dist").iterdir()
    with tarfile.open(made) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    needed = {"tests/fmu/test_installed.py", "docs/pages.py", "CITATION.cff", ".ci/run"}
    assert needed - names == set()
