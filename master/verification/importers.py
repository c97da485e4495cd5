"""Independent importers tried on FMUs, each in a process of its own: who, which version, what was
seen.

`piston-cosim verify importers` tries them on the body FMU and on the coupled FMU of the numerical
example. Further interpreters are named by PISTON_COSIM_PYTHONS, separated by colons: their version
of Python runs the FMUs too, and so do the importers installed there.
"""

import os
import subprocess
import sys

STEPS = 5
STEP = 2.5e-5  # [s]

MARK = "seen: "
COMMON = (
    "import sys\nfmu, folder, steps, step, output = sys.argv[1:6]\n"
    "steps, step = int(steps), float(step)\n"
    "def seen(what):\n    print('" + MARK + "' + str(what), flush=True)\n"
)

SCRIPTS = {
    "fmpy in process": (
        "fmpy",
        """
import fmpy
times = {"stop_time": steps * step, "output_interval": step, "step_size": step}
r = fmpy.simulate_fmu(fmu, **times, output=[output])
seen(float(r[output][-1]))""",
    ),
    "fmpy validate": (
        "fmpy",
        """
from fmpy.validation import validate_fmu
problems = validate_fmu(fmu)
seen(problems or "no problem")""",
    ),
    "libcosim": (
        "libcosimpy",
        """
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
execution = CosimExecution.from_step_size(step_size=round(step * 1e9))
index = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="one"))
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
assert execution.step(step_count=steps)
reference = {v.name.decode(): v.reference for v in execution.slave_variables(index)}[output]
seen(observer.last_real_values(index, [reference])[0])""",
    ),
    "Ecos": (
        "ecospy",
        """
from ecospy import EcosSimulation, EcosSimulationStructure
structure = EcosSimulationStructure()
structure.add_model("one", fmu)
with EcosSimulation(structure=structure, step_size=step) as simulation:
    simulation.init()
    simulation.step(steps)
    seen(simulation.get_real("one::" + output))""",
    ),
    "fmpy simulate": (
        "fmpy",
        """
import csv, subprocess, tempfile
from pathlib import Path
table = Path(tempfile.mkdtemp()) / "out.csv"
words = ["simulate", fmu, "--stop-time", str(steps * step), "--output-interval", str(step),
         "--output-variables", output, "--output-file", str(table)]
done = subprocess.run([sys.executable, "-m", "fmpy", *words], capture_output=True, text=True)
assert done.returncode == 0, done.stderr
*_, last = csv.reader(table.read_text().splitlines())
seen(float(last[1]))""",
    ),
    "fmuloader": (
        "fmuloader",
        """
from pathlib import Path
from xml.etree import ElementTree
from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
root = ElementTree.parse(Path(folder) / "modelDescription.xml").getroot()
variable = next(v for v in root.iter("ScalarVariable") if v.get("name") == output)
reference = int(variable.get("valueReference"))
one = Fmi2Slave(fmu, model_identifier=root.find("CoSimulation").get("modelIdentifier"))
one.instantiate("one", Fmi2Type.CO_SIMULATION, guid=root.get("guid"))
one.setup_experiment(start_time=0.0)
one.enter_initialization_mode()
one.exit_initialization_mode()
for k in range(steps):
    one.do_step(k * step, step)
seen(one.get_real([reference])[0])
one.terminate()
one.free_instance()""",
    ),
    "OMSimulator": (
        "OMSimulator",
        """
from OMSimulator import OMSimulator
oms = OMSimulator()
made = (oms.newModel("m"), oms.addSystem("m.s", oms.system_wc), oms.addSubModel("m.s.one", fmu))
for status in made:
    assert status == 0, status
oms.setStopTime("m", steps * step)
oms.setFixedStepSize("m.s", step)
for status in (oms.instantiate("m"), oms.initialize("m"), oms.simulate("m")):
    assert status == 0, status
seen(oms.getReal("m.s.one." + output)[0])""",
    ),
    "PyFMI": (
        "PyFMI",
        """
from pyfmi import load_fmu
one = load_fmu(fmu)
one.setup_experiment()
one.initialize()
for k in range(steps):
    assert one.do_step(k * step, step) == 0
seen(float(one.get(output)[0]))""",
    ),
    "fmu-manipulation-toolbox": (
        "fmu_manipulation_toolbox",
        """
import subprocess
from pathlib import Path
tool = str(Path(sys.executable).parent / "fmutool")
done = subprocess.run([tool, "-input", fmu, "-check"], capture_output=True, text=True)
words = done.stdout + done.stderr
bad = [line for line in words.splitlines() if line.startswith(("ERROR", "WARNING"))]
seen(bad or "no problem")""",
    ),
    "Python alone (ctypes)": (
        None,
        """
import ctypes, urllib.parse
from pathlib import Path
from xml.etree import ElementTree
root = ElementTree.parse(Path(folder) / "modelDescription.xml").getroot()
name = root.find("CoSimulation").get("modelIdentifier")
guid = root.get("guid").encode()
variable = next(v for v in root.iter("ScalarVariable") if v.get("name") == output)
reference = int(variable.get("valueReference"))
said = []
text = ctypes.c_char_p
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, text, ctypes.c_int, text, text)
logger = LOGGER(lambda *arguments: said.append(arguments[-1].decode()))
callbacks = (ctypes.c_void_p * 5)(ctypes.cast(logger, ctypes.c_void_p).value)
library = ctypes.CDLL(str(Path(folder) / "binaries" / "linux64" / (name + ".so")))
library.fmi2Instantiate.restype = ctypes.c_void_p
location = "file://" + urllib.parse.quote(str(Path(folder) / "resources"))
one = ctypes.c_void_p(library.fmi2Instantiate(b"one", 1, guid, location.encode(), callbacks, 0, 0))
if not one:
    seen("refused: " + "; ".join(said))
    sys.exit()
d = ctypes.c_double
calls = [library.fmi2SetupExperiment(one, 0, d(0), d(0), 0, d(0)),
         library.fmi2EnterInitializationMode(one), library.fmi2ExitInitializationMode(one)]
calls += [library.fmi2DoStep(one, d(k * step), d(step), 0) for k in range(steps)]
value = d()
references = (ctypes.c_uint * 1)(reference)
calls.append(library.fmi2GetReal(one, references, ctypes.c_size_t(1), ctypes.byref(value)))
assert not any(calls), (calls, said)
library.fmi2FreeInstance(one)
seen(value.value)""",
    ),
}


