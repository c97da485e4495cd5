"""Comparison of two runs: differences of their cases, and those of figures that are clear."""

from dataclasses import replace
from math import pi

import pytest

from piston_cosim.master.engine.comparison import (
    NOT_DISTINGUISHABLE,
    NOT_KNOWN,
    changes,
    compared,
    difference,
    differing,
    have_equal_grids,
    headline,
    spread,
)
from piston_cosim.master.engine.measures import Measure, Measures
from piston_cosim.master.engine.uncertainty import DIVERGES, EXACT, Uncertainty, combined

KEY = "minimum_film_thickness_m"


def film(value, grid, step=0.0, signed=True):
    """Return a minimum film thickness with parts of its uncertainty [µm]."""
    parts = {"grid": 1e-6 * grid, "step": 1e-6 * step}
    label = "minimum film thickness"
    known = combined(parts, signed)
    return Measure(KEY, label, 1e-6 * value, "m", "ehd", uncertainty=known)


def test_a_measure_reads_as_a_figure():
    assert repr(film(9.2, 0.05)) == "<minimum film thickness: 9.20 +- 0.05 \N{MICRO SIGN}m>"


def test_errors_that_two_runs_share_cancel():
    """The parts are 4 and 3 µm with one sign, so that 1 µm and a fifth of 5 µm remain."""
    one, other = film(2.0, 4.0), film(3.0, 3.0)
    assert spread(one, other, alike=True) == pytest.approx(1e-6)
    assert spread(one, other, alike=False) == pytest.approx(5e-6)
    assert spread(film(2.0, 4.0), film(3.0, -3.0), alike=True) == pytest.approx(7e-6)
    assert spread(film(2.0, 4.0), film(3.0, 4.0), alike=True) == pytest.approx(0.2 * 32**0.5 * 1e-6)
    estimates = film(2.0, 4.0, signed=False), film(3.0, 3.0, signed=False)
    assert spread(*estimates, alike=True) == pytest.approx(5e-6)


def test_causes_add_as_squares():
    one, other = film(2.0, 4.0, 1.0), film(3.0, 1.0, -3.0)
    assert spread(one, other, alike=True) == pytest.approx(5e-6)  # 3 and 4 µm


def test_a_difference_below_its_uncertainty_is_not_distinguishable():
    clear = difference(film(5.0, 4.0), film(3.0, 3.0), True)
    assert (clear.text, clear.better) == ("+2.0 +- 1.0 µm", 1)
    assert clear.size == pytest.approx(2e-6)
    same = difference(film(3.9, 4.0), film(3.0, 3.0), True)
    assert (same.text, same.size, same.better) == (NOT_DISTINGUISHABLE, 0.0, 0)


def test_more_friction_is_worse_and_more_motion_is_neither():
    def figure(key, value):
        return Measure(key, key, value, "W", uncertainty=combined({"grid": 0.1}))

    for key, better in (("mean_friction_power_w", -1), ("range_lateral_displacement_m", 0)):
        assert difference(figure(key, 2.0), figure(key, 1.0), True).better == better
        assert difference(figure(key, 1.0), figure(key, 2.0), True).better == -better


def test_a_figure_without_an_uncertainty_has_no_difference():
    def pressure(reason):
        unknown = Uncertainty(None, "", reason)
        return Measure("maximum_pressure_pa", "maximum pressure", 1e8, "Pa", uncertainty=unknown)

    found = difference(pressure(DIVERGES), pressure("not recorded"), True)
    assert (found.text, found.size) == (DIVERGES, 0.0)
    found = difference(pressure("not recorded"), pressure("not recorded"), True)
    assert found.text == NOT_KNOWN


def tree(file, oil="sae_0w_20", grid=(52, 20), label="base"):
    """Return the tree of a case with a profile."""
    bodies = {"build": {"piston": {"profiles": [{"file": file}]}, "grid": [*grid]}}
    participants = {"bodies": bodies, "ehd": {"build": {"oil": oil, "grid": [*grid]}}}
    return {"label": label, "time": {"step": "1 deg"}, "participants": participants}


