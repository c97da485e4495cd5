"""Preview of the body FMU from its build table and parameters, before anything is reduced.

It has geometry, masses, clearance cold and hot, cells with a film, faults, and a picture of both
shapes.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..master.fmi.errors import BadInput
from ..master.fmi.preview import Figure, Message, Preview
from ..master.fmi.symmetry import rejection
from .body_options import Block, Piston
from .build import boss_films, eye_film, hot_piston, options_ahead, piston_about_pin
from .dynamics.assembly import ReducedBodies
from .dynamics.build_options import BuildOptions
from .dynamics.clearance import bore_shape, skirt_gap
from .dynamics.contradictions import pin_radius
from .dynamics.model_faults import faults
from .dynamics.parameters import (
    CRANK_PARAMETERS,
    ELEMENT_PARAMETERS,
    AxisParameters,
    Parameters,
    parameters_from,
    settings_of,
)
from .dynamics.pin_axis import pin_beam, pin_span
from .dynamics.thermal_growth import Radii
from .finite_elements.connections import aspect_ratios
from .finite_elements.element import rigid_mass
from .finite_elements.mesh import Mesh, MeshFault
from .geometry.grid import cell_centres
from .geometry.profile import HotShape
from .input_tables import read_tables
from .options import Build, read_options
from .preview_picture import Shapes, draw_shapes
from .preview_remarks import (
    COLD,
    BodyPreview,
    messages_on_fit,
    messages_on_gas,
    messages_on_profiles,
    narrowest,
)
from .preview_temperatures import (
    figures_of_walls,
    messages_on_shapes,
    messages_on_walls,
    warm_walls,
)
from .reducing import hot_shapes
from .reduction.bosses import boss_readings
from .reduction.reading import read_body
from .reduction.reduce import faults_of_modes, placed_block, placed_piston
from .reduction.reduced_body import SMALL_END, MeshProperties, ReducedBlock, load
from .reduction.rigid import rigid_block, rigid_piston
from .reduction.shell import film_shell, shell_mesh
from .reduction.symmetry import is_mirrored
from .reduction.ties import pin_layer, tie_of
from .thrust_symmetry import claims

Look = TypeVar("Look")
PISTON_POSITIONS = 7
"""Places of the piston along its stroke at which the clearance is looked at."""
CENTRE_FROM_PIN = "from the pin's axis to the centre of mass: compare, rocking depends on it"


class Eye(NamedTuple):
    """A rod's eye that yields: radius of its bore [m], and what is to be said of it."""

    radius: float
    figures: list[Figure]


