"""What a case file may say about the bodies: the `[participants.X.build]` table."""

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, TypeVar

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
    field_validator,
    model_validator,
)
from pydantic_core import core_schema

from ..master.fmi.errors import BadInput
from ..master.fmi.option_classes import sentences, with_meanings
from ..master.fmi.quantities import in_unit, to_si
from .finite_elements.regions import Bore, Cylinder, Plane, Region
from .geometry.pin import CRANK_SURFACES, PIN_SURFACES
from .geometry.pin_shapes import MOST

Count = Annotated[int, Field(ge=4, le=400)]
Length = Annotated[float, in_unit("m")]
Angle = Annotated[float, in_unit("rad")]
Pressure = Annotated[float, in_unit("Pa")]
Density = Annotated[float, in_unit("kg/m^3")]
Stiffness = Annotated[float, in_unit("N/m")]
Mass = Annotated[float, in_unit("kg")]
Inertia = Annotated[float, in_unit("kg*m^2")]
Time = Annotated[float, in_unit("s")]
AngularSpeed = Annotated[float, in_unit("rad/s")]
Frequency = Annotated[float, in_unit("Hz")]
Number = Annotated[float, in_unit("1")]

MOST_MODES = 200
"""Maximum number of modes of a body."""
ERROR_RANGE = (1e-4, 0.5)
"""Range of the expected error that determines the number of modes [-]."""


class ModeCount:
    """Pydantic field: number of modes, or the error that chooses it, as a float."""

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(_mode_count)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        low, high = ERROR_RANGE
        number = {"type": "integer", "minimum": 0, "maximum": MOST_MODES}
        error = {"type": ["number", "string"], "unit": "1", "ge": low, "le": high}
        return {"anyOf": [number, error]}


def _mode_count(value: Any) -> int | float:
    """Return a number of modes, or a float for an error."""
    low, high = ERROR_RANGE
    expected = (
        f"expected a number of modes from 0 to {MOST_MODES} or an error "
        f"of {100 * low:g} % to {100 * high:g} %, got {value!r}"
    )
    if isinstance(value, str) and value.strip().isdecimal():
        value = int(value)
    if isinstance(value, int) and not isinstance(value, bool):
        if not 0 <= value <= MOST_MODES:
            raise ValueError(expected)
        return value
    try:
        error = to_si(value, "1")
    except ValueError:
        raise ValueError(expected) from None
    if not low <= error <= high:
        raise ValueError(expected)
    return error


Direction = Literal["x", "y", "z", "-x", "-y", "-z"]
STRICT = ConfigDict(extra="forbid", allow_inf_nan=False, json_schema_extra=with_meanings)


class Surface(BaseModel):
    """Surface defined by geometry, in the project's axes.

    It is a cylinder about y with its ends, a bore about z, or a plane across y.
    """

    model_config = STRICT
    shape: Literal["cylinder", "bore", "plane"]
    """Cylinder about y with ends, bore about z of any length, or plane across y."""
    radius: Length | None = None
    """Radius of a cylinder or bore."""
    lower: Length | None = None
    """Lower end of a cylinder."""
    upper: Length | None = None
    """Upper end of a cylinder."""
    height: Length | None = None
    """Height of a plane."""

    @model_validator(mode="after")
    def _complete(self):
        needed = {
            "cylinder": ("radius", "lower", "upper"),
            "bore": ("radius",),
            "plane": ("height",),
        }
        for key in needed[self.shape]:
            if getattr(self, key) is None:
                raise ValueError(f"{key}: expected a value for a {self.shape}, got nothing")
        return self

    def region(self) -> Region:
        """As `mesh.read_mesh` takes it."""
        given = self.model_dump(exclude={"shape"}, exclude_none=True)
        regions = {"cylinder": Cylinder, "bore": Bore, "plane": Plane}
        return regions[self.shape](**given)


class RigidPiston(BaseModel):
    """Data sheet of a rigid piston."""

    model_config = STRICT
    mass: Annotated[Mass, Field(gt=0)]
    """Mass without the pin."""
    centre: tuple[Length, Length]
    """Centre of mass (x, y), relative to the skirt axis at the height of pin point A."""
    inertia: Annotated[Inertia, Field(gt=0)]
    """Moment of inertia about the axis through the centre of mass along the pin."""
    radius: Annotated[Length, Field(gt=0)]
    """Radius of the skirt."""


