"""Build options of the body FMU, which its build.json contains."""

from dataclasses import MISSING, dataclass, fields, is_dataclass
from types import UnionType
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np

from ..geometry.pin import CRANK_SURFACES, PIN_SURFACES
from ..geometry.profile import BoreOrder, HotShape, MeasuredShape
from .speed_table import SpeedTable
from .start_state import StartState
from .tables import GasTable


@dataclass(frozen=True)
class PistonOptions:
    """The piston of the FMU.

    Parameters
    ----------
    file : str
        File of the reduced body in the FMU's resources.
    modes : int
    pin_offset : float
        x of pin point A from the skirt's axis [m].
    profiles : tuple of MeasuredShape
        Gaps that add to barrel and ovality.
    hot : HotShape, optional
        On the film grid of the hot skirt.
    is_hot : bool
        Whether profiles or hot shape are those of the running engine, so that the skirt does not
        grow.
    """

    file: str
    modes: int
    pin_offset: float
    profiles: tuple[MeasuredShape, ...] = ()
    hot: HotShape | None = None
    is_hot: bool = False


class BoreGrid(NamedTuple):
    """Points around and along a bore, of fields that another participant exchanges with it."""

    around: int
    axial: int


@dataclass(frozen=True)
class BlockOptions:
    """The cylinder block of the FMU.

    Parameters
    ----------
    file : str
        File of the reduced body in the FMU's resources.
    modes : int
    orders : tuple of BoreOrder
    profiles : tuple of MeasuredShape
        Widenings that add to those orders.
    bore_from_outside : BoreGrid, optional
        Grid on which another participant gives the deflection of the bore. None: modes give it.
    hot : HotShape, optional
        On the table of the bore.
    is_hot : bool
        Whether orders, profiles or hot shape are those of the running engine, so that the bore does
        not grow.
    """

    file: str
    modes: int
    orders: tuple[BoreOrder, ...] = ()
    profiles: tuple[MeasuredShape, ...] = ()
    bore_from_outside: BoreGrid | None = None
    hot: HotShape | None = None
    is_hot: bool = False


@dataclass(frozen=True)
class WallTemperature:
    """Temperature of a wall.

    Parameters
    ----------
    level : float
        Start value of the input with its level [K].
    rise : float
        Upper minus lower edge, linear about the level [K].
    table : MeasuredShape, optional
        Differences from the level [K].
    varies : bool
        Whether a field input has the temperature.
    """

    level: float
    rise: float = 0.0
    table: MeasuredShape | None = None
    varies: bool = False


@dataclass(frozen=True)
class WallTemperatures:
    """Temperatures of skirt and bore.

    Parameters
    ----------
    skirt, bore : WallTemperature
    stations : int
        Heights of a field input of the bore.
    """

    skirt: WallTemperature
    bore: WallTemperature
    stations: int


@dataclass(frozen=True)
class SurfaceOptions:
    """A film surface: rows of the film grid that belong to a separate film.

    Parameters
    ----------
    name : str
        First word of its variables; "" of the whole skirt, the one surface with plain names.
    first, last : int
        Rows along the skirt, from 0; `last` is not among them.
    """

    name: str
    first: int
    last: int

    @property
    def prefix(self) -> str:
        """Return the prefix of its variables' names."""
        return f"{self.name}." if self.name else ""


SKIRT = "skirt"
"""Name of the whole skirt's surface where there are others."""


@dataclass(frozen=True)
class FloatingPin:
    """Films of a floating pin.

    Parameters
    ----------
    grid : (int, int)
        Cells around and along each shell.
    boss_length, small_end_length : float
        Lengths of one boss and of the rod's eye along the pin [m].
    bosses : str
        File of the piston's modes in its bosses, among the FMU's resources; "" of a rigid piston.
    pin_shapes : int
        Number of shapes in which the pin tilts and bends. 0: it remains parallel to its shells.
    small_end : str
        File of the modes of the rod's eye, among the FMU's resources; "" of a rigid eye.
    small_end_modes : int
    """

    grid: tuple[int, int]
    boss_length: float
    small_end_length: float
    bosses: str = ""
    pin_shapes: int = 0
    small_end: str = ""
    small_end_modes: int = 0

    def lengths(self) -> dict[str, float]:
        """Return the length of each surface of `PIN_SURFACES` [m]."""
        return dict(zip(PIN_SURFACES, (self.boss_length, self.boss_length, self.small_end_length)))


@dataclass(frozen=True)
class CrankBearing:
    """A film of the crank.

    Parameters
    ----------
    name : str
        One of `CRANK_SURFACES`.
    grid : (int, int)
        Cells around and along the shell.
    length : float
        Along the crank's axis [m].
    shell : str
        File of the modes of its shell, among the FMU's resources; "" of a rigid shell.
    modes : int
    """

    name: str
    grid: tuple[int, int]
    length: float
    shell: str = ""
    modes: int = 0


@dataclass(frozen=True)
class InSpace:
    """Inertia of a rigid piston that moves in space, in addition to that in its plane.

    Parameters
    ----------
    first_moment_z : float
        Mass times z of the centre of mass from A [kg m].
    inertia : ndarray, shape (3, 3)
        Tensor about A [kg m2].
    """

    first_moment_z: float
    inertia: np.ndarray


class FilmGrid(NamedTuple):
    """Fields of a film surface: what their names begin with, and their shape."""

    prefix: str
    shape: tuple[int, int]


