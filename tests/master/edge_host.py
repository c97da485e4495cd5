"""A host that knows FMPy alone: calls of an FMU, their statuses, and what the FMU logs.

python edge_host.py FMU CALLS [RESOURCES]

CALLS is a JSON list of lists of calls, each of which gets an instance of its own. Prints a JSON
list of (statuses, log of the last call). RESOURCES replaces the folder of the FMU's resources.
"""

import ctypes
import json
import shutil
import sys

from fmpy import extract, fmi2, fmi3, read_model_description
from fmpy.fmi1 import FMICallException

folder = extract(sys.argv[1])
description = read_model_description(folder)
second = description.fmiVersion == "2.0"
variables = {v.name.partition("[")[0]: v for v in reversed(description.modelVariables)}
log = []


def made():
    """Return an instance of the FMU; its status is 3 if there is none."""
    log.clear()
    one = (fmi2.FMU2Slave if second else fmi3.FMU3Slave)(
        guid=description.guid or description.instantiationToken,
        unzipDirectory=folder,
        instanceName="edge",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    one.unzipDirectory = (*sys.argv, folder)[3]
    if second:
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = ctypes.cast(logger, fmi2.fmi2CallbackLoggerTYPE)
        one.instantiate(callbacks=callbacks, loggingOn=True)
        return one, callbacks
    one.instantiate(logMessage=logger)
    return one, logger


def set_value(one, name):
    v = variables[name]
    count = 1 if second else {"u": 6, "x": 6}.get(name, 1)
    kind = {"Enumeration": "Integer" if second else "Int64"}.get(v.type, v.type)
    getattr(one, f"set{kind}")([v.valueReference], [1] * count)


def enter(one, start, stop):
    if second:
        one.setupExperiment(startTime=start, stopTime=stop)
        one.enterInitializationMode()
    else:
        one.enterInitializationMode(startTime=start, stopTime=stop)


def debug(one, category):
    names = (ctypes.c_char_p * 1)(category.encode())
    (one.fmi2SetDebugLogging if second else one.fmi3SetDebugLogging)(one.component, 1, 1, names)


def save(one):
    saved[:] = [one.getFMUstate() if second else one.getFMUState()]


def restore(one):
    (one.setFMUstate if second else one.setFMUState)(*saved)


def null(one):
    (one.setFMUstate if second else one.setFMUState)(ctypes.c_void_p())


saved = []
DO = {
    "enter": enter,
    "leave": lambda one: one.exitInitializationMode(),
    "step": lambda one, time, step: one.doStep(time, step),
    "end": lambda one: one.terminate(),
    "reset": lambda one: one.reset(),
    "set": set_value,
    "derive": lambda one: one.getDirectionalDerivative(
        [variables["total"].valueReference], [variables["gain"].valueReference], [1.0]
    ),
    "save": save,
    "restore": restore,
    "null": null,
    "log": debug,
}
logger = (
    fmi2.fmi2CallbackLoggerTYPE(lambda _e, _i, _s, _c, text: log.append(text.decode()))
    if second
    else fmi3.fmi3LogMessageCallback(lambda _e, _s, _c, text: log.append(text.decode()))
)


def answers(calls):
    """Return the statuses of calls and the log of the last one."""
    statuses = []
    try:
        one, _kept = made()
    except Exception:
        return [3], list(log)
    for name, *arguments in calls:
        log.clear()
        try:
            DO[name](one, *arguments)
            statuses.append(0)
        except FMICallException as failure:
            statuses.append(failure.status)
    one.freeInstance()
    return statuses, list(log)


assert not any(name.startswith("piston_cosim") for name in sys.modules)
print(json.dumps([answers(calls) for calls in json.loads(sys.argv[2])]))
shutil.rmtree(folder)
