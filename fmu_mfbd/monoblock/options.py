"""What a case file may say about a block of several cylinders."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, Field, ValidationError, field_validator, model_validator

from ...master.fmi.errors import BadInput
from ..options import (
    STRICT,
    BoreFromOutside,
    Density,
    Direction,
    Length,
    Mass,
    Number,
    Pressure,
    sentence_of,
)


class BuildMonoblock(BaseModel):
    """The whole table of the FMU. Mesh origin O on the crank axis, amid the cylinders, which stand
    upright in line along z; surfaces bore_1 .., deck, bearing_1 .., mount_1 ...
    """

    model_config = STRICT
    mesh: str
    """Mesh of 10-node tetrahedra (.msh, .inp, .cdb, also .xz, .gz) that names all surfaces."""
    mesh_unit: Annotated[Length, Field(gt=0)] = 1.0
    """What a length of 1 in the mesh file means."""
    axes: tuple[Direction, Direction, Direction] = ("x", "y", "z")
    """The file's directions that are thrust (x), towards the head (y) and along the crank (z)."""
    origin: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """Where this project's origin lies in the file."""
    density: Annotated[Density, Field(ge=500, le=25000)]
    """Of the material."""
    young: Annotated[Pressure, Field(ge=1e8, le=1e18)]
    """Young's modulus; far above a metal's for a block that does not bend."""
    poisson: Annotated[Number, Field(ge=0, lt=0.5)]
    """Poisson's ratio."""
    head_mass: Annotated[Mass, Field(ge=0)] = 0.0
    """Of the head, spread over the deck without stiffness."""
    crank_mass: Annotated[Mass, Field(ge=0)] = 0.0
    """Of crankshaft and flywheel, spread over the main bearings without stiffness."""
    cylinder_z: Annotated[list[Length], Field(min_length=1, max_length=16)]
    """Place of each cylinder's axis along the crank, rising."""
    bearings: Annotated[int, Field(ge=1, le=17)]
    """Main bearings."""
    mounts: Annotated[int, Field(ge=3, le=16)] = 4
    """Mounts."""
    bore_lower: Length
    """Lower end of the bores' fields above the crank axis."""
    bore_upper: Length
    """Upper end likewise."""
    bore: BoreFromOutside = BoreFromOutside()
    """Grid of each bore's fields, as block.bore_from_outside of the cylinders has it."""
    free_modes: Annotated[int, Field(ge=1, le=100)] = 10
    """Lowest modes of the free block, kept as they are."""
    modes: Annotated[int, Field(ge=2, le=400)] = 100
    """How many in all: besides those the answers to forces on deck, bearings and mounts, then to
    the pressures on the bores to which they yield most.
    """

    @field_validator("cylinder_z")
    @classmethod
    def _rising(cls, places):
        if any(a >= b for a, b in zip(places, places[1:])):
            raise ValueError("places along the crank must rise")
        return places

    @model_validator(mode="after")
    def _upright(self):
        if self.bore_lower >= self.bore_upper:
            raise ValueError(
                f"bore_lower = {self.bore_lower:g} m: must lie below "
                f"bore_upper = {self.bore_upper:g} m"
            )
        return self

    @model_validator(mode="after")
    def _enough(self):
        answers = 3 * len(self.cylinder_z) + 3 * self.mounts
        if self.modes <= self.free_modes + answers:
            raise ValueError(
                f"modes = {self.modes}: {self.free_modes} free ones and {answers} answers to "
                "forces on deck, bearings and mounts are among them, ask for more"
            )
        return self


def read_monoblock(options: dict[str, Any], folder: Path) -> BuildMonoblock:
    """Validate a build table; its path becomes absolute.

    Raises
    ------
    BadInput
        With every fault: path, value, what is allowed.
    """
    try:
        build = BuildMonoblock.model_validate(options)
    except ValidationError as error:
        raise BadInput([sentence_of(fault, BuildMonoblock) for fault in error.errors()]) from None
    path = (folder / build.mesh).resolve()
    if not path.is_file():
        raise BadInput([f"mesh = {build.mesh!r}: no such file in {folder}"])
    return build.model_copy(update={"mesh": str(path)})
