"""Reduced bodies are kept: an .npz in a folder for what was decided about a body and for the code
that makes it. What is kept is found without the code that reduces, which is slow to import.
"""

import hashlib
import json
import resource
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from ..options import Block, Piston
from .film_loads import Training
from .reduced_body import BossFilms, save

FILES = ("mesh", "stiffness", "mass")
"""Options that name a file."""
ROOMS = ("finite_elements", "geometry", "reduction")
"""Rooms of this part whose code makes a reduced body."""

Say = Callable[[str], None]
Grid = tuple[int, int]


@cache
def code_digest() -> str:
    """SHA-256 of the code that makes a reduced body: whoever changes a line gets a new body."""
    digest = hashlib.sha256()
    part = Path(__file__).parents[1]
    for file in sorted(file for room in ROOMS for file in (part / room).glob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def kept_body(
    options: Piston | Block,
    grid: Grid,
    folder: Path | str,
    progress: Say = print,
    training: Training | None = None,
    bosses: BossFilms | None = None,
) -> Path:
    """Path of the reduced body's .npz, made unless one of the same file contents, options, training
    and code (`code_digest`) lies in `folder`. A piston's `pin_offset` needs no new reduction.

    The file is written under another name and moved into place, so that an interrupted run leaves
    nothing half-written; its solutions wait in `folder` for the next try.

    Parameters
    ----------
    options : Piston or Block
    grid : (int, int)
    folder : Path
    progress : callable
    training : Training, optional
        For the basis `trained`: its forces count, not the file they come from.
    bosses : BossFilms, optional
        Films in a piston's bosses.
    """
    name = "piston" if isinstance(options, Piston) else "block"
    later = {"profiles", "orders", "reduced", "train_on", "pin_offset"}
    decided = options.model_dump(mode="json", exclude=later)
    for key in FILES:
        if decided[key]:
            decided[key] = hashlib.sha256(Path(decided[key]).read_bytes()).hexdigest()
    decided |= {"grid": list(grid), "code": code_digest()}
    if training:
        decided["training"] = training.digest()
    if bosses:
        decided["bosses"] = bosses._asdict()
    path = _path(name, decided, folder)
    if not path.exists():
        from ..finite_elements.solver import Remembering
        from .reduce import reduce_block, reduce_piston

        begin = time.perf_counter()
        factors = Remembering(Path(folder) / "unfinished", progress)
        body, anatomy, left_out, held = (
            reduce_piston(options, grid, progress, factors, training, bosses)
            if isinstance(options, Piston)
            else reduce_block(options, grid, progress, factors, training)
        )
        seconds = time.perf_counter() - begin
        peak_memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        anatomy = replace(anatomy, seconds=seconds, peak_memory=peak_memory)
        save(path, *(part for part in (body, anatomy, left_out, held) if part))
        factors.forget()
    return path


def kept(name: str, options: dict, make: Callable[[], Any], folder: Path) -> Path:
    """Path of the .npz NAME-digest of what `make` makes, made unless one of the same options (a
    file's as the digest of its content) and code lies in `folder`.
    """
    path = _path(name, options | {"code": code_digest()}, folder)
    if not path.exists():
        save(path, make())
    return path


def _path(name, decided, folder):
    """File of a body by its name and all that was decided about it."""
    digest = hashlib.sha256(json.dumps(decided, sort_keys=True).encode()).hexdigest()[:24]
    return Path(folder) / f"{name}-{digest}.npz"
