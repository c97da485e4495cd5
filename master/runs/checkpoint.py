"""Checkpoint of a run: enough to go on in a new process with the same bits, never damaged by a
crash.
"""

import os
import zipfile
from collections import Counter
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path

from ..coupling.ledger import Ledger
from ..coupling.stepping import Counters
from ..coupling.work import ConjugatePair, InterfaceWork
from ..fmi.errors import BadInput, Stopped, file_fault
from ..participants.plain import NotPlain, pack, unpack
from .envelopes import Envelopes
from .extrapolation import Extrapolation
from .reductions import Reduction
from .repetition import Repetition


class Interrupted(Stopped):
    """Stop of a run by a signal, with a checkpoint."""

    def __init__(self, output, time):
        super().__init__(f"interrupted at t = {time:.6g} s; {kept(output)}")


def kept(output):
    """Return a message about the checkpoint of a stopped run."""
    checkpoint = Checkpoint.path(output)
    if not checkpoint.exists():
        return "no checkpoint was written"
    return (
        "remove the cause, then continue from the last checkpoint with: "
        f"piston-cosim resume {checkpoint}"
    )


@dataclass
class Account:
    """What a run has brought and taken so far: all that its summary is made of.

    counters; reductions : summary entries; work : `InterfaceWork`; spent : seconds by what they
    went into; steps_done : macro steps of the run; rows : of the results file, and wall_time [s],
    both as of the last checkpoint; began, began_rows : steps and rows at the beginning of the
    period under way, which reductions, work, ledger and envelopes are of; repetition : of a case
    with a period.
    """

    counters: Counters
    reductions: list
    work: InterfaceWork
    spent: dict
    steps_done: int = 0
    rows: int = 0
    wall_time: float = 0.0
    began: int = 0
    began_rows: int = 0
    repetition: Repetition | None = None
    ledger: Ledger | None = None
    envelopes: Envelopes = field(default_factory=lambda: Envelopes({}))


MAGIC = b"piston-cosim checkpoint\n"
VERSION = 3
CHECKSUM = 32
"""Bytes of a SHA-256."""

ACCOUNTS = (
    Account,
    ConjugatePair,
    Counters,
    Envelopes,
    Extrapolation,
    InterfaceWork,
    Ledger,
    Reduction,
    Repetition,
)
"""Classes of what an account is made of."""


@dataclass(frozen=True)
class Checkpoint:
    """State of a run after a macro step.

    tree, folder : resolved TOML tree, where its paths begin; frozen : participants, predictor,
    method (see `freezing`); fmus : participant -> SHA-256 of its FMU's content; sources :
    participant -> SHA-256 of its Python file.

    The file holds the line "piston-cosim checkpoint", 4 bytes with the version of this layout, the
    SHA-256 of all that follows, and then plain data (see `participants.plain`): no code. Its size
    is that of the participants' states and of what the method remembers, and does not grow with the
    run.
    """

    tree: dict
    folder: str
    frozen: bytes
    account: Account
    fmus: dict
    sources: dict = field(default_factory=dict)

    @staticmethod
    def path(output):
        """Where the checkpoint of a results file lies; none is written if a participant cannot
        serialise its state.
        """
        return Path(f"{output}.checkpoint")

    def write(self, output):
        """Put it beside the results file, in place of the last one in a single move."""
        target = self.path(output)
        partial = target.with_name(target.name + ".part")
        data = pack(vars(self) | {"account": _bounded(self.account)}, ACCOUNTS)
        with open(partial, "wb") as file:
            file.write(MAGIC + VERSION.to_bytes(4, "little") + sha256(data).digest())
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, target)

    @staticmethod
    def read(path):
        """The checkpoint in a file; BadInput if it is none, damaged or of another version."""
        try:
            whole = Path(path).read_bytes()
        except OSError as error:
            raise BadInput(file_fault(path, error)) from None
        begin = len(MAGIC) + 4 + CHECKSUM
        if not whole.startswith(MAGIC) or len(whole) < begin:
            raise BadInput(f"{path}: expected a checkpoint of this version, got another file")
        version = int.from_bytes(whole[len(MAGIC) : len(MAGIC) + 4], "little")
        if version != VERSION:
            raise BadInput(
                f"{path}: expected a checkpoint of layout {VERSION}, got layout {version}"
            )
        data = whole[begin:]
        if sha256(data).digest() != whole[begin - CHECKSUM : begin]:
            raise BadInput(f"{path}: expected an intact checkpoint, got another checksum")
        try:
            checkpoint = Checkpoint(**unpack(data, ACCOUNTS))
            _unbounded(checkpoint.account)
        except (NotPlain, TypeError, AttributeError, KeyError):
            raise BadInput(f"{path}: expected a checkpoint, got other content") from None
        return checkpoint


def _bounded(account):
    """The account with the number of macro steps by their iterations, in place of a list of them
    all.
    """
    counted = dict(Counter(account.counters.iterations))
    return replace(account, counters=replace(account.counters, iterations=counted))


def _unbounded(account):
    """The list of iterations again, in another order, which nobody asks for."""
    counted = account.counters.iterations
    account.counters.iterations = [int(k) for k, count in counted.items() for _ in range(count)]


def code_files(tree, folder, key):
    """Return the files with code that a case names: participant -> path.

    key : "file" for Python files, "fmu" for FMUs.
    """
    tables = tree.get("participants", {}).items()
    named = {name: table[key] for name, table in tables if table.get(key)}
    return {
        name: Path(folder) / (text.rpartition(":")[0] if key == "file" else text)
        for name, text in named.items()
    }


def source_hashes(tree, folder):
    """Return the SHA-256 of the Python files that a case names: participant -> text."""
    files = code_files(tree, folder, "file")
    return {name: sha256(path.read_bytes()).hexdigest() for name, path in files.items()}


def check_code(checkpoint, say):
    """Compare the code that a checkpoint names with what its run had; nothing is executed.

    Parameters
    ----------
    checkpoint : Checkpoint
    say : callable(line)
        Receives a line for each file whose code the run will execute.

    Raises
    ------
    BadInput
        With every file that is missing or has another content.
    """
    faults, files = [], []
    for key, expected in (("file", checkpoint.sources), ("fmu", checkpoint.fmus)):
        for name, path in code_files(checkpoint.tree, checkpoint.folder, key).items():
            try:
                content = sha256(path.read_bytes()).hexdigest() if key == "file" else None
                same = (content or _content_hash(path)) == expected.get(name)
            except (OSError, zipfile.BadZipFile) as error:
                faults.append(f"participants.{name}.{key}: {file_fault(path, error)}")
                continue
            if not same:
                kind = "Python file" if key == "file" else "FMU"
                faults.append(
                    f"participants.{name}.{key}: expected the {kind} of the run, got another "
                    f"content of {path}; run again from the start"
                )
            files.append(f"executes participants.{name}.{key} = {path}")
    if faults:
        raise BadInput(faults)
    for line in files:
        say(line)


def fingerprints(participants):
    """SHA-256 of the content of every participant's FMU: participant -> text."""
    paths = {name: getattr(p, "path", None) for name, p in participants.items()}
    return {name: _content_hash(path) for name, path in paths.items() if path is not None}


def _content_hash(path):
    """Of names and contents alone: an FMU built again has other times in its archive."""
    digest = sha256()
    with zipfile.ZipFile(path) as archive:
        for name in sorted(archive.namelist()):
            digest.update(f"{name}\n".encode())
            digest.update(sha256(archive.read(name)).digest())
    return digest.hexdigest()
