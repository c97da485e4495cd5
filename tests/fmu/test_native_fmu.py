"""The lubrication FMU that needs no Python next to the one in Python, rejections, foreign machines.

It has the same bits, but for what goes through exp or log, by those of the C library.
"""

import ctypes
import shutil
import subprocess
import zipfile
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import CHOICES, CHOSEN, NUMBERS, Parameters
from piston_cosim.fmu_ehd.state import Fields, Scalars
from piston_cosim.fmu_ehd.variables import (
    DERIVATIVE_INPUTS,
    DERIVATIVE_OUTPUTS,
    TURNING_INPUT,
    TURNING_OUTPUT,
    variables,
)
from piston_cosim.master.fmi.builder_native import ENTRIES
from piston_cosim.master.fmi.errors import Discard
from piston_cosim.master.fmi.native_code import OPEN, TARGETS, translated
from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.master.participants.fmi3 import Fmu3Participant
from piston_cosim.tests.verification.cases.motored import (
    DEGREE,
    UNEVEN,
    motored_film,
    opening,
    physics,
)

from .pairs import side_by_side
from .runs import make, reached

GRID = (12, 10)
OF_OIL = (
    *("axial temperature", "barus", "roelands", "cross", "carreau", "flow factors"),
    *("oblong roughness", "coating and roelands"),
)
"""Physics with exp, log or powers of the C library."""
C_LIBRARY = 1e-11
"""Two C libraries' exp and log differ by a bit, and a film passes a few of these on."""
SCARCE = dict(film_fraction_lower_edge=0.7, film_fraction_upper_edge=0.8)
FED = dict(opening_supply="own", pressure_openings=3e5, cavitation_pressure=-5e4)
ROUGH = dict(roughness_rms=3e-6)
ON_BORE = dict(initial_oil_layer=4e-6, initial_film_fraction=0.5, chamfer_capacity=1e-8)
SPLASH = dict(ON_BORE, oil_supply="bore_and_ring", oil_splash=1e-3, **ROUGH)


def many_windows():
    """Return windows on both sides, across the first row, at an edge and within.

    One film cell has no film cell beside it.
    """
    cells = opening(GRID)
    cells[4, 0] = cells[9, 5] = cells[2, 9] = True
    cells[[3, 3, 2, 4], [3, 5, 4, 4]] = True
    return cells


class Film(NamedTuple):
    """Changes of `Parameters`, steps, allowed difference, and cells of the grid."""

    changes: dict[str, Any]
    steps: int = 60
    allowed: float = 0.0
    grid: tuple[int, int] = GRID


