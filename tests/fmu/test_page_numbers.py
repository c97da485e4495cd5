"""Every number in the result tables of case pages, from runs of the cases.

The main job and the journal bearing have tests of their own.
"""

from typing import NamedTuple

import numpy as np
import pytest

import piston_cosim as pc

from ..shown import ROOT, check, table, written

TEMPLATE = f"{ROOT}/models/lubrication_template/axial_film.py:AxialFilm"

UNITS = {
    "um": 1e-6,
    "mm": 1e-3,
    "MPa": 1e6,
    "kPa": 1e3,
    "kN": 1e3,
    "mJ": 1e-3,
    "cm3/s": 1e-6,
    "%": 0.01,
}
UNITS |= {"deg": np.pi / 180.0, "roughness of data_sheet": 0.54e-6}
"""Unit of a page -> SI; others are SI."""


class Shown(NamedTuple):
    """Quantity of a run: kind min, max, abs, mean or sum, an output, and the unit of the page.

    A sum is that of the means of several outputs, and a length that of a vector. "when" is the
    crank angle of the maximum. The kind "summary" is an entry of the summary, and "measure" one of
    the main results. "given" is an input of the case or a reference. With `last`, the quantity is
    one of the last period.
    """

    kind: str
    outputs: str
    unit: str = ""
    last: bool = False

    def value(self, results):
        """Return the value at the ends of all steps; a mean has their lengths as weights."""
        if self.kind == "given":
            return float(self.outputs)
        if self.kind == "summary":
            return results.summary[self.outputs] / UNITS.get(self.unit, 1.0)
        if self.kind == "measure":
            return pc.measures(results)[self.outputs].value / UNITS.get(self.unit, 1.0)
        shown = results.last if self.last else results.whole
        series = [shown.series(port).values[1:] for port in self.outputs.split()]
        if self.kind == "when":
            angle = np.degrees(shown.series("bodies.crank_angle").values[1:])
            return (angle[series[0].argmax()] + 360.0) % 720.0 - 360.0
        if self.kind == "length":
            value = float(np.hypot(*series).max())
        elif self.kind in ("mean", "sum"):
            weights = np.diff(shown.time)
            value = sum(float(np.average(one, weights=weights)) for one in series)
        elif self.kind == "abs":
            value = max(float(np.abs(one).max()) for one in series)
        else:
            value = float({"min": np.min, "max": np.max}[self.kind](series))
        return value / UNITS.get(self.unit, 1.0)


TILT = [Shown(kind, "bodies.rocking_angle", "deg") for kind in ("min", "max")]
SIDEWAYS = [Shown(kind, "bodies.lateral_displacement", "um") for kind in ("min", "max")]
CYLINDER = {
    "minimum film thickness": ("min", "{0}_film.minimum_film_thickness", "um"),
    "highest pressure": ("max", "{0}_film.maximum_pressure", "MPa"),
    "largest side force": ("abs", "{0}.side_force", "kN"),
    "largest kinetic energy across the bore": ("max", "{0}.kinetic_energy", "mJ"),
}
ENDS = ("front", "rear")


def of_cylinder(label, end):
    """Return a quantity of a cylinder of a twin."""
    kind, output, unit = CYLINDER[label]
    return Shown(kind, output.format(end), unit)


