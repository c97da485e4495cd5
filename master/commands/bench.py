"""`piston-cosim bench`."""

import subprocess
import sys
from pathlib import Path

from ..fmi.errors import BadInput, unknown
from .common import console


def command(*names: str):
    """Run the benchmarks of a source checkout.

    Example: piston-cosim bench ehd_step

    Parameters
    ----------
    names
        Scripts in tests/bench without their suffix. Default: all except the folder slow.
    """
    folder = Path(__file__).resolve().parents[2] / "tests" / "bench"
    known = {path.stem: path for path in sorted(folder.rglob("*.py"))}
    strange = [name for name in names if name not in known]
    if strange or not known:
        raise BadInput(
            [f"NAMES: {unknown('benchmark', name, known)}" for name in strange]
            if known
            else "bench: expected a source checkout, got an installed package"
        )
    for name in names or [name for name, path in known.items() if path.parent == folder]:
        console.print(f"[bold]{name}[/]")
        if subprocess.run([sys.executable, str(known[name])]).returncode:
            sys.exit(1)
