"""Pin, connecting rod and crank of a piston as simple bodies, from the parameters of the case."""

import numpy as np

from ..case.contract import players
from ..results.file import Results
from ..results.solids import Solid
from .places import film_body, parameter
from .surfaces import at_instants, crank_motion, pin_offset

AROUND = 40
"""Number of points around a cylinder."""
PIN_SHARE = 0.2
"""Default radius of a pin, relative to the bore's."""

Mesh = tuple[np.ndarray, np.ndarray]
"""Points (n, 3) [m] and triangles (t, 3)."""


def crank_drive(results: Results, body: str, owner: str, motion: np.ndarray) -> list[Solid]:
    """Return pin, rod and crank of a piston; none if the case has no crank.

    Throw, rod length, pin radius and motion are those of the case, without the play of bearings.
    All other dimensions are multiples of the pin's radius r.

    Parameters
    ----------
    results : Results
    body : str
        Participant with the role `bodies`.
    owner : str
        Owner of the solids.
    motion : ndarray, shape (instants, 3)
        Motion of the piston, see `Solid`.
    """
    names = "crank_radius", "rod_length", "pin_radius"
    throw, length, pin = (parameter(results, body, name, "m") for name in names)
    bore = _bore_radius(results, body)
    if not (bore and throw and length):
        return []
    r = pin or PIN_SHARE * bore
    rod = [
        _cylinder(1.4 * r, 2 * r, y=length),
        _bar(1.2 * r, length, r),
        _cylinder(1.9 * r, 2 * r),
    ]
    crank = [
        _cylinder(1.3 * r, 3 * r, y=throw),
        *(_bar(3 * r, throw + 1.5 * r, r, z=side * 2 * r) for side in (-1, 1)),
        *(_cylinder(1.6 * r, 3 * r, z=side * 4 * r) for side in (-1, 1)),
    ]
    turning = crank_motion(results, body, "main_bearing")
    turning[:, 2] = at_instants(results, f"{body}.crank_angle")
    parts = {
        "pin": ([_cylinder(r, 1.7 * bore, x=pin_offset(results, body))], motion),
        "rod": (rod, crank_motion(results, body, "big_end")),
        "crank": (crank, turning),
    }
    return [_solid(name, meshes, own, owner) for name, (meshes, own) in parts.items()]


def _bore_radius(results, body):
    """Return the largest bore radius of the films of a body [m]; 0 if none states it."""
    films = players(results.case, "lubrication")
    own = [film for film in films if film_body(results, film) in (body, None)]
    return max((parameter(results, film, "bore_radius", "m") for film in own), default=0.0)


def _solid(name, meshes, motion, owner):
    """Return the body of several closed meshes."""
    begins = np.cumsum([0, *(len(points) for points, _ in meshes)])
    points = np.vstack([points for points, _ in meshes])
    triangles = np.vstack([own + begin for (_, own), begin in zip(meshes, begins)])
    modes, coordinates = np.zeros((len(points), 3, 0)), np.zeros((len(motion), 0))
    return Solid(
        name=name,
        points=points,
        triangles=triangles,
        modes=modes,
        coordinates=coordinates,
        motion=motion,
        owner=owner,
        schematic=True,
    )


def _prism(outline, depth, z) -> Mesh:
    """Return a prism along z over an outline (n, 2), which is counterclockwise and convex."""
    n = len(outline)
    ends = [np.column_stack([outline, np.full(n, z + side * depth / 2)]) for side in (-1, 1)]
    here, following = np.arange(n), (np.arange(n) + 1) % n
    fan = np.column_stack([np.zeros(n - 2, int), np.arange(1, n - 1), np.arange(2, n)])
    sides = [
        np.column_stack([here, following, following + n]),
        np.column_stack([here, following + n, here + n]),
    ]
    return np.vstack(ends), np.vstack([fan[:, ::-1], fan + n, *sides])


def _cylinder(radius, depth, x=0.0, y=0.0, z=0.0) -> Mesh:
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    outline = np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)])
    return _prism(outline, depth, z)


def _bar(width, length, depth, z=0.0) -> Mesh:
    """Return a bar from the origin along y."""
    half = width / 2
    return _prism(np.array([[-half, 0], [half, 0], [half, length], [-half, length]]), depth, z)