PIN_FILMS = {
    "minimum film thickness: boss, small end": [
        Shown("min", "left_film.minimum_film_thickness", "um"),
        Shown("min", "small_end_film.minimum_film_thickness", "um"),
    ],
    "highest pressure: boss, small end": [
        Shown("max", "left_film.maximum_pressure", "MPa"),
        Shown("max", "small_end_film.maximum_pressure", "MPa"),
    ],
}
SIDE_FORCE = [Shown("abs", "bodies.side_force", "kN")]
BOSSES = "left_film.friction_power right_film.friction_power"
FLOATING = {
    "lateral displacement": SIDEWAYS,
    "largest side force": SIDE_FORCE,
    "mean friction power of both bosses": [Shown("sum", BOSSES)],
    "mean friction power of the small end": [Shown("mean", "small_end_film.friction_power")],
} | PIN_FILMS
YIELDING = PIN_FILMS | {
    "mean friction power: skirt, bosses, small end": [
        Shown("mean", "skirt_film.friction_power"),
        Shown("sum", BOSSES),
        Shown("mean", "small_end_film.friction_power"),
    ],
    "lateral displacement": SIDEWAYS,
    "largest side force": SIDE_FORCE,
}
RINGS = {
    "largest side force of the skirt": SIDE_FORCE,
    "largest side force of the rings": [Shown("abs", "rings.side_force", "kN")],
    "largest lateral displacement of A": [Shown("max", "bodies.lateral_displacement", "um")],
    "range of the tilt": TILT,
    "friction power of skirt and rings": [
        Shown("mean", "ehd.friction_power"),
        Shown("mean", "rings.friction_power"),
    ],
    "iterations per step": [Shown("summary", "mean_iterations")],
}
TIED = {
    "lateral displacement": SIDEWAYS,
    "largest side force": SIDE_FORCE,
    "mean friction power of both bosses": [Shown("mean", "bodies.pin_friction_power")],
}
FILM = {
    "minimum film thickness": [Shown("min", "ehd.minimum_film_thickness", "um")],
    "maximum pressure": [Shown("max", "ehd.maximum_pressure", "MPa")],
    "maximum side force": SIDE_FORCE,
    "mean iterations per step": [Shown("summary", "mean_iterations")],
}
FRONT, REAR = ({label: [of_cylinder(label, end)] for label in CYLINDER} for end in ENDS)
BOTH = {label: [of_cylinder(label, end) for end in ENDS] for label in CYLINDER}
ON_BLOCK = {
    "shaking force along y": ("block.shaking_force_y", "kN"),
    "moment about z from side forces": ("block.shaking_moment_z", ""),
    "force on the mounts along y": ("block.mount_force_y", ""),
}
LEAST, LARGEST = (
    {label: [Shown(kind, *one)] for label, one in ON_BLOCK.items()} for kind in ("min", "max")
)
UNGROOVED = {
    "minimum film thickness": [Shown("min", "ehd.minimum_film_thickness", "um")],
    "highest pressure": [Shown("max", "ehd.maximum_pressure", "MPa")],
    "mean friction power": [Shown("mean", "ehd.friction_power")],
    "lateral displacement": SIDEWAYS,
    "largest side force": SIDE_FORCE,
}
SHEET = {
    "minimum film thickness": UNGROOVED["minimum film thickness"],
    "highest film pressure": UNGROOVED["highest pressure"],
    "largest side force": SIDE_FORCE,
    "lateral displacement of the pin": SIDEWAYS,
    "mean friction power of skirt and pin": [
        Shown("mean", "ehd.friction_power"),
        Shown("mean", "bodies.pin_friction_power"),
    ],
}
COMPARED = {
    "minimum film thickness": [
        Shown("min", "ehd.minimum_film_thickness", "roughness of data_sheet")
    ],
    "largest side force": [Shown("abs", "bodies.side_force_demand", "kN")],
    "lateral displacement of the pin": [Shown("given", "50")],
}
PIN_FRICTION = {
    "film": UNGROOVED["minimum film thickness"],
    "pressure": UNGROOVED["highest pressure"],
    "side force": SIDE_FORCE,
    "displacement": SIDEWAYS,
}
COEFFICIENT = "participants.bodies.parameters.pin_friction_coefficient"


def of_film(film, *rows):
    """Return quantities of a film."""
    known = {
        "minimum film thickness": [Shown("min", f"{film}.minimum_film_thickness", "um")],
        "highest pressure": [Shown("max", f"{film}.maximum_pressure", "MPa")],
        "mean friction power": [Shown("mean", f"{film}.friction_power")],
        "mean oil flow from the slots": [Shown("mean", f"{film}.flow_openings", "cm3/s")],
    }
    return {row: known[row] for row in rows or [*known][:3]}


PISTON = {"lateral displacement": SIDEWAYS, "largest side force": SIDE_FORCE}
LOWER, UPPER = of_film("lower_film") | PISTON, of_film("upper_film")
LOAD, FLOW = "largest load, 8 deg after firing", "mean oil flow from the slots"
BEARINGS = {"big_end": "big_end_film", "main_bearing": "main_film"}
CRANK = [
    of_film(film, *of_film(film), FLOW)
    | {LOAD: [Shown("length", f"bodies.{name}_force_x bodies.{name}_force_y", "kN")]}
    for name, film in BEARINGS.items()
]
WIDENED = "largest widening along the load"
SHELLS = [
    of_film(film) | {WIDENED: [Shown("max", f"bodies.{output}", "um")]}
    for film, output in (
        ("big_end_film", "big_end_widening_along"),
        ("main_film", "main_bearing_widening_y"),
    )
]
MOBILITY = {"minimum film thickness": [Shown("given", "2.22"), Shown("given", "2.84")]}


