"""FMUs of the C models beside: compiled, and packed with a description."""

import subprocess
import zipfile
from pathlib import Path

import pytest

from piston_cosim.master.fmi.compiler import compiler

MODELS = Path(__file__).parent / "c_models"
FLAGS = ("-O1", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC")


def compile_model(source, library, *flags):
    """A shared library of a C source; who has no compiler skips the test."""
    if not compiler():
        pytest.skip("no C compiler")
    subprocess.run([compiler(), *FLAGS, *flags, source, "-o", library, "-lm"], check=True)


def pack(fmu, description, library, place):
    """An FMU: its description, and its library for a platform as the standard names it."""
    with zipfile.ZipFile(fmu, "w") as target:
        target.writestr("modelDescription.xml", description)
        target.write(library, f"binaries/{place}/{Path(library).name}")
