"""The coupled wires as one vector, one sweep over the participants, and the linearised sweep."""

import numpy as np

from .wiring import is_unknown, rms


class Interface:
    """Vector layout of all connections.

    The vector x holds, wire after wire, what the target reads. `feedback` marks the elements of
    wires that run against the stepping order: the unknowns of a sequential (Gauss-Seidel) sweep
    (`feedback_wires`: the slice of each among them). Norms are scaled: element / nominal of its
    wire.

    Parameters
    ----------
    participants : dict of str to Participant
        In stepping order.
    connections : sequence of Connection

    parallel : bool
        Jacobi's order: every participant reads the iterate alone, all wires are unknowns.

    `trail` holds the measures of every wire since `begin`, a list for each sweep that was measured;
    `first` the root mean square of every wire's residual in the first of them.
    """

    def __init__(self, participants, connections, parallel=False):
        self.participants, self.connections = participants, connections
        self.begin()
        sizes = [int(np.prod(c.shape)) for c in connections]
        ends = np.cumsum(sizes, dtype=int)
        self.parts = [slice(end - size, end) for end, size in zip(ends, sizes)]
        self.size = int(ends[-1]) if sizes else 0
        self.nominal = np.repeat([c.nominal for c in connections], sizes)
        against = [is_unknown(c, list(participants), parallel) for c in connections]
        self.feedback = np.repeat(against, sizes)
        lengths = [size for size, back in zip(sizes, against) if back]
        self.feedback_wires = [
            slice(end - size, end) for end, size in zip(np.cumsum(lengths, dtype=int), lengths)
        ]
        self.inputs = {name: self._wires(name, "target") for name in participants}
        self.outputs = {name: self._wires(name, "source") for name in participants}

    def _wires(self, name, end):
        return [
            (getattr(c, end)[1], part, c.shape)
            for c, part in zip(self.connections, self.parts)
            if getattr(c, end)[0] == name
        ]

    def begin(self):
        """A macro step is tried."""
        self.trail, self.first = [], [0.0] * len(self.connections)

    def read(self):
        """Vector of what the sources say now."""
        y = np.empty(self.size)
        for name, participant in self.participants.items():
            for field, part, _ in self.outputs[name]:
                y[part] = np.ravel(participant.get(field))
        return y

    def sweep(self, x, time, step, saved):
        """Step every participant once from its saved state, later ones reading what earlier ones
        have just computed.

        Parameters
        ----------
        x : ndarray, shape (size,)
            Iterate; the inputs are set to its feedback elements.
        time, step : float
            Start and length of the macro step [s].
        saved : dict of str to saved state

        Returns
        -------
        used, y, residual : ndarray, shape (size,)
            What the inputs were set to, what the outputs are at time + step, and how far the
            iterate is off: y - used on the feedback wires; used - x on the others, which agree by
            the order of stepping but may have moved since.
        """
        used, y = x.copy(), np.empty(self.size)
        for name, participant in self.participants.items():
            participant.restore(saved[name])
            for field, part, shape in self.inputs[name]:
                participant.set(field, used[part].reshape(shape))
            participant.step(time, step)
            for field, part, _ in self.outputs[name]:
                y[part] = np.ravel(participant.get(field))
                if not self.feedback[part.start]:
                    used[part] = y[part]
        return used, y, np.where(self.feedback, y - used, used - x)

    def linear_sweep(self, change):
        """The sweep linearised at the last step of every participant.

        Parameters
        ----------
        change : ndarray, shape (size,)
            Change of the iterate; only its feedback elements are read.

        Returns
        -------
        ndarray, shape (size,)
            Change of all outputs.
        """
        seen, result = np.where(self.feedback, change, 0.0), np.zeros(self.size)
        for name, participant in self.participants.items():
            if not self.outputs[name]:
                continue
            seeds = {field: seen[part].reshape(shape) for field, part, shape in self.inputs[name]}
            products = participant.derivative(seeds, [field for field, _, _ in self.outputs[name]])
            for field, part, _ in self.outputs[name]:
                result[part] = np.ravel(products[field])
                if not self.feedback[part.start]:
                    seen[part] = result[part]
        return result

    def allowed(self, values):
        """Residual that counts as converged, per element, for given values; shape (size,)."""
        return np.concatenate(
            [
                np.full(part.stop - part.start, c.allowed(values[part], first))
                for c, part, first in zip(self.connections, self.parts, self.first)
            ]
        )

    def measure(self, residual, values):
        """Largest measure of a wire, Eq. (C0): converged at 1 and below, NaN if any element is not
        finite.
        """
        if not self.trail:
            self.first = [rms(residual[part]) for part in self.parts]
        self.trail.append(self._measures(residual, values))
        return float(np.max(self.trail[-1]))

    def _measures(self, residual, values):
        return [
            c.measure(residual[part], values[part], first)
            for c, part, first in zip(self.connections, self.parts, self.first)
        ]

    def worst(self, residual, values):
        """Sentence naming the worst wire and its largest residual."""
        measures = self._measures(residual, values)
        k = int(np.argmax(np.where(np.isnan(measures), np.inf, measures)))
        c, r = self.connections[k], residual[self.parts[k]]
        element = int(np.argmax(np.where(np.isnan(r), np.inf, np.abs(r))))
        index = ",".join(str(i + 1) for i in np.unravel_index(element, c.shape)) if c.shape else ""
        return (
            f"{c.target[0]}.{c.target[1]}[{index}]: {r[element]:.3g} {c.unit} "
            f"(allowed {c.allowed(values[self.parts[k]], self.first[k]):.3g})"
        )
