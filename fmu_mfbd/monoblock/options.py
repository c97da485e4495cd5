"""Options of a case file for a block of several cylinders."""

from typing import Annotated

from pydantic import Field

from ..body_options import (
    FILE,
    BoreFromOutside,
    Density,
    Length,
    Mass,
    Number,
    PlacedMesh,
    Pressure,
)
from ..options import BuildTable

FREE_MODES = 10
"""Number of lowest modes of the free block among all modes."""


class BuildMonoblock(PlacedMesh, BuildTable):
    """Build options of the block FMU.

    The mesh origin O is on the crank axis, in the middle of the cylinders. The cylinders are
    upright and in line along z. Surfaces: bore_1 .., deck, bearing_1 .., mount_1 ...
    """

    mesh: Annotated[str, FILE]
    """Mesh of 10-node tetrahedra (.msh, .inp, .cdb, also .xz, .gz) that names all surfaces."""
    density: Annotated[Density, Field(ge=500, le=25000)]
    """Density of the material."""
    young: Annotated[Pressure, Field(ge=1e8, le=1e18)]
    """Young's modulus. Use a value far above that of a metal for a rigid block."""
    poisson: Annotated[Number, Field(ge=0, lt=0.5)]
    """Poisson's ratio."""
    head_mass: Annotated[Mass, Field(ge=0)] = 0.0
    """Mass of the head, distributed over the deck without stiffness."""
    crank_mass: Annotated[Mass, Field(ge=0)] = 0.0
    """Mass of crankshaft and flywheel, distributed over the main bearings without stiffness."""
    cylinder_z: Annotated[list[Length], Field(min_length=1, max_length=16)]
    """Positions of the cylinder axes along the crank, ascending."""
    bearings: Annotated[int, Field(ge=1, le=17)]
    """Number of main bearings."""
    mounts: Annotated[int, Field(ge=3, le=16)] = 4
    """Number of mounts."""
    bore_lower: Length
    """Lower end of the bores' grids above the crank axis."""
    bore_upper: Length
    """Upper end of the bores' grids above the crank axis."""
    bore: BoreFromOutside = BoreFromOutside()
    """Grid of each bore, equal to block.bore_from_outside of the cylinders."""
    modes: Annotated[int, Field(ge=2, le=400)] = 100
    """Total number of modes: ten free modes, static responses to forces on deck, bearings and
    mounts, and most compliant pressures on the bores.
    """

    def contradictions(self) -> list[str]:
        """Return the faults of positions, ends and number of modes."""
        faults = super().contradictions()
        places = self.cylinder_z
        if any(a >= b for a, b in zip(places, places[1:])):
            faults.append(f"cylinder_z: expected rising places along the crank, got {places}")
        if self.bore_lower >= self.bore_upper:
            faults.append(
                f"bore_lower: expected a height below bore_upper = {self.bore_upper:g} m, "
                f"got {self.bore_lower:g} m"
            )
        answers = 3 * len(places) + 3 * self.mounts
        if self.modes <= FREE_MODES + answers:
            faults.append(
                f"modes: expected more than {FREE_MODES} free modes and {answers} answers to "
                f"forces, got {self.modes}"
            )
        return faults
