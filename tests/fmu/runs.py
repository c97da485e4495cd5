"""Runs of cases in the process of the tests."""

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run


def run_tree(origin, tree, output):
    """Return the results of a case's tree, whose file is at `origin`."""
    case = check_case(tree, origin)
    run(open_system(case, origin.parent, print), case, tree, output)
    return Results(output)


def run_text(folder, text, changes=(), output=None):
    """Write a case into a folder and return its results."""
    path = folder / "case.toml"
    path.write_text(text)
    return run_tree(path, read_tree(path, changes), output or folder / "o.h5")


def reached(one):
    """Return the end of the last step of an instance [s], where its next step begins."""
    return one.get("time") if one.version == "3" else one._reached(0.0)
