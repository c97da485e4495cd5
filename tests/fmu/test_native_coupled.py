"""The native coupled FMU takes the same steps as the coupled FMU in Python.

Film and bodies are those of the native FMUs. The order of the sums in the master's products of
vectors differs, and a small matrix is factorised instead of inverted.
"""

from functools import cache

import numpy as np
import pytest
from fmpy.fmi2 import fmi2Error

from piston_cosim.master.coupling.stepping import WITHOUT_PARTS
from piston_cosim.master.fmi.errors import CallFailed, Discard
from piston_cosim.master.participants.fmi2 import FmuParticipant

from .films import one_film, several_films
from .pairs import BY_ITSELF, side_by_side
from .runs import EXAMPLE, FEW_MODES, export, small_tree, tight
from .shipped import DATA_SHEET, FLOATING_PIN, small_pin

STEP = float(np.radians(1.0)) / (2 * np.pi * 100.0)  # 1 deg at 6000 rpm [s]
HARD = dict(
    crank_offset=1e-3,
    start_lateral_displacement=4e-6,
    start_rocking_angle=2e-4,
    pin_friction_coefficient=0.05,
    film_fraction_lower_edge=0.6,
    film_fraction_upper_edge=0.7,
    initial_film_fraction=0.7,
    roughness_rms=1.5e-6,
    impact_resolution=1.0,
)
"""Beside the axis, turned, with friction at the pin, little oil at the edges and surfaces that
touch. No step is repeated in parts, which multiply round-off.
"""
COUNTS = ("residual_evaluations", "jacobian_evaluations", "solver_iterations")
"""Work of both participants over all iterations of the steps so far, and of the film in the last:
equal where every step took the same evaluations and linearisations.
"""
CONVERGED = "0.01 nm"
"""Tolerance of films at which what is left of round-off is small."""
ROUND_OFF = 1e-12
"""Of the largest value: 2e-13 was seen. A Newton update leaves of an error what its linear solve
does, and both paths stop in the same iteration, so that round-off passes on without growing.
"""
SUMS = 1e-10  # sums in another order, by a linear solve that multiplies their difference
OF_EQUALS = ("evaluations", "work_error", "imbalance", "power_error", "force_hydrodynamic")
"""Of the floating pin: counts, and shares and forces that are differences of what is equal."""
OF_WORKS = {"power_error": "film_power"}
"""It is a difference of powers."""
FLEXIBLE = dict(modes=FEW_MODES)
TIGHT = [("wires.0.tolerance", "1e-5 nm"), ("wires.1.tolerance", 1e-11)]


@cache
def exported(*changes, native=True, **sizes):
    """Export the coupled FMU of the small case with changes, as machine code or in Python."""
    return export(small_tree(("time.stop", "12 deg"), *changes, **sizes), native=native)


def both(tree, path):
    """As machine code, and in Python."""
    return [export(tree, path, native) for native in (True, False)]


@pytest.fixture
def engine(backend):
    return exported(native=backend == "native")


def started(path, values=HARD):
    one = FmuParticipant("coupled", path)
    one.start(values, 0.0, 1.0)
    one.log.clear()  # a first start compiles, and says so
    return one


def given(one, k, cooling=0.1):
    """Return the inputs and tunable parameters of step k; the piston cools by `cooling` [K]."""
    values = {
        "gas_pressure": 1e5 * k,
        "ring_side_force": 5.0 * np.sin(k),
        "ring_moment": 0.02 * np.cos(k),
        "piston_temperature": 293.15 - cooling * k,
        "damping_ratio": 0.02 + 1e-3 * k,
        "crankcase_pressure": 1e4 * k,  # one that swings makes 2e-12 of an input's last bit
        "viscosity": 0.01 + 1e-4 * k,
    }
    return {name: value for name, value in values.items() if name in one.fields}


def warm(one, k):
    """Return the same inputs for a piston that keeps its temperature.

    Otherwise pressures of a few kPa would show a last bit of the gap as 1e-12.
    """
    return given(one, k, cooling=0.0)


def step(one, k, steps=1):
    """Take the k-th step, or several in one."""
    for name, value in given(one, k).items():
        one.set(name, value)
    one.step((k - 1) * STEP, steps * STEP)


def outputs_of(one):
    """Names of its outputs but those that are round-off themselves and counts."""
    return [
        name
        for name, field in one.fields.items()
        if field.causality == "output" and name not in BY_ITSELF + COUNTS
    ]


# ---- the values of the FMU in Python


def compared(pair, steps, values=(), inputs=given):
    """Return the outputs of the pair after each step, and their differences."""
    return side_by_side(pair, dict(values), inputs, steps, lambda k: STEP, redo=steps + 1)


def test_every_output_is_that_of_the_fmu_in_python():
    apart = compared(both(small_tree(("time.stop", "12 deg")), EXAMPLE), 40, HARD)
    for name in ("friction_power_asperity", "outflow_upper_edge", "moment_on_block"):
        assert apart.size[name] > 0.0
    assert apart.size["contact_area_fraction"] > 0.0
    assert apart.size["boundary_friction_share"] > 1e-4
    assert apart.size["lateral_displacement"] > 6e-6 and apart.size["maximum_pressure"] > 1e7
    assert max(apart.shares(OF_WORKS).values()) <= ROUND_OFF