def preview(options: dict[str, Any], parameters: dict[str, Any], folder: Path) -> Preview:
    """Look at a build table and its parameters.

    Parameters
    ----------
    options : dict
        The case file's `[participants.X.build]` table.
    parameters : dict
        Parameters of the case by name, in SI, None if a value is invalid. The others have their
        defaults. If one is None, no contradictions are checked.
    folder : Path
        Folder of the case.

    Returns
    -------
    Preview
        `figure("bore_radius")`, `("skirt_length")` and `("swept_volume")` are for others to hold
        theirs against.
    """
    try:
        build = read_options(options, folder)
        tables = read_tables(build)
    except BadInput as error:
        return Preview(faults=error.faults)
    valid = {name: value for name, value in parameters.items() if value is not None}
    chosen = parameters_from(Parameters, valid)
    elements = tuple(parameters_from(kind, valid) for kind in ELEMENT_PARAMETERS)
    wrong: list[str] = []
    warnings: list[str] = []
    piston = _tried(_piston, build, wrong, warnings)
    block = _tried(_block, build, wrong, warnings)
    if piston is None or block is None:
        return Preview(faults=wrong)
    if assumed := claims(build):
        sides = ("piston", build.piston, piston.mesh), ("block", build.block, block.mesh)
        reasons = [
            f"{name}.mesh (nodes differ from their mirror image)"
            for name, body, mesh in sides
            if body.modes and mesh and not is_mirrored(mesh, 2)
        ]
        wrong += [rejection(claim, reasons) for claim in assumed if reasons]
    try:
        hot = hot_shapes(build, lambda text: None)
    except BadInput as error:
        return Preview(faults=[*wrong, *error.faults])
    piston = piston._replace(body=hot_piston(piston.body, hot.get("piston")))
    cold, prepared = options_ahead(build, tables), options_ahead(build, tables, hot)
    axis = _axis(prepared, valid, build)
    eye = _tried(_eye, build, wrong, warnings)
    if None not in parameters.values():
        radii = {"small_end": eye.radius} if eye else {}
        rigid = ReducedBodies(piston.body, block.body)
        own = [axis, *elements] if axis else elements
        wrong += faults(rigid, prepared, chosen, own, radii)
    figures = [
        *_of_piston(build, piston),
        *_of_films(prepared, piston, chosen, valid),
        *(_of_axis(prepared, piston, chosen, axis) if axis and not wrong else ()),
        *(eye.figures if eye else ()),
        *_of_block(build, block),
        *(figure for name, shape in hot.items() for figure in _of_heat(name, shape)),
        *_of_mechanism(build, block, chosen, valid.get("crank_speed")),
    ]
    messages: list[Message] = []
    if tables.gas:
        figures.append(Figure("gas", "highest_gas_pressure", tables.gas.pressure.max(), "Pa"))
        messages += messages_on_gas(tables.gas)
    shapes = _shapes(prepared, cold, piston, block, chosen, valid)
    figures += _of_film(build, shapes)
    if walls := shapes.walls:
        ends = piston.body.skirt_lower, piston.body.skirt_upper
        figures += figures_of_walls(walls, shapes.pin_height, ends, shapes.bore_height)
        messages += messages_on_walls(prepared, chosen, valid, walls)
    messages += messages_on_shapes(build, shapes.walls is not None)
    messages += messages_on_profiles(build, tables, piston, block)
    messages += messages_on_fit(build, piston, block, chosen, shapes)
    remarks: list[str] = []
    texts = {"fault": wrong, "warning": warnings, "remark": remarks}
    for message in messages:
        texts[message.kind].append(message.text)
    return Preview(figures, wrong, warnings, remarks, lambda path: draw_shapes(shapes, path))


def _tried(
    look: Callable[[Build, list[str]], Look], build: Build, wrong: list[str], warnings: list[str]
) -> Look | None:
    """Return what a mesh or a file has, or None with its faults."""
    try:
        return look(build, warnings)
    except MeshFault as error:
        wrong += error.faults
    except (ValueError, MemoryError) as error:
        wrong.append(str(error))
    return None


def _eye(build: Build, warnings: list[str]) -> Eye | None:
    """Read the mesh of the rod's eye, if it is flexible."""
    film = eye_film(build)
    if not film:
        return None
    assert build.floating_pin and build.floating_pin.small_end
    options = build.floating_pin.small_end
    mesh = shell_mesh(options, film, SMALL_END, warnings.append)
    radius = film_shell(mesh, film).radius
    mass = rigid_mass(mesh.points, mesh.tets, options.density)[0, 0]
    source = f"of {len(mesh.points)} nodes, from the shank's cut on"
    modes = Figure("modes", "small_end_modes", options.modes, "1", "pressure_modes")
    return Eye(radius, [Figure("small_end", "mass", mass, "kg", source), modes])


def _piston(build: Build, warnings: list[str]) -> BodyPreview:
    """Return the piston, rigid."""
    options = build.piston
    if options.rigid:
        return BodyPreview(rigid_piston(options, build.grid))
    if options.reduced:
        skirt = None
        body = piston_about_pin(options, Path(options.reduced))
        try:
            skirt = load(MeshProperties, Path(options.reduced)).skirt
        except ValueError:  # a file without them
            warnings.append(f"{options.reduced}: does not say where the skirt is: film everywhere")
        return BodyPreview(body, skirt)
    mesh = read_body(options, warnings.append)
    placed = placed_piston(mesh, options, build.grid, None)
    films = boss_films(build)
    faults_of_modes(mesh, options, "pin_bore", "skirt", placed.angle, placed.height, films)
    tie = tie_of(mesh, options, films is not None) if options.modes else ""
    length = pin_layer(mesh, options.boss_length).length if tie == "sliding" else None
    if films:
        boss_readings(mesh, placed.position, films)
    body = placed.body.about(options.pin_offset)
    return BodyPreview(body, placed.skirt, mesh, tie, length)


