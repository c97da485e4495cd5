"""Films of a piston as surfaces that move with their bodies.

They are those of the skirt, of a floating pin's bosses and small end, of the big end and of the
main bearing.
"""

from collections.abc import Callable

import numpy as np

from ..case.contract import players
from ..fmi.quantities import to_si
from ..results.fields_export import cylinder_cells, pin_cells, read_block
from ..results.file import Results
from ..results.series import Film
from ..results.solids import Solid, Stand
from .places import film_body, film_surface, gap_port, parameter

BOSSES = {"boss_left": -1.0, "boss_right": 1.0}
"""Side of z = 0 of each boss."""
EYE = "small_end"
CRANK = ("big_end", "main_bearing")
"""Films about the crank pin and about the crank's axis."""
SIZES = "bore_radius", "skirt_length"
"""Parameters of a film that are sizes of its surface."""
RADIUS_TOLERANCE = 0.02
"""Relative tolerance of the radius for points of a boss's bore."""


def films_of(results: Results, solids: list[Solid], say: Callable[[str], None]) -> list[Film]:
    """Return the recorded fields of every film on its surface.

    A film of the skirt is upright and as high as the piston. One of a boss moves with the
    piston. That of the small end moves with the pin and rotates with the rod, and that of the
    big end moves with the crank pin. Films without a piston are fixed. Films with an unknown
    position are omitted and reported.
    """
    films = []
    for name in players(results.case, "lubrication"):
        radius, length = (parameter(results, name, key, "m") for key in SIZES)
        ports = [port for port in results.recorded if results.dataset(port).ndim == 3]
        own = [port for port in ports if port.startswith(f"{name}.")]
        if not own or not radius:
            continue
        shape = results.dataset(own[0]).shape
        gap = gap_port(results, name)
        if gap in ports and gap not in own and results.dataset(gap).shape == shape:
            own.append(gap)
        owner = film_body(results, name)
        piston = next((s for s in solids if s.film and s.owner in ("", owner)), None)
        placed = _placed(results, name, (shape[1:], radius, length or 1.0), piston, own[0])
        if placed is None:
            say(f"{name}: omitted, because its position is unknown")
            continue
        points, cells, motion = placed
        stand = piston.stand if piston else Stand()
        blocks = [read_block(results, port) for port in own]
        films.append(
            Film(name=name, blocks=blocks, points=points, cells=cells, motion=motion, stand=stand)
        )
    return films


def _placed(results, film, sizes, piston, port):
    """Return points, cells and motion of a film's surface; None if its position is unknown."""
    shape, radius, length = sizes
    surface = film_surface(results, film).removesuffix(".")
    if surface in CRANK:
        ends = (-length / 2, length / 2)
        body = film_body(results, film)
        return *pin_cells(shape, radius, ends), crank_motion(results, body, surface)
    if surface in (*BOSSES, EYE):
        ends = _along_pin(results, film, surface, piston, radius, length)
        motion = piston.motion if piston else None
        if surface == EYE and motion is not None:
            motion = np.column_stack([motion[:, :2], rod_turn(results, film_body(results, film))])
        return *pin_cells(shape, radius, ends), motion
    if piston is None:
        return *cylinder_cells(shape, radius, (0.0, length)), None
    ends = piston.between(port)
    if ends is None:
        return None
    upright = None if piston.motion is None else piston.motion * [0.0, 1.0, 0.0]
    return *cylinder_cells(shape, radius, ends), upright


def _along_pin(results, film, surface, piston, radius, length):
    """Return the z range of a film of the pin [m].

    That of the small end is central. That of a boss begins where its bore begins in the mesh, or
    without a mesh next to the small end.
    """
    if surface == EYE:
        return -length / 2, length / 2
    side = BOSSES[surface]
    build = results.case["participants"][film_body(results, film)].get("build", {})
    begin = to_si(build.get("floating_pin", {}).get("small_end_length", "0 m"), "m") / 2
    if piston is not None and "rigid" not in build.get("piston", {}):
        x, y, z = piston.points.T
        of_bore = (np.abs(np.hypot(x, y) - radius) < RADIUS_TOLERANCE * radius) & (side * z > 0)
        begin = float(np.abs(z[of_bore]).min()) if of_bore.any() else begin
    return tuple(sorted((side * begin, side * (begin + length))))


def at_instants(results, port):
    """Return a scalar at the recorded instants."""
    return np.interp(results.instants, results.time, results.series(port).values)


def crank_motion(results: Results, body: str | None, surface: str) -> np.ndarray:
    """Return the motion of a shell of the crank without its play, (instants, 3) [m], [m], [rad].

    Eq. (X44):  (x, y) = (o - r sin theta, r cos theta)      big end, which rotates with the rod
                (x, y) = (o, 0)                              main bearing       o: crank_offset
    """
    radius = parameter(results, body, "crank_radius", "m") if surface == "big_end" else 0.0
    turn = rod_turn(results, body) if surface == "big_end" else 0.0
    theta = at_instants(results, f"{body}.crank_angle")
    aside = parameter(results, body, "crank_offset", "m") - radius * np.sin(theta)
    # Eq. (X44)
    return np.column_stack([aside, radius * np.cos(theta), turn + 0.0 * theta])


def rod_turn(results: Results, body: str | None) -> np.ndarray:
    """Return the rotation of the rod about z at the recorded instants [rad].

    Eq. (X25):  sin psi = -(e + x_A + r sin theta)/L     e: pin offset minus crank offset
    """

    def at(name):
        return at_instants(results, f"{body}.{name}")

    names = "crank_offset", "crank_radius", "rod_length"
    crank_offset, radius, length = (parameter(results, body, name, "m") for name in names)
    offset = pin_offset(results, body) - crank_offset
    aside = offset + at("lateral_displacement") + radius * np.sin(at("crank_angle"))
    return -np.arcsin(aside / length)  # Eq. (X25)


def pin_offset(results: Results, body: str | None) -> float:
    """Return the pin offset of a piston [m], 0 if the case does not state it."""
    build = results.case["participants"][body].get("build", {})
    return to_si(build.get("piston", {}).get("pin_offset", "0 m"), "m")
