"""Kernels kept on disk: true to what they call, made again when damaged, done without
if need be."""

import fcntl
import os
import shutil
import subprocess
import sys

import pytest

from ..command import script

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


class Package:
    """A package of three kernels, each calling the next, in a folder of its own."""

    def __init__(self, folder):
        self.folder, self.home = folder, folder / "kernels"
        self.home.mkdir()
        for name, text in (("__init__", ""), ("leaf", LEAF), ("middle", MIDDLE), ("top", TOP)):
            (self.home / f"{name}.py").write_text(text)
        self.environment = os.environ | {"PYTHONPATH": str(folder), "HOME": str(folder)}

    def top(self):
        """(top(3), how many times the top kernel was read from disk), in a new process."""
        value, hits = self.printed("top(3.0), sum(top.dispatcher.stats.cache_hits.values())")
        return float(value), int(hits)

    def printed(self, what, module="top"):
        """Words of an expression in the names of a module, in a new process."""
        code = f"from kernels.{module} import *\nprint({what})"
        return script(code, env=self.environment).split()

    def kept(self, ending):
        """Files of kept kernels."""
        return list(self.home.rglob(f"*.{ending}"))


@pytest.fixture
def package(tmp_path):
    return Package(tmp_path)


def test_a_kept_kernel_is_read_again(package):
    assert package.top() == (70.0, 0)
    assert package.top() == (70.0, 1)


def test_an_edit_two_calls_away_takes_effect(package):
    assert package.top() == (70.0, 0)
    # of another length: Python itself tells two files of one second and one length not apart
    (package.home / "leaf.py").write_text(LEAF.replace("2.0", "4.00"))
    assert package.top() == (130.0, 0)
    assert package.top() == (130.0, 1)


def test_a_process_waits_for_a_kernel_that_another_one_compiles(package):
    """The other process is this one: it holds the lock, and brings the kernels while it does."""
    package.top()
    files = {path: path.read_bytes() for path in (*package.kept("nbi"), *package.kept("nbc"))}
    for path in files:
        path.unlink()
    (lock,) = (path for path in package.kept("lock") if ".callee" not in path.name)
    read = "sum(top.dispatcher.stats.cache_hits.values())"
    code = f"from kernels.top import top\nprint(top(3.0), {read})"
    with lock.open() as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        command = [sys.executable, "-c", code]
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, text=True, env=package.environment
        ) as other:
            with pytest.raises(subprocess.TimeoutExpired):
                other.wait(6)
            for path, content in files.items():
                path.write_bytes(content)
            fcntl.flock(held, fcntl.LOCK_UN)
            assert other.communicate(timeout=60)[0].split() == ["70.0", "1"]


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_a_damaged_kernel_is_made_again(package, ending):
    package.top()
    for path in package.kept(ending):
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert package.top() == (70.0, 0)
    assert package.top() == (70.0, 1)


def test_a_kernel_in_the_code_of_others_is_lowered_once_and_never_made_ready(package):
    """Another kernel that calls it, in another process, finds it kept."""
    read = "sum(inner.callee.stats.cache_hits.values()), 'dispatcher' in vars(inner)"
    assert package.printed(f"top(3.0), {read}") == ["70.0", "0", "False"]
    assert package.printed(f"other(3.0), {read}") == ["6.0", "1", "False"]
    assert package.printed("inner(3.0)") == ["7.0"]


def test_kernels_of_one_name_from_different_processes_stay_apart(package):
    """Each process compiles another `times`, as the first kernel or the second one of all."""
    (package.home / "family.py").write_text(FAMILY)
    for call, value in (("twice(1.0)", "2.0"), ("thrice(1.0)", "3.0"), ("both(1.0)", "32.0")):
        assert package.printed(call, "family") == [value]


@pytest.mark.parametrize("start", ["first", "second"])
def test_what_a_kernel_within_another_raises_reaches_python(package, start):
    if start == "second":
        package.top()
    (package.home / "raises.py").write_text(
        "from kernels.top import top\n"
        "try:\n    top(-1.0)\nexcept ValueError as fault:\n    words = fault.args\n"
    )
    words = package.printed("*__import__('kernels.raises', fromlist=['']).words")
    assert words == ["negative", "-1.0"]


def test_a_kernel_is_compiled_where_nothing_can_be_kept(package):
    """A file stands wherever there would be a folder for it."""
    shutil.rmtree(package.home / "__pycache__", ignore_errors=True)
    (package.home / "__pycache__").write_text("")
    package.environment |= {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null"}
    package.environment |= {"PYTHONDONTWRITEBYTECODE": "1"}
    assert package.top() == (70.0, 0)
    assert not package.kept("nbi")
