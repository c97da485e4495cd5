"""What one step of every participant says of an iterate, in Python and in machine code."""

from typing import NamedTuple

import numpy as np


class Evaluation(NamedTuple):
    """What one step of every participant says of an iterate.

    used, outputs, residual : ndarray, shape (size,)
        What the inputs were set to, what the outputs are at the end of the step, and how far the
        iterate is off: outputs - used on the feedback wires; used - iterate on the others, which
        agree by the order of stepping but may have moved since.
    """

    used: np.ndarray
    outputs: np.ndarray
    residual: np.ndarray