PHYSICS = physics(GRID)
FILMS = {
    **{name: Film(PHYSICS[name], 120) for name in PHYSICS if name not in OF_OIL},
    **{name: Film(PHYSICS[name], allowed=C_LIBRARY) for name in OF_OIL},
    # Newton's method on a coating ends at 1e-11 of it
    "everything": Film(PHYSICS["everything"], allowed=1e-9),
    "rounded": Film(dict(SCARCE, **ROUGH, cavitation_rounding=5.0)),
    "all on little oil": Film(
        dict(
            oil=Oil("two_point", "barus_1893", "carreau_1972", shear_thinning_exponent=0.6),
            roughness_rms=3e-6,
            flow_factors="patir_cheng_1978",
            peklenik_number_bore=6.0,
            coating_thickness=1e-5,
            film_fraction_lower_edge=0.6,
            film_fraction_upper_edge=0.5,
        ),
        allowed=C_LIBRARY,
    ),
    "walther_1931": Film(
        dict(oil=Oil("walther_1931"), oil_temperature_lower_edge=350.0), allowed=C_LIBRARY
    ),
    "two_point": Film(
        dict(oil=Oil("two_point", viscosity_40=0.08), oil_temperature_upper_edge=390.0),
        allowed=C_LIBRARY,
    ),
    "filled in part": Film(dict(initial_film_fraction=0.6, roughness_rms=1e-6)),
    "another grid": Film(ROUGH, grid=(9, 16)),
    # surfaces that touch
    "windows, scarce": Film(SCARCE | ROUGH | {"open_cells": many_windows()}, 90),
    "windows, fed": Film(FED | ROUGH | {"open_cells": many_windows()}, 90),
    # a bearing slides both ways, from the library of skirts
    **{
        f"bearing, {name}": Film(changes | {"surface": "bearing"}, 60, allowed)
        for name, changes, allowed in (
            ("ring", dict(film_fraction_lower_edge=0.6, initial_film_fraction=0.7), 0.0),
            ("groove and holes", FED | ROUGH | {"open_cells": opening(GRID)}, 0.0),
            (
                "sector",
                ROUGH | dict(sector_angle=2.5, opening_supply="own", pressure_openings=1e5),
                0.0,
            ),
            ("coated", ROUGH | dict(coating_thickness=2e-5, cavity_shear="full_film"), 0.0),
            (
                "any oil",
                ROUGH | {"oil": Oil("vogel_1921", "roelands_1966", "cross_1965")},
                C_LIBRARY,
            ),
            (
                "flow factors",
                ROUGH | dict(flow_factors="patir_cheng_1978", peklenik_number_skirt=0.25),
                C_LIBRARY,
            ),
        )
    },
    # oil on the bore that is scarce, over two strokes and more
    "bore": Film(ON_BORE | ROUGH | {"oil_supply": "bore"}, 400),
    "ring and splash": Film(SPLASH, 400),
    "below ambient": Film(
        dict(
            ON_BORE,
            oil_supply="bore_and_ring",
            cavitation_pressure=-5e4,
            pressure_lower_edge=-5e4,
            pressure_upper_edge=-5e4,
            coating_thickness=2e-5,
        ),
        400,
    ),
    "half": Film(SPLASH | {"film_symmetry": "thrust_plane"}, 120),
    "half and cut-outs": Film(
        SPLASH | {"film_symmetry": "automatic", "open_cells": opening(GRID)}, 120
    ),
    "bore and cut-outs": Film(SPLASH | {"open_cells": opening(GRID)}, 400),
}
"""Every choice of physics. The steps pass rupture, reformation and reversal of sliding."""


def flat(changes):
    """Return changes of `Parameters` as parameters of the FMU."""
    default = Oil()
    own = {k: v for k, v in changes.items() if k not in ("oil", "open_cells", "surface")}
    oil = changes.get("oil", default)
    return own | {
        entry.name: getattr(oil, entry.name)
        for entry in fields(Oil)
        if getattr(oil, entry.name) != getattr(default, entry.name)
    }


def numbered(values):
    """Parameters with choices by number."""
    return {k: CHOICES[k].index(v) + 1 if k in CHOICES else v for k, v in values.items()}


def started(path, film, velocity, **values):
    """Return an instance of the FMU after its initialisation."""
    one = FmuParticipant("film", path)
    one.start(numbered(values) | {"film_thickness": film, "sliding_velocity": velocity}, 0.0, 1.0)
    return one


def step(one, film, velocity, size=DEGREE):
    one.set("film_thickness", film)
    one.set("sliding_velocity", velocity)
    one.step(reached(one), size)


@pytest.mark.parametrize("name", FILMS)
def test_values_are_those_of_the_fmu_in_python(name):
    """All outputs and derivatives, and those of steps taken back."""
    changes, steps, allowed, grid = FILMS[name]
    options = {"grid": [*grid], "surface": changes.get("surface", "skirt")}
    bearing = options["surface"] == "bearing"
    if (cells := changes.get("open_cells")) is not None:
        options["mask"] = (~cells).astype(int).tolist()
    cell = np.arange(grid[0] * grid[1]).reshape(grid)

    def given(one, k):
        values = motored_film(grid, k * DEGREE)._asdict()
        turning = 4.0 * (1.0 + 0.5 * np.sin(300.0 * k * DEGREE)) + 0.02 * cell  # [m/s]
        return values | ({TURNING_INPUT: turning} if bearing else {})

    apart = side_by_side(
        [make("fmu_ehd", options, Path("."), native) for native in (True, False)],
        numbered(flat(changes)),
        given,
        steps,
        lambda k: UNEVEN if k % 7 == 0 else DEGREE,
        derive=15,
        seeds=dict(zip((*DERIVATIVE_INPUTS, TURNING_INPUT)[: 2 + bearing], (1e-6, 1.0, 1.0))),
        products=(*DERIVATIVE_OUTPUTS, TURNING_OUTPUT)[: 2 + bearing],
    )
    assert apart.size["nodal_pressure_force"] > 0.0
    assert max(apart.shares().values(), default=0.0) <= allowed


