"""`piston-cosim list`."""

from rich.table import Table

from ..case.reading import case_names, find_case, read_tree
from .common import console


def command():
    """List the shipped cases.

    Example: piston-cosim list
    """
    table = Table("case", "title", "variants", box=None)
    for name in case_names():
        tree = read_tree(find_case(name))
        table.add_row(name, tree.get("title", ""), ", ".join(tree.get("variants", {})))
    console.print(table)