def test_parts_of_a_macro_step_are_those_of_the_fmu_in_python():
    """The eleventh of 12 steps is repeated in parts down to 1/32.

    Velocities are differences over a part, so that round-off is at most 32 times as large. A piston
    that cools would add the last bit of its clearance, which these parts show as up to 3e-9.
    """
    pair = both(small_tree(("time.stop", "12 deg")), EXAMPLE)
    apart = compared(pair, 12, HARD | {"impact_resolution": 10e-9}, warm)
    ours, theirs = apart.last
    assert [ours[name] for name in COUNTS] == [theirs[name] for name in COUNTS]
    assert ours["residual_evaluations"] > 300.0  # 100 after ten steps
    assert max(apart.shares(OF_WORKS).values()) <= 32 * ROUND_OFF


def test_a_step_whose_parts_fail_is_taken_without_parts_as_in_python():
    """In the last of 28 steps, a quarter does not converge in four iterations, the whole step does.

    Second differences of quarters multiply round-off by 16. 4e-13 was seen.
    """
    changes = [("time.stop", "12 deg"), ("wires.0.tolerance", CONVERGED)]
    changes += [("coupling.max_iterations", 4), ("coupling.advanced.halvings", 2)]
    told = []
    for path in both(small_tree(*changes), EXAMPLE):
        one = started(path, HARD | {"impact_resolution": 10e-9})
        for k in range(1, 28):
            step(one, k)
        assert list(one.log) == []
        step(one, 28)
        assert [WITHOUT_PARTS in text for _, text in one.log] == [True]
        told.append([one.get(name) for name in COUNTS])
        told[-1] += [one.get(name) for name in ("lateral_displacement", "maximum_pressure")]
    assert told[0] == pytest.approx(told[1], rel=1e-10)


def two_films():
    """Return a case of three participants, two of them of one library.

    The bands have unequal size and a groove between them. The piston is off the axis, and surfaces
    touch.
    """
    tree = several_films((12, 12), "12 deg", [(1, 5), (7, 12)])
    tree["participants"]["bodies"]["parameters"] |= {
        "start_lateral_displacement": "45 um",
        "start_rocking_angle": "0.3 mrad",
        "crank_offset": "1 mm",
    }
    for film in ("film_1", "film_2"):
        tree["participants"][film]["parameters"]["roughness_rms"] = "3 um"
    return tree


@pytest.mark.parametrize(
    "make, steps, moved",
    [
        (
            two_films,
            12,
            {
                "film_1.maximum_pressure": 1e4,
                "film_2.maximum_pressure": 1e4,
                "film_2.contact_area_fraction": 0.0,
            },
        ),
        # nothing is iterated: the bodies move by inertia and gas, the film stays as it started
        (
            lambda: one_film((12, 10), "12 deg") | {"wires": []},
            6,
            {"lateral_displacement": 0.0},
        ),
    ],
    ids=["two films", "no wires"],
)
def test_other_cases_are_those_of_the_fmu_in_python(make, steps, moved):
    apart = compared(both(tight(make(), CONVERGED), DATA_SHEET), steps, inputs=warm)
    assert [name for name, least in moved.items() if not apart.size[name] > least] == []
    shares = apart.shares(OF_WORKS)
    assert {name: share for name, share in shares.items() if share > ROUND_OFF} == {}


def test_a_floating_pin_is_that_of_the_fmu_in_python():
    tree = small_pin(stop="12 deg", skirt=(12, 10), pin=(24, 4))
    ours, theirs = compared(
        both(tight(tree, CONVERGED), FLOATING_PIN), 12, inputs=lambda one, k: {}
    ).last
    names = [name for name in theirs if not name.endswith(OF_EQUALS)]
    assert sum(abs(theirs[name]) > 0.0 for name in names) > 20
    for name in names:
        assert abs(ours[name] - theirs[name]) <= SUMS * max(abs(theirs[name]), 1e-9), name


@pytest.mark.slow
def test_flexible_bodies_are_those_of_the_fmu_in_python():
    """Bodies with four modes each give the values of the FMU in Python.

    The wires have more directions than a linear solve takes products, and the last digits decide
    where it stops. With the case's tolerance of 1 nm the film agrees to a thousandth of that. With
    a tolerance of 1e-5 nm, 1e-9 of the film, everything agrees to 1e-9.
    """
    trees = [small_tree(("time.stop", "12 deg"), *more, modes=4) for more in ((), TIGHT)]
    apart = compared(both(trees[0], EXAMPLE), 20, HARD)
    assert apart.size["elastic_energy"] > 0.0
    for name in ("minimum_film_thickness", "lateral_displacement"):
        assert apart.off[name] <= 1e-12  # m; 1.2e-13 was seen
    tight = compared(both(trees[1], EXAMPLE), 20, HARD)
    # 1.4e-11 was seen
    assert max(tight.shares(OF_WORKS).values()) <= 1e-9


