"""A short part of fuzz.py: damaged model descriptions, case files and tables give a sentence."""

from . import fuzz


def test_damage_is_told_by_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "cache"))
    outcomes, bugs = fuzz.fuzz(300, tmp_path, fuzz.descriptions())
    assert not bugs, next(iter(bugs.values()))
    # the undamaged case is taken, so that damage reaches every part of what is checked
    assert outcomes["taken"] > 30 and outcomes["refused"] > 100
