"""Build options of the temperatures of skirt and bore."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from ..master.fmi.option_classes import Flag
from ..master.fmi.quantities import in_unit
from .body_options import FILE, AngleUnit, LengthUnit, Options, missing_keys

LOWEST, HIGHEST = 233.15, 573.15
"""Range of the temperature of a wall, as of the oil [K]."""


def _in_range(kelvin: float) -> float:
    """Return a temperature in range; kelvins and degrees Celsius that are mistaken are outside."""
    if not LOWEST <= kelvin <= HIGHEST:
        raise ValueError(
            f"expected {LOWEST:g} to {HIGHEST:g} K, got {kelvin:g} K = {kelvin - 273.15:g} degC; "
            "check its unit"
        )
    return kelvin


Temperature = Annotated[
    float,
    in_unit("K"),
    AfterValidator(_in_range),
    Field(json_schema_extra={"ge": LOWEST, "le": HIGHEST}),
]
UNITS = ("angle_unit", "height_unit", "temperature_unit")


class Wall(Options):
    """Temperature of a wall: one value, two edges, a table, or a field input.

    Short forms: "120 degC" for `value`, ["110 degC", "150 degC"] for `edges`, "input" for `input`.
    """

    value: Temperature | None = None
    """Even temperature of the wall. It is the start value of piston_temperature or
    bore_temperature.
    """
    edges: tuple[Temperature, Temperature] | None = None
    """Temperatures of the lower and upper edge, linear in height between them."""
    file: Annotated[str | None, FILE] = None
    """CSV file of a table over angle and height. The first row holds angles. Each further row holds
    a height and its temperatures. Heights are above pin point A for the skirt and above the crank
    axis for the bore. They cover the wall.
    """
    angle_unit: Annotated[AngleUnit, Field(gt=0)] | None = None
    """Unit of the angles of the file."""
    height_unit: Annotated[LengthUnit, Field(gt=0)] | None = None
    """Unit of the heights of the file."""
    temperature_unit: Literal["K", "degC"] | None = None
    """Unit of the temperatures of the file."""
    input: Flag = False
    """Whether the temperature is a field input, skirt_temperature_field on the film grid or
    bore_temperature_field at the angles of the film grid and `block.stations` heights.
    """

    @model_validator(mode="before")
    @classmethod
    def _short(cls, value: Any) -> Any:
        if value == "input":
            return {"input": True}
        if isinstance(value, list | tuple):
            return {"edges": value}
        return value if isinstance(value, dict) else {"value": value}

    def contradictions(self) -> list[str]:
        """Return the faults of the source and of its units."""
        forms = {name: getattr(self, name) for name in ("value", "edges", "file", "input")}
        chosen = [name for name, value in forms.items() if value]
        if len(chosen) != 1:
            got = " and ".join(chosen) or "nothing"
            return [f"expected one of value, edges, file and input, got {got}"]
        if self.file:
            return missing_keys(self, UNITS, "with file")
        units = [name for name in UNITS if getattr(self, name) is not None]
        return [f"{one}: expected it with file only, got it with {chosen[0]}" for one in units]


class Temperatures(Options):
    """Temperatures of both walls of the films on the skirt.

    They give the temperature of the oil and the growth of both walls.
    """

    skirt: Wall
    """Temperature of the skirt."""
    bore: Wall
    """Temperature of the bore."""
