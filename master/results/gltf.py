"""Bodies in motion as one binary glTF 2.0 file that any viewer of the format plays. A body that
deflects or has a film is a mesh for each instant, which is visible for a frame.
"""

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.ndimage import map_coordinates

from ..fmi.errors import BadInput
from .figures import COLOURS
from .file import Results
from .pictures import colour_norm
from .solids import Solid

RATE = 30
"""Frames shown in a second."""
FLOAT, UNSIGNED, BYTE = 5126, 5125, 5121
VERTICES, INDICES = 34962, 34963
METAL = np.array([0.68, 0.72, 0.76])
"""Linear colour of a body."""
OUTER = 0.97
"""Points of the skirt have at least this fraction of the largest radius of the piston."""
VIEW = np.radians(40.0)
"""Angle of the viewer from the pin axis towards the thrust side [rad]."""
_TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


class Painted(NamedTuple):
    """A field that colours the skirt: values, shape (instants, around, along), and the heights
    between which it lies [m].
    """

    values: np.ndarray
    ends: tuple[float, float]


def painted_skirts(
    results: Results, solids: Sequence[Solid], fields: Sequence[str], chosen: np.ndarray
) -> dict[str, list[Painted]]:
    """Return the fields that colour each body at chosen instants, by its title; default: pressures
    of the films on it.
    """
    found: dict[str, list[Painted]] = {}
    for solid in solids:
        ports = [port for port in results.recorded if port.endswith(".pressure")]
        for port in fields or ports:
            ends = solid.between(port)
            if ends and results.dataset(port).ndim == 3:
                painted = Painted(results.dataset(port)[:][chosen], ends)
                found.setdefault(solid.title(), []).append(painted)
    return found


class _Buffer:
    """Bytes of the file, with the position of each array."""

    def __init__(self):
        self.data = bytearray()
        self.views: list[dict] = []
        self.accessors: list[dict] = []

    def add(self, values, target=None, limits=False) -> int:
        """Return the number of the accessor of an array with a row per element."""
        kind, code = {"f": (FLOAT, "<f4"), "u": (BYTE, "u1"), "i": (UNSIGNED, "<u4")}[
            values.dtype.kind
        ]
        array = np.ascontiguousarray(values, code)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes}
        self.views.append(view | ({"target": target} if target else {}))
        self.data += array.tobytes()  # rows are multiples of four bytes and stay aligned
        width = array.shape[1] if array.ndim == 2 else 1
        accessor = {
            "bufferView": len(self.views) - 1,
            "componentType": kind,
            "normalized": kind == BYTE,
            "count": len(array),
            "type": _TYPES[width],
        }
        if limits:
            rows = array.reshape(len(array), width)
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def write_gltf(
    solids: list[Solid],
    instants: np.ndarray,
    times: float,
    path: Path,
    painted: Mapping[str, Sequence[Painted]] | None = None,
) -> Path:
    """Write bodies at instants of a run. Deflection, lateral motion and tilt are magnified. A body
    at rest is cut open.

    Eq. (X19):  P(t) = R(times beta) (p + times Phi q(t)) + (times across, along, 0)

    Parameters
    ----------
    solids : list of Solid
        With motion and coordinates at the instants.
    instants : ndarray, shape (instants,)
        [s]; 30 of them take a second.
    times : float
        Magnification.
    path : Path
        Ends with .glb.
    painted : dict of str to sequence of Painted, optional
        Title of a body -> fields that colour its skirt.

    Raises
    ------
    BadInput
        If there is no body, or only one instant.
    """
    if not solids or len(instants) < 2:
        raise BadInput(
            f"{path}: expected a body and two instants, got {len(solids)} bodies and "
            f"{len(instants)} instants"
        )
    scene = _Scene(instants)
    for solid in solids:
        scene.add(solid, times, (painted or {}).get(solid.title(), ()))
    turned = [0.0, float(np.sin(-VIEW / 2)), 0.0, float(np.cos(VIEW / 2))]
    scene.nodes.append({"name": "engine", "children": _roots(solids, scene), "rotation": turned})
    tree = {
        "asset": {"version": "2.0", "generator": "piston-cosim"},
        "scene": 0,
        "scenes": [{"nodes": [len(scene.nodes) - 1]}],
        "nodes": scene.nodes,
        "meshes": scene.meshes,
        "materials": [MATERIAL],
        "animations": [{"name": "run", "channels": scene.channels, "samplers": scene.samplers}],
        "accessors": scene.buffer.accessors,
        "bufferViews": scene.buffer.views,
        "buffers": [{"byteLength": len(scene.buffer.data)}],
        "extras": {"magnification": times, "seconds": [float(instants[0]), float(instants[-1])]},
    }
    if not scene.channels:
        del tree["animations"]
    path.write_bytes(_binary(tree, bytes(scene.buffer.data)))
    return path


