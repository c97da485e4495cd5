"""Two FMUs of one model side by side, and how far their outputs and derivatives are apart."""

from types import MappingProxyType

import numpy as np

from piston_cosim.master.participants.open import open_fmu

from .runs import reached

BY_ITSELF = ("interface_work_error", "mass_imbalance")
"""Shares that are round-off themselves: compared as they are."""


class Apart:
    """Largest value of each name, and largest difference of two sides; what was added last."""

    def __init__(self):
        self.size, self.off, self.last = {}, {}, ()

    def add(self, ours, theirs):
        self.last = ours, theirs
        for name, value in theirs.items():
            value = np.asarray(value, dtype=float)
            for table, one in ((self.size, value), (self.off, ours[name] - value)):
                table[name] = np.maximum(table.get(name, 0.0), np.abs(one).max())  # keeps a NaN

    def shares(self, of=MappingProxyType({})):
        """Return each nonzero difference as a share of the largest value of its name.

        `of` may give another name whose largest value is used.
        """
        sizes = {
            name: 1.0 if name.endswith(BY_ITSELF) else self.size[of.get(name, name)] or 1.0
            for name in self.off
        }
        return {name: off / sizes[name] for name, off in self.off.items() if not off == 0.0}


def side_by_side(paths, start, given, steps, length, redo=10, derive=0, seeds=None, products=()):
    """Step two FMUs and compare all outputs after each step.

    Parameters
    ----------
    paths : sequence of Path
        Both FMUs.
    start : dict
        Parameters.
    given, length : callable
        Inputs of a step by FMU and number, and its length [s] by number.
    steps, redo, derive : int
        Number of steps. Each `redo`-th is first taken with other inputs and another length, and
        taken back, every second time from bytes. After each `derive`-th derivatives are compared
        too, each difference as a share of the derivative.
    seeds : dict of str to float
        Inputs of the derivatives, and the size of their changes.
    products : sequence of str
        Outputs of the derivatives.

    Returns
    -------
    Apart
    """
    both = [open_fmu("one", path) for path in paths]
    names = [name for name, field in both[1].fields.items() if field.causality == "output"]
    assert set(names) <= set(both[0].fields)
    apart, rng = Apart(), np.random.default_rng(9)

    def step(one, k, longer=1.0):
        for name, value in given(one, k).items():
            one.set(name, value)
        one.step(reached(one), longer * length(k))

    for one in both:
        one.start(start | given(one, 0), 0.0, 1.0)
    for k in range(steps + 1):
        for one in both if k else ():
            if k % redo == 0:
                saved = one.save()
                data = one.serialise(saved)
                step(one, k + 3, 2.5)
                one.restore(one.deserialise(data) if k // redo % 2 == 0 else saved)
            step(one, k)
        apart.add(*({name: one.get(name) for name in names} for one in both))
        if derive and k and k % derive == 0:
            along = {
                name: size * rng.standard_normal(np.shape(both[0].get(name)))
                for name, size in seeds.items()
            }
            found = [one.derivative(along, list(products)) for one in both]
            scale = {name: np.abs(value).max() or 1.0 for name, value in found[1].items()}
            apart.add(*({f"of {n}": one[n] / scale[n] for n in products} for one in found))
    for one in both:
        one.close()
    return apart
