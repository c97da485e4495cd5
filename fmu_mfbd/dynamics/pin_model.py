"""A piston whose pin floats: the model of `model.PistonInBore` with the films of the pin in both
bosses and in the rod's eye, which may yield, and those of the crank in rod and block where it has
any. The pin is rigid or tilts and bends; crank, block and what else there is of the rod are rigid.
"""

from typing import Any, NamedTuple

import numpy as np

from ..geometry.film import FilmForces, NodalForces, film_now, opening, sliding
from ..geometry.pin import (
    CRANK_SURFACES,
    PARALLEL,
    PIN_SURFACES,
    Bent,
    PinForces,
    PinResultants,
    PinSurface,
    Yielding,
    across,
    grid_power,
    leaning,
    modal_push,
    opening_of,
    resultants_on,
    slope_push,
    turned,
    yielded,
)
from ..geometry.pin_shapes import STRAIGHT, AxisShapes
from .build_options import FilmGrid
from .energy import Ledger
from .floating_pin import (
    BOSS_X,
    BOSS_Y,
    EYE_X,
    EYE_Y,
    NO_MODES,
    RIGID_CRANK,
    RIGID_EYE,
    SPIN,
    Bodies,
    Crankshaft,
    EyeModes,
    Lack,
    PinFilms,
    eye_motion,
    imbalance,
    inertia,
    inertia_with_rod,
    on_shapes,
    place_of,
    pushed,
    tangent,
)
from .generalised_alpha import Coefficients, Motion, predict
from .impact import Inertia, limit_memory
from .instant import (
    NO_RINGS,
    Instant,
    OtherForces,
    RingForce,
    forces_by_film,
    part_of,
    together,
    window_of,
    work_error,
)
from .model import Inputs, PistonInBore
from .piston_motion import LATERAL, RIGID, ROCKING, Load
from .slider_crank import CrankMotion, height, motion, rod_turn

PASSES = 30
"""Most iterations of Newton's method; its tangent is exact, three are usual."""

*BOSSES, EYE = PIN_SURFACES
BIG_END, MAIN_BEARING = CRANK_SURFACES

STRAIGHT_JOURNAL = Bent(PARALLEL, PARALLEL)
"""Those of the crank stay parallel to their shells."""


class Shell(NamedTuple):
    """Where the pin, or a journal of the crank, stands in a shell, and how both turn.

    Parameters
    ----------
    axes : ndarray, shape (2, 2)
        R(chi), by the angle that the shell has turned.
    place, velocity : ndarray, shape (2,)
        Of the pin's axis from the shell's, in space [m], [m/s].
    own_turning, turning : float
        chi' of the shell, phi' - chi' of the pin in it [rad/s].
    bent : Bent
        Of the pin, in space.
    """

    axes: np.ndarray
    place: np.ndarray
    velocity: np.ndarray
    own_turning: float
    turning: float
    bent: Bent

    def own_place(self) -> np.ndarray:
        """d of Eq. (H6) [m]."""
        return self.axes.T @ self.place

    def own_velocity(self) -> np.ndarray:
        """d' [m/s]."""
        return self.axes.T @ (self.velocity - self.own_turning * across(self.place))

    def own_bent(self) -> Bent:
        """How the pin tilts and bends in the axes of the shell."""
        return Bent(self.bent.position @ self.axes, self.moved(*self.bent, self.own_turning))

    def moved(self, position: np.ndarray, change: np.ndarray, turn: float) -> np.ndarray:
        """Change of shapes' coordinates, (n, 2), in the axes of the shell, which turns [m]."""
        return (change - turn * np.column_stack([-position[:, 1], position[:, 0]])) @ self.axes


class OnModes(NamedTuple):
    """Moments on the pin by the slopes of all bosses and of the eye (Eq. (G5)), by modal
    coordinate, and forces on the eye's modes (Eq. (G6)).
    """

    slope_push: np.ndarray
    eye_slope_push: np.ndarray
    on_eye: np.ndarray


class Reach(NamedTuple):
    """What an end acceleration of 1 adds to each coordinate's velocity [s] and position [s2] at the
    end of a step, shape (7 + k + 2 n,).
    """

    velocity: np.ndarray
    position: np.ndarray


