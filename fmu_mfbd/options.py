"""Options of a case file for the bodies: the table `[participants.X.build]`."""

from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import BaseModel, Field

from ..master.fmi.errors import BadInput
from ..master.fmi.option_classes import Flag, validated
from .body_options import (
    FILE,
    MOST_MODES,
    Angle,
    AngleUnit,
    AngularSpeedUnit,
    Block,
    Count,
    Density,
    Inertia,
    Length,
    Number,
    Options,
    Piston,
    PlacedMesh,
    Pressure,
    PressureUnit,
    Surface,
    TimeUnit,
    either,
    missing_keys,
)
from .force_elements import SLIDES
from .geometry.pin import CRANK_SURFACES, PIN_SURFACES
from .geometry.pin_shapes import MOST_SHAPES
from .temperature_options import Temperatures


class Table(Options):
    """Table of two columns, in a CSV file (comma or semicolon) or as `points` in the case."""

    file: Annotated[str | None, FILE] = None
    """CSV file with two columns."""
    points: list[tuple[float, float]] | None = None
    """The two columns as a list of pairs."""
    strokes: Literal[2, 4] = 4
    """Number of strokes of a cycle."""

    def contradictions(self) -> list[str]:
        """Return the faults of source and length."""
        faults = either(self, "file", "points")
        if self.points is not None and len(self.points) < 2:
            faults.append(f"points: expected at least two points, got {len(self.points)}")
        return faults


class Gas(Table):
    """Gas pressure over crank angle, see `tables.gas_table`.

    The parameter `gas_source` selects whether it adds to the input `gas_pressure`.
    """

    angle_unit: Annotated[AngleUnit, Field(gt=0)]
    """Unit of the first column, the crank angle."""
    pressure_unit: Annotated[PressureUnit, Field(gt=0)]
    """Unit of the second column, the gauge pressure."""


class Speed(Table):
    """Crank speed over time or crank angle, see `speed_table.speed_table`.

    It replaces the input `crank_speed`.
    """

    time_unit: Annotated[TimeUnit, Field(gt=0)] | None = None
    """Unit of the first column if it is time."""
    angle_unit: Annotated[AngleUnit, Field(gt=0)] | None = None
    """Unit of the first column if it is crank angle."""
    speed_unit: Annotated[AngularSpeedUnit, Field(gt=0)]
    """Unit of the second column, the crank speed."""

    def contradictions(self) -> list[str]:
        """Return the faults of a table over time or over crank angle."""
        return super().contradictions() + either(self, "time_unit", "angle_unit")


class FilmSurface(Options):
    """Rows of the film grid that a separate lubrication FMU covers."""

    name: Annotated[str, Field(pattern="^[a-z][a-z0-9_]*$", max_length=40)]
    """Prefix of its variables, as in NAME.film_thickness."""
    rows: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]]
    """First and last row of `grid` along the skirt, counted from 1 at the lower edge."""

    def contradictions(self) -> list[str]:
        """Return the fault of too few rows."""
        first, last = self.rows
        if last - first + 1 >= LEAST_ROWS:
            return []
        return [f"rows: expected at least {LEAST_ROWS} rows, got {last - first + 1}"]


class BuildTable(Options):
    """Build options of an FMU."""

    def faults(self, folder: Path) -> list[str]:
        """Return the faults that depend on files; paths become absolute."""
        return resolve(self, folder)


class ElasticShell(PlacedMesh):
    """Material and modes of a flexible shell under a film."""

    young: Annotated[Pressure, Field(ge=1e8, le=1e12)]
    """Young's modulus."""
    poisson: Annotated[Number, Field(ge=0, lt=0.5)]
    """Poisson's ratio."""
    modes: Annotated[int, Field(ge=0, le=MOST_MODES)] = 60
    """Number of modes. 0: rigid."""