class RigidBlock(BaseModel):
    """Data sheet of a rigid block."""

    model_config = STRICT
    radius: Annotated[Length, Field(gt=0)]
    """Radius of the bore."""


class Body(BaseModel):
    """Options of a body.

    `stiffness` and `mass` are matrices of another program (`matrices.read_matrix`). They replace
    density, young and poisson. `mesh` or a CSV file (`point_cloud.read_nodes`) then gives the nodes
    and their surfaces. `reduced` is a file of `piston-cosim reduce` (.npz). It replaces mesh,
    material, basis and modes. `rigid` is a data sheet (`RigidPiston`, `RigidBlock`) that also needs
    the ends of the surface.
    """

    ENDS: ClassVar[tuple[str, str]]

    model_config = STRICT
    mesh: str | None = None
    """Mesh of 10-node tetrahedra (.msh, .inp, .bdf, also .xz, .gz). For a body of matrices, also a
    CSV file of nodes.
    """
    reduced: str | None = None
    """Reduced body, a file of `piston-cosim reduce` (.npz). It replaces mesh, material, basis and
    modes.
    """
    rigid: RigidPiston | RigidBlock | None = None
    """Data sheet of a rigid body. It replaces the mesh."""
    mesh_unit: Annotated[Length, Field(gt=0)] = 1.0
    """Length unit of the mesh file, e.g. "1 mm"."""
    axes: tuple[Direction, Direction, Direction] = ("x", "y", "z")
    """Directions of the mesh file that correspond to x, y and z: thrust side, towards the head,
    along the pin.
    """
    origin: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """Position of the project's origin in the mesh file."""
    surfaces: dict[str, Surface] = {}
    """Surfaces defined by geometry, for a mesh file that does not name them."""
    density: Annotated[Density, Field(ge=500, le=25000)] | None = None
    """Density of the material."""
    young: Annotated[Pressure, Field(ge=1e8, le=1e12)] | None = None
    """Young's modulus."""
    poisson: Annotated[Number, Field(ge=0, lt=0.5)] | None = None
    """Poisson's ratio."""
    stiffness: str | None = None
    """Stiffness matrix of another program (.mtx, .pch, .bdf)."""
    mass: str | None = None
    """Mass matrix of another program (.mtx, .pch, .bdf)."""
    stiffness_unit: Annotated[Stiffness, Field(gt=0)] | None = None
    """Unit of the stiffness matrix."""
    mass_unit: Annotated[Mass, Field(gt=0)] | None = None
    """Unit of the mass matrix."""
    basis: Literal[
        "smooth_pressure_modes",
        "trained",
        "pressure_modes",
        "craig_bampton",
        "characteristic_constraint_modes",
    ] = "smooth_pressure_modes"
    """Modes of the reduced body. The default modes are deflections under smooth film pressures.
    `trained` adds modes from an earlier run.
    """
    train_on: str | None = None
    """Results file of the earlier run for `trained`. It must hold both nodal forces on the same
    grid.
    """
    modes: Annotated[int | float, ModeCount] = 60
    """Number of modes, or the largest expected relative error of the deflection, e.g. "1 %". 0:
    rigid. An error requires smooth_pressure_modes or trained. `trained` adds its modes to this
    number.
    """
    symmetric_film: bool = False
    """Whether the film pressure is its own mirror image about the thrust plane. The smooth pressure
    modes are then symmetric too, and about half as many are as accurate.
    """
    modes_from: Annotated[int, Field(ge=1, le=400)] | None = None
    """Number of lowest modes from which `modes` are selected by their part in the deflection under
    smooth pressures. Requires craig_bampton or characteristic_constraint_modes. Default: no
    selection.
    """
    modes_off: list[Annotated[int, Field(ge=1)]] = []
    """Numbers of the modes to switch off, as in the table of modes."""

    @model_validator(mode="after")
    def _source(self):
        sources = (self.mesh, self.reduced, self.rigid)
        if sum(source is not None for source in sources) != 1:
            raise ValueError("expected one of mesh, reduced and rigid, got none or several")
        if self.rigid:
            self._complete_sheet()
        if (self.basis == "trained") != (self.train_on is not None):
            raise ValueError("train_on: expected it with basis = 'trained' only, got one of both")
        if isinstance(self.modes, float) and self.basis not in ("smooth_pressure_modes", "trained"):
            raise ValueError(
                f"modes: expected a number of modes with basis = '{self.basis}', got "
                f"{self.modes:g}; "
                "an error chooses the modes of 'smooth_pressure_modes' and 'trained'"
            )
        if self.modes_from is not None:
            self._check_selection(self.modes_from)
        if self.stiffness or self.mass or (self.mesh or "").endswith(".csv"):
            what = "a body of matrices"
            needed = ("stiffness", "stiffness_unit", "mass", "mass_unit")
        else:
            what = "a mesh"
            needed = ("density", "young", "poisson")
        missing = [key for key in needed if getattr(self, key) is None]
        if self.mesh is not None and missing:
            raise ValueError(_missing(missing, f"with {what}"))
        return self

    def _check_selection(self, candidates: int) -> None:
        """Raise ValueError unless `modes` can be selected from the lowest modes of the basis."""
        lowest = ("craig_bampton", "characteristic_constraint_modes")
        if self.basis not in lowest:
            wanted = " or ".join(map(repr, lowest))
            raise ValueError(f"modes_from: expected basis = {wanted}, got {self.basis!r}")
        if candidates < self.modes:
            raise ValueError(
                f"modes_from: expected at least modes = {self.modes}, got {candidates}"
            )

    def most_modes(self) -> int:
        """Return the largest number of modes that the body can have, before it is reduced."""
        if self.rigid:
            return 0
        known = isinstance(self.modes, int) and self.basis != "trained"
        return int(self.modes) - len(self.modes_off) if known else MOST_MODES

    def _complete_sheet(self) -> None:
        """Raise ValueError unless a data sheet has what it needs, and no modes."""
        missing = [key for key in self.ENDS if getattr(self, key) is None]
        if missing:
            raise ValueError(_missing(missing, "for a rigid body"))
        if "modes" in self.model_fields_set and self.modes:
            raise ValueError(f"modes: expected 0 for a rigid body, got {self.modes}")


