"""Mesh of a piston from a STEP file, by gmsh (extra `mesh`); surfaces are recognised by shape."""

from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from ..fmi.errors import BadInput

RADIUS_TOLERANCE = 3e-3
"""Relative tolerance of the largest radius: it includes the faces of the skirt, not ring lands."""
NORMAL_TOLERANCE = 1e-3
"""Component of a unit normal that counts as zero."""
ELEMENT_SIZE = 0.06
"""Largest edge of an element, relative to the bore's diameter."""
ELEMENTS_AROUND = 12
"""Minimum number of elements around a full circle."""


class Face(NamedTuple):
    """Face of the solid.

    shape : in gmsh's terms; radius : [m]; points, normals : on the face, (n, 3) [m] and [-].
    """

    tag: int
    shape: str
    radius: float
    points: np.ndarray
    normals: np.ndarray


def mesh_of_step(step: Path, target: Path, bore: float) -> None:
    """Write a mesh of 10-node tetrahedra with the surfaces skirt, crown and pin_bore.

    The solid has this project's axes: x thrust, y towards the head, z along the pin, and the origin
    on the axes of pin and skirt. Its skirt is a cylinder. Profile and ovality belong to the case.

    Parameters
    ----------
    step : Path
        With the units of the file.
    target : Path
        .msh file, in metres.
    bore : float
        Diameter, for the size of elements [m].

    Raises
    ------
    BadInput
        Without gmsh, if the file has no solid, or if a surface is missing.
    """
    try:
        import gmsh  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise BadInput(
            "--step: expected gmsh, got none; run pip install 'piston-cosim[mesh]' or give --mesh"
        ) from None
    if not step.is_file():
        raise BadInput(f"--step: expected a STEP file, got no such file {str(step)!r}")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        try:
            gmsh.model.occ.importShapes(str(step), format="step")
        except Exception as error:
            raise BadInput(f"--step: expected a STEP file, got {str(step)!r}") from error
        gmsh.model.occ.synchronize()
        _mesh(gmsh, step, bore)
        target.parent.mkdir(parents=True, exist_ok=True)
        gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
        gmsh.write(str(target))
    finally:
        gmsh.finalize()


def _mesh(gmsh: ModuleType, step: Path, bore: float) -> None:
    """Name the surfaces of the only solid, and mesh it."""
    solids = [tag for _, tag in gmsh.model.getEntities(3)]
    if len(solids) != 1:
        raise BadInput(f"--step: expected one solid, got {len(solids)}")
    faces = [_face(gmsh, tag) for _, tag in gmsh.model.getEntities(2)]
    surfaces = {"skirt": _skirt(faces), "crown": _crown(faces)}
    surfaces["pin_bore"] = [one.tag for one in _cylinders(faces, 2)]
    missing = [name for name, tags in surfaces.items() if not tags]
    if missing:
        raise BadInput(
            f"--step: expected faces {' and '.join(missing)}, got none; let x be thrust, y up and "
            "z "
            "the pin, with the origin on the axes of pin and skirt"
        )
    gmsh.model.addPhysicalGroup(3, solids, name="all")
    for name, tags in surfaces.items():
        gmsh.model.addPhysicalGroup(2, tags, name=name)
    gmsh.option.setNumber("Mesh.MeshSizeMax", ELEMENT_SIZE * bore)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", ELEMENTS_AROUND)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.model.mesh.optimize("HighOrder")


def _face(gmsh: Any, tag: int) -> Face:
    """Return the face, evaluated at a few points."""
    low, high = gmsh.model.getParametrizationBounds(2, tag)
    u, v = (np.linspace(a, b, 7)[1:-1] for a, b in zip(low, high))
    where = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).ravel()
    points = np.reshape(gmsh.model.getValue(2, tag, where), (-1, 3))
    normals = np.reshape(gmsh.model.getNormal(tag, where), (-1, 3))
    curvature = float(np.max(np.abs(gmsh.model.getCurvature(2, tag, where))))
    radius = 1.0 / curvature if curvature > 1e-9 else np.inf
    return Face(tag, gmsh.model.getType(2, tag), radius, points, normals)


def _skirt(faces: list[Face]) -> list[int]:
    """Return the cylinders about y with the largest radius."""
    about = _cylinders(faces, 1)
    largest = max((one.radius for one in about), default=0.0)
    return [one.tag for one in about if one.radius > (1 - RADIUS_TOLERANCE) * largest]


def _cylinders(faces: list[Face], axis: int) -> list[Face]:
    """Return the cylinders about one of the axes x, y, z."""
    return [
        one
        for one in faces
        if one.shape == "Cylinder"
        and np.abs(one.normals[:, axis]).max() < NORMAL_TOLERANCE
        and np.ptp(np.hypot(*np.delete(one.points, axis, axis=1).T)) < RADIUS_TOLERANCE * one.radius
    ]


def _crown(faces: list[Face]) -> list[int]:
    """Return the planes normal to y at the top."""
    across = [
        one
        for one in faces
        if one.shape == "Plane" and np.abs(one.normals[:, 1]).min() > 1 - NORMAL_TOLERANCE
    ]
    top = max((one.points[:, 1].max() for one in across), default=0.0)
    return [one.tag for one in across if one.points[:, 1].min() > top - 1e-6]
