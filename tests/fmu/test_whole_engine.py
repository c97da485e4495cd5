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


ZERO = (
    *("bodies.pin_tilt_x", "bodies.pin_tilt_y"),
    *(f"{one}_film.friction_force_hydrodynamic" for one in ("small_end", "big_end", "main")),
)
"""Curves that are zero by symmetry about the plane of the crank: 1e-12 rad and 3e-4 N are left."""


def native_and_python(tree, native, folder):
    """Return the curves of a run with native participants, and of one in Python, by name."""
    needs_compiler()
    ours, known = (
        run_tree(WHOLE, tree | {"native": one}, folder / f"{len(one)}.h5").structured()
        for one in (native, [])
    )
    assert ours.dtype.names == known.dtype.names
    aside = (*ROUND_OFF_BY_ITSELF, PRODUCTS, RESIDUAL)
    names = [name for name in known.dtype.names if not name.endswith(aside)]
    return {name: (ours[name], known[name]) for name in names}


def apart(ours, known):
    """Return the largest difference of two curves over their range or size."""
    return np.abs(ours - known).max() / max(np.ptp(known), np.abs(known).max(), 1e-300)


def tightened(tree, share):
    """Return the tree with a share of all tolerances."""

    def tight_wire(wire):
        number, *unit = str(wire["tolerance"]).split(" ", 1)
        size = share * float(number)
        return wire | {"tolerance": f"{size:.3g} {unit[0]}" if unit else size}

    wires = [tight_wire(one) if "tolerance" in one else one for one in tree["wires"]]
    return tree | {"wires": wires}


@pytest.mark.slow
def test_native_films_and_bodies_give_the_curves_of_those_in_python(tmp_path):
    """Every curve agrees to 1e-6 of its range at a tolerance of 0.01 nm.

    All wires have a thousandth of the case's tolerances. Bodies follow numpy's BLAS in Python
    alone, so that an iteration ends elsewhere within the tolerances. The largest difference is
    2e-7. With a hundredth (0.1 nm) it is 4e-6: differences follow the tolerances.
    """
    tree = tightened(tight(whole_engine(), "10 nm"), 1e-3)
    curves = native_and_python(tree, ["skirt_film", *BEARINGS, "bodies"], tmp_path)
    for name, pair in curves.items():
        if name not in ZERO:
            assert apart(*pair) <= AGREES, name
