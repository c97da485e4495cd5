"""FMU in a separate process: if it hangs or crashes, the run ends with a message.

Commands and values go through a pipe, as many as possible in one message. A response that exceeds
the timeout ends the FMU's process.
"""

import traceback
from contextlib import suppress
from itertools import count
from typing import Any

import numpy as np

from ..fmi.errors import BadInput, Discard, Finished, ParticipantFault
from .open import open_fmu
from .participant import StartedInHalves
from .worker import Worker

DESCRIBED = ("description", "declares_units", "has_clocks", "has_derivatives")
DESCRIBED += ("can_redo", "can_serialise", "can_interpolate")
"""Properties that the model description determines."""


def _in_process(method):
    """Return the method of a participant that its process runs."""

    def run(self, *arguments):
        return self._ask(method, *arguments)

    return run


class IsolatedParticipant(StartedInHalves):
    """Participant whose FMU runs in another process, with the same methods and results.

    Parameters
    ----------
    participant : FmuParticipant
        Not started. It provides the model description. The FMU is loaded in the other process.
    timeout : float
        Response timeout, after which the process is ended [s].

    Raises
    ------
    ParticipantFault
        By every method, after a timeout or if the process has ended.
    """

    runs_apart = True

    def __init__(self, participant, timeout):
        self.name, self.path = participant.name, participant.path
        self.fields: Any = participant.fields
        self.described = participant
        self.ended = ""
        self.timeout = timeout
        for name in DESCRIBED:
            setattr(self, name, getattr(participant, name))
        self._process: Any = None
        self._queue: list[tuple[str, tuple]] = []
        self._awaited: Any = None
        self._fresh: dict[str, Any] = {}  # values that were read since the last change
        self._numbers = count(1)

    def launch(self):
        """Start the process. Call it before `start`, because it takes time."""
        described = self.described
        length = getattr(described, "length", None)
        opening = described.elements, described.event_mode
        recipe = self.name, self.path, described.sizes, length, *opening
        self._process = Worker(_serve, recipe)
        self._pipe = self._process.pipe

    def another(self):
        """Return a second instance in a separate process, not started."""
        return type(self)(self.described, self.timeout)

    def enter(self, parameters, start_time, stop_time):
        """Run the first half of `start`; see `FmuParticipant.enter`."""
        self.started_with = parameters, start_time, stop_time
        if self._process is None:
            self.launch()
        self._ask("enter", parameters, start_time, stop_time)

    def leave(self):
        """Run the second half of `start`."""
        self._fresh = {}
        self._ask("leave")

    warned, get_many, serialise, derivative, next_tick, stop_at = map(
        _in_process, ("warned", "get_many", "serialise", "derivative", "next_tick", "stop_at")
    )

    def set(self, name, value):
        """Set a field (array of its shape), or a scalar of any type."""
        self._fresh = {}  # an output may follow its input immediately
        self._queue.append(("set", (name, _copied(value))))

    def set_course(self, name, course):
        self._fresh = {}  # an output may follow its input immediately
        self._queue.append(("set_course", (name, _copied(course))))

    def get(self, name):
        """Return the value of a field: array of its shape, or a Python scalar.

        Fields that were read once are transferred after every step.
        """
        if self.fields[name].type != "Real" or self.fields[name].clocked:
            return self._ask("get", name)
        if name not in self._fresh:
            self._fresh[name] = self._ask("read", name)
        return _copied(self._fresh[name])

    def tick(self, time, step):
        self._fresh = {}
        self._ask("tick", time, step)

    def step(self, time, step):
        """Take a step [s]; raise `Discard` or `ParticipantFault` as `FmuParticipant.step`."""
        self.begin_step(time, step)
        self.end_step()

    def begin_step(self, time, step):
        """Begin a step, so that other participants may step until `end_step`."""
        self._fresh = {}
        self._send("step", time, step)

    def end_step(self):
        """Wait for the end of the step; raise what `step` raises."""
        self.ended, self._fresh = self._receive()

    def save(self):
        """Return the number of the FMU's saved state; `free` it after use."""
        return self._numbered("save")

    def restore(self, saved):
        """Restore a saved state, where the next step begins."""
        self._fresh = {}
        self._queue.append(("restore", (saved,)))

    def free(self, saved):
        """Free a saved state."""
        self._queue.append(("free", (saved,)))

    def deserialise(self, data):
        """Return the number of the state in bytes of `serialise`."""
        return self._numbered("deserialise", data)

    def _numbered(self, method, *arguments):
        """Queue a command that creates a saved state; return the number of the state."""
        number = next(self._numbers)
        self._queue.append((method, (number, *arguments)))
        return number

    def close(self):
        """Terminate the FMU and its process."""
        if self._process is not None:
            try:
                self._ask("close")
            finally:
                self._pipe.close()
                self._process.join(self.timeout)
                self._process.kill()
                self._process = None

    def _ask(self, method, *arguments):
        """Send all queued commands and this one; return its result, or raise its exception."""
        self._send(method, *arguments)
        return self._receive()

    def _send(self, method, *arguments):
        """Send all queued commands and this one."""
        if self._awaited:  # the result of an abandoned step
            with suppress(Discard, ParticipantFault):
                self._receive()
        queue, self._queue = [*self._queue, (method, arguments)], []
        self._awaited = method, arguments
        try:
            self._pipe.send(queue)
        except OSError:
            raise self._ended() from None

    def _receive(self):
        """Return the result of the last command, or raise its exception."""
        try:
            if not self._pipe.poll(self.timeout):
                self._process.kill()
                raise ParticipantFault(
                    f"{self.name}: no answer to {self._awaited[0]} within {self.timeout:g} s; "
                    "its process has been ended"
                )
            raised, answer = self._pipe.recv()
        except (EOFError, OSError):
            raise self._ended() from None
        finally:
            self._awaited = None
        if raised:
            raise answer
        return answer

    def _ended(self):
        """Return the fault of a process that has ended."""
        method, arguments = self._awaited
        self._awaited = None
        self._process.join(self.timeout)
        return ParticipantFault(
            f"{self.name}: its process has ended ({self._process.end}) before or in "
            f"{method}{arguments if method == 'step' else ''}"
        )


