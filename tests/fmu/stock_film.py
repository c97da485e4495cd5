"""A lubrication FMU as pythonfmu's own manual makes one.

It has no units, nominals or derivatives, and its variables hold the state.

A local film law (squeeze alone): p = -12 mu hdot w^2 / h^3 / 10, cut off at 0; w: half the skirt's
length.
"""

import math

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real

CELLS = (12, 10)
NAMES = [f"[{i + 1},{j + 1}]" for i in range(CELLS[0]) for j in range(CELLS[1])]
AREA = 27e-3 / CELLS[1] * 2 * math.pi * 28.25e-3 / CELLS[0]


class StockFilm(Fmi2Slave):
    """Every element a registered variable; `before` holds the film at the end of the last step."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        constants = {"n_circumferential": CELLS[0], "n_axial": CELLS[1], "contract_version": 2}
        self.values = constants | {"viscosity": 0.012}
        self._register(Real, "viscosity", Fmi2Causality.parameter, Fmi2Variability.fixed)
        for name in constants:
            self._register(Integer, name, Fmi2Causality.parameter, Fmi2Variability.fixed)
        for name, causality, start in (
            ("film_thickness", "input", 3e-5),
            ("sliding_velocity", "input", 0.0),
            ("before", "local", 3e-5),
            ("nodal_pressure_force", "output", 0.0),
            ("nodal_friction_force", "output", 0.0),
        ):
            for cell in NAMES:
                self.values[name + cell] = start
                continuous = Fmi2Variability.continuous
                self._register(Real, name + cell, Fmi2Causality[causality], continuous)

    def _register(self, kind, name, causality, variability):
        self.register_variable(
            kind(
                name,
                causality=causality,
                variability=variability,
                getter=lambda: self.values[name],
                setter=lambda value: self.values.__setitem__(name, value),
            ),
            nested=False,
        )

    def exit_initialization_mode(self):
        self._compute(1.0)

    def do_step(self, current_time, step_size):
        self._compute(step_size)
        return True

    def _compute(self, step):
        v = self.values
        for cell in NAMES:
            film = max(v["film_thickness" + cell], 1e-6)
            squeeze = (v["film_thickness" + cell] - v["before" + cell]) / step
            pressure = max(-1.2 * v["viscosity"] * squeeze * 13.5e-3**2 / film**3, 0.0)
            v["nodal_pressure_force" + cell] = pressure * AREA
            v["nodal_friction_force" + cell] = (
                -v["viscosity"] * v["sliding_velocity" + cell] / film * AREA
            )
            v["before" + cell] = v["film_thickness" + cell]
