"""Shapes of arrays in named tuples, by which `master.fmi.block` lays them out."""

from typing import Annotated

import numpy as np

Vector = Annotated[np.ndarray, "n"]
Matrix = Annotated[np.ndarray, "n, m"]
