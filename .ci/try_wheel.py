"""Try a release wheel in an empty home without a compiler: run the main job, export a native FMU.

    python .ci/try_wheel.py dist/piston_cosim-*.whl

The export starts with an empty cache. It fails above `ALLOWED`, and after any reduction of a body
or compilation.
"""

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ALLOWED = 20.0  # processor time of the export [s]


def processor_time():
    """Return the processor time of all finished child processes [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(folder, *command):
    """Run a command with the environment of a new user and return its processor time [s]."""
    before = processor_time()
    environment = {"HOME": str(folder / "home"), "PATH": str(folder / "venv/bin")}
    subprocess.run(command, cwd=folder, env=environment, check=True)
    return processor_time() - before


def main(wheel):
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "home").mkdir()
        subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
        subprocess.run([folder / "venv/bin/pip", "install", "-q", wheel], check=True)
        command = folder / "venv/bin/piston-cosim"
        job = run(folder, command, "run", "numerical_example", "--no-plots")
        cache = folder / "home/.cache/piston-cosim"
        if reduced := [path.name for path in (cache / "bodies").iterdir()]:
            raise SystemExit(f"main job: expected no reduction of a body, got {', '.join(reduced)}")
        if compiled := [path.name for path in folder.rglob("*.nbc")]:
            raise SystemExit(f"main job: expected no compilation, got {', '.join(compiled)}")
        shutil.rmtree(cache)
        output = folder / "engine.fmu"
        export = run(
            folder, command, "fmu", "export", "numerical_example", "--native", "--output", output
        )
        print(f"main job: {job:.1f} s of processor time")
        print(
            f"native FMU: {export:.1f} s of processor time, {os.path.getsize(output) / 1e6:.1f} MB"
        )
        if export > ALLOWED:
            raise SystemExit(f"native FMU: expected at most {ALLOWED:.0f} s, got {export:.1f} s")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