@dataclass(frozen=True)
class BuildOptions:
    """All of it, in SI.

    Parameters
    ----------
    grid : (int, int)
        Film grid cells around and along the skirt.
    piston : PistonOptions
    block : BlockOptions
    gas : GasTable, optional
        Added to the input `gas_pressure`, unless the parameter `gas_source` chooses one of both.
    speed : SpeedTable, optional
        Table that replaces the input `crank_speed`.
    start : StartState, optional
        State that replaces the parameters start_*.
    skirt : list of list of int, optional
        Cells of the film grid with the skirt under them (1) and without (0), one row a
        circumferential cell, for who builds a film to it; None where it is not known, or whole.
    surfaces : tuple of SurfaceOptions
        From below; empty: the whole skirt is one.
    floating_pin : FloatingPin, optional
        None: the pin is tied.
    mounted : bool
        Whether another participant moves the block and gets the forces on it.
    in_space : InSpace, optional
        None: the piston moves in its plane.
    crank_bearings : tuple of CrankBearing
        In the order of `CRANK_SURFACES`.
    symmetric_film : bool
        Whether the modes assume that the film is its own mirror image about the thrust plane.
    temperatures : WallTemperatures, optional
        None: inputs give a uniform temperature of each wall, and the oil temperature is no output.
    slides : tuple of str
        Displacements in joints, of `force_elements.SLIDES`.
    """

    grid: tuple[int, int]
    piston: PistonOptions
    block: BlockOptions
    gas: GasTable | None = None
    speed: SpeedTable | None = None
    start: StartState | None = None
    skirt: list[list[int]] | None = None
    surfaces: tuple[SurfaceOptions, ...] = ()
    floating_pin: FloatingPin | None = None
    mounted: bool = False
    in_space: InSpace | None = None
    crank_bearings: tuple[CrankBearing, ...] = ()
    symmetric_film: bool = False
    temperatures: WallTemperatures | None = None
    slides: tuple[str, ...] = ()

    def film_surfaces(self) -> tuple[SurfaceOptions, ...]:
        """Return all film surfaces of the skirt, at least one."""
        _, along = self.grid
        name = SKIRT if self.pin_grids() else ""
        return self.surfaces or (SurfaceOptions(name, 0, along),)

    def pin_grids(self) -> tuple[FilmGrid, ...]:
        """Return names and shapes of the fields of the surfaces of a floating pin and of the crank.

        It is empty for a tied pin without films of the crank.
        """
        pin = self.floating_pin
        return (
            *(FilmGrid(f"{name}.", pin.grid) for name in PIN_SURFACES if pin),
            *(FilmGrid(f"{one.name}.", one.grid) for one in self.crank_bearings),
        )

    def bearing_coordinates(self) -> int:
        """Return the number of coordinates of pin, crank, their shells and slides."""
        pin = self.floating_pin
        of_crank = sum(2 + one.modes for one in self.crank_bearings)
        of_pin = 5 + 2 * pin.pin_shapes + pin.small_end_modes if pin else 0
        return of_pin + of_crank + len(self.slides)

    def crank_surfaces(self) -> tuple[str, ...]:
        """Return the names of the crank's film surfaces."""
        return tuple(one.name for one in self.crank_bearings)

    def absent_parts(self) -> tuple[str, ...]:
        """Return how names of outputs begin whose part of pin, eye or crank is absent."""
        pin = self.floating_pin
        parts = {
            "pin_displacement": pin,
            "pin_angle": pin,
            "pin_rotation": pin,
            "small_end": pin,
            "pin_tilt": pin and pin.pin_shapes,
            "pin_bending": pin and pin.pin_shapes,
            "small_end_widening": pin and pin.small_end_modes,
            **{f"{name}_widening": 0 for name in CRANK_SURFACES},
        }
        parts |= {f"{one.name}_widening": one.modes for one in self.crank_bearings}
        there = parts | dict.fromkeys(self.crank_surfaces(), 1)
        return tuple(name for name in (*parts, *CRANK_SURFACES) if not there.get(name))

    def film_grids(self) -> tuple[FilmGrid, ...]:
        """Return the names and shapes of the fields of the skirt's surfaces."""
        around, _ = self.grid
        return tuple(
            FilmGrid(one.prefix, (around, one.last - one.first)) for one in self.film_surfaces()
        )

    def to_json(self) -> dict[str, Any]:
        """Return the content of build.json: all values that differ from their defaults.

        If there are several surfaces, it also has the skirt of each, NAME.skirt.
        """
        parts = {
            f"{one.prefix}skirt": [row[one.first : one.last] for row in self.skirt]
            for one in self.film_surfaces()
            if one.name and self.skirt is not None
        }
        return _written(self) | parts

    @classmethod
    def from_json(cls, content: dict[str, Any]) -> "BuildOptions":
        """Return the options from the content of build.json."""
        return _read(cls, content)


def _written(value: Any) -> Any:
    """Return a value of an option as numbers, texts, lists and tables."""
    if is_dataclass(value):
        return {
            one.name: _written(member)
            for one, member in ((one, getattr(value, one.name)) for one in fields(value))
            if one.default is MISSING or member != one.default
        }
    if isinstance(value, tuple | list):
        return [_written(one) for one in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def _read(hint: Any, value: Any) -> Any:
    """Return the option of this type that `_written` wrote."""
    if value is None:
        return None
    if isinstance(hint, UnionType):
        kind, _ = get_args(hint)
        return _read(kind, value)
    if get_origin(hint) is tuple:
        kind, _ = get_args(hint)
        return tuple(_read(kind, one) for one in value)
    if hasattr(hint, "__dataclass_fields__"):
        hints = get_type_hints(hint)
        return hint(
            **{name: _read(hints[name], one) for name, one in value.items() if name in hints}
        )
    if hasattr(hint, "_fields"):
        return hint(*map(_read, get_type_hints(hint).values(), value))
    return np.array(value, dtype=float) if hint is np.ndarray else value