class _Scene:
    """Nodes, meshes and animation of the file."""

    def __init__(self, instants):
        self.buffer = _Buffer()
        self.nodes: list[dict] = []
        self.meshes: list[dict] = []
        self.channels: list[dict] = []
        self.samplers: list[dict] = []
        self.bodies: list[int] = []
        self.shown = (instants - instants[0]) / float(np.mean(np.diff(instants))) / RATE
        self.clock = self.buffer.add(self.shown, limits=True)

    def add(self, solid, times, painted):
        """Add the node of a body, with its motion and its meshes."""
        node: dict = {"name": solid.title()}
        self.nodes.append(node)
        self.bodies.append(len(self.nodes) - 1)
        if solid.motion is None:
            solid = _cut_open(solid)
        points = solid.points
        highest = 0  # a viewer without animations shows this instant
        colours = [METAL + 0 * points]
        if painted:
            colours, highest = _colours(solid, painted)
        if solid.motion is not None:
            self._move(node, solid.motion, times, highest)
        indices = self.buffer.add(solid.triangles.ravel().astype(int), INDICES)
        deflected = [points + times * solid.modes @ q for q in solid.coordinates]  # Eq. (X19)
        shapes = []
        for shape in deflected if solid.modes.shape[2] else [points]:
            shapes.append(self.buffer.add(shape, VERTICES, limits=True))
        paints = [self.buffer.add(_rgba(colour), VERTICES) for colour in colours]
        count = max(len(shapes), len(paints))
        for k in range(count):
            attributes = {"POSITION": shapes[k % len(shapes)], "COLOR_0": paints[k % len(paints)]}
            surface = {"attributes": attributes, "indices": indices, "material": 0}
            self.meshes.append({"name": solid.name, "primitives": [surface]})
            frame = {"mesh": len(self.meshes) - 1, "scale": [float(k == highest)] * 3}
            node.setdefault("children", []).append(len(self.nodes))
            if count > 1:
                self._show(k, count)
            self.nodes.append(frame)

    def _show(self, k, count):
        """Show the next node from instant k to the one after it."""
        keys = sorted({0, k, min(k + 1, count - 1)})
        at = self.buffer.add(self.shown[keys], limits=True)
        visible = np.repeat([[float(j == k)] for j in keys], 3, axis=1)
        self._animate(len(self.nodes), "scale", visible, at, "STEP")

    def _move(self, node, motion, times, first):
        across, along, turn = motion.T
        half = 0.5 * times * turn
        moves = np.column_stack([times * across, along, 0 * along])
        turns = np.column_stack([0 * half, 0 * half, np.sin(half), np.cos(half)])
        for what, values in (("translation", moves), ("rotation", turns)):
            node[what] = values[first].tolist()
            self._animate(len(self.nodes) - 1, what, values, self.clock, "LINEAR")

    def _animate(self, node, what, values, clock, interpolation):
        output = self.buffer.add(values)
        self.samplers.append({"input": clock, "output": output, "interpolation": interpolation})
        target = {"node": node, "path": what}
        self.channels.append({"sampler": len(self.samplers) - 1, "target": target})


def _cut_open(solid):
    """Return the half of a body behind the plane through the bore's axis that faces the viewer."""
    towards = np.array([np.sin(VIEW), 0.0, np.cos(VIEW)])
    depth = solid.points @ towards
    kept = (depth[solid.triangles] < 0).any(axis=1)
    used, triangles = np.unique(solid.triangles[kept], return_inverse=True)
    points = solid.points - np.maximum(depth, 0.0)[:, None] * towards
    return replace(
        solid,
        points=points[used],
        triangles=triangles.reshape(-1, 3),
        modes=solid.modes[used],
    )


def _colours(solid, painted):
    """Return the linear colours of a body's points at all instants, and the instant of the highest
    value.
    """
    x, y, z = solid.points.T
    outer = np.hypot(x, z) > OUTER * np.hypot(x, z).max()
    norm = colour_norm([np.ma.array(one.values) for one in painted])
    colours = np.repeat((METAL + 0 * solid.points)[None], len(painted[0].values), axis=0)
    for values, (low, high) in painted:
        _, n, m = values.shape
        skirt = outer & (y >= low) & (y <= high)
        around = ((np.arctan2(x, z) - np.pi / 2) * n / (2 * np.pi) + n // 4) % n
        along = (y - low) / (high - low) * m - 0.5
        at = [around[skirt], along[skirt]]
        for colour, image in zip(colours, values):
            closed = image[np.r_[:n, 0]]
            shown = COLOURS(norm(map_coordinates(closed, at, order=1, mode="nearest")))
            colour[skirt] = shown[:, :3] ** 2.2  # linear
    highest = max(painted, key=lambda one: one.values.max()).values
    return colours, int(highest.max(axis=(1, 2)).argmax())


def _rgba(colours):
    """Return opaque colours as bytes."""
    return (255 * np.column_stack([colours, np.ones(len(colours))])).round().astype(np.uint8)


def _roots(solids, scene):
    """Return the nodes that are in no other: the bodies; of several cylinders a node each, added to
    those of the bodies, at its position.
    """
    owners = list(dict.fromkeys(solid.owner for solid in solids))
    if len(owners) == 1:
        return scene.bodies
    roots = []
    for owner in owners:
        own = [k for k, solid in enumerate(solids) if solid.owner == owner]
        along, bank = solids[own[0]].stand
        turn = [0.0, 0.0, float(np.sin(bank / 2)), float(np.cos(bank / 2))]
        place = {"translation": [0.0, 0.0, float(along)], "rotation": turn}
        roots.append(len(scene.nodes))
        scene.nodes.append({"name": owner, "children": [scene.bodies[k] for k in own]} | place)
    return roots


MATERIAL = {
    "pbrMetallicRoughness": {"metallicFactor": 0.1, "roughnessFactor": 0.6},
    "doubleSided": True,
}
"""Material of all bodies; their points have colours."""


def _binary(tree, data):
    """Header, the description padded by blanks, the arrays."""
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + len(data)
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, size),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(data), b"BIN\0"),
            data,
        ]
    )