def last(kind, output, unit=""):
    """Return a quantity of the last period."""
    return Shown(kind, output, unit, last=True)


ENERGY = "bodies.kinetic_energy"
MOTORCYCLE = {
    "minimum film thickness": [last("min", "ehd.minimum_film_thickness", "um")],
    "highest pressure": [last("max", "ehd.maximum_pressure", "MPa")],
    "largest side force": [last("abs", "bodies.side_force", "kN")],
    "lateral displacement of the pin point": [
        last(kind, "bodies.lateral_displacement", "um") for kind in ("min", "max")
    ],
    "tilt": [last(kind, "bodies.rocking_angle", "deg") for kind in ("min", "max")],
    "largest kinetic energy across the bore": [last("max", ENERGY, "mJ"), last("when", ENERGY)],
    "asperities' share of the friction work": [Shown("measure", "contact_share_ehd", "%")],
    "friction mean effective pressure": [
        Shown("measure", "friction_mean_effective_pressure_pa", "kPa")
    ],
    "iterations per step": [Shown("summary", "mean_iterations")],
}
SLAP = [Shown("measure", "slap_energy_j_bodies", "mJ")]


def slapping(film, bodies="bodies", last=False):
    """Return the quantities of tables that compare slaps; the largest tilt is an absolute value."""
    return {
        "minimum film thickness": [Shown("min", f"{film}.minimum_film_thickness", "um", last)],
        "highest pressure": [Shown("max", f"{film}.maximum_pressure", "MPa", last)],
        "lateral displacement": [
            Shown(kind, f"{bodies}.lateral_displacement", "um", last) for kind in ("min", "max")
        ],
        "largest tilt": [Shown("abs", f"{bodies}.rocking_angle", "deg", last)],
        "slap": SLAP,
    }


WALLS = slapping("ehd", last=True) | {
    "friction mean effective pressure": MOTORCYCLE["friction mean effective pressure"]
}
TWO_CYCLES = {"native": True, "time.stop": "1440 deg", "record.periods": 1}
EDGES = {"participants.ehd.parameters.oil_supply": "edges"}
TEMPERATURES = "even", "hot_oil", "hot_shape", "hot"
TIE = "participants.bodies.build.piston.tie"
ONE_CYCLE = {"time.stop": "720 deg"}
TIES = {
    f"`{tie}`{note}": ("fired_motorcycle", "flooded", ONE_CYCLE | {TIE: tie}, "ehd")
    for tie, note in (("rbe2", ""), ("rbe3", ""), ("sliding", " (default)"))
}
TIES["pin on films"] = ("yielding_bosses", "fired_skirt", {}, "skirt_film")
ENGINE = f"{ROOT}/models/whole_engine"
WHOLE = {
    "skirt": "skirt_film",
    "both bosses": "left_film",
    "small end": "small_end_film",
    "big end": "big_end_film",
    "main bearing": "main_film",
}
HALF_TURN = {
    "time.stop": "180 deg",
    "participants.bodies.parameters.start_crank_angle": "-60 deg",
}


def parts(pin=True, crank=True):
    """Return the quantities of the table of effects for an engine with or without some films."""
    skirt, bosses, end, big, main = WHOLE.values()
    film = [Shown("min", f"{one}.minimum_film_thickness", "um") for one in WHOLE.values()]
    peak = [Shown("max", f"{one}.maximum_pressure", "MPa") for one in WHOLE.values()]
    on_pin = [
        Shown("sum", " ".join(f"{one}.friction_power" for one in (bosses, "right_film", end)))
    ]
    on_crank = [Shown("sum", " ".join(f"{one}.friction_power" for one in (big, main)))]
    slaps = slapping(skirt)
    return {
        "minimum film thickness of the skirt": film[:1],
        "highest pressure of the skirt": peak[:1],
        "lateral displacement": slaps["lateral displacement"],
        "largest tilt": slaps["largest tilt"],
        "largest loss in a slap": SLAP,
        "largest side force": SIDE_FORCE,
        "minimum film thickness: boss, small end": film[1:3] if pin else [],
        "highest pressure: boss, small end": peak[1:3] if pin else [],
        "minimum film thickness: big end, main bearing": film[3:] if crank else [],
        "highest pressure: big end, main bearing": peak[3:] if crank else [],
        "mean friction power: skirt, pin, crank": [
            Shown("mean", f"{skirt}.friction_power"),
            *(on_pin if pin else []),
            *(on_crank if crank else []),
        ],
    }


