"""The flexible piston on its crank in Exudyn: an independent multibody code, the same mesh, modes,
mechanism and forces.

The piston's frame A rides on a rigid rod whose other end goes round with the crank at constant
speed. Springs hold A laterally and against turning, where the oil film would; a gas force that
comes and goes presses on the crown. No gravity, no damping.
"""

from typing import NamedTuple

import numpy as np

from .dynamics.generalised_alpha import coefficients, predict
from .dynamics.piston_motion import Load, settle
from .dynamics.slider_crank import height, rod_turn


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

    def gas(self, time):
        """F(t) [N]."""
        return self.gas_force * np.sin(np.pi * time / self.duration) ** 2


def own_motion(body, mechanism, gas_shape, drive, step, steps, spectral_radius):
    """Piston motion by this package.

    Parameters
    ----------
    body : FlexibleBody
    mechanism : Mechanism
    gas_shape : ndarray, shape (k,)
        Modal force of a unit gas force [kg^-1/2].
    drive : Drive
    step, steps : float, int
        [s]
    spectral_radius : float

    Returns
    -------
    ndarray, shape (steps + 1, 2 + k)
        x_A [m], rocking angle [rad], modal coordinates [kg^1/2 m]; it starts at rest and
        undeformed.
    """
    n = 2 + len(gas_shape)
    place, rate, a = np.zeros((3, n))
    history = [place]
    place, rate, a = _balanced(
        body, mechanism, gas_shape, drive, 0.0, coefficients(0.0, spectral_radius), place, rate, a
    )
    c, auxiliary = coefficients(step, spectral_radius), a
    for k in range(1, steps + 1):
        p, r, auxiliary = predict(c, place, rate, a, auxiliary)
        place, rate, a = _balanced(body, mechanism, gas_shape, drive, k * step, c, p, r, a)
        auxiliary = auxiliary + c.weight * a
        history.append(place)
    return np.array(history)


def _balanced(body, mechanism, gas_shape, drive, time, c, place, rate, a):
    """End of a step: the springs' forces and the place they belong to, found in turns (the spring
    adds 1e-3 to the inertia).
    """
    F, angle = drive.gas(time), drive.crank_angle + drive.crank_speed * time
    for _ in range(6):
        end = place + c.place * a
        load = Load(
            -drive.lateral_stiffness * end[0], -F, -drive.turning_stiffness * end[1], F * gas_shape
        )
        a = settle(
            body, mechanism, load, place, rate, a, angle, drive.crank_speed, 0.0, c.rate, c.place
        )[0]
    return place + c.place * a, rate + c.rate * a, a


def exudyn_motion(points, K, M, modes, mechanism, gas_shape, drive, step, steps, spectral_radius):
    """The same by Exudyn (ObjectFFRFreducedOrder, joints as constraints, generalised-alpha).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Nodes from A [m].
    K, M : scipy.sparse matrix, shape (3 n, 3 n)
        Full matrices [N/m], [kg].
    modes : ndarray, shape (3 n, k)
        [kg^-1/2]
    mechanism, gas_shape, drive, step, steps, spectral_radius
        As for `own_motion`.

    Returns
    -------
    ndarray, shape (steps + 1, 2 + k)
    """
    import exudyn as exu
    import exudyn.itemInterface as item

    system = exu.SystemContainer().AddSystem()
    lever, turn, pin, A = _start(mechanism, drive)
    piston = _exudyn_piston(
        exu, system, (points, K, M, modes), A, lever * drive.crank_speed, gas_shape, drive
    )
    _held(item, system, piston["nRigidBody"], drive)
    _crank_and_rod(item, system, piston["nRigidBody"], mechanism, drive, (lever, turn, pin, A))
    sensors = [
        system.AddSensor(
            item.SensorNode(
                nodeNumber=node,
                storeInternal=True,
                outputVariableType=exu.OutputVariableType.Coordinates,
            )
        )
        for node in (piston["nRigidBody"], piston["nGenericODE2"])
    ]
    system.Assemble()
    system.SolveDynamic(_settings(exu, step, steps, spectral_radius))
    frame, modal = (system.GetSensorStoredData(sensor) for sensor in sensors)
    return np.column_stack([frame[:, 1], frame[:, 6], modal[:, 1:]])


