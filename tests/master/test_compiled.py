"""Compiled kernels are cached on disk.

They follow edits of the functions that they call, are rebuilt when damaged, and are optional.
"""

import fcntl
import shutil
import sys
import time
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path

import pytest

LEAF = """
from piston_cosim.master.fmi.compiled import compiled

@compiled(inline="always")
def leaf(x):
    return 2.0 * x
"""
MIDDLE = """
from piston_cosim.master.fmi.compiled import compiled
from .leaf import leaf

@compiled
def middle(x):
    if x < 0.0:
        raise ValueError("negative", x)
    return leaf(x) + 1.0
"""
TOP = """
from piston_cosim.master.fmi.compiled import compiled
from . import middle

inner = middle.middle

@compiled
def top(x):
    return 10.0 * inner(x)

@compiled
def other(x):
    return inner(x) - 1.0
"""
FAMILY = """
from piston_cosim.master.fmi.compiled import compiled

def multiplied(factor):
    @compiled
    def times(x):
        return factor * x

    return times

double, triple = multiplied(2.0), multiplied(3.0)

@compiled
def twice(x):
    return double(x)

@compiled
def thrice(x):
    return triple(x)

@compiled
def both(x):
    return twice(x) + 10.0 * thrice(x)
"""
READ = "sum(top.dispatcher.stats.cache_hits.values())"
"""How many times the top kernel was read from disk."""


def evaluated(folder, module, what):
    """Value of an expression in the names of a module of the package."""
    sys.path.insert(0, str(folder))
    return eval(what, vars(import_module(f"kernels.{module}")))


class Package:
    """A package of three kernels, each calling the next, in a folder of its own."""

    def __init__(self, folder):
        import_module("piston_cosim.master.fmi.kernel_cache")  # once for all processes
        self.folder, self.home = folder, folder / "kernels"

    def found(self, what, module="top"):
        """Value of an expression in the names of a module, in a new process."""
        with get_context("fork").Pool(1) as pool:
            return pool.apply(evaluated, (self.folder, module, what))

    def top(self):
        return self.found(f"(top(3.0), {READ})")

    def kept(self, ending):
        """Files of kept kernels."""
        return list(self.home.rglob(f"*.{ending}"))


def written(folder):
    package = Package(folder)
    package.home.mkdir()
    for name, text in (("__init__", ""), ("leaf", LEAF), ("middle", MIDDLE), ("top", TOP)):
        (package.home / f"{name}.py").write_text(text)
    return package


@pytest.fixture
def fresh(tmp_path):
    """Return a package without compiled kernels."""
    return written(tmp_path)


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    package = written(tmp_path_factory.mktemp("first"))
    assert package.top() == (70.0, 0)
    return package


@pytest.fixture
def package(first, tmp_path):
    """Return a package with cached kernels."""
    shutil.copytree(first.home, tmp_path / "kernels")
    return Package(tmp_path)


def test_an_edit_two_calls_away_takes_effect(package):
    assert package.top() == (70.0, 1)
    # of another length: Python itself tells two files of one second and one length not apart
    (package.home / "leaf.py").write_text(LEAF.replace("2.0", "4.00"))
    assert package.top() == (130.0, 0)
    assert package.top() == (130.0, 1)


def test_a_process_waits_for_a_kernel_that_another_one_compiles(package):
    """The other process is this one: it holds the lock, and brings the kernels while it does."""
    files = {path: path.read_bytes() for path in (*package.kept("nbi"), *package.kept("nbc"))}
    for path in files:
        path.unlink()
    (lock,) = (path for path in package.kept("lock") if ".callee" not in path.name)
    with get_context("fork").Pool(1) as pool, lock.open() as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        other = pool.apply_async(evaluated, (package.folder, "top", f"(top(3.0), {READ})"))
        opened = Path(f"/proc/{pool._pool[0].pid}/fd")
        while lock.resolve() not in [path.resolve() for path in opened.iterdir()]:
            time.sleep(0.01)
        time.sleep(0.1)  # one that does not wait has found no kernel by then
        for path, content in files.items():
            path.write_bytes(content)
        fcntl.flock(held, fcntl.LOCK_UN)
        assert other.get(60) == (70.0, 1)


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_a_damaged_kernel_is_made_again(package, ending):
    for path in package.kept(ending):
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert package.top() == (70.0, 0)
    assert package.top() == (70.0, 1)


def test_a_kernel_in_the_code_of_others_is_lowered_once_and_never_made_ready(fresh):
    """Another kernel that calls it, in another process, finds it kept."""
    read = "sum(inner.callee.stats.cache_hits.values()), 'dispatcher' in vars(inner)"
    assert fresh.found(f"(top(3.0), {read})") == (70.0, 0, False)
    assert fresh.found(f"(other(3.0), {read})") == (6.0, 1, False)
    assert fresh.found("inner(3.0)") == 7.0


def test_kernels_of_one_name_from_different_processes_stay_apart(fresh):
    """Each process compiles another `times`, as the first kernel or the second one of all."""
    (fresh.home / "family.py").write_text(FAMILY)
    for call, value in (("twice(1.0)", 2.0), ("thrice(1.0)", 3.0), ("both(1.0)", 32.0)):
        assert fresh.found(call, "family") == value


@pytest.mark.parametrize("start", ["fresh", "package"])
def test_what_a_kernel_within_another_raises_reaches_python(request, start):
    with pytest.raises(ValueError) as fault:
        request.getfixturevalue(start).found("top(-1.0)")
    assert fault.value.args == ("negative", -1.0)


def test_a_kernel_is_compiled_where_nothing_can_be_kept(fresh, monkeypatch):
    """A file stands wherever there would be a folder for it."""
    (fresh.home / "__pycache__").write_text("")
    monkeypatch.setenv("HOME", "/dev/null")
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    assert fresh.top() == (70.0, 0)
    assert not fresh.kept("nbi")