REFERENCE = "Python alone (ctypes)"
# relative; importers that count time in whole nanoseconds differ in the last bits of the time
ROUNDING = 1e-10
NOT_INSTALLED = "not installed"


def try_importers(fmu, output, pythons=(sys.executable,)):
    """What each importer saw.

    Parameters
    ----------
    fmu : Path
        FMI 2.0 FMU for co-simulation.
    output : str
        Real output to read after the last step.
    pythons : iterable of path
        Interpreters; each importer is tried in the ones it is installed in, and named once if it is
        in none.

    Yields
    ------
    tuple of str
        Importer, its version, Python's version, what was seen.
    """
    from ..participants.fmi2 import unpack

    folder = unpack(fmu)
    absent = dict.fromkeys(SCRIPTS)
    for python in pythons:
        version = _ask(python, "import platform; print(platform.python_version())")
        for importer, (package, script) in SCRIPTS.items():
            known = (
                _ask(python, f"import importlib.metadata as m; print(m.version({package!r}))")
                if package
                else "-"
            )
            if not known.startswith(FAILED):
                absent.pop(importer, None)
                yield (
                    importer,
                    known,
                    version,
                    _ask(python, COMMON + script, fmu, folder, STEPS, STEP, output),
                )
    for importer in absent:
        yield importer, "-", "-", NOT_INSTALLED


FAILED = "failed"


def _ask(python, script, *arguments):
    """What the script says it saw, else the last line printed; "failed" with the last line of the
    error.
    """
    done = subprocess.run(
        [str(python), "-c", script, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=600,
        cwd="/",
    )
    if done.returncode:
        return f"{FAILED} ({done.returncode}): {(done.stderr.strip().splitlines() or [''])[-1]}"
    lines = done.stdout.strip().splitlines() or ["nothing"]
    return next((line.removeprefix(MARK) for line in lines if line.startswith(MARK)), lines[-1])


def judged(rows):
    """Each row with its verdict: what Python alone sees every importer must see; checkers, no
    problem.

    Parameters
    ----------
    rows : iterable of tuple of str
        From `try_importers`, of one FMU.

    Returns
    -------
    list of tuple
        Verdict, then the row: "ok", "FAIL", or "-" where the importer is not installed, or the FMU
        says what its Python lacks.
    """
    rows = list(rows)
    reference = next(
        float(seen)
        for importer, _, _, seen in rows
        if importer == REFERENCE and not seen.startswith(FAILED)
    )

    def verdict(seen):
        if seen == NOT_INSTALLED or "-m pip install" in seen:
            return "-"
        try:
            return "ok" if abs(float(seen) - reference) <= ROUNDING * abs(reference) else "FAIL"
        except ValueError:
            return "ok" if seen == "no problem" else "FAIL"

    return [(verdict(row[-1]), *row) for row in rows]


def shipped(say):
    """The FMUs that other tools load, small: (title, path, output to look at)."""
    from ..case.export import export_fmu
    from ..case.schema import check_case, find_case, read_tree
    from ..case.system import open_system

    path = find_case("numerical_example")
    small = [
        ("participants.bodies.build.grid", [12, 10]),
        ("participants.ehd.build.grid", [12, 10]),
        ("participants.bodies.build.piston.modes", 0),
        ("participants.bodies.build.block.modes", 0),
    ]
    case = check_case(read_tree(path, small), path)
    bodies = open_system(case, path.parent, say).participants["bodies"].path
    return [
        ("body FMU", bodies, "lateral_displacement"),
        ("coupled FMU", export_fmu(case, path.parent, say), "lateral_displacement"),
    ]


def verify_importers(console, say):
    """Print what every importer sees of the shipped FMUs; returns how many failed."""
    from rich.table import Table

    pythons = [sys.executable, *filter(None, os.environ.get("PISTON_COSIM_PYTHONS", "").split(":"))]
    failed = 0
    seen_after = f"seen after {STEPS} steps"
    table = Table("", "FMU", "importer", "version", "Python", seen_after, box=None)
    for title, fmu, output in shipped(say):
        for verdict, *row in judged(try_importers(fmu, output, pythons)):
            failed += verdict == "FAIL"
            table.add_row(verdict, f"{title}, {output}", *row)
    console.print(table)
    console.print(f"{failed} failed")
    return failed
