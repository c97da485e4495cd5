"""`piston-cosim results snapshot`."""

import json
from pathlib import Path

import numpy as np

from ...fmi.errors import BadInput, unknown
from ...results.file import open_results
from ...results.instants import instant, instant_text
from ..common import Moment, OutputFile, print_line


def command(file: Path, /, *, participant: str, output: OutputFile, time: Moment | None = None):
    """Write the state of a participant at one instant.

    Another run starts from that state if its case sets `start = "start.json"` in the table
    `participants.bodies.build`.

    Example: piston-cosim results snapshot results/fired_motorcycle/flexible.h5 --participant bodies
    --output models/mine/start.json

    Parameters
    ----------
    file
        Results file.
    participant
        Name of the participant in the case.
    output
        JSON file of outputs by name, in SI units.
    time
        Recorded instant nearest to a time, a crank angle or an extreme, e.g. "18 ms",
        "24 deg" or "max ehd.maximum_pressure". Default: the last instant with fields.
    """
    results = open_results(file)
    if participant not in results.case["participants"]:
        known = results.case["participants"]
        raise BadInput(f"--participant: {unknown('participant', participant, known)}")
    instants = results.instants
    if not len(instants):
        instants = results.time
    k = len(instants) - 1
    if time is not None:
        k = int(np.argmin(np.abs(instants - instant(results, time))))
    row = int(np.argmin(np.abs(results.time - instants[k])))
    values = {
        name: results.series(f"{participant}.{name}").values[row : row + 1].tolist()[0]
        for name in results.file[participant]
    }
    if participant in results.file["fields"]:
        values |= {
            name: results.dataset(f"{participant}.{name}")[k].tolist()
            for name in results.file["fields"][participant]
        }
    output.write_text(json.dumps(values, indent=1))
    print_line(f"snapshot {output}   t = {instant_text(results, instants[k])}")
