"""Summary entries: one number for an output over all macro steps, updated during the run."""

from typing import Any

from ..case.tables import reduced
from ..coupling.wiring import port_of


class Reduction:
    """Summary entry "min|max|mean|last participant.variable" over all macro steps.

    Its memory does not grow with the run. The mean is over time, with the step lengths as weights.
    A compensated sum keeps the error of a single addition.

    Eq. (Z8):  mean = sum of H_k y(t_k) / sum of H_k,   H_k: length of the step that ends at t_k

    Parameters
    ----------
    name, text : str
    begin : float
        Beginning of the first step [s].

    References
    ----------
    [Neumaier1974] A. Neumaier, ZAMM 54, 39-51.
    """

    def __init__(self, name, text, begin):
        self.name = name
        self.begin = self.time = begin
        self.kind, port = reduced(text)
        self.port = port_of(port)
        self.total = 0.0
        self.lost = 0.0
        self.value: Any = None

    def add(self, time, value):
        """Add the output at the end of a step, `time` [s]."""
        length, self.time = time - self.time, time
        if self.kind == "mean":
            self._sum(length * float(value))  # Eq. (Z8)
        elif self.value is None or self.kind == "last":
            self.value = value
        elif value != value or (value < self.value if self.kind == "min" else value > self.value):
            self.value = value

    def _sum(self, value):
        total = self.total + value
        larger, smaller = sorted((self.total, value), key=abs, reverse=True)
        self.lost += (larger - total) + smaller
        self.total = total

    def result(self):
        """Return the value of the entry."""
        if self.kind == "mean":
            return (self.total + self.lost) / (self.time - self.begin)  # Eq. (Z8)
        return self.value if self.kind == "last" else float(self.value)
