"""`piston-cosim bench`."""

import subprocess
import sys
from pathlib import Path

from ..fmi.errors import BadInput
from .common import console


def command(*names: str):
    """Run the benchmarks of a source checkout: ratios measured side by side, one thread.

    Example: piston-cosim bench mfbd_step

    Parameters
    ----------
    names
        Scripts in tests/bench without their ending; all of them by default.
    """
    folder = Path(__file__).resolve().parents[2] / "tests" / "bench"
    known = sorted(path.stem for path in folder.glob("*.py"))
    unknown = [name for name in names if name not in known]
    if unknown or not known:
        raise BadInput(f"no benchmark {', '.join(unknown)}: there are {', '.join(known)}" if known else
                       "benchmarks are in the source checkout, not in the installed package")
    for name in names or known:
        console.print(f"[bold]{name}[/]")
        subprocess.run([sys.executable, str(folder / f"{name}.py")], check=True)
