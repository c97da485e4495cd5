"""An isolated participant with clones: the columns of its derivative are difference probes that the
clones take at the same time.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..fmi.errors import Discard, ParticipantFault
from .derivatives import DIFFERENCE, Fields, scales
from .isolated import IsolatedParticipant


class ClonedParticipant:
    """An isolated participant whose derivative is taken by differences, one probe for each element
    of its inputs, as many at a time as there are clones.

    Eq. (P9):  J e_j = (y(x + d_j e_j) - y(x)) / d_j,   d_j = DIFFERENCE scale_j,
               scale: nominal, else max|x|, else 1

    Every probe begins with the serialised state that the last step began with, so that the bits do
    not depend on how many clones there are, or on which of them takes a probe. The columns are
    taken with the first product that is asked for after a step, and serve all others.

    Parameters
    ----------
    participant : IsolatedParticipant
    clones : sequence of IsolatedParticipant
        Of the same FMU, at least one; not started.
    """

    has_derivatives = False

    def __init__(self, participant: Any, clones: Sequence[IsolatedParticipant]):
        self.participant, self.clones = participant, clones
        self._begin: Any = None
        self._last_step = (0.0, 0.0)
        self._columns: list[Fields] = []

    def __getattr__(self, name):
        return getattr(self.participant, name)

    def launch(self):
        """Start all processes, which takes their time at once."""
        for one in (self.participant, *self.clones):
            one.launch()

    def start(self, parameters, start_time, stop_time):
        """See `FmuParticipant.start`."""
        self.enter(parameters, start_time, stop_time)
        self.leave()

    def enter(self, parameters, start_time, stop_time):
        """First half of `start`, of all."""
        for one in (self.participant, *self.clones):
            one.enter(parameters, start_time, stop_time)

    def leave(self):
        """Second half of `start`, of all."""
        for one in (self.participant, *self.clones):
            one.leave()

    def restore(self, saved):
        """Go back to a saved state; the next step counts from it."""
        self._begin = saved
        self.participant.restore(saved)

    def step(self, time, step):
        """One step [s]."""
        self.begin_step(time, step)
        self.end_step()

    def begin_step(self, time, step):
        """See `IsolatedParticipant.begin_step`."""
        self._last_step, self._columns = (time, step), []
        self.participant.begin_step(time, step)

    def derivative(self, seeds: Mapping[str, np.ndarray], products: Iterable[str]) -> Fields:
        """Directional derivative of the last step, from its columns."""
        products = list(products)
        if not self._columns:
            self._columns = self._probed(seeds, products)
        whole = np.concatenate([np.ravel(seed) for seed in seeds.values()])
        changes = {name: np.zeros(self.fields[name].shape) for name in products}
        for share, column in zip(whole, self._columns):
            for name in products:
                changes[name] = changes[name] + share * column[name]
        return changes

    def _probed(self, inputs: Iterable[str], products: Sequence[str]) -> list[Fields]:
        """All columns, by the elements of the inputs."""
        before = {name: self.participant.get(name) for name in (*inputs, *products)}
        scale = scales(self.participant, before, inputs)
        begin = self.participant.serialise(self._begin)
        places = [(name, k) for name in inputs for k in range(np.size(before[name]))]
        states = [clone.deserialise(begin) for clone in self.clones]
        columns: list[Fields] = []
        for first in range(0, len(places), len(self.clones)):
            pack = list(zip(self.clones, states, places[first:]))
            for clone, state, (name, k) in pack:
                clone.restore(state)
                for other in inputs:
                    changed = np.array(before[other], dtype=float)
                    if other == name:
                        changed.flat[k] += DIFFERENCE * scale[name]
                    clone.set(other, changed)
                clone.begin_step(*self._last_step)
            failures = [_waited_for(clone) for clone, _, _ in pack]
            for failure in filter(None, failures):
                raise failure
            columns += [
                {
                    product: (clone.get(product) - before[product]) / (DIFFERENCE * scale[name])
                    for product in products
                }  # Eq. (P9)
                for clone, _, (name, _) in pack
            ]
        for clone, state in zip(self.clones, states):
            clone.free(state)
        return columns

    def close(self):
        """Close all; the first fault is raised once they are."""
        faults = []
        for one in (self.participant, *self.clones):
            try:
                one.close()
            except ParticipantFault as fault:
                faults.append(fault)
        if faults:
            raise faults[0]


def _waited_for(clone: IsolatedParticipant) -> Discard | ParticipantFault | None:
    """What the step that a clone has begun raises; all are waited for before anything is raised."""
    try:
        clone.end_step()
    except (Discard, ParticipantFault) as failure:
        return failure
    return None
