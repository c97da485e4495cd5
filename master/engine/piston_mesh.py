"""Mesh of a generated piston of parabolic tetrahedra, by gmsh (extra `mesh`).

It has crown, ring belt, skirt, and pin bosses on pillars. A slipper has no skirt at the pin's
sides. Every proportion is our own choice, typical of passenger car pistons. The mesh has no ring
grooves. Profile and ovality belong to the case.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from ..fmi.errors import BadInput
from .new import Engine

if TYPE_CHECKING:
    from ...models.meshes import Piston

Kind = Literal["slipper", "full"]
ELEMENT_SIZE = 0.065
"""Largest edge of an element, relative to the bore."""
ELEMENTS_AROUND = 12
"""Minimum number of elements around a full circle."""
MM = 1e3


def mesh_of_sizes(made: Engine, kind: Kind, target: Path) -> None:
    """Write the mesh of a piston.

    Parameters
    ----------
    made : new.Engine
        Provides bore, clearance, skirt, compression height and pin.
    kind : "slipper" or "full"
        Two panels on the thrust sides, or a skirt all around.
    target : Path
        With suffix .msh.xz.

    Raises
    ------
    BadInput
        Without gmsh, or if the sizes are inconsistent.
    """
    faults = contradictions(made)
    if faults:
        raise BadInput(faults)
    try:
        from ...models.meshes import make
    except ImportError:
        raise BadInput(
            f"--piston: expected gmsh for {kind!r}, got none; run pip install 'piston-cosim[mesh]' "
            "or give --mesh or --piston data-sheet"
        ) from None
    target.parent.mkdir(parents=True, exist_ok=True)
    make(target, shape(made, kind), ELEMENT_SIZE * MM * made["bore"], ELEMENTS_AROUND)


def contradictions(made: Engine) -> list[str]:
    """Return why the sizes make no such piston."""
    faults = []
    crown, pin = made["compression_height"], made["pin_diameter"] / 2
    lowest = BOSS_RADIUS * pin + CROWN_THICKNESS * made["bore"]
    if crown < lowest:
        faults.append(
            f"--compression-height: expected at least {MM * lowest:.4g} mm for pin boss and crown, "
            f"got {MM * crown:.4g} mm; or give a smaller --pin-diameter"
        )
    if pin > LARGEST_PIN * made["bore"]:
        faults.append(
            f"--pin-diameter: expected at most {2 * MM * LARGEST_PIN * made['bore']:.4g} mm, "
            f"{2 * LARGEST_PIN:g} of the bore, got {2 * MM * pin:.4g} mm"
        )
    if made["skirt_above"] <= 0.0:
        faults.append("--skirt-above: expected a skirt above the pin axis, got 0 mm")
    belt = MM * (crown - CROWN_THICKNESS * made["bore"] - made["skirt_above"])
    if belt <= 0.0:
        faults.append(
            f"--skirt-above: expected less than {MM * made['skirt_above'] + belt:.4g} mm below a "
            f"ring belt, got {MM * made['skirt_above']:.4g} mm"
        )
    return faults


BOSS_RADIUS = 1.55
"""Outer radius of a pin boss, relative to the pin's."""
CROWN_THICKNESS = 0.085
"""Thickness of the crown, relative to the bore."""
LARGEST_PIN = 0.16
"""Largest radius of the pin relative to the bore, so that boss and walls fit."""


DIESEL_WALL = 1.5
"""Thickness of a diesel's slipper skirt relative to that of petrol, for twice the side force."""


def shape(made: Engine, kind: Kind) -> "Piston":
    """Return the dimensions of the piston [mm]."""
    from ...models.meshes import Piston

    bore = MM * made["bore"]
    radius = MM * made.skirt_radius
    pin = MM * made["pin_diameter"] / 2
    boss = BOSS_RADIUS * pin
    slipper = kind == "slipper"
    wall = bore * (DIESEL_WALL if slipper and made.diesel else 1.0)
    return Piston(
        skirt_radius=radius,
        land_radius=radius - 0.003 * bore,
        skirt=(-MM * made["skirt_below"], MM * made["skirt_above"]),
        top=MM * made["compression_height"],
        crown=CROWN_THICKNESS * bore,
        skirt_inside=(radius - 0.032 * wall, radius - 0.042 * wall),
        belt_inside=radius - 0.09 * bore,
        pin=pin,
        boss=boss,
        boss_from=0.17 * bore,
        boss_length=0.5 * bore,
        pillar_width=1.3 * boss,
        pillar_from=0.19 * bore,
        pillar_length=0.5 * bore,
        reach=radius - 0.02 * bore,
        root=0.6 * CROWN_THICKNESS * bore,
        box_wall=(0.045 * bore, 0.3 * bore) if slipper else None,
        cut_beyond=0.36 * bore if slipper else None,
    )
