"""The block's FMU: a table of variables and a step."""

from typing import Any

import numpy as np

from ...master.fmi.errors import BadInput
from ...master.fmi.slave import FieldSlave
from ...master.fmi.variables import Variable
from ..dynamics.monoblock import (
    RIGID_MOTIONS,
    BlockParameters,
    BlockState,
    Cylinder,
    CylinderMotion,
    MountedMonoblock,
)
from ..dynamics.parameters import parameters_from
from ..reduction.reduced_body import ReducedMonoblock, load
from . import variables as table
from .variables import AXES, BlockScalars, ports


class Monoblock(FieldSlave):
    """Flexible block of several cylinders on its mounts."""

    name = "fmu_monoblock"
    description = "Flexible block of several cylinders on its mounts, reduced from finite elements"
    state_type = BlockState

    @property
    def derivative_inputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the forces of all cylinders."""
        return ports(self.options["cylinders"], Cylinder)

    @property
    def derivative_outputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the motion of the block at all cylinders."""
        return ports(self.options["cylinders"], CylinderMotion)

    @staticmethod
    def variables(options: dict[str, Any]) -> list[Variable]:
        """Return the variables for the options of build.json."""
        around, axial = options["grid"]
        return table.variables(options["cylinders"], options["mounts"], (around, axial))

    def start(self, values: dict[str, Any]) -> tuple[BlockState, dict[str, Any]]:
        """Load the reduced block; at rest."""
        body = load(ReducedMonoblock, self.resources / self.options["file"])
        mounts = range(1, self.options["mounts"] + 1)
        springs = [[values[f"mount_{k}_stiffness_{axis}"] for axis in AXES] for k in mounts]
        p = parameters_from(BlockParameters, values)
        self.model = MountedMonoblock(body, np.array(springs), p)
        if self.model.loose():
            raise BadInput(
                "mount_1_stiffness_x, ..: expected mounts that hold all six directions or "
                "none, got others"
            )
        cylinders = self._cylinders(values)
        state = self.model.start(cylinders)
        return state, self._shown(state, state, 0.0) | _six(
            ("shaking_force", "shaking_moment"), self.model.total(cylinders)
        )

    def advance(
        self, state: BlockState, values: dict[str, Any], time: float, step: float
    ) -> tuple[BlockState, dict[str, Any]]:
        """Take a step; returns (state, outputs)."""
        end = self.model.advance(state, self._cylinders(values), step)
        return end, self._shown(state, end, step)

    def directional_derivative(self, seeds: dict[str, Any]) -> dict[str, Any]:
        """Return the product of the step map's derivative with the seed fields."""
        assert self.state is not None  # a derivative is asked of a step
        return _outputs_of(self.model.change(self.state, self._cylinders(seeds)))

    def _cylinders(self, values: dict[str, Any]) -> list[Cylinder]:
        """Return the forces of each cylinder."""
        names = Cylinder._fields
        each = range(1, self.options["cylinders"] + 1)
        return [Cylinder(*(values[f"cylinder_{k}.{name}"] for name in names)) for k in each]

    def _shown(self, before: BlockState, now: BlockState, step: float) -> dict[str, Any]:
        """Return the outputs at the end of a step."""
        model = self.model
        motions = model.at_cylinders(now.position, now.velocity, now.acceleration)
        kinetic, elastic = model.energies(now)
        on_mounts = model.mounts @ now.position + model.mount_damping @ now.velocity
        rate = now.velocity
        scalars = BlockScalars(
            kinetic_energy=kinetic,
            elastic_energy=elastic,
            mount_power=float(rate @ model.mount_damping @ rate),
            modal_power=float(rate @ (model.modal_damping * rate)),
            largest_bore_deflection=max(np.abs(one.bore_deflection).max() for one in motions),
            power_error=model.energy_error(before, now) / step if step > 0.0 else 0.0,
        )
        return {
            **_outputs_of(motions),
            **_six(("displacement", "rotation"), now.position),
            **_six(("velocity", "rotation_velocity"), now.velocity),
            **_six(("shaking_force", "shaking_moment"), now.force),
            **_six(("mount_force", "mount_moment"), on_mounts),
            **scalars._asdict(),
        }


def _outputs_of(motions: list[CylinderMotion]) -> dict[str, Any]:
    """Return the motion of the block at the cylinders, by variable."""
    return {
        f"cylinder_{k}.{name}": value
        for k, one in enumerate(motions, 1)
        for name, value in one._asdict().items()
    }


def _six(names: tuple[str, str], values: np.ndarray) -> dict[str, float]:
    """Return the rigid part of a vector, by variable."""
    parts = zip(names, values[:RIGID_MOTIONS].reshape(2, 3))
    return {f"{name}_{axis}": one for name, three in parts for axis, one in zip(AXES, three)}