def test_what_differs_is_named_and_no_hash():
    names = "84ef3fd8d20001ab", "e035b7a6f2f34567"
    assert differing(tree("a/prof_a.csv"), tree("prof_b.csv"), names) == (
        "prof_a.csv",
        "prof_b.csv",
    )
    one, other = tree("prof_a.csv", "sae_30"), tree("prof_b.csv")
    assert differing(one, other, names) == (
        "prof_a.csv and oil sae_30",
        "prof_b.csv and oil sae_0w_20",
    )
    fine, coarse = tree("a.csv", grid=(104, 40)), tree("a.csv")
    assert differing(fine, coarse, names) == ("grid [104, 40]", "grid [52, 20]")
    assert differing(coarse, tree("a.csv", label="other"), ("base", "other")) == ("base", "other")
    variants = tree("a.csv") | {"variants": {"other": {}}}
    assert differing(variants, tree("b.csv"), ("base", "other")) == ("base", "other")
    assert differing(variants, tree("b.csv"), names) == ("a.csv", "b.csv")
    assert have_equal_grids(coarse, tree("b.csv")) and not have_equal_grids(fine, coarse)
    step = {"step": f"{pi / 180} rad"}
    assert have_equal_grids(coarse, coarse | {"time": step})
    assert not have_equal_grids(coarse, coarse | {"time": {"step": "2 deg"}})


def test_what_differs_is_the_same_in_other_units_and_folders():
    def film_of(viscosity, clearance="25 um", file="a/prof.csv"):
        made = tree(file)
        made["participants"]["ehd"]["parameters"] = {"viscosity": viscosity}
        made["participants"]["pin"] = {"parameters": {"viscosity": "9 mPa s"}}
        made["participants"]["bodies"]["parameters"] = {"radial_clearance": clearance}
        return made

    def found(one, other):
        return differing(one, other, ("one", "two"))

    here = film_of("5 mPa s")
    assert found(film_of("5 mPa s", ["1 mm"]), film_of("5 mPa s", ["0.1 cm"])) == ("one", "two")
    assert found(here, film_of("0.005 Pa s", "0.025 mm")) == ("one", "two")
    assert found(here, film_of("5 mPa s", "12.5um")) == (
        "radial clearance 25 um",
        "radial clearance 12.5um",
    )
    assert found(here, film_of("5 mPa s", file="b/prof.csv")) == ("a/prof.csv", "b/prof.csv")
    both = film_of("6 mPa s")
    both["participants"]["pin"]["parameters"]["viscosity"] = "8 mPa s"
    assert found(here, both) == (
        "ehd viscosity 5 mPa s and pin viscosity 9 mPa s",
        "ehd viscosity 6 mPa s and pin viscosity 8 mPa s",
    )


@pytest.mark.parametrize(
    "first, begin",
    [
        ("a/rigid", "a/rigid"),
        ("run_a", "run_a"),
        ("radial clearance 2.5 um", "Radial clearance 2.5 um"),
        ("rigid", "Rigid"),
    ],
)
def test_a_headline_keeps_the_letters_of_files(first, begin):
    rows = [difference(film(3.0, 0.1), film(3.0, 0.1), True)]
    assert headline((first, "b"), rows).startswith(f"{begin} instead of b makes no clear")


def test_the_headline_says_what_changes_and_which_is_better():
    trees = tree("prof_a.csv"), tree("prof_b.csv")
    tables = Measures(all=[film(3.0, 4.0)]), Measures(all=[film(5.0, 3.0)])
    found = compared(("a", "b"), trees, tables)
    assert found.headline == (
        "prof_a.csv instead of prof_b.csv lowers the minimum film thickness by 2.0 +- 1.0 µm. "
        "Better with prof_b.csv: minimum film thickness."
    )
    share = Measure(
        "contact_share", "contact", 4e-5, "1", "ehd", uncertainty=combined({"grid": 1e-5})
    )
    tables[0].all.append(share)
    tables[1].all.append(replace(share, value=0.0))  # a difference below the last digit
    assert compared(("a", "b"), trees, tables).rows[-1].text == NOT_DISTINGUISHABLE
    same = compared(("a", "b"), trees, (tables[0], tables[0]))
    assert same.headline == (
        "prof_a.csv instead of prof_b.csv makes no clear difference. "
        "Not distinguishable: minimum film thickness."
    )
    tables[0].all[-1] = tables[1].all[-1]
    zero = compared(("a", "b"), trees, tables)
    assert [row.label for row in zero.rows] == ["minimum film thickness"]
    assert zero.remarks == ["Zero in both runs: contact."]


