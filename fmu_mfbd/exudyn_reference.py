"""The flexible piston on its crank in Exudyn: an independent multibody code, the same mesh, modes, mechanism and forces.

The piston's frame A rides on a rigid rod whose other end goes round with the crank at constant speed. Springs hold A laterally
and against turning, where the oil film would; a gas force that comes and goes presses on the crown. No gravity, no damping.
"""

from typing import NamedTuple

import numpy as np

from .generalised_alpha import coefficients, predict
from .piston_motion import Load, settle
from .slider_crank import height, rod_turn


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
        x_A [m], rocking angle [rad], modal coordinates [kg^1/2 m]; it starts at rest and undeformed.
    """
    n = 2 + len(gas_shape)
    place, rate, a = np.zeros((3, n))
    history = [place]
    place, rate, a = _balanced(body, mechanism, gas_shape, drive, 0.0, coefficients(0.0, spectral_radius), place, rate, a)
    c, auxiliary = coefficients(step, spectral_radius), a
    for k in range(1, steps + 1):
        p, r, auxiliary = predict(c, place, rate, a, auxiliary)
        place, rate, a = _balanced(body, mechanism, gas_shape, drive, k * step, c, p, r, a)
        auxiliary = auxiliary + c.weight * a
        history.append(place)
    return np.array(history)


def _balanced(body, mechanism, gas_shape, drive, time, c, place, rate, a):
    """End of a step: the springs' forces and the place they belong to, found in turns (the spring adds 1e-3 to the inertia)."""
    F, angle = drive.gas(time), drive.crank_angle + drive.crank_speed * time
    for _ in range(6):
        end = place + c.place * a
        load = Load(-drive.lateral_stiffness * end[0], -F, -drive.turning_stiffness * end[1], F * gas_shape)
        a = settle(body, mechanism, load, place, rate, a, angle, drive.crank_speed, 0.0, c.rate, c.place)[0]
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
    from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface

    fem = FEMinterface()
    fem.nodes, fem.massMatrix, fem.stiffnessMatrix = {"Position": points}, M.tocsr(), K.tocsr()
    fem.modeBasis, fem.surface = {"matrix": modes, "type": "NormalModes"}, [{"Name": "none", "Trigs": np.zeros((0, 3), int)}]
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    phi, w = drive.crank_angle, drive.crank_speed
    Y, _, lever = height(mechanism, 0.0, phi)
    turn = rod_turn(mechanism, 0.0, 0.0, phi, w)[0]
    r = mechanism.crank_radius
    crank_pin, A = np.array([-r * np.sin(phi), r * np.cos(phi), 0.0]), np.array([mechanism.offset, Y, 0.0])

    def force(mbs, time, number, q, rate):
        F = drive.gas(time)
        return [0.0, -F, 0.0, 0.0, 0.0, 0.0, *(F * gas_shape)]

    interface = ObjectFFRFreducedOrderInterface(fem, rigidBodyNodeType="NodeType.RotationRxyz")
    piston = interface.AddObjectFFRFreducedOrderWithUserFunctions(exu, mbs, positionRef=A, initialVelocity=[0.0, lever * w, 0.0],
                                                                  UFforce=force)
    frame = piston["nRigidBody"]
    ground = mbs.AddNode(item.NodePointGround())
    fixed = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    free = [mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=frame, coordinate=k)) for k in range(6)]
    for k in (2, 3, 4):                                         # planar motion
        mbs.AddObject(item.CoordinateConstraint(markerNumbers=[fixed, free[k]]))
    for k, stiffness in ((0, drive.lateral_stiffness), (5, drive.turning_stiffness)):
        mbs.AddObject(item.CoordinateSpringDamper(markerNumbers=[fixed, free[k]], stiffness=stiffness))
    # crank without mass in the plane, its angle prescribed; rod with its own
    centre = crank_pin + mechanism.rod_centre * (A - crank_pin)
    tilt = np.arctan2(-(A - crank_pin)[0], (A - crank_pin)[1])
    length, k = mechanism.rod_length, mechanism.rod_centre
    pin_speed = w * np.array([-r * np.cos(phi), -r * np.sin(phi)])
    centre_speed = (1 - k) * pin_speed + k * np.array([0.0, lever * w])
    bodies = {}
    for name, place, angle, speed, spin, mass, inertia in (
            ("crank", np.zeros(3), phi, np.zeros(2), w, 1.0, 1e-3),
            ("rod", centre, tilt, centre_speed, turn, mechanism.rod_mass, mechanism.rod_inertia)):
        node = mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=[*place[:2], angle], initialVelocities=[*speed, spin]))
        bodies[name] = node, mbs.AddObject(item.ObjectRigidBody2D(nodeNumber=node, physicsMass=mass, physicsInertia=inertia))
    earth = mbs.AddObject(item.ObjectGround())

    def joint(first, at_first, second, at_second):
        markers = [mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=at))
                   for body, at in ((first, at_first), (second, at_second))]
        mbs.AddObject(item.SphericalJoint(markerNumbers=markers, constrainedAxes=[1, 1, 0]))

    joint(earth, [0.0, 0.0, 0.0], bodies["crank"][1], [0.0, 0.0, 0.0])
    joint(bodies["crank"][1], [0.0, r, 0.0], bodies["rod"][1], [0.0, -k * length, 0.0])
    eye = mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=bodies["rod"][1], localPosition=[0.0, (1 - k) * length, 0.0]))
    pin = mbs.AddMarker(item.MarkerNodePosition(nodeNumber=frame))
    mbs.AddObject(item.SphericalJoint(markerNumbers=[eye, pin], constrainedAxes=[1, 1, 0]))
    turned = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=bodies["crank"][0], coordinate=2))
    mbs.AddObject(item.CoordinateConstraint(markerNumbers=[fixed, turned],
                                            offsetUserFunction=lambda mbs, t, number, offset: w * t,
                                            offsetUserFunction_t=lambda mbs, t, number, offset: w))
    what = exu.OutputVariableType.Coordinates
    kept = [mbs.AddSensor(item.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=what))
            for node in (frame, piston["nGenericODE2"])]
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, step * steps
    settings.timeIntegration.generalizedAlpha.spectralRadius = spectral_radius
    settings.timeIntegration.newton.relativeTolerance = settings.timeIntegration.newton.absoluteTolerance = 1e-10
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = step
    settings.timeIntegration.verboseMode = 0
    mbs.SolveDynamic(settings)
    frame_history, modal_history = (mbs.GetSensorStoredData(sensor) for sensor in kept)
    return np.column_stack([frame_history[:, 1], frame_history[:, 6], modal_history[:, 1:]])
