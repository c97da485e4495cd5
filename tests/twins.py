"""Comparison of a step of a native FMU with that of its Python class, in one process.

Both get the same values, and their values after the step are compared.
"""

import numpy as np


class Twins:
    """Two instances of a class, of which the one in `machine` runs the kernels of `native`.

    off, largest : largest difference and value of each output, and of each derivative under "of".
    """

    def __init__(self, kind, native, folder):
        self.native = native
        self.python, self.machine = (kind(instance_name="twin", resources=folder) for _ in "ab")
        self.off, self.largest = {}, {}

    def give(self, values):
        for name, value in values.items():
            for one in (self.python, self.machine):
                one.views[name][...] = value

    def start(self):
        self.python.exit_initialization_mode()
        self.numbers = np.zeros(4)
        begin = self.native.setup_row(self.machine)
        size, self.first, self.length, self.faults = map(int, begin[:4])
        self.memory = np.zeros(size)
        self.memory[: begin.size] = begin
        self.call = self.machine.real, self.machine.integer, self.memory, self.numbers
        self.native.start(*self.call)

    def advance(self, step):
        assert self.python.do_step(0.0, step)
        self.numbers[0] = step
        self.native.advance(*self.call)

    def compare(self):
        assert self.memory[self.faults] == 0.0
        for v in self.python.table:
            if v.causality == "output":
                a, b = (one.views[v.name] for one in (self.python, self.machine))
                self._note(v.name, a - b, a)

    def compare_derivatives(self, seeds):
        for name, seed in seeds.items():
            self.machine.views["seed:" + name][...] = seed
        self.native.tangent(*self.call)
        for name, a in self.python.directional_derivative(seeds).items():
            self._note("of " + name, (a - self.machine.views["product:" + name]) / abs(a).max(), 1)

    def _note(self, name, difference, value):
        for table, one in ((self.off, difference), (self.largest, value)):
            table[name] = max(table.get(name, 0.0), float(np.abs(one).max()))

    def shares(self):
        """Return the differences that are not zero, by the largest value of each name."""
        return {name: off / self.largest[name] for name, off in self.off.items() if off}
