"""Every command of every page runs: quick ones as typed, slow ones with `-m slow`.

Runs, sweeps and studies end after two steps. A command that no list contains fails.
"""

import re
import shlex
import shutil
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.commands.app import COMMANDS
from piston_cosim.master.fmi.builder import build_fmu_of_file

from ..command import call
from ..fmu.runs import run_tree, stopped

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted([*ROOT.glob("docs/**/*.md"), *ROOT.glob("models/**/*.md")])]
BLOCK = re.compile(r"(?ms)^```[^\n]*\n(.*?)^```$")
SPAN = re.compile(r"`([^`\n]+)`")
COMMAND = re.compile(r"(?:^|[ /])piston-cosim (\S.*)")

SLOW = (
    *("run numerical_example*", "run fired_motorcycle*", "run ring_pack", "run grooved_skirt*"),
    *("run floating_pin*", "run yielding_bosses*", "run crank_bearings*", "run journal_bearing*"),
    *("run whole_engine*", "run models/whole_engine/*"),
    *("run twin *", "run flexible_twin*", "run elastic_tube", "run engine.ssp"),
    *("run data_sheet --set native=true", "run data_sheet * --bodies *", "run data_sheet * jfo *"),
    *("sweep numerical_example *", "sweep fired_motorcycle *", "sweep data_sheet *"),
    *("sweep models/measured/piston_slap *", "sensitivities *", "optimise *", "calibrate *"),
    *(
        "sweep my_engine *",
        "study my_engine grid",
        "study my_engine step",
        "study numerical_example *",
        "study fired_motorcycle *",
    ),
    *("study elastic_tube *", "reduce numerical_example*", "reduce yielding_bosses*", "verify*"),
    "results recover results/*",
    *("fmu build * --native *", "fmu build * --case *", "fmu export * --native *"),
    *("fmu export my_engine *", "fmu export numerical_example *", "fmu export *.ssp*"),
)
QUICK = (
    *(
        "list",
        "--help",
        "--version",
        "* --help",
        "keys*",
        "new *",
        "check *",
        "profile *",
        "bearing *",
    ),
    *("run my_engine*", "run data_sheet*", "run case.toml*", "run two_mass_oscillator"),
    *("compare *", "results plot *", "results report *", "results scalars *", "results fields *"),
    *("results snapshot *", "results movie *", "resume *"),
    *("fmu info *", "fmu check *", "fmu build my_film.py*", "fmu build models/*"),
    *("fmu build ehd --grid *", "fmu build ehd --output *"),
    "fmu export data_sheet --output engine.fmu",
)
NOT_RUN = {
    "--install-completion": "changes the shell of the user",
    "*--dask *": "needs a cluster",
    "reduce my_engine*": "the page adds a mesh first, which tests/fmu/test_own_piston.py does",
    "results recover a.h5*": "a.h5 has no flexible body here, see.md has the command",
    "verify --output": "verification.md has the whole command",
    "run build/engine/engine.ssp*": "tests/fmu/test_engine_example.py builds and runs it",
}
"""Commands that no test here can run, and why."""
NAMES = {"list", "keys", "verify"}
"""Commands without an operand. Another name of a command alone is a reference to it."""
WRITTEN = {
    "my_engine NAME": "my_engine step",
    "CASE methods": "numerical_example methods",
    "CASE": "data_sheet",
    "COMMAND": "run",
}
WRITTEN |= {"RUN.h5": "a.h5"}
"""Words of the pages in capitals, and what replaces them here."""
STOPS = {"two_mass_oscillator": "30 ms", "elastic_tube": "", "journal_bearing": "2 ms"}
STOPS |= {"case.toml": "10 ms", "my_engine": "6 deg"}
"""Stop time of cases without a crank, and of my_engine: three rows for the measurement of the page.
That of the others is 2 steps."""
SHEET = find_case("data_sheet")
PROFILE = "height,0,45,90,135,180,225,270,315\n" + "".join(
    f"{y},{k},{k // 2},{k // 4},{k // 2},{k},{k // 2},{k // 4},{k // 2}\n"
    for y, k in ((-14, 60), (-7, 54), (0, 50), (7, 55), (13, 66))
)
MEASURED = "bodies.crank_angle [deg],bodies.side_force [kN]\n-360,0\n-358,0.1\n-356,0.3\n"


def commands(page):
    """Return the distinct commands of a page, in their order, without comments."""
    text = re.sub(r" *\\\n\s*", " ", page.read_text())
    lines = [line for block in BLOCK.findall(text) for line in block.splitlines()]
    found = filter(None, map(COMMAND.search, [*lines, *SPAN.findall(BLOCK.sub("", text))]))
    typed = [re.split(r"\s{2,}|\s+# ", one[1])[0].strip() for one in found]
    return [one for one in dict.fromkeys(typed) if one in NAMES or one not in COMMANDS]


