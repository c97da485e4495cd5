"""models/whole_engine: six films, elastic bodies and a block on mounts at once."""

import numpy as np
import pytest

from piston_cosim.master.case.check import check
from piston_cosim.master.case.reading import find_case, read_tree

from ..command import call
from .runs import needs_compiler, run_tree, tight
from .shipped import BEARINGS, WHOLE, whole_engine
from .test_resume import goes_on
from .test_run_native import AGREES, PRODUCTS, RESIDUAL, ROUND_OFF_BY_ITSELF

OTHERS = ("tied.toml", "without_crank_films.toml")


def test_cases_for_comparison_have_no_faults():
    for name in ("whole_engine", *(str(WHOLE.parent / one) for one in OTHERS)):
        assert check(name).faults == []


def test_cases_for_comparison_differ_in_what_their_names_say():
    """They have the same skirt, cylinder, mounts and gas."""
    whole, *others = (
        read_tree(find_case(str(WHOLE.parent / one))) for one in ("case.toml", *OTHERS)
    )
    for tree in others:
        for keys in ("skirt_film.parameters", "bodies.build.block", "bodies.build.gas"):
            own, known = tree["participants"], whole["participants"]
            for key in keys.split("."):
                own, known = own[key], known[key]
            assert own == known
        own, known = (one["participants"]["block"]["parameters"] for one in (tree, whole))
        assert {key for key in known if own[key] != known[key]} <= {"mass"}
        assert tree["time"] == whole["time"]


@pytest.mark.slow
def test_a_killed_run_continues_with_the_same_bits(tmp_path):
    """The run of 12 deg ends as without the interruption, in all datasets."""
    words = ["run", "whole_engine", "--only", "whole", "--set", "time.stop=12 deg"]
    words += ["--set", "record.checkpoint_every=4", "--no-plots", "--output"]
    call(*words, tmp_path / "once").check_returncode()
    (tmp_path / "again").mkdir()
    goes_on(words, tmp_path / "again", "whole", tmp_path / "once/whole.h5")


@pytest.mark.slow
def test_native_participants_give_the_curves_of_those_in_python(tmp_path):
    """Every curve agrees to 1e-6 of its range at a tolerance of 0.1 nm.

    The films are native, and the bodies are those in Python.
    """
    needs_compiler()
    tree = tight(whole_engine(), "0.1 nm")
    native, python = (
        run_tree(WHOLE, tree | {"native": films}, tmp_path / f"{len(films)}.h5")
        for films in (["skirt_film", *BEARINGS], [])
    )
    curves, other = (one.structured() for one in (python, native))
    assert curves.dtype.names == other.dtype.names
    for name in curves.dtype.names:
        if not name.endswith((*ROUND_OFF_BY_ITSELF, PRODUCTS, RESIDUAL)):
            a, b = other[name], curves[name]
            size = max(np.ptp(b), np.abs(b).max())
            assert np.abs(a - b).max() <= AGREES * size, name
