"""Run engine.ssp by FMPy's functions with explicit coupling.

python by_fmpy.py engine.ssp STEPS
"""

import sys
import tempfile
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
from fmpy import fmi2

SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
STEP = 25e-6


def simulate(ssp, steps):
    """Return crank speed [rad/s], lateral displacement [m] and friction power [W] at the end."""
    with tempfile.TemporaryDirectory() as folder:
        zipfile.ZipFile(ssp).extractall(folder)
        system = ElementTree.parse(Path(folder) / "SystemStructure.ssd").getroot()
        parts = {
            c.get("name"): _start(Path(folder) / c.get("source"))
            for c in system.iter(SSD + "Component")
        }
        wires = [
            [c.get(end) for end in ("startElement", "startConnector", "endElement", "endConnector")]
            for c in system.iter(SSD + "Connection")
            if c.get("startElement") and c.get("endElement")  # else a connector of the system
        ]
        for k in range(steps):
            values = [_get(parts[source], output) for source, output, _, _ in wires]
            for value, (_, _, target, name) in zip(values, wires):
                parts[target][0].setReal([parts[target][1][name]], [value])
            for fmu, _ in parts.values():
                fmu.doStep(k * STEP, STEP)
        results = (
            _get(parts["crankshaft"], "crank_speed"),
            _get(parts["piston"], "lateral_displacement"),
            _get(parts["piston"], "friction_power"),
        )
        for fmu, _ in parts.values():
            fmu.terminate()
            fmu.freeInstance()
        return results


def _start(path):
    """Return the initialised FMU with its start values, and references by name."""
    description = fmpy.read_model_description(str(path))
    fmu = fmi2.FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(path), unzipdir=str(path.with_suffix(""))),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName=path.stem,
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu, {v.name: v.valueReference for v in description.modelVariables}


def _get(part, name):
    return part[0].getReal([part[1][name]])[0]


if __name__ == "__main__":
    print(*simulate(sys.argv[1], int(sys.argv[2])))
