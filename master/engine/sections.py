"""Sections of a piston's report in addition to the case's pictures, from recorded data only.

They show strokes, motion of the skirt's edges, forces and friction by side, films and their
minimum, and envelopes.
"""

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ..case.contract import players
from ..case.schema import Case
from ..results.charts import (
    DASHES,
    Chart,
    Curve,
    CyclePhase,
    Dash,
    Drawn,
    Section,
    StillMap,
)
from ..results.file import Results
from ..results.instants import crank_angle
from ..results.report import FilmView, Orbit, Special
from ..results.solids import Solid, Stand
from ..results.words import scaled
from .crank_drive import crank_drive
from .friction import friction_pressures
from .impacts import impacts
from .places import film_body, film_surface, gap_port, parameter
from .stands import stands
from .surfaces import at_instants

STROKES = ("expansion", "exhaust", "intake", "compression")
"""Strokes from firing top dead centre, 180 deg each."""
LEAST_LOAD = 0.05
"""Minimum radial load for a friction coefficient, relative to the largest one of the run."""
CRANK = "crank angle [deg]"
MOTION = ("lateral_displacement", "piston_position", "rocking_angle")
"""Outputs that move a piston on the page."""

Runs = dict[str, Results]


CHARTS = tomllib.loads((Path(__file__).parent / "templates/charts.toml").read_text("utf-8"))
"""Charts over the crank angle, by section; the head of the file explains them."""


def special(
    case: Case,
    runs: Runs,
    skins: Mapping[str, Mapping[str, Sequence[Any]]] = MappingProxyType({}),
) -> Special:
    """Return sections, strokes, films and bodies of a piston's runs; empty for other runs.

    Parameters
    ----------
    case : Case
    runs : dict of str to Results
    skins : dict of str to dict of str to sequence of fmu_mfbd.offline.Skin, optional
        Label -> participant with the role `bodies` -> surfaces of its piston and block.
    """
    first = next(iter(runs.values()))
    bodies, films = (players(first.case, role) for role in ("bodies", "lubrication"))
    if not bodies or not films or any(crank_angle(results) is None for results in runs.values()):
        return Special()
    body_of = {film: film_body(first, film) or bodies[0] for film in films}
    parts = [(body, body, len(bodies), _of_body(runs, body, skins, body_of)) for body in bodies]
    for film in films:
        own = _of_film(case, runs, body_of[film], film)
        parts.append((film, body_of[film], len(films), own))
    sections = [
        _named(section, name, runs, bodies, body) if several > 1 else section
        for name, body, several, own in parts
        for section in own
    ]
    sections.append(Section("Friction over the periods", _cycles(runs)))
    return Special(
        sections=[section for section in sections if section.drawn],
        phases=strokes(runs),
        films=[_view(runs, body_of[film], film, len(films)) for film in films],
        solids={
            label: [
                solid
                for body, own in parts.items()
                for solid in _solids(own, runs[label], body, bodies)
            ]
            for label, parts in skins.items()
        },
    )


def is_fired(runs: Runs) -> bool:
    """Return whether a run has gas pressure in a cylinder."""
    return any(
        results.series(port).values.any()
        for results in runs.values()
        for port in results.ports
        if port.endswith(".cylinder_pressure")
    )


def _view(runs, body, film, films) -> FilmView:
    """Return the maps, curves and orbit of a film. Bearings have an orbit instead of motion."""
    first = next(iter(runs.values()))
    layers = {
        "pressure": f"{film}.pressure",
        "thickness": gap_port(first, film),
        "fraction": f"{film}.film_fraction",
        "contact": f"{film}.asperity_pressure",
    }
    bearing = _is_bearing(runs, film)
    own = "view_of_bearing" if bearing else "view_of_skirt"
    charts = _charts(runs, "view", own, body=body, film=film)
    orbit = _orbit(runs, body, film_surface(first, film).rstrip(".")) if bearing else None
    return FilmView(film if films > 1 else "Film", layers, charts, orbit)


def _orbit(runs, body, surface) -> Orbit | None:
    """Return the orbit of a bearing, or None if the runs lack its displacements or clearance."""
    name = "pin" if surface.startswith("boss") else surface
    ports = [f"{body}.{name}_displacement_{axis}" for axis in "xy"]
    key = f"{surface.partition('_')[0] if name == 'pin' else name}_clearance"
    clearance = parameter(next(iter(runs.values())), body, key, "m")
    if not clearance or not all({*ports} <= {*results.ports} for results in runs.values()):
        return None
    paths = [
        tuple(1e6 * results.series(port).values for port in ports) for results in runs.values()
    ]
    at = [_degrees(results) for results in runs.values()]
    return Orbit(1e6 * clearance, at, paths)


