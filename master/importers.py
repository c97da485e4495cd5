"""Independent importers tried on an FMU, each in a process of its own: who, which version, what was seen.

    python -m master.importers X.fmu OUTPUT [PYTHON ...]

OUTPUT is the Real output to compare; PYTHON are further interpreters: their version runs the FMU too, and so do the
importers installed there.
"""

import subprocess
import sys
from pathlib import Path

STEPS, STEP = 5, 2.5e-5

MARK = "seen: "
COMMON = "import sys\nfmu, folder, steps, step, output = sys.argv[1:6]\nsteps, step = int(steps), float(step)\n" \
         "def seen(what):\n    print('" + MARK + "' + str(what), flush=True)\n"

SCRIPTS = {
    "fmpy in process": ("fmpy", """
import fmpy
r = fmpy.simulate_fmu(fmu, stop_time=steps * step, output_interval=step, step_size=step, output=[output])
seen(float(r[output][-1]))"""),
    "fmpy validate": ("fmpy", """
from fmpy.validation import validate_fmu
found = validate_fmu(fmu)
seen(found or "no problem")"""),
    "libcosim": ("libcosimpy", """
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
execution = CosimExecution.from_step_size(step_size=round(step * 1e9))
index = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="one"))
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
assert execution.step(step_count=steps)
reference = {v.name.decode(): v.reference for v in execution.slave_variables(index)}[output]
seen(observer.last_real_values(index, [reference])[0])"""),
    "Ecos": ("ecospy", """
from ecospy import EcosSimulation, EcosSimulationStructure
structure = EcosSimulationStructure()
structure.add_model("one", fmu)
with EcosSimulation(structure=structure, step_size=step) as simulation:
    simulation.init()
    simulation.step(steps)
    seen(simulation.get_real("one::" + output))"""),
    "fmu-manipulation-toolbox": ("fmu_manipulation_toolbox", """
import subprocess
from pathlib import Path
done = subprocess.run([str(Path(sys.executable).parent / "fmutool"), "-input", fmu, "-check"], capture_output=True, text=True)
words = done.stdout + done.stderr
bad = [line for line in words.splitlines() if line.startswith(("ERROR", "WARNING"))]
seen(bad or "no problem")"""),
    "Python alone (ctypes)": (None, """
import ctypes, urllib.parse
from pathlib import Path
from xml.etree import ElementTree
root = ElementTree.parse(Path(folder) / "modelDescription.xml").getroot()
name = root.find("CoSimulation").get("modelIdentifier")
reference = int(next(v for v in root.iter("ScalarVariable") if v.get("name") == output).get("valueReference"))
said = []
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
logger = LOGGER(lambda environment, instance, status, category, message: said.append(message.decode()))
callbacks = (ctypes.c_void_p * 5)(ctypes.cast(logger, ctypes.c_void_p).value)
library = ctypes.CDLL(str(Path(folder) / "binaries" / "linux64" / (name + ".so")))
library.fmi2Instantiate.restype = ctypes.c_void_p
location = "file://" + urllib.parse.quote(str(Path(folder) / "resources"))
one = ctypes.c_void_p(library.fmi2Instantiate(b"one", 1, b"", location.encode(), callbacks, 0, 0))
if not one:
    seen("refused: " + "; ".join(said))
    sys.exit()
d = ctypes.c_double
calls = [library.fmi2SetupExperiment(one, 0, d(0), d(0), 0, d(0)), library.fmi2EnterInitializationMode(one),
         library.fmi2ExitInitializationMode(one)]
calls += [library.fmi2DoStep(one, d(k * step), d(step), 0) for k in range(steps)]
value = d()
calls.append(library.fmi2GetReal(one, (ctypes.c_uint * 1)(reference), ctypes.c_size_t(1), ctypes.byref(value)))
assert not any(calls), (calls, said)
library.fmi2FreeInstance(one)
seen(value.value)"""),
}


def try_importers(fmu, output, pythons=(sys.executable,)):
    """What each importer saw.

    Parameters
    ----------
    fmu : Path
        FMI 2.0 FMU for co-simulation.
    output : str
        Real output to read after the last step.
    pythons : iterable of path
        Interpreters; each importer is tried in the ones it is installed in.

    Yields
    ------
    tuple of str
        Importer, its version, Python's version, what was seen.
    """
    from .participant import unpack

    folder = unpack(fmu)
    for python in pythons:
        version = _ask(python, "import platform; print(platform.python_version())")
        for importer, (package, script) in SCRIPTS.items():
            known = _ask(python, f"import importlib.metadata as m; print(m.version({package!r}))") if package else "-"
            if not known.startswith("failed"):
                yield importer, known, version, _ask(python, COMMON + script, fmu, folder, STEPS, STEP, output)


def _ask(python, script, *arguments):
    """What the script says it saw, else the last line printed; "failed" with the last line of the error."""
    done = subprocess.run([str(python), "-c", script, *map(str, arguments)], capture_output=True, text=True, timeout=600, cwd="/")
    if done.returncode:
        return f"failed ({done.returncode}): {(done.stderr.strip().splitlines() or [''])[-1]}"
    lines = done.stdout.strip().splitlines() or ["nothing"]
    return next((line.removeprefix(MARK) for line in lines if line.startswith(MARK)), lines[-1])


def main():
    """Print the table for an FMU."""
    from rich.console import Console
    from rich.table import Table

    path, output, *pythons = sys.argv[1:]
    table = Table("importer", "version", "Python", f"seen ({output} after {STEPS} steps)", box=None)
    for row in try_importers(Path(path).resolve(), output, (sys.executable, *pythons)):
        table.add_row(*row)
    Console(width=160).print(table)


if __name__ == "__main__":
    main()