class ShapeTable(BaseModel):
    """Measured shape in a CSV file, see `tables.profile_table`."""

    model_config = STRICT
    file: str
    """CSV file. The first row holds angles. Each further row holds a height and its values."""
    angle_unit: Annotated[Angle, Field(gt=0)]
    """Unit of the angles."""
    height_unit: Annotated[Length, Field(gt=0)]
    """Unit of the heights."""
    value_unit: Annotated[Length, Field(gt=0)]
    """Unit of the values."""


class Order(BaseModel):
    """Fourier order of a bore distortion, see `profile.fourier_bore`."""

    model_config = STRICT
    order: Annotated[int, Field(ge=0, le=40)]
    """Fourier order: 0 growth, 1 offset of the axis, 2 ovality, 4 four bolts."""
    amplitude: Length
    """Amplitude of the radial widening."""
    phase: Angle = 0.0
    """Angle of the largest widening, from the pin axis towards the thrust side."""


class Table(BaseModel):
    """Table of two columns, in a CSV file (comma or semicolon) or as `points` in the case."""

    model_config = STRICT
    file: str | None = None
    """CSV file with two columns."""
    points: list[tuple[float, float]] | None = None
    """The two columns as a list of pairs."""
    strokes: Literal[2, 4] = 4
    """Number of strokes of a cycle."""

    @model_validator(mode="after")
    def _source(self):
        if (self.file is None) == (self.points is None):
            raise ValueError("expected either file or points, got both or neither")
        if self.points is not None and len(self.points) < 2:
            raise ValueError(f"points: expected at least two points, got {len(self.points)}")
        return self


class Gas(Table):
    """Gas pressure over crank angle, see `tables.gas_table`.

    The parameter `gas_source` selects whether it adds to the input `gas_pressure`.
    """

    angle_unit: Annotated[Angle, Field(gt=0)]
    """Unit of the first column, the crank angle."""
    pressure_unit: Annotated[Pressure, Field(gt=0)]
    """Unit of the second column, the gauge pressure."""


