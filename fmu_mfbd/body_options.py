"""Build options of one body: its source, modes, surfaces and measured shapes."""

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, WithJsonSchema, model_validator

from ..master.fmi.option_classes import ADVANCED, Flag, with_meanings
from ..master.fmi.quantities import in_unit, to_si
from .finite_elements.regions import Bore, Cylinder, Plane, Region

Count = Annotated[int, Field(ge=4, le=400)]


Length = Annotated[float, in_unit("m")]


Angle = Annotated[float, in_unit("rad")]


Pressure = Annotated[float, in_unit("Pa")]


Density = Annotated[float, in_unit("kg/m^3")]


Mass = Annotated[float, in_unit("kg")]


Inertia = Annotated[float, in_unit("kg*m^2")]


Number = Annotated[float, in_unit("1")]


Expansion = Annotated[float, in_unit("1/K")]


Temperature = Annotated[float, in_unit("K")]


LengthUnit = Annotated[float, in_unit("m", alone=True)]
AngleUnit = Annotated[float, in_unit("rad", alone=True)]
PressureUnit = Annotated[float, in_unit("Pa", alone=True)]
StiffnessUnit = Annotated[float, in_unit("N/m", alone=True)]
MassUnit = Annotated[float, in_unit("kg", alone=True)]
TimeUnit = Annotated[float, in_unit("s", alone=True)]
AngularSpeedUnit = Annotated[float, in_unit("rad/s", alone=True)]
"""Units of the numbers of a file, "mm" or "1 mm"."""
WITH_MATERIALS = (".inp", ".bdf", ".nas", ".fem", ".dat", ".cdb")
"""Suffixes of mesh files that may have materials."""
FILE = "file"
"""Mark of an option that names a file."""


MOST_MODES = 200
"""Maximum number of modes of a body."""


ERROR_RANGE = (1e-4, 0.5)
"""Range of the expected error that determines the number of modes [-]."""


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


WITH_REDUCED = {"reduced", "modes", "tie", "pin_offset", "profiles", "orders", "shape"}
"""Options of a reduced body of a file. `modes` is the number in it, and bosses need `tie`."""


ModeCount = Annotated[
    int | float,
    PlainValidator(_mode_count),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "integer", "minimum": 0, "maximum": MOST_MODES},
                {"type": ["number", "string"], "unit": "1"} | dict(zip(("ge", "le"), ERROR_RANGE)),
            ]
        }
    ),
]
"""Number of modes, or the error that chooses it, as a float."""


Direction = Literal["x", "y", "z", "-x", "-y", "-z"]


STRICT = ConfigDict(extra="forbid", allow_inf_nan=False, json_schema_extra=with_meanings)


class Options(BaseModel):
    """Table of options."""

    model_config = STRICT

    @model_validator(mode="after")
    def _consistent(self):
        if faults := self.contradictions():
            raise ValueError("\n".join(faults))
        return self

    def contradictions(self) -> list[str]:
        """Return a sentence for each fault of several keys together."""
        return []


class PlacedMesh(Options):
    """Part, unit and axes of a mesh file."""

    mesh_unit: Annotated[LengthUnit, Field(gt=0)] = 1.0
    """Length unit of the mesh file, e.g. "1 mm"."""
    axes: tuple[Direction, Direction, Direction] = ("x", "y", "z")
    """Directions of the mesh file that correspond to x, y and z: thrust side, towards the head,
    along pin and crank.
    """
    origin: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """Position of the project's origin in the mesh file."""
    part: str | None = None
    """Part of the mesh file, by its name or number: part, instance, body, element set, component,
    physical volume, group or Nastran property. Default: the whole file.
    """

    def contradictions(self) -> list[str]:
        """Return the fault of a part without a mesh."""
        mesh = getattr(self, "mesh", None)
        if self.part is None or mesh and not mesh.endswith(".csv"):
            return []
        return [f"part: expected it with a mesh of elements, got mesh = {mesh!r}"]


