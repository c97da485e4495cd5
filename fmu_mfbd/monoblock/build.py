"""Build of the block's FMU: reduce the block, or read it from the cache."""

from pathlib import Path
from typing import Any

from ...master.fmi.cache import cache_folder
from ...master.fmi.variables import Variable
from ..finite_elements.materials import NEEDED, replacement_remarks
from ..finite_elements.mesh import read_mesh
from ..options import read_options
from ..reducing import Say, reducing
from ..reduction.monoblock import Plan, free_block, reduce_monoblock
from ..reduction.store import contents, stored_file
from .options import FREE_MODES, BuildMonoblock
from .variables import variables


def options_schema() -> dict[str, Any]:
    """Return the JSON schema of the build table."""
    return BuildMonoblock.model_json_schema()


def declared_variables(options: dict[str, Any] | None, folder: Path) -> list[Variable]:
    """Return the variables of the FMU of a build table, or of none, without a reduction.

    Raises
    ------
    BadInput
        Every fault of the table.
    """
    if options is None:
        return variables(1, 4, (8, 8))
    build = read_options(options, folder, BuildMonoblock)
    return variables(len(build.cylinder_z), build.mounts, (build.bore.around, build.bore.axial))


def prepare(
    options: dict[str, Any], folder: Path, progress: Say
) -> tuple[dict[str, Any], list[Path]]:
    """Validate the build table and reduce the block.

    Returns the content of build.json, and the reduced block for the FMU's resources.

    Raises
    ------
    BadInput
        Every fault of the table; then every fault of the mesh.
    """
    build = read_options(options, folder, BuildMonoblock)
    plan = plan_of(build)
    with reducing("monoblock", build.mesh, progress) as say:

        def build_body():
            placed = build.mesh_unit, build.axes, build.origin, build.part
            mesh = read_mesh(build.mesh, dict.fromkeys(plan.surfaces()), *placed, say)
            material = build.young, build.poisson, build.density
            for sentence in replacement_remarks(mesh.sets, dict(zip(NEEDED, material))):
                say(f"{build.mesh}: {sentence}")
            body = free_block(mesh, material, build.head_mass, build.crank_mass)
            return (reduce_monoblock(body, plan, say),)

        path = stored_file("monoblock", contents(build), build_body, cache_folder("bodies"))
    resolved = {
        "file": path.name,
        "cylinders": len(build.cylinder_z),
        "mounts": build.mounts,
        "grid": [build.bore.around, build.bore.axial],
    }
    return resolved, [path]


def plan_of(build: BuildMonoblock) -> Plan:
    """Return the options of the reduction."""
    return Plan(
        cylinder_z=build.cylinder_z,
        bearings=build.bearings,
        mounts=build.mounts,
        grid=(build.bore.around, build.bore.axial),
        lower=build.bore_lower,
        upper=build.bore_upper,
        free_modes=FREE_MODES,
        modes=build.modes,
    )