class SmallEnd(ElasticShell):
    """Flexible small end of the rod.

    The mesh origin is on its axis at mid-length, with the shank towards -y. Surfaces: eye (the
    bore) and cut, where the rigid rod holds the shank.
    """

    density: Annotated[Density, Field(ge=500, le=25000)]
    """Density of the material, for the inertia of the modes. Mass and inertia of the rod are
    parameters.
    """
    mesh: Annotated[str, FILE]
    """Mesh of 10-node tetrahedra (.msh, .inp, .bdf, .cdb, .med, also .xz, .gz)."""
    surfaces: dict[Literal["eye", "cut"], Surface] = {}
    """Surfaces defined by geometry (bore or plane), for a mesh file that does not name them."""


class RingMesh(Options):
    """Ring about z that is meshed without a mesh file."""

    inside: Annotated[Length, Field(gt=0)]
    """Radius of the bore."""
    outside: Annotated[Length, Field(gt=0)]
    """Outer radius."""
    length: Annotated[Length, Field(gt=0)] | None = None
    """Length along z. Default: the length of the film."""
    held: Annotated[Angle, Field(gt=0, le=2 * np.pi * (1 + 1e-9))] = 2 * np.pi
    """Arc about +y over which the outer surface is fixed. Default: the whole outer surface."""
    cells: tuple[
        Annotated[int, Field(ge=8, le=200)],
        Annotated[int, Field(ge=1, le=20)],
        Annotated[int, Field(ge=1, le=100)],
    ] = (36, 2, 6)
    """Number of blocks of elements around, through the wall and along."""

    def contradictions(self) -> list[str]:
        """Return the faults of wall and arc."""
        faults = []
        if self.outside <= self.inside:
            faults.append(
                f"outside: expected more than inside = {self.inside:g} m, got {self.outside:g} m"
            )
        if (least := 2 * np.pi / self.cells[0]) > self.held:
            faults.append(
                f"held: expected at least one block around, {np.degrees(least):.4g} deg, got "
                f"{np.degrees(self.held):.4g} deg"
            )
        return faults


class RoundShell(ElasticShell):
    """Flexible shell of a bearing, as a mesh or as a ring.

    The mesh origin is on its axis z at mid-length. Surfaces: bore, and held, where a rigid body
    holds the shell. Its axes are those of the film's shell.
    """

    mesh: Annotated[str | None, FILE] = None
    """Mesh of 10-node tetrahedra (.msh, .inp, .bdf, .cdb, .med, also .xz, .gz)."""
    ring: RingMesh | None = None
    """Ring that replaces a mesh file."""
    surfaces: dict[Literal["bore", "held"], Surface] = {}
    """Surfaces defined by geometry (bore or plane), for a mesh file that does not name them."""

    def contradictions(self) -> list[str]:
        """Return the faults of mesh or ring."""
        return super().contradictions() + either(self, "mesh", "ring")


class BearingShell(RoundShell):
    """Flexible shell of big end or main bearing, whose modes have inertia."""

    density: Annotated[Density, Field(ge=500, le=25000)]
    """Density of the material, for the inertia of the modes."""


def shell_faults(where: str, modes: int, grid: tuple[int, int]) -> list[str]:
    """Return a sentence if a shell has too many modes for the cells of its film."""
    around, along = grid
    most = around * along - 2
    if modes <= most:
        return []
    return [f"{where}modes: expected at most {most} for {around} x {along} cells, got {modes}"]


class FloatingPin(Options):
    """Pin that rotates and moves on films in both bosses and in the small end.

    The surfaces boss_left, boss_right and small_end have the fields of a bearing. The skirt is then
    the surface skirt.
    """

    grid: tuple[Count, Count] = (72, 8)
    """Number of cells around and along each of the three shells."""
    boss_length: Annotated[Length, Field(gt=0)]
    """Length of one boss along the pin."""
    small_end_length: Annotated[Length, Field(gt=0)]
    """Length of the small end along the pin."""
    boss_modes: Annotated[int, Field(ge=0, le=190)] = 0
    """Number of piston modes for the deflection of the bosses under their films. 0: rigid bosses.
    `piston.modes` includes them if it is a number. If it is an error, they are added.
    """
    pin_shapes: Annotated[int, Field(ge=0, le=MOST_SHAPES)] = 0
    """Number of shapes in which the pin moves in its shells, in addition to translation. 0: it
    stays parallel to them. 1: it tilts. Each further shape bends the pin.
    """
    small_end: SmallEnd | None = None
    """Mesh of a flexible small end. Default: rigid."""