class Surface(Options):
    """Surface defined by geometry, in the project's axes.

    It is a cylinder about y with its ends, a bore about z, or a plane across y.
    """

    shape: Literal["cylinder", "bore", "plane"]
    """Cylinder about y with ends, bore about z of any length, or plane across y."""
    radius: Length | None = None
    """Radius of a cylinder or bore."""
    lower: Length | None = None
    """Lower end of a cylinder, above pin point A for the piston and above the crank axis for the
    block.
    """
    upper: Length | None = None
    """Upper end of a cylinder, from the same origin."""
    height: Length | None = None
    """Height of a plane, from the same origin."""

    def contradictions(self) -> list[str]:
        """Return the missing keys of the shape."""
        needed = {
            "cylinder": ("radius", "lower", "upper"),
            "bore": ("radius",),
            "plane": ("height",),
        }
        return missing_keys(self, needed[self.shape], f"for a {self.shape}")

    def region(self) -> Region:
        """Return the surface as `mesh.read_mesh` takes it."""
        sizes = self.model_dump(exclude={"shape"}, exclude_none=True)
        regions = {"cylinder": Cylinder, "bore": Bore, "plane": Plane}
        return regions[self.shape](**sizes)


class RigidPiston(Options):
    """Data sheet of a rigid piston."""

    mass: Annotated[Mass, Field(gt=0)]
    """Mass without the pin."""
    centre: tuple[Length, Length]
    """Centre of mass (x, y): x from the skirt axis, y above pin point A."""
    inertia: Annotated[Inertia, Field(gt=0)]
    """Moment of inertia about the axis through the centre of mass along the pin."""
    radius: Annotated[Length, Field(gt=0)]
    """Radius of the skirt."""


class RigidBlock(Options):
    """Data sheet of a rigid block."""

    radius: Annotated[Length, Field(gt=0)]
    """Radius of the bore."""


class MaterialOptions(Options):
    """Material of a set of elements. An omitted value is that of the body or of the mesh file."""

    density: Annotated[Density, Field(ge=500, le=25000)] | None = None
    """Density of the material."""
    young: Annotated[Pressure, Field(ge=1e8, le=1e12)] | None = None
    """Young's modulus."""
    poisson: Annotated[Number, Field(ge=0, lt=0.5)] | None = None
    """Poisson's ratio."""
    expansion: Annotated[Expansion, Field(ge=0, le=1e-4)] | None = None
    """Coefficient of thermal expansion."""


class NodeDisplacements(Options):
    """Displacements at the nodes of the mesh, see `node_values.read_node_values`."""

    file: Annotated[str, FILE]
    """Results of another program (.csv, .vtu, .frd) with the displacement of each node."""
    length_unit: Annotated[LengthUnit, Field(gt=0)]
    """Unit of the displacements and of the coordinates in the file."""
    field: str | None = None
    """Name of the displacement in a .vtu or .frd. Default: the only one, DISP for .frd."""


class TemperatureField(Options):
    """Temperatures of the body, from which its own hot shape is computed."""

    file: Annotated[str | None, FILE] = None
    """Results of another program (.csv, .vtu, .frd) with the temperature of each node."""
    table: Annotated[str | None, FILE] = None
    """CSV file. The first row holds radii from the axis. Each further row holds a height and its
    temperatures. Heights are above pin point A for the piston and above the crank axis for the
    block.
    """
    length_unit: Annotated[LengthUnit, Field(gt=0)]
    """Unit of coordinates, radii and heights in the file."""
    temperature_unit: Literal["degC", "K"]
    """Unit of the temperatures in the file."""
    reference: Annotated[Temperature, Field(ge=200, le=600)] = 293.15
    """Temperature of the body in the shape of the mesh."""
    field: str | None = None
    """Name of the temperature in a .vtu or .frd. Default: the only one, NDTEMP for .frd."""

    def contradictions(self) -> list[str]:
        """Return the fault of no source, or two, and of a name in a table."""
        faults = either(self, "file", "table")
        if self.table and self.field:
            faults.append("field: expected it with file only, got it with table")
        return faults