def _copied(value):
    return value.copy() if isinstance(value, np.ndarray) else value


class Server:
    """Other end of the pipe: runs commands on the real participant."""

    def __init__(self, participant):
        self.participant, self.saved, self.read_ahead = participant, {}, set()

    def run(self, method, arguments):
        return (getattr(self, method, None) or getattr(self.participant, method))(*arguments)

    def read(self, name):
        self.read_ahead.add(name)
        return self.participant.get(name)

    def step(self, time, step):
        self.participant.step(time, step)
        return self.participant.ended, {n: self.participant.get(n) for n in self.read_ahead}

    def save(self, number):
        self.saved[number] = self.participant.save()

    def restore(self, number):
        self.participant.restore(self.saved[number])

    def free(self, number):
        self.participant.free(self.saved.pop(number))

    def serialise(self, number):
        return self.participant.serialise(self.saved[number])

    def deserialise(self, number, data):
        self.saved[number] = self.participant.deserialise(data)


def _serve(pipe, recipe):
    """Run commands until `close`, or until the master has ended."""
    server = Server(open_fmu(*recipe))
    with suppress(EOFError, OSError):  # a master that was killed closes or resets the pipe
        while True:
            queue = pipe.recv()
            pipe.send(answered(server, queue))
            if queue[-1][0] == "close":
                return


def answered(server, queue):
    """Run commands; return whether one raised, and the last result or the exception."""
    answer = False, None
    try:
        for command in queue:
            answer = False, server.run(*command)
    except (Discard, BadInput, Finished, ParticipantFault) as error:
        answer = True, error
    except Exception:
        name = server.participant.name
        answer = True, ParticipantFault(f"{name}: {traceback.format_exc()}")
    return answer