class CrankBearing(Options):
    """Film between the crank and the rod or block.

    Its surface has the fields of a bearing.
    """

    grid: tuple[Count, Count] = (72, 8)
    """Number of cells around and along the shell."""
    length: Annotated[Length, Field(gt=0)]
    """Length of the bearing along the crank."""
    shell: BearingShell | None = None
    """Flexible shell. Its axis y points towards the piston. The rigid rod or block holds it.
    Default: rigid.
    """


class MotionInSpace(Options):
    """Rigid piston that also moves along its pin, rolls about x and yaws about y.

    The values complete a data sheet and refer to the centre of mass. A mesh needs no values.
    """

    inertia_x: Annotated[Inertia, Field(gt=0)] | None = None
    """Moment of inertia about x."""
    inertia_y: Annotated[Inertia, Field(gt=0)] | None = None
    """Moment of inertia about y."""
    centre_z: Length = 0.0
    """Coordinate z of the centre of mass."""


LEAST_ROWS = 4
"""Minimum number of rows of a film grid along the skirt."""


class Common(BuildTable):
    """Options in addition to those of the bodies."""

    grid: tuple[Count, Count] = (40, 40)
    """Number of cells around and along the skirt."""
    gas: Gas | None = None
    """Gas pressure over crank angle. By default it adds to the input gas_pressure, see the
    parameter gas_source.
    """
    speed: Speed | None = None
    """Crank speed over time or crank angle. It replaces the input crank_speed."""
    start: Annotated[str | None, FILE] = None
    """File of `piston-cosim results snapshot`. It replaces the parameters start_*."""
    film_surfaces: list[FilmSurface] = []
    """Bands of the skirt with separate films, in ascending order. Rows between them have no film.
    Default: one surface for the whole skirt, with variable names without prefix.
    """
    floating_pin: FloatingPin | None = None
    """Films between pin, bosses and rod. They replace a pin that is tied to the piston. Without
    boss_modes the piston is rigid.
    """
    big_end: CrankBearing | None = None
    """Film between the rod and the crank pin, surface big_end. The skirt is then the surface skirt.
    """
    main_bearing: CrankBearing | None = None
    """Film between the crank and the block, surface main_bearing. The crank has its own mass, and
    one bearing carries this cylinder. The skirt is then the surface skirt.
    """
    motion_in_space: MotionInSpace | None = None
    """Motion of the piston along its tied pin, with roll and yaw. Both bodies are rigid."""
    temperatures: Temperatures | None = None
    """Temperatures of skirt and bore, from which the oil temperature of the films and the growth of
    both walls follow. Default: the inputs piston_temperature and bore_temperature.
    """
    mounted: Flag = False
    """The block moves on mounts. Another participant provides block_acceleration_x and other
    inputs, and receives force_on_block_x and other outputs.
    """
    slides: list[str] = []
    """Displacements in joints that are tied otherwise, each an output of this name. Force elements
    declare them.
    """

    def contradictions(self) -> list[str]:
        """Return the faults of shells and film surfaces."""
        faults = []
        if self.floating_pin and (eye := self.floating_pin.small_end):
            faults += shell_faults("floating_pin.small_end.", eye.modes, self.floating_pin.grid)
        for name, one in self.crank_films().items():
            if one.shell:
                faults += shell_faults(f"{name}.shell.", one.shell.modes, one.grid)
        return faults + self._faults_of_surfaces() + self._faults_of_slides()

    def _faults_of_slides(self) -> list[str]:
        """Return the faults of slides that are unknown, or of joints with films."""
        films = {"piston": "floating_pin", "rod": "big_end", "crank": "main_bearing"}
        faults = []
        if len({*self.slides}) < len(self.slides):
            faults.append(f"slides: expected each once, got {', '.join(self.slides)}")
        for name in self.slides:
            if name not in SLIDES:
                faults.append(f"slides: expected one of {', '.join(SLIDES) or 'none'}, got {name}")
            elif getattr(self, film := films[SLIDES[name].acts]):
                faults.append(f"slides: expected a joint without films, got {name} with {film}")
        return faults

    def crank_films(self) -> dict[str, CrankBearing]:
        """Return the films of the crank, by surface."""
        surfaces = {name: getattr(self, name) for name in CRANK_SURFACES}
        return {name: one for name, one in surfaces.items() if one}

    def faults(self, folder: Path) -> list[str]:
        """Return the faults of files and ends of the bodies; paths become absolute."""
        faults = super().faults(folder)
        for name, surface in (("piston", "skirt"), ("block", "bore")):
            if body := getattr(self, name):
                faults += _faults_of_ends(name, body, surface)
        return faults

    def _faults_of_surfaces(self) -> list[str]:
        """Return the faults of names and rows of the skirt's film surfaces."""
        _, along = self.grid
        taken = {*(PIN_SURFACES if self.floating_pin else ()), *self.crank_films()}
        below = 0
        faults = []
        for k, surface in enumerate(self.film_surfaces):
            first, last = surface.rows
            where = f"film_surfaces.{k}"
            if surface.name in taken:
                faults.append(f"{where}.name: expected a new name, got {surface.name!r}")
            if first <= below:
                faults.append(
                    f"{where}.rows: expected rows above {below}, the end of the surface before, "
                    f"got {[first, last]}"
                )
            if last > along:
                faults.append(f"{where}.rows: expected at most {along} rows, got {[first, last]}")
            taken.add(surface.name)
            below = last
        return faults


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

    def contradictions(self) -> list[str]:
        """Return also the fault of no body."""
        faults = super().contradictions()
        if self.piston is None and self.block is None:
            faults.append("build: expected a table piston, block or both, got nothing")
        return faults


