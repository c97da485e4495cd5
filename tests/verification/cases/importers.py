"""Independent importers of the exported engine FMU, compared with the results of `run`.

Each importer runs in a separate process. The comparison is over the whole case, and includes the
row before the first step.

`piston-cosim verify importers` tries them on the numerical example in FMI 2.0 and 3.0, with Python
and without (native). It also tries a host in plain C (host.c). PISTON_COSIM_PYTHONS names further
interpreters, separated by colons. Their Python versions run the FMUs too, and so do the importers
installed there.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from rich.table import Table

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.fmi.archive import unpack
from piston_cosim.master.fmi.builder_native import too_old
from piston_cosim.master.fmi.compiler import compiler
from piston_cosim.master.fmi.quantities import to_si
from piston_cosim.master.fmi.requirements import PACKAGES
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

WATCHED = (
    "lateral_displacement",
    "rocking_angle",
    "minimum_film_thickness",
    "maximum_pressure",
    "side_force",
    "friction_power",
)
"""Outputs of the engine FMU that are compared."""

ALLOWED = 1e-5
"""Allowed distance over the range of an output. An importer whose clock counts whole nanoseconds
takes steps that are 8e-6 longer. It is compared with a run in these steps.
"""

EXACT = ("wires.0.tolerance", "0.1 nm"), ("wires.1.tolerance", 1e-7)
"""Tolerances at which round-off of the importers' times does not reach `ALLOWED`."""

NATIVE = "resources/slave.bin"
"""What an FMU that needs no Python holds."""

MARK = "seen: "
COMMON = f"""
import json, sys
from pathlib import Path
from xml.etree import ElementTree
fmu, folder, count, step, names = sys.argv[1:6]
count, step, names = int(count), float(step), json.loads(names)
root = ElementTree.parse(Path(folder) / "modelDescription.xml").getroot()
third = root.get("fmiVersion").startswith("3")
known = {{v.get("name"): int(v.get("valueReference")) for v in root.find("ModelVariables")}}
references = [known[name] for name in names]
identifier = root.find("CoSimulation").get("modelIdentifier")
token = root.get("guid") or root.get("instantiationToken")
rows = []
def keep(time, values):
    rows.append([float(time), *map(float, values)])
def seen(what):
    print({MARK!r} + json.dumps(what), flush=True)
def seen_in_table(*command):
    import csv, subprocess, tempfile
    table = Path(tempfile.mkdtemp()) / "out.csv"
    words = [str(word).replace("TABLE", str(table)) for word in command]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    last_rows = {{row["time"]: row for row in csv.DictReader(table.read_text().splitlines())}}
    for time, row in last_rows.items():
        keep(time, [row[name] for name in names])
    seen(rows)
"""


@dataclass(frozen=True)
class Importer:
    """An importer, or a checker.

    package : what pip calls it; None for one that comes with this tool;
    script : shows the rows (time, watched outputs), or what is wrong with the FMU;
    versions : of the standard that it reads;
    source : where it is had;
    tick : of its clock [s], whose multiples its steps are; 0 where steps are any number;
    program : the command that it is, if it is none of Python.
    """

    package: str | None
    script: str
    versions: tuple[str, ...] = ("2.0", "3.0")
    source: str = ""
    tick: float = 0.0
    program: str = ""