class Body(PlacedMesh, MaterialOptions):
    """Options of a body.

    `stiffness` and `mass` are matrices of another program (`matrices.read_matrix`). They replace
    density, young and poisson. `mesh` or a CSV file (`point_cloud.read_nodes`) then gives the nodes
    and their surfaces. `reduced` is a file of `piston-cosim reduce` (.npz). It replaces mesh,
    material, basis and modes. `rigid` is a data sheet (`RigidPiston`, `RigidBlock`) that also needs
    the ends of the surface.
    """

    ENDS: ClassVar[tuple[str, str]]

    mesh: Annotated[str | None, FILE] = None
    """Mesh of 10-node tetrahedra (.msh, .inp, .bdf, .cdb, .dat, .med, also .xz, .gz). For a body of
    matrices, also a CSV file of nodes.
    """
    reduced: Annotated[str | None, FILE] = None
    """Reduced body, a file of `piston-cosim reduce` (.npz). It replaces mesh, material, basis and
    modes.
    """
    rigid: RigidPiston | RigidBlock | None = None
    """Data sheet of a rigid body. It replaces the mesh."""
    surfaces: dict[str, Surface] = {}
    """Surfaces defined by geometry, for a mesh file that does not name them."""
    materials: dict[str, MaterialOptions] = {}
    """Materials of sets of elements, by the name of a set, a part or a material of the mesh file.
    Other elements have the material of the body, or else that of the mesh file.
    """
    hot_shape: NodeDisplacements | None = None
    """Displacements at the nodes by another program, which become the hot shape of skirt or bore.
    The rigid motion of a piston's pin bores is taken out, that of a bore stays.
    """
    temperature_field: TemperatureField | None = None
    """Temperatures from which the hot shape of skirt or bore is computed. Requires `expansion`."""
    stiffness: Annotated[str | None, FILE] = None
    """Stiffness matrix of another program (.mtx, .pch, .bdf)."""
    mass: Annotated[str | None, FILE] = None
    """Mass matrix of another program (.mtx, .pch, .bdf)."""
    stiffness_unit: Annotated[StiffnessUnit, Field(gt=0)] | None = None
    """Unit of the stiffness matrix."""
    mass_unit: Annotated[MassUnit, Field(gt=0)] | None = None
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
    train_on: Annotated[str | None, FILE] = None
    """Results file of the earlier run for `trained`. It must hold both nodal forces on the same
    grid.
    """
    modes: ModeCount = 60
    """Number of modes, or the largest relative error of the deflection under smooth pressures, e.g.
    "1 %". 0: rigid. `reduce` prints the larger error under a narrow patch at an edge. An error
    requires smooth_pressure_modes or trained. It excludes the modes of `trained` and `boss_modes`.
    """
    symmetric_film: Flag = False
    """Whether the modes assume that the film is its own mirror image about the thrust plane. About
    half as many smooth pressure modes are then as accurate. A case whose film is not symmetric is
    rejected.
    """
    shape: Literal["cold", "hot"] | None = None
    """Whether the profile of the wall is that at reference_temperature or that of the running
    engine. A hot shape does not grow with the temperatures. Default: cold, with a remark.
    """
    modes_from: Annotated[int, Field(ge=1, le=400)] | None = None
    """Number of lowest modes from which `modes` are selected by their part in the deflection under
    smooth pressures. Requires craig_bampton or characteristic_constraint_modes. Default: no
    selection.
    """

    def contradictions(self) -> list[str]:
        """Return the faults of source, basis and heat."""
        faults = super().contradictions()
        sources = (self.mesh, self.reduced, self.rigid)
        if sum(source is not None for source in sources) != 1:
            return [*faults, "expected one of mesh, reduced and rigid, got none or several"]
        if self.rigid:
            faults += missing_keys(self, self.ENDS, "for a rigid body")
            if "modes" in self.model_fields_set and self.modes:
                faults.append(f"modes: expected 0 for a rigid body, got {self.modes}")
        if self.reduced:
            unused = sorted(self.model_fields_set - WITH_REDUCED)
            faults += [f"{key}: expected nothing with reduced, got a value" for key in unused]
        what, needed = "a mesh", ("density", "young", "poisson")
        if self.stiffness or self.mass or (self.mesh or "").endswith(".csv"):
            what = "a body of matrices"
            needed = ("stiffness", "stiffness_unit", "mass", "mass_unit")
        elif self._materials_of_file():
            needed = ()
        if self.mesh is not None:
            faults += missing_keys(self, needed, f"with {what}")
        return faults + self._faults_of_basis() + self._faults_of_heat(what)

    def _faults_of_basis(self) -> list[str]:
        """Return the faults of basis and number of modes."""
        faults = []
        if (self.basis == "trained") != (self.train_on is not None):
            faults.append("train_on: expected it with basis = 'trained' only, got one of both")
        if isinstance(self.modes, float) and self.basis not in ("smooth_pressure_modes", "trained"):
            faults.append(
                f"modes: expected a number of modes with basis = '{self.basis}', got "
                f"{self.modes:g}; "
                "an error chooses the modes of 'smooth_pressure_modes' and 'trained'"
            )
        lowest = ("craig_bampton", "characteristic_constraint_modes")
        if self.modes_from is not None and self.basis not in lowest:
            expected = " or ".join(map(repr, lowest))
            faults.append(f"modes_from: expected basis = {expected}, got {self.basis!r}")
        elif self.modes_from is not None and self.modes_from < self.modes:
            got = self.modes_from
            faults.append(f"modes_from: expected at least modes = {self.modes}, got {got}")
        return faults

    def _faults_of_heat(self, source: str) -> list[str]:
        """Return the faults of a body that cannot have the hot shape, or has two."""
        faults = []
        if self.hot_shape and self.temperature_field:
            faults.append("temperature_field: expected nothing with hot_shape, got a table")
        if self.has_hot_shape and self.shape == "hot":
            faults.append("shape: expected 'cold' with a hot shape that adds to it, got 'hot'")
        for key in ("hot_shape", "temperature_field", "materials"):
            if self.rigid and getattr(self, key):
                faults.append(f"{key}: expected nothing with a data sheet, got a table")
            if source == "a body of matrices" and key != "hot_shape" and getattr(self, key):
                faults.append(f"{key}: expected nothing with {source}, got a table")
        return faults

    @property
    def is_hot(self) -> bool:
        """Return whether the wall has the shape of the running engine."""
        return self.shape == "hot" or self.has_hot_shape

    @property
    def has_hot_shape(self) -> bool:
        """Return whether a hot shape adds to the profile of the wall."""
        return bool(self.hot_shape or self.temperature_field)

    def _materials_of_file(self) -> bool:
        """Return whether the material may be that of sets, or of a mesh file with materials."""
        name = (self.mesh or "").removesuffix(".gz").removesuffix(".xz")
        return bool(self.materials) or name.endswith(WITH_MATERIALS)

    def most_modes(self) -> int:
        """Return the largest number of modes that the body can have, before it is reduced."""
        if self.rigid:
            return 0
        known = isinstance(self.modes, int) and self.basis != "trained"
        return int(self.modes) if known else MOST_MODES


