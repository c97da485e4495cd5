"""Model of a rigid piston that moves in space, based on `model.PistonInBore`.

It shifts along the pin, rolls and yaws in addition to the motion in the plane of the crank. The
five equations are in plain numpy.
"""

from collections.abc import Iterable
from typing import Annotated, Any, NamedTuple, cast

import numpy as np

from ..geometry.film import NodalForces
from ..geometry.space import Levers, levers, slope_around
from ..mechanism.cylinder import BODY
from ..mechanism.floating_frame import TURN, ArrowMatrix, Y
from ..mechanism.generalised_alpha import Coefficients, Motion, predict
from ..mechanism.impact import UNLIMITED, Inertia, limit_memory, longest_step
from ..mechanism.piston_motion import LATERAL, RIGID, ROCKING
from ..mechanism.slider_crank import CrankMotion, height
from .block_force import NO_FORCE
from .energy import energy_ledger, other_forces
from .instant import Instant, load_of
from .model import Inputs, PistonInBore
from .motion_in_space import (
    COORDINATES,
    IN_SPACE,
    ROLL,
    SHIFT,
    YAW,
    SpaceBodies,
    SpaceImbalance,
    SpaceLoad,
    forces_on_block,
    imbalance,
    inertia,
    pushed,
    tangent,
    with_pin,
)
from .response import Response, StepInputs, load_change
from .skirt_films import (
    AxialMotion,
    FilmParts,
    SkirtFilms,
    forces_by_film,
    skirt_changes,
    skirt_films,
    total_forces,
    window_of,
)
from .step import StepResult
from .system import StepProblem

MOST_ITERATIONS = 60
"""Maximum number of iterations of Newton's method. Four are usual."""


class SpaceSolution(NamedTuple):
    """End of a step: load, motion, residual, evaluations, tangents and last change.

    Evaluations are 0 if the equations were not solved. The change is that of accelerations [m/s2,
    rad/s2].
    """

    load: SpaceLoad
    end: Motion
    imbalance: SpaceImbalance
    evaluations: int
    tangents: int
    change: float


class LastInSpace(NamedTuple):
    """Data of the last step for derivatives at its end."""

    coefficients: Coefficients
    solved: SpaceSolution
    crank: CrankMotion
    guide_height: float
    levers: tuple[Levers, ...]


class SpaceScalars(NamedTuple):
    """Scalar outputs across the plane of the crank, declared as `drive.Scalars`."""

    pin_axis_displacement: Annotated[float, "m", 1e-5]
    """Displacement of pin point A along the pin, +z."""
    roll_angle: Annotated[float, "rad", 1e-3]
    """Rotation of the piston about +x, including the constant pin_tilt."""
    yaw_angle: Annotated[float, "rad", 1e-3]
    """Rotation of the piston about +y."""
    pin_axis_velocity: Annotated[float, "m/s", 1e-2]
    """Velocity of pin point A along the pin."""
    roll_velocity: Annotated[float, "rad/s", 1.0]
    """Angular velocity of the piston about +x."""
    yaw_velocity: Annotated[float, "rad/s", 1.0]
    """Angular velocity of the piston about +y."""
    pin_axis_side_force: Annotated[float, "N", 1e2]
    """Force of the piston on the bore through the film along +z."""
    rod_force_z: Annotated[float, "N", 10.0]
    """Force of the rod on the pin along z, from stop and damper."""
    rod_moment_x: Annotated[float, "N.m", 1.0]
    """Moment of the small end on the pin about +x."""
    rod_moment_y: Annotated[float, "N.m", 1.0]
    """Moment of the small end on the pin about +y."""
    force_on_block_z: Annotated[float, "N", 1e2]
    """Force of bore and main bearings on the block along z."""
    moment_on_block_x: Annotated[float, "N.m", 10.0]
    """Moment of bore, deck and main bearings on the block about x."""
    moment_on_block_y: Annotated[float, "N.m", 10.0]
    """Moment of bore, deck and main bearings on the block about y."""


