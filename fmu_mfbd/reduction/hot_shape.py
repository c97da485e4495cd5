"""Hot shape of skirt or bore: from displacements of another program, or from temperatures."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ...master.fmi.separated import read_rows
from ..body_options import Block, Piston, TemperatureField
from ..finite_elements.element import rigid_motions, stiffness, thermal_load
from ..finite_elements.faces import surface_matrix
from ..finite_elements.mesh import Mesh, MeshFault
from ..finite_elements.node_values import (
    DISPLACEMENT,
    TEMPERATURE,
    Placement,
    displacement_on,
    on_mesh,
    read_node_values,
)
from ..finite_elements.solver import Factorise, factorise
from ..geometry.grid import cell_centres
from ..geometry.profile import HotShape
from .bases import Elastic, MeanElastic, mean_conditions
from .geometry import pin_bore
from .reading import read_body
from .reduce import ends, film_surface
from .reduced_body import load
from .store import contents, stored_file

Say = Callable[[str], None]
ZERO = {"degC": 273.15, "K": 0.0}
"""Zero of the units of temperature [K]."""
COLDEST, HOTTEST = 200.0, 1500.0
"""Range of temperatures, our own choice [K]."""
LEAST_HOT = 500.0
"""Lowest temperature of a body up to which its numbers may be degrees Celsius, our own choice [K].

