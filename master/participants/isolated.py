"""An FMU in a process of its own: it may hang or crash, and the run ends with a sentence instead of
with it.

Fields lie in memory that both processes share; commands go through a pipe, as many as possible in
one message; an answer that does not come in time ends the FMU's process.
"""

import traceback
from contextlib import suppress
from itertools import count
from typing import Any

from ..fmi.errors import BadInput, Discard, Finished, ParticipantFault
from .open import open_fmu
from .worker import Worker, shared_file, shared_numbers


class IsolatedParticipant:
    """A participant whose FMU runs in another process; same methods and same bits as the
    participant it stands for.

    Parameters
    ----------
    participant : FmuParticipant
        Not started; what the model description says is read from it, the FMU itself is loaded in
        the other process.
    timeout : float
        Longest wait for any one answer [s]; the process is ended then.

    Raises
    ------
    ParticipantFault
        By every method, after a time-out or when the process has ended by itself.
    """

    runs_apart = True

    def __init__(self, participant, timeout):
        self.description = participant.description
        self.described = participant
        self.ended = ""
        self.timeout = timeout
        self.name = participant.name
        self.fields = participant.fields
        self.path = participant.path
        self.has_derivatives = participant.has_derivatives
        self.can_redo = participant.can_redo
        self.can_serialise = participant.can_serialise
        self.can_interpolate = participant.can_interpolate
        self.declares_units = participant.declares_units
        self.has_clocks = participant.has_clocks
        self._process: Any = None
        self._queue: list[tuple[str, tuple]] = []
        self._awaited: Any = None
        self._fresh: set[str] = set()
        self._read_ahead: set[str] = set()
        self._numbers = count(1)

    def launch(self):
        """Start the process, which takes its time; to be called before `start`."""
        memory = shared_file(2 * sum(field.size for field in self.fields.values()))
        described = self.described
        length = getattr(described, "length", None)
        how = described.elements, described.event_mode
        recipe = self.name, self.path, described.sizes, length, *how
        self._process = Worker(_serve, memory, recipe, files=[memory])
        self._pipe = self._process.pipe
        self._values, self._changes = _views(shared_numbers(memory), self.fields)

    def start(self, parameters, start_time, stop_time):
        """Instantiate and initialise in the process; see `FmuParticipant.start`."""
        self.enter(parameters, start_time, stop_time)
        self.leave()

    def another(self):
        """Return a second instance in a process of its own, not started."""
        return type(self)(self.described, self.timeout)

    def enter(self, parameters, start_time, stop_time):
        """First half of `start`; see `FmuParticipant.enter`."""
        self.started_with = parameters, start_time, stop_time
        if self._process is None:
            self.launch()
        self._ask("enter", parameters, start_time, stop_time)

    def leave(self):
        """Second half of `start`."""
        self._fresh = set()
        self._ask("leave")

    def warned(self):
        """See `FmuParticipant.warned`."""
        return self._ask("warned")

    def set(self, name, value):
        """Set a field (array of its shape), or a scalar of any type."""
        self._fresh = set()  # an output may follow its input at once
        if self.fields[name].type == "Real" and not self.fields[name].clocked:
            self._values[name][...] = value
            self._queue.append(("write", (name,)))
        else:
            self._queue.append(("set", (name, value)))

    def set_course(self, name, course):
        """Set an input and its time derivatives at the beginning of the next step; see
        `FmuParticipant.set_course`.
        """
        self._fresh = set()  # an output may follow its input at once
        self._queue.append(("set_course", (name, course)))

    def get(self, name):
        """Value of a field: array of its shape, or a Python scalar. What was read once comes along
        with every step.
        """
        if self.fields[name].type != "Real" or self.fields[name].clocked:
            return self._ask("get", name)
        if name not in self._fresh:
            self._ask("read", name)
            self._read_ahead.add(name)
            self._fresh.add(name)
        value = self._values[name]
        return value.copy() if value.shape else value.item()

    def get_many(self, names):
        """Values of several scalars: dict of name to float or int."""
        return self._ask("get_many", list(names))

    def stop_at(self, clocks):
        """See `ClockedFmu3.stop_at`."""
        self._ask("stop_at", clocks)

    def tick(self, time, step):
        """See `ClockedFmu3.tick`."""
        self._fresh = set()
        self._ask("tick", time, step)

    def next_tick(self):
        """See `ClockedFmu3.next_tick`."""
        return self._ask("next_tick")

    def step(self, time, step):
        """One step [s]; raises Discard or ParticipantFault as `FmuParticipant.step` does."""
        self.begin_step(time, step)
        self.end_step()

    def begin_step(self, time, step):
        """Send the step away; other participants may step until `end_step`."""
        self._fresh = set()
        self._send("step", time, step)

    def end_step(self):
        """Wait for the end of the step that was begun; raises what `step` raises."""
        self.ended = self._receive()
        self._fresh = set(self._read_ahead)

    def save(self):
        """A number for the FMU's state; `free` it when it is no longer needed."""
        return self._numbered("save")

    def restore(self, saved):
        """Go back to a saved state; the next step counts from it."""
        self._fresh = set()
        self._queue.append(("restore", (saved,)))

    def free(self, saved):
        """Forget a saved state; nothing to do where the process is gone."""
        self._queue.append(("free", (saved,)))

    def serialise(self, saved):
        """The saved state as bytes."""
        return self._ask("serialise", saved)

    def deserialise(self, data):
        """A number for the state that `serialise` made into bytes."""
        return self._numbered("deserialise", data)

    def _numbered(self, method, *arguments):
        """Queue what makes a saved state; the number by which it is kept there."""
        number = next(self._numbers)
        self._queue.append((method, (number, *arguments)))
        return number

    def derivative(self, seeds, products):
        """Directional derivative of the last step; see `FmuParticipant.derivative`."""
        for name, value in seeds.items():
            self._changes[name][...] = value
        answered = self._ask("derivative", list(seeds), list(products))
        return {name: self._changes[name].copy() for name in answered}

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
        """Send everything queued with this command behind it; its answer, or what it raised in the
        other process.
        """
        self._send(method, *arguments)
        return self._receive()

    def _send(self, method, *arguments):
        """Send everything queued with this command behind it."""
        if self._awaited:  # the answer to a step that nobody waited for: the run was broken off
            with suppress(Discard, ParticipantFault):
                self._receive()
        queue, self._queue = [*self._queue, (method, arguments)], []
        self._awaited = method, arguments
        self._post(queue)

    def _post(self, queue):
        """Send commands to the other process."""
        try:
            self._pipe.send(queue)
        except OSError:
            raise self._ended() from None

    def _receive(self):
        """Answer to the command that was sent last, or what it raised in the other process."""
        try:
            raised, answer = self._fetch()
        finally:
            self._awaited = None
        if raised:
            raise answer
        return answer

    def _fetch(self):
        """Whether the other process raised something, and its answer or what it raised."""
        try:
            if not self._pipe.poll(self.timeout):
                self._process.kill()
                raise ParticipantFault(
                    f"{self.name}: no answer to {self._awaited[0]} within {self.timeout:g} s; "
                    "its process has been ended"
                )
            return self._pipe.recv()
        except (EOFError, OSError):
            raise self._ended() from None

    def _ended(self):
        """Fault of a process that is gone."""
        method, arguments = self._awaited
        self._awaited = None
        self._process.join(self.timeout)
        return ParticipantFault(
            f"{self.name}: its process has ended ({self._process.end}) before or in "
            f"{method}{arguments if method == 'step' else ''}"
        )