class Build(Bodies):
    """Build options of the body FMU, which needs both bodies."""

    piston: Piston = Field(...)
    block: Block = Field(...)

    def contradictions(self) -> list[str]:
        """Return also the faults of options that do not go together."""
        faults = super().contradictions()
        if self.block.bore_from_outside and not self.mounted:
            faults.append("mounted: expected true with block.bore_from_outside, got false")
        others = {
            "motion_in_space": self.motion_in_space,
            "block.bore_from_outside": self.block.bore_from_outside,
        }
        walls = self.temperatures and (self.temperatures.skirt, self.temperatures.bore)
        rejecting = [name for name, option in others.items() if option]
        if walls and any(wall.input for wall in walls) and rejecting:
            got = " and ".join(rejecting)
            faults.append(f"temperatures: expected no input with {got}, got one")
        if self.motion_in_space:
            faults += _faults_in_space(self, self.motion_in_space)
        if self.floating_pin:
            faults += _faults_of_bosses(self.piston, self.floating_pin.boss_modes)
        return faults


IN_SPACE = "its equations are those of a rigid piston on a tied pin in a block at rest"
"""Reason why options do not go with a motion in space."""


def _faults_in_space(build: Build, space: MotionInSpace) -> list[str]:
    """Return the faults of a piston that moves in space."""
    faults = []
    for name, body in (("piston", build.piston), ("block", build.block)):
        if not body.rigid and body.modes:
            faults.append(
                f"{name}.modes: expected 0 or a rigid {name} with motion_in_space, got "
                f"{body.modes:g}; {IN_SPACE}"
            )
    conflicts = {
        "floating_pin": build.floating_pin,
        **build.crank_films(),
        "mounted": build.mounted,
        "start": build.start,
        "slides": build.slides,
    }
    faults += [
        f"{name}: expected nothing with motion_in_space, got a value; {IN_SPACE}"
        for name, value in conflicts.items()
        if value
    ]
    sheet = build.piston.rigid
    if sheet is None:
        return faults + [
            f"motion_in_space.{name}: expected nothing with a mesh, got a value"
            for name in sorted(space.model_fields_set)
        ]
    if space.inertia_x is None or space.inertia_y is None:
        missing = missing_keys(space, ("inertia_x", "inertia_y"), "with a rigid piston")
        return faults + [f"motion_in_space.{one}" for one in missing]
    low, middle, high = sorted((space.inertia_x, space.inertia_y, sheet.inertia))
    if high > (1 + 1e-9) * (low + middle):
        faults.append(
            "motion_in_space: expected moments of inertia, each at most the sum of the others, "
            f"got {low:.4g}, {middle:.4g}, {high:.4g} kg.m2"
        )
    return faults