class Solved(NamedTuple):
    """The end of a step.

    Parameters
    ----------
    reach : Reach
    load : Load
        On the piston, all but the pin's; with the modal forces of the bosses' films.
    end : Motion
    crank : CrankMotion
    guided : float
        Height at which the bore is read [m].
    shells : tuple of Shell
        Of every film of pin and crank.
    each : list of PinResultants
        Likewise.
    films : PinFilms
        Together.
    lack : Lack
    evaluations : int
        0 where the equations were not solved.
    change : float
        Of accelerations, in the last pass [m/s2, rad/s2].
    """

    reach: Reach
    load: Load
    end: Motion
    crank: CrankMotion
    guided: float
    shells: tuple[Shell, ...]
    each: list[PinResultants]
    films: PinFilms
    lack: Lack
    evaluations: int
    change: float


class PistonOnFloatingPin(PistonInBore):
    """Piston, floating pin and rod, and the geometry of the films between them and in the bore.

    Parameters
    ----------
    tied : PistonInBore
        The same without a pin of its own, no mode of it static, the block rigid.
    pins : tuple of PinSurface
        In both bosses and in the rod's eye, then those of the crank; the bosses with the piston's
        modes, if it has any, the eye with its own.
    grids : tuple of FilmGrid
        Names and shapes of their fields.
    spin_inertia : float
        Of the pin about its axis [kg m2].
    shapes : AxisShapes
        In which it tilts and bends; `pins` have their values.
    eye : EyeModes
        Those of the rod's eye.
    crank : Crankshaft
        What of it has films.
    """

    def __init__(
        self,
        tied: PistonInBore,
        pins: tuple[PinSurface, ...],
        grids: tuple[FilmGrid, ...],
        spin_inertia: float,
        shapes: AxisShapes = STRAIGHT,
        eye: EyeModes = RIGID_EYE,
        crank: Crankshaft = RIGID_CRANK,
    ):
        vars(self).update(vars(tied))
        self.pins = pins
        self.grids = grids
        self.surfaces = (*PIN_SURFACES, *crank.surfaces)
        mechanism = self.system.mechanism
        self.bodies = Bodies(self.system.piston, mechanism, spin_inertia, shapes, eye, crank)
        self.coordinates = self.bodies.size()
        self.held = self.bodies.held()
        self.inertia = inertia(self.bodies)
        self.with_rod = inertia_with_rod(self.bodies)

    def _instant(
        self,
        c: Coefficients,
        before: Motion,
        auxiliary: np.ndarray,
        crank: CrankMotion,
        others: OtherForces,
        inputs: Inputs,
    ) -> Instant:
        """Everything at the end of a step, as `instant.end_of_step`."""
        system = self.system
        guided = height(system.mechanism, 0.0, crank.angle)
        push = np.ravel(inputs.pressure_force)
        drag = np.ravel(inputs.friction_force)
        parts = forces_by_film(system, guided.height, push, drag)
        skirt = together(system, parts)
        along_bore = others.gas - others.rings.axial
        load = Load(
            lateral=skirt.lateral + others.rings.lateral,
            axial=skirt.axial - along_bore,
            moment=skirt.moment + system.pin_offset * along_bore + others.rings.moment,  # Eq. (D8)
            guided=along_bore,
            modal=self._modal(skirt, inputs.pins) + others.gas * system.gas_force,
        )
        predicted, carried, reach = self._predicted(c, before, auxiliary)
        solved = self._solved((predicted, before.acceleration), reach, load, crank, inputs.pins)
        self._pin = solved = solved._replace(guided=guided.height)
        self._pin_forces = inputs.pins
        end = solved.end
        carried = carried + c.to_auxiliary * end.acceleration
        carried[self.held] = 0.0
        kept = Motion(end.position, end.velocity.copy(), end.acceleration.copy())
        piston = system.piston
        rigid = Inertia(piston.mass + system.mechanism.pin_mass, piston.S[1], piston.I0)
        impact = limit_memory(rigid, before, kept, carried, c.step)

        guided_velocity = guided.lever * crank.speed
        height_now, axial_velocity = self._height(end, crank)
        of_skirt = Motion(*(self._of_skirt(one) for one in end))
        thickness = np.empty(len(push))
        velocity = np.empty(len(push))
        errors = []
        on_slopes = 0.0  # axial force of pressure on bores that are not straight
        first = 0
        for k, surface in enumerate(self.film_surfaces):
            shape = surface.skirt.gap.shape
            last = first + surface.skirt.gap.size
            film = film_now(
                surface.skirt,
                surface.bore,
                window_of(surface, guided.height),
                NodalForces(push[first:last].reshape(shape), drag[first:last].reshape(shape)),
                axial_velocity,
                guided_velocity,
                of_skirt.position,
                of_skirt.velocity,
            )
            thickness[first:last] = film.film_thickness.ravel()
            velocity[first:last] = film.sliding_velocity.ravel()
            errors.append(
                work_error(
                    part_of(system, parts, k),
                    film,
                    axial_velocity,
                    guided_velocity,
                    of_skirt.velocity,
                )
            )
            on_slopes += film.axial_force
            first = last
        driven = skirt.axial * axial_velocity + on_slopes * guided_velocity
        driven += self._along_crank(solved.films, crank, solved.shells[len(BOSSES)].own_turning)
        forces = self._forces(skirt, solved.films, self._modal(skirt, inputs.pins))
        ledger = self._ledger(before, kept, end, forces, c.step * driven)
        pin_x, pin_y = solved.lack.on_piston
        return Instant(
            position=end.position,
            velocity=end.velocity,
            acceleration=end.acceleration,
            kept_velocity=kept.velocity,
            kept_acceleration=kept.acceleration,
            auxiliary=carried,
            impact=impact,
            ledger=ledger,
            other_forces=self.with_rod @ end.acceleration - forces,  # Eq. (D15)
            guided=guided.height,
            load=load,
            side_force=-skirt.lateral,
            film_thickness=thickness,
            sliding_velocity=velocity,
            piston_position=height_now,
            piston_velocity=axial_velocity,
            pin_x=pin_x,
            pin_y=pin_y - on_slopes,
            pin_moment=solved.films.bosses.on_shell,
            torque=solved.lack.torque - on_slopes * guided.lever,
            pin_friction_power=-sum(
                shell.turning * one.on_pin
                for shell, one, _ in zip(solved.shells, solved.each, PIN_SURFACES)
            ),
            work_error=np.array(errors),
            evaluations=solved.evaluations,
            tangents=solved.evaluations,
            change=solved.change,
        )

    def _solved(
        self,
        guess: tuple[Motion, np.ndarray],
        reach: Reach,
        load: Load,
        crank: CrankMotion,
        forces: tuple[PinForces, ...],
    ) -> Solved:
        """Accelerations that fulfil Eq. (D21) at the end of a step, by Newton's method, from where
        the step ends without any and from those at its beginning.
        """
        predicted, begun = guess
        acceleration = begun.copy()
        change = np.inf
        fixed = self._on_modes(forces)
        for evaluation in range(1, PASSES + 1):
            end = Motion(
                predicted.position + reach.position * acceleration,
                predicted.velocity + reach.velocity * acceleration,
                acceleration,
            )
            shells = self._shells(end, crank)
            each = self._resultants(shells, forces, end.position)
            films = self._together(each, fixed)
            lack = imbalance(self.bodies, load, end, crank, films)
            slope = tangent(self.bodies, load, end, crank, films, *reach)
            step = np.linalg.solve(slope, lack.residual)
            size = np.abs(acceleration).max()
            left = np.abs(step).max()
            # what grows again, or does not fall by ten, is round-off of forces that cancel
            if left <= 1e-13 * size or (change <= 1e-7 * size and left >= 0.1 * change):
                return Solved(
                    reach, load, end, crank, 0.0, shells, each, films, lack, evaluation, left
                )
            acceleration = acceleration - step
            change = left
        return Solved(reach, load, end, crank, 0.0, shells, each, films, lack, 0, change)

    def _shells(self, end: Motion, crank: CrankMotion) -> tuple[Shell, ...]:
        """Of each film of pin and crank."""
        position = end.position
        velocity = end.velocity
        eye = eye_motion(self.bodies, end)
        mechanism = self.bodies.mechanism
        rod = rod_turn(mechanism, eye.position, eye.velocity, crank.angle, crank.speed)
        aside = mechanism.offset + eye.position + mechanism.crank_radius * np.sin(crank.angle)
        rod_angle = -np.arcsin(aside / mechanism.rod_length)  # Eq. (K3)
        bent = Bent(self.bodies.bent(position), self.bodies.bent(velocity))
        boss = Shell(
            turned(position[ROCKING]),
            position[BOSS_X : BOSS_Y + 1],
            velocity[BOSS_X : BOSS_Y + 1],
            velocity[ROCKING],
            velocity[SPIN] - velocity[ROCKING],
            bent,
        )
        in_rod = turned(rod_angle)
        small_end = Shell(
            in_rod,
            position[EYE_X : EYE_Y + 1],
            velocity[EYE_X : EYE_Y + 1],
            rod.velocity,
            velocity[SPIN] - rod.velocity,
            bent,
        )
        turns = {
            BIG_END: (in_rod, rod.velocity, crank.speed - rod.velocity),
            MAIN_BEARING: (np.eye(2), 0.0, crank.speed),
        }
        of_crank = []
        for name in self.bodies.crank.surfaces:
            axes, own_turning, turning = turns[name]
            place, moved = (self.bodies.play(name, one) for one in (position, velocity))
            of_crank.append(Shell(axes, place, moved, own_turning, turning, STRAIGHT_JOURNAL))
        return (*(boss for _ in BOSSES), small_end, *of_crank)

    def _together(self, each: list[PinResultants], on_modes: OnModes) -> PinFilms:
        """Films of both bosses as one, and the others by their names."""
        found = dict(zip(self.surfaces, each))
        parts = zip(*(found[name] for name in BOSSES))
        force, on_pin, on_shell, on_axis = (sum(one) for one in parts)
        both = PinResultants(np.asarray(force), float(on_pin), float(on_shell), np.asarray(on_axis))
        of_crank = {name: found[name] for name in self.bodies.crank.surfaces}
        return PinFilms(both, found[EYE], *on_modes, **of_crank)

    def _along_crank(self, films: PinFilms, crank: CrankMotion, rod_turning: float) -> float:
        """Power of the films on what the crank drives [W]."""
        on_crank = films.big_end.on_pin + films.main_bearing.on_pin
        return films.on_rod() * rod_turning + on_crank * crank.speed

    def _resultants(
        self, shells: tuple[Shell, ...], forces: tuple[PinForces, ...], position: np.ndarray
    ) -> list[PinResultants]:
        """Of each film of pin and crank, shells yielding by the coordinates at `position`."""
        out = []
        for k, (surface, one, shell) in enumerate(zip(self.pins, forces, shells)):
            found = resultants_on(surface, one, shell.place, shell.axes, shell.bent.position)
            if surface.modes is not None:
                modal = self._modes_of(k, position)
                found = found.with_slopes(float(slope_push(surface, one.pressure) @ modal))
            out.append(found)
        return out

    def _modes_of(self, k: int, coordinates: np.ndarray) -> np.ndarray:
        """Modal coordinates by which the shell of film k yields."""
        of_shell = self.bodies.modal if self.surfaces[k] in BOSSES else self.bodies.in_eye
        return of_shell(coordinates)

    def _on_modes(self, forces: tuple[PinForces, ...]) -> OnModes:
        """What the films do by the modes of their shells."""
        at = len(BOSSES)
        eye, in_eye = self.pins[at], forces[at]
        yields = eye.modes is not None
        return OnModes(
            slope_push=sum(
                (
                    slope_push(surface, one.pressure)
                    for surface, one in zip(self.pins[: len(BOSSES)], forces)
                    if surface.modes is not None
                ),
                NO_MODES if not self.modes else np.zeros(self.modes),
            ),
            eye_slope_push=slope_push(eye, in_eye.pressure) if yields else NO_MODES,
            on_eye=modal_push(eye, in_eye) if yields else NO_MODES,
        )

    def _modal(self, skirt: FilmForces, forces: tuple[PinForces, ...]) -> np.ndarray:
        """Forces of all films on the piston's modes, (k,)."""
        pushed_by = [
            modal_push(surface, one)
            for surface, one in zip(self.pins[: len(BOSSES)], forces)
            if surface.modes is not None
        ]
        return sum(pushed_by, skirt.piston)

    def _predicted(
        self, c: Coefficients, before: Motion, auxiliary: np.ndarray
    ) -> tuple[Motion, np.ndarray, Reach]:
        """Where a step ends without accelerations, its auxiliary accelerations, and their reach.

        Eq. (N9):  x_A, rocking angle and phi by Eq. (N2), a, e, b, m, modes and shapes by Eq. (N8)

        Films hold the pin within its play, springs the modes that bend away from it: what inertia
        does there is over within microseconds, and a method that remembers it rings.
        """
        n = self.coordinates
        held = self.held
        position, velocity, carried = predict(c, before, auxiliary)
        reach = Reach(np.full(n, c.to_velocity), np.full(n, c.to_position))
        # Eq. (N9)
        position[held] = before.position[held] + c.step * before.velocity[held]
        velocity[held] = before.velocity[held]
        reach.velocity[held] = c.step
        reach.position[held] = c.step**2
        return Motion(position, velocity, np.zeros(n)), carried, reach

    def _of_skirt(self, coordinates: np.ndarray) -> np.ndarray:
        """Coordinates of the skirt's film: x_A, rocking angle, modes."""
        return np.append(coordinates[:RIGID], self.bodies.modal(coordinates))

    def _height(self, end: Motion, crank: CrankMotion) -> tuple[float, float]:
        """Height of A [m] and its velocity [m/s] (Eq. (K16))."""
        eye = eye_motion(self.bodies, end)
        now = height(self.bodies.mechanism, eye.position, crank.angle)
        driven = now.slope * eye.velocity + now.lever * crank.speed
        place, speed = (self._lifted(one) for one in (end.position, end.velocity))
        return float(now.height + place), float(driven + speed)

    def _lifted(self, coordinates: np.ndarray) -> float:
        """By which play lifts A (Eqs. (K16), (K25)) [m], or its change."""
        _, lifted = self.bodies.shift(coordinates)
        return float(coordinates[EYE_Y] - coordinates[BOSS_Y] + lifted)

    def _forces(self, skirt: FilmForces, films: PinFilms, modal: np.ndarray) -> np.ndarray:
        """Generalised forces of all films, but for what they do along the driven motion,
        (7 + k + 2 n,); `modal` those on the modes.
        """
        on_pin = films.bosses.on_pin + films.eye.on_pin
        rocking = skirt.moment + films.bosses.on_shell
        rigid = [skirt.lateral, rocking, *films.bosses.force, *films.eye.force, on_pin]
        return self.bodies.stacked(
            rigid=np.array(rigid),
            modes=modal,
            shapes=on_shapes(films).ravel(),
            eye=films.on_eye,
            big_end=films.big_end.force,
            main_bearing=films.main_bearing.force,
        )

    def _elastic(self, position: np.ndarray) -> float:
        """Energy of the modes of piston and eye and of the pin's shapes [J]."""
        stored = float(self.system.piston.stiffness @ self.bodies.modal(position) ** 2) / 2
        stored += float(self.bodies.eye.stiffness @ self.bodies.in_eye(position) ** 2) / 2
        bent = self.bodies.bent(position)
        return stored + float((self.bodies.shapes.stiffness @ bent**2).sum()) / 2

    def _ledger(
        self, before: Motion, kept: Motion, end: Motion, forces: np.ndarray, driven: float
    ) -> Ledger:
        """Energies as in `energy`, by the inertia of Eq. (D22)."""
        M = self.with_rod
        way = end.position - before.position
        mean = (before.acceleration + end.acceleration) / 2
        first = float(before.velocity @ M @ before.velocity)
        last = float(kept.velocity @ M @ kept.velocity)
        return Ledger(
            kinetic=float(kept.velocity @ self.inertia @ kept.velocity) / 2,
            elastic=self._elastic(kept.position),
            film_work=float(forces @ way) + driven,  # Eq. (D11)
            error=(last - first) / 2 - float(way @ M @ mean),  # Eq. (D10)
            axial_work=driven,
            accounted=last / 2,
        )

    def _outputs(self, now: Instant, crank: CrankMotion) -> dict[str, Any]:
        """Those of the tied pin, and the pin's own."""
        outputs = super()._outputs(now, crank)
        position = now.position
        pin = self._pin
        for k, grid in enumerate(self.grids):
            surface = self.pins[k]
            shell = pin.shells[k]
            gap = surface.clearance + opening_of(surface, shell.own_place())
            gap = gap + yielded(surface, self._modes_of(k, position))
            if surface.axis is not None:
                gap = gap + leaning(surface, shell.own_bent().position)
            outputs |= {
                f"{grid.prefix}film_thickness": gap,
                f"{grid.prefix}sliding_velocity": np.zeros(grid.shape),
                # Eq. (H7)
                f"{grid.prefix}circumferential_velocity": np.full(
                    grid.shape, surface.radius * shell.turning
                ),
                f"{grid.prefix}interface_work_error": self._work_error(k, shell),
            }
        eye_x, eye_y = pin.films.eye.force
        if self.modes:
            outputs["modal_coordinate"] = self.bodies.modal(position).copy()
            outputs["modal_velocity"] = self.bodies.modal(now.kept_velocity).copy()
        return (
            outputs
            | self._axis(position)
            | self._eye(position, now.kept_velocity)
            | self._of_crank(position)
            | {
                "pin_displacement_x": position[BOSS_X],
                "pin_displacement_y": position[BOSS_Y],
                "small_end_displacement_x": position[EYE_X],
                "small_end_displacement_y": position[EYE_Y],
                "pin_angle": position[SPIN],
                "pin_rotation_speed": now.kept_velocity[SPIN],
                "small_end_force_x": -eye_x,
                "small_end_force_y": -eye_y,
                "small_end_friction_moment": pin.films.eye.on_shell,
            }
        )

    def _eye(self, position: np.ndarray, velocity: np.ndarray) -> dict[str, Any]:
        """How an eye with modes yields."""
        surface = self.pins[len(BOSSES)]
        if surface.modes is None:
            return {}
        modal = self.bodies.in_eye(position)
        wider = _diameters(yielded(surface, modal))
        return {
            "small_end_widening_across": wider[0],
            "small_end_widening_along": wider[1],
            "small_end_modal_coordinate": modal.copy(),
            "small_end_modal_velocity": self.bodies.in_eye(velocity).copy(),
        }

    def _of_crank(self, position: np.ndarray) -> dict[str, Any]:
        """Where the crank stands in its films, and what it does to rod and block."""
        out = {}
        for name in self.bodies.crank.surfaces:
            film = getattr(self._pin.films, name)
            x, y = self.bodies.play(name, position)
            force_x, force_y = film.force
            out |= {
                f"{name}_displacement_x": x,
                f"{name}_displacement_y": y,
                f"{name}_force_x": -force_x,
                f"{name}_force_y": -force_y,
                f"{name}_friction_moment": film.on_shell,
            }
        return out

    def _axis(self, position: np.ndarray) -> dict[str, Any]:
        """How a pin with shapes tilts and bends."""
        shapes = self.bodies.shapes
        if not len(shapes.mass):
            return {}
        bent = self.bodies.bent(position)
        tilt, sag = shapes.slope @ bent, shapes.sag @ bent
        return {
            "pin_tilt_x": float(tilt[0]),
            "pin_tilt_y": float(tilt[1]),
            "pin_bending_x": float(sag[0]),
            "pin_bending_y": float(sag[1]),
        }

    def _work_error(self, k: int, shell: Shell) -> float:
        """Power of a film on the grid (Eq. (G4)) minus that in the coordinates, relative [-]."""
        found = self._pin.each[k]
        forces = self._pin_forces[k]
        surface = self.pins[k]
        end = self._pin.end
        yielding = Yielding(*(self._modes_of(k, one) for one in (end.position, end.velocity)))
        place, velocity = shell.own_place(), shell.own_velocity()
        bent = shell.own_bent()
        power, size = grid_power(surface, forces, place, velocity, shell.turning, yielding, bent)
        parts = found.force @ shell.velocity, found.on_shell * shell.own_turning
        if surface.modes is not None:
            parts = (*parts, float(modal_push(surface, forces) @ yielding.velocity))
        if surface.axis is not None:
            parts = (*parts, float(np.sum(found.on_shapes * shell.bent.velocity)))
        pin = found.on_pin * (shell.own_turning + shell.turning)
        size += sum(abs(one) for one in (*parts, pin))
        return float(abs(power - sum(parts) - pin) / size) if size > 0.0 else 0.0

    def directional_derivative(
        self,
        pressure_force: np.ndarray,
        friction_force: np.ndarray,
        rings: RingForce = NO_RINGS,
        pins: tuple[PinForces, ...] = (),
    ) -> dict[str, np.ndarray | float]:
        """Change of films and motion at the end of the last step with the forces at its end.

        Eq. (D23):  J dq'' = -dr,   dq = c2 dq'',   dq' = c1 dq''       J, r of Eq. (D21)

        Parameters
        ----------
        pressure_force, friction_force, rings
            As of the tied pin.
        pins : tuple of PinForces
            Directions, of all films of the pin [N].
        """
        last = self._pin
        end = last.end
        system = self.system
        push = np.ravel(pressure_force)
        drag = np.ravel(friction_force)
        skirt = together(system, forces_by_film(system, last.guided, push, drag))
        arm = system.pin_offset + end.position[LATERAL]
        changes = (
            skirt.lateral + rings.lateral,
            skirt.axial + rings.axial,
            skirt.moment + rings.moment - rings.axial * arm,  # Eq. (D8)
        )
        fixed = self._on_modes(pins)
        films = self._together(self._resultants(last.shells, pins, end.position), fixed)
        at = place_of(self.bodies, end, last.crank)
        if self._linear is None:
            self._linear = np.linalg.inv(
                tangent(self.bodies, last.load, end, last.crank, last.films, *last.reach)
            )
            self.jacobian_evaluations += 1
        acceleration = -self._linear @ pushed(
            self.bodies, at, films, changes, self._modal(skirt, pins)
        )
        # Eq. (D23)
        moved = Motion(
            last.reach.position * acceleration, last.reach.velocity * acceleration, acceleration
        )
        place, speed, _ = moved
        eye = eye_motion(self.bodies, moved)
        link = motion(self.bodies.mechanism, eye_motion(self.bodies, end), last.crank)
        rising = link.slope * eye.velocity + link.axial_by_velocity / 2 * eye.position
        rising += self._lifted(speed)
        none = np.zeros(0)
        gaps = []
        velocities = []
        for surface in self.film_surfaces:
            window = window_of(surface, last.guided)
            sides = (surface.skirt, surface.bore, window)
            bent, bending = (self.bodies.modal(one) for one in (place, speed))
            gaps.append(opening(*sides, place[LATERAL], place[ROCKING], bent, none).ravel())
            velocities.append(sliding(*sides, rising, speed[ROCKING], bending, none).ravel())
        out: dict[str, Any] = {
            **self._by_film("film_thickness", np.concatenate(gaps)),
            **self._by_film("sliding_velocity", np.concatenate(velocities)),
            "lateral_velocity": speed[LATERAL],
            "rocking_velocity": speed[ROCKING],
            "piston_velocity": rising,
        }
        rod = (
            at.rod.slope * eye.position,
            at.rod.slope * eye.velocity + at.rod.velocity_slope * eye.position,
        )
        boss = place[BOSS_X : BOSS_Y + 1], place[ROCKING], speed[SPIN] - speed[ROCKING]
        in_rod, turning = rod
        ways = dict.fromkeys(BOSSES, boss) | {
            EYE: (place[EYE_X : EYE_Y + 1], in_rod, speed[SPIN] - turning),
            BIG_END: (self.bodies.play(BIG_END, place), in_rod, -turning),
            MAIN_BEARING: (self.bodies.play(MAIN_BEARING, place), 0.0, 0.0),
        }
        for k, grid in enumerate(self.grids):
            surface = self.pins[k]
            shell = last.shells[k]
            moved_by, turn, spun = ways[self.surfaces[k]]
            way = shell.axes.T @ (moved_by - turn * across(shell.place))
            faster = surface.radius * spun
            gap = opening_of(surface, way) + yielded(surface, self._modes_of(k, place))
            if surface.axis is not None:
                aside = self.bodies.bent(place)
                gap = gap + leaning(surface, shell.moved(shell.bent.position, aside, turn))
            out |= {
                f"{grid.prefix}film_thickness": gap,
                f"{grid.prefix}circumferential_velocity": np.full(grid.shape, faster),
            }
        return out


def _diameters(opened: np.ndarray) -> tuple[float, float]:
    """By how much a shell is wider along its own x and y, amid its length, from what it yields by,
    (c, a).

    Eq. (H13):  D(a) = u(a) + u(a + pi),   u linear between the grid's lines and rows
    """
    around, along = opened.shape
    amid = (opened[:, (along - 1) // 2] + opened[:, along // 2]) / 2
    lines = np.arange(around + 1) / around
    at = np.interp([0.0, 0.25, 0.5, 0.75], lines, np.append(amid, amid[0]))
    east, north, west, south = at.tolist()
    return east + west, north + south  # Eq. (H13)