The coldest part of a piston or cylinder in an engine is not hotter. 227 degC is 500 K, and numbers
in kelvin that are read as degrees Celsius begin above."""
LEAST_SHARED_LENGTH = 0.2
"""Least length that table and body share, by the longer of both, our own choice: wrong units of
length differ by a factor of 10 or more, inches and centimetres excepted."""
OF_MODES = {
    *("profiles", "orders", "reduced", "train_on", "pin_offset", "modes", "basis"),
    *("modes_from", "symmetric_film", "tie", "boss_length", "density"),
}
"""Options that a hot shape does not depend on."""


class Table(NamedTuple):
    """Temperatures [K], (heights, radii), over radius and height [m]."""

    radius: np.ndarray
    height: np.ndarray
    temperature: np.ndarray


def kept_hot_shape(
    options: Piston | Block, grid: tuple[int, int], folder: Path, say: Say
) -> HotShape:
    """Return the hot shape of a body, from the cache or computed now.

    Parameters
    ----------
    options : Piston or Block
        With a hot shape or a temperature field.
    grid : (int, int)
        Cells of the film around and along the skirt.
    folder : Path
        Cache.
    say : callable
        Prints a sentence.

    Raises
    ------
    MeshFault
        If mesh and file do not fit.
    """
    name = f"hot_{_name(options)}"
    decided = contents(options, OF_MODES) | {"grid": list(grid)}
    return load(
        HotShape, stored_file(name, decided, lambda: (hot_shape(options, grid, say),), folder)
    )


def hot_shape(
    options: Piston | Block,
    grid: tuple[int, int],
    say: Say,
    factors: Factorise = factorise,
) -> HotShape:
    """Return the hot shape of skirt or bore; see `kept_hot_shape`."""
    mesh = read_body(options, lambda text: None)
    piston = isinstance(options, Piston)
    if options.hot_shape:
        u = _displacement(mesh, options)
    else:
        assert (field := options.temperature_field)
        rise = _temperatures(mesh, options, field) - field.reference
        say(
            f"hot shape of {3 * len(mesh.points)} degrees of freedom at "
            f"{field.reference + rise.min():.4g} to {field.reference + rise.max():.4g} K"
        )
        u = thermal_shape(mesh, rise, piston, factors)
    if piston:
        lower, upper = ends(mesh, "skirt", options.skirt_lower, options.skirt_upper)
        u, motion = without_motion(mesh, u)
        return on_skirt(mesh, u, grid, (lower, upper), motion)
    lower, upper = ends(mesh, "bore", options.bore_lower, options.bore_upper)
    return on_bore(mesh, u, grid[0], np.linspace(lower, upper, options.stations))


def _name(options: Piston | Block) -> str:
    """Return the name of the table of a body."""
    return "piston" if isinstance(options, Piston) else "block"


def _displacement(mesh: Mesh, options: Piston | Block) -> np.ndarray:
    """Return the displacement of the nodes from a file, (n, 3) [m], nan at nodes without one."""
    assert (source := options.hot_shape)
    surface, others = ("skirt", ["pin_bore"]) if isinstance(options, Piston) else ("bore", [])
    needed = np.unique(np.concatenate([mesh.nodes(name) for name in (surface, *others)]))
    placed = Placement(source.length_unit, options.axes, options.origin)
    values = read_node_values(source.file, DISPLACEMENT, source.field)
    return displacement_on(
        values, mesh, placed, surface, needed, f"{_name(options)}.hot_shape: {source.file}"
    )


def _temperatures(mesh: Mesh, options: Piston | Block, field: TemperatureField) -> np.ndarray:
    """Return the temperature of the nodes, (n,) [K].

    Raises
    ------
    MeshFault
        If nodes have none, or temperatures are out of range.
    """
    where = f"{_name(options)}.temperature_field: {field.table or field.file}"
    if field.table:
        table = read_table(Path(field.table), field)
        if faults := _places(table, mesh.points):
            raise MeshFault([f"{where}: {fault}" for fault in faults])
        values = on_table(table, mesh.points)
    else:
        assert field.file
        placed = Placement(field.length_unit, options.axes, options.origin)
        nodal = read_node_values(field.file, TEMPERATURE, field.field)
        nodes = np.arange(len(mesh.points))
        values = on_mesh(nodal, mesh, placed, nodes, where)[:, 0] + ZERO[field.temperature_unit]
    low, high = float(values.min()), float(values.max())
    if field.temperature_unit == "degC" and low > LEAST_HOT:
        coldest = f"{LEAST_HOT - ZERO['degC']:.4g} degC"
        raise MeshFault(
            f"{where}: expected a lowest temperature up to {coldest}, got "
            f"{low - ZERO['degC']:.4g} degC; if the numbers are kelvin, set temperature_unit to K"
        )
    if low < COLDEST or high > HOTTEST:
        expected = f"expected {COLDEST:g} to {HOTTEST:g} K, got {low:.4g} to {high:.4g} K"
        raise MeshFault(f"{where}: {expected}; check temperature_unit")
    return values


def _places(table: Table, points: np.ndarray) -> list[str]:
    """Return a sentence if the radii or the heights of a table are not those of the body.

    A line of one value is constant in its direction. Radii may begin at the body or at the axis,
    and must reach into the body.
    """
    x, y, z = points.T
    faults = []
    for name, line, value in (
        ("radii", table.radius, np.hypot(x, z)),
        ("heights", table.height, y),
    ):
        low, high = float(value.min()), float(value.max())
        begins = (low, 0.0) if name == "radii" else (low,)
        inside = _shared(line, low, high) >= LEAST_SHARED_LENGTH * (high - low)
        if line.size > 1 and not (inside and any(_fits(line, one, high) for one in begins)):
            faults.append(
                f"expected {name} that cover {1e3 * low:.4g} to {1e3 * high:.4g} mm, those of the "
                f"body, got {1e3 * line[0]:.4g} to {1e3 * line[-1]:.4g} mm; check length_unit"
            )
    return faults


def _fits(line: np.ndarray, low: float, high: float) -> bool:
    """Return whether a line of positions shares enough of its length with low to high."""
    return _shared(line, low, high) >= LEAST_SHARED_LENGTH * max(line[-1] - line[0], high - low)


def _shared(line: np.ndarray, low: float, high: float) -> float:
    """Return the length that a line of positions shares with low to high, negative for a gap."""
    return float(min(line[-1], high) - max(line[0], low))


def read_table(path: Path, field: TemperatureField) -> Table:
    """Read a table of temperatures over radius and height.

    Raises
    ------
    MeshFault
        If rows differ in length, or radii or heights do not rise.
    """
    rows = read_rows(path)
    try:
        head, *body = [[float(cell) for cell in row[k == 0 :]] for k, (_, row) in enumerate(rows)]
    except ValueError as error:
        raise MeshFault(
            f"{path}: expected radii, then rows of a height and values; {error}"
        ) from None
    faults = [
        f"{path}, line {number}: expected a height and {len(head)} temperatures, got {len(row)}"
        for (number, _), row in zip(rows[1:], body)
        if len(row) != len(head) + 1
    ]
    if faults or not body or not head:
        raise MeshFault(faults or f"{path}: expected radii, then rows of a height and values")
    table = np.array(body)
    radius, height = np.array(head), table[:, 0]
    for name, line in (("radii", radius), ("heights", height)):
        if (np.diff(line) <= 0).any():
            faults.append(f"{path}: expected ascending {name}, got {line.tolist()}")
    if faults:
        raise MeshFault(faults)
    length = field.length_unit
    temperature = table[:, 1:] + ZERO[field.temperature_unit]
    return Table(radius * length, height * length, temperature)


def on_table(table: Table, points: np.ndarray) -> np.ndarray:
    """Return temperatures at points, (n,) [K], linear in radius and height, constant outside."""
    from scipy.interpolate import RegularGridInterpolator  # slow to import

    x, y, z = points.T
    lines, axes, at = [], [], []
    for line, value in ((table.height, y), (table.radius, np.hypot(x, z))):
        lines.append(line if line.size > 1 else np.array([line[0], line[0] + 1.0]))
        axes.append(line.size)
        at.append(np.clip(value, line[0], line[-1]))
    values = np.tile(table.temperature, [2 if size == 1 else 1 for size in axes])
    return RegularGridInterpolator(lines, values)(np.stack(at, axis=1))


def thermal_shape(
    mesh: Mesh, rise: np.ndarray, piston: bool, factors: Factorise = factorise
) -> np.ndarray:
    """Return the static displacement of a body by heat, (n, 3) [m].

    Eq. (J52):  K u = f,   f by Eq. (M25)

    A block is fixed at its bolts. The mean motion of a piston's pin bores is zero, as of the tie
    `rbe3` (Eq. (J5)): the pin does not resist the growth of its bores.

    Parameters
    ----------
    mesh : Mesh
        With its material.
    rise : ndarray, shape (n,)
        Temperature above that of the mesh without stress [K].
    piston : bool
        Whether the body is a piston.
    factors : callable
        Factorises a matrix.
    """
    assert (material := mesh.material)
    young, poisson, _, expansion, _ = material
    K = stiffness(mesh.points, mesh.tets, young, poisson)
    load = thermal_load(mesh.points, mesh.tets, young, poisson, expansion, rise).ravel()
    no_mass = sp.csr_matrix(K.shape)
    if piston:
        conditions = mean_conditions(mesh.points, pin_area(mesh))
        elastic = MeanElastic(K, no_mass, conditions, rigid_motions(mesh.points), factors)
    else:
        elastic = Elastic(K, no_mass, mesh.nodes("bolts"), factors)
    u = elastic.solve(load[elastic.free, None])  # Eq. (J52)
    return elastic.full(u).reshape(-1, 3)


def pin_area(mesh: Mesh) -> np.ndarray:
    """Return the area of the pin bores at each node, (n,) [m2]."""
    return np.asarray(surface_matrix(mesh.points, mesh.faces["pin_bore"]).sum(axis=1)).ravel()


def without_motion(mesh: Mesh, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a piston's displacement without the mean motion of its pin bores, and this motion.

    Eq. (J53):  u' = u - R q,   C u' = 0      C by Eq. (J5), R the rigid motions about A

    The floating frame moves with the tie, so that its modes have no such motion either.

    Returns
    -------
    displacement : ndarray, shape (n, 3)
        [m]
    motion : ndarray, shape (6,)
        q [m], [rad]
    """
    axis, _ = pin_bore(mesh)
    C = mean_conditions(mesh.points, pin_area(mesh))
    R = rigid_motions(mesh.points - np.array([axis.first, 0.0, 0.0]))
    q = np.linalg.solve(C @ R, C @ np.nan_to_num(u).ravel())
    return u - (R @ q).reshape(-1, 3), q  # Eq. (J53)


