"""Build options of a lubrication FMU, which its model class reads from build.json."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from .common.grid import Flags


@dataclass(frozen=True)
class BuildOptions:
    """Checked build options, oil and mask read.

    Parameters
    ----------
    grid : tuple of int
        (n_circumferential, n_axial).
    inputs : tuple of str
        Conditions that are inputs instead of parameters.
    oil : dict
        Start value of each parameter of the chosen oil, in SI.
    surface : str
        One of `parameters.SURFACES`.
    mask : list of list of int, optional
        One row a circumferential cell: 1 = film, 0 = opening; None without openings.
    """

    grid: tuple[int, int]
    inputs: tuple[str, ...] = ()
    oil: Mapping[str, float | str] = field(default_factory=dict)
    mask: list[list[int]] | None = None
    surface: str = "skirt"

    @classmethod
    def read(cls, options: Mapping[str, Any]) -> "BuildOptions":
        """Return the options from the content of build.json."""
        n_circumferential, n_axial = options["grid"]
        lists = dict(grid=(n_circumferential, n_axial), inputs=tuple(options["inputs"]))
        return cls(**{**options, **lists})

    def written(self) -> dict[str, Any]:
        """Return the content of build.json."""
        return asdict(self) | dict(grid=list(self.grid), inputs=list(self.inputs))

    @property
    def open_cells(self) -> Flags | None:
        """Cut-outs of the mask, None without one."""
        return None if self.mask is None else np.array(self.mask) == 0
