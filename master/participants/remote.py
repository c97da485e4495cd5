"""FMU on a worker of an existing Dask cluster, used like an isolated one.

Commands and values go to a Dask actor, as many as possible in one message. Dask's configuration
names the certificates for TLS on both sides (distributed.comm.tls). The FMU is sent along.
Workers need this package and dask[distributed].
"""

import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from ..fmi.errors import BadInput, ParticipantFault
from .isolated import IsolatedParticipant, Server, answered
from .open import open_fmu

CONNECTED = 20.0
"""Connection timeout of the scheduler [s]."""
BUSY: Counter[str] = Counter()
"""Participants of this process by worker. An actor occupies a thread there, so the next one goes
to the worker with the fewest."""


class RemoteParticipant(IsolatedParticipant):
    """Participant whose FMU runs on a worker of a Dask cluster, with the same results.

    Parameters
    ----------
    participant : FmuParticipant
        Not started.
    timeout : float
        Response timeout [s].
    host : str
        Scheduler of the cluster, tls://NAME:PORT.

    Raises
    ------
    BadInput
        By `launch`, if dask is not installed, if no scheduler with a trusted certificate responds,
        or if there is no worker.
    ParticipantFault
        By every method, after a timeout or if the worker has ended.
    """

    def __init__(self, participant, timeout, host):
        super().__init__(participant, timeout)
        self.host = host
        self._worker = ""
        self._actor: Any = None
        self._kept: Any = None

    def another(self):
        """Return a second instance on the cluster, not started."""
        return RemoteParticipant(self.described, self.timeout, self.host)

    def launch(self):
        """Send the FMU to the worker with the fewest participants."""
        try:
            from dask.distributed import Client
        except ImportError:
            raise BadInput(
                f"participants.{self.name}.host: expected dask installed, got nothing; "
                "run pip install 'dask[distributed]'"
            ) from None
        try:
            self._process = Client(self.host, timeout=CONNECTED, set_as_default=False)
            workers = sorted(self._process.ncores())
        except (OSError, TypeError, ValueError, RuntimeError):
            raise BadInput(
                f"participants.{self.name}.host: expected a scheduler that answers, got "
                f"{self.host!r}"
            ) from None
        if not workers:
            self._process.close()
            raise BadInput(
                f"participants.{self.name}.host: expected a worker at {self.host!r}, got none"
            )
        self._worker = min(workers, key=lambda worker: BUSY[worker])
        BUSY[self._worker] += 1
        self._values = {}
        described = self.described
        how = described.elements, described.event_mode
        recipe = described.sizes, getattr(described, "length", None), *how
        data = Path(self.path).read_bytes()
        made = (RemoteFmu, self.name, Path(self.path).name, data, recipe)
        place = {"workers": [self._worker], "actor": True, "pure": False}
        self._kept = self._process.submit(*made, **place)  # the actor lives as long as its future
        self._actor = self._result(self._kept)

    def set(self, name, value):
        """Set a field (array of its shape), or a scalar of any type."""
        self._fresh = set()  # an output may follow its input immediately
        kept = value.copy() if isinstance(value, np.ndarray) else value
        self._queue.append(("set", (name, kept)))

    def derivative(self, seeds, products):
        return self._ask("derivative", dict(seeds), list(products))

    def close(self):
        """Terminate the FMU, and release the worker."""
        if self._process is None:
            return
        try:
            self._ask("close")
        finally:
            client, self._process, self._actor, self._kept = self._process, None, None, None
            BUSY[self._worker] -= 1
            client.close(timeout=self.timeout)

    def _post(self, queue):
        with self._process.as_current():  # the actor needs a current client
            self._coming = self._actor.run(queue)

    def _fetch(self):
        raised, answer, fields_read = self._result(self._coming)
        self._values |= {name: np.asarray(value) for name, value in fields_read.items()}
        return raised, answer

    def _result(self, future: Any):
        """Return the result of a future; raise `ParticipantFault` if it fails."""
        try:
            return future.result(timeout=self.timeout)
        except TimeoutError:
            words = f"no answer within {self.timeout:g} s"
        except Exception as error:  # Dask's own errors, or errors of the connection
            words = f"{type(error).__name__}: {error}"
        awaited = self._awaited[0] if self._awaited else "launch"
        raise ParticipantFault(f"{self.name}: on {self._worker}, {awaited}: {words}")


class RemoteFmu:
    """Actor on a worker."""

    def __init__(self, name, file, data, recipe):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / file
            path.write_bytes(data)
            self.server = FarServer(open_fmu(name, path, *recipe))

    def run(self, queue):
        """Run commands; return whether one raised, the last result or exception, and fields."""
        self.server.fields_read = {}
        return (*answered(self.server, queue), self.server.fields_read)


class FarServer(Server):
    """Server that shares no memory with the master."""

    def __init__(self, participant):
        self.participant, self.saved, self.read_ahead = participant, {}, set()
        self.fields_read: dict[str, Any] = {}

    def read(self, name):
        self.fields_read[name] = self.participant.get(name)
        self.read_ahead.add(name)

    def step(self, time, step):
        self.participant.step(time, step)
        self.fields_read |= {name: self.participant.get(name) for name in self.read_ahead}
        return self.participant.ended

    def derivative(self, seeds, products):
        return self.participant.derivative(seeds, products)
