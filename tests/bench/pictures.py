"""Print the bytes of every kind of picture in every format, and the time of a movie of 90 frames.

Run: python tests/bench/pictures.py (about a minute on a quiet machine)
"""

import shutil
import sys
import tempfile
from contextlib import chdir
from pathlib import Path
from time import perf_counter

from piston_cosim.master.case.reading import find_case
from piston_cosim.master.commands.app import main

FORMATS = ("png", "svg", "pdf")
LARGEST = 200_000  # bytes of a vector file
STUDY = """
[studies.step]
title = "Macro step"
reference = "1 deg"
x = "bodies.crank_angle"
curves = ["bodies.lateral_displacement", "bodies.side_force"]
[studies.step.points]
"4 deg" = { "time.step" = "4 deg" }
"1 deg" = { "time.step" = "1 deg" }
"""
MEASURED = "bodies.crank_angle [deg],bodies.side_force [kN]\n-90,0.2\n10,1.2\n20,1.8\n90,2\n"


def call(*words):
    """Call the command line, without its output."""
    sys.argv = ["piston-cosim", *words]
    try:
        main()
    except SystemExit as ended:
        if ended.code:
            raise


def pictures():
    """Draw pictures of runs in the present folder."""
    runs = [f"results/numerical_example/{name}.h5" for name in ("flexible", "rigid")]
    call("run", "numerical_example")
    call("run", "data_sheet", "--set", "time.step=2 deg")
    shutil.copytree(find_case("data_sheet").parent, "sheet")
    with open("sheet/case.toml", "a") as file:
        file.write(STUDY)
    Path("measured.csv").write_text(MEASURED)
    for kind in FORMATS:
        call("results", "plot", *runs, "--format", kind, "--output", "plot")
        call("results", "plot", *runs, "--format", kind, "--output", "paper", "--paper")
        sheet = "results/data_sheet/rigid.h5"
        compared = ("--measured", "measured.csv", "--output", f"compare/measured.{kind}")
        call("results", "compare", sheet, *compared)
        call("check", "numerical_example", "--picture", f"check/check.{kind}")
        call("study", "sheet", "step", "--output", "study", "--format", kind)
        gaps = ("--vary", "radial_clearance=30um..60um:3", "--vary", "barrel=20um;40um")
        call("sweep", "data_sheet", *gaps, "--output", "sweep", "--format", kind)
    for kind in ("gif", "glb", "pvd"):
        begin = perf_counter()
        call("results", "movie", runs[0], "--output", f"movie/movie.{kind}")
        print(f"movie.{kind} of 90 frames: {perf_counter() - begin:.1f} s")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        pictures()
        drawn = sorted(
            file
            for name in ("plot", "paper", "compare", "check", "study", "sweep", "movie")
            for file in Path(name).iterdir()
            if file.suffix[1:] in (*FORMATS, "gif", "glb")
        )
        for file in drawn:
            print(f"{file!s:32} {file.stat().st_size:9,} bytes")
        large = [
            str(file)
            for file in drawn
            if file.suffix in (".svg", ".pdf") and file.stat().st_size > LARGEST
        ]
        sys.exit(f"larger than {LARGEST:,} bytes: {', '.join(large)}" if large else 0)
