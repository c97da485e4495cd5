"""Reading of a body: its mesh with surfaces and material, and its matrices."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import scipy.sparse as sp

from ..body_options import Block, Piston
from ..finite_elements.materials import NEEDED, material_of, replacement_remarks
from ..finite_elements.matrices import FullModel, assembled, matrix_faults, read_matrix
from ..finite_elements.mesh import Mesh, MeshFault, axes_matrix, read_mesh
from ..finite_elements.point_cloud import read_nodes

Say = Callable[[str], None]


def read_surfaces(options: Any, names: Iterable[str], say: Say) -> Mesh:
    """Read the mesh or the nodes of a body with surfaces.

    `options` are those of a piston, a block or a small end.

    Raises
    ------
    MeshFault
    """
    path = Path(options.mesh or "")
    regions = {name: surface.region() for name, surface in options.surfaces.items()}
    surfaces = dict.fromkeys(names) | regions
    placed = options.mesh_unit, options.axes, options.origin
    if path.suffix == ".csv":
        return read_nodes(path, surfaces, *placed)
    return read_mesh(path, surfaces, *placed, options.part, say)


SURFACES = {Piston: ("skirt", "crown", "pin_bore"), Block: ("bore", "bolts")}
"""Surfaces of the mesh of a body."""


def read_body(options: Piston | Block, say: Say) -> Mesh:
    """Read the mesh or the nodes of a body with its surfaces and its material.

    Raises
    ------
    MeshFault
    """
    mesh = read_surfaces(options, SURFACES[type(options)], say)
    if not len(mesh.tets) or options.stiffness or options.mass:
        return mesh
    values = {key: getattr(options, key) for key in (*NEEDED, "expansion")}
    tables = {name: one.model_dump() for name, one in options.materials.items()}
    for sentence in replacement_remarks(mesh.sets, values):
        say(f"{options.mesh}: {sentence}")
    needed = (*NEEDED, "expansion") if options.temperature_field else NEEDED
    where = f"{options.mesh}: "
    material = material_of(mesh.sets, len(mesh.tets), values, tables, where, needed)
    return replace(mesh, material=material)


def full_model(mesh: Mesh, options: Piston | Block, progress: Say) -> FullModel:
    """Return a body with its matrices, from elements or from files.

    Raises
    ------
    MeshFault
        If the matrices are wrong.
    """
    freedoms = 3 * len(mesh.points)
    if not (options.stiffness and options.mass):
        progress(f"assembling {freedoms} degrees of freedom")
        assert (material := mesh.material)  # `read_body` adds it if files give no matrices
        return assembled(mesh, material.young, material.poisson, material.density)
    labels = mesh.labels
    if labels is None:
        raise MeshFault(
            f"{options.mesh}: expected nodes with numbers for the matrices, got linear tetrahedra "
            "or several instances"
        )
    progress(f"reading matrices of {freedoms} degrees of freedom")
    rotation = sp.kron(sp.identity(len(mesh.points)), axes_matrix(options.axes), format="csr")
    K = rotation @ (read_matrix(options.stiffness, labels) * options.stiffness_unit) @ rotation.T
    M = rotation @ (read_matrix(options.mass, labels) * options.mass_unit) @ rotation.T
    if faults := matrix_faults(mesh, K, M, Path(options.stiffness).name):
        raise MeshFault(faults)
    return FullModel(mesh, K, M)
