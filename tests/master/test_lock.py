"""One writer for one file, whatever has become of the writers before."""

import json
import subprocess
import sys

import pytest

from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.runs.lock import lock_path, sole_writer

HOLD = """
import sys, time
from piston_cosim.master.runs.lock import sole_writer
with sole_writer(sys.argv[1]):
    print("held", flush=True)
    time.sleep(600)
"""


def test_the_second_writer_is_refused_and_one_that_died_gives_way(tmp_path):
    output = tmp_path / "folder" / "base.h5"
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(output)], stdout=subprocess.PIPE, text=True
    )
    assert holder.stdout.readline() == "held\n"
    with pytest.raises(BadInput, match=f"written by process {holder.pid} on .* since .*; wait"):
        with sole_writer(output):
            raise AssertionError
    holder.kill()
    holder.wait()
    assert lock_path(output).exists()  # what the dead process has left
    with sole_writer(output):
        assert json.loads(lock_path(output).read_text())["process"] != holder.pid
    assert not lock_path(output).exists()


def test_other_files_of_the_folder_are_free(tmp_path):
    with sole_writer(tmp_path / "a.h5"), sole_writer(tmp_path / "b.h5"):
        assert lock_path(tmp_path / "a.h5").exists()


def test_where_nothing_can_be_written_there_is_a_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="lock: expected a new name, got an existing"):
        with sole_writer(tmp_path / "file" / "a.h5"):
            raise AssertionError
