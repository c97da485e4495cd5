"""Try a release wheel in an empty home without a compiler: run the main job, export a native FMU.

    python .ci/try_wheel.py dist/piston_cosim-*.whl

The main job is that of the README, with its pictures. Both start with an empty cache. The script
fails if one needs more than `ALLOWED`, and after any reduction of a body or compilation.
"""

import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ALLOWED = {"main job": 25.0, "native FMU": 20.0}
"""Processor time [s]. It is the longest wall time on an idle machine."""


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
        costs = {"main job": run(folder, command, "run", "numerical_example")}
        cache = folder / "home/.cache/piston-cosim"
        if reduced := [path.name for path in (cache / "bodies").iterdir()]:
            raise SystemExit(f"main job: expected no reduction of a body, got {', '.join(reduced)}")
        if compiled := [path.name for path in folder.rglob("*.nbc")]:
            raise SystemExit(f"main job: expected no compilation, got {', '.join(compiled)}")
        shutil.rmtree(cache)
        output = folder / "engine.fmu"
        costs["native FMU"] = run(
            folder, command, "fmu", "export", "numerical_example", "--native", "--output", output
        )
        print(f"{output.name}: {output.stat().st_size / 1e6:.1f} MB")
        for name, cost in costs.items():
            print(f"{name}: {cost:.1f} s of processor time")
            if cost > ALLOWED[name]:
                raise SystemExit(
                    f"{name}: expected at most {ALLOWED[name]:.0f} s, got {cost:.1f} s"
                )


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