PAGES = {
    "whole_engine": [
        (
            "quantity 1",
            [
                ("whole_engine", "whole", parts(), HALF_TURN),
                ("whole_engine", "rigid_block", parts(), HALF_TURN),
                (f"{ENGINE}/without_crank_films.toml", None, parts(crank=False), HALF_TURN),
                (f"{ENGINE}/tied.toml", None, parts(pin=False), HALF_TURN),
            ],
        ),
    ],
    "data_sheet": [
        ("quantity", [("data_sheet", "rigid", SHEET), ("data_sheet", "rigid", COMPARED)]),
    ],
    "grooved_skirt": [
        (
            "quantity",
            [
                ("grooved_skirt", "rigid", LOWER),
                ("grooved_skirt", "rigid", UPPER),
                ("data_sheet", "rigid", UNGROOVED),
            ],
        ),
    ],
    "crank_bearings": [
        (
            "quantity",
            [("crank_bearings", "crank", one) for one in (*CRANK, MOBILITY)],
        ),
        ("quantity 1", [("crank_bearings", "elastic", one) for one in SHELLS]),
    ],
    "fired_motorcycle": [
        (
            "quantity",
            [("fired_motorcycle", x, MOTORCYCLE) for x in ("flexible", "flooded", "rigid")],
        ),
        ("scarce oil", [("fired_motorcycle", x, WALLS, TWO_CYCLES) for x in TEMPERATURES]),
        ("flooded", [("fired_motorcycle", x, WALLS, TWO_CYCLES | EDGES) for x in TEMPERATURES]),
    ],
    "ring_pack": [
        ("quantity", [("ring_pack", "rings", RINGS), ("ring_pack", "without", RINGS)]),
    ],
    "lubrication_template": [
        ("quantity", [("data_sheet", "rigid", FILM), ("data_sheet", "template", FILM)]),
    ],
    "twin": [
        ("quantity", [("twin", "twin_180", FRONT), ("twin", "twin_180", REAR)]),
        ("quantity of the block", [("twin", "twin_180", LEAST), ("twin", "twin_180", LARGEST)]),
    ],
    "floating_pin": [
        (
            "quantity",
            [
                ("data_sheet", "rigid", TIED),
                ("floating_pin", "floating", FLOATING),
                ("floating_pin", "half", FLOATING),
            ],
        ),
    ],
    "flexible_twin": [
        (
            "quantity",
            [("flexible_twin", "flexible_180", BOTH), ("flexible_twin", "stiff", BOTH)],
        ),
    ],
    "yielding_bosses": [
        (
            "quantity",
            [("yielding_bosses", label, YIELDING) for label in ("yielding", "rigid", "elastic")],
        ),
    ],
}
"""Page -> its tables: first cell of the head, and each column.

A column has case, variant, quantities and perhaps changes of the case. The second table with the
same first cell has a 1 after it.
"""

ITERATIONS = [Shown("summary", "mean_iterations"), Shown("summary", "max_iterations")]
CREATED = Shown("summary", "energy_created_share_max", "%")
DEFLECTED = Shown("max", "block.largest_bore_deflection", "um")
STEPS = r"needs ([\d.]+) iterations per step"
TEXTS = {
    "twin": [
        (rf"{STEPS} and at most (\d+)", "twin", "twin_180", ITERATIONS),
        (r"creates at most ([\d.]+) %", "twin", "twin_180", [CREATED]),
    ],
    "flexible_twin": [
        (rf"{STEPS}, at most (\d+)", "flexible_twin", "flexible_180", ITERATIONS),
        (r"deflection of a bore is ([\d.]+) um", "flexible_twin", "flexible_180", [DEFLECTED]),
        (r"stiff block needs ([\d.]+)\.", "flexible_twin", "stiff", ITERATIONS[:1]),
    ],
}
"""Page -> pattern of its text, case, variant and the numbers of the groups."""