def test_the_headline_has_a_sentence_for_each_direction_and_no_figure_twice():
    def slap(value):
        known = combined({"grid": 1e-4})
        return Measure("slap_energy_j", "slap", value, "J", "bodies", uncertainty=known)

    def friction(key, value):
        return Measure(key, key, value, "W", uncertainty=combined({"grid": 1.0}))

    keys = "mean_friction_power_w", "friction_mean_effective_pressure_pa"
    tables = [
        Measures(all=[*(friction(key, f) for key in keys), slap(s)])
        for f, s in ((90.0, 3e-3), (80.0, 5e-3))
    ]
    found = compared(("a", "b"), (tree("a.csv"), tree("b.csv")), tables)
    assert found.headline == (
        "a.csv instead of b.csv raises the mean_friction_power_w by 10.0 +- 1.4 W. "
        "It lowers the slap by 2.00 +- 0.14 mJ. "
        "Better with a.csv: slap. Better with b.csv: mean_friction_power_w."
    )
    assert len(found.rows) == 3


def test_results_of_unequal_lengths_are_not_comparable():
    whole, half = (
        Measures(all=[film(value, 0.1)], length=f"{length} deg")
        for value, length in ((3.0, 720), (2.0, 360))
    )
    trees = tree("a.csv"), tree("b.csv")
    assert compared(("a", "b"), trees, (whole, half)).headline == (
        "a.csv instead of b.csv raises the minimum film thickness by 1.000 +- 0.028 µm. "
        "Not comparable: a.csv has results of 720 deg, and b.csv of 360 deg."
    )
    assert (
        "Better" in compared(("a", "b"), trees, (whole, replace(half, length="720 deg"))).headline
    )


def test_a_sentence_of_a_headline_has_at_most_25_words():
    rows = [
        difference(*(replace(film(value, 0.1), label=name) for value in (3.0, 2.0)), True)
        for name in ("minimum film thickness", "maximum pressure", "mean power", "slap energy")
    ]
    by = "by 1.000 +- 0.028 µm"
    assert changes(("A", "B"), rows) == (
        f"A instead of B raises the minimum film thickness {by} and the maximum pressure {by}. "
        f"It raises the mean power {by} and the slap energy {by}."
    )


def test_runs_of_two_cases_have_a_remark():
    table = Measures(all=[film(3.0, 0.1)])
    one, other = ({"title": title} | tree("a.csv") for title in ("One", "Other"))
    names, tables = ("a", "b"), (table, table)
    assert compared(names, (one, other), tables).remarks[0].startswith("The runs are of cases with")
    variant = other | {"variants": {"more": {"title": "One"}}}
    assert not compared(names, (one, variant), tables).remarks


def test_no_impact_is_an_exact_zero():
    none = Measure("slap_energy_j", "slap energy", 0.0, "J", "bodies", uncertainty=EXACT)
    slap = replace(none, value=3e-3, uncertainty=combined({"grid": 1e-4}))
    assert difference(slap, none, False).text == "+3.00 +- 0.10 mJ"
    pair = [Measures(all=[film(value, 0.1), none]) for value in (3.0, 2.0)]
    found = compared(("a", "b"), (tree("a.csv"), tree("b.csv")), pair)
    assert "slap" not in found.headline and found.remarks == ["Zero in both runs: slap energy."]


def test_runs_without_a_common_figure_say_so():
    found = compared(("a", "b"), (tree("a.csv"), tree("b.csv")), (Measures(), Measures()))
    assert found.headline == "a.csv and b.csv have no main result in common."
    assert not found.rows and not found.remarks


def test_several_films_are_named():
    two = [
        replace(film(value, 0.1), owner=owner) for value, owner in ((3.0, "big"), (2.0, "small"))
    ]
    table = Measures(all=two)
    found = compared(("a", "b"), (tree("a.csv"), tree("b.csv")), (table, table))
    label = "minimum film thickness"
    assert [row.label for row in found.rows] == [f"{label}, big", f"{label}, small"]
