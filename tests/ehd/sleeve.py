"""Skirt, oil and steps of the tests that compare numbers with formulas."""

import numpy as np
import pytest

from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.tests.verification.cases.motored import film_after

RADIUS = 31e-3  # [m]
LENGTH = 23e-3  # [m]
WIDTH = 2.0 * np.pi * RADIUS  # [m]
AREA = WIDTH * LENGTH  # [m2]
VISCOSITY = 0.013  # [Pa s]


def near(value, rel=1e-12):
    """Return a relative tolerance about the value.

    Film flows of 1e-8 m3/s are smaller than pytest's absolute tolerance.
    """
    return pytest.approx(value, rel=rel, abs=0.0)


def parameters(shape, **changes):
    """Parameters with this skirt and oil."""
    given = dict(bore_radius=RADIUS, skirt_length=LENGTH, oil=Oil(viscosity=VISCOSITY)) | changes
    return Parameters(shape, **given)


def stepped(shape, film, velocity=0.0, step=1e-4, conditions=None, **changes):
    """Return the outputs of one step of a constant film, or of a list of films in turn.

    A constant full film is steady at once.
    """
    films = film if isinstance(film, list) else [film, film]
    given = conditions or {}
    return film_after(parameters(shape, **changes), films, velocity, step, **given).outputs
