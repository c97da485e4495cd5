"""Inputs held at their mean over a macro step give second order, whatever the participants do.

The pair is a crane, a trolley with a hanging load, and its controller: dx/dt = A x + B u,
y = C x + D u. Each side is exact for the input that it holds. The controller has direct
feedthrough (D is not 0), so that its output at the end of a step needs the input's value there.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm

import piston_cosim as pc

from .toys import Toy, variable

TROLLEY, LOAD, ROPE, GRAVITY, FRICTION = 10.0, 4.0, 2.0, 9.81, 3.0
"""[kg], [kg], [m], [m/s2], [N s/m]."""
CRANE = (  # trolley's position and velocity, load's angle and rate; force in, position out
    np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [0.0, -FRICTION / TROLLEY, LOAD * GRAVITY / TROLLEY, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [0.0, FRICTION / TROLLEY / ROPE, -(TROLLEY + LOAD) * GRAVITY / TROLLEY / ROPE, 0.0],
        ]
    ),
    np.array([0.0, 1.0 / TROLLEY, 0.0, -1.0 / TROLLEY / ROPE]),
    np.array([1.0, 0.0, 0.0, 0.0]),
    0.0,
)
CONTROLLER = (  # lead filter of 0.2 s: force = -20 N/m (position + 2 s (position - filtered)/0.2 s)
    np.array([[-1.0 / 0.2]]),
    np.array([1.0 / 0.2]),
    np.array([20.0 * 2.0 / 0.2]),
    -20.0 * (1.0 + 2.0 / 0.2),
)


class Linear(Toy):
    """dx/dt = A x + B u with u held, exactly; y = C x + D u whenever it is read."""

    path = SimpleNamespace(name="linear")

    def __init__(self, name, matrices, begin):
        fields = {"u": variable("u", "input"), "y": variable("y", "output")}
        super().__init__(name, fields, np.array(begin), {"u": np.array(0.0)})
        self.a, self.b, self.c, self.d = matrices

    def get(self, name):
        u = super().get("u")
        return u if name == "u" else self.c @ self.state + self.d * u

    def _advance(self, step):
        size = len(self.state)
        whole = np.zeros((size + 1, size + 1))
        whole[:size, :size], whole[:size, size] = step * self.a, step * self.b
        self.state = expm(whole)[:size] @ np.append(self.state, self.values["u"])


def position(tmp_path, step, **coupling):
    """Trolley's position [m] at 1 s, the load let go at 0.1 rad."""
    run = pc.couple(
        {
            "crane": lambda: Linear("crane", CRANE, [0.5, 0.0, 0.1, 0.0]),
            "controller": lambda: Linear("controller", CONTROLLER, [0.5]),
        },
        ["crane.y -> controller.u", "controller.y -> crane.u"],
        stop="1 s",
        step=f"{step} s",
        **coupling,
    )
    return float(run.run(tmp_path / "r.h5").series("crane.y")[0][-1])


def exact():
    """Return y of the monolithic system dx/dt = (A + B D2 C) x + B C2 z, dz/dt = A2 z + B2 C x."""
    (a, b, c, _), (a2, b2, c2, d2) = CRANE, CONTROLLER
    whole = np.block([[a + d2 * np.outer(b, c), np.outer(b, c2)], [np.outer(b2, c), a2]])
    return float((expm(whole) @ np.array([0.5, 0.0, 0.1, 0.0, 0.5]))[0])


@pytest.mark.parametrize("method", ["newton", "iqn_ils"])
def test_the_mean_of_both_ends_is_of_second_order(tmp_path, method):
    reference = exact()
    observed = {}
    for inputs in ("held", "mean"):
        coarse, fine = (
            abs(
                position(
                    tmp_path, step, method=method, inputs=inputs, advanced={"differences": True}
                )
                - reference
            )
            for step in (0.02, 0.01)
        )
        observed[inputs] = np.log2(coarse / fine)
    # the next term of the error is 0.01 s times the fastest rate, some 10/s
    assert observed["mean"] == pytest.approx(2.0, abs=0.1)
    assert observed["held"] == pytest.approx(1.0, abs=0.2)
