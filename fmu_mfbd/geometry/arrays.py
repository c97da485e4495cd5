"""Types of arrays in named tuples, from which `master.fmi.block` generates the layout."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

Vector = Annotated[np.ndarray, "n"]
Matrix = Annotated[np.ndarray, "n, m"]
Numbers = Annotated[NDArray[np.int64], "n"]
