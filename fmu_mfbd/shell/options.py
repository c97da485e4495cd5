"""What a case file may say about the elastic shell of a bearing."""

from pathlib import Path
from typing import Annotated

from pydantic import Field

from ..body_options import MOST_MODES, Count, Length
from ..options import BuildTable, RoundShell, shell_faults


class BuildShell(RoundShell, BuildTable):
    """Build options of the FMU of a shell.

    The mesh origin is on its axis z at mid-length. Surfaces: bore, and held, which is fixed.
    """

    grid: tuple[Count, Count] = (72, 8)
    """Number of cells around and along the shell, equal to the grid of its film."""
    length: Annotated[Length, Field(gt=0)]
    """Length of the film along the shell."""
    modes: Annotated[int, Field(ge=1, le=MOST_MODES)] = 60
    """Number of modes."""

    def faults(self, folder: Path) -> list[str]:
        """Return the faults of modes and mesh; the path becomes absolute."""
        return shell_faults("", self.modes, self.grid) + super().faults(folder)