def _of_body(runs, body, skins, body_of) -> list[Section]:
    """Return motion and forces of a piston."""
    own = [one for parts in skins.values() for one in parts.get(body, ())]
    skirt = next((skin.skirt for skin in own if skin.skirt), None)
    films = [film for film, owner in body_of.items() if owner == body]
    if skirt is None:
        motion = _charts(runs, "pin_eccentricity", body=body)
    else:
        motion = _eccentricity(runs, body, skirt)
    forces = []
    for film in films:
        of = "the film" if len(films) == 1 else film
        forces += _charts(runs, "radial_force", film=film, of=of)
    return [
        Section(
            "Motion of the piston",
            [*motion, *_charts(runs, "motion", body=body), *_slaps(runs, body)],
        ),
        Section("Forces", [*forces, *_charts(runs, "forces", body=body)]),
    ]


def _named(section, name, runs, bodies, body):
    """Return a section with a name in its title, and with the strokes of its cylinder."""
    title = f"{section.title}: {name}"
    if body == bodies[0]:
        return replace(section, title=title)
    text = f"The crank angle is that of {bodies[0]}, the strokes are those of {body}."
    own = own_strokes(runs, body)
    if own is None:
        text = f"The crank angle is that of {bodies[0]}; runs differ by the strokes of {body}."
    return replace(section, title=title, text=text, phases=own or ())


def _of_film(case, runs, body, film) -> list[Section]:
    """Return the sections of a film."""
    gap = gap_port(next(iter(runs.values())), film)
    bearing = _is_bearing(runs, film)
    kind = "bearing" if bearing else "skirt"
    friction = _charts(runs, f"friction_of_{kind}", film=film)
    thickness = _charts(runs, f"film_of_{kind}", "film_pressure", film=film)
    return [
        Section("Friction", [*friction, *([] if bearing else _stribeck(runs, body, film))]),
        Section("Film", [*thickness, *_place_of_thinnest(case, runs, gap)]),
        Section("Oil", _charts(runs, "oil", film=film)),
        _envelopes(case, runs, film, gap),
    ]


def _solids(skins, results, body, bodies) -> list[Solid]:
    """Return piston and block at the recorded instants, then pin, rod and crank.

    Bodies whose modal coordinates were not recorded are undeformed.
    """
    owner = body if len(bodies) > 1 else ""
    stand = stands(results).get(body, Stand())
    port = f"{body}.modal_coordinate"
    modes = [skin.modes.shape[2] for skin in skins]
    coordinates = np.zeros((len(results.instants), 0))
    if port in results.recorded and results.dataset(port).shape[1] == sum(modes):
        coordinates = results.dataset(port)[:]
    known = coordinates.shape[1] == sum(modes)
    modes = modes if known else [0] * len(skins)
    parts = np.split(coordinates, np.cumsum(modes)[:-1], axis=1)
    motion = np.column_stack([at_instants(results, f"{body}.{name}") for name in MOTION])
    meshed = [
        Solid(
            name=skin.name,
            points=skin.points,
            triangles=skin.triangles,
            modes=skin.modes[:, :, : part.shape[1]],
            coordinates=part,
            motion=motion if skin.skirt else None,
            film=skin.skirt,
            stress=skin.von_mises(part) if part.shape[1] else None,
            fields=fields_around(results, body, skin.skirt) if skin.skirt else {},
            owner=owner,
            held=known,
            stand=stand,
        )
        for skin, part in zip(skins, parts)
    ]
    return [*meshed, *crank_drive(results, body, owner, motion)]


def fields_around(results, body, skirt) -> dict[str, tuple[float, float]]:
    """Return the recorded fields around a piston's skirt with their lower and upper heights [m].

    The heights are those of the whole skirt, or of the rows of a film surface in the case's
    build table. Fields of a pin's films are not included.
    """
    build = results.case["participants"][body].get("build", {})
    low, high = skirt
    heights = {"": (low, high), "skirt.": (low, high)}
    for surface in build.get("film_surfaces", ()):
        _, rows = build["grid"]
        first, last = surface["rows"]
        step = (high - low) / rows
        heights[f"{surface['name']}."] = (low + (first - 1) * step, low + last * step)
    fields = {}
    for film in players(results.case, "lubrication"):
        if film_body(results, film) not in (body, None):
            continue
        ends = heights.get(film_surface(results, film))
        gap = gap_port(results, film).removesuffix("film_thickness")
        for port in results.recorded:
            if ends and port.startswith((f"{film}.", gap)):
                fields[port] = ends
    return fields


