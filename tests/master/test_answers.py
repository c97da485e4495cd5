"""Answers that are kept from one process to the next."""

import json
import subprocess
import sys

import pytest

from piston_cosim.master.fmi.quantities import from_si, to_si, worth

ASK = """
import sys
from piston_cosim.master.fmi.quantities import from_si, is_angle, is_known, to_si, worth
print(to_si("25 um", "m").hex(), is_angle("3 deg"), is_known("furlongs"), is_known("nothing"),
      worth("N", "m/s"), from_si(0.5, "m", "in"), to_si(2, "1"), to_si(2.0, "1"))
try:
    {wrong}
except ValueError as error:
    print(error)
print("pint" in sys.modules)
"""


def ask(wrong="raise ValueError('none')"):
    """What a process of its own says, and whether it has imported pint."""
    code = ASK.format(wrong=wrong)
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    *said, imported = run.stdout.splitlines()
    return said, imported == "True"


def test_a_second_process_has_the_same_answers_without_the_library(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    first, imported = ask()
    assert imported
    length, *others = first[0].split()
    assert float.fromhex(length) == pytest.approx(25e-6, rel=1e-15)
    assert others[:4] == ["True", "True", "False", "power"]
    assert ask() == (first, False)
    (kept,) = (tmp_path / "answers").iterdir()
    # what is raised is asked again, with what it says
    said, imported = ask("to_si('3 kg', 'm')")
    assert imported and said[1] == "expected a quantity in m, got '3 kg'; write for example '1 mm'"
    # a file that cannot be read, and a disk that keeps nothing
    kept.write_text(kept.read_text()[:20])
    assert ask() == (first, True) and ask() == (first, False)
    (tmp_path / "file").touch()
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "file"))
    assert ask() == (first, True)


def test_what_other_processes_have_kept_meanwhile_stays(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    ask()
    (kept,) = (tmp_path / "answers").iterdir()
    before = json.loads(kept.read_text())
    ask("to_si('7 mm', 'm')")
    assert json.loads(kept.read_text()) == before | {'["_by_pint", "7 mm", "m"]': 7e-3}


def test_products_and_conversions_by_hand():
    assert worth("Pa", "m3") == "energy" and worth("Pa.s", "m3/s2") == "power"
    assert worth("N", "s") not in ("energy", "power")
    assert from_si(0.0254, "m", "in") == pytest.approx(1.0, rel=1e-15)
    with pytest.raises(ValueError, match="m"):
        from_si(1.0, "m", "kg")
    assert to_si("1 in", "m") == pytest.approx(0.0254, rel=1e-15)
