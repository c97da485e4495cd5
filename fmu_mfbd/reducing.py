"""Phase, progress and faults of the reduction of a body for its FMU."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import fields
from functools import cache
from pathlib import Path

import numpy as np

from ..master.fmi.cache import cache_folder
from ..master.fmi.errors import BadInput, for_all
from ..master.fmi.phases import phase
from .body_options import Block, Piston
from .finite_elements.deck import MeshFault
from .geometry.profile import HotShape
from .options import Bodies, RoundShell, SmallEnd
from .reduction.reduced_body import (
    Anatomy,
    MeshProperties,
    ReducedBosses,
    ReducedPiston,
    ShellFilm,
    ShellKind,
    load,
)
from .reduction.store import stored_shell
from .thrust_symmetry import kind_of

Say = Callable[[str], None]
SECONDS_PER_MEGABYTE = 50.0
"""Time of a first reduction per megabyte of its mesh file [s]."""


@contextmanager
def reducing(name: str, mesh: str | None, progress: Say, table: str = "") -> Iterator[Say]:
    """Yield `say`. Its first message begins the phase: a cached body has no messages.

    Parameters
    ----------
    name : str
        Name of the body in messages.
    mesh : str or None
        Path of the mesh, whose size determines the expected time.
    progress : callable
        Prints a sentence.
    table : str
        Option with the table of the body, empty if the body has the whole build table.

    Raises
    ------
    BadInput
        Every fault of the mesh, or the option that the reduction rejects.
    """
    with ExitStack() as phases:

        @cache
        def begin() -> None:
            megabytes = Path(mesh).stat().st_size / 1e6 if mesh else 0.1
            phases.enter_context(phase(f"reducing {name}", megabytes, SECONDS_PER_MEGABYTE))

        def say(text: str) -> None:
            begin()
            progress(f"{name}: {text}")

        try:
            yield say
        except MeshFault as error:
            raise BadInput(error.faults) from None
        except MemoryError:
            fault = "modes: expected a reduction that fits into memory, got too many nodes or modes"
            raise BadInput(f"{table}.{fault}".removeprefix(".")) from None
        except ValueError as error:
            raise BadInput(f"{table}.{error}".removeprefix(".")) from None


def reduced_shell(
    options: SmallEnd | RoundShell,
    density: float,
    film: ShellFilm,
    kind: ShellKind,
    progress: Say,
    table: str = "",
) -> Path:
    """Return the path of a reduced shell, from the cache or reduced now.

    Parameters
    ----------
    options : SmallEnd or RoundShell
    density : float
        Density of the material [kg/m3].
    film : ShellFilm
    kind : ShellKind
    progress, table
        As of `reducing`.

    Raises
    ------
    BadInput
        Every fault of the mesh, or the option that the reduction rejects.
    """
    with reducing(kind.title.replace(" ", "_"), options.mesh, progress, table) as say:
        return stored_shell(options, density, film, kind, cache_folder("bodies"), say)


def hot_shapes(build: Bodies, progress: Say) -> dict[str, HotShape]:
    """Return the hot shapes of piston and block, as far as they have one, by name.

    Raises
    ------
    BadInput
        Every fault of mesh and files.
    """
    bodies = {"piston": build.piston, "block": build.block}
    hot = {name: body for name, body in bodies.items() if body and body.has_hot_shape}

    def shape_of(name: str) -> HotShape:
        from .reduction.hot_shape import kept_hot_shape  # slow to import

        options = hot[name]
        with reducing(name, options.mesh, progress, name) as say:
            return kept_hot_shape(options, build.grid, cache_folder("bodies"), say)

    return dict(zip(hot, for_all(shape_of, hot)))


def check_own(path: Path, options: Piston | Block, grid: tuple[int, int]) -> None:
    """Raise ValueError unless a user's file holds a body of these options for this film grid."""
    kind = kind_of(options)
    body = load(kind, path)
    if "modes" in options.model_fields_set and options.modes != len(body.omega):
        raise ValueError(
            f"modes: expected {len(body.omega)}, the number in {path.name}, got {options.modes:g}"
        )
    for part in (Anatomy, MeshProperties):
        names = {one.name for one in fields(part)}
        with np.load(path) as file:
            missing = names - set(file.files)
        if missing and missing != names:
            raise ValueError(
                f"reduced: expected {', '.join(sorted(missing))} in {path.name}, got nothing; "
                "run `piston-cosim reduce` again"
            )
    around, along = grid
    rows = around * along if kind is ReducedPiston else around
    if len(body.radial) != rows:
        raise ValueError(
            f"reduced: expected {rows} rows of modes for this film grid in {path.name}, "
            f"got {len(body.radial)}"
        )
    if not np.all(np.diff(body.omega) >= 0) or np.any(body.omega <= 0):
        raise ValueError(
            f"reduced: expected positive rising frequencies in {path.name}, got others"
        )


def check_bosses(path: Path, films: ShellFilm) -> None:
    """Raise ValueError unless a user's piston has its modes in the bosses on the films' grid."""
    around, along, _ = load(ReducedBosses, path).boss_outward.shape[1:]
    if (around, along) != films.grid:
        raise ValueError(
            f"reduced: expected films of {films.grid[0]} x {films.grid[1]} cells in the bosses of "
            f"{path.name}, got {around} x {along}"
        )
