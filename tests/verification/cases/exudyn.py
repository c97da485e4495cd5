"""The flexible piston on its crank in Exudyn, an independent multibody code.

Mesh, modes, mechanism and forces are the same. The piston's frame A is on a rigid rod whose other
end rotates with the crank at constant speed. Springs hold A laterally and against rotation, where
the oil film would. A gas force on the crown rises and falls. There is no gravity and no damping.
"""

from typing import Any, NamedTuple

import numpy as np

from piston_cosim.fmu_mfbd.dynamics.pin_films import forces_of
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED
from piston_cosim.fmu_mfbd.mechanism.floating_frame import FlexibleBody
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import (
    Coefficients,
    Motion,
    Prediction,
    coefficients,
    predict,
)
from piston_cosim.fmu_mfbd.mechanism.piston_motion import LATERAL, ROCKING, Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import (
    CrankMotion,
    Mechanism,
    height,
)
from piston_cosim.fmu_mfbd.mechanism.solution import solve_motion

from .links import increments_of
from .tied import tied_pin


class Drive(NamedTuple):
    """What moves and holds the piston.

    Parameters
    ----------
    crank_angle, crank_speed : float
        At the start [rad], [rad/s]: constant.
    lateral_stiffness, turning_stiffness : float
        On x_A [N/m], on the rocking angle [N m/rad].
    gas_force, duration : float
        F(t) = gas_force sin^2(pi t/duration) along -y [N], [s].
    """

    crank_angle: float
    crank_speed: float
    lateral_stiffness: float
    turning_stiffness: float
    gas_force: float
    duration: float

    def gas(self, time: float) -> float:
        """F(t) [N]."""
        return self.gas_force * np.sin(np.pi * time / self.duration) ** 2


class CrankedPiston(NamedTuple):
    """The reduced piston on its crank, and what drives it.

    Parameters
    ----------
    body : FlexibleBody
    mechanism : Mechanism
    gas_shape : ndarray, shape (k,)
        Modal force of a unit gas force [kg^-1/2].
    drive : Drive
    """

    body: FlexibleBody
    mechanism: Mechanism
    gas_shape: np.ndarray
    drive: Drive


class FullPiston(NamedTuple):
    """The piston's finite elements and modes, as Exudyn takes them.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Nodes from A [m].
    K, M : scipy.sparse matrix, shape (3 n, 3 n)
        Full matrices [N/m], [kg].
    modes : ndarray, shape (3 n, k)
        [kg^-1/2]
    """

    points: np.ndarray
    K: Any
    M: Any
    modes: np.ndarray


class Start(NamedTuple):
    """Where the mechanism stands at the start.

    Parameters
    ----------
    lever : float
        dY/d(crank angle) [m].
    turn : float
        The rod's angular velocity [rad/s].
    pin, A : ndarray, shape (3,)
        Crank pin and A [m].
    """

    lever: float
    turn: float
    pin: np.ndarray
    A: np.ndarray


def own_motion(
    piston: CrankedPiston, step: float, steps: int, spectral_radius: float
) -> np.ndarray:
    """Piston motion by this package.

    Parameters
    ----------
    piston : CrankedPiston
    step, steps : float, int
        [s]
    spectral_radius : float

    Returns
    -------
    ndarray, shape (steps + 1, 2 + k)
        x_A [m], rocking angle [rad], modal coordinates [kg^1/2 m]; it starts at rest and
        undeformed.
    """
    nothing = np.zeros(2 + len(piston.gas_shape))
    history = [nothing]
    at_rest = Prediction(nothing, nothing, nothing)
    now = _end_of_step(piston, 0.0, coefficients(0.0, spectral_radius), at_rest, nothing)
    c = coefficients(step, spectral_radius)
    auxiliary = now.acceleration
    for k in range(1, steps + 1):
        predicted = predict(c, now, auxiliary)
        now = _end_of_step(piston, k * step, c, predicted, now.acceleration)
        auxiliary = predicted.auxiliary + c.to_auxiliary * now.acceleration
        history.append(now.position)
    return np.array(history)


