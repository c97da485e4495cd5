"""Variants of a case in parallel processes, with the same results as in separate runs."""

from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from ..case.checked import check_case
from ..case.system import open_system
from ..fmi.errors import BadInput, Stopped
from .completed import complete_run
from .console import Watch
from .pool import LocalPool, PointDied
from .signals import forwarding
from .working import REFRESH_INTERVAL, bars, every


class Variant(NamedTuple):
    """Variant to run: its resolved tree, the folder of its case, and its results file.

    uncertainty : whether its uncertainties are computed by further runs.
    """

    tree: dict[str, Any]
    folder: Path
    output: Path
    uncertainty: bool = False


class Outcome(NamedTuple):
    """Outcome of a variant.

    It has a summary and the time of its first step [s], or faults, or headline and lines of the
    error that stopped it.
    """

    summary: dict[str, Any] = {}
    first: float | None = None
    faults: Sequence[str] = ()
    headline: str = ""
    lines: Sequence[str] = ()


def start_processes(pool: LocalPool, count: int) -> None:
    """Let processes of a pool start, and import what a variant needs, in the background."""
    for _ in range(count):
        pool.submit(_import)


def _import() -> None:
    """Import the modules that a variant imports late."""
    from ..participants import fmi2  # noqa: F401


def run_variants(
    variants: dict[str, Variant],
    pool: LocalPool,
    console,
    say: Callable[[str], object],
    log: Callable[[str], object],
) -> dict[str, Outcome]:
    """Run variants in parallel; return their outcomes by label.

    The failure of a variant does not affect the others. `say` receives each message once, and `log`
    the lines of each period.

    Raises
    ------
    Stopped
        If a variant was stopped.
    BadInput
        With the faults of all variants.
    """
    reported = set()

    def receive(label, message):
        kind, *data = message
        if kind == "show":
            received.stepped |= data[0] > 0.0
            show(label, *data)
        elif kind == "log":
            log(f"{label}: {data[0]}")
        elif data[0] not in reported:
            reported.add(data[0])
            say(data[0])

    with bars(console) as show, forwarding(pool.send_signal) as received:
        futures = pool.share(receive, _run, variants)
    outcomes = {label: _outcome(future) for label, future in futures.items()}
    stopped = {label: one for label, one in outcomes.items() if one.lines}
    if stopped:
        error = Stopped(
            "\n".join(f"{x}: {line}" for x, one in stopped.items() for line in one.lines)
        )
        error.headline = next((one.headline for one in stopped.values()), "")
        raise error
    if faults := [fault for one in outcomes.values() for fault in one.faults]:
        raise BadInput([*dict.fromkeys(faults)])
    return outcomes


def _outcome(future: Future) -> Outcome:
    try:
        return future.result()
    except CancelledError:
        return Outcome(lines=["not run"])
    except PointDied as death:
        return Outcome(headline="a process of the run ended", lines=[str(death)])


def _run(send, variant: Variant) -> Outcome:
    """Run a variant in this process."""
    watch = Watch(lambda share, state: send(("show", share, state)))
    say, log = (partial(_send, send, kind) for kind in ("say", "log"))
    tree, folder, output, uncertainty = variant
    try:
        case = check_case(tree, folder)
        with every(REFRESH_INTERVAL, watch.tick):
            system = open_system(case, folder, say)
            options = {"say": say, "log": log, "uncertainty": uncertainty}
            summary = complete_run(system, case, tree, output, watch, **options)
        send(("show", 1.0, ""))
        return Outcome(summary, watch.first)
    except BadInput as error:
        return Outcome(faults=error.faults)
    except Stopped as error:
        notes = getattr(error, "__notes__", ())
        return Outcome(headline=error.headline, lines=[str(error), *notes])


def _send(send, kind, text):
    send((kind, text))
