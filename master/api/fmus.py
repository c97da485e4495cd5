"""Building and loading of FMUs."""

import logging
import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..case.ahead import ahead
from ..case.checked import check_case
from ..case.export import experiment_ahead
from ..case.given import build_options
from ..case.symmetry import symmetry_faults
from ..fmi import builder, builder_native
from ..fmi.errors import BadInput, Discard, unknown
from ..participants import open as opening
from .cases import Case, open_case

log = logging.getLogger("piston_cosim")


def build_fmu(
    source: Case | str | Path,
    participant: str | None = None,
    *,
    output: str | Path | None = None,
    options: Mapping[str, Any] | None = None,
    fmi: Literal["2.0", "3.0"] = "2.0",
    platforms: Sequence[str] = (),
    say: Callable[[str], object] = log.info,
) -> Path:
    """Return the FMU of one participant of a case, or of a single-file model class.

    Parameters
    ----------
    source : Case, str or Path
        A case, or "FILE.py:CLASS". The FMU starts with the values of the case, see `open_case`
        for its variants and for changes.
    participant : str, optional
        Its name in the case. If omitted, `source` is a file.
    output : path, optional
        Path of the FMU. Default: in the user's cache.
    options : mapping, optional
        Build options that replace those of the case ({"grid": [60, 30]}, for all participants that
        have them). For a file, the argument of its `variables(options)`.
    fmi : {"2.0", "3.0"}
        Version of FMI. 3.0 needs a C compiler.
    platforms : sequence of str
        Platforms of a native FMU that needs no Python: "linux64", "win64", "aarch64-linux",
        "darwin64", "aarch64-darwin". Each one needs a C compiler, unless its library is prebuilt.
        If empty, the FMU runs in Python.
    say : callable
        Called with a message before long work.

    Returns
    -------
    Path

    Raises
    ------
    BadInput
        With every fault of the options, or if there is no such participant, file or class.

    Examples
    --------
    >>> path = pc.build_fmu("data_sheet", "ehd", options={"grid": [16, 8]}, output="film.fmu")
    >>> path.name
    'film.fmu'
    """
    if participant is None:
        if platforms:
            raise BadInput(f"{source}: expected a case for a native FMU, got a single file")
        built = builder.build_fmu_of_file(str(source), dict(options or {}), say, fmi)
    else:
        case = source if isinstance(source, Case) else open_case(source)
        built = _of_case(case, participant, options or {}, fmi, platforms, say)
    if not platforms:
        compile_code(built, say)
    if output is None:
        return built
    return Path(shutil.copyfile(built, output))


def compile_code(path: Path, say: Callable[[str], object]) -> None:
    """Start an FMU and take a step of its default experiment, to cache its compiled code.

    Later starts of FMUs with the same code then take less time. An FMU whose default values are not
    valid is not compiled, and the message says why.

    Parameters
    ----------
    path : Path
        An FMU of this tool.
    say : callable
        Called with a message first.
    """
    say(f"starting {path.name} once: code that is new here is compiled, about a minute")
    one = opening.open_fmu("fmu", path)
    usual = one.description.defaultExperiment  # the builder writes both times
    try:
        one.start({}, 0.0, float(usual.stopTime))
        one.step(0.0, float(usual.stepSize))
    except (BadInput, Discard) as error:
        why, *_ = str(error).strip().splitlines() or [type(error).__name__]
        say(f"warning: {path.name} does not start with its default values: {why}")
    finally:
        one.close()


def _of_case(
    case: Case,
    participant: str,
    options: Mapping[str, Any],
    fmi: str,
    platforms: Sequence[str],
    say: Callable[[str], object],
) -> Path:
    """Return the FMU of a case's participant with some build options replaced.

    Its start values are those of the case.
    """
    checked, folder = check_case(case.tree, case.path), case.path.parent
    buildable = [name for name, table in checked.participants.items() if table.package]
    if participant not in buildable:
        raise BadInput(f"participant: {unknown('participant', participant, buildable)}")
    for name, table in checked.participants.items():
        shared = options.keys() if name == participant else options.keys() & table.build.keys()
        table.build |= {key: options[key] for key in shared}
    table: Any = checked.participants[participant]
    package: Any = table.package
    if platforms:  # first, because other faults may follow from these
        builder_native.check_native(package, table.build, folder, say, platforms)
    declared = ahead(checked, folder)
    if table.parameters and participant not in declared.parameters and not declared.faults:
        declared.faults.append(
            f"participants.{participant}.parameters: expected a package with declared_variables, "
            f"got {table.package}"
        )
    if faults := declared.faults + symmetry_faults(checked, folder, declared):
        raise BadInput(faults)
    starts = {
        name: np.ravel(value).tolist()
        for name, value in declared.parameters.get(participant, {}).items()
    }
    build = build_options(checked, folder, say)[participant]
    make = (
        partial(builder_native.build_native_fmu, platforms=platforms)
        if platforms
        else builder.build_fmu
    )
    experiment = experiment_ahead(checked, folder)
    return make(package, build, folder, say, fmi, experiment=experiment, starts=starts)


def open_fmu(path: str | Path, name: str = "fmu") -> Any:
    """Return an FMU of either version of the standard, to step it yourself.

    Parameters
    ----------
    path : str or Path
        An FMI 2.0 or 3.0 FMU for co-simulation.
    name : str
        Its name in error messages.

    Returns
    -------
    Participant
        `fields` (name -> unit, causality, shape, allowed range, description);
        `start(parameters, start_time, stop_time)`; `set(name, value)`, `get(name)` with whole
        arrays; `step(time, step)`; `save()`, `restore(state)`; `derivative(seeds, products)` if
        `has_derivatives`; `close()`. Values have the units that the FMU declares.

    Raises
    ------
    BadInput
        If there is no such file, or it is not an FMU for co-simulation.

    Examples
    --------
    >>> film = pc.open_fmu(pc.build_fmu("data_sheet", "ehd", options={"grid": [16, 8]}))
    >>> film.fields["film_thickness"].shape, film.fields["film_thickness"].unit
    ((16, 8), 'm')
    >>> film.start({"viscosity": 0.01}, 0.0, 1.0)
    >>> film.set("sliding_velocity", np.full((16, 8), 2.0))
    >>> film.step(0.0, 1e-4)
    >>> bool(film.get("friction_power") > 0.0)
    True
    >>> film.close()
    """
    path = Path(path)
    if not path.is_file():
        raise BadInput(f"{path}: expected an FMU, got no such file")
    return opening.open_fmu(name, path)
