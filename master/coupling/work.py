"""Work that crosses the interface, as each of its two sides computes it: what they do not agree on,
the iteration has made.
"""

import numpy as np

from ..fmi.errors import BadInput
from ..fmi.quantities import pint_unit, registry


class WorkBalance:
    """Work of the wires that name a `conjugate`, summed over the macro steps.

    Eq. (W1):  W_1 = sum_steps F_in . (q_out(t+H) - q_out(t)),   W_2 = sum_steps F_out . (q_in(t+H) - q_in(t))

    q is the wire's field, F its conjugate; side 1 computes q_out from F_in, side 2 F_out from q_in.
    Where q is a velocity, q H stands for the difference. A wire agrees to its tolerance; the
    balance says what that is worth as energy.

    Parameters
    ----------
    interface : Interface
    wires : sequence of case.Wire

    Raises
    ------
    BadInput
        If a conjugate is no output that its wire's source reads, or the product is neither work nor
        power.
    """

    def __init__(self, interface, wires):
        self.pairs, self.parts = conjugates(interface.connections, wires), interface.parts
        self.work, self.exchanged = np.zeros(2), 0.0
        self.last = 0.0, interface.read(), interface.read()

    def add(self, time, used, y):
        """Add the macro step that ends at `time` [s]: what inputs were set to and what outputs are
        there.
        """
        (before, used_before, y_before), self.last = self.last, (time, used, y)
        step = time - before
        for field, force, rate in self.pairs:
            q, f = self.parts[field], self.parts[force]
            out, into = (
                (y[q] * step, used[q] * step)
                if rate
                else (y[q] - y_before[q], used[q] - used_before[q])
            )
            share = np.array([used[f] @ out, y[f] @ into])  # Eq. (W1)
            self.work += share
            self.exchanged += float(np.abs(used[f]) @ np.abs(out))

    def summary(self):
        """Summary entries: W_1 [J], and (W_1 - W_2) / sum |F_in| . |dq_out|; none without
        conjugates.
        """
        if not self.pairs:
            return {}
        first, second = self.work.tolist()
        return {
            "interface_work_j": first,
            "interface_work_imbalance": (first - second) / (self.exchanged or 1.0),
        }


def conjugates(connections, wires):
    """(index of the field, index of its conjugate, whether their product is power) of each wire
    that names one.
    """
    faults, found = [], []
    ports = {(".".join(c.source), ".".join(c.target)): k for k, c in enumerate(connections)}
    for wire in wires:
        if wire.conjugate is None or (wire.source, wire.target) not in ports:
            continue
        k = ports[wire.source, wire.target]
        back = [
            j
            for j, c in enumerate(connections)
            if ".".join(c.source) == wire.conjugate
            and c.target[0] == connections[k].source[0]
            and c.shape == connections[k].shape
        ]
        where = f"wire {wire.source} -> {wire.target}: conjugate = {wire.conjugate!r}"
        if not back:
            faults.append(
                f"{where}: no field of this shape is wired from there to {connections[k].source[0]}"
            )
            continue
        product = registry()(pint_unit(connections[k].unit)) * registry()(
            pint_unit(connections[back[0]].unit)
        )
        if not (product.check("[energy]") or product.check("[power]")):
            faults.append(f"{where}: the product is in {product.units:~P}, neither work nor power")
        found.append((k, back[0], product.check("[power]")))
    if faults:
        raise BadInput(faults)
    return found
