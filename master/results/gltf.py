"""Moving bodies as one binary glTF 2.0 file, which any viewer of the format plays.

Modes are morph targets with their coordinates as weights. The rigid motion is that of a node.
"""

import json
import struct
from pathlib import Path

import numpy as np

from ..fmi.errors import BadInput
from .solids import Solid

RATE = 30
"""Number of recorded instants per second of the animation."""
FLOAT, UNSIGNED = 5126, 5125
VERTICES, INDICES = 34962, 34963
COLOURS = {True: (0.68, 0.72, 0.76, 1.0), False: (0.45, 0.48, 0.52, 1.0)}
"""Colours of moving and of fixed bodies."""
_TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


class _Buffer:
    """Bytes of the file, and the position of each array in them."""

    def __init__(self):
        self.data = bytearray()
        self.views: list[dict] = []
        self.accessors: list[dict] = []

    def add(self, values, target=None, limits=False) -> int:
        """Add an array with a row for each element; return the number of its accessor."""
        kind = UNSIGNED if values.dtype.kind in "iu" else FLOAT
        array = np.ascontiguousarray(values, "<u4" if kind == UNSIGNED else "<f4")
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes}
        self.views.append(view | ({"target": target} if target else {}))
        self.data += array.tobytes()  # multiples of four bytes, so they are aligned
        width = array.shape[1] if array.ndim == 2 else 1
        accessor = {
            "bufferView": len(self.views) - 1,
            "componentType": kind,
            "count": len(array),
            "type": _TYPES[width],
        }
        if limits:
            rows = array.reshape(len(array), width)
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def write_gltf(solids: list[Solid], instants: np.ndarray, times: float, path: Path) -> Path:
    """Write bodies at the recorded instants of a run.

    `times` magnifies deflection, lateral motion and tilt, but not the motion along the bore.

    Eq. (X19):  P(t) = R(times beta) (p + times sum_k w_k(t) m_k) + (times across, along, 0)
                m_k = Phi_k max|q_k|,   w_k = q_k / max|q_k|

    Parameters
    ----------
    solids : list of Solid
    instants : ndarray, shape (instants,)
        [s], slowed down so that 30 of them take a second.
    times : float
    path : Path
        With suffix .glb.

    Raises
    ------
    BadInput
        If there are no bodies, or only one instant.
    """
    if not solids or len(instants) < 2:
        raise BadInput(
            f"{path}: expected a body and two instants, got {len(solids)} bodies and "
            f"{len(instants)} instants"
        )
    buffer = _Buffer()
    shown = (instants - instants[0]) / float(np.mean(np.diff(instants))) / RATE
    clock = buffer.add(shown, limits=True)
    meshes, channels, samplers = [], [], []

    def animate(node, what, values):
        samplers.append({"input": clock, "output": buffer.add(values), "interpolation": "LINEAR"})
        target = {"node": node, "path": what}
        channels.append({"sampler": len(samplers) - 1, "target": target})

    for node, solid in enumerate(solids):
        meshes.append(_mesh(solid, node, buffer))
        if solid.modes.shape[2]:
            weights = times * solid.coordinates / _sizes(solid)  # Eq. (X19)
            animate(node, "weights", weights.ravel())
        if solid.motion is not None:
            across, along, turn = solid.motion.T
            animate(node, "translation", np.column_stack([times * across, along, 0 * along]))
            half = 0.5 * times * turn
            animate(
                node, "rotation", np.column_stack([*2 * [0 * half], np.sin(half), np.cos(half)])
            )
    nodes = [{"name": solid.title(), "mesh": k} for k, solid in enumerate(solids)]
    tree = {
        "asset": {"version": "2.0", "generator": "piston-cosim"},
        "scene": 0,
        "scenes": [{"nodes": _roots(solids, nodes)}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [_material(solid) for solid in solids],
        "animations": [{"name": "run", "channels": channels, "samplers": samplers}],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
        "extras": {"drawn_times": times, "seconds": [float(instants[0]), float(instants[-1])]},
    }
    if not channels:
        del tree["animations"]
    path.write_bytes(_binary(tree, bytes(buffer.data)))
    return path


def _roots(solids, nodes):
    """Return the root nodes: the bodies, or for several cylinders a node for each of them.

    The nodes of cylinders are appended to those of the bodies.
    """
    owners = list(dict.fromkeys(solid.owner for solid in solids))
    if len(owners) == 1:
        return list(range(len(solids)))
    for owner in owners:
        own = [k for k, solid in enumerate(solids) if solid.owner == owner]
        along, bank = solids[own[0]].stand
        turn = [0.0, 0.0, float(np.sin(bank / 2)), float(np.cos(bank / 2))]
        place = {"translation": [0.0, 0.0, float(along)], "rotation": turn}
        nodes.append({"name": owner, "children": own} | place)
    return list(range(len(solids), len(nodes)))


def _sizes(solid):
    """Return the largest value of every coordinate, 1 for zero coordinates."""
    largest = np.abs(solid.coordinates).max(axis=0)
    return np.where(largest > 0, largest, 1.0)


def _mesh(solid, material, buffer):
    surface = {
        "attributes": {"POSITION": buffer.add(solid.points, VERTICES, limits=True)},
        "indices": buffer.add(solid.triangles.ravel(), INDICES),
        "material": material,
    }
    count = solid.modes.shape[2]
    if not count:
        return {"name": solid.name, "primitives": [surface]}
    shapes = solid.modes * _sizes(solid)  # Eq. (X19)
    surface["targets"] = [
        {"POSITION": buffer.add(shapes[:, :, k], VERTICES, limits=True)} for k in range(count)
    ]
    names = {"targetNames": [f"mode {k + 1}" for k in range(count)]}
    return {
        "name": solid.name,
        "primitives": [surface],
        "weights": [0.0] * count,
        "extras": names,
    }


def _material(solid):
    return {
        "name": solid.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": COLOURS[solid.motion is not None],
            "metallicFactor": 0.2,
            "roughnessFactor": 0.6,
        },
        "doubleSided": True,
    }


def _binary(tree, data):
    """Return the file: header, description padded with blanks, arrays."""
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