class Speed(Table):
    """Crank speed over time or crank angle, see `speed_table.speed_table`.

    It replaces the input `crank_speed`.
    """

    time_unit: Annotated[Time, Field(gt=0)] | None = None
    """Unit of the first column if it is time."""
    angle_unit: Annotated[Angle, Field(gt=0)] | None = None
    """Unit of the first column if it is crank angle."""
    speed_unit: Annotated[AngularSpeed, Field(gt=0)]
    """Unit of the second column, the crank speed."""

    @model_validator(mode="after")
    def _over(self):
        if (self.time_unit is None) == (self.angle_unit is None):
            raise ValueError("expected either time_unit or angle_unit, got both or neither")
        return self


class Piston(Body):
    """Options of the piston.

    The mesh origin is on the skirt axis at the height of pin point A. Surfaces: `skirt`, `crown`,
    `pin_bore`.
    """

    ENDS = ("skirt_lower", "skirt_upper")
    tie: Literal["rbe2", "rbe3", "rbe3_per_boss"] = "rbe2"
    """Connection of the pin bores to pin point A. `rbe2` ties every node, `rbe3` the mean motion of
    both bores, and `rbe3_per_boss` that of each. It affects the skirt compliance more than the
    choice of modes.
    """
    rigid: RigidPiston | None = None
    """Data sheet of a rigid piston. It replaces the mesh."""

    skirt_lower: Length | None = None
    """Lower edge of the skirt above pin point A. Default: that of the surface in the mesh."""
    skirt_upper: Length | None = None
    """Upper edge of the skirt above pin point A. Default: that of the surface in the mesh."""
    pin_offset: Length = 0.0
    """Offset of pin point A from the skirt axis, positive towards the thrust side. It is at most
    0.05 skirt radii from the pin bores of the mesh, which do not move. It requires no new
    reduction.
    """
    profiles: list[ShapeTable] = []
    """Measured gaps that add to barrel and ovality."""


class BoreFromOutside(BaseModel):
    """Grid of a bore whose deflection another participant computes.

    Angles start at the thrust line like those of the film grid. Heights range from bore_lower to
    bore_upper.
    """

    model_config = STRICT
    around: Annotated[int, Field(ge=8, le=400)] = 24
    """Number of angles."""
    axial: Annotated[int, Field(ge=8, le=400)] = 24
    """Number of heights, both ends included."""


class Block(Body):
    """Options of the block.

    The mesh origin is on the bore axis at the height of the crank axis. Surfaces: `bore`, `bolts`.
    """

    ENDS = ("bore_lower", "bore_upper")
    tie: Literal["rbe2", "springs"] = "rbe2"
    """Support of the bolt faces: rigid (rbe2), or springs."""
    rigid: RigidBlock | None = None
    """Data sheet of a rigid block. It replaces the mesh."""
    spring_stiffness: Annotated[Stiffness, Field(ge=1e3, le=1e14)] = 1e9
    """Stiffness of all springs together in each direction, distributed over all bolt faces."""

    bore_lower: Length | None = None
    """Lower end of the bore above the crank axis. Default: that of the surface in the mesh."""
    bore_upper: Length | None = None
    """Upper end of the bore above the crank axis. Default: that of the surface in the mesh."""
    stations: Annotated[int, Field(ge=8, le=400)] = 64
    """Number of heights in the table of bore modes."""
    bore_from_outside: BoreFromOutside | None = None
    """Grid of a bore whose deflection another participant computes. It provides bore_deflection and
    receives force_on_bore and force_on_deck. Requires `rigid` and `mounted = true`.
    """
    profiles: list[ShapeTable] = []
    """Measured widenings of the bore."""
    orders: list[Order] = []
    """Fourier orders of the bore distortion."""

    @model_validator(mode="after")
    def _bore_of_outside(self):
        if self.bore_from_outside:
            if not self.rigid:
                raise ValueError("rigid: expected a table with bore_from_outside, got nothing")
            if "stations" in self.model_fields_set:
                raise ValueError("stations: expected nothing with bore_from_outside, got a value")
            self.stations = self.bore_from_outside.axial
        return self


class Band(BaseModel):
    """Modal damping ratio above a frequency, up to the next band."""

    model_config = STRICT
    above: Annotated[Frequency, Field(ge=0)]
    """Lowest frequency of the band."""
    ratio: Annotated[Number, Field(ge=0, le=2)]
    """Modal damping ratio."""


