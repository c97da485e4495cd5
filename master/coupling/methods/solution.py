"""What every method shares: the macro step to solve, its solution, its failure, the limit on an
update.
"""

from dataclasses import dataclass

import numpy as np

from ..interface import Interface


@dataclass(frozen=True)
class MacroStep:
    """One macro step: sweeps of `interface` from `time` over `step` [s], every sweep from the
    `saved` states.
    """

    interface: Interface
    time: float
    step: float
    saved: dict

    def sweep(self, x):
        """`Interface.sweep` of this step."""
        return self.interface.sweep(x, self.time, self.step, self.saved)

    def linear_sweep(self, change):
        """`Interface.linear_sweep` at the last sweep."""
        return self.interface.linear_sweep(change)


@dataclass(frozen=True)
class Solution:
    """An accepted macro step.

    x : the wires at its end, which the next step goes by; held : what the inputs were set to where
    that is something else, in a step that was not iterated; history : `Interface.measure` of every
    iteration; jacobians : linearisations; products : directional derivatives of the whole sweep;
    probes : sweeps that took their place.
    """

    x: np.ndarray
    history: tuple
    jacobians: int = 0
    products: int = 0
    probes: int = 0
    held: np.ndarray | None = None

    @property
    def inputs(self):
        """What the inputs were set to."""
        return self.x if self.held is None else self.held

    @property
    def iterations(self):
        return len(self.history)


class NotConverged(RuntimeError):
    """The macro step did not reach its fixed point; says where the worst residual is and how the
    residual went.
    """

    def __init__(self, reason, interface, residual, values, history):
        self.iterations = len(history)
        trail = [f"{value:.2g}" for value in history]
        shown = trail if len(trail) <= 12 else [*trail[:6], "...", *trail[-5:]]
        super().__init__(
            f"{reason}; worst {interface.worst(residual, values)}; "
            f"residual/tolerance per iteration: {' '.join(shown)}"
        )


def step_length(interface, x, change):
    """Largest share <= 1 of `change` that respects every wire's `largest_decrease`.

    The smallest element m of such a wire may go down to m - s max(m, nominal/10), s =
    largest_decrease.
    """
    share = 1.0
    for connection, part in zip(interface.connections, interface.parts):
        down = change[part] < 0
        if connection.largest_decrease is None or not down.any():
            continue
        smallest = x[part].min()
        floor = smallest - connection.largest_decrease * max(smallest, connection.nominal / 10)
        share = min(share, float(np.min((x[part] - floor)[down] / -change[part][down])))
    return share