def _end_of_step(piston, time, c: Coefficients, predicted: Prediction, guess) -> Motion:
    """Return the motion at the end of a step.

    The springs' forces and the position are computed in turn. The springs add only 1e-3 to the
    inertia.
    """
    drive = piston.drive
    F = drive.gas(time)
    crank = CrankMotion(drive.crank_angle + drive.crank_speed * time, drive.crank_speed, 0.0)
    chain, by = tied_pin(piston.body, piston.mechanism, 0.0), increments_of(c, len(guess))
    a = guess
    for _ in range(6):
        end = predicted.position + c.to_position * a
        load = Load(
            lateral=-drive.lateral_stiffness * end[LATERAL],
            axial=-F,
            moment=-drive.turning_stiffness * end[ROCKING],
            axis_force=0.0,  # in Exudyn the force stays on A
            modal=F * piston.gas_shape,
        )
        now = solve_motion(chain, forces_of(chain, load), predicted, a, by, crank, FIXED).now
        a = now.acceleration
    return now


def exudyn_motion(
    full: FullPiston, piston: CrankedPiston, step: float, steps: int, spectral_radius: float
) -> np.ndarray:
    """Return the motion of `own_motion` as computed by Exudyn.

    It uses ObjectFFRFreducedOrder, joints as constraints, and generalised-alpha.

    Parameters
    ----------
    full : FullPiston
    piston, step, steps, spectral_radius
        As for `own_motion`.

    Returns
    -------
    ndarray, shape (steps + 1, 2 + k)
    """
    import exudyn as exu
    import exudyn.itemInterface as item

    mechanism = piston.mechanism
    drive = piston.drive
    system = exu.SystemContainer().AddSystem()
    start = _start(mechanism, drive)
    body = _exudyn_piston(exu, system, full, start, piston.gas_shape, drive)
    _held(item, system, body["nRigidBody"], drive)
    _crank_and_rod(item, system, body["nRigidBody"], mechanism, drive, start)
    sensors = [
        system.AddSensor(
            item.SensorNode(
                nodeNumber=node,
                storeInternal=True,
                outputVariableType=exu.OutputVariableType.Coordinates,
            )
        )
        for node in (body["nRigidBody"], body["nGenericODE2"])
    ]
    system.Assemble()
    system.SolveDynamic(_settings(exu, step, steps, spectral_radius))
    frame, modal = (system.GetSensorStoredData(sensor) for sensor in sensors)
    lateral = 1  # after the time: x y z, then three angles
    angle = 6
    return np.column_stack([frame[:, lateral], frame[:, angle], modal[:, 1:]])


def _start(mechanism: Mechanism, drive: Drive) -> Start:
    """Where the mechanism stands at the start."""
    phi = drive.crank_angle
    r = mechanism.crank_radius
    above = height(mechanism, 0.0, phi)
    along = r * np.cos(phi)
    return Start(
        lever=above.lever,
        turn=-along * drive.crank_speed / (above.height - along),  # Eq. (K3)
        pin=np.array([-r * np.sin(phi), r * np.cos(phi), 0.0]),
        A=np.array([mechanism.offset, above.height, 0.0]),
    )


def _exudyn_piston(exu, system, full, start, gas_shape, drive):
    """Add the flexible piston with its gas force, and return Exudyn's dictionary of the parts.

    It starts with the velocity along y that the crank gives it.
    """
    from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface

    fem = FEMinterface()
    fem.nodes = {"Position": full.points}
    fem.massMatrix = full.M.tocsr()
    fem.stiffnessMatrix = full.K.tocsr()
    fem.modeBasis = {"matrix": full.modes, "type": "NormalModes"}
    fem.surface = [{"Name": "none", "Trigs": np.zeros((0, 3), int)}]
    speed = start.lever * drive.crank_speed

    def force(system, time, number, q, dq):
        F = drive.gas(time)
        return [0.0, -F, 0.0, 0.0, 0.0, 0.0, *(F * gas_shape)]

    interface = ObjectFFRFreducedOrderInterface(fem, rigidBodyNodeType="NodeType.RotationRxyz")
    return interface.AddObjectFFRFreducedOrderWithUserFunctions(
        exu, system, positionRef=start.A, initialVelocity=[0.0, speed, 0.0], UFforce=force
    )


