"""Processes for the points of a sweep and the variants of a run.

If a process dies or exceeds its time limit, only its point fails.
"""

import os
import threading
import traceback
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import suppress
from functools import partial

from ..participants.worker import Worker
from .signals import follow_command

INTERMEDIATE = None
"""Value that replaces the flag of an exception in intermediate messages of a call."""


class PointDied(RuntimeError):
    """Process of a point that ended before its result."""


class LocalPool(ThreadPoolExecutor):
    """Executor whose threads call processes, which are replaced when they die.

    Parameters
    ----------
    workers : int, optional
        Number of processes. Default: number of processors.
    time_limit : float, optional
        Time limit of a call, after which its process is ended [s]. Default: none.
    """

    def __init__(self, workers=None, time_limit=None):
        super().__init__(max(1, os.cpu_count() or 1 if workers is None else workers))
        self.time_limit = time_limit
        self._own = threading.local()  # process of a thread
        self._processes: set = set()
        self._shared: list[Future] = []
        self._closed = threading.Event()

    def submit(self, fn, /, *args, **kwargs):
        """Return a `Future` of `fn(*args, **kwargs)`."""
        return super().submit(self._call, None, fn, args, kwargs)

    def share(self, listener, fn, calls):
        """Return completed `Future`s of `fn(send, argument)`, by label.

        This process makes the first call, because it has already imported what the call needs.

        Parameters
        ----------
        listener : callable(label, data)
            Called with the arguments of `send`, in any thread.
        fn : callable
            Function of a module of this package.
        calls : dict
            Label -> argument.
        """
        first, *others = calls
        here: Future = Future()
        submit = super().submit
        self._shared = [
            submit(self._call, partial(listener, label), fn, (calls[label],), {})
            for label in others
        ]
        here.set_result(fn(partial(listener, first), calls[first]))
        wait(self._shared)
        return dict(zip(calls, [here, *self._shared]))

    def send_signal(self, number):
        """Cancel shared calls that wait, and send a signal to all processes."""
        for future in self._shared:
            future.cancel()
        for process in list(self._processes):
            process.send_signal(number)

    def shutdown(self, wait=True, *, cancel_futures=False):
        """End the processes after the waiting calls, which may be cancelled."""
        if cancel_futures:
            self._closed.set()
            for process in list(self._processes):
                process.kill()
        super().shutdown(wait, cancel_futures=cancel_futures)
        if wait:
            for process in self._processes:
                process.pipe.close()
            for process in self._processes:
                process.join()
            self._processes.clear()

    def __exit__(self, kind, value, trace):
        self.shutdown(cancel_futures=kind is not None)

    def _start(self):
        process = Worker(_serve)
        self._processes.add(process)
        try:
            process.pipe.recv()  # the start of the process is not part of any call's time
        except (EOFError, OSError):
            self._end(process)
            raise PointDied("the process could not be started") from None
        return process

    def _call(self, listener, *work):
        """Run a call in the process of this thread."""
        process = getattr(self._own, "process", None)
        if process is None or not process.is_alive:
            process = self._own.process = self._start()
        if self._closed.is_set():  # `shutdown` may not know a process that has just started
            self._end(process)
            raise PointDied("the process was ended with the others")
        try:
            process.pipe.send((listener is not None, *work))
            if not process.pipe.poll(self.time_limit):
                self._end(process)
                raise PointDied(
                    f"time limit of {self.time_limit:g} s exceeded; the process was ended"
                )
            raised, answer = process.pipe.recv()
            while raised is INTERMEDIATE:
                listener(answer)
                raised, answer = process.pipe.recv()
        except (EOFError, OSError):
            self._end(process)
            raise PointDied(f"the process ended ({process.end})") from None
        if raised:
            raise answer
        return answer

    def _end(self, process):
        process.kill()
        process.join()
        self._processes.discard(process)


def _serve(pipe):
    """Answer calls until the pipe closes."""
    follow_command()
    pipe.send("up")
    while True:
        try:
            has_listener, function, arguments, named = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            listener = (partial(_send, pipe, threading.Lock()),) if has_listener else ()
            answer = False, function(*listener, *arguments, **named)
        except Exception as error:
            if has_listener:  # a bug: shared calls return faults
                traceback.print_exc()
            answer = True, RuntimeError(f"{type(error).__name__}: {error}")
        pipe.send(answer)


def _send(pipe, lock, data):
    with lock, suppress(OSError):  # the command may have ended
        pipe.send((INTERMEDIATE, data))
