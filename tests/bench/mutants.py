"""Mutation bench: deliberate errors, one at a time, and whether the fast tests notice.

    python tests/bench/mutants.py [--only PATTERN] [--workers N]
    python tests/bench/mutants.py --check

`mutants.toml` holds the errors. Each is put into a copy of the tree of its own, where tests run
until one fails: first the quick ones of the changed part, with kernels interpreted, for most of the
time would go into compiling them (`interpreted.py`); then, for what is left, the whole fast tier
(tests/ehd, tests/mfbd, tests/master) as it stands. An error survives only if that passes.

Printed are every error with its fate, its time and the test that noticed, then the survivors.
Exit code 1 if fewer than 90 % are killed, or if a recorded text does not stand exactly once in its
file (stale; `--check` looks for these alone, in a second); 2 if the tests fail on the unchanged
tree, for then they prove nothing.

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
LEFT_OUT = ("build", "dist", "results", "site")
"""What a copy is made without; nothing of it is under version control."""
HIDDEN = (".ci", ".github")
"""Hidden folders that tests read."""
FAST = {"fmu_ehd": "tests/ehd", "fmu_mfbd": "tests/mfbd", "master": "tests/master"}
"""The fast tier: the tests of each part."""
QUICK = {
    "fmu_ehd": "values_flows values values_contact values_oil asperity film_step films",
    "fmu_mfbd": "values_kernels values floating_frame values_bodies bases finite_element",
    "master": "values_stepping values_methods values_run values_results",
}
"""Of these, the files that need no large body and no picture, likeliest first."""
INTERPRETED = ("fmu_ehd", "fmu_mfbd")
"""Parts whose quick tests run with interpreted kernels."""
COMPILED = ("fmu_ehd/balance/transport.py", "fmu_ehd/balance/oil_layer.py")
"""Files whose own tests take too many steps for that."""
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
    what is wrong then, in a sentence; first : the quick test file that is likeliest to
    notice; test : the one that notices in place of all quick ones, with compiled kernels.
    """

    file: str
    old: str
    new: str
    breaks: str
    first: str = ""
    test: str = ""

    @property
    def part(self):
        return self.file.split("/")[0].replace("models", "master")  # their tests are the master's

    def stale(self, root):
        """Why it cannot be put into the tree and tried there, or an empty text."""
        if self.part not in FAST:
            return f"{self.file}: no tests are fast for {self.part}"
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
    """Return the recorded mutants, each with the test file that is likeliest to detect it."""
    record = tomllib.loads(path.read_text())
    first = record.pop("first")
    return [
        Mutant(file, **entry, first=first.get(file, ""))
        for file, entries in record.items()
        for entry in entries
    ]


def copy_tree(source, target, copy=shutil.copy2):
    """Copy a tree with the compiled files."""
    target.mkdir(parents=True)
    for part in source.iterdir():
        hidden = part.is_dir() and part.name.startswith(".") and part.name not in HIDDEN
        if hidden or part.name in LEFT_OUT:
            continue
        if part.is_dir():
            shutil.copytree(part, target / part.name, copy_function=copy)
        else:
            copy(part, target / part.name)


def pytest(tree, cache, tests, interpreted=False):
    """Exit code and output of pytest in a tree, which is found before any that is installed."""
    settings = {
        "PYTHONPATH": os.pathsep.join([str(tree.parent), str(tree / "tests" / "bench")]),
        "PISTON_COSIM_CACHE": str(cache),
        "OMP_NUM_THREADS": "1",
    }
    command = [sys.executable, "-m", "pytest", "-n", "0", "-x", "-p", "no:cacheprovider"]
    command += ["--tb=line", *tests]
    if interpreted:
        command += ["-p", "interpreted"]
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
    if run.returncode < 0:
        return TESTS_FAILED, f"{run.stdout}\nFAILED the process died of signal {-run.returncode}"
    return run.returncode, run.stdout


def quick_tests(part):
    """Return the quick test files of a part."""
    return [f"{FAST[part]}/test_{name}.py" for name in QUICK[part].split()]


def is_interpreted(mutant):
    """Whether the quick tests of a mutant run with interpreted kernels."""
    return mutant.part in INTERPRETED and mutant.file not in COMPILED and not mutant.test


