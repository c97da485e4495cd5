"""Runs of a coupled pair that are disturbed, and resumed until they end.

They are killed, frozen, starved of disk, or their files are damaged. Their tables must be those
of an undisturbed run, bit for bit.

A damaged checkpoint must be rejected with a message. The run then starts again, as a user would
do.
"""

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.fmi.compiler import compiler

from .c_fmus import compile_model
from .counter import LOOP, SOURCE, case_text, make
from .runs import datasets

STEPS = 4000
LONGEST = 120
"""Seconds that one call of the command may take before it counts as hung."""
BLOWS = ("kill", "interrupt", "freeze", "worker", "disk", "checkpoint", "cut", "results", "cache")


def tables(path):
    """All datasets of a results file."""
    return {name: np.asarray(one).tobytes() for name, one in datasets(path).items()}


class Chaos:
    """A case in a folder of its own, and what is done to it."""

    def __init__(self, folder, seed):
        self.folder, self.rng = folder, random.Random(seed)
        self.cache = folder / "cache"
        self.environment = os.environ | {
            "PISTON_COSIM_CACHE": str(self.cache),
            "OMP_NUM_THREADS": "1",
            "PYTHONFAULTHANDLER": "1",
        }
        self.seen = Counter()
        library = folder / "counter.so"
        compile_model(SOURCE, library)
        for name in "ab":
            make(folder / f"{name}.fmu", library)
        more = '[record]\ncheckpoint_every = 20\nfields = ["a.x"]\nevery = 7\n'
        text = case_text(LOOP, "iqn_ils", f"{STEPS / 100} s", "0.01 s", "k = 2.0", more=more)
        text = text.replace('fmu = "b.fmu"', 'fmu = "b.fmu"\nisolated = true\ntimeout = "5 s"')
        (folder / "case.toml").write_text(text)
        self.calm = tables(self.whole(folder / "calm"))

    def command(self, *words, limit=None):
        """Start the command; `limit`: largest file it may write [bytes], as on a full disk."""

        def narrow():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        return subprocess.Popen(
            [sys.executable, "-m", "piston_cosim", *map(str, words)],
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            preexec_fn=narrow if limit else None,
        )

    def said(self, process):
        """Return the output of a command; a traceback is a bug, and so is a hang."""
        try:
            said, _ = process.communicate(timeout=LONGEST)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGABRT)  # Python then says where it stands
            said, _ = process.communicate(timeout=LONGEST)
            raise AssertionError(f"it hangs, after {dict(self.seen)}: {said}") from None
        assert "Traceback" not in said, said
        return said

    def whole(self, output):
        """Return the results of an undisturbed run."""
        process = self.command("run", "case.toml", "--no-plots", "--output", output)
        said = self.said(process)
        assert process.returncode == 0, said
        return output / "base.h5"

    def round(self):
        """One run with blows until it ends; its tables are those of the calm one."""
        output = self.folder / "disturbed"
        shutil.rmtree(output, ignore_errors=True)
        results = output / "base.h5"
        words = ["run", "case.toml", "--no-plots", "--output", output]
        for _ in range(4):
            blow = self.rng.choice(BLOWS)
            self.seen[blow] += 1
            limit = self.rng.randrange(200_000, 900_000) if blow == "disk" else None
            process = self.command(*words, limit=limit)
            self.strike(blow, process, output)
            self.said(process)
            if process.returncode == 0:
                break
            self.damage(blow, results)
            kept = results.with_name("base.h5.checkpoint")
            words = ["resume", kept] if kept.exists() else words
        if not results.exists():
            results = self.end(words, output)
        assert tables(results) == self.calm, "another table than undisturbed"

    def end(self, words, output):
        """Undisturbed to the end: resumed, or from the start where that is refused."""
        process = self.command(*words)
        said = self.said(process)
        if process.returncode:
            assert process.returncode == 2, said
            self.seen["refused"] += 1
            shutil.rmtree(output, ignore_errors=True)
            return self.whole(output)
        return output / "base.h5"

    def strike(self, blow, process, output):
        """Do something to a run under way: Python itself, before it, is not what is tried."""
        begun, end = time.time(), time.monotonic() + 30
        while process.poll() is None and not is_written(output, begun) and time.monotonic() < end:
            time.sleep(0.01)
        time.sleep(self.rng.uniform(0.0, 1.5))
        if process.poll() is not None:
            return
        if blow == "kill":
            process.kill()
        elif blow == "freeze":
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.5)
            process.send_signal(signal.SIGCONT)
        elif blow == "worker":
            for child in children(process.pid):
                os.kill(child, signal.SIGKILL)
        elif blow != "disk":
            process.send_signal(signal.SIGINT)

    def damage(self, blow, results):
        """Damage a file that the run has left."""
        file = {
            "checkpoint": results.with_name("base.h5.checkpoint"),
            "cut": results.with_name("base.h5.checkpoint"),
            "results": results.with_name("base.h5.partial"),
        }.get(blow)
        if blow == "cache":
            found = [path for path in self.cache.rglob("*.so") if path.is_file()]
            file = self.rng.choice(found) if found else None
        if file is None or not file.exists():
            return
        data = bytearray(file.read_bytes())
        if blow in ("cut", "results"):  # a results file is cut: a flipped bit of a number is unseen
            del data[self.rng.randrange(len(data)) :]
        else:
            data[self.rng.randrange(len(data))] ^= 1 << self.rng.randrange(8)
        file.write_bytes(data)


def is_written(output, since):
    """Whether a run has begun to write its results since then."""
    partial = output / "base.h5.partial"
    try:
        return partial.stat().st_mtime > since
    except OSError:
        return False


def children(number):
    """Return the processes that a process has started, including those of its threads."""
    found = []
    for task in Path(f"/proc/{number}/task").glob("*"):
        found += map(int, (task / "children").read_text().split())
    return found


@pytest.mark.slow
@pytest.mark.skipif(not compiler(), reason="no C compiler")
def test_tables_are_those_of_an_undisturbed_run(tmp_path):
    seed = time.time_ns() % 2**31
    print("seed", seed)
    driver, end = Chaos(tmp_path, seed), time.monotonic() + 120
    while not driver.seen or time.monotonic() < end:
        driver.round()
