"""Material of each element: from the mesh file, from the case by element set, or of the body."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from .deck import MeshFault, entry
from .element import Value


class Range(NamedTuple):
    """Allowed range of a property and its unit."""

    least: float
    most: float
    unit: str


RANGES = {
    "young": Range(1e8, 1e12, "Pa"),
    "poisson": Range(0.0, 0.5 - 1e-9, "1"),
    "density": Range(500.0, 25e3, "kg/m^3"),
    "expansion": Range(0.0, 1e-4, "1/K"),
}
"""Properties of a material with their ranges in SI."""
NEEDED = ("young", "poisson", "density")
INCHES = (0.0254, 0.3048)
POUND = 4.4482216152605
"""Force of one pound [N], the unit of force of a mesh file in inches or feet."""
UNSTATED = ("", "none")
"""Material of the elements of a file that have none."""
OTHERS = "no set"
"""Name of the elements that neither the file nor the case puts into a set with a material."""
EQUAL_TOLERANCE = 1e-6
"""Relative difference below which two values are the same."""


class ElementSets(NamedTuple):
    """Sets of elements of a mesh file, and its materials.

    Parameters
    ----------
    members : dict of str to ndarray of int
        Rows of the elements of each part or named set.
    materials : sequence of str
        Material of each element, empty if the file does not state it.
    properties : dict of str to dict of str to float
        Properties of each material in the units of the file.
    length : float
        Length of the file's unit [m].
    """

    members: Mapping[str, np.ndarray] = {}
    materials: Sequence[str] = ()
    properties: Mapping[str, Mapping[str, float]] = {}
    length: float = 1.0


class Material(NamedTuple):
    """Material of a body or of each of its elements.

    Parameters
    ----------
    young, poisson, density, expansion : float or ndarray, shape (e,)
        [Pa], [-], [kg/m3], [1/K]; the expansion is nan if it is not known.
    name : ndarray of str, shape (e,)
        Set of each element; empty for one material.
    """

    young: Value
    poisson: Value
    density: Value
    expansion: Value
    name: np.ndarray = np.empty(0, dtype=str)

    def names(self) -> list[str]:
        """Return the names of the sets; none for one material."""
        return sorted(set(self.name.tolist()))


def units_of(length: float) -> dict[str, float]:
    """Return the SI values of the units of a file with consistent units.

    Eq. (M23):  stress F/L^2,  density F T^2/L^4

    L is the length unit, T the second, and F the newton, or the pound-force with inches or feet.

    Parameters
    ----------
    length : float
        L [m].
    """
    force = POUND if any(abs(length / one - 1) < EQUAL_TOLERANCE for one in INCHES) else 1.0
    stress, density = force / length**2, force / length**4  # Eq. (M23)
    return {"young": stress, "poisson": 1.0, "density": density, "expansion": 1.0}


def replacement_remarks(sets: ElementSets, values: Mapping[str, float | None]) -> list[str]:
    """Return a sentence if values of the case for the body differ from those of the file."""
    units = units_of(sets.length)
    used = sorted({*sets.materials} - {*UNSTATED})
    changed = [
        key
        for key, value in values.items()
        if value is not None
        and any(
            key in sets.properties.get(name, {})
            and abs(sets.properties[name][key] * units[key] - value) > EQUAL_TOLERANCE * value
            for name in used
        )
    ]
    several = [f"{sets.materials.count(name)} elements of {name}" for name in used]
    if changed:
        return [
            f"{', '.join(changed)} of the case replace those of the file in "
            f"{', '.join(several)}; omit them to use those of the file"
        ]
    if len(used) > 1 and any(value is not None for value in values.values()):
        return [
            f"{len(used)} materials ({', '.join(several)}) get the same "
            f"{', '.join(key for key, value in values.items() if value is not None)} of the case"
        ]
    return []


def material_of(
    sets: ElementSets,
    count: int,
    values: Mapping[str, float | None],
    tables: Mapping[str, Mapping[str, float | None]],
    where: str = "",
    needed: Sequence[str] = NEEDED,
) -> Material:
    """Return the material of a mesh.

    A property of an element is that of its set in `tables`, else that of the body in `values`, else
    that of its material in the file.

    Parameters
    ----------
    sets : ElementSets
    count : int
        Number of elements e.
    values : dict of str to float or None
        Properties of all elements in SI.
    tables : dict of str to dict of str to float or None
        Properties by element set, or by name of a material in the file, in SI.
    where : str
        Begins each fault.
    needed : sequence of str
        Properties that each element must have.

    Raises
    ------
    MeshFault
        If a set is not known, two sets share elements, or an element lacks a value or has one
        outside its range.
    """
    stated = [OTHERS if one in UNSTATED else one for one in sets.materials]
    name = np.array(stated or [OTHERS] * count, dtype=object)
    in_file = {one: name == one for one in sorted({*stated} - {OTHERS})}
    units = units_of(sets.length)
    table = {key: np.full(count, np.nan) for key in RANGES}
    for one, rows in in_file.items():
        for key, value in sets.properties.get(one, {}).items():
            table[key][rows] = value * units[key]
    for key, value in values.items():
        if value is not None:
            table[key][:] = value
    faults = []
    taken = np.zeros(count, dtype=bool)
    for one, entries in tables.items():
        rows = entry(sets.members, one)
        rows = entry(in_file, one) if rows is None else np.isin(np.arange(count), rows)
        if rows is None:
            known = ", ".join([*sets.members, *in_file][:12]) or "none"
            faults.append(f"{where}materials.{one}: expected a set of elements of {known}")
            continue
        if shared := int((rows & taken).sum()):
            faults.append(
                f"{where}materials.{one}: expected a set without elements of the others, got "
                f"{shared} shared elements"
            )
        taken |= rows
        name[rows] = one
        for key, value in entries.items():
            if value is not None:
                table[key][rows] = value
    faults = faults or _faults(name, table, where, sets.length, needed)
    if faults:
        raise MeshFault(faults)
    kinds = np.unique(np.nan_to_num(np.stack(list(table.values())), nan=-1.0), axis=1)
    if kinds.shape[1] == 1:
        young, poisson, density, expansion = (float(table[key][0]) for key in Material._fields[:-1])
        return Material(young, poisson, density, expansion)
    each = (table[key] for key in Material._fields[:-1])
    return Material(*each, name=name.astype(str))


def _faults(name, table, where, length, needed):
    """Return a sentence for each property of a set that is missing or out of its range."""
    faults = []
    for one in sorted(set(name)):
        rows = name == one
        for key, (least, most, unit) in RANGES.items():
            value = table[key][rows]
            missing = int(np.isnan(value).sum())
            wrong = value[(value < least) | (value > most)]
            if missing and key in needed:
                got = f"nothing for {missing} elements"
                hint = f"give {key}" + ("" if one == OTHERS else f" or materials.{one}.{key}")
            elif wrong.size:
                got = f"{wrong[0]:.4g} {unit}"
                hint = f"the file has consistent units with a length of {length:g} m, see mesh_unit"
            else:
                continue
            faults.append(
                f"{where}{key} of {one}: expected {least:g} to {most:g} {unit}, got {got}; {hint}"
            )
    return faults
