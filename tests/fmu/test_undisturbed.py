"""Faults that must not break a run.

An FMU hangs or changes the working directory, a point of a sweep never ends, or archives and
names are made to do harm.
"""

import csv
import pickle
import signal
import time
import zipfile

import fmpy
import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.fmi.archive import unpack
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.participants.open import open_fmu
from piston_cosim.master.results.file import Results

from ..command import begun, ended
from .counter import LOOP, case_text
from .waiting import wait_for

RUN = ("run", "case.toml", "--no-plots", "--output", "o")


@pytest.fixture(autouse=True)
def case(folder):
    (folder / "case.toml").write_text(case_text(LOOP))


def hangs(folder, step):
    """Write the case with an FMU that hangs at a step."""
    text = case_text(LOOP, b=f"trouble = 1\ntrouble_at = {step}")
    (folder / "case.toml").write_text(text)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_second_signal_ends_a_run_whose_fmu_hangs(folder, number):
    hangs(folder, 3)
    process = begun(folder, *RUN)
    wait_for((folder / "o" / "base.h5.partial").exists)
    time.sleep(0.5)  # it may still be on the way to the fourth step
    process.send_signal(number)
    time.sleep(0.5)
    assert process.poll() is None  # one signal waits for the macro step
    process.send_signal(number)
    _, told = ended(process, 128 + number, 10)
    assert "repeat the signal to stop immediately" in told and "Traceback" not in told
    # and what it has left is in nobody's way
    (folder / "case.toml").write_text(case_text(LOOP))
    ended(begun(folder, *RUN))


def test_an_fmu_that_changes_the_working_directory_does_not_matter(folder):
    words = ("--no-plots", "--output", "here/o", "--summary-json", "here.json")
    told = ended(begun(folder, "run", "case.toml", *words))
    assert "results  here/o/base.h5" in told[0]
    assert (folder / "here/o/base.h5").exists() and (folder / "here.json").exists()


def test_points_that_hang_or_cannot_run_are_rows_and_the_rest_is_done(folder):
    hangs(folder, -1)
    vary = "--vary=participants.b.parameters.trouble_at=-1;3;-2"
    words = ["sweep", "case.toml", vary, "--workers=1", "--output=s"]
    for limit in ("8 s", "1 s"):  # the second sweep repeats only what hangs
        told = ended(begun(folder, *words, f"--time-limit={limit}"), 1)
        with open(folder / "s" / "sweep.csv") as file:
            rows = list(csv.DictReader(file))
        assert [row["status"] for row in rows] == ["done", "failed", "done"]
        assert f"time limit of {limit} exceeded" in rows[1]["message"]
    assert "1 of 3 points failed" in told[1]
    times = [Results(folder / "s" / row["results"]).time for row in rows if row["status"] == "done"]
    assert np.array_equal(times[0], times[1]) and times[0][-1] == 1.0


PICTURE = '[[pictures]]\nfile = "{}"\ntitle = "t"\nkind = "lines"\nx = "a.x"\ny = [["b.x"]]\n'


@pytest.mark.parametrize("name", ["../x", "/tmp/x", "a/../x", "..", "a\\\\b", ""])
@pytest.mark.parametrize(
    "more", [PICTURE, '[variants."{}"]\n"coupling.predictor" = 1\n', 'label = "{}"\n']
)
def test_names_of_files_stay_in_the_output_folder(tmp_path, more, name):
    text = case_text(LOOP)
    added = more.format(name)
    text = added + text if more.startswith("label") else text + added
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(BadInput, match="expected a file name"):
        check_case(read_tree(tmp_path / "case.toml"), tmp_path)


def test_an_archive_that_would_fill_the_disk_is_refused_before_it_is_unpacked(folder):
    with zipfile.ZipFile(folder / "a.fmu", "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("resources/zeros", bytes(2**27))
    with pytest.raises(BadInput, match="expected at most 200 times the packed .* MB, got 134 MB"):
        open_fmu("a", folder / "a.fmu")
    with zipfile.ZipFile(folder / "b.fmu", "a") as archive:
        archive.writestr("../../x", b"out")
    with pytest.raises(BadInput, match="expected files inside it, got path '../../x'"):
        open_fmu("b", folder / "b.fmu")


def test_damaged_files_of_the_cache_are_named_and_whole_again(folder, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(folder / "cache"))
    unpacked = unpack(folder / "a.fmu")
    library_there = unpacked / "binaries" / "linux64" / "counter.so"
    whole = library_there.read_bytes()
    for damaged in (whole[:-1], b"X" + whole[1:], None):
        library_there.unlink()
        if damaged is not None:
            library_there.write_bytes(damaged)
        with pytest.warns(UserWarning, match="was damaged; restored .*counter.so"):
            unpack(folder / "a.fmu")
        assert library_there.read_bytes() == whole


def test_a_description_is_read_once_and_again_where_what_was_kept_is_damaged(folder, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(folder / "cache"))
    reads = []
    read = fmpy.read_model_description

    def counted(path, **options):
        reads.append(path)
        return read(path, **options)

    monkeypatch.setattr(fmpy, "read_model_description", counted)
    first = open_fmu("a", folder / "a.fmu")
    again = open_fmu("a", folder / "a.fmu")
    assert len(reads) == 1
    assert again.fields == first.fields and list(again.fields) == list(first.fields)
    assert {"x", "u", "k"} <= first.fields.keys()
    assert again.description.guid == first.description.guid
    assert repr(again.description.coSimulation) == repr(first.description.coSimulation)
    (kept,) = (folder / "cache" / "descriptions").iterdir()
    for damaged in (kept.read_bytes()[:-20], b"", pickle.dumps(None)):
        kept.write_bytes(damaged)
        assert open_fmu("a", folder / "a.fmu").fields == first.fields
        assert open_fmu("a", folder / "a.fmu").fields == first.fields
    assert len(reads) == 4
    other = folder / "a.fmu"
    with zipfile.ZipFile(other) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    said = members["modelDescription.xml"]
    members["modelDescription.xml"] = said.replace(b'name="k"', b'name="stiffness"')
    with zipfile.ZipFile(other, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    assert "stiffness" in open_fmu("a", other).fields  # the same name, another content


def test_where_no_description_can_be_kept_it_is_read_each_time(folder, monkeypatch):
    fields = open_fmu("a", folder / "a.fmu").fields
    monkeypatch.setattr(
        "piston_cosim.master.participants.description.cache_folder",
        lambda kind: folder / "not" / "there",
    )
    assert open_fmu("a", folder / "a.fmu").fields == fields
