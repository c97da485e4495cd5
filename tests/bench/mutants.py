"""Mutation bench: deliberate errors, one at a time, and whether the fast tests notice.

    python tests/bench/mutants.py [--only PATTERN] [--workers N]

`mutants.toml` holds the errors. Each is put into a copy of the tree of its own, and the fast tier
(tests/ehd, tests/mfbd, tests/master) runs there until a test fails: first the tests that concern
the changed part, then the others. An error survives only if the whole tier passes.

Printed are every error with its fate, its time and the test that noticed, then the survivors.
Exit code 1 if fewer than 90 % are killed, or if a recorded text does not stand exactly once in its
file (stale); 2 if the tier fails on the unchanged tree, for then it proves nothing. With `--only`
just the tests that noticed something are tried there.

Copies share files by hard links: what changes is written anew. Kernels are compiled once, in the
copy they are all made of, and again only where an error reaches them (`master/fmi/compiled.py`).
The user's cache is not touched: reduced bodies are kept by their options, not by the code that made
them, so an error in the bodies begins with an empty one.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MUTANTS = Path(__file__).with_suffix(".toml")
PARTS = ("__init__.py", "__main__.py", "py.typed", "pyproject.toml", "README.md", "tests")
PARTS += ("fmu_ehd", "fmu_mfbd", "master", "models", "docs")
"""What a copy is made of."""
FAST = {"fmu_ehd": "tests/ehd", "fmu_mfbd": "tests/mfbd", "master": "tests/master"}
"""The fast tier: the tests of each part."""
NEEDED = 0.9
"""Share that must be killed."""
TIMEOUT = 900.0
"""Seconds for one run of pytest: several times what the whole tier takes. Who hangs is noticed."""
TESTS_FAILED, INTERRUPTED = 1, 2
"""Exit codes of pytest: a test failed; a test module could not even be imported."""


@dataclass(frozen=True)
class Mutant:
    """One deliberate error.

    file : in the tree; old, new : text that stands there once, and what takes its place; breaks :
    what is wrong then, in a sentence; first : test file that should notice, run before all others.
    """

    file: str
    old: str
    new: str
    breaks: str
    first: str = ""

    @property
    def part(self):
        return self.file.split("/")[0]

    def stale(self, root):
        """Why it cannot be put into the tree, or an empty text."""
        path = root / self.file
        count = path.read_text().count(self.old) if path.is_file() else 0
        return "" if count == 1 else f"{self.file}: {self.old!r} stands there {count} times"

    def put_into(self, root):
        """Change the file; a new one takes its place, for the old one may be shared by links."""
        path = root / self.file
        text = path.read_text().replace(self.old, self.new)
        path.unlink()
        path.write_text(text)


@dataclass(frozen=True)
class Fate:
    """What became of a mutant: whether it was killed, by which test, after how many seconds."""

    mutant: Mutant
    killed: bool
    by: str
    seconds: float


def read_mutants(path):
    """The recorded mutants."""
    return [Mutant(**entry) for entry in tomllib.loads(path.read_text())["mutant"]]


def copy_tree(source, target, copy=shutil.copy2):
    """The parts of a tree that tests need, with what has been compiled."""
    target.mkdir(parents=True)
    for name in PARTS:
        part = source / name
        if part.is_dir():
            shutil.copytree(part, target / name, copy_function=copy)
        elif part.exists():
            copy(part, target / name)


def pytest(tree, cache, tests):
    """Exit code and output of pytest in a tree, which is found before any that is installed."""
    settings = {
        "PYTHONPATH": str(tree.parent),
        "PISTON_COSIM_CACHE": str(cache),
        "OMP_NUM_THREADS": "1",
    }
    command = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", "--tb=line", *tests]
    try:
        run = subprocess.run(
            command,
            cwd=tree,
            env=os.environ | settings,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=TIMEOUT,
        )
    except subprocess.TimeoutExpired:
        return TESTS_FAILED, f"FAILED no end within {TIMEOUT:.0f} s"
    return run.returncode, run.stdout


def stages(mutant):
    """Lists of tests to run one after the other: the likeliest first, then the whole tier."""
    own = FAST.get(mutant.part, FAST["master"])
    others = [folder for folder in FAST.values() if folder != own]
    return [stage for stage in ([mutant.first], [own], others) if stage != [""]]


def fate_of(mutant, base, base_cache, folder):
    """Try one mutant in a copy of its own; RuntimeError if pytest itself went wrong."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        tree, cache = Path(scratch) / "piston_cosim", Path(scratch) / "cache"
        copy_tree(base, tree, os.link)
        if mutant.part == "fmu_mfbd" or not base_cache.exists():
            cache.mkdir()
        else:
            shutil.copytree(base_cache, cache, copy_function=os.link)
        mutant.put_into(tree)
        for tests in stages(mutant):
            code, text = pytest(tree, cache, tests)
            if code in (TESTS_FAILED, INTERRUPTED):
                return Fate(mutant, True, noticed(text), time.perf_counter() - begin)
            if code:
                raise RuntimeError(f"pytest ended with {code} on {mutant.file}:\n{text}")
    return Fate(mutant, False, "", time.perf_counter() - begin)