def kind(command):
    """Return the list of a command: the first one with a pattern that it matches."""
    lists = {"not run": NOT_RUN, "slow": SLOW, "quick": QUICK}
    for word, name in WRITTEN.items():
        command = command.replace(word, name)
    return next((k for k, one in lists.items() if any(fnmatchcase(command, p) for p in one)), None)


def words_of(command, folder):
    """Return the words of a command that ends early, in a folder with the results of 8 deg."""
    for word, name in WRITTEN.items():
        command = command.replace(word, name)
    words = shlex.split(command.replace("$PWD", str(folder)))
    if "--time" in words:
        words[words.index("--time") + 1] = "0 ms"
    if (
        words[0] in ("run", "sweep", "study", "sensitivities", "optimise", "calibrate")
        and "--help" not in words
    ):
        stop = STOPS.get(words[1], "2 deg" if "step" not in command else "8 deg")
        words += ["--output", "results/swapped"] if "--bodies" in words else []  # no mesh
        words += ["--set", f"time.stop={stop}"] if stop else []
    return [str(file) for word in words for file in (folder.glob(word) if "*" in word else [word])]


@pytest.fixture(scope="module")
def stock(tmp_path_factory):
    """Return a folder with the files that pages name without making them."""
    folder = tmp_path_factory.mktemp("stock")
    template = ROOT / "models/lubrication_template/axial_film.py"
    (folder / "my_film.py").write_text(template.read_text().replace("AxialFilm", "MyFilm"))
    (folder / "models").symlink_to(ROOT / "models")
    (folder / "docs").mkdir()
    oscillator = ROOT / "models/two_mass_oscillator/oscillator.py"
    shutil.copy(build_fmu_of_file(f"{oscillator}:Oscillator", {}), folder / "mass.fmu")
    own = build_fmu_of_file(f"{template}:AxialFilm", {"grid": [40, 40]})
    for name in ("own.fmu", "film.fmu"):
        shutil.copy(own, folder / name)
    for name in ("bench.csv", "measured.csv"):
        (folder / name).write_text(MEASURED)
    (folder / "my_profile.csv").write_text(PROFILE)
    tree = read_tree(SHEET, [("time.stop", "8 deg"), ("record.checkpoint_every", 1)])
    run_tree(SHEET, tree, folder / "a.h5").close()
    (folder / "results/a").mkdir(parents=True)
    stopped(SHEET, tree, folder / "results/a/flexible.h5", 2e-4)
    for name in (
        *("b.h5", "coupled.h5", "results/a/rigid.h5", "results/b/rigid.h5"),
        *("results/data_sheet/rigid.h5", "results/my_engine/rigid.h5"),
        *("results/my_engine/base.h5", "results/fired_motorcycle/flexible.h5"),
        *("results/journal_bearing/heavy.h5", "results/journal_bearing/elastic.h5"),
        "results/study_numerical_example_modes/runs/rigid.h5",
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / "a.h5", folder / name)
    sizes = "--bore", 86, "--stroke", 86, "--rod", 143
    assert call("new", "my_engine", *sizes, folder=folder).returncode == 0
    return folder


def test_every_command_is_in_a_list():
    """A list that no page needs any more is no error, a command without a list is one."""
    found = {one: page.name for page in PAGES for one in commands(page)}
    assert len(found) > 100
    assert {one: page for one, page in found.items() if kind(one) is None} == {}


def trials():
    """Yield each page with commands, once for the quick ones and once if it has slow ones."""
    for page in PAGES:
        kinds = {kind(one) for one in commands(page)}
        name = str(page.relative_to(ROOT))
        if "quick" in kinds:
            yield pytest.param(page, ("quick",), id=name)
        if "slow" in kinds:
            yield pytest.param(page, ("quick", "slow"), id=f"{name} slow", marks=pytest.mark.slow)


LACKING = ("expected a C compiler", "expected gmsh")
"""Faults of commands that need a program which is not installed everywhere."""


@pytest.fixture(scope="module")
def done():
    """Return the commands that have run: a command of several pages runs once."""
    return set()


@pytest.mark.parametrize("page, kinds", [*trials()])
def test_the_commands_of_a_page_run_in_their_order(page, kinds, stock, done):
    if case := re.search(r"(?ms)^```toml\n(.*?)^```$", page.read_text()):
        (stock / "case.toml").write_text(case[1])
    for command in commands(page):
        if kind(command) not in kinds or command in done:
            continue
        if command.startswith("new my_engine"):
            shutil.rmtree(stock / "my_engine")
        result = call(*words_of(command, stock), folder=stock)
        lacks = any(fault in result.stderr for fault in LACKING)
        assert lacks or result.returncode == 0, f"{command}\n{result.stdout}\n{result.stderr}"
        done.add(command)