class FilmSurface(BaseModel):
    """Rows of the film grid that a separate lubrication FMU covers."""

    model_config = STRICT
    name: Annotated[str, Field(pattern="^[a-z][a-z0-9_]*$", max_length=40)]
    """Prefix of its variables, as in NAME.film_thickness."""
    rows: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]]
    """First and last row of `grid` along the skirt, counted from 1 at the lower edge."""

    @field_validator("rows")
    @classmethod
    def _wide(cls, rows):
        first, last = rows
        if last - first + 1 < LEAST_ROWS:
            raise ValueError(f"expected at least {LEAST_ROWS} rows, got {last - first + 1}")
        return rows


class SmallEnd(BaseModel):
    """Flexible small end of the rod.

    The mesh origin is on its axis at mid-length, with the shank towards -y. Surfaces: eye (the
    bore) and cut, where the rigid rod holds the shank.
    """

    model_config = STRICT
    mesh: str
    """Mesh of 10-node tetrahedra (.msh, .inp, .bdf, .cdb, also .xz, .gz)."""
    mesh_unit: Annotated[Length, Field(gt=0)] = 1.0
    """Length unit of the mesh file, e.g. "1 mm"."""
    axes: tuple[Direction, Direction, Direction] = ("x", "y", "z")
    """Directions of the mesh file that correspond to x, y and z: thrust side, towards the head,
    along the pin.
    """
    origin: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """Position of the project's origin in the mesh file."""
    surfaces: dict[Literal["eye", "cut"], Surface] = {}
    """Surfaces defined by geometry (bore or plane), for a mesh file that does not name them."""
    density: Annotated[Density, Field(ge=500, le=25000)]
    """Density of the material, for the inertia of the modes. Mass and inertia of the rod are
    parameters.
    """
    young: Annotated[Pressure, Field(ge=1e8, le=1e12)]
    """Young's modulus."""
    poisson: Annotated[Number, Field(ge=0, lt=0.5)]
    """Poisson's ratio."""
    modes: Annotated[int, Field(ge=0, le=MOST_MODES)] = 60
    """Number of modes. 0: rigid."""


class FloatingPin(BaseModel):
    """Pin that rotates and moves on films in both bosses and in the small end.

    The surfaces boss_left, boss_right and small_end have the fields of a bearing. The skirt is then
    the surface skirt.
    """

    model_config = STRICT
    grid: tuple[Count, Count] = (72, 8)
    """Number of cells around and along each of the three shells."""
    boss_length: Annotated[Length, Field(gt=0)]
    """Length of one boss along the pin."""
    small_end_length: Annotated[Length, Field(gt=0)]
    """Length of the small end along the pin."""
    boss_modes: Annotated[int, Field(ge=0, le=190)] = 0
    """Number of piston modes for the deflection of the bosses under their films. 0: rigid bosses.
    """
    pin_shapes: Annotated[int, Field(ge=0, le=MOST)] = 0
    """Number of shapes in which the pin moves in its shells, in addition to translation. 0: it
    stays parallel to them. 1: it tilts. Each further shape bends the pin.
    """
    small_end: SmallEnd | None = None
    """Mesh of a flexible small end. Default: rigid."""


class CrankBearing(BaseModel):
    """Film between the crank and the rod or block, in addition to those of a floating pin.

    Its surface has the fields of a bearing.
    """

    model_config = STRICT
    grid: tuple[Count, Count] = (72, 8)
    """Number of cells around and along the shell."""
    length: Annotated[Length, Field(gt=0)]
    """Length of the bearing along the crank."""


