"""Checkpoints contain no code and do not grow.

If they are damaged or belong to another version or another FMU, a message rejects them.
"""

import os
import pickle
from dataclasses import replace

import numpy as np
import pytest

from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.checkpoint import (
    CHECKSUM,
    MAGIC,
    VERSION,
    Checkpoint,
    check_code,
    source_hashes,
)

from ..command import call
from .c_fmus import Variable, make_reported
from .counter import LOOP, case_text, make
from .runs import run_tree, stopped

SUMMARY = '[summary]\nmean = "mean a.x"\nleast = "min b.x"\nsum = "last b.number_sum"\n'


def interrupted(folder, at, method="iqn_ils", every=5, stop="9 s"):
    """Return the results file and the summary of a run that is stopped at a time [s]."""
    text = case_text(
        [*LOOP, ("a.n", "b.number", "")],
        method=method,
        stop=stop,
        a="k = 2.0",
        more=f"[record]\ncheckpoint_every = {every}\n{SUMMARY}",
    )
    path, output = folder / "case.toml", folder / f"{at:g}.h5"
    path.write_text(text)
    if at < np.inf:
        stopped(path, read_tree(path), output, at)
        return output, None
    return output, run_tree(path, read_tree(path), output).summary


def resumed(path):
    """Exit code and error text of `piston-cosim resume`."""
    done = call("resume", path)
    return done.returncode, done.stderr


@pytest.mark.parametrize("method", ["newton", "iqn_ils", "iqn_ageing", "aitken"])
def test_resumed_the_bits_are_the_same(folder, method):
    whole, summary = interrupted(folder, np.inf, method, stop="3 s")
    output, _ = interrupted(folder, 1.55, method, stop="3 s")
    assert resumed(Checkpoint.path(output)) == (0, "")
    one, other = Results(whole), Results(output)
    for port in one.ports:
        assert np.array_equal(one.series(port).values, other.series(port).values), port
    same = {key for key in summary if not key.startswith("wall_time")}
    assert {key: summary[key] for key in same} == {key: other.summary[key] for key in same}


def test_a_run_with_a_table_is_resumed_and_another_table_is_rejected(folder):
    text = case_text([("b.u", "a.u", "")], stop="3 s", more="[record]\ncheckpoint_every = 5\n")
    path, table, output = (folder / name for name in ("table.toml", "b.csv", "table.h5"))
    path.write_text(text.replace('fmu = "b.fmu"', 'table = "b.csv"'))
    rows = "time [s], u\n0, 1\n3, 4\n"
    table.write_text(rows)
    run_tree(path, read_tree(path), whole := folder / "whole.h5")
    stopped(path, read_tree(path), output, 1.55)
    table.write_text(rows.replace("4", "5"))
    code, text = resumed(Checkpoint.path(output))
    assert code == 2 and "expected the file of b that began the run" in text
    table.write_text(rows)
    assert resumed(Checkpoint.path(output)) == (0, "")
    one, other = (Results(file).series("a.x").values for file in (whole, output))
    assert np.array_equal(one, other)


def test_warnings_before_a_checkpoint_are_in_the_summary(folder):
    """Of a kind at the start, one before the checkpoint, and one on both sides of it."""
    early = 'if(t<0.25)logged(I,1,"cold");if(t>0.35)logged(I,1,t<1?"left at 0.4":"left at 1.0")'
    part = {"ENTER": 'logged((void*)m,1,"licence ends")', "STEP": early}
    flags = 'canSerializeFMUstate="true"'
    make_reported(folder / "w.fmu", "2.0", [Variable("y", 1, "output")], flags=flags, **part)
    text = case_text([], stop="3 s", fmus=("w.fmu", "b.fmu"), more="[record]\ncheckpoint_every = 5")
    path, output = folder / "warned.toml", folder / "warned.h5"
    path.write_text(text)
    stopped(path, read_tree(path), output, 1.55)
    assert resumed(Checkpoint.path(output)) == (0, "")
    assert Results(output).summary["warnings"] == [
        "a: at the start, 1 time: licence ends",
        "a: t = 0 s, 3 times: cold",
        "a: t = 0.4 s, 26 times: left at 0.4",
    ]


def test_its_size_does_not_grow_with_the_run(folder):
    sizes = [
        Checkpoint.path(interrupted(folder, at)[0]).stat().st_size for at in (2.05, 4.05, 8.05)
    ]
    # the secants are full from the third step on; numbers have more or fewer digits
    assert max(sizes) - min(sizes) < 200


