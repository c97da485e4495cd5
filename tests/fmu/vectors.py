"""Three bent lags with inputs of three, of c_models/dahlquist.c, in a loop with a gain."""

import subprocess
import zipfile
from pathlib import Path

from piston_cosim.master.fmi.compiler import compiler

from .test_foreign_fmus import DAHLQUIST, FEEDTHROUGH, MODELS

BEND, GAIN = 0.1, 0.5
SERIALISED = DAHLQUIST.replace(
    'canGetAndSetFMUstate="true"', 'canGetAndSetFMUstate="true" canSerializeFMUstate="true"'
)
CASE = """
title = "Bent lags"
[time]
stop = "{stop} s"
step = "0.1 s"
[participants.bent]
fmu = "bent.fmu"
{more}
[participants.gain]
fmu = "gain.fmu"
[participants.gain.parameters]
gain = 0.5
[[wires]]
from = "bent.x"
to = "gain.array_input"
[[wires]]
from = "gain.array_output"
to = "bent.u"
tolerance = 1e-10
[coupling]
method = "newton"
order = ["bent", "gain"]
[record]
fields = ["bent.x"]
"""


def make(folder: Path, wait=0):
    """Both FMUs in a folder; a step of the lags waits so many microseconds."""
    flags = ["-O1", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    own = ["-DSERIALISES", f"-DBEND={BEND}", f"-DWAIT={wait}"]
    for name, source, text, place in (
        ("bent", "dahlquist", SERIALISED, "linux64"),
        ("gain", "feedthrough", FEEDTHROUGH, "x86_64-linux"),
    ):
        library = folder / f"{source}.so"
        more = own if name == "bent" else []
        command = [str(compiler()), *flags, *more, str(MODELS / f"{source}.c"), "-o", str(library)]
        subprocess.run(command, check=True)
        with zipfile.ZipFile(folder / f"{name}.fmu", "w") as target:
            target.writestr("modelDescription.xml", text)
            target.write(library, f"binaries/{place}/{source}.so")