def test_another_grid_has_the_same_library(native_fmu, make_native):
    name = "binaries/linux64/fmu_ehd.so"
    first, other = (zipfile.ZipFile(path).read(name) for path in (native_fmu, make_native([9, 16])))
    assert first == other


LARGEST_STATE = 300_000
"""Bytes of a state on 40 x 40 cells, of which the variables of the FMU are 90 000."""


@pytest.mark.parametrize("name", ["ring and splash", "coated"])
def test_a_saved_state_is_small(backend, name):
    shape = (40, 40)
    changes = SPLASH if name != "coated" else dict(coating_thickness=2e-5)
    path = make("fmu_ehd", {"grid": [*shape]}, Path("."), backend == "native")
    one = started(path, *motored_film(shape, 0.0), **flat(changes))
    for k in range(1, 4):
        step(one, *motored_film(shape, k * DEGREE))
    assert len(one.serialise(one.save())) <= LARGEST_STATE
    one.close()


class Allocated(ctypes.Structure):
    """Answer of glibc's mallinfo2."""

    names = "arena ordblks smblks hblks mapped usmblks fsmblks used fordblks keepcost"
    _fields_ = [(name, ctypes.c_size_t) for name in names.split()]


def test_instances_share_the_working_memory_of_a_step(make_native):
    """A step of a second instance reuses the blocks of the first instance's step.

    A tenth leaves room for what Python allocates.
    """
    count = ctypes.CDLL(None).mallinfo2
    count.restype = Allocated
    shape, ones, needs = (40, 40), [], []
    for _ in range(2):
        ones.append(started(make_native([*shape]), *motored_film(shape, 0.0)))
        before = count()
        step(ones[-1], *motored_film(shape, DEGREE))
        after = count()
        needs.append(after.used + after.mapped - before.used - before.mapped)
    for one in ones:
        one.close()
    assert needs[1] <= 0.1 * needs[0]


EDGES = dict(oil_temperature_lower_edge=373.15, pressure_upper_edge=0.0)
FIELD = np.linspace(340.0, 400.0, 30).reshape(6, 5)


@pytest.mark.parametrize(
    "inputs", [(), tuple(EDGES), ("pressure_upper_edge", "oil_temperature"), ("oil_temperature",)]
)
def test_conditions_change_between_steps(backend, inputs):
    """Temperature and pressure of an edge and a field of temperatures may change between steps.

    They are tunable parameters or inputs. The oil thins as well. For the film, oil of a cut-out is
    as warm as that of the nearest film cell.
    """
    shape, mask = (6, 5), np.ones((6, 5), dtype=int)
    if inputs == ("oil_temperature",):
        mask[2, 1:4] = mask[5, 0] = 0
    options = {"grid": [*shape], "inputs": [*inputs], "mask": mask.tolist()}
    model = LubricationModel(Parameters(shape, Oil("vogel_1921"), open_cells=mask == 0))

    def around(k):
        edges = {"oil_temperature_lower_edge": 373.15 + 5.0 * k, "pressure_upper_edge": 1e4 * k}
        field = {"oil_temperature": FIELD + k} if "oil_temperature" in inputs else {}
        return {name: value for name, value in edges.items() if not field or name in inputs} | field

    def shown(values):
        """To a cut-out another temperature than its own makes no difference."""
        return {n: np.where(mask == 1, v, 290.0) if np.ndim(v) else v for n, v in values.items()}

    path = make("fmu_ehd", options, Path("."), backend == "native")
    one = started(path, *motored_film(shape, 0.0), viscosity_law="vogel_1921", **shown(around(0)))
    state, _ = model.start(*motored_film(shape, 0.0), **around(0))
    for k in range(1, 6):
        thin = {"vogel_b": 1010.0 - 20.0 * k}
        for name, value in (thin | shown(around(k))).items():
            one.set(name, value)
        step(one, *motored_film(shape, k * DEGREE))
        given = thin | around(k)
        state, outputs = model.advance(state, *motored_film(shape, k * DEGREE), DEGREE, **given)
        for name in DERIVATIVE_OUTPUTS:
            off = np.abs(one.get(name) - outputs[name]).max()
            assert off <= C_LIBRARY * np.abs(outputs[name]).max()
    for name, wrong in (("pressure_upper_edge", -1.0), ("oil_temperature_lower_edge", 600.0)):
        if name in inputs:
            right = one.get(name)
            one.set(name, wrong)
            with pytest.raises(Discard, match=f"{name}: expected"):
                step(one, *motored_film(shape, 0.0))
            one.set(name, right)
    one.close()