IMPORTERS = {
    "fmpy in process": Importer(
        "fmpy",
        """
import fmpy
times = {"stop_time": count * step, "output_interval": step, "step_size": step}
for row in fmpy.simulate_fmu(fmu, **times, output=names):
    keep(row[0], [row[name] for name in names])
seen(rows)""",
        source="pip install fmpy",
    ),
    "fmpy simulate": Importer(
        "fmpy",
        """
seen_in_table(sys.executable, "-m", "fmpy", "simulate", fmu, "--stop-time", count * step,
              "--output-interval", step, "--output-variables", *names, "--output-file", "TABLE")""",
        source="pip install fmpy",
    ),
    "fmpy validate": Importer(
        "fmpy",
        """
from fmpy.validation import validate_fmu
seen(validate_fmu(fmu) or "no problem")""",
        source="pip install fmpy",
    ),
    "libcosim": Importer(
        "libcosimpy",
        """
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
nanoseconds = round(step * 1e9)
execution = CosimExecution.from_step_size(step_size=nanoseconds)
index = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="one"))
observer = CosimObserver.create_time_series(buffer_size=count + 1)
execution.add_observer(observer)
for reference in references:
    observer.start_time_series(index, reference, CosimVariableType.REAL)
assert execution.step(step_count=count)
def part(begin, length):  # it takes a row away for each of number 0: the first by itself
    columns = [
        observer.time_series_real_samples(index, reference, begin, length)
        for reference in references
    ]
    for time, *values in zip(columns[0][0], *(column[2] for column in columns)):
        keep(time * 1e-9, values)
part(0, 2)
part(1, count)
seen(rows)""",
        ("2.0",),
        source="pip install libcosimpy",
        tick=1e-9,
    ),
    "Ecos": Importer(
        "ecospy",
        """
from ecospy import EcosSimulation, EcosSimulationStructure
structure = EcosSimulationStructure()
structure.add_model("one", fmu)
with EcosSimulation(structure=structure, step_size=step) as simulation:
    simulation.init()
    for k in range(count + 1):
        if k:
            simulation.step(1)
        keep(k * step, [simulation.get_real("one::" + name) for name in names])
seen(rows)""",
        source="apt install libtbb12; pip install ecospy",
    ),
    "fmuloader": Importer(
        "fmuloader",
        """
if third:
    from fmuloader.fmi3 import Fmi3Slave
    one = Fmi3Slave(fmu, model_identifier=identifier)
    one.instantiate_co_simulation("one", instantiation_token=token)
    one.enter_initialization_mode(start_time=0.0)
    get = one.get_float64
else:
    from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
    one = Fmi2Slave(fmu, model_identifier=identifier)
    one.instantiate("one", Fmi2Type.CO_SIMULATION, guid=token)
    one.setup_experiment(start_time=0.0)
    one.enter_initialization_mode()
    get = one.get_real
one.exit_initialization_mode()
keep(0.0, get(references))
for k in range(count):
    one.do_step(k * step, step)
    keep((k + 1) * step, get(references))
seen(rows)
one.terminate()
one.free_instance()""",
        source="pip install fmuloader",
    ),
    "PyFMI": Importer(
        "PyFMI",
        """
from pyfmi import load_fmu
one = load_fmu(fmu)
one.setup_experiment()
one.initialize()
keep(0.0, [one.get(name)[0] for name in names])
for k in range(count):
    assert one.do_step(k * step, step) == 0
    keep((k + 1) * step, [one.get(name)[0] for name in names])
seen(rows)""",
        ("2.0",),
        source="conda install -c conda-forge pyfmi",
    ),
    "fmu-manipulation-toolbox": Importer(
        "fmu_manipulation_toolbox",
        """
import subprocess
tool = str(Path(sys.executable).parent / "fmutool")
done = subprocess.run([tool, "-input", fmu, "-check"], capture_output=True, text=True)
words = done.stdout + done.stderr
bad = [line for line in words.splitlines() if line.startswith(("ERROR", "WARNING"))]
seen(bad or "no problem")""",
        source="pip install fmu-manipulation-toolbox",
    ),
    "fmusim": Importer(
        None,
        """
watched = [word for name in names for word in ("--output-variable", name)]
seen_in_table("fmusim", "--interface-type", "cs", "--stop-time", count * step,
              "--output-interval", step, *watched, "--output-file", "TABLE", fmu)""",
        source="download a release of the Reference-FMUs, up to 0.0.39",
        program="fmusim",
    ),
    "FMU Compliance Checker": Importer(
        None,
        """
seen_in_table("fmuCheck.linux64", "-k", "cs", "-h", step, "-n", 0, "-s", count * step,
              "-o", "TABLE", fmu)""",
        ("2.0",),
        source="download a release of FMUComplianceChecker",
        program="fmuCheck.linux64",
    ),
    "MasterSim": Importer(
        None,
        """
import csv, subprocess, tempfile
project = Path(tempfile.mkdtemp()) / "engine.msim"
project.write_text(f'''
tEnd {count * step!r} s
hMax {step!r} s
hStart {step!r} s
hMin 1e-9 s
hFallBackLimit 1e-9 s
hOutputMin {step / 2!r} s
adjustStepSize no
MasterMode GAUSS_JACOBI
ErrorControlMode NONE
maxIterations 1
simulator 0 0 engine #000000 "{fmu}"
''')
done = subprocess.run(["mastersim", "-x", project], capture_output=True, text=True)
assert done.returncode == 0, done.stdout + done.stderr
table = (project.with_suffix("") / "results" / "values.csv").read_text().splitlines()
for row in csv.DictReader(table, delimiter="\\t"):
    of = {column.split(" ")[0]: value for column, value in row.items() if column}
    keep(of["Time"], [of["engine." + name] for name in names])
seen(rows)""",
        ("2.0",),
        source="download a release of MasterSim",
        program="mastersim",
    ),
    "OMSimulator": Importer(
        None,
        """
seen_in_table("OMSimulator", f"--stopTime={count * step!r}", f"--stepSize={step!r}",
              f"--intervals={count}", "--resultFile=TABLE", fmu)""",
        ("2.0",),
        source="pip install OMSimulator, or build it",
        program="OMSimulator",
    ),
    "Python alone (ctypes)": Importer(
        None,
        """
import ctypes, urllib.parse
said = []
text = ctypes.c_char_p
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, text, ctypes.c_int, text, text)
logger = LOGGER(lambda *arguments: said.append(arguments[-1].decode()))
callbacks = (ctypes.c_void_p * 5)(ctypes.cast(logger, ctypes.c_void_p).value)
library = ctypes.CDLL(str(Path(folder) / "binaries" / "linux64" / (identifier + ".so")))
library.fmi2Instantiate.restype = ctypes.c_void_p
location = ("file://" + urllib.parse.quote(str(Path(folder) / "resources"))).encode()
one = library.fmi2Instantiate(b"one", 1, token.encode(), location, callbacks, 0, 0)
if not one:
    seen("refused: " + "; ".join(said))
    sys.exit()
one, d = ctypes.c_void_p(one), ctypes.c_double
wanted, values = (ctypes.c_uint * len(names))(*references), (d * len(names))()
def row(time):
    assert not library.fmi2GetReal(one, wanted, ctypes.c_size_t(len(names)), values), said
    keep(time, values)
calls = [library.fmi2SetupExperiment(one, 0, d(0), d(0), 0, d(0)),
         library.fmi2EnterInitializationMode(one), library.fmi2ExitInitializationMode(one)]
row(0.0)
for k in range(count):
    calls.append(library.fmi2DoStep(one, d(k * step), d(step), 0))
    row((k + 1) * step)
assert not any(calls), said
library.fmi2FreeInstance(one)
seen(rows)""",
        ("2.0",),
    ),
}
"""Name -> importer of co-simulation FMUs on Linux."""