class MotionInSpace(BaseModel):
    """Rigid piston that also moves along its pin, rolls about x and yaws about y.

    The values complete a data sheet and refer to the centre of mass. A mesh needs no values.
    """

    model_config = STRICT
    inertia_x: Annotated[Inertia, Field(gt=0)] | None = None
    """Moment of inertia about x."""
    inertia_y: Annotated[Inertia, Field(gt=0)] | None = None
    """Moment of inertia about y."""
    product_xy: Inertia = 0.0
    """Product of inertia, the integral of x y dm."""
    product_yz: Inertia = 0.0
    """Product of inertia, the integral of y z dm."""
    product_zx: Inertia = 0.0
    """Product of inertia, the integral of z x dm."""
    centre_z: Length = 0.0
    """Coordinate z of the centre of mass."""

    def tensor(self, inertia_z: float) -> np.ndarray:
        """Tensor of inertia of a data sheet about its centre of mass, (3, 3) [kg m2]."""
        xy, yz, zx = -self.product_xy, -self.product_yz, -self.product_zx
        x, y = self.inertia_x, self.inertia_y
        return np.array([[x, xy, zx], [xy, y, yz], [zx, yz, inertia_z]], dtype=float)


LEAST_ROWS = 4
"""Minimum number of rows of a film grid along the skirt."""


class Common(BaseModel):
    """Options in addition to those of the bodies."""

    model_config = ConfigDict(extra="forbid", json_schema_extra=with_meanings)
    grid: tuple[Count, Count] = (40, 40)
    """Number of cells around and along the skirt."""
    gas: Gas | None = None
    """Gas pressure over crank angle. By default it adds to the input gas_pressure, see the
    parameter gas_source.
    """
    speed: Speed | None = None
    """Crank speed over time or crank angle. It replaces the input crank_speed."""
    start: str | None = None
    """File of `piston-cosim results snapshot`. It replaces the parameters start_*."""
    film_surfaces: list[FilmSurface] = []
    """Bands of the skirt with separate films, in ascending order. Rows between them have no film.
    Default: one surface for the whole skirt, with variable names without prefix.
    """
    floating_pin: FloatingPin | None = None
    """Films between pin, bosses and rod. They replace a pin that is tied to the piston. The block
    is rigid, and without boss_modes so is the piston.
    """
    big_end: CrankBearing | None = None
    """Film between the rod and the crank pin, surface big_end. Requires floating_pin."""
    main_bearing: CrankBearing | None = None
    """Film between the crank and the block, surface main_bearing. The crank has its own mass, and
    one bearing carries this cylinder. Requires floating_pin.
    """
    motion_in_space: MotionInSpace | None = None
    """Motion of the piston along its tied pin, with roll and yaw. Both bodies are rigid."""
    mounted: bool = False
    """The block moves on mounts. Another participant provides block_acceleration_x and other
    inputs, and receives force_on_block_x and other outputs.
    """
    damping_bands: list[Band] = []
    """Modal damping by frequency. It replaces damping_ratio, high_frequency_damping_ratio and
    damping_transition_frequency.
    """

    @field_validator("damping_bands")
    @classmethod
    def _rising(cls, bands):
        if not bands:
            return bands
        rising = all(a.above < b.above for a, b in zip(bands, bands[1:]))
        if bands[0].above != 0.0 or not rising:
            got = ", ".join(f"{band.above:g}" for band in bands)
            raise ValueError(f"expected rising bands from 0 Hz, got {got} Hz")
        return bands

    @model_validator(mode="after")
    def _of_floating_pin(self):
        if self.floating_pin and self.start:
            raise ValueError(f"start: expected nothing with floating_pin, got {self.start!r}")
        if self.floating_pin and self.mounted:
            raise ValueError("mounted: expected false with floating_pin, got true")
        if self.floating_pin and (eye := self.floating_pin.small_end):
            around, along = self.floating_pin.grid
            if eye.modes > around * along - 2:
                raise ValueError(
                    f"floating_pin.small_end.modes: expected at most {around * along - 2} for "
                    f"{around} x {along} cells, got {eye.modes}"
                )
        alone = [] if self.floating_pin else [*self.crank_films()]
        if alone:
            raise ValueError(f"floating_pin: expected a table with {', '.join(alone)}, got nothing")
        return self

    def crank_films(self) -> dict[str, CrankBearing]:
        """Those of the crank, by surface."""
        given = {name: getattr(self, name) for name in CRANK_SURFACES}
        return {name: one for name, one in given.items() if one}

    @model_validator(mode="after")
    def _apart(self):
        _, along = self.grid
        taken = {*PIN_SURFACES, *self.crank_films()} if self.floating_pin else set()
        below = 0
        for k, surface in enumerate(self.film_surfaces):
            first, last = surface.rows
            where = f"film_surfaces.{k}"
            if surface.name in taken:
                raise ValueError(f"{where}.name: expected a new name, got {surface.name!r}")
            if first <= below:
                raise ValueError(
                    f"{where}.rows: expected rows above {below}, the end of the surface before, "
                    f"got {[first, last]}"
                )
            if last > along:
                raise ValueError(
                    f"{where}.rows: expected at most {along} rows, got {[first, last]}"
                )
            taken.add(surface.name)
            below = last
        return self