class ShapeTable(Options):
    """Measured shape in a CSV file, see `tables.profile_table`."""

    file: Annotated[str, FILE]
    """CSV file. The first row holds angles. Each further row holds a height and its values. Heights
    are above pin point A for the piston and above the crank axis for the block.
    """
    angle_unit: Annotated[AngleUnit, Field(gt=0)]
    """Unit of the angles."""
    height_unit: Annotated[LengthUnit, Field(gt=0)]
    """Unit of the heights."""
    value_unit: Annotated[LengthUnit, Field(gt=0)]
    """Unit of the values."""


class Order(Options):
    """Fourier order of a bore distortion, see `profile.fourier_bore`."""

    order: Annotated[int, Field(ge=0, le=40)]
    """Fourier order: 0 growth, 1 offset of the axis, 2 ovality, 4 four bolts."""
    amplitude: Length
    """Amplitude of the radial widening."""
    phase: Angle = 0.0
    """Angle of the largest widening, from the pin axis towards the thrust side."""


class SlidingLayer(NamedTuple):
    """Layer between pin bores and pin of the tie `sliding`.

    Parameters
    ----------
    stiffness : float
        [Pa/m]
    part : str
        Part of the bores that bears.
    cells : (int, int)
        Cells around this part, and along a boss.
    """

    stiffness: float
    part: str
    cells: tuple[int, int]