ELSEWHERE = {"VDMCheck": "download a release of FMI-VDM-Model, needs Java"}
"""Checkers without a package, and where to get them."""

LACKING = """
from importlib.util import find_spec
print("lacks", *[name for name in {names} if not find_spec(name)])"""
"""Says what a Python lacks of `names`."""

HOST = "plain C host"
NOT_INSTALLED = "not installed"
FAILED = "failed"


@dataclass(frozen=True)
class Trial:
    """What one importer saw of one FMU: rows of time and watched outputs, or words."""

    importer: str
    version: str
    python: str
    seen: np.ndarray | str

    @property
    def tick(self):
        """Of the importer's clock [s]."""
        return IMPORTERS[self.importer].tick if self.importer in IMPORTERS else 0.0


def try_importers(fmu, version, count, step, pythons=(sys.executable,)):
    """Yield the result of each importer.

    Parameters
    ----------
    fmu : Path
        FMU for co-simulation with the outputs `WATCHED`.
    version : {"2.0", "3.0"}
        Its version of the standard.
    count : int
        Steps to take.
    step : float
        Their length [s].
    pythons : iterable of path
        Interpreters; each importer is tried in the ones it is installed in, and named once if it is
        in none.

    Yields
    ------
    Trial
    """
    folder = unpack(fmu)
    needed = () if (Path(folder) / NATIVE).exists() else PACKAGES
    arguments = (fmu, folder, count, repr(step), json.dumps(WATCHED))
    yield Trial(HOST, "-", "-", _ask_host(folder, count, step))
    offered = {name: one for name, one in IMPORTERS.items() if version in one.versions}
    absent = dict.fromkeys(offered)
    for python in pythons:
        release = str(_ask(python, "import platform; print(platform.python_version())"))
        _, *lacking = str(_ask(python, LACKING.format(names=needed))).split()
        for name, importer in offered.items():
            asked = f"import importlib.metadata as m; print(m.version({importer.package!r}))"
            installed = str(_ask(python, asked)) if importer.package else "-"
            if importer.program and not shutil.which(importer.program):
                continue
            if not installed.startswith(FAILED):
                absent.pop(name, None)
                seen = (
                    f"{NOT_INSTALLED}: {', '.join(lacking)}, needed in the Python that runs the FMU"
                    if lacking
                    else _ask(python, COMMON + importer.script, *arguments)
                )
                yield Trial(name, installed, release, seen)
    for name in absent:
        yield Trial(name, "-", "-", f"{NOT_INSTALLED}: {offered[name].source}")


