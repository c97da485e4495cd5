"""Export of recorded fields as CSV: all, one line, one instant or one grid point.

Surfaces and collections of films are for ParaView.
"""

import csv
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..case.shown import NEUTRAL
from ..fmi.errors import BadInput, unknown
from .instants import crank_angle


@dataclass(frozen=True)
class ExportedField:
    """One quantity over instants and grid points.

    Parameters
    ----------
    name, unit : str
    times : ndarray, shape (t,)
        [s]
    i, j : ndarray of int, shapes (a,), (b,)
        1-based indices along both sides of the grid.
    values : ndarray, shape (t, a, b)
    """

    name: str
    unit: str
    times: np.ndarray
    i: np.ndarray
    j: np.ndarray
    values: np.ndarray


def read_block(results, port):
    """Return a recorded field; raise `BadInput` if it was not recorded or has not two indices."""
    if port not in results.recorded:
        hint = "name it in record.fields of the case"
        raise BadInput(f"field: {unknown('field', port, results.recorded, hint)}")
    dataset = results.dataset(port)
    if dataset.ndim != 3:
        raise BadInput(f"{port}: expected a field of two indices, got shape {dataset.shape[1:]}")
    i, j = (np.arange(1, size + 1) for size in dataset.shape[1:])
    return ExportedField(
        name=port, unit=dataset.attrs["unit"], times=results.instants, i=i, j=j, values=dataset[:]
    )


def chosen(block, time=None, i=None, j=None):
    """Return the part of a block at the instant nearest to `time` [s], on line i, on line j.

    i and j are 1-based. None selects all.
    """
    faults = [
        f"{axis}: expected 1 to {len(line)}, got {index}"
        for axis, index, line in (("i", i, block.i), ("j", j, block.j))
        if index is not None and not 1 <= index <= len(line)
    ]
    if faults:
        raise BadInput(faults)
    if time is not None:
        k = int(np.abs(block.times - time).argmin())
        block = replace(block, times=block.times[k : k + 1], values=block.values[k : k + 1])
    if i is not None:
        block = replace(block, i=block.i[i - 1 : i], values=block.values[:, i - 1 : i])
    if j is not None:
        block = replace(block, j=block.j[j - 1 : j], values=block.values[:, :, j - 1 : j])
    return block


class Positions(NamedTuple):
    """Positions of a block's values by one measure.

    positions : shape that broadcasts to (t, a, b).
    """

    name: str
    unit: str
    positions: np.ndarray


def grid_positions(case, results, block):
    """Return the crank angle of a block's instants and the positions of its grid points.

    The positions are along the case's axes of the field. Unknown ones are omitted.
    """
    positions = []
    if crank := crank_angle(results):
        angle = np.degrees(np.interp(block.times, crank.time, crank.angle))
        positions.append(Positions("crank angle", "deg", angle[:, None, None]))
    axes = case.axes_of(block.name)
    if axes is not NEUTRAL:
        around, along = results.dataset(block.name).shape[1:]
        first = axes.first.positions(around)[block.i - 1]
        second = axes.second.positions(along)[block.j - 1]
        positions.append(Positions(axes.first.label, axes.first.unit or "1", first[None, :, None]))
        positions.append(
            Positions(axes.second.label, axes.second.unit or "1", second[None, None, :])
        )
    return positions


def write_csv(blocks, path, positions=()):
    """Write a row for each instant and grid point: time, i, j, positions and quantities.

    Raises `BadInput` for fields on different grids.
    """
    if len({block.values.shape for block in blocks}) > 1:
        names = ", ".join(block.name for block in blocks)
        raise BadInput(f"--field: expected fields on one grid, got {names}")
    times, i, j = np.meshgrid(blocks[0].times, blocks[0].i, blocks[0].j, indexing="ij")
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(
            [
                *("time [s]", "i", "j"),
                *(f"{one.name} [{one.unit}]" for one in positions),
                *(f"{block.name} [{block.unit}]" for block in blocks),
            ]
        )
        shape = times.shape
        columns = [np.broadcast_to(one.positions, shape).ravel().round(9) for one in positions]
        writer.writerows(
            zip(
                *(times.ravel(), i.ravel(), j.ravel(), *columns),
                *(block.values.ravel() for block in blocks),
            )
        )


def cylinder_cells(shape, radius, ends):
    """Return corners and cells of fields on a cylinder about y between two heights [m].

    The order is that of a field's values: index i around from +z towards +x, j along y.
    """
    from_z = shape[0] / 4 - shape[0] // 4 - 0.5
    points, cells = _shell(shape, radius, ends, from_z)
    return points[:, [1, 2, 0]], cells


def pin_cells(shape, radius, ends):
    """Return corners and cells of fields in a shell about z, between two heights [m].

    The order is that of a field's values: cell i centred at 2 pi (i - 1)/n from x towards y, j
    along z.
    """
    return _shell(shape, radius, ends, -0.5)


def _shell(shape, radius, ends, first):
    """Return corners and cells, n around and m along the third axis, from index `first` on."""
    n, m = shape
    low, high = ends
    angle = 2 * np.pi * (np.arange(n) + first) / n  # beginning of the cells
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(n)])
    points = np.vstack([ring + [0, 0, z] for z in np.linspace(low, high, m + 1)])
    a, b = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    after = (a + 1) % n
    corners = [b * n + a, b * n + after, (b + 1) * n + after, (b + 1) * n + a]
    return points, np.stack(corners, axis=-1).reshape(-1, 4)


def write_collection(entries, path):
    """Write a .pvd file of (time [s], number of the part, VTU file below its folder)."""
    lines = [
        f'    <DataSet timestep="{time!r}" '
        f'file="{file.relative_to(path.parent).as_posix()}" part="{part}"/>'
        for time, part, file in entries
    ]
    path.write_text(
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        + "\n".join(lines)
        + "\n  </Collection>\n</VTKFile>\n"
    )
    return path