def _start(mechanism, drive):
    """dY/d(crank angle) [m], the rod's turning speed [rad/s], and where crank pin and A are at the
    start [m].
    """
    phi, r = drive.crank_angle, mechanism.crank_radius
    Y, _, lever = height(mechanism, 0.0, phi)
    turn = rod_turn(mechanism, 0.0, 0.0, phi, drive.crank_speed)[0]
    return (
        lever,
        turn,
        np.array([-r * np.sin(phi), r * np.cos(phi), 0.0]),
        np.array([mechanism.offset, Y, 0.0]),
    )


def _exudyn_piston(exu, system, mesh, A, speed, gas_shape, drive):
    """The flexible piston with its gas force, moving along y with `speed` [m/s]; Exudyn's
    dictionary of what it made.
    """
    from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface

    points, K, M, modes = mesh
    fem = FEMinterface()
    fem.nodes, fem.massMatrix, fem.stiffnessMatrix = {"Position": points}, M.tocsr(), K.tocsr()
    fem.modeBasis, fem.surface = (
        {"matrix": modes, "type": "NormalModes"},
        [{"Name": "none", "Trigs": np.zeros((0, 3), int)}],
    )

    def force(system, time, number, q, rate):
        F = drive.gas(time)
        return [0.0, -F, 0.0, 0.0, 0.0, 0.0, *(F * gas_shape)]

    interface = ObjectFFRFreducedOrderInterface(fem, rigidBodyNodeType="NodeType.RotationRxyz")
    return interface.AddObjectFFRFreducedOrderWithUserFunctions(
        exu, system, positionRef=A, initialVelocity=[0.0, speed, 0.0], UFforce=force
    )


def _fixed(item, system):
    """A marker that does not move."""
    return system.AddMarker(
        item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0)
    )


def _held(item, system, frame, drive):
    """The piston's frame in the plane, on its two springs."""
    fixed = _fixed(item, system)
    free = [
        system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=frame, coordinate=k))
        for k in range(6)
    ]
    for k in (2, 3, 4):
        system.AddObject(item.CoordinateConstraint(markerNumbers=[fixed, free[k]]))
    for k, stiffness in ((0, drive.lateral_stiffness), (5, drive.turning_stiffness)):
        system.AddObject(
            item.CoordinateSpringDamper(markerNumbers=[fixed, free[k]], stiffness=stiffness)
        )


def _crank_and_rod(item, system, frame, mechanism, drive, start):
    """Crank with its angle prescribed (its inertia does not matter), rod with its own, and the
    three joints.
    """
    (lever, turn, pin, A), w, r = start, drive.crank_speed, mechanism.crank_radius
    length, share, rod = mechanism.rod_length, mechanism.rod_centre, A - pin
    pin_speed = w * np.array([-pin[1], pin[0]])
    centre_speed = (1 - share) * pin_speed + share * np.array([0.0, lever * w])
    crank_node, crank = _body(
        item, system, np.zeros(3), drive.crank_angle, np.zeros(2), w, 1.0, 1e-3
    )
    _, rod_body = _body(
        item,
        system,
        pin + share * rod,
        np.arctan2(-rod[0], rod[1]),
        centre_speed,
        turn,
        mechanism.rod_mass,
        mechanism.rod_inertia,
    )

    def at(body, y):
        return system.AddMarker(
            item.MarkerBodyPosition(bodyNumber=body, localPosition=[0.0, y, 0.0])
        )

    ground = system.AddObject(item.ObjectGround())
    for ends in (
        (at(ground, 0.0), at(crank, 0.0)),
        (at(crank, r), at(rod_body, -share * length)),
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


def _body(item, system, place, angle, speed, spin, mass, inertia):
    """A rigid body in the plane: its node and object."""
    node = system.AddNode(
        item.NodeRigidBody2D(
            referenceCoordinates=[*place[:2], angle], initialVelocities=[*speed, spin]
        )
    )
    return node, system.AddObject(
        item.ObjectRigidBody2D(nodeNumber=node, physicsMass=mass, physicsInertia=inertia)
    )


def _settings(exu, step, steps, spectral_radius):
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps, integration.endTime, integration.verboseMode = steps, step * steps, 0
    integration.generalizedAlpha.spectralRadius = spectral_radius
    integration.newton.relativeTolerance = integration.newton.absoluteTolerance = 1e-10
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = step
    return settings
