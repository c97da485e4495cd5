"""Names for positions: no long positional argument lists, no picking by number where names are."""

import ast
import re

MOST = 8
MEMBERS = 5
"""Members up to which a named tuple or dataclass may be built by position."""
ORDERED = ("parents", "argv", "shape")
"""Attributes whose elements have numbers and no names."""


def long_lists(tree):
    """(name, line) of functions that take more than `MOST` positional arguments."""
    return [
        (node.name, node.lineno)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and len(node.args.posonlyargs + node.args.args) > MOST
    ]


def picked(tree):
    """(text, line) of subscripts by an integer of 2 or more that is the only index.

    What a string's `partition` gives, a path's parents, a program's arguments and the sizes of an
    array have no names.
    """
    return [
        (ast.unparse(node), node.lineno)
        for node in ast.walk(tree)
        if isinstance(node, ast.Subscript)
        and isinstance(node.slice, ast.Constant)
        and isinstance(node.slice.value, int)
        and node.slice.value >= 2
        and not (isinstance(node.value, ast.Attribute) and node.value.attr in ORDERED)
        and "partition(" not in ast.unparse(node.value)
    ]


def large_tuples(trees):
    """Names of the named tuples and dataclasses with more than `MEMBERS` members."""
    classes = (one for tree in trees for one in ast.walk(tree) if isinstance(one, ast.ClassDef))
    return {
        one.name
        for one in classes
        if re.search(r"\(NamedTuple\)|@dataclass", ast.unparse(one))
        and sum(isinstance(line, ast.AnnAssign) for line in one.body) > MEMBERS
    }


def built_by_position(tree, names):
    """(name, line) of tuples of these names with more than `MEMBERS` values by position."""
    return [
        (node.func.id, node.lineno)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in names
        and len(node.args) > MEMBERS
        and not any(isinstance(one, ast.Starred) for one in node.args)
    ]


def test_rules_see_what_they_forbid():
    tree = ast.parse("def f(a, b, c, d, e, f, g, h, i):\n    return link[8] + a.shape[2] + x[0, 3]")
    assert long_lists(tree) == [("f", 1)]
    assert picked(tree) == [("link[8]", 2)]
    members = "".join(f"    {name}: int\n" for name in "abcdef")
    tree = ast.parse(f"class Six(NamedTuple):\n{members}Six(1, 2, 3, 4, 5, 6)\nSix(*range(6))")
    assert built_by_position(tree, large_tuples([tree])) == [("Six", 8)]


def test_no_function_takes_more_than_eight_arguments_by_position(trees):
    assert {path: faults for path, tree in trees.items() if (faults := long_lists(tree))} == {}


def test_nothing_is_picked_by_a_number_of_two_or_more(trees):
    assert {path: faults for path, tree in trees.items() if (faults := picked(tree))} == {}


def test_large_tuples_are_built_by_name(trees):
    names = large_tuples(trees.values())
    faults = {path: built_by_position(tree, names) for path, tree in trees.items()}
    assert {path: lines for path, lines in faults.items() if lines} == {}