class Bodies(Common):
    """One body or both, for a reduction without an FMU."""

    piston: Piston | None = None
    """Options of the piston. The mesh origin is on the skirt axis at the height of pin point A.
    Surfaces: skirt, crown, pin_bore.
    """
    block: Block | None = None
    """Options of the block. The mesh origin is on the bore axis at the height of the crank axis.
    Surfaces: bore, bolts.
    """

    @model_validator(mode="after")
    def _any(self):
        if self.piston is None and self.block is None:
            raise ValueError("build: expected a table piston, block or both, got nothing")
        return self


class Build(Common):
    """Build options of the body FMU."""

    piston: Piston
    """Options of the piston. The mesh origin is on the skirt axis at the height of pin point A.
    Surfaces: skirt, crown, pin_bore.
    """
    block: Block
    """Options of the block. The mesh origin is on the bore axis at the height of the crank axis.
    Surfaces: bore, bolts.
    """

    @model_validator(mode="after")
    def _beside_a_bore_from_outside(self):
        if self.block.bore_from_outside and not self.mounted:
            raise ValueError("mounted: expected true with block.bore_from_outside, got false")
        return self

    @model_validator(mode="after")
    def _beside_motion_in_space(self):
        if self.motion_in_space:
            faults = _faults_in_space(self, self.motion_in_space)
            if faults:
                raise ValueError("\n".join(faults))
        return self

    @model_validator(mode="after")
    def _beside_a_floating_pin(self):
        if not self.floating_pin:
            return self
        faults = []
        if not self.block.rigid and self.block.modes:
            got = f"{self.block.modes:g}"
            faults.append(f"block.modes: expected 0 or a rigid block with floating_pin, got {got}")
        elif (self.piston.rigid or not self.piston.modes) and self.floating_pin.boss_modes:
            got = self.floating_pin.boss_modes
            faults.append(f"floating_pin.boss_modes: expected 0 for a rigid piston, got {got}")
        elif not self.piston.rigid and self.piston.modes:
            faults += _faults_of_bosses(self.piston, self.floating_pin.boss_modes)
        if faults:
            raise ValueError("\n".join(faults))
        return self


def _faults_in_space(build: Build, space: MotionInSpace) -> list[str]:
    """Return the faults of a piston that moves in space."""
    faults = []
    for name, body in (("piston", build.piston), ("block", build.block)):
        if not body.rigid and body.modes:
            faults.append(
                f"{name}.modes: expected 0 or a rigid {name} with motion_in_space, got "
                f"{body.modes:g}"
            )
    beside = {
        "floating_pin": build.floating_pin,
        "mounted": build.mounted,
        "start": build.start,
    }
    faults += [
        f"{name}: expected nothing with motion_in_space, got a value"
        for name, given in beside.items()
        if given
    ]
    sheet = build.piston.rigid
    moments = {"inertia_x": space.inertia_x, "inertia_y": space.inertia_y}
    if sheet is None:
        return faults + [
            f"motion_in_space.{name}: expected nothing with a mesh, got a value"
            for name in sorted(space.model_fields_set)
        ]
    missing = [name for name, value in moments.items() if value is None]
    if missing:
        keys = [f"motion_in_space.{name}" for name in missing]
        return [*faults, _missing(keys, "with a rigid piston")]
    low, middle, high = np.linalg.eigvalsh(space.tensor(sheet.inertia))
    if low <= 0.0 or high > (1 + 1e-9) * (low + middle):
        faults.append(
            "motion_in_space: expected positive principal moments, each at most the sum of the "
            f"others, got {low:.4g}, {middle:.4g}, {high:.4g} kg.m2"
        )
    return faults


