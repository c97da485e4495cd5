"""Checkpoints of a run, which resume with the same bits and survive a crash."""

import os
import zipfile
from collections import Counter
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from shlex import quote

from ..coupling.ledger import Ledger
from ..coupling.stepping import Counters
from ..coupling.work import ConjugatePair, InterfaceWork
from ..fmi.errors import BadInput, Stopped, file_fault
from ..participants.plain import NotPlain, pack, unpack
from .envelopes import Envelopes
from .extrapolation import Extrapolation
from .extremes import Extremes
from .reductions import Reduction
from .repetition import Repetition


class Interrupted(Stopped):
    """Stop of a run by a signal, with a checkpoint."""

    def __init__(self, output, time):
        super().__init__(f"interrupted at t = {time:.6g} s; {checkpoint_message(output)}")


def checkpoint_message(output):
    """Return a message about the checkpoint of a stopped run."""
    checkpoint = Checkpoint.path(output)
    if not checkpoint.exists():
        return "no checkpoint was written"
    return (
        "remove the cause, then continue from the last checkpoint with: "
        f"piston-cosim resume {quote(str(checkpoint))}"
    )


@dataclass
class Account:
    """Counters and sums of a run so far, from which its summary is made.

    counters; reductions : summary entries; work : `InterfaceWork`; spent : time by task [s];
    steps_done : macro steps of the run; rows, wall_time : rows of the results file and time [s]
    at the last checkpoint; began, began_rows : steps and rows at the beginning of the current
    period, for which reductions, work, ledger and envelopes hold; repetition : for a case with a
    period; warnings : participant, text, time and count of each up to the last checkpoint.
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
    warnings: list = field(default_factory=list)


MAGIC = b"piston-cosim checkpoint\n"
VERSION = 5
CHECKSUM = 32
"""Length of a SHA-256 [bytes]."""

ACCOUNTS = (
    Account,
    ConjugatePair,
    Counters,
    Envelopes,
    Extrapolation,
    Extremes,
    InterfaceWork,
    Ledger,
    Reduction,
    Repetition,
)
"""Classes of the members of an account."""


@dataclass(frozen=True)
class Checkpoint:
    """State of a run after a macro step.

    tree, folder : resolved TOML tree and folder of its paths; frozen : participants, predictor,
    method (see `freezing`); fmus : participant -> SHA-256 of its FMU's content; sources :
    participant -> SHA-256 of its Python file.

    The file contains the line "piston-cosim checkpoint", 4 bytes with the version of this
    layout, and the SHA-256 of the rest. The rest is plain data without code (see
    `participants.plain`). Its size does not grow with the run.
    """

    tree: dict
    folder: str
    frozen: bytes
    account: Account
    fmus: dict
    sources: dict = field(default_factory=dict)

    @staticmethod
    def path(output):
        """Return the path of the checkpoint of a results file."""
        return Path(f"{output}.checkpoint")

    def write(self, output):
        """Replace the last checkpoint next to the results file in a single step."""
        target = self.path(output)
        partial = target.with_name(target.name + ".part")
        data = pack(vars(self) | {"account": _with_counts(self.account)}, ACCOUNTS)
        with open(partial, "wb") as file:
            file.write(MAGIC + VERSION.to_bytes(4, "little") + sha256(data).digest())
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, target)

    @staticmethod
    def read(path):
        """Return the checkpoint in a file.

        Raises `BadInput` if it is none, damaged or of another version.
        """
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
            _with_list(checkpoint.account)
        except (NotPlain, TypeError, AttributeError, KeyError):
            raise BadInput(f"{path}: expected a checkpoint, got other content") from None
        return checkpoint


def _with_counts(account):
    """Return the account with a count of macro steps by iterations, instead of a list."""
    counted = dict(Counter(account.counters.iterations))
    return replace(account, counters=replace(account.counters, iterations=counted))


def _with_list(account):
    """Restore the list of iterations, whose order has no effect."""
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
    return {name: _hash(path) for name, path in code_files(tree, folder, "file").items()}


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
                same = (_hash if key == "file" else _content_hash)(path) == expected.get(name)
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
    """Return the SHA-256 of the content of every participant's FMU or table, by participant."""
    paths = {name: getattr(p, "path", None) for name, p in participants.items()}
    return {name: _content_hash(path) for name, path in paths.items() if path is not None}


def _hash(path):
    return sha256(path.read_bytes()).hexdigest()


def _content_hash(path):
    """Return the hash of names and contents; file times differ after a rebuild.

    A table is a single file.
    """
    if not zipfile.is_zipfile(path):
        return _hash(path)
    digest = sha256()
    with zipfile.ZipFile(path) as archive:
        for name in sorted(archive.namelist()):
            digest.update(f"{name}\n".encode())
            digest.update(sha256(archive.read(name)).digest())
    return digest.hexdigest()