def _fixed(item, system):
    """Return a marker that does not move."""
    return system.AddMarker(
        item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0)
    )


def _held(item, system, frame, drive):
    """Hold the piston's frame in the plane, on its two springs."""
    fixed = _fixed(item, system)
    free = [
        system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=frame, coordinate=k))
        for k in range(6)
    ]
    lateral, _, *out_of_plane, angle = free
    for marker in out_of_plane:
        system.AddObject(item.CoordinateConstraint(markerNumbers=[fixed, marker]))
    springs = ((lateral, drive.lateral_stiffness), (angle, drive.turning_stiffness))
    for marker, stiffness in springs:
        system.AddObject(
            item.CoordinateSpringDamper(markerNumbers=[fixed, marker], stiffness=stiffness)
        )


def _crank_and_rod(item, system, frame, mechanism, drive, start):
    """Add the crank, the rod and the three joints.

    The crank's angle is prescribed, so its inertia does not matter. The rod has its own inertia.
    """
    w = drive.crank_speed
    pin = start.pin
    length = mechanism.rod_length
    share = mechanism.rod_centre
    rod = start.A - pin
    pin_velocity = w * np.array([-pin[1], pin[0]])
    centre_velocity = (1 - share) * pin_velocity + share * np.array([0.0, start.lever * w])
    crank_node = system.AddNode(
        item.NodeRigidBody2D(
            referenceCoordinates=[0.0, 0.0, drive.crank_angle], initialVelocities=[0.0, 0.0, w]
        )
    )
    crank = system.AddObject(
        item.ObjectRigidBody2D(nodeNumber=crank_node, physicsMass=1.0, physicsInertia=1e-3)
    )
    centre_x, centre_y, _ = pin + share * rod
    rod_node = system.AddNode(
        item.NodeRigidBody2D(
            referenceCoordinates=[centre_x, centre_y, np.arctan2(-rod[0], rod[1])],
            initialVelocities=[*centre_velocity, start.turn],
        )
    )
    rod_body = system.AddObject(
        item.ObjectRigidBody2D(
            nodeNumber=rod_node,
            physicsMass=mechanism.rod_mass,
            physicsInertia=mechanism.rod_inertia,
        )
    )

    def at(body, y):
        return system.AddMarker(
            item.MarkerBodyPosition(bodyNumber=body, localPosition=[0.0, y, 0.0])
        )

    ground = system.AddObject(item.ObjectGround())
    for ends in (
        (at(ground, 0.0), at(crank, 0.0)),
        (at(crank, mechanism.crank_radius), at(rod_body, -share * length)),
        (
            at(rod_body, (1 - share) * length),
            system.AddMarker(item.MarkerNodePosition(nodeNumber=frame)),
        ),
    ):
        system.AddObject(item.SphericalJoint(markerNumbers=list(ends), constrainedAxes=[1, 1, 0]))
    turned = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=crank_node, coordinate=2))
    system.AddObject(
        item.CoordinateConstraint(
            markerNumbers=[_fixed(item, system), turned],
            offsetUserFunction=lambda system, t, number, offset: w * t,
            offsetUserFunction_t=lambda system, t, number, offset: w,
        )
    )


def _settings(exu, step, steps, spectral_radius):
    """Solver settings of Exudyn: fixed steps, tight Newton, positions kept at every step."""
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps = steps
    integration.endTime = step * steps
    integration.verboseMode = 0
    integration.generalizedAlpha.spectralRadius = spectral_radius
    integration.newton.relativeTolerance = 1e-10
    integration.newton.absoluteTolerance = 1e-10
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = step
    return settings
