"""Shipped cases on coarse grids, and the runs of them that `results_of` computes once a session."""

from functools import partial

import numpy as np

from piston_cosim.master.case.reading import find_case, read_tree

from .engines import ENGINES, engine_tree
from .engines import PATH as TWIN
from .films import PATH as DATA_SHEET
from .films import even_bands, one_film, several_films
from .runs import coarse, pin_case, tight

FLOATING_PIN, CRANK_BEARINGS = find_case("floating_pin"), find_case("crank_bearings")
YIELDING, FLEXIBLE_TWIN = find_case("yielding_bosses"), find_case("flexible_twin")
WHOLE = find_case("whole_engine")
BUILD, PARAMETERS = "participants.bodies.build", "participants.bodies.parameters"
PIN, SPACE = f"{BUILD}.floating_pin", f"{BUILD}.motion_in_space"
BEFORE_FIRING = (f"{PARAMETERS}.start_crank_angle", "-40 deg")
PINS = {"left_film": "boss_left", "right_film": "boss_right", "small_end_film": "small_end"}
BEARINGS = PINS | {"big_end_film": "big_end", "main_film": "main_bearing"}
BORE = (f"{PARAMETERS}.pin_bore_radius", "9.4 mm")
MOMENTS = {"inertia_x": "0.0033 kg*m^2", "inertia_y": "0.0029 kg*m^2"}
TILT = (f"{PARAMETERS}.pin_tilt", "0.5 mrad")
EYE = {
    "mesh": "small_end.msh.xz",
    "density": "7850 kg/m^3",
    "young": "206 GPa",
    "poisson": 0.3,
    "modes": 40,
}
GRID = (24, 20)
"""Of one or several films on the skirt of `data_sheet`."""
GROOVED = [(1, 9), (12, 20)]

small_pin = partial(pin_case, FLOATING_PIN, PINS)
small_crank = partial(pin_case, CRANK_BEARINGS, BEARINGS)


def recorded(tree, *fields):
    """Return a tree that records some fields, every tenth step."""
    return tree | {"record": {"fields": [*fields], "every": "10 deg"}}


def firing_pin(shapes, *changes):
    """Return the tree of a floating pin through the firing, with shapes of the pin or none."""
    bent = [(f"{PIN}.pin_shapes", shapes), BORE] if shapes else []
    fields = ["left_film.pressure", *(f"bodies.{one}.film_thickness" for one in PINS.values())]
    return recorded(small_pin(BEFORE_FIRING, *bent, *changes, stop="80 deg"), *fields)


def yielding(*changes):
    """Return the tree of yielding bosses, with few modes, through the firing."""
    short = {"boss_length": "16 mm", "small_end_length": "20 mm", "boss_modes": 24}
    few = ((f"{BUILD}.piston.modes", 50), (PIN, short))
    given = (BEFORE_FIRING, *few, *changes)
    tree = pin_case(YIELDING, PINS, *given, pin=(48, 4), stop="80 deg")
    return recorded(tree, "left_film.pressure", "small_end_film.pressure")


def whole_engine(*changes):
    """Return the tree of the whole engine with few modes."""
    pin = {"boss_length": "16 mm", "small_end_length": "20 mm", "boss_modes": 24, "pin_shapes": 3}
    eye = EYE | {"mesh": "../yielding_bosses/small_end.msh.xz", "modes": 20}
    few = [(f"{BUILD}.{body}.modes", modes) for body, modes in (("piston", 50), ("block", 12))]
    few += [(f"{BUILD}.{name}.shell.modes", 12) for name in ("big_end", "main_bearing")]
    few += [(PIN, pin | {"small_end": eye}), *changes]
    return pin_case(WHOLE, BEARINGS, *few, stop="20 deg")


def tied(*changes):
    """Return the tree of the piston of the data sheet, whose pin is tied; nothing is drawn."""
    tree = read_tree(DATA_SHEET, coarse(*changes, grid=(24, 12), modes=None))
    return {**tree, "record": {"every": 100}, "pictures": []}


def cycle(supply):
    """Return the tree of a period of the data sheet in long steps, with a supply of oil."""
    changes = {
        "time.step": "5 deg",
        "record.fields": [],
        "participants.ehd.parameters.oil_supply": supply,
        "participants.ehd.parameters.stroke": "160 mm",
    }
    return read_tree(DATA_SHEET, coarse(*changes.items(), grid=(16, 12), modes=None))


def with_cut_out():
    """Return the tree of one film, rows 10 and 11 cut out, which hold what the edges hold."""
    tree = one_film(GRID, "60 deg")
    mask = np.ones(GRID, dtype=int)
    mask[:, 9:11] = 0
    tree["participants"]["ehd"]["build"]["mask"] = mask.tolist()
    return tree


def flexible_twin(stop, path=FLEXIBLE_TWIN):
    """Return the tree of two cylinders on a coarse film grid, nothing drawn."""
    tree = read_tree(path, [("time.stop", stop)])
    for name in ("front", "rear"):
        for participant in (name, f"{name}_film"):
            tree["participants"][participant]["build"]["grid"] = [16, 12]
    for key in ("variants", "beside", "pictures", "axes", "monitor"):
        tree.pop(key, None)
    return tree | {"record": {"fields": ["front.film_thickness"], "every": 1}}


RUNS = {
    "floating_pin": lambda: (FLOATING_PIN, firing_pin(0)),
    "bending_pin": lambda: (
        FLOATING_PIN,
        tight(firing_pin(5), "0.1 nm"),
    ),  # mirrors as well as that
    "tied_pin": lambda: (DATA_SHEET, tied(BEFORE_FIRING, ("time.stop", "80 deg"))),
    "crank_bearings": lambda: (CRANK_BEARINGS, small_crank(stop="400 deg")),
    "yielding_bosses": lambda: (YIELDING, yielding()),
    "whole_engine": lambda: (WHOLE, whole_engine(BEFORE_FIRING, ("time.stop", "80 deg"))),
    "rigid_bosses": lambda: (
        YIELDING,
        yielding((f"{BUILD}.piston.modes", 0), (f"{PIN}.boss_modes", 0)),
    ),
    "elastic_eye": lambda: (
        YIELDING,
        yielding(
            ("time.stop", "50 deg"),
            (f"{PIN}.small_end", EYE),
            (f"{PIN}.pin_shapes", 4),
            (BORE[0], "5.2 mm"),
        ),
    ),
    # a pin that is not square and a centre of mass 1 mm beside the plane, over the firing
    "piston_in_space": lambda: (
        DATA_SHEET,
        tied(("time.stop", "400 deg"), (SPACE, MOMENTS | {"centre_z": "1 mm"}), TILT),
    ),
    "cycle": lambda: (DATA_SHEET, cycle("edges")),
    "starved_cycle": lambda: (DATA_SHEET, cycle("bore_and_ring")),
    "one_film": lambda: (DATA_SHEET, with_cut_out()),
    "two_films": lambda: (DATA_SHEET, several_films(GRID, "60 deg", GROOVED)),
    "four_films": lambda: (DATA_SHEET, several_films(GRID, "60 deg", even_bands(20, 4))),
    "in_line_four": lambda: (TWIN, engine_tree(ENGINES["in-line four"], (16, 12), "24 deg")),
    "flexible_twin": lambda: (FLEXIBLE_TWIN, flexible_twin("24 deg")),
}
"""Name -> path and tree of a run."""