def _block(build: Build, warnings: list[str]) -> BodyPreview:
    """Return the block, rigid."""
    options = build.block
    if options.rigid:
        return BodyPreview(rigid_block(options, build.grid))
    if options.reduced:
        return BodyPreview(load(ReducedBlock, Path(options.reduced)))
    mesh = read_body(options, warnings.append)
    placed = placed_block(mesh, options, build.grid)
    faults_of_modes(mesh, options, "bolts", "bore", placed.angle, placed.height)
    return BodyPreview(placed.body, None, mesh)


def _of_piston(build: Build, piston: BodyPreview) -> list[Figure]:
    body = piston.body
    centre = body.S / body.mass
    about_centre = body.I0 - body.mass * float(centre @ centre)
    source = "of a data sheet or a reduced body"
    if piston.mesh:
        source = f"of {len(piston.mesh.points)} nodes"
    figures = [
        Figure("piston", "mass", body.mass, "kg", source),
        Figure("piston", "centre_above_pin", centre[1], "m"),
        Figure("piston", "centre_from_pin", float(np.hypot(*centre)), "m", CENTRE_FROM_PIN),
        *_of_mesh("piston", piston),
        Figure("piston", "inertia", about_centre, "kg.m2", "about its centre of mass"),
        Figure("piston", "pin_offset", build.piston.pin_offset, "m"),
        Figure("skirt", "skirt_radius", body.radius, "m"),
        Figure("skirt", "skirt_length", body.skirt_upper - body.skirt_lower, "m"),
        Figure("skirt", "skirt_lower", body.skirt_lower, "m", "above the pin's axis"),
        Figure("skirt", "skirt_upper", body.skirt_upper, "m", "above the pin's axis"),
    ]
    if piston.boss_length is not None:
        note = "on the pin, from its inner end: compare, the skirt's compliance depends on it"
        figures.append(Figure("boss", "boss_length", piston.boss_length, "m", note))
    return [*figures, _modes_of("piston", build.piston, piston.tie)]


def _of_mesh(part: str, sized: BodyPreview) -> list[Figure]:
    """Return figures on the quality of a body's mesh, if it has tetrahedra."""
    if sized.mesh is None or not len(sized.mesh.tets):
        return []
    ratios = aspect_ratios(sized.mesh.points, sized.mesh.tets)
    worst = int(ratios.argmax())
    x, y, z = 1e3 * sized.mesh.points[sized.mesh.tets[worst, :4]].mean(axis=0)
    source = f"1 is regular; element {worst + 1} at ({x:.4g}, {y:.4g}, {z:.4g}) mm"
    figures = [Figure(part, "worst_aspect_ratio", float(ratios[worst]), "1", source)]
    return figures + _of_materials(part, sized.mesh)


def _of_materials(part: str, mesh: Mesh) -> list[Figure]:
    """Return the mass of each set of elements with its material, if there are several."""
    figures: list[Figure] = []
    material = mesh.material
    if material is None:
        return figures
    density_of = np.asarray(material.density)
    for name in material.names():
        rows = np.flatnonzero(material.name == name)
        young, poisson, density, expansion = (np.asarray(one)[rows[0]] for one in material[:4])
        source = f"{len(rows)} elements, {density:.4g} kg/m3, {1e-9 * young:.4g} GPa, {poisson:.3g}"
        if np.isfinite(expansion):
            source += f", {1e6 * expansion:.3g}e-6 1/K"
        mass = rigid_mass(mesh.points, mesh.tets[rows], density_of[rows])[0, 0]
        figures.append(Figure(part, f"mass_of_{name}", float(mass), "kg", source))
    return figures


