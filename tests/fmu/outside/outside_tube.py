"""An example package with its own participant, method, step control and observer.

The participant is the wall of the elastic tube without FMI, as a coupling adapter of another
program would provide it. The method is plain relaxation with a memory. The step control takes
steps of half the requested length. The observer lists the ends of windows.
"""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from piston_cosim.master.coupling.methods import NotConverged, Solution

NODES = 101
WAVE = 1e4 * np.sqrt(np.pi) / 2  # c2 of the tube law [m2/s2]


def _variable(name, unit, causality):
    return SimpleNamespace(
        name=name,
        shape=(NODES,),
        type="Real",
        causality=causality,
        unit=unit,
        nominal=1.0,
        minimum=None,
        maximum=None,
        description="",
    )


class Wall:
    """The elastic wall: cross-section = (2 c2 / (2 c2 - pressure))^2, without a memory."""

    can_redo = can_serialise = declares_units = True
    can_interpolate = has_derivatives = False

    def __init__(self, name, options, folder):
        self.name = name
        self.stiffness = options.pop("stiffness", 1.0)
        if options:
            raise ValueError(f"unknown options {', '.join(options)}")
        variables = _variable("pressure", "Pa", "input"), _variable("area", "m2", "output")
        self.fields = {variable.name: variable for variable in variables}
        self.pressure = np.zeros(NODES)

    def start(self, parameters, start_time, stop_time):
        self.enter(parameters, start_time, stop_time)
        self.leave()

    def enter(self, parameters, start_time, stop_time):
        for name, value in parameters.items():
            self.set(name, value)
        self.step(start_time, 0.0)

    def leave(self):
        pass

    def set(self, name, value):
        self.pressure = np.array(value, dtype=float)

    def get(self, name):
        return self.pressure if name == "pressure" else self.area

    def get_many(self, names):
        return {}

    def step(self, time, step):
        stiff = self.stiffness * WAVE
        self.area = (2 * stiff / (2 * stiff - self.pressure)) ** 2

    def save(self):
        return self.pressure, self.area

    def restore(self, saved):
        self.pressure, self.area = saved

    def free(self, saved):
        pass

    def serialise(self, saved):
        return np.stack(saved).tobytes()

    def deserialise(self, data):
        return tuple(np.frombuffer(data).reshape(2, NODES).copy())

    def derivative(self, seeds, products):
        raise NotImplementedError

    def close(self):
        pass


@dataclass
class Last:
    """What the method carries over: the last change and residual of the step before."""

    windows: int = 0


@dataclass(frozen=True)
class AndersonOne:
    """Fixed-point iteration that goes by the last secant, Anderson's mixing of depth one."""

    relaxation: float
    max_iterations: int
    remembered = (Last,)

    def memory(self):
        return Last()

    def solve(self, macro_step, guess, memory):
        interface = macro_step.interface
        feedback = interface.feedback
        x, before, history = guess, None, []
        while True:
            at = macro_step.evaluate(x)
            history.append(interface.measure(at.residual, at.outputs))
            if history[-1] <= 1.0:
                memory.windows += 1
                return Solution(at.used, tuple(history))
            if len(history) == self.max_iterations:
                raise NotConverged("the last secant leads nowhere", interface, at, history)
            y, r = at.outputs[feedback], (at.outputs - at.used)[feedback]
            step = self.relaxation * r
            if before is not None:
                dr = r - before[1]
                c = -(dr @ r) / (dr @ dr)
                step = r + c * (y - before[0])
            before = y, r
            x = at.used.copy()
            x[feedback] += step


def anderson_one(coupling):
    return AndersonOne(coupling.options.get("first", 0.5), coupling.max_iterations)


@dataclass
class EveryHalf:
    """Macro steps of half the length that the case asks for."""

    wires: tuple
    smallest: float
    options: dict
    error: float = 0.0
    at_smallest: int = 0
    asked: float = field(default=0.0)

    def length(self, remaining):
        self.asked = max(self.asked, remaining)
        half = self.asked / 2
        return (half, False) if remaining > 1.5 * half else (remaining, True)

    def accepts(self, last, time, step, solution):
        return True

    def halve(self, step):
        return False


class WindowTimes:
    """Writes the end of every window beside the results."""

    def __init__(self, options, system, output):
        self.file = open(output.with_suffix(".times"), "w")

    def attempted(self, time, step, trail, failure):
        pass

    def accepted(self, time, solution):
        print(time, solution.iterations, file=self.file)

    def close(self):
        self.file.close()
