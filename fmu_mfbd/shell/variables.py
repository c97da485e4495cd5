"""Variables of the shell FMU."""

from ...master.fmi.variables import Variable, input_variable, output_variable
from ..variables import PIN_FORCES, PinInputs, declared

DEFLECTION = "bore_deflection"
SCALARS = (
    ("largest_deflection", "m", "Largest deflection of the bore", 1e-5),
    ("widening_x", "m", "Change of the diameter at mid-length along x", 1e-5),
    ("widening_y", "m", "Change of the diameter at mid-length along y", 1e-5),
    ("elastic_energy", "J", "Elastic energy of the shell", 1e-3),
    ("force_x", "N", "Force of the film on the support of the shell along x", 1e3),
    ("force_y", "N", "Force of the film on the support of the shell along y", 1e3),
    ("moment", "N.m", "Moment of the film on the support of the shell about +z", 1.0),
)
"""Outputs, as `output_variable` takes them."""


def variables(grid: tuple[int, int]) -> list[Variable]:
    """Return the variables of a shell under a film on a grid of cells around and along it."""
    forces = declared(PinInputs, input_variable, shape=grid)
    return [
        *(one for one in forces if one.name in PIN_FORCES),
        output_variable(DEFLECTION, "m", "Outward deflection of the bore", 1e-5, grid),
        *(output_variable(*row) for row in SCALARS),
    ]
