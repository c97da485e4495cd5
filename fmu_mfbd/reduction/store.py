"""Cache of reduced bodies.

It contains an .npz file for each mesh, options and code. The shipped files of `models/bodies`
depend on mesh and options only. A lookup does not import the code that reduces, which is slow.
"""

import hashlib
import json
import re
import resource
import time
from collections.abc import Callable, Collection
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from ...models import MODELS
from ..body_options import SLIDING_LAYER, Block, Piston
from ..options import RoundShell, SmallEnd
from .film_loads import Training
from .reduced_body import ReducedShell, ShellFilm, ShellKind, save

FILES = ("mesh", "stiffness", "mass", "file", "table")
"""Options that name a file."""
INCLUDE = re.compile(rb"(?im)^[ \t]*(?:\*[^\n]*\binput[ \t]*=|include[ \t])[ \t'\"]*([^'\",\r\n]+)")
"""Name of an included file in a deck of Abaqus or Nastran."""
HOT = ("hot_shape", "temperature_field")
"""Options of a hot shape, on which modes do not depend."""
LATER_OPTIONS = ("part", "materials", "expansion", *HOT)
"""Options that are no part of a key if they have no value."""
SOURCES = ("finite_elements", "geometry", "reduction")
"""Folders whose code determines a reduced body."""
SHIPPED = MODELS / "bodies"
"""Folder of reduced bodies without mode shapes on the mesh (`.ci/bodies.py` writes them)."""
IF_FLEXIBLE = {"basis", "symmetric_film", "modes_from", "tie", "boss_length"}
"""Options that have no effect on a body without modes."""

Say = Callable[[str], None]
Grid = tuple[int, int]


@cache
def code_digest() -> str:
    """Return the SHA-256 of the code that determines a reduced body."""
    digest = hashlib.sha256()
    part = Path(__file__).parents[1]
    for file in sorted(file for name in SOURCES for file in (part / name).glob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def kept_body(
    options: Piston | Block,
    grid: Grid,
    folder: Path | str,
    progress: Say = print,
    training: Training | None = None,
    bosses: ShellFilm | None = None,
    shapes: bool = True,
) -> Path:
    """Return the path of a reduced body's .npz: shipped, cached in `folder`, or reduced now.

    The contents of files, options and training determine the body; in `folder` the code
    (`code_digest`) does too. `pin_offset` of a piston needs no new reduction.

    Each file is written under another name and then moved. After an interruption, the next
    reduction continues with the solutions cached in `folder`.

    Parameters
    ----------
    options : Piston or Block
    grid : (int, int)
    folder : Path
    progress : callable
    training : Training, optional
        Forces for the basis `trained`. The key contains the forces, not the path of their file.
    bosses : ShellFilm, optional
        Films in a piston's bosses.
    shapes : bool
        Whether the file must contain mode shapes on the mesh. Shipped files do not.
    """
    name = "piston" if isinstance(options, Piston) else "block"
    decided = _decided(options, grid, training, bosses)
    used: list[Any] = []

    def build_body() -> tuple[Any, ...]:
        from ..finite_elements.solver import CachedFactorise
        from .reduce import reduce_block, reduce_piston

        begin = time.perf_counter()
        factors = CachedFactorise(Path(folder) / "unfinished", progress)
        used.append(factors)
        reduced = (
            reduce_piston(options, grid, progress, factors, training, bosses)
            if isinstance(options, Piston)
            else reduce_block(options, grid, progress, factors, training)
        )
        seconds = time.perf_counter() - begin
        peak_memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        properties = replace(reduced.properties, seconds=seconds, peak_memory=peak_memory)
        body, anatomy, _, *rest = reduced
        return body, anatomy, properties, *(part for part in rest if part)

    path = stored_file(name, decided, build_body, folder, not shapes)
    for factors in used:
        factors.forget()
    return path


def _decided(
    options: Piston | Block, grid: Grid, training: Training | None, bosses: ShellFilm | None
) -> dict[str, Any]:
    """Return what determines a reduced body besides the code."""
    later = {"profiles", "orders", "reduced", "train_on", "pin_offset", "shape", "expansion", *HOT}
    if not options.modes:
        later |= IF_FLEXIBLE
    slides = isinstance(options, Piston) and options.tie in (None, "sliding")
    if not slides:
        later |= {"boss_length"}
    decided = contents(options, later) | {"grid": list(grid)}
    if slides and options.modes:
        decided["pin_layer"] = SLIDING_LAYER
    if training:
        decided["training"] = training.digest()
    if bosses:
        decided["bosses"] = bosses._asdict()
    return decided


def contents(options: BaseModel, excluded: Collection[str] = ()) -> dict[str, Any]:
    """Return options, with the digest of the content of each file that they name."""
    out = options.model_dump(mode="json", exclude=set(excluded))
    for key in LATER_OPTIONS:  # which shipped files do not have
        if not out.get(key, True):
            del out[key]
    for table in (out, *(out[key] for key in HOT if key in out)):
        for key in FILES:
            if table.get(key):
                table[key] = _digest(Path(table[key]))
    return out


def _digest(path: Path, above: tuple[Path, ...] = ()) -> str:
    """Return the SHA-256 of a file and of the files that it includes, if it is a deck."""
    data = path.read_bytes()
    digest = hashlib.sha256(data)
    for name in INCLUDE.findall(data):
        inner = path.parent / name.decode(errors="replace").strip().replace("\\", "/")
        if inner.is_file() and inner not in above:
            digest.update(_digest(inner, (*above, path, inner)).encode())
    return digest.hexdigest()


def stored_file(
    name: str,
    options: dict[str, Any],
    make: Callable[[], tuple[Any, ...]],
    folder: Path | str,
    shipped: bool = True,
) -> Path:
    """Return the path of the .npz of the parts that `make` returns.

    The file is shipped, if this is allowed, cached in `folder`, or made now. The options
    (`contents`) determine it; in `folder` the code does too.
    """
    key = hashlib.sha256(json.dumps(options, sort_keys=True).encode()).hexdigest()[:24]
    path = SHIPPED / f"{name}-{key}.npz"
    if not (shipped and path.exists()):
        path = Path(folder) / f"{name}-{key}-{code_digest()[:24]}.npz"
    if not path.exists():
        save(path, *make())
    return path


def stored_shell(
    options: SmallEnd | RoundShell,
    density: float,
    film: ShellFilm,
    kind: ShellKind,
    folder: Path,
    progress: Say = print,
) -> Path:
    """Return the path of a reduced shell, cached in `folder` or reduced now.

    Raises
    ------
    MeshFault, ValueError
        If the mesh or the number of modes is wrong.
    """

    def build_body() -> tuple[ReducedShell]:
        from ..finite_elements.matrices import assembled
        from .shell import reduce_shell, shell_mesh

        mesh = shell_mesh(options, film, kind, progress)
        body = assembled(mesh, options.young, options.poisson, density)
        return (reduce_shell(body, film, progress, kind=kind),)

    decided = contents(options) | {"density": density, "film": list(film), "kind": list(kind)}
    return stored_file(kind.title.replace(" ", "_"), decided, build_body, folder)