def stages(mutant, quick):
    """Return lists of tests to run one after the other, the likeliest to fail first.

    Most mutants need only the first list. Collecting all others takes longer than running it.
    """
    if not quick:
        own = FAST[mutant.part]
        return [[own, *(other for other in FAST.values() if other != own)]]
    if mutant.test:
        return [[mutant.test]]
    files = quick_tests(mutant.part)
    first = mutant.first or files[0]
    rest = [file for file in files if file != first]
    return [stage for stage in ([first], rest) if stage]


def fate_of(mutant, base, base_cache, folder, quick):
    """Try one mutant in a separate copy, on the quick tests of its part or on the whole tier.

    Raise RuntimeError if pytest itself fails.
    """
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        tree, cache = Path(scratch) / "piston_cosim", Path(scratch) / "cache"
        copy_tree(base, tree, os.link)
        if mutant.part == "fmu_mfbd" or not base_cache.exists():
            cache.mkdir()
        else:
            shutil.copytree(base_cache, cache, copy_function=os.link)
        mutant.put_into(tree)
        for tests in stages(mutant, quick):
            code, text = pytest(tree, cache, tests, quick and is_interpreted(mutant))
            if code:
                break
    if code not in (0, TESTS_FAILED, INTERRUPTED):
        raise RuntimeError(f"pytest ended with {code} on {mutant.file}:\n{text}")
    return Fate(mutant, bool(code), noticed(text) if code else "", time.perf_counter() - begin)


def try_all(mutants, workers, quick, **places):
    """Return the fates of all mutants, and print each as it arrives."""
    fates = []
    with ThreadPoolExecutor(workers) as pool:
        tried = [pool.submit(fate_of, mutant, quick=quick, **places) for mutant in mutants]
        for future in as_completed(tried):
            fates.append(fate := future.result())
            left = "left    " if quick else "SURVIVED"
            word = "killed  " if fate.killed else left
            print(f"{word} {fate.seconds:6.0f} s  {fate.mutant.file}: {fate.mutant.breaks}")
            print(f"                   {fate.by}", flush=True)
    return fates


def unsound(runs, base, cache):
    """Whether one of the runs, (tests, interpreted), fails on the unchanged tree; says so."""
    for tests, interpreted in runs:
        code, text = pytest(base, cache, tests, interpreted)
        if code:
            print(f"the tests fail on the unchanged tree:\n{text}", flush=True)
            return True
    return False


def noticed(text):
    """Return the failed test named in pytest's output.

    Raise RuntimeError if there is none, because pytest itself failed then.
    """
    failures = re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", text, re.MULTILINE)
    if not failures:
        raise RuntimeError(f"pytest failed without a test that did:\n{text}")
    return failures[0]


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
    """Return the arguments of the command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", default="", help="regular expression: in file, text or sentence")
    parser.add_argument("--check", action="store_true", help="only tell the stale records")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    return parser.parse_args()


def main():
    """Run the bench; the exit code."""
    given = arguments()
    mutants = read_mutants(MUTANTS)
    stale = [why for mutant in mutants if (why := mutant.stale(ROOT))]
    print(*[f"stale: {why}" for why in stale], sep="\n", end="\n" if stale else "")
    if given.check:
        print(f"{len(mutants)} records, {len(stale)} stale")
        return int(bool(stale))
    wanted = [
        mutant
        for mutant in mutants
        if re.search(given.only, f"{mutant.file} {mutant.old} {mutant.breaks}")
        and not mutant.stale(ROOT)
    ]
    if not wanted:
        print("no mutant to try")
        return 1
    parts = sorted({mutant.part for mutant in wanted})
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        base, cache = Path(folder) / "base" / "piston_cosim", Path(folder) / "base" / "cache"
        places = {"base": base, "base_cache": cache, "folder": folder}
        copy_tree(ROOT, base)
        before = [(quick_tests(part), part in INTERPRETED) for part in parts]
        own = {mutant.first for mutant in wanted if mutant.file in COMPILED}
        own = sorted(own | {mutant.test for mutant in wanted if mutant.test})
        before += [(own, False)] if own else []
        if unsound(before, base, cache):
            return 2
        quick = try_all(wanted, given.workers, quick=True, **places)
        fates = [fate for fate in quick if fate.killed]
        left = [fate.mutant for fate in quick if not fate.killed]
        if left:
            print(f"\n{len(left)} left for the whole tier", flush=True)
            if unsound([(FAST.values(), False)], base, cache):
                return 2
            fates += try_all(left, given.workers, quick=False, **places)
    return int(report(fates) < NEEDED or bool(stale))


if __name__ == "__main__":
    sys.exit(main())