def strokes(runs: Runs, ahead: float = 0.0) -> list[CyclePhase]:
    """Return the strokes of the runs. Runs without gas pressure have dead centres only.

    0 deg is firing top dead centre, a cycle is 720 deg. The crank angle of the cylinder is that
    of the abscissa minus `ahead` [deg].
    """
    fired = is_fired(runs)
    spans = [_degrees(results)[[0, -1]] - ahead for results in runs.values()]
    first = int(np.floor(min(low for low, _ in spans) / 180.0 + 1e-9))
    last = int(np.ceil(max(high for _, high in spans) / 180.0 - 1e-9))
    return [
        CyclePhase(
            180.0 * k + ahead,
            180.0 * (k + 1) + ahead,
            STROKES[k % 4] if fired else "",
            ("" if k % 4 else "firing TDC") if fired else ("TDC", "BDC")[k % 2],
        )
        for k in range(first, last)
    ]


def own_strokes(runs: Runs, body: str) -> list[CyclePhase] | None:
    """Return the strokes of a cylinder over the crank angle of the first one.

    Returns None if the runs have different strokes.
    """
    distinct = {
        round(float(_degrees(results)[0] - np.degrees(results.series(port).values[0])), 3)
        for results in runs.values()
        if (port := f"{body}.crank_angle") in results.ports
    }
    return strokes(runs, distinct.pop()) if len(distinct) == 1 else None


def _degrees(results):
    crank = crank_angle(results)
    assert crank is not None  # checked in `special`
    return np.degrees(crank.angle)


def _charts(runs: Runs, *sections: str, **names: str) -> list[Chart]:
    """Return the charts of sections over the crank angle, without those that are zero."""
    charts = []
    for entry in (chart for section in sections for chart in CHARTS[section]):
        lines = {name: port.format(**names) for name, port in entry["lines"].items()}
        if curves := _curves(runs, lines, entry["unit"]):
            title = entry["title"].format(**names)
            charts.append(Chart(title, CRANK, f"[{entry['unit']}]", curves, cursor=True))
    return charts


def _curves(runs: Runs, lines: dict[str, str], unit: str) -> list[Curve]:
    """Return a curve for each run and port that is not zero in all runs."""
    target_unit = None if unit == "-" else unit
    known = [(results, {*results.ports}) for results in runs.values()]
    drawn: list[tuple[Dash, str, str]] = [
        (dash, name, port)
        for dash, (name, port) in zip(DASHES, lines.items())
        if any(port in ports and results.series(port).values.any() for results, ports in known)
    ]
    curves = []
    for k, (label, (results, ports)) in enumerate(zip(runs, known)):
        for dash, name, port in drawn:
            if port in ports:
                title = label if len(lines) == 1 else f"{label}, {name}"
                series = results.series(port)
                shown, _ = scaled(series.values, series.unit, target_unit)
                curves.append(Curve(title, k, _degrees(results), shown, dash))
    return curves


def _points(runs: Runs, points: Callable, title: str, x: str, y: str, **how: Any) -> list[Drawn]:
    """Return a chart of the points (x, y) of each run; `points` returns None if it has none."""
    point_lists = [points(results) for results in runs.values()]
    curves = [
        Curve(label, k, *one, points=True)
        for k, (label, one) in enumerate(zip(runs, point_lists))
        if one is not None
    ]
    drawn: list[Drawn] = [Chart(title, x, y, curves, **how)]
    return drawn if curves else []


def _slaps(runs, body) -> list[Drawn]:
    """Return a chart of the energy that the piston loses in each impact."""

    def lost(results):
        events = impacts(results, body)
        if events is None:
            return None
        rows = [impact.row for impact in events]
        return _degrees(results)[rows], 1e3 * np.array([impact.loss for impact in events])

    title = "Energy of the piston lost in each impact"
    return _points(runs, lost, title, CRANK, "[mJ]", cursor=True)


def _eccentricity(runs, body, skirt) -> list[Drawn]:
    """Return a chart of the displacement of the skirt's edges.

    Eq. (X14):  e(y) = x_A - beta y      y above the pin's axis, beta the rocking angle about +z
    """
    ports = f"{body}.lateral_displacement", f"{body}.rocking_angle"
    curves = []
    for k, (label, results) in enumerate(runs.items()):
        if not {*ports} <= {*results.ports}:
            continue
        displacement, tilt = (results.series(port).values for port in ports)
        for dash, name, height in zip(DASHES, ("lower edge", "upper edge"), skirt):
            shown = 1e6 * (displacement - tilt * height)  # Eq. (X14)
            curves.append(Curve(f"{label}, {name}", k, _degrees(results), shown, dash))
    title = "Eccentricity of the skirt's edges, positive towards thrust"
    return [Chart(title, CRANK, "[µm]", curves, cursor=True)] if curves else []


