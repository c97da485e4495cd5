"""The command line in the process of the tests, without the second that a new Python takes."""

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
