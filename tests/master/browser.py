"""A Chromium without a window, asked through its pipes: real time, keys, sizes, printing.

Commands and events: the DevTools protocol, https://chromedevtools.github.io/devtools-protocol.
"""

import fcntl
import json
import os
import select
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

FLAGS = (
    *("--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update", "--hide-scrollbars"),
    *("--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--disable-gpu", "--remote-debugging-pipe"),
)
"""What a page may ask of the network is asked by the page alone; graphics by software."""
HANDED = """import os, sys
os.dup2(int(sys.argv[1]), 3); os.dup2(int(sys.argv[2]), 4)
os.execv(sys.argv[3], sys.argv[3:])"""
LATE = 120.0
"""No answer in so many seconds is none."""


def _above(descriptor):
    """Return the same pipe as a descriptor of 10 or more."""
    moved = fcntl.fcntl(descriptor, fcntl.F_DUPFD, 10)
    os.close(descriptor)
    return moved


class Browser:
    """One browser with one page.

    Parameters
    ----------
    folder : Path
        For its profile.
    width, height : int
        Of the page [CSS pixels].
    """

    def __init__(self, folder: Path, width: int = 1200, height: int = 900):
        program = shutil.which("chromium") or shutil.which("google-chrome")
        if program is None:
            pytest.skip("no chromium: the page was not opened")
        self.events: list[dict] = []
        self._count = 0
        self._rest = b""
        self._session: str | None = None
        asked, self._write = os.pipe()
        self._read, told = os.pipe()
        # the protocol's two pipes are its descriptors 3 and 4, whichever they are here
        asked, told = (_above(one) for one in (asked, told))
        self._process = subprocess.Popen(
            [sys.executable, "-c", HANDED, str(asked), str(told), program, *FLAGS]
            + [f"--user-data-dir={folder}", f"--window-size={width},{height}", "about:blank"],
            pass_fds=(asked, told),
            stderr=subprocess.DEVNULL,
            env=os.environ | {"HOME": str(folder)},
        )
        os.close(asked)
        os.close(told)
        page = self._first_page()
        self._session = self.ask("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.ask(f"{domain}.enable")
        self.ask("Performance.enable", timeDomain="threadTicks")  # processor time, not the clock's

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self._write)
        os.close(self._read)
        self._process.terminate()
        self._process.wait()

    def _first_page(self):
        until = time.monotonic() + LATE
        while time.monotonic() < until:
            targets = self.ask("Target.getTargets")["targetInfos"]
            pages = [one["targetId"] for one in targets if one["type"] == "page"]
            if pages:
                return pages[0]
            time.sleep(0.02)
        raise AssertionError("the browser opens no page")

    def ask(self, method: str, **given):
        """Return the browser's answer to a command."""
        self._count += 1
        wanted = self._count
        message = {"id": wanted, "method": method, "params": given}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + LATE
        while True:
            answer = self._message(until)
            if answer.get("id") == wanted:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]
            self.events.append(answer)

    def _message(self, until):
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._read], [], [], max(0.0, until - time.monotonic()))
            assert ready, "the browser does not answer"
            part = os.read(self._read, 1 << 20)
            assert part, "the browser is gone"
            self._rest += part
        text, _, self._rest = self._rest.partition(b"\0")
        return json.loads(text)

    def reset(self):
        """Forget what was said, size and media, and show nothing."""
        self.ask("Emulation.clearDeviceMetricsOverride")
        self.ask("Emulation.setEmulatedMedia", media="", features=[])
        self.ask("Page.navigate", url="about:blank")
        self.events.clear()

    def resize(self, width: int):
        """Give the page a width [CSS pixels]."""
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        self.ask("Emulation.setDeviceMetricsOverride", **size)

    def open(self, page: Path, anchor: str = ""):
        """Open a page at an anchor and wait until it is ready."""
        self.ask("Page.navigate", url=page.resolve().as_uri() + anchor)
        self.run(
            "while (!document.body || document.body.dataset.page !== 'ready')"
            " await new Promise(done => setTimeout(done, 20));"
        )

    def run(self, script: str):
        """Return the value of an asynchronous function with this body."""
        answer = self.ask(
            "Runtime.evaluate",
            expression=f"(async () => {{ {script} }})()",
            awaitPromise=True,
            returnByValue=True,
        )
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def key(self, name: str):
        """Press a key: Tab, an arrow by its name, or a letter."""
        codes = {"Tab": 9, "Enter": 13, "ArrowRight": 39}
        given = {"key": name, "windowsVirtualKeyCode": codes.get(name, ord(name[0]))}
        letters = "\r" if name == "Enter" else name if len(name) == 1 else ""
        text = {"text": letters} if letters else {"code": name}
        self.ask("Input.dispatchKeyEvent", type="keyDown", **given, **text)
        self.ask("Input.dispatchKeyEvent", type="keyUp", **given)

    def metrics(self) -> dict[str, float]:
        """Performance.getMetrics: processor time of the page's script, layout and tasks [s]."""
        told = self.ask("Performance.getMetrics")["metrics"]
        return {one["name"]: one["value"] for one in told}

    def said(self) -> list[str]:
        """Return the console messages and uncaught errors.

        Messages of the browser's software renderer about its speed are left out.
        """
        kinds = {
            "Runtime.consoleAPICalled": lambda one: [str(arg.get("value")) for arg in one["args"]],
            "Runtime.exceptionThrown": lambda one: one["exceptionDetails"].get(
                "exception", one["exceptionDetails"]
            ),
            "Log.entryAdded": lambda one: one["entry"]["text"],
        }
        words = [
            str(kinds[event["method"]](event["params"]))
            for event in self.events
            if event["method"] in kinds
        ]
        return [word for word in words if "GPU stall due to ReadPixels" not in word]

    def asked(self) -> list[str]:
        """Addresses asked for beside files, and what the page holds itself."""
        urls = [
            event["params"]["request"]["url"]
            for event in self.events
            if event["method"] == "Network.requestWillBeSent"
        ]
        return [url for url in urls if not url.startswith(("file:", "data:", "blob:", "about:"))]

    def seconds(self) -> float:
        """Return the processor time of all its processes [s]."""
        ticks = 0
        family = {self._process.pid}
        for stat in sorted(Path("/proc").glob("[0-9]*/stat"), key=lambda path: int(path.parts[2])):
            try:
                pid, rest = int(stat.parts[2]), stat.read_text().rpartition(")")[2].split()
            except OSError:
                continue
            if pid in family or int(rest[1]) in family:
                family.add(pid)
                ticks += int(rest[11]) + int(rest[12])
        return ticks / os.sysconf("SC_CLK_TCK")


PLAYED = """byId("play").click();
while (play.count < %d) await new Promise(done => requestAnimationFrame(done));
byId("play").click();"""
WARMING = 20
"""Frames until the browser has compiled what it plays with."""


@dataclass(frozen=True)
class Pace:
    """Processor time of a frame of a page that plays [ms].

    page : of the page's own thread; all : of all processes.
    """

    page: float
    all: float


def pace(browser: Browser, frames: int) -> Pace:
    """Play so many frames of the page with the bodies open."""
    browser.run(
        "byId('bodies').open = true;"
        " while (!document.querySelector('.scene canvas')?.scene.thrust.style.transform)"
        " await new Promise(done => setTimeout(done, 50));"
    )
    browser.run(PLAYED % WARMING)
    taken = browser.seconds()
    tasks = browser.metrics()["TaskDuration"]
    browser.run(PLAYED % frames)
    return Pace(
        page=1e3 * (browser.metrics()["TaskDuration"] - tasks) / frames,
        all=1e3 * (browser.seconds() - taken) / frames,
    )
