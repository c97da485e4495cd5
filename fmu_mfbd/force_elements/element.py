"""Declaration of a force element: its parameters, its bodies, its force and how that changes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

BODIES = ("crank", "rod", "pin", "piston")
"""Bodies that an element acts on. It reacts on another one of them or on the block."""


def declared(
    unit: str,
    start: float,
    minimum: float | None = None,
    maximum: float | None = None,
    advanced: bool = False,
) -> Any:
    """Declare the default of a parameter with unit and range. The text below it describes it.

    If `advanced`, few cases need it.
    """
    known = dict(unit=unit, minimum=minimum, maximum=maximum, advanced=advanced)
    return field(default=start, metadata=known)


JOINTS = {"piston": "rod", "rod": "crank", "crank": "block"}
"""Body -> its parent, with a joint that an element may free."""


class PointMotion(NamedTuple):
    """Motion of the point of a force element, seen from the body that it reacts on.

    All components are in the axes of that body. The position is that from its reference point,
    see `ForceElement`.

    Parameters
    ----------
    x, y : float
        Position [m].
    angle : float
        Angle of the body that the element acts on, from -pi to pi [rad].
    vx, vy, spin : float
        Rates of `x`, `y` and `angle` [m/s], [rad/s].
    crank_angle : float
        0 at firing top dead centre [rad].
    """

    x: float
    y: float
    angle: float
    vx: float
    vy: float
    spin: float
    crank_angle: float


class PointForce(NamedTuple):
    """Force of an element on its point, in the axes of the body that it reacts on.

    The opposite force acts on that body at the same point.

    Parameters
    ----------
    x, y : float
        [N]
    moment : float
        About +z [N m].
    """

    x: float
    y: float
    moment: float


@dataclass(frozen=True)
class ForceElement:
    """Force between two bodies that depends on their motion.

    The reference point of crank, rod, pin and piston is the crank pin, the small end, its axis and
    pin point A. That of the block is the position of A on the crank axis in the middle of the bore.
    A tied pin is a part of the rod. The force does not act on modes.

    Parameters
    ----------
    parameters : type
        Frozen dataclass of `declared` parameters in SI. If the first one is 0, there is no element.
    force : function
        Takes the parameters and a `PointMotion`, and returns a `PointForce`.
    change : function
        Takes the parameters, a `PointMotion` and a small change of it, and returns the change of
        the force. That of the crank angle is 0.
    acts, reacts : str
        Bodies: one of `BODIES`, and another one of them or "block".
    height : str
        Name of the parameter with y of the point from the reference point of the body that the
        element acts on. Default: the point is the reference point.
    frees : mapping of str to (float, float)
        Directions, in the axes of the body that it reacts on, along which the joint between both
        bodies slides instead of being tied, if the build option `slides` lists their names. Each
        is an output, the displacement [m] along a direction of length 1. `JOINTS` has the bodies.
        The bore is read where the piston would be without the displacement.
    """

    parameters: type
    force: Callable[[Any, PointMotion], PointForce]
    change: Callable[[Any, PointMotion, PointMotion], PointForce]
    acts: str = "piston"
    reacts: str = "block"
    height: str = ""
    frees: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.acts not in BODIES or self.reacts not in {"block", *BODIES} - {self.acts}:
            bodies = f"acts = {self.acts!r}, reacts = {self.reacts!r}"
            raise ValueError(f"expected two of {', '.join(BODIES)} and block, got {bodies}")
        if not self.names() or self.height not in ("", *self.names()):
            raise ValueError(f"height: expected one of {self.names()}, got {self.height!r}")

        if self.frees and JOINTS.get(self.acts) != self.reacts:
            got = f"acts = {self.acts!r}, reacts = {self.reacts!r}"
            raise ValueError(f"frees: expected acts and reacts of {JOINTS}, got {got}")

    def names(self) -> list[str]:
        """Return the names of the parameters."""
        return [one.name for one in fields(self.parameters)]