def on_skirt(
    mesh: Mesh,
    u: np.ndarray,
    grid: tuple[int, int],
    ends_cold: tuple[float, float],
    motion: np.ndarray,
) -> HotShape:
    """Return the hot shape on the film grid of the hot skirt.

    Eq. (I16):  y_l' = y_l + mean u_y(theta, y_l),   y_u' likewise
                u_r at Y = u_r(theta, y),   y + u_y(theta, y) = Y

    y is the height of the material in the mesh, and Y are the rows of the grid between y_l', y_u'.

    Parameters
    ----------
    mesh : Mesh
    u : ndarray, shape (n, 3)
        Displacement [m].
    grid : (int, int)
    ends_cold : (float, float)
        y_l and y_u [m].
    motion : ndarray, shape (6,)
        Mean motion of the pin bores.
    """
    around, along = grid
    lower, upper = ends_cold
    angle, rows = cell_centres(around, along, lower, upper)
    stations = np.concatenate([[lower], rows, [upper]])
    radial, axial = _read(mesh, u, "skirt", angle, stations)
    low, high = float(axial[:, 0].mean()), float(axial[:, -1].mean())  # Eq. (I16)
    _, hot = cell_centres(around, along, lower + low, upper + high)
    return HotShape(*_at_hot(stations, radial, axial, hot), low, high, motion)


def on_bore(mesh: Mesh, u: np.ndarray, around: int, heights: np.ndarray) -> HotShape:
    """Return the hot shape on the table of the bore, with its rigid motion, see `on_skirt`."""
    angle, _ = cell_centres(around, 1, 0.0, 1.0)
    radial, axial = _read(mesh, u, "bore", angle, heights)
    nodes = mesh.nodes("bore")
    motion, *_ = np.linalg.lstsq(rigid_motions(mesh.points[nodes]), u[nodes].ravel(), rcond=None)
    return HotShape(*_at_hot(heights, radial, axial, heights), 0.0, 0.0, motion)


def _read(mesh, u, surface, angle, heights):
    """Return outward radial and axial displacement on a grid, (c, a), as modes are read."""
    reading = film_surface(mesh, surface, angle, heights).reading
    flat = np.nan_to_num(u).ravel()  # only nodes of the surface are read
    return tuple((one @ flat).reshape(len(angle), -1) for one in reading)


def _at_hot(
    stations: np.ndarray, radial: np.ndarray, axial: np.ndarray, heights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return both displacements of the material that is at some heights when hot, Eq. (I16).

    Beyond the ends, they are constant.
    """
    from scipy.interpolate import PchipInterpolator  # slow to import

    out = np.empty((2, len(radial), len(heights)))
    for i, (grown, moved) in enumerate(zip(radial, axial)):
        hot = stations + moved  # Eq. (I16)
        both = PchipInterpolator(hot, np.stack([grown, moved]), axis=1)
        out[:, i] = both(np.clip(heights, hot[0], hot[-1]))
    first, second = out
    return first, second