def _is_bearing(runs, film):
    """Return whether the friction of a film is a torque."""
    return any(f"{film}.friction_torque" in results.ports for results in runs.values())


def _cycles(runs) -> list[Drawn]:
    """Return a chart of the FMEP of every whole period shown, if there are several."""

    def cycles(results):
        ends, pressures = np.array(friction_pressures(results)).reshape(-1, 2).T
        return (np.degrees(ends), 1e-3 * pressures) if len(ends) > 1 else None

    title = "Friction mean effective pressure of every period"
    return _points(runs, cycles, title, "end of the period, crank angle [deg]", "[kPa]")


def _stribeck(runs, body, film) -> list[Drawn]:
    """Return a chart of the friction coefficient over the bearing number of the skirt.

    Steps with a small load are omitted.

    Eq. (X17):  f = |F_film + F_contact| / W,   S = mu |v| L / W
                W is the sum of the radial forces on both sides, mu the oil's viscosity in the case,
                v the piston's speed, L the length of the skirt
    """
    ports = [
        f"{film}.friction_force_hydrodynamic",
        f"{film}.friction_force_asperity",
        f"{film}.radial_force_thrust_side",
        f"{film}.radial_force_anti_thrust_side",
        f"{body}.piston_velocity",
    ]

    def coefficients(results):
        viscosity = parameter(results, film, "viscosity", "Pa.s")
        scale = viscosity * parameter(results, film, "skirt_length", "m")
        if not scale or not {*ports} <= {*results.ports}:
            return None
        hydrodynamic, contact, thrust, anti, speed = (results.series(port).values for port in ports)
        load = np.abs(thrust) + np.abs(anti)
        carries = load > LEAST_LOAD * load.max()
        # Eq. (X17)
        number = scale * np.abs(speed[carries]) / load[carries]
        return 1e6 * number, np.abs(hydrodynamic + contact)[carries] / load[carries]

    title = f"Friction coefficient, steps with more than {100 * LEAST_LOAD:g} % of the largest load"
    x = "viscosity x speed x skirt length / load [1e-6]"
    return _points(runs, coefficients, title, x, "[-]", logarithmic=True)


def _place_of_thinnest(case, runs, port) -> list[Drawn]:
    """Return charts of angle and height of the thinnest film at every recorded instant."""
    axes = case.axes_of(port)

    def positions(k, axis, results):
        if port not in results.recorded:
            return None
        values, exists = results.dataset(port)[:], results.existing_cells(port)
        values = values if exists is None else np.where(exists, values, np.inf)
        flat = values.reshape(len(values), -1).argmin(axis=1)
        cells = np.unravel_index(flat, values.shape[1:])[k]
        at = np.interp(results.instants, results.time, _degrees(results))
        return at, axis.positions(values.shape[1 + k])[cells]

    drawn = []
    for k, axis in enumerate((axes.first, axes.second)):
        title = f"Position of the minimum film thickness: {axis.label}"
        options = dict(cursor=True, around=axis.centred is not None)
        of_axis = partial(positions, k, axis)
        drawn += _points(runs, of_axis, title, CRANK, f"[{axis.unit or '-'}]", **options)
    return drawn


def _envelopes(case, runs, film, gap):
    envelopes = (
        ("Maximum pressure of the last period", "MPa", f"{film}.pressure"),
        ("Minimum film thickness of the last period", "µm", gap),
        ("Maximum contact pressure of the last period", "MPa", f"{film}.asperity_pressure"),
    )
    drawn: list[Drawn] = []
    for title, unit, port in envelopes:
        known = [results.envelope(port) for results in runs.values()]
        fields = [None if one is None else scaled(one.values, one.unit, unit)[0] for one in known]
        if any(np.any(values) for values in fields if values is not None):
            cells = [one and run.existing_cells(port) for one, run in zip(known, runs.values())]
            drawn.append(StillMap(title, unit, case.axes_of(port), fields, cells))
    pressures = {label: results.envelope(f"{film}.pressure") for label, results in runs.items()}
    sparse = [label for label, one in pressures.items() if one and not one.every_step]
    text = "The envelopes hold every accepted macro step of the last period."
    if sparse:
        text += f" The envelopes of {', '.join(sparse)} hold recorded instants only."
    return Section("Envelopes", drawn, text)
