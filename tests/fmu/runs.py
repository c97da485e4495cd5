"""Cases on coarse grids, their runs in the process of the tests, and their FMUs."""

import re
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from unittest import mock

import h5py
import pytest
from fmpy.validation import validate_fmu
from lark import Lark

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import start
from piston_cosim.master.coupling.stepping import Stepper
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import build_native_fmu, too_old
from piston_cosim.master.fmi.compiler import compiler
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.checkpoint import Checkpoint
from piston_cosim.master.runs.run import run

EXAMPLE = find_case("numerical_example")


def tight(tree, tolerance="1 nm"):
    """Return the tree of a case that iterates all its films to a tolerance."""
    wires = [
        wire | {"tolerance": tolerance} if wire["to"].endswith("film_thickness") else wire
        for wire in tree["wires"]
    ]
    return tree | {"wires": wires}


TIGHT = ("wires.0.tolerance", "1 nm"), ("wires.1.tolerance", 1e-6)
"""Tolerances of film thickness and velocity at which runs that differ in their method agree."""
FEW_MODES = 12
"""Modes of both bodies of a small flexible example. All tests share its reduction: 20 s."""


def coarse(*changes, grid=(12, 10), modes=0):
    """Return changes of a case with one film: cells, and modes of both bodies unless None.

    The tolerances are `TIGHT`.
    """
    bodies = ("piston", "block") if modes is not None else ()
    return [
        *TIGHT,
        *((f"participants.{name}.build.grid", list(grid)) for name in ("bodies", "ehd")),
        *((f"participants.bodies.build.{body}.modes", modes) for body in bodies),
        *changes,
    ]


def small_tree(*changes, **sizes):
    """Return the tree of the numerical example, rigid unless `modes` are given; see `coarse`."""
    return read_tree(EXAMPLE, coarse(*changes, **sizes))


def pin_case(path, films, *changes, skirt=(24, 12), pin=(48, 4), crank=(48, 4), stop="30 deg"):
    """Return the tree of a case with a floating pin on coarse grids, without slots, nothing drawn.

    films : film of pin or crank -> surface.
    """
    tree = read_tree(path, [("time.stop", stop), *changes])
    tables = tree["participants"]
    build = tables["bodies"]["build"]
    build["grid"] = tables["skirt_film"]["build"]["grid"] = list(skirt)
    build["floating_pin"] = build["floating_pin"] | {"grid": list(pin)}
    for name, surface in films.items():
        grid = list(crank if surface in build else pin)
        if surface in build:
            build[surface] = build[surface] | {"grid": grid}
        tables[name]["build"] |= {"grid": grid, "mask": "none"}
        for supply in ("opening_supply", "pressure_openings"):
            tables[name]["parameters"].pop(supply, None)
    record = {"fields": ["left_film.pressure"], "every": 10}
    return tight(tree) | {"record": record, "pictures": []}


def run_tree(origin, tree, output, **how):
    """Return the results of a case's tree, whose file is at `origin`."""
    case = check_case(tree, origin)
    run(open_system(case, origin.parent, print), case, tree, output, **how)
    return Results(output)


class Stopped(RuntimeError):
    """Raised in the middle of a run."""


def stopped(origin, tree, output, at):
    """Stop a run at a time [s]; return its last checkpoint."""

    def watch(time, *others):
        if time > at:
            raise Stopped

    with pytest.raises(Stopped):
        run_tree(origin, tree, output, watch=watch)
    return Checkpoint.read(Checkpoint.path(output))


def open_text(folder, text, changes=()):
    """Write a case into a folder; return the case and its system."""
    path = folder / "case.toml"
    path.write_text(text)
    case = check_case(read_tree(path, changes), path)
    return case, open_system(case, folder, print)


def stepper(case, system):
    """Start a system; return what advances it by one macro step."""
    start(system)
    method = method_of(case.coupling)
    return Stepper(system, method, 3, held=system.held, clocks=system.clocks)


def run_text(folder, text, changes=(), output=None):
    """Write a case into a folder and return its results."""
    path = folder / "case.toml"
    path.write_text(text)
    return run_tree(path, read_tree(path, changes), output or folder / "o.h5")


def datasets(path):
    """Return all arrays of a results file by name."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, one: found.update({name: one[()]} if isinstance(one, h5py.Dataset) else {})
        )
    return found


def values_of(results, *names):
    """Return values of recorded curves, one array for each name."""
    found = [results.series(name).values for name in names]
    return found if len(names) > 1 else found[0]


def is_sound(results, energy=True):
    """Assert that oil and work of every film are kept to round-off and every step converged."""
    errors = [name for name in results.ports if name.endswith("interface_work_error")]
    films = [name for name in results.ports if name.endswith("mass_imbalance")]
    assert len(errors) == len(films) > 0
    for name in (*errors, *films):
        assert results.series(name).values.max() <= 1e-12, name
    assert results.summary["unconverged_steps"] == 0
    assert abs(results.summary["interface_work_imbalance"]) <= 1e-5
    assert not energy or results.summary["energy_created_share_max"] < 0.05


def module_of(path):
    """Return the module of a file that is in no package."""
    spec = spec_from_file_location(path.stem, path)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def problems_of(fmu):
    """Return what FMPy rejects in an FMU; it parses one of the names that differ in numbers alone.

    Its parser takes 5 ms for the name of each element of an array.
    """
    parse = cache(Lark.parse)

    def parsed(parser, name):
        return parse(parser, re.sub(r"\d+", "1", name))

    with mock.patch.object(Lark, "parse", parsed):
        return validate_fmu(str(fmu))


def reached(one):
    """Return the end of the last step of an instance [s], where its next step begins."""
    return one.get("time") if one.version == "3" else one._reached(0.0)


def build_of(tree, path, name):
    """Return package, build table and folder of a participant."""
    table = check_case(tree, path).participants[name]
    return table.package, table.build, path.parent


def needs_compiler(native=True):
    """Skip a test where nothing can be compiled."""
    if not compiler():
        pytest.skip("no C compiler, or not Linux on x86-64")
    if native and too_old():
        pytest.skip(too_old()[0])


def make(package, options, folder, native=False, version="2.0", **more):
    """Return an FMU of a package, native or in Python."""
    if native:
        needs_compiler()
        return build_native_fmu(package, options, folder, version=version, **more)
    return build_fmu(package, options, folder, version=version, **more)


def export(tree, path=EXAMPLE, native=False, version="2.0", coordinates=False):
    """Return the coupled FMU of a tree, native or in Python.

    The native one iterates on wires as the one in Python does, to round-off, or in coordinates.
    """
    if native:
        needs_compiler()
    advanced = tree["coupling"].get("advanced", {}) | {"coordinates": coordinates}
    tree = tree | {"coupling": tree["coupling"] | {"advanced": advanced}}
    platforms = ["linux64"] if native else ()
    return export_fmu(check_case(tree, path), path.parent, print, version, platforms)