# ---- what is covered


def test_every_choice_and_number_is_covered():
    assert set(CHOICES) == set(CHOSEN)
    both = [v for kind in ("skirt", "bearing") for v in variables((4, 4), surface=kind)]
    free = {v.name for v in both if v.causality == "parameter" and not v.choices}
    assert free == set(NUMBERS)
    given = {v.name for v in both if v.causality == "output"}
    assert given == {*Fields._fields, *Scalars._fields, "solver_iterations"}


# ---- what it needs


def test_the_library_asks_for_the_c_library_alone(native_fmu, tmp_path):
    library = zipfile.ZipFile(native_fmu).extract("binaries/linux64/fmu_ehd.so", tmp_path)
    if not shutil.which("readelf"):
        pytest.skip("no readelf")
    told = subprocess.run(["readelf", "-d", library], capture_output=True, text=True, check=True)
    needed = [
        line.split("[")[1].rstrip("]") for line in told.stdout.splitlines() if "NEEDED" in line
    ]
    assert set(needed) <= {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}


def test_machine_code_that_would_call_python_is_refused():
    calling = "declare void @{0}()\ndefine void @native_size() {{ call void @{0}() ret void }}"
    assert translated(calling.format("exp"), TARGETS["linux64"])
    assert "exp" in OPEN["functions"]
    with pytest.raises(RuntimeError, match="would call PyErr_Format"):
        translated(calling.format("PyErr_Format"), TARGETS["linux64"])


def test_the_library_exports_the_standard_alone(native_fmu, unpack, tmp_path):
    """The entries of the model are inner symbols, which no other library can replace."""
    (path,) = (unpack(native_fmu, tmp_path / "a").folder / "binaries/linux64").iterdir()
    library = ctypes.CDLL(str(path))
    assert hasattr(library, "fmi2DoStep")
    assert [name for name in ENTRIES if hasattr(library, f"fmu_ehd_{name}")] == []


def test_a_film_of_many_cells_gives_its_first_outputs(host, make_native, unpack, tmp_path):
    """A film of 40 x 40 cells takes a step in a host in C, and through the arrays of FMI 3."""
    grid = [40, 40]
    place = unpack(make_native(grid), tmp_path / "place")
    cell = ("nodal_pressure_force[3,4]", "film_thickness[3,4]")
    arguments = place.arguments("film_thickness[3,4]", 2e-5, *cell)
    command = [str(host), "5e-5", "1", *map(str, arguments)]
    subprocess.run(command, check=True, capture_output=True, env={})
    one = Fmu3Participant("film", make_native(grid, version="3.0"))
    film, velocity = motored_film(grid, 0.0)
    one.start({"film_thickness": film, "sliding_velocity": velocity}, 0.0, 1.0)
    one.step(0.0, DEGREE)
    assert one.get("nodal_pressure_force").max() > 0.0
    one.close()