@pytest.fixture
def checkpoint(folder):
    return Checkpoint.path(interrupted(folder, 1.05)[0])


def test_what_is_damaged_anywhere_is_refused(checkpoint):
    whole = checkpoint.read_bytes()
    for place in np.linspace(0, len(whole) - 1, 20).astype(int):
        flipped = bytearray(whole)
        flipped[place] ^= 1
        checkpoint.write_bytes(flipped)
        with pytest.raises(BadInput, match="damaged|version|layout"):
            Checkpoint.read(checkpoint)
        checkpoint.write_bytes(whole[:place])
        with pytest.raises(BadInput, match="damaged|version|layout"):
            Checkpoint.read(checkpoint)
    checkpoint.write_bytes(whole[:-1])
    code, text = resumed(checkpoint)
    assert code == 2 and "expected an intact checkpoint, got another checksum" in text


def test_one_of_another_layout_is_refused(checkpoint):
    whole = bytearray(checkpoint.read_bytes())
    whole[len(MAGIC)] = VERSION + 1
    checkpoint.write_bytes(whole)
    expected = f"expected a checkpoint of layout {VERSION}, got layout {VERSION + 1}"
    with pytest.raises(BadInput, match=expected):
        Checkpoint.read(checkpoint)


class Trap:
    """Makes a file when it is unpickled."""

    def __reduce__(self):
        return os.mkdir, ("trapped",)


def test_a_crafted_file_runs_nothing(checkpoint, tmp_path, monkeypatch):
    from hashlib import sha256

    monkeypatch.chdir(tmp_path)
    trap = pickle.dumps(Trap())
    head = MAGIC + VERSION.to_bytes(4, "little")
    for data in (trap, head + sha256(trap).digest() + trap):
        checkpoint.write_bytes(data)
        with pytest.raises(BadInput, match="expected a checkpoint|cannot read the checkpoint"):
            Checkpoint.read(checkpoint)
    assert not (tmp_path / "trapped").exists()
    assert CHECKSUM == sha256().digest_size


def test_an_fmu_that_has_changed_since_is_refused_and_one_built_again_is_not(
    folder, checkpoint, library
):
    make(folder / "a.fmu", library, names={"heard_length": "length"})
    code, text = resumed(checkpoint)
    assert code == 2 and "a.fmu: expected the FMU of the run, got another content" in text
    (folder / "a.fmu").unlink()
    make(folder / "a.fmu", library)  # the same content, other times in the archive
    assert resumed(checkpoint)[0] == 0


def test_without_the_results_so_far_it_is_refused(checkpoint):
    partial = checkpoint.with_suffix(".partial")
    whole = partial.read_bytes()
    damaged = "1.05.h5.partial: expected results so far, got a damaged file"
    # HDF5 looks for what was cut off without an end: found by `test_chaos.py`
    for data, words in (
        (None, "expected the results so far, got no such file"),
        (b"no results", damaged),
        (whole[: len(whole) // 50], damaged),
    ):
        partial.unlink()
        if data is not None:
            partial.write_bytes(data)
        code, text = resumed(checkpoint)
        assert code == 2 and words in text
        partial.touch()


def test_code_that_a_checkpoint_names_is_compared_before_it_is_executed(folder):
    output, _ = interrupted(folder, 1.55)
    path = Checkpoint.path(output)
    kept = Checkpoint.read(path)
    evil = folder / "evil.py"
    evil.write_text(f"open({str(folder / 'ran')!r}, 'w')\n")
    kept.tree["participants"]["a"] = {"file": f"{evil}:Evil"}
    kept.write(output)
    code, text = resumed(path)
    assert code == 2 and str(evil) in text
    assert "a.file: expected the Python file of the run, got another" in text
    assert not (folder / "ran").exists()


def test_resume_lists_the_code_that_it_executes(folder):
    output, _ = interrupted(folder, 1.55)
    kept = Checkpoint.read(Checkpoint.path(output))
    lines = []
    check_code(kept, lines.append)
    assert lines == [f"executes participants.{name}.fmu = {folder / name}.fmu" for name in "ab"]
    lag = folder / "lag.py"
    lag.write_text("class Lag: pass\n")
    tree = {"participants": {"c": {"file": "lag.py:Lag"}}}
    named = replace(kept, tree=tree, sources=source_hashes(tree, folder))
    check_code(named, lines.append)
    assert lines[-1] == f"executes participants.c.file = {lag}"
    lag.write_text("class Lag: other = 1\n")
    (folder / "a.fmu").unlink()
    for changed in (named, kept):
        with pytest.raises(BadInput):
            check_code(changed, print)