SLIDING_LAYER = SlidingLayer(1e15, "upper half", (36, 16))
"""Our own choice: gas presses this half on the pin, and a tenfold stiffness changes the skirt
compliance by less than 1 %.
"""


class Piston(Body):
    """Options of the piston.

    The mesh origin is on the skirt axis at the height of pin point A. Surfaces: `skirt`, `crown`,
    `pin_bore`.
    """

    ENDS = ("skirt_lower", "skirt_upper")
    tie: Literal["sliding", "rbe2", "rbe3"] | None = None
    """Connection of the pin bores to pin point A. It affects the skirt compliance more than the
    choice of modes. `sliding` holds the upper half of both bores along its normal on a rigid pin,
    and leaves them free along and around the pin. `rbe2` ties every node, and `rbe3` the mean
    motion of both bores. Default: `sliding`, `rbe3` for the bosses of a floating pin, or `rbe2` if
    the bores of the mesh are no cylinders.
    """
    boss_length: Annotated[Length, Field(gt=0)] | None = None
    """Length of each boss that bears on the pin with `sliding`, from its inner end. It affects the
    skirt compliance as much as sliding does. Other ties do not use it. Default: the diameter of the
    pin bore, or the length of the boss in the mesh if it is less.
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


class BoreFromOutside(Options):
    """Grid of a bore whose deflection another participant computes.

    Angles start at the thrust line like those of the film grid. Heights range from bore_lower to
    bore_upper.
    """

    around: Annotated[int, Field(ge=8, le=400)] = 24
    """Number of angles."""
    axial: Annotated[int, Field(ge=8, le=400)] = 24
    """Number of heights, both ends included."""


class Block(Body):
    """Options of the block.

    The mesh origin is on the bore axis at the height of the crank axis. Surfaces: `bore`, `bolts`.
    """

    ENDS = ("bore_lower", "bore_upper")
    rigid: RigidBlock | None = None
    """Data sheet of a rigid block. It replaces the mesh."""
    bore_lower: Length | None = None
    """Lower end of the bore above the crank axis. Default: that of the surface in the mesh."""
    bore_upper: Length | None = None
    """Upper end of the bore above the crank axis. Default: that of the surface in the mesh."""
    stations: int = Field(64, ge=8, le=400, json_schema_extra=ADVANCED)
    """Number of heights in the table of bore modes."""
    bore_from_outside: BoreFromOutside | None = None
    """Grid of a bore whose deflection another participant computes. It provides bore_deflection and
    receives force_on_bore and force_on_deck. Requires `rigid` and `mounted = true`.
    """
    profiles: list[ShapeTable] = []
    """Measured widenings of the bore."""
    orders: list[Order] = Field([], json_schema_extra=ADVANCED)
    """Fourier orders of the bore distortion."""

    @model_validator(mode="after")
    def _bore_of_outside(self):
        if self.bore_from_outside:
            self.stations = self.bore_from_outside.axial
        return self

    def contradictions(self) -> list[str]:
        """Return also the faults of a bore whose deflection comes from outside."""
        faults = super().contradictions()
        if self.bore_from_outside and not self.rigid:
            faults.append(
                "rigid: expected a table with bore_from_outside, got nothing; the deflection "
                "of the bore is an input"
            )
        if self.bore_from_outside and "stations" in self.model_fields_set:
            faults.append("stations: expected nothing with bore_from_outside, got a value")
        return faults


def either(table: BaseModel, first: str, second: str) -> list[str]:
    """Return a sentence unless a table has exactly one of two keys."""
    has_both = getattr(table, first) is not None
    if has_both != (getattr(table, second) is not None):
        return []
    return [f"expected either {first} or {second}, got {'both' if has_both else 'neither'}"]


def missing_keys(table: BaseModel, keys: Iterable[str], context: str) -> list[str]:
    """Return a sentence for each key without a value."""
    missing = [key for key in keys if getattr(table, key) is None]
    return [f"{key}: expected a value {context}, got nothing" for key in missing]
