"""Phase, progress and faults of the reduction of a body for its FMU."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path

from ..master.fmi.cache import cache_folder
from ..master.fmi.errors import BadInput
from ..master.fmi.phases import phase
from .finite_elements.deck import MeshFault
from .options import RoundShell, SmallEnd
from .reduction.reduced_body import ShellFilm, ShellKind
from .reduction.store import kept_shell

Say = Callable[[str], None]
TYPICAL = 50.0
"""Time of a first reduction per megabyte of its mesh file [s]."""


@contextmanager
def reducing(name: str, mesh: str | None, progress: Say, table: str = "") -> Iterator[Say]:
    """Yield `say`. Its first message begins the phase: a cached body has no messages.

    Parameters
    ----------
    name : str
        Of the body, in the phase and in messages.
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
            phases.enter_context(phase(f"reducing {name}", megabytes, TYPICAL))

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
        Of the material [kg/m3].
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
        return kept_shell(options, density, film, kind, cache_folder("bodies"), say)
