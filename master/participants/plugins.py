"""Entry points of other installed packages, used by the names in a case.

piston_cosim.participants   factory(name, options, folder) -> Participant
piston_cosim.methods        factory(coupling table) -> Method; its optional `remembered` are the
                            classes of its memory, for checkpoints
piston_cosim.step_controls  factory(wires, smallest step [s], options) -> like StepControl
piston_cosim.observers      factory(options, system, results file) -> `attempted`, `accepted` (see
                            Observer) and `close`
"""

from importlib.metadata import entry_points
from typing import Any

from ..fmi.errors import BadInput, unknown

GROUP = "piston_cosim."

KEYS = {"participants": "plugin", "methods": "coupling.method"}
KEYS |= {"step_controls": "coupling.step_control", "observers": "observers"}
"""Key of a case that names a plugin, by the kind of plugin."""


def names(kind: str) -> list[str]:
    """Return the installed "participants", "methods", "step_controls" or "observers"."""
    return sorted(entry_points(group=GROUP + kind).names)


def plugin(kind: str, name: str) -> Any:
    """Return the factory of a name.

    Raises `BadInput` if it does not exist, or if its package cannot be imported.
    """
    matches = [entry for entry in entry_points(group=GROUP + kind) if entry.name == name]
    if not matches:
        hint = "install the package that has it"
        raise BadInput(f"{KEYS[kind]}: {unknown('plugin', name, names(kind), hint)}")
    try:
        return matches[0].load()
    except Exception as error:
        raise BadInput(
            f"{KEYS[kind]}: expected a module that can be imported, got {matches[0].value}: {error}"
        ) from None


def from_plugin(kind: str, name: str, *arguments: Any) -> Any:
    """Return the result of a factory; raise `BadInput` if it raises `ValueError`."""
    factory = plugin(kind, name)
    try:
        return factory(*arguments)
    except BadInput:
        raise
    except (ValueError, TypeError, KeyError) as error:
        raise BadInput(f"{KEYS[kind]}: {name}: {error}") from None
