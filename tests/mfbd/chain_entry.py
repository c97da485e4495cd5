"""An entry of machine code that solves the equations of motion of a chain in its memory.

As a program it compiles the entry for three platforms by the compiler of native FMUs, which raises
an error if the code needs a symbol from outside, and prints the sizes.
"""

from typing import NamedTuple

import numpy as np

from piston_cosim.fmu_mfbd.mechanism.carrier import BlockMotion
from piston_cosim.fmu_mfbd.mechanism.chain import Chain, Loads
from piston_cosim.fmu_mfbd.mechanism.derivative import chain_derivative
from piston_cosim.fmu_mfbd.mechanism.equations import chain_forces
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.laws import add_laws
from piston_cosim.fmu_mfbd.mechanism.motion import Increments, chain_motion
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion
from piston_cosim.fmu_mfbd.mechanism.solution import factorise_chain, substitute_chain
from piston_cosim.master.fmi.block import flatten
from piston_cosim.master.fmi.compiled import compiled
from piston_cosim.master.fmi.native_parts import NativePart


class ChainProblem(NamedTuple):
    """A chain, its loads and its motion."""

    chain: Chain
    loads: Loads
    now: Motion
    by: Increments
    drive: CrankMotion
    given: BlockMotion


_, problem_from = flatten(ChainProblem)


@compiled
def advance(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write the accelerations after one iteration of Newton's method into `real`."""
    problem = problem_from(memory)
    chain, loads, now = problem.chain, problem.loads, problem.now
    add_laws(chain, chain_motion(chain.joints, now, problem.drive), problem.drive.angle, loads)
    forces = chain_forces(chain, loads, now, problem.drive, problem.given)
    arrow = chain_derivative(chain, loads, now, forces, problem.by).arrow
    change = substitute_chain(factorise_chain(arrow), forces.residual)
    for k in range(len(change)):
        real[k] = now.acceleration[k] - change[k]


PART = NativePart(
    entries=(advance,),
    setup=lambda slave: None,
    uncovered=lambda options: (),
    faults=(),
    refusal="",
)

if __name__ == "__main__":
    from piston_cosim.master.fmi import native_code

    module = native_code.module_text("chain", PART)
    for platform in ("linux64", "aarch64-linux", "win64"):
        code = native_code.translated(module, native_code.TARGETS[platform])
        print(platform, len(code))