def _faults_of_bosses(piston: Piston, boss_modes: int) -> list[str]:
    """Return the faults of the bosses of a piston on a floating pin."""
    if piston.rigid or not piston.modes:
        got = f"expected 0 for a rigid piston, got {boss_modes}"
        return [f"floating_pin.boss_modes: {got}"] if boss_modes else []
    faults = []
    if isinstance(piston.modes, float):
        if not boss_modes:
            faults.append(
                "floating_pin.boss_modes: expected at least 1 with piston.modes, got 0; modes of "
                "the skirt alone miss the deflection of the bosses"
            )
    elif not 0 < boss_modes < piston.modes:
        faults.append(
            f"floating_pin.boss_modes: expected 1 to {piston.modes - 1} of {piston.modes} modes, "
            f"got {boss_modes}; modes of the skirt alone miss the deflection of the bosses"
        )
    if piston.tie not in (None, "rbe3"):
        faults.append(
            f"piston.tie: expected 'rbe3' with floating_pin, got {piston.tie!r}; other ties hold "
            "the bores on a rigid pin"
        )
    if piston.boss_length is not None:
        got = f"{1e3 * piston.boss_length:g} mm"
        faults.append(
            f"piston.boss_length: expected nothing with floating_pin, got {got}; "
            "floating_pin.boss_length is that of the films"
        )
    if piston.basis in ("craig_bampton", "characteristic_constraint_modes"):
        faults.append(
            "piston.basis: expected 'smooth_pressure_modes', 'pressure_modes' or 'trained' with "
            f"floating_pin, got {piston.basis!r}; its modes miss the deflection of the bosses"
        )
    return faults


Chosen = TypeVar("Chosen", bound=BuildTable)


def read_options(options: dict[str, Any], folder: Path | str, kind: type[Chosen] = Build) -> Chosen:
    """Validate a build table.

    Parameters
    ----------
    options : dict
        As in the case file, units as text.
    folder : Path
        Folder in which relative paths start.
    kind : type of BuildTable

    Returns
    -------
    BuildTable
        In SI, paths absolute.

    Raises
    ------
    BadInput
        With every fault: path, value, what is allowed.
    """
    build = validated(kind, options)
    if faults := build.faults(Path(folder)):
        raise BadInput(faults)
    return build


def _faults_of_ends(name: str, body: Piston | Block, surface: str) -> list[str]:
    """Return a sentence if the ends of a body's surface are reversed."""
    low_key, high_key = f"{surface}_lower", f"{surface}_upper"
    low, high = getattr(body, low_key), getattr(body, high_key)
    if low is None or high is None or low < high:
        return []
    return [f"{name}.{low_key}: expected a height below {high_key} = {high:g} m, got {low:g} m"]


def resolve(table: BaseModel, folder: Path, where: str = "") -> list[str]:
    """Make all paths of a table absolute; a sentence for each that is no file."""
    faults = []
    for key, field in type(table).model_fields.items():
        value = getattr(table, key)
        if FILE in field.metadata and value is not None:
            path = (folder / value).resolve()
            setattr(table, key, str(path))
            if not path.is_file():
                faults.append(f"{where}{key}: expected a file in {folder}, got {value!r}")
        elif isinstance(value, BaseModel):
            faults += resolve(value, folder, f"{where}{key}.")
        elif isinstance(value, list):
            tables = [one for one in value if isinstance(one, BaseModel)]
            for k, one in enumerate(tables):
                faults += resolve(one, folder, f"{where}{key}.{k}.")
    return faults
