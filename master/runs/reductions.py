"""Summary entries: one number of an output over all macro steps, kept as the run goes on."""

from typing import Any

from ..case.schema import reduced
from ..coupling.wiring import port_of


class Reduction:
    """One summary entry: "min|max|mean|last participant.variable" over all macro steps.

    It keeps as many numbers however long the run is. The mean is of a compensated sum, so that it
    has the error of a single addition.

    References
    ----------
    [Neumaier1974] A. Neumaier, ZAMM 54, 39-51.
    """

    def __init__(self, name, text):
        self.name = name
        self.kind, port = reduced(text)
        self.owner, self.variable = port_of(port)
        self.count = 0
        self.total = 0.0
        self.lost = 0.0
        self.value: Any = None

    def add(self, values):
        """Take the outputs (participant -> variable -> number) at the end of a step."""
        value = values[self.owner][self.variable]
        self.count += 1
        if self.kind == "mean":
            self._sum(float(value))
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
        """The entry."""
        if self.kind == "mean":
            return (self.total + self.lost) / self.count
        return self.value if self.kind == "last" else float(self.value)
