"""The coupled wires as one vector, one sweep over the participants, and the linearised sweep."""

import numpy as np


class Interface:
    """Vector layout of all connections.

    The vector x holds, wire after wire, what the target reads. `feedback` marks the elements of wires that run against
    the stepping order: the unknowns of a sequential sweep. Norms are scaled: element / nominal of its wire.

    Parameters
    ----------
    participants : dict of str to Participant
        In stepping order.
    connections : sequence of Connection
    """

    def __init__(self, participants, connections):
        self.participants, self.connections = participants, connections
        sizes = [int(np.prod(c.shape)) for c in connections]
        ends = np.cumsum(sizes, dtype=int)
        self.parts = [slice(end - size, end) for end, size in zip(ends, sizes)]
        self.size = int(ends[-1]) if sizes else 0
        self.nominal = np.repeat([c.nominal for c in connections], sizes)
        self.tolerance = np.repeat([c.tolerance for c in connections], sizes)
        position = {name: k for k, name in enumerate(participants)}
        against = [position[c.target[0]] <= position[c.source[0]] for c in connections]
        self.feedback = np.repeat(against, sizes)
        self.inputs = {name: self._wires(name, "target") for name in participants}
        self.outputs = {name: self._wires(name, "source") for name in participants}

    def _wires(self, name, end):
        return [(getattr(c, end)[1], part, c.shape) for c, part in zip(self.connections, self.parts)
                if getattr(c, end)[0] == name]

    def read(self):
        """Vector of what the sources say now."""
        y = np.empty(self.size)
        for name, participant in self.participants.items():
            for field, part, _ in self.outputs[name]:
                y[part] = np.ravel(participant.get(field))
        return y

    def sweep(self, x, time, step, saved, sequential):
        """Step every participant once from its saved state.

        Parameters
        ----------
        x : ndarray, shape (size,)
            What the inputs are set to.
        time, step : float
            Start and length of the macro step [s].
        saved : dict of str to saved state
        sequential : bool
            True: participants that come later read what earlier ones have just computed; False: all read x.

        Returns
        -------
        used, y : ndarray, shape (size,)
            What the inputs were set to, and what the outputs are at time + step.
        """
        used, y = x.copy(), np.empty(self.size)
        for name, participant in self.participants.items():
            participant.restore(saved[name])
            for field, part, shape in self.inputs[name]:
                participant.set(field, used[part].reshape(shape))
            participant.step(time, step)
            for field, part, _ in self.outputs[name]:
                y[part] = np.ravel(participant.get(field))
                if sequential and not self.feedback[part.start]:
                    used[part] = y[part]
        return used, y

    def linear_sweep(self, change, source):
        """Linearised sequential sweep at the last step of every participant.

        Parameters
        ----------
        change : ndarray, shape (size,)
            Change of the inputs; only its feedback elements are read.
        source : ndarray, shape (size,)
            Added to every output on its way (a residual, or zero).

        Returns
        -------
        ndarray, shape (size,)
            Change of all outputs, source included.
        """
        seen = np.where(self.feedback, change, 0.0)
        result = source.copy()
        for name, participant in self.participants.items():
            if not self.outputs[name]:
                continue
            seeds = {field: seen[part].reshape(shape) for field, part, shape in self.inputs[name]}
            products = participant.derivative(seeds)
            for field, part, _ in self.outputs[name]:
                result[part] += np.ravel(products[field])
                if not self.feedback[part.start]:
                    seen[part] = result[part]
        return result

    def worst(self, residual):
        """Sentence naming the element with the largest residual relative to its tolerance."""
        k = int(np.nanargmax(np.abs(residual) / self.tolerance)) if np.isfinite(residual).any() else 0
        c, part = next((c, p) for c, p in zip(self.connections, self.parts) if p.start <= k < p.stop)
        index = ",".join(str(i + 1) for i in np.unravel_index(k - part.start, c.shape)) if c.shape else ""
        return f"{c.target[0]}.{c.target[1]}[{index}]: {residual[k]:.3g} {c.unit} (tolerance {c.tolerance:.3g})"
