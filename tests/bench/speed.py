"""Cost of a macro step and of rigid bodies, and the effect of the tolerance: one table.

    python tests/bench/speed.py [--against FOLDER] [--degrees N]

The case is numerical_example from rest, in steps of 1 deg, one thread. FOLDER is a checkout of an
earlier version (`git worktree add FOLDER COMMIT`). By default, the comparison is with whole films
at 1 nm. Each measurement is a process of its own; all of them take turns, and the shortest of
`PASSES` processor times counts.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time, thread_time

PASSES = 3
CURVES = (
    "lateral_displacement",
    "rocking_angle",
    "minimum_film_thickness",
    "maximum_pressure",
    "friction_power",
)
NOW = {"symmetric": True}
TIGHT = {"wires.0.tolerance": "1 nm", "wires.1.tolerance": 1e-6}
BEFORE = {"symmetric": False} | TIGHT
STEP = 1.0 / 36e3  # s, 1 deg at 6000 rpm
NEW_GRID = (44, 36)  # none of the shipped bodies


def single(case, folder, degrees):
    """Step of the native single FMU [s], and its curves."""
    from piston_cosim.master.case.export import export_fmu
    from piston_cosim.master.participants.fmi2 import FmuParticipant

    one = FmuParticipant("one", export_fmu(case, folder, lambda text: None, "2.0", ["linux64"]))
    one.start({}, 0.0, 1.0)
    begin, rows = thread_time(), []
    for k in range(degrees):
        one.step(k * STEP, STEP)
        rows.append([one.get(name) for name in CURVES])
    seconds = (thread_time() - begin) / degrees
    one.close()
    return {"step": seconds, "curves": rows}


def run(case, folder, degrees, tree):
    """Step of `run` [s], from its first macro step to its summary."""
    from piston_cosim.master.case.system import open_system
    from piston_cosim.master.coupling.stepping import Stepper
    from piston_cosim.master.runs.run import run as run_case

    system = open_system(case, folder, lambda text: None)
    times, advance = [], Stepper.advance

    def timed(*arguments):
        times.append(thread_time())
        return advance(*arguments)

    Stepper.advance = timed
    with tempfile.TemporaryDirectory() as scratch:
        run_case(system, case, tree, Path(scratch) / "run.h5")
    return {"step": (thread_time() - times[0]) / degrees}


def rigid(folder):
    """Time of the build of rigid bodies on a new grid [s], and peak memory [MB]."""
    from piston_cosim.master.case.reading import find_case, read_tree
    from piston_cosim.master.fmi.tree import import_part

    modes = [(f"participants.bodies.build.{body}.modes", 0) for body in ("piston", "block")]
    grid = ("participants.bodies.build.grid", list(NEW_GRID))
    build = read_tree(find_case("numerical_example"), [*modes, grid])["participants"]["bodies"]
    begin = process_time()
    import_part("fmu_mfbd.build").prepare(build["build"], folder, lambda text: None)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"seconds": process_time() - begin, "memory": memory}


def measure(kind, degrees, changes):
    """Print one measurement as JSON."""
    from piston_cosim.master.case.checked import check_case
    from piston_cosim.master.case.reading import find_case, read_tree

    path = find_case("numerical_example")
    if kind == "rigid":
        return rigid(path.parent)
    more = {"time.stop": f"{degrees} deg", "record.fields": [], "native": kind != "python"}
    tree = read_tree(path, [*{**changes, **more}.items()])
    case = check_case(tree, path)
    if kind == "single":
        return single(case, path.parent, degrees)
    return run(case, path.parent, degrees, tree)


def measured(kind, degrees, changes, package=None):
    """Return a measurement in a process of its own, of the package in a folder if given."""
    with tempfile.TemporaryDirectory() as scratch:
        variables = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        if kind == "rigid":
            variables |= {"PISTON_COSIM_CACHE": scratch}
        if package:
            (Path(scratch) / "piston_cosim").symlink_to(Path(package).resolve())
            variables |= {"PYTHONPATH": scratch}
        command = [sys.executable, "-W", "ignore", __file__, "--measure", kind]
        command += ["--degrees", str(degrees), "--changes", json.dumps(changes)]
        process = subprocess.run(command, env=variables, stdout=subprocess.PIPE, check=True)
        return json.loads(process.stdout.splitlines()[-1])


def main(against, degrees):
    earlier = TIGHT if against else BEFORE  # a checkout need not know the key `symmetric`
    kinds = {
        "native single FMU": ("single", NOW, None),
        "native single FMU, 1 nm": ("single", NOW | TIGHT, None),
        "native single FMU, before": ("single", earlier, against),
        "run, native": ("native", NOW, None),
        "run, Python": ("python", NOW, None),
        "run, Python, before": ("python", earlier, against),
    }
    found = {name: [] for name in kinds}
    for _ in range(PASSES):
        for name, (kind, changes, package) in kinds.items():
            found[name].append(measured(kind, degrees, changes, package))
    step = {name: min(one["step"] for one in some) for name, some in found.items()}
    for name, seconds in step.items():
        print(f"{name:28} {1e3 * seconds:6.2f} ms a step")
    now, before = step["native single FMU"], step["native single FMU, before"]
    rows = [
        ("native single FMU, over before", now / before, 0.55),
        ("run native, over single FMU", step["run, native"] / now, 1.15),
        ("run Python, over before", step["run, Python"] / step["run, Python, before"], 0.75),
    ]
    loose, tight = (found[f"native single FMU{name}"][0]["curves"] for name in ("", ", 1 nm"))
    for k, name in enumerate(CURVES):
        one, other = ([row[k] for row in rows_of] for rows_of in (loose, tight))
        apart = max(abs(a - b) for a, b in zip(one, other)) / (max(other) - min(other))
        limit = 5e-4 if name == "maximum_pressure" else 1e-4
        rows.append((f"10 nm against 1 nm, {name}", apart, limit))
    bodies = measured("rigid", degrees, {})
    rows += [
        ("rigid bodies on a new grid [s]", bodies["seconds"], 2.0),
        ("rigid bodies on a new grid [MB]", bodies["memory"], 250.0),
    ]
    for name, value, limit in rows:
        print(f"{name:48} {value:9.3g}   wanted {limit:g}{'' if value <= limit else '   above'}")
    print("load average", *(f"{one:.2f}" for one in os.getloadavg()))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", metavar="FOLDER")
    parser.add_argument("--degrees", type=int, default=180)
    parser.add_argument("--measure", help=argparse.SUPPRESS)
    parser.add_argument("--changes", default="{}", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.measure:
        print(json.dumps(measure(given.measure, given.degrees, json.loads(given.changes))))
    else:
        main(given.against, given.degrees)
