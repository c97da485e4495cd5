"""Live page of a run: curves, pausing, stopping with a checkpoint.

The page responds on 127.0.0.1 only, under an address that contains a secret. It rejects requests
with another Host or Origin, so that neither another machine nor another page of the browser can
read or stop the run.
"""

import json
import os
import re
import secrets
import signal
import threading
import time as clock
from base64 import b64encode
from contextlib import contextmanager
from hashlib import sha256
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

KEPT = 4000
"""Maximum number of points of a curve. Beyond it, every second one is removed, and the sampling
interval doubles."""
PATIENCE = 0.1
"""Time between two checks while the run is paused [s]."""
CURVES = 6
"""Number of curves of a case without monitor entries."""


class Live:
    """State of the live page, the `watch` of `run`; calls `further` after every macro step."""

    def __init__(self, title, further):
        self.title, self.further = title, further
        self.names: list[str] = []
        self.rows: list[list[float]] = []
        self.every, self.count, self.generation = 1, 0, 0
        self.stop, self.time = 0.0, 0.0
        self.paused = False
        self.lock = threading.Lock()

    def __call__(self, time, stop, solution, monitored):
        with self.lock:
            self.names = ["iterations", *(f"{n} [{unit}]" for n, (_, unit) in monitored.items())]
            self.time, self.stop = time, stop
            if self.count % self.every == 0:
                values = (float(value) for value, _ in monitored.values())
                self.rows.append([time, solution.iterations, *values])
            self.count += 1
            if len(self.rows) > KEPT:
                self.rows, self.every = self.rows[::2], 2 * self.every
                self.generation += 1
        self.further(time, stop, solution, monitored)

    def hold(self, heard):
        """Wait between two macro steps while the run is paused, or until a signal arrives."""
        while self.paused and not heard.signal:
            clock.sleep(PATIENCE)

    def state(self, generation, begin):
        """Return the changes since a page received `begin` rows of a generation."""
        with self.lock:
            begin = begin if generation == self.generation else 0
            return {
                "title": self.title,
                "names": self.names,
                "rows": self.rows[begin:],
                "begin": begin,
                "generation": self.generation,
                "time": self.time,
                "stop": self.stop,
                "paused": self.paused,
            }

    def ask(self, wish):
        """Execute the command of a button; return whether it exists."""
        if wish == "stop":
            self.paused = False
            os.kill(os.getpid(), signal.SIGINT)
        elif wish in ("pause", "go"):
            self.paused = wish == "pause"
        else:
            return False
        return True


@contextmanager
def serving(live):
    """Serve the page, and yield its address."""
    secret = secrets.token_urlsafe(16)
    server = ThreadingHTTPServer(("127.0.0.1", 0), _handler(live, secret))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/{secret}/"
    finally:
        server.shutdown()
        server.server_close()


def _headers(page):
    """Return the headers of every answer: the page runs its own script and style, nothing else."""
    sources = {
        kind: f"'sha256-{b64encode(sha256(text).digest()).decode()}'"
        for kind, text in re.findall(rb"<(script|style)>(.*?)</\1>", page, re.DOTALL)
    }
    policy = (
        f"default-src 'none'; script-src {sources[b'script']}; style-src {sources[b'style']}; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
    return {
        "Content-Security-Policy": policy,
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",  # the address contains the secret
        "Cache-Control": "no-store",
    }


def _handler(live, secret):
    page = Path(__file__).with_name("live.html").read_bytes()
    headers = _headers(page)

    class Handler(BaseHTTPRequestHandler):
        def parse_request(self):
            """Read a request; reject one from another page or for another host."""
            if not super().parse_request():
                return False
            _, port, *_ = self.connection.getsockname()
            hosts = [f"{name}:{port}" for name in ("127.0.0.1", "localhost")]
            origin = self.headers.get("Origin")
            own = origin is None or origin in [f"http://{host}" for host in hosts]
            if self.headers.get("Host") in hosts and own:
                return True
            self.send_error(403)
            return False

        def end_headers(self):
            for name, text in headers.items():
                self.send_header(name, text)
            super().end_headers()

        def do_GET(self):
            place, _, query = self.path.partition("?")
            if place == f"/{secret}/":
                self._answer(page, "text/html; charset=utf-8")
            elif place == f"/{secret}/state":
                known = [int(part) if part.isdigit() else 0 for part in query.split(",")]
                generation, begin = (*known, 0, 0)[:2]
                state = json.dumps(live.state(generation, begin))
                self._answer(state.encode(), "application/json")
            else:
                self.send_error(404)

        def do_POST(self):
            head, _, wish = self.path.rpartition("/")
            if head == f"/{secret}" and live.ask(wish):
                self._answer(b"{}", "application/json")
            else:
                self.send_error(404)

        def _answer(self, data, kind):
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(data)))
            self.end_headers()
            self.wfile.write(data)

        def log_message(self, format, *args):
            """Print nothing, because the screen is for the run's own messages."""

    return Handler


def curves(case, system):
    """Return the monitor entries of the case; default: the first scalar outputs."""
    if case.monitor:
        return case.monitor
    ports = [
        f"{name}.{field.name}"
        for name, participant in system.participants.items()
        for field in participant.fields.values()
        if field.causality == "output" and not field.shape and field.type == "Real"
    ]
    return {port: f"last {port}" for port in ports[:CURVES]}