def _ask_host(folder, count, step):
    """Rows that host.c prints, compiled here; words where it fails."""
    if not (cc := compiler()):
        return f"{NOT_INSTALLED}: a C compiler (cc, or $CC)"
    root = ElementTree.parse(Path(folder) / "modelDescription.xml").getroot()
    third = root.attrib["fmiVersion"].startswith("3")
    place = "x86_64-linux" if third else "linux64"
    known = {v.get("name"): v.get("valueReference") for v in root.iter() if v.get("valueReference")}
    modelled = root.find("CoSimulation")
    assert modelled is not None  # the builder's
    library = Path(folder) / "binaries" / place / f"{modelled.attrib['modelIdentifier']}.so"
    token = root.get("instantiationToken" if third else "guid")
    with tempfile.TemporaryDirectory() as scratch:
        program = Path(scratch) / "host"
        source = Path(__file__).with_name("host.c")
        subprocess.run([cc, "-o", program, source, "-ldl"], check=True)
        location = Path(folder) / "resources"
        words = [program, root.get("fmiVersion"), library, token]
        words += [location if third else location.as_uri(), repr(step), count]
        words += [known[name] for name in WATCHED]
        done = subprocess.run([*map(str, words)], capture_output=True, text=True, cwd="/")
    if done.returncode:
        return _failure(done)
    return np.array([line.split() for line in done.stdout.splitlines()], dtype=float)


def _failure(done):
    """Words on a process that failed, with the last line of its error."""
    return f"{FAILED} ({done.returncode}): {(done.stderr.strip().splitlines() or [''])[-1]}"


