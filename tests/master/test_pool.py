"""Processes for the points of a sweep: one that dies, hangs or raises fails its own call alone."""

import os
import signal
import threading
import time

import pytest

from piston_cosim.master.runs.pool import LocalPool, PointDied


def test_a_process_that_dies_takes_its_own_call_with_it():
    with LocalPool(1) as pool:
        first = pool.submit(os.getpid)
        killed = pool.submit(signal.raise_signal, signal.SIGKILL)
        left = pool.submit(os._exit, 7)
        raising = pool.submit(int, "x")
        last = [pool.submit(pow, 2, k) for k in range(5)]
        assert first.result(60) != os.getpid()
        with pytest.raises(PointDied, match="by SIGKILL"):
            killed.result(60)
        with pytest.raises(PointDied, match="exit code 7"):
            left.result(60)
        with pytest.raises(RuntimeError, match="ValueError: invalid literal"):
            raising.result(60)
        assert [future.result(60) for future in last] == [1, 2, 4, 8, 16]


def test_a_call_longer_than_the_limit_is_ended():
    with LocalPool(2, time_limit=1.0) as pool:
        long = pool.submit(time.sleep, 600)
        short = pool.submit(abs, -3)
        with pytest.raises(PointDied, match="time limit of 1 s exceeded"):
            long.result(60)
        assert short.result(60) == 3


def test_an_error_outside_ends_the_processes():
    with pytest.raises(KeyboardInterrupt), LocalPool(1) as pool:
        running = pool.submit(time.sleep, 600)
        waiting = pool.submit(abs, -1)
        while not running.running():
            time.sleep(0.01)
        raise KeyboardInterrupt
    assert waiting.cancelled() or not waiting.done()


def test_a_process_that_starts_while_the_pool_ends_is_ended(monkeypatch):
    """Its call would be waited for, ten minutes here."""
    begun, go, start = threading.Event(), threading.Event(), LocalPool._start

    def held_up(pool):
        begun.set()
        go.wait(60)
        return start(pool)

    monkeypatch.setattr(LocalPool, "_start", held_up)
    pool = LocalPool(1)
    late = pool.submit(time.sleep, 600)
    assert begun.wait(60)
    pool.shutdown(wait=False, cancel_futures=True)
    go.set()
    with pytest.raises(PointDied, match="with the others"):
        late.result(60)
    pool.shutdown()