def _of_films(
    prepared: BuildOptions, piston: BodyPreview, chosen: Parameters, given: dict[str, Any]
) -> list[Figure]:
    """Return the lengths of several film surfaces, and lengths and radii of those of pin and crank.

    Films of the skirt have no separate radius.
    """
    _, along = prepared.grid
    row = (piston.body.skirt_upper - piston.body.skirt_lower) / along
    sizes = [(one.name, (one.last - one.first) * row, None) for one in prepared.surfaces]
    if pin := prepared.floating_pin:
        radius = pin_radius(piston.body.radius, chosen)
        sizes += [(name, length, radius) for name, length in pin.lengths().items()]
    for one in prepared.crank_bearings:
        name = f"{one.name}_radius"
        radius = given.get(name, getattr(CRANK_PARAMETERS[one.name](), name))
        sizes.append((one.name, one.length, radius))
    figures = []
    for name, length, radius in sizes:
        figures.append(Figure(name, f"{name}.skirt_length", length, "m"))
        if radius is not None:
            figures.append(Figure(name, f"{name}.bore_radius", radius, "m"))
    return figures


def _axis(prepared: BuildOptions, given: dict[str, Any], build: Build) -> AxisParameters | None:
    """Return the parameters of a pin that tilts or bends, else None.

    It is also None if the positions of its bosses come from a mesh that is not reduced yet.
    """
    pin = prepared.floating_pin
    if pin is None or not pin.pin_shapes or (build.floating_pin and build.floating_pin.boss_modes):
        return None
    return parameters_from(AxisParameters, given)


def _of_axis(
    prepared: BuildOptions, piston: BodyPreview, chosen: Parameters, axis: AxisParameters
) -> list[Figure]:
    """Return the figures of a pin that tilts or bends."""
    assert prepared.floating_pin
    own, shapes = prepared.floating_pin, prepared.floating_pin.pin_shapes
    settings = settings_of(chosen, axis)
    beam = pin_beam(piston.body.radius, pin_span(own, None), shapes, settings)
    pin = beam.pin
    area = np.pi * (pin.radius**2 - pin.bore_radius**2)
    figures = [
        Figure("pin", "pin_length", pin.length, "m"),
        Figure("pin", "pin_density", pin.mass / (area * pin.length), "kg/m3"),
    ]
    if len(beam.omega) > 1:
        frequency = beam.omega[1] / (2 * np.pi)
        figures.append(Figure("pin", "pin_bending_frequency", frequency, "Hz", "of the free pin"))
    return figures


def _modes_of(name: str, body: Piston | Block, tie: str = "") -> Figure:
    """Return the number of modes, or the expected error that chooses it, and the tie of a mesh."""
    if body.rigid or not body.modes:
        return Figure("modes", f"{name}_modes", 0, "1", "rigid")
    entry = "expected_error" if isinstance(body.modes, float) else "modes"
    source = f"{body.basis}, tie {tie}" if tie else body.basis
    return Figure("modes", f"{name}_{entry}", body.modes, "1", source)


def _of_block(build: Build, block: BodyPreview) -> list[Figure]:
    body = block.body
    return [
        *_of_mesh("block", block),
        Figure("bore", "bore_radius", body.radius, "m"),
        Figure("bore", "bore_lower", body.heights[0], "m", "above the crank axis"),
        Figure("bore", "bore_upper", body.heights[-1], "m", "above the crank axis"),
        _modes_of("block", build.block),
    ]


def _of_mechanism(
    build: Build, block: BodyPreview, chosen: Parameters, speed: float | None
) -> list[Figure]:
    lowest, highest = stroke_of(build.piston.pin_offset, chosen)
    stroke = highest - lowest
    figures = [
        Figure("crank", "crank_radius", chosen.crank_radius, "m"),
        Figure("crank", "rod_length", chosen.rod_length, "m"),
        Figure("crank", "stroke", stroke, "m", "of the pin"),
        Figure("crank", "swept_volume", np.pi * block.body.radius**2 * stroke, "m3"),
    ]
    if speed is not None and build.speed is None:
        mean = stroke * speed / np.pi
        figures.append(Figure("crank", "mean_piston_speed", mean, "m/s"))
    return figures