@pytest.fixture
def runs(tmp_path):
    """Return the runs of cases by case, label and changes, each once."""
    done = {}

    def run(case, label, changes=None):
        key = case, label, str(changes)
        if key not in done:
            template = label == "template"
            opened = pc.open_case(case, changes or {}, None if template else label)
            own = TEMPLATE if template else None
            done[key] = opened.run(tmp_path / f"{len(done)}.h5", lubrication=own)
        return done[key]

    yield run
    for results in done.values():
        results.close()


@pytest.mark.slow
def test_the_friction_of_the_pin_has_the_effect_of_the_page(tmp_path):
    rows, computed = table("models/data_sheet/README.md", "coefficient"), {}
    for row in rows:
        case = pc.open_case("data_sheet", {COEFFICIENT: float(row)})
        with case.run(tmp_path / f"{row}.h5") as results:
            computed[row] = [[one.value(results) for one in own] for own in PIN_FRICTION.values()]
    check(rows, computed)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_a_page_shows_the_numbers_of_its_runs(page, runs):
    for head, columns in PAGES[page]:
        first, number = head.removesuffix(" 1"), int(head.endswith(" 1"))
        rows = table(f"models/{page}/README.md", first, number)
        computed = {row: [] for row in rows}
        for case, label, quantities, *changes in columns:
            assert set(quantities) <= set(rows)
            results = runs(case, label, *changes)
            for row in rows:
                computed[row].append([one.value(results) for one in quantities.get(row, [])])
        check(rows, computed)
    text = (ROOT / f"models/{page}/README.md").read_text()
    for pattern, case, label, quantities in TEXTS.get(page, []):
        values = [one.value(runs(case, label)) for one in quantities]
        check({pattern: [[*written(pattern, text)]]}, {pattern: [values]})


@pytest.mark.slow
def test_the_tie_of_the_pin_has_the_effect_of_the_page(runs):
    rows, computed = table("models/fired_motorcycle/README.md", "tie"), {}
    for tie, (case, label, changes, film) in TIES.items():
        results = runs(case, label, changes)
        cells = [[one.value(results) for one in own] for own in slapping(film).values()]
        computed[tie] = cells
        rows[tie] = rows[tie][1:]  # the bench prints the compliance
    check(rows, computed)


@pytest.mark.slow
def test_the_whole_engine_has_the_numbers_of_its_page(runs):
    results, page = runs("whole_engine", "whole"), "models/whole_engine/README.md"
    angle = np.degrees(results.whole.series("bodies.crank_angle").values)
    side = np.abs(results.whole.series("bodies.side_force").values)
    slap = pc.measures(results)["slap_energy_j_bodies"]
    values = {
        "lateral displacement of the pin point": [one.value(results) for one in SIDEWAYS],
        "tilt": [one.value(results) for one in TILT],
        "largest side force": [side.max() / 1e3, angle[side.argmax()]],
        "largest loss in a slap": [slap.value / 1e-3, angle[slap.row]],
        "friction mean effective pressure of all films": [
            Shown("measure", "friction_mean_effective_pressure_pa", "kPa").value(results)
        ],
        "vertical displacement of the block at the crank axis": [
            Shown(kind, "block.displacement_y", "mm").value(results) for kind in ("min", "max")
        ],
        "vertical force on the mounts": [
            Shown(kind, "block.mount_force_y").value(results) for kind in ("min", "max")
        ],
    }
    check(table(page, "quantity"), {label: [one] for label, one in values.items()})
    computed = {}
    for label, film in WHOLE.items():
        thickness = results.whole.series(f"{film}.minimum_film_thickness").values
        pressure = results.whole.series(f"{film}.maximum_pressure").values
        powers = f"{film} right_film" if label == "both bosses" else film
        power = Shown("sum", " ".join(f"{one}.friction_power" for one in powers.split()))
        ends = ((thickness, thickness.argmin(), 1e-6), (pressure, pressure.argmax(), 1e6))
        extremes = [[values[k] / unit, angle[k]] for values, k, unit in ends]
        computed[label] = [*extremes, [power.value(results)]]
    check(table(page, "film"), computed)
