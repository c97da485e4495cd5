"""Runs of the command line, in the process of the tests and in a separate one.

In the process of the tests, a run saves the second that a new Python takes to start.
"""

import contextlib
import io
import subprocess
import sys
from unittest import mock

from piston_cosim.master.commands.app import main


def call(*words, folder="."):
    """Return exit code and output of `piston-cosim WORDS` in a folder."""
    words = [str(word) for word in words]
    out, errors = io.StringIO(), io.StringIO()
    code = 0
    with (
        mock.patch.object(sys, "argv", ["piston-cosim", *words]),
        contextlib.chdir(folder),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(errors),
    ):
        try:
            main()
        except SystemExit as ended:
            code = ended.code
    return subprocess.CompletedProcess(words, code, out.getvalue(), errors.getvalue())


def script(code, *words, **settings):
    """Return what code prints in a Python of its own, whose arguments are the words."""
    command = [sys.executable, "-c", code, *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, **settings)
    assert done.returncode == 0, done.stderr
    return done.stdout


def begun(folder, *words, **settings):
    """Start `piston-cosim WORDS` in a folder as a process of its own."""
    settings = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True} | settings
    command = [sys.executable, "-m", "piston_cosim", *map(str, words)]
    return subprocess.Popen(command, cwd=folder, **settings)


def ended(process, code=0, seconds=300):
    """Wait for a process and check its exit code; return its output and its errors."""
    out, errors = process.communicate(timeout=seconds)
    assert process.returncode == code, out + errors
    return out, errors