def _ask(python, script, *arguments):
    """Return the rows or the message that the script reports, else the last printed line.

    If the script fails, return "failed" with the last line of the error.
    """
    done = subprocess.run(
        [str(python), "-c", script, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=3600,
        cwd="/",
    )
    if done.returncode:
        return _failure(done)
    lines = done.stdout.strip().splitlines() or ["nothing"]
    for line in lines:
        if line.startswith(MARK):
            what = json.loads(line.removeprefix(MARK))
            rows = isinstance(what, list) and isinstance(what[0], list)
            return np.array(what) if rows else str(what)
    return lines[-1]


def distance(rows, reference):
    """How far rows are from those of a run, the worst output's.

    Eq. (Y5):  d = max over outputs and rows of  |y - y_run| / (max y_run - min y_run)

    Parameters
    ----------
    rows, reference : ndarray, shape (steps + 1, 1 + outputs)
        Time [s] in the first column.

    Returns
    -------
    float
        d [-]; infinite where the row before the first step or one of the others is missing, or
        where a row's time is off by 1e-6 of a step or more.
    """
    times = reference[:, 0]
    step = times[1] - times[0]
    complete = len(rows) == len(reference) and np.all(np.abs(rows[:, 0] - times) < 1e-6 * step)
    if not complete:
        return np.inf
    ranges = np.ptp(reference[:, 1:], axis=0)
    return float(np.max(np.abs(rows[:, 1:] - reference[:, 1:]) / ranges))  # Eq. (Y5)


def judged(trial, reference):
    """Return the result of a trial, "ok", "FAIL" or "-", and its message.

    "-" means that the importer is not installed, or that the FMU reports a package missing from
    Python.
    """
    seen = trial.seen
    if not isinstance(seen, str):
        far = distance(seen, reference)
        said = "rows are missing" if np.isinf(far) else f"{far:.1e} over {len(seen)} rows"
        return ("ok" if far <= ALLOWED else "FAIL"), said
    if seen.startswith(NOT_INSTALLED) or "-m pip install" in seen:
        return "-", seen
    return ("ok" if seen == "no problem" else "FAIL"), seen


def _shipped(changes):
    """Path, tree and case of the numerical example with changes."""
    path = find_case("numerical_example")
    tree = read_tree(path, [*changes, *EXACT])
    return path, tree, check_case(tree, path)


def engine(changes, versions, say, folder):
    """Return the results of the numerical example and its engine FMUs.

    Parameters
    ----------
    changes : list of (key, value)
        Of the case.
    versions : iterable of str
        Of the standard.
    say : callable
        Called with a line of text before long work.
    folder : Path
        For the run's results.

    Returns
    -------
    reference : ndarray, shape (steps + 1, 1 + outputs)
        Time [s] and the watched outputs.
    fmus : dict of str to Path
        By version.
    step : float
        Of the case [s].
    """
    path, _, case = _shipped(changes)
    reference = shipped_run(changes, say, folder / "run.h5")
    fmus = {version: export_fmu(case, path.parent, say, version) for version in versions}
    return reference, fmus, float(reference[1, 0])


def native_engine(changes, versions, say):
    """Its engine FMUs without Python, by version; none where they cannot be built.

    Parameters
    ----------
    changes, versions, say
        As in `engine`.

    Returns
    -------
    dict of str to Path
    """
    lacking = too_old() if compiler() else ["a C compiler is needed, for Linux on x86-64"]
    if lacking:
        say(f"native FMUs are not tested: {'; '.join(lacking)}")
        return {}
    path, _, case = _shipped(changes)
    return {
        version: export_fmu(case, path.parent, say, version, ("linux64",)) for version in versions
    }


def shipped_run(changes, say, file):
    """Return the results of the numerical example.

    Parameters
    ----------
    changes : list of (key, value)
        Of the case.
    say : callable
        Called with a line of text before long work.
    file : Path
        For the run's results.

    Returns
    -------
    ndarray, shape (steps + 1, 1 + outputs)
        Time [s] and the watched outputs.
    """
    path, tree, case = _shipped(changes)
    system = open_system(case, path.parent, say)
    say(f"reference run with steps of {system.step:.12g} s")
    run(system, case, tree, file)
    results = Results(file).whole
    ports = [
        f"{owner}.{name}"
        for name in WATCHED
        for owner, one in system.participants.items()
        if name in one.fields
    ]
    columns = [results.series(port).values for port in ports]
    times = system.step * np.arange(len(columns[0]))
    return np.array([times, *columns]).T


def in_whole_ticks(changes, step, tick):
    """Return the case with steps that are whole ticks of a clock.

    Parameters
    ----------
    changes : list of (key, value)
        Of the case.
    step, tick : float
        Of the case, and of the clock [s].

    Returns
    -------
    changes : list of (key, value)
        With as many steps, each a whole number of ticks: of 27.7778 us and 1 ns, 27.778 us.
    step : float
        Their length [s].
    """
    time = _shipped(changes)[-1].time
    ticked = tick * round(step / tick)
    longer = [
        (f"time.{key}", f"{to_si(getattr(time, key), 'rad') * ticked / step!r} rad")
        for key in ("step", "stop")
    ]
    # a period is no whole number of these steps
    return [*changes, *longer, ("time.until_periodic", 0)], ticked


def verify_importers(console, say, changes=()):
    """Print how far every importer is from `run` on the shipped case; returns how many failed."""
    pythons = [sys.executable, *filter(None, os.environ.get("PISTON_COSIM_PYTHONS", "").split(":"))]
    failed = 0
    table = Table("", "FMI", "importer", "version", "Python", "distance from run", box=None)
    with tempfile.TemporaryDirectory() as scratch:
        versions = ("2.0", "3.0") if compiler() else ("2.0",)
        changes = [("time.stop", "720 deg"), *changes]
        reference, fmus, step = engine(changes, versions, say, Path(scratch))
        count = len(reference) - 1

        @cache
        def held_against(tick):
            if not tick:
                return reference
            ticked, _ = in_whole_ticks(changes, step, tick)
            return shipped_run(ticked, say, Path(scratch) / "ticked.h5")

        forms = [(fmi, fmi, fmu) for fmi, fmu in fmus.items()]
        without = native_engine(changes, versions, say)
        forms += [(f"{fmi} native", fmi, fmu) for fmi, fmu in without.items()]
        for form, fmi, fmu in forms:
            for trial in try_importers(fmu, fmi, count, step, pythons):
                say(f"FMI {form}: {trial.importer}")
                verdict, said = judged(trial, held_against(trial.tick))
                failed += verdict == "FAIL"
                table.add_row(verdict, form, trial.importer, trial.version, trial.python, said)
    for name, source in ELSEWHERE.items():
        table.add_row("-", "", name, "-", "-", f"{NOT_INSTALLED}: {source}")
    console.print(table)
    console.print(
        f"{failed} failed. The distance is the largest of {', '.join(WATCHED)} over their ranges, "
        f"row 0 included. It must not exceed {ALLOWED:g}."
    )
    return failed