def unsound(base, cache, fates):
    """2 if a test that noticed something fails on the unchanged tree as well, else 0."""
    noticing = sorted({fate.by for fate in fates if fate.killed})
    code, text = pytest(base, cache, noticing) if noticing else (0, "")
    if code:
        print(f"what noticed fails on the unchanged tree:\n{text}")
    return 2 if code else 0


def noticed(text):
    """The test that failed, from pytest's output."""
    failures = re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", text, re.MULTILINE)
    return failures[0] if failures else FAST["master"]


def report(fates):
    """Print the survivors and the share that was killed; returns that share."""
    survivors = [fate.mutant for fate in fates if not fate.killed]
    print(f"\n{len(survivors)} of {len(fates)} survive")
    for mutant in survivors:
        print(f"  {mutant.file}: {mutant.old!r} -> {mutant.new!r}\n    {mutant.breaks}")
    share = 1.0 - len(survivors) / len(fates)
    print(f"killed: {share:.1%}, needed {NEEDED:.0%}")
    return share


def arguments():
    """What the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", default="", help="regular expression: in file, text or sentence")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    return parser.parse_args()


def main():
    """Run the bench; the exit code."""
    given = arguments()
    mutants = read_mutants(MUTANTS)
    stale = [why for mutant in mutants if (why := mutant.stale(ROOT))]
    print(*[f"stale: {why}" for why in stale], sep="\n", end="\n" if stale else "")
    wanted = [
        mutant
        for mutant in mutants
        if re.search(given.only, f"{mutant.file} {mutant.old} {mutant.breaks}")
        and not mutant.stale(ROOT)
    ]
    if not wanted:
        print("no mutant to try")
        return 1
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        base, cache = Path(folder) / "base" / "piston_cosim", Path(folder) / "base" / "cache"
        copy_tree(ROOT, base)
        if not given.only:
            code, text = pytest(base, cache, FAST.values())
            if code:
                print(f"the tier fails on the unchanged tree:\n{text}")
                return 2
        fates = []
        with ThreadPoolExecutor(given.workers) as pool:
            tried = [pool.submit(fate_of, mutant, base, cache, folder) for mutant in wanted]
            for future in as_completed(tried):
                fates.append(fate := future.result())
                word = "killed  " if fate.killed else "SURVIVED"
                print(f"{word} {fate.seconds:6.0f} s  {fate.mutant.file}: {fate.mutant.breaks}")
                print(f"                   {fate.by}", flush=True)
        if given.only and (code := unsound(base, cache, fates)):
            return code
    return int(report(fates) < NEEDED or bool(stale))


if __name__ == "__main__":
    sys.exit(main())