def _missing(keys: list[str], context: str) -> str:
    """Return a line about each missing key."""
    return "\n".join(f"{key}: expected a value {context}, got nothing" for key in keys)


def _faults_of_bosses(piston: Piston, boss_modes: int) -> list[str]:
    """Return the faults of the flexible bosses of a piston."""
    faults = []
    if isinstance(piston.modes, float):
        faults.append(f"piston.modes: expected a number with boss_modes, got {piston.modes:g}")
    elif not 0 < boss_modes < piston.modes:
        faults.append(
            f"floating_pin.boss_modes: expected 1 to {piston.modes - 1} of {piston.modes} modes, "
            f"got {boss_modes}"
        )
    if piston.tie != "rbe3":
        faults.append(f"piston.tie: expected 'rbe3' with floating_pin, got {piston.tie!r}")
    if piston.basis not in (films := ("smooth_pressure_modes", "pressure_modes")):
        wanted = " or ".join(map(repr, films))
        faults.append(f"piston.basis: expected {wanted} with floating_pin, got {piston.basis!r}")
    if piston.modes_off:
        got = piston.modes_off
        faults.append(f"piston.modes_off: expected no entry with floating_pin, got {got}")
    return faults


Chosen = TypeVar("Chosen", Bodies, Build)


def read_options(options: dict[str, Any], folder: Path | str, kind: type[Chosen] = Build) -> Chosen:
    """Validate a build table.

    Parameters
    ----------
    options : dict
        As in the case file, units as text.
    folder : Path
        Where paths start.
    kind : {Build, Bodies}

    Returns
    -------
    Build or Bodies
        In SI, paths absolute.

    Raises
    ------
    BadInput
        With every fault: path, value, what is allowed.
    """
    try:
        build = kind.model_validate(options)
    except ValidationError as error:
        raise BadInput(sentences(error, kind)) from None
    faults = []
    if build.piston:
        ends = ("skirt_lower", build.piston.skirt_lower), ("skirt_upper", build.piston.skirt_upper)
        faults += _faults_of_body("piston", build.piston, *ends, folder)
    if build.block:
        ends = ("bore_lower", build.block.bore_lower), ("bore_upper", build.block.bore_upper)
        faults += _faults_of_body("block", build.block, *ends, folder)
    if build.start:
        faults += _resolve(build, "start", "start", folder)
    if build.floating_pin and (eye := build.floating_pin.small_end):
        faults += _resolve(eye, "mesh", "floating_pin.small_end.mesh", folder)
    for name, table in (("gas", build.gas), ("speed", build.speed)):
        if table and table.file:
            faults += _resolve(table, "file", f"{name}.file", folder)
    if faults:
        raise BadInput(faults)
    return build


SOURCES = ("mesh", "stiffness", "mass", "reduced", "train_on")
"""Keys of a body that name a file."""


def _faults_of_body(
    name: str,
    body: Piston | Block,
    lower: tuple[str, float | None],
    upper: tuple[str, float | None],
    folder: Path | str,
) -> list[str]:
    """Return the faults of a body's modes, files and ends, and make its paths absolute.

    `lower` and `upper` are key and height [m] of the ends.
    """
    faults = []
    most = MOST_MODES if isinstance(body.modes, float) else body.modes
    unknown = sorted({n for n in body.modes_off if n > most})
    if unknown:
        numbers = ", ".join(map(str, unknown))
        faults.append(f"{name}.modes_off: expected at most {most} modes, got {numbers}")
    for source in SOURCES:
        path = getattr(body, source)
        if path:
            faults += _resolve(body, source, f"{name}.{source}", folder)
    for table in body.profiles:
        faults += _resolve(table, "file", f"{name}.profiles", folder)
    (low_key, low), (high_key, high) = lower, upper
    if low is not None and high is not None and low >= high:
        faults.append(
            f"{name}.{low_key}: expected a height below {high_key} = {high:g} m, got {low:g} m"
        )
    return faults


def _resolve(table: BaseModel, key: str, where: str, folder: Path | str) -> list[str]:
    """Make a path absolute; a sentence if there is no such file."""
    given = getattr(table, key)
    path = (Path(folder) / given).resolve()
    setattr(table, key, str(path))
    return [] if path.is_file() else [f"{where}: expected a file in {folder}, got {given!r}"]