def _views(storage, fields):
    """Two arrays a field in the shared memory: its value, and the change a derivative is asked for
    or answers.
    """
    offset, values, changes = 0, {}, {}
    for name, field in fields.items():
        for views in (values, changes):
            views[name] = storage[offset : offset + field.size].reshape(field.shape)
            offset += field.size
    return values, changes


class Server:
    """The other end: runs commands on the real participant."""

    def __init__(self, participant, memory):
        self.participant, self.saved, self.read_ahead = participant, {}, set()
        self.values, self.changes = _views(memory, participant.fields)

    def run(self, method, arguments):
        return (getattr(self, method, None) or getattr(self.participant, method))(*arguments)

    def write(self, name):
        self.participant.set(name, self.values[name])

    def read(self, name):
        self.values[name][...] = self.participant.get(name)
        self.read_ahead.add(name)

    def step(self, time, step):
        self.participant.step(time, step)
        for name in self.read_ahead:
            self.values[name][...] = self.participant.get(name)
        return self.participant.ended

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

    def derivative(self, seeds, products):
        changes = {name: self.changes[name] for name in seeds}
        derivatives = self.participant.derivative(changes, products)
        for name, value in derivatives.items():
            self.changes[name][...] = value
        return list(derivatives)


def _serve(pipe, memory, recipe):
    """Answer commands until the master is gone or `close` is done."""
    server = Server(open_fmu(*recipe), shared_numbers(memory))
    with suppress(EOFError, OSError):  # a master that was killed closes or resets the pipe
        while True:
            queue = pipe.recv()
            pipe.send(answered(server, queue))
            if queue[-1][0] == "close":
                return


def answered(server, queue):
    """Run commands; whether one raised, and the answer of the last or what was raised."""
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