def stroke_of(pin_offset: float, chosen: Parameters) -> tuple[float, float]:
    """Return the lowest and highest position of A above the crank axis [m].

    Eq. (K10):  Y = sqrt((L +- r)^2 - e^2)      e = pin offset - crank offset

    A rod that is too short, which `faults` names, ends at the crank axis.
    """
    offset = pin_offset - chosen.crank_offset
    reach = chosen.rod_length + chosen.crank_radius * np.array([-1.0, 1.0])
    lowest, highest = np.sqrt(np.maximum(reach**2 - offset**2, 0.0))  # Eq. (K10)
    return float(lowest), float(highest)


def _of_heat(name: str, shape: HotShape) -> list[Figure]:
    """Return the figures of a hot shape, and its rigid motion."""
    part = "skirt" if name == "piston" else "bore"
    least, most = 1e6 * shape.radial.min(), 1e6 * shape.radial.max()
    shift = ", ".join(f"{1e6 * one:.3g}" for one in shape.motion[:3])
    turn = ", ".join(f"{1e6 * one:.3g}" for one in shape.motion[3:])
    stays = "of the pin bores is taken out" if name == "piston" else "is contained"
    text = (
        f"mean of {least:.4g} to {most:.4g} um; the rigid motion ({shift}) um, ({turn}) urad "
        f"along and about x, y, z {stays}"
    )
    figures = [Figure(part, f"{part}_hot_growth", float(shape.radial.mean()), "m", text)]
    if name == "piston":
        longer = shape.upper - shape.lower
        figures.append(Figure(part, "skirt_lengthening", longer, "m", "part of skirt_length"))
    return figures


def _shapes(
    prepared: BuildOptions,
    without_heat: BuildOptions,
    piston: BodyPreview,
    block: BodyPreview,
    chosen: Parameters,
    given: dict[str, Any],
) -> Shapes:
    """Return skirt and bore, cold and hot, on the film grid and along the bore."""
    body = piston.body
    angle, height = cell_centres(*prepared.grid, body.skirt_lower, body.skirt_upper)
    cold = replace(chosen, **dict.fromkeys(COLD, 0.0))
    heights = block.body.heights
    straight = np.zeros((len(angle), len(heights)))
    grid, ends = (angle, height, heights), (body.skirt_lower, body.skirt_upper)
    radii = Radii(body.radius, block.body.radius)
    walls = warm_walls(prepared, chosen, given, grid, ends, radii)
    skirt_growth, bore_growth = (walls.skirt_growth, walls.bore_growth) if walls else (0.0, 0.0)
    return Shapes(
        angle=angle,
        height=height,
        film=_with_a_film(prepared, piston),
        skirt_cold=skirt_gap(body, angle, height, without_heat.piston, cold),
        skirt_hot=skirt_gap(body, angle, height, prepared.piston, chosen) - skirt_growth,
        bore_height=heights,
        bore_cold=bore_shape(heights, angle, without_heat.block, cold) + straight,
        bore_hot=bore_shape(heights, angle, prepared.block, chosen) + straight + bore_growth,
        pin_height=np.linspace(*stroke_of(prepared.piston.pin_offset, chosen), PISTON_POSITIONS),
        walls=walls,
    )


def _with_a_film(prepared: BuildOptions, piston: BodyPreview) -> np.ndarray:
    """Return the cells of the film grid on a film surface and with the skirt under them."""
    film = np.zeros(prepared.grid, dtype=bool)
    for one in prepared.film_surfaces():
        film[:, one.first : one.last] = True
    return film if piston.skirt is None else film & piston.skirt


def _of_film(build: Build, shapes: Shapes) -> list[Figure]:
    around, along = build.grid
    figures = [
        Figure("film", "cells_around", around, "1"),
        Figure("film", "cells_along", along, "1"),
        Figure("film", "covered_share", float(shapes.film.mean()), "1", "cells with a skirt"),
    ]
    for hot, name in ((False, "clearance_cold"), (True, "clearance_hot")):
        least = narrowest(shapes, hot)
        where = f"narrowest, at {least.angle:.4g} deg, {1e3 * least.height:.3g} mm above the pin"
        figures.append(Figure("clearance", name, least.gap, "m", where))
    return figures
