"""What other installed packages bring: found by entry points, looked up by the names in a case.

piston_cosim.participants   factory(name, options, folder) -> Participant
piston_cosim.methods        factory(coupling table) -> Method; its `remembered`, if any, are the
                            classes that its memory is made of, for checkpoints
piston_cosim.step_controls  factory(wires, smallest step [s], options) -> like StepControl
piston_cosim.observers      factory(options, system, results file) -> `attempted`, `accepted` (see
                            Observer) and `close`
"""

from importlib.metadata import entry_points
from typing import Any

from ..fmi.errors import BadInput

GROUP = "piston_cosim."


def names(kind: str) -> list[str]:
    """What there is of "participants", "methods", "step_controls" or "observers"."""
    return sorted(entry_points(group=GROUP + kind).names)


def plugin(kind: str, name: str) -> Any:
    """The factory of that name; BadInput if there is none, or its package cannot be imported."""
    found = [entry for entry in entry_points(group=GROUP + kind) if entry.name == name]
    if not found:
        there = ", ".join(names(kind)) or "none"
        raise BadInput(f"{name!r}: no installed package brings it; of {kind} there are: {there}")
    try:
        return found[0].load()
    except Exception as error:
        raise BadInput(f"{name!r}: {found[0].value} cannot be imported: {error}") from None


def made(kind: str, name: str, *arguments: Any) -> Any:
    """What that factory makes of the arguments; BadInput where it raises ValueError."""
    factory = plugin(kind, name)
    try:
        return factory(*arguments)
    except BadInput:
        raise
    except (ValueError, TypeError, KeyError) as error:
        raise BadInput(f"{name!r}: {error}") from None