class PistonInSpace(PistonInBore):
    """Rigid piston in a rigid bore, with five coordinates.

    Parameters
    ----------
    planar : PistonInBore
        The same in its plane, without modes.
    bodies : motion_in_space.Bodies
    """

    IN_SPACE = True

    def __init__(self, planar: PistonInBore, bodies: SpaceBodies):
        vars(self).update(vars(planar))
        self.coordinates = COORDINATES
        self.bodies = bodies
        self.around = tuple(slope_around(one.bore) for one in self.film_surfaces)
        self.inertia = ArrowMatrix(inertia(bodies), np.zeros((0, COORDINATES)), np.zeros(0))
        self.with_rod = self.inertia._replace(top=self.inertia.top.copy())
        self.with_rod.top[:RIGID, :RIGID] += self.system.with_rod.top - self.system.inertia.top

    def _instant(self, step: StepProblem, step_inputs: StepInputs, inputs: Inputs) -> Instant:
        """Return everything at the end of a step, as `instant.end_of_step`."""
        c, before, auxiliary, _, crank, others = step
        system = self.system
        upright = height(system.mechanism, 0.0, crank.angle)
        guide = AxialMotion(upright.height, upright.lever * crank.speed)
        forces = step_inputs.skirt
        nodal = self._nodal(forces)
        sides = self._levers(guide.height)
        each = [side.forces(one) for side, one in zip(sides, nodal)]
        across = np.sum(each, axis=0)
        parts = forces_by_film(system, guide.height, forces)
        skirt = total_forces(parts)
        load = SpaceLoad(load_of(system, skirt, others), across)
        solved = self._solved(c, before, auxiliary, load, crank)
        self._space = LastInSpace(c, solved, crank, guide.height, sides)
        self._inverse: np.ndarray | None = None
        end = solved.end
        carried = predict(c, before, auxiliary).auxiliary + c.to_auxiliary * end.acceleration
        next_start = Motion(end.position, end.velocity.copy(), end.acceleration.copy())
        longest = self._limit(before, next_start, carried, c.step)

        imbalance = solved.imbalance
        at = imbalance.motion
        axial_velocity = at.velocity[-1, Y]
        on_grids = self._films(guide, forces, nodal, parts, axial_velocity, end)
        driven = c.step * (skirt.axial * axial_velocity + on_grids.on_slopes * guide.velocity)
        films = np.array([*skirt.push, *across])
        M = self.inertia, self.with_rod
        pin_x, pin_y = imbalance.on_piston
        on_block, self._across = forces_on_block(self.bodies, load, end, imbalance)
        turning = on_grids.on_slopes * upright.lever
        on_block = on_block._replace(  # Eq. (D70)
            moment_on_block=on_block.moment_on_block - turning,
            main_bearing_force_y=on_block.main_bearing_force_y + on_grids.on_slopes,
        )
        none = np.zeros(0)
        return Instant(
            end=end,
            next_start=next_start,
            auxiliary=carried,
            ledger=energy_ledger(before, next_start, end, *M, films, driven, 0.0),
            other_forces=other_forces(self.with_rod, end.acceleration, films),
            next_other_forces=other_forces(self.with_rod, next_start.acceleration, films),
            guide_height=guide.height,
            side_force=-skirt.push[LATERAL],
            films=on_grids,
            axial=AxialMotion(at.position[-1, Y], axial_velocity),
            pin_x=pin_x,
            pin_y=pin_y - on_grids.on_slopes,
            pin_moment=imbalance.pin_moment,
            torque=imbalance.torque - turning,
            pin_friction_power=imbalance.pin_moment
            * (at.velocity[BODY.rod, TURN] - at.velocity[-1, TURN]),
            element_power=0.0,
            evaluations=solved.evaluations,
            tangents=solved.tangents,
            change=solved.change,
            longest_step=longest,
            pin_film_thickness=none,
            circumferential_velocity=none,
            pin_work_error=none,
            pin_scalars=none,
            linear=cast(Any, None),  # `_response` has its own
            on_block=on_block,
        )

    def _films(
        self,
        guide: AxialMotion,
        forces: NodalForces,
        nodal: list[NodalForces],
        parts: FilmParts,
        axial_velocity: float,
        end: Motion,
    ) -> SkirtFilms:
        """Return all films of the skirt at the end of a step."""
        shift, shifting = end.position[IN_SPACE], end.velocity[IN_SPACE]
        position, velocity = end.position[:RIGID], end.velocity[:RIGID]
        flat = skirt_films(self.system, guide, forces, parts, axial_velocity, position, velocity)
        sides = self._space.levers
        slid = [side.sliding * shifting[ROLL - SHIFT] for side in sides]
        errors = []
        for side, own, sliding, error in zip(sides, nodal, slid, flat.work_error):
            on_grid = own.pressure * side.opening(shifting) + own.friction * sliding
            work = side.forces(own) * shifting
            size = np.abs(on_grid).sum() + np.abs(work).sum()
            difference = abs(on_grid.sum() - work.sum())
            errors.append(max(error, difference / size if size else 0.0))
        return SkirtFilms(
            flat.film_thickness + on_cells(side.opening(shift) for side in sides),
            flat.sliding_velocity + on_cells(slid),
            np.array(errors),
            flat.on_slopes,
        )

    def _nodal(self, forces: NodalForces) -> list[NodalForces]:
        """Return the stacked forces by surface, on its grid."""
        ends = np.cumsum([one.skirt.gap.size for one in self.film_surfaces])[:-1]
        shapes = [one.skirt.gap.shape for one in self.film_surfaces]
        fields = (np.split(one, ends) for one in forces)
        return [
            NodalForces(one.reshape(shape), other.reshape(shape))
            for one, other, shape in zip(*fields, shapes)
        ]

    def _levers(self, guide_height: float) -> tuple[Levers, ...]:
        """Return the levers of all surfaces, for A at its height when x_A = 0 [m]."""
        return tuple(
            levers(surface, around, window_of(surface, guide_height))
            for surface, around in zip(self.film_surfaces, self.around)
        )

    def _solved(
        self,
        c: Coefficients,
        before: Motion,
        auxiliary: np.ndarray,
        load: SpaceLoad,
        crank: CrankMotion,
    ) -> SpaceSolution:
        """Solve Eq. (D27) for the accelerations at the end of a step, by Newton's method.

        If the next change is not smaller than the last one, the last one is halved. If changes
        decrease slowly, the tangent is recomputed, as in `mechanism.solution`.
        """
        predicted = predict(c, before, auxiliary)
        acceleration = before.acceleration.copy()
        change = np.inf
        step = np.zeros(COORDINATES)
        share = 1.0
        slope = None
        tangents = 0
        for evaluation in range(1, MOST_ITERATIONS + 1):
            end = Motion(
                predicted.position + c.to_position * acceleration,
                predicted.velocity + c.to_velocity * acceleration,
                acceleration,
            )
            forces = imbalance(self.bodies, load, end, crank)
            if slope is None:
                slope = tangent(self.bodies, load, end, crank, c.to_velocity, c.to_position)
                tangents += 1
            next_change = np.linalg.solve(slope, forces.residual)
            size = np.abs(acceleration).max()
            left = np.abs(next_change).max()
            # a change that does not decrease tenfold is round-off of forces that cancel
            if left <= 1e-13 * size or (change <= 1e-7 * size and left >= 0.1 * change):
                return SpaceSolution(
                    load=load,
                    end=end,
                    imbalance=forces,
                    evaluations=evaluation,
                    tangents=tangents,
                    change=left,
                )
            if left > (1 - share / 4) * change:
                share /= 2
                acceleration = acceleration + share * step
                continue
            if left > 0.1 * change:
                slope = None
            step = next_change
            share = 1.0
            change = left
            acceleration = acceleration - step
        return SpaceSolution(
            load=load, end=end, imbalance=forces, evaluations=0, tangents=tangents, change=change
        )

    def _limit(self, before: Motion, next_start: Motion, carried: np.ndarray, step: float) -> float:
        """Bound what an impact step passes on (Eq. (N7)), in the plane and across it separately.

        Return the longest step of both (Eq. (N12)) [s].

        z and roll correspond to x_A and the rocking angle, and the first moment has the other sign.
        No film stops yaw.
        """
        body = with_pin(self.bodies)
        mass = body.mass + self.bodies.pin_mass
        in_plane = Inertia(mass, body.S[1], body.J[2, 2])
        across = Inertia(mass, -body.S[1], body.J[0, 0])
        longest = UNLIMITED
        for rigid, pair in ((in_plane, slice(0, RIGID)), (across, slice(SHIFT, YAW))):
            begun, ended = (
                Motion(one.position[pair], one.velocity[pair], one.acceleration[pair])
                for one in (before, next_start)
            )
            own = longest_step(rigid, begun, ended, carried[pair], step, self.system.resolution)
            longest = min(longest, own)
            limit_memory(rigid, begun, ended, carried[pair], step)
        return longest

    def _outputs(self, result: StepResult) -> dict[str, Any]:
        """Return the outputs of a piston in its plane, and those across it."""
        now = result.instant
        shift, roll, yaw = now.end.position[IN_SPACE]
        solved = self._space.solved
        motion = (shift, self.bodies.tilt + roll, yaw, *now.next_start.velocity[IN_SPACE])
        out_of_plane = -solved.load.across[0], *solved.imbalance.out_of_plane
        scalars = SpaceScalars._make([*motion, *out_of_plane, *self._across])
        return super()._outputs(result) | scalars._asdict()

    def _response(self, seeds: StepInputs, carried: np.ndarray) -> Response:
        """Return the change of the skirt's films and of the motion with forces.

        Eq. (D29):  J dq'' = -dr,   dq = c2 dq'',   dq' = c1 dq''       J, r of Eq. (D27)

        The block does not move, and the pin is tied.
        """
        c, solved, crank, guide_height, sides = self._space
        load, end = solved.load, solved.end
        system = self.system
        skirt = total_forces(forces_by_film(system, guide_height, seeds.skirt))
        across = [side.forces(one) for side, one in zip(sides, self._nodal(seeds.skirt))]
        change = SpaceLoad(load_change(system, skirt, seeds.rings), np.sum(across, axis=0))
        if self._inverse is None:
            self._inverse = np.linalg.inv(
                tangent(self.bodies, load, end, crank, c.to_velocity, c.to_position)
            )
            self.jacobian_evaluations += 1
        acceleration = -self._inverse @ pushed(self.bodies, load, end, crank, change)
        # Eq. (D29)
        place = c.to_position * acceleration
        speed = c.to_velocity * acceleration
        at = solved.imbalance.motion
        (x, y), (passing, _, _) = at.arm[-1], at.velocity[-1] - at.velocity[BODY.rod]
        steeper = (x * x + y * y) / y**3 * passing
        rising = -x / y * speed[LATERAL] - steeper * place[LATERAL]
        none = np.zeros(0)
        flat = skirt_changes(system, guide_height, rising, place[:RIGID], speed[:RIGID])
        return Response(
            film_thickness=flat.film_thickness
            + on_cells(side.opening(place[IN_SPACE]) for side in sides),
            sliding_velocity=flat.sliding_velocity
            + on_cells(side.sliding * speed[ROLL] for side in sides),
            lateral_velocity=speed[LATERAL],
            rocking_velocity=speed[ROCKING],
            piston_velocity=rising,
            pin_film_thickness=none,
            circumferential_velocity=none,
            on_block=NO_FORCE,
        )


def on_cells(fields: Iterable[np.ndarray]) -> np.ndarray:
    """Return the fields of all surfaces in one array."""
    return np.concatenate([field.ravel() for field in fields])
