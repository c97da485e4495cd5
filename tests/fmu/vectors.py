"""Three bent lags with inputs of three, of c_models/dahlquist.c, in a loop with a gain."""

from pathlib import Path

from .c_fmus import MODELS, compile_model, pack
from .test_foreign_fmus import DAHLQUIST, FEEDTHROUGH

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
    own = ["-DSERIALISES", f"-DBEND={BEND}", f"-DWAIT={wait}"]
    for name, source, text, place in (
        ("bent", "dahlquist", SERIALISED, "linux64"),
        ("gain", "feedthrough", FEEDTHROUGH, "x86_64-linux"),
    ):
        library = folder / f"{source}.so"
        more = own if name == "bent" else []
        compile_model(MODELS / f"{source}.c", library, *more)
        pack(folder / f"{name}.fmu", text, library, place)
