"""The run in time: predict, converge, accept or halve; every macro step accounted for."""

from dataclasses import dataclass, field

import numpy as np

from .fmi.errors import Discard
from .interface import Interface
from .methods import MacroStep, NotConverged, step_length


class StepFailed(RuntimeError):
    """A macro step that no halving could bring to convergence: the run stops, what was accepted stays."""


@dataclass
class Counters:
    """What the run has cost. NRES and NJAC count sweeps (probes for differences too) and linearisations, as an implicit
    integrator counts them."""

    steps: int = 0
    halved_steps: int = 0
    iterations: list = field(default_factory=list)
    residual_evaluations: int = 0
    jacobian_evaluations: int = 0
    derivative_products: int = 0

    def accept(self, solution):
        self.steps += 1
        self.iterations.append(solution.iterations)
        self.residual_evaluations += solution.iterations + solution.probes
        self.jacobian_evaluations += solution.jacobians
        self.derivative_products += solution.products


class Predictor:
    """Extrapolates the interface vector through the last accepted ones (Lagrange; order 0 repeats the last)."""

    def __init__(self, order):
        self.order, self.past = order, []

    def keep(self, time, x):
        self.past = [*self.past, (time, x)][-self.order - 1:]

    def clear(self):
        self.past = self.past[-1:]

    def __call__(self, time):
        """Guess at `time` [s]; the last vector if there is no more to go by."""
        guess = np.zeros_like(self.past[-1][1])
        for time_a, x in self.past:
            others = [time_b for time_b, _ in self.past if time_b != time_a]
            guess += x * np.prod([(time - b) / (time_a - b) for b in others])
        return guess


class Stepper:
    """Takes macro steps of a started system.

    Parameters
    ----------
    system : System
        Its participants must have been started.
    method : Newton or Relaxation
        Any value with their `solve`.
    halvings : int
        How often in a row a macro step may be halved.
    accepted : callable(time, solution)
        Told of every accepted step, halves included, while the participants stand at its end.
    order : int
        Of the predictor.
    attempted : callable(time, step, trail, failure)
        Told of every attempt before it is accepted or halved: the wires' measures by sweep, and why it failed or None.
    """

    def __init__(self, system, method, halvings, accepted=lambda time, solution: None, order=2,
                 attempted=lambda time, step, trail, failure: None):
        self.interface = Interface({name: system.participants[name] for name in system.order}, system.connections)
        self.method, self.halvings, self.accepted, self.attempted = method, halvings, accepted, attempted
        self.counters, self.failures, self.memory = Counters(), [], method.memory()
        self.predictor = Predictor(order)
        self.predictor.keep(0.0, self.interface.read())

    def advance(self, time, step, halvings=None):
        """Bring all participants from time to time + step [s].

        A step that does not converge, or that a participant discards, is rolled back and taken as two halves with
        cleared history. Raises StepFailed when no halving is left.
        """
        halvings = self.halvings if halvings is None else halvings
        participants = self.interface.participants
        saved = {name: p.save() for name, p in participants.items()}
        self.interface.trail.clear()
        try:
            solution = self._converge(time, step, saved)
        except (NotConverged, Discard) as failure:
            self.attempted(time, step, self.interface.trail, failure)
            self.failures.append(f"t = {time:.6g} s, step {step:.3g} s: {failure}")
            self.counters.residual_evaluations += len(self.interface.trail)
            for name, p in participants.items():
                p.restore(saved[name])
            self.predictor.clear()
            self.memory = self.method.memory()
            if halvings == 0:
                raise StepFailed(self.failures[-1]) from failure
            self.counters.halved_steps += 1
            self.advance(time, step / 2, halvings - 1)
            self.advance(time + step / 2, step / 2, halvings - 1)
        else:
            self.attempted(time, step, self.interface.trail, None)
            self.counters.accept(solution)
            self.predictor.keep(time + step, solution.x)
            self.accepted(time + step, solution)
        finally:
            for name, p in participants.items():
                p.free(saved[name])

    def _converge(self, time, step, saved):
        start = self.predictor.past[-1][1]
        change = self.predictor(time + step) - start
        guess = start + step_length(self.interface, start, change) * change
        return self.method.solve(MacroStep(self.interface, time, step, saved), guess, self.memory)
