"""Run engine.ssp by libcosim (pip install libcosimpy).

python by_libcosim.py engine.ssp STEPS
"""

import re
import sys
import tempfile
import zipfile
from pathlib import Path

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

STEP = 25_000  # ns


def components_only(ssp, folder):
    """Copy an SSP without connections to the system's own connectors, which libcosim rejects."""
    system_end = rb'<ssd:Connection (?![^>]*Element="[^>]*Element=")[^>]*/>'
    path = Path(folder) / "engine.ssp"
    with zipfile.ZipFile(ssp) as source, zipfile.ZipFile(path, "w") as copy:
        for name in source.namelist():
            copy.writestr(name, re.sub(system_end, b"", source.read(name)))
    return path


def simulate(ssp, steps):
    """Return crank speed [rad/s], lateral displacement [m] and friction power [W] at the end."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(components_only(ssp, folder))
        execution = CosimExecution.from_ssp_file(ssp_path=path, step_size=STEP)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    execution.step(step_count=steps)

    def get(part, name):
        index = execution.slave_index_from_instance_name(part)
        reference = {v.name.decode(): v.reference for v in execution.slave_variables(index)}[name]
        return observer.last_real_values(index, [reference])[0]

    return (
        get("crankshaft", "crank_speed"),
        get("piston", "lateral_displacement"),
        get("piston", "friction_power"),
    )


if __name__ == "__main__":
    print(*simulate(sys.argv[1], int(sys.argv[2])))
