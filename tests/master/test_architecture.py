"""The three packages never import each other; kernels know no FMI."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
OUTER = {"slave.py", "variables.py", "build.py", "options.py", "verification.py", "offline.py"}


def test_import_contracts_hold():
    run = subprocess.run([sys.executable, "-c", "from importlinter.cli import lint_imports_command; lint_imports_command()"],
                         cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.parametrize("package", ["fmu_ehd", "fmu_mfbd"])
def test_kernels_know_no_fmi(package):
    guilty = []
    for path in (ROOT / package).rglob("*.py"):
        if path.name in OUTER:
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else \
                [node.module or ""] if isinstance(node, ast.ImportFrom) and node.level == 0 else []
            guilty += [f"{path.name}: {n}" for n in names if n.split(".")[0] in ("master", "pythonfmu", "fmpy")]
    assert guilty == []
