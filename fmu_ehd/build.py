"""Options of the lubrication FMU that are fixed when it is built."""

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from master.fmi.errors import BadInput

SMALLEST, LARGEST = 4, 1000  # cells along one side


class Options(BaseModel):
    """Build options.

    Parameters
    ----------
    grid : list of int
        [n_circumferential, n_axial].
    no_fields : bool
        Leave out pressure, asperity_pressure and film_fraction.
    """

    model_config = ConfigDict(extra="forbid")
    grid: tuple[int, int] = (40, 40)
    no_fields: bool = False

    @field_validator("grid")
    @classmethod
    def _size(cls, grid):
        if not all(SMALLEST <= n <= LARGEST for n in grid):
            raise ValueError(f"both numbers of cells must lie between {SMALLEST} and {LARGEST}")
        return grid


def prepare(options, folder, progress):
    """Check the build options; the lubrication FMU needs no offline work.

    Parameters
    ----------
    options : dict
        From the case file.
    folder : pathlib.Path
        Folder of the case (unused: no files).
    progress : callable
        Takes a line of text (unused).

    Returns
    -------
    options : dict
        Complete, JSON-able.
    files : list of pathlib.Path
        Empty.

    Raises
    ------
    BadInput
        With every fault: key, value, what is allowed.
    """
    try:
        return Options(**options).model_dump(mode="json"), []
    except ValidationError as error:
        raise BadInput([f"{'.'.join(map(str, e['loc']))} = {e['input']!r}: {e['msg']}" for e in error.errors()]) from None
