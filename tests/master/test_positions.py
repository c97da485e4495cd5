"""Names for positions: no long positional argument lists, no picking by number where names are."""

import ast

MOST = 8
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


def test_rules_see_what_they_forbid():
    tree = ast.parse("def f(a, b, c, d, e, f, g, h, i):\n    return link[8] + a.shape[2] + x[0, 3]")
    assert long_lists(tree) == [("f", 1)]
    assert picked(tree) == [("link[8]", 2)]


def test_no_function_takes_more_than_eight_arguments_by_position(trees):
    assert {path: faults for path, tree in trees.items() if (faults := long_lists(tree))} == {}


def test_nothing_is_picked_by_a_number_of_two_or_more(trees):
    assert {path: faults for path, tree in trees.items() if (faults := picked(tree))} == {}