def test_a_host_that_adds_up_its_times_has_the_bits_of_one_that_multiplies(engine):
    """As does one that misses the ends by less than 1e-6 of a step; 30 steps, pairs at the end."""
    exact, added, rough = (started(engine) for _ in range(3))
    time = 0.0
    sums = set()
    for k in range(30):
        size = 2 if k > 26 else 1
        begin = (k + max(k - 27, 0)) * STEP
        exact.step(begin, size * STEP)
        added.step(time, size * STEP)
        time += size * STEP
        rough.step(begin + 2e-7 * (k % 3) * STEP, size * STEP)
        sums.add(time == (k + max(k - 27, 0) + size) * STEP)
    assert sums == {True, False}  # the sum is another number at some ends
    for name in (*outputs_of(exact), *COUNTS):
        values = [one.get(name) for one in (exact, added, rough)]
        assert values[0] == values[1] == values[2], name
    for one in (exact, added, rough):
        one.close()


# ---- parameters after the start

FIXED = [("radial_clearance", 5e-5, "fmi2SetReal"), ("cavitation_model", 2, "fmi2SetInteger")]
"""A number and a choice that are read once, and the call that sets them."""


def test_a_fixed_parameter_is_rejected_after_the_start_and_never_acts(engine):
    """A rollback does not apply it either."""
    one, other = started(engine), started(engine)
    for name, value, call in FIXED:
        before, reference = one.get(name), one.fields[name].references[0]
        assert before != value
        with pytest.raises(CallFailed):
            one.set(name, value)
        words = "expected an input or a tunable parameter in Step Mode"
        told = f"{call}: {words}, got the parameter of value reference {reference} ({name})"
        assert list(one.log) == [(fmi2Error, told)]
        one.log.clear()
        assert one.get(name) == before
    saved = one.save()
    step(one, 1)
    one.restore(saved)
    for participant in (one, other):
        step(participant, 1)
    assert [one.get(name) for name in outputs_of(one)] == [
        other.get(name) for name in outputs_of(one)
    ]


@pytest.mark.parametrize(
    "name, value, sizes, output, steps, near, share",
    [
        # 20 mPa s for 6, to the tolerance of the wires
        ("viscosity", 0.02, {}, "friction_power_hydrodynamic", 1, 1e-9, 1.0),
        # in an engine with modes
        ("damping_ratio", 2.0, FLEXIBLE, "elastic_energy", 2, 1e-6, 1e-3),
    ],
)
def test_a_tunable_parameter_acts_at_the_next_step(
    backend, name, value, sizes, output, steps, near, share
):
    """From the first step on as if the run had begun with it."""
    path = exported(native=backend == "native", **sizes)
    one, other, begun = (started(path, HARD | more) for more in ({}, {}, {name: value}))
    one.set(name, value)
    assert list(one.log) == []
    for participant in (one, other, begun):
        for k in range(steps):
            participant.step(k * STEP, STEP)
    assert one.get(output) == pytest.approx(begun.get(output), rel=near)
    assert abs(one.get(output) - other.get(output)) > share * other.get(output) > 0.0


# ---- states


def test_saved_state_omits_earlier_products_and_repeats_the_same_bits(backend):
    """The step after a save has the bits of the repeated step, which has no earlier products.

    With modes, a step that has them has other bits: a host that never saves keeps them.
    """
    path = exported(native=backend == "native", **FLEXIBLE)
    never, saving, other = started(path), started(path), started(path, {})
    names = outputs_of(never)
    for k in range(1, 12):
        saved = saving.save()
        step(never, k)
        step(saving, k)
    after = [saving.get(name) for name in names]
    whole = saving.serialise(saved)
    saving.restore(saved)
    other.restore(other.deserialise(whole))
    for one in (saving, other):
        step(one, 11)
        assert [one.get(name) for name in names] == after
    assert [never.get(name) for name in names] != after


LARGEST_STATE = 300_000
"""Limit of a serialised state [bytes]; 171 and 215 kB were seen."""


@pytest.mark.slow
@pytest.mark.parametrize("modes", [(0, 0), (48, 80)])
def test_state_of_the_numerical_example_is_small(native_engine, modes):
    """On its 40 x 40 cells, rigid and with its modes. 80 search directions would have 4.1 MB."""
    bodies = zip(("piston", "block"), modes)
    changes = [(f"participants.bodies.build.{body}.modes", count) for body, count in bodies]
    one = started(native_engine([40, 40], changes))
    for k in range(1, 41):
        step(one, k)
    assert len(one.serialise(one.save())) < LARGEST_STATE


def test_what_does_not_converge_names_the_worst_wire():
    one = started(exported(("coupling.max_iterations", 3), ("coupling.advanced.halvings", 0)))
    with pytest.raises(Discard) as refusal:
        for k in range(1, 12):
            step(one, k)
    for words in (
        "no convergence in 3 iterations",
        "ehd.",
        "expected a residual of at most 1e-",
        "no halving is left",
    ):
        assert words in str(refusal.value)
