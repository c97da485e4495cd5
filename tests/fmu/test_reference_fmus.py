"""Modelica's Reference-FMUs alone under the master, against the results that they carry.

The folder named by PISTON_COSIM_REFERENCE_FMUS holds them, of FMI 2.0 and 3.0, in any sub-folders;
without it the test is skipped.
"""

import csv
import os
import zipfile
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.participants.open import open_fmu

from .runs import run_tree

FOLDER = os.environ.get("PISTON_COSIM_REFERENCE_FMUS", "")
FMUS = sorted(Path(FOLDER).rglob("*.fmu")) if FOLDER else []
WITHOUT = {
    "Clocks": "is for scheduled execution alone",
    "Roberts": "carries the results of BouncingBall",
}
TOLERANCE = 1e-12  # the same arithmetic: what the CSV rounds, 16 digits


def reference(fmu):
    """Columns of the CSV in an FMU: name -> list of texts; None without one."""
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.endswith("_out.csv")]
        if not names:
            return None
        head, *rows = csv.reader(archive.read(names[0]).decode().splitlines())
    return {name: list(column) for name, column in zip(head, zip(*rows))}


def numbers(column):
    """Values of a column: numbers, truth values, or arrays of numbers with spaces between."""
    said = {"true": "1", "false": "0"}
    return np.squeeze([[float(said.get(t, t)) for t in text.split(" ")] for text in column])


of_each = pytest.mark.parametrize("fmu", FMUS, ids=lambda path: str(path.relative_to(FOLDER)))
pytestmark = pytest.mark.skipif(not FMUS, reason="PISTON_COSIM_REFERENCE_FMUS names no folder")


def ran(folder, time, recorded, wires=(), **participants):
    """Results of a case."""
    tree = {
        "title": "reference",
        "time": time,
        "participants": participants,
        "wires": list(wires),
        "coupling": {"order": list(participants)},
        "record": {"fields": recorded},
    }
    return run_tree(folder / "case", tree, folder / "o.h5")


@of_each
def test_alone_to_its_own_reference(fmu, tmp_path):
    if fmu.stem in WITHOUT:
        pytest.skip(f"{fmu.stem} {WITHOUT[fmu.stem]}")
    columns = reference(fmu)
    assert columns, "the FMU carries no reference results"
    time = numbers(columns.pop("time"))
    fields = open_fmu("one", fmu).fields
    wanted = [n for n in columns if n in fields and fields[n].type not in ("String", "Binary")]
    assert wanted
    times = {"start": time[0], "stop": time[-1], "step": time[1] - time[0]}
    times = {name: f"{value} s" for name, value in times.items()}
    results = ran(tmp_path, times, [f"one.{name}" for name in wanted], one={"fmu": str(fmu)})
    for name in wanted:
        found, expected = results.dataset(f"one.{name}")[:], numbers(columns[name])
        close = {"rtol": TOLERANCE, "atol": TOLERANCE, "err_msg": name}
        np.testing.assert_allclose(np.squeeze(found), expected, **close)


GIVEN = {"Real": 1.5, "Integer": 7, "Boolean": True}


def matched(fields):
    """Pairs of an output and an input of the same type and shape, every input once."""
    outputs = [f for f in fields.values() if f.causality == "output" and f.type in GIVEN]
    inputs = [f for f in fields.values() if f.causality == "input" and f.type in GIVEN]
    pairs = []
    for field in outputs:
        kind = (field.native, field.type, field.shape)
        for inlet in inputs:
            if (inlet.native, inlet.type, inlet.shape) == kind:
                pairs.append((field, inlet))
                inputs.remove(inlet)
                break
    return pairs


@of_each
def test_in_a_wired_pair(fmu, tmp_path):
    """The inputs of the second FMU equal the outputs of the first.

    Real values agree at the end of the same step, held ones a step later.
    """
    if fmu.stem == "Clocks":
        pytest.skip(f"{fmu.stem} {WITHOUT[fmu.stem]}")
    pairs = matched(open_fmu("one", fmu).fields)
    if not pairs:
        pytest.skip(f"{fmu.stem} has no inputs that its outputs fit")
    wires = [{"from": f"one.{a.name}", "to": f"two.{b.name}"} for a, b in pairs]
    values = {
        b.name: np.full(b.shape, GIVEN[b.type]).tolist() if b.shape else GIVEN[b.type]
        for _, b in pairs
    }
    two = {"fmu": str(fmu)}
    recorded = [port for wire in wires for port in wire.values()]
    one, time = two | {"parameters": values}, {"stop": "1 s", "step": "0.1 s"}
    results = ran(tmp_path, time, recorded, wires, one=one, two=two)
    for a, b in pairs:
        said, heard = results.dataset(f"one.{a.name}")[:], results.dataset(f"two.{b.name}")[:]
        spoken = said[1:] if a.type == "Real" else said[:-1]
        np.testing.assert_array_equal(heard[1:], spoken, err_msg=f"{a.name} -> {b.name}")
        assert np.any(said)
