"""piston_cosim: elastohydrodynamic lubrication of flexible pistons as an FMI co-simulation.

    import piston_cosim as pc

    case = pc.open_case("numerical_example", {"participants.ehd.parameters.viscosity": "20 mPa s"})
    results = case.run()
    results.plot.lines("ehd.minimum_film_thickness", units={"ehd.minimum_film_thickness": "um"})

Cases       open_case, Case, sweep, sensitivities
Results     open_results, Results
Parts       Film, bearing, reduce_bodies
Own models  Slave, variables, couple
FMUs        build_fmu, open_fmu
Citation    cite
Errors      BadInput, Discard, StepFailed

Each is imported when it is first used. This folder is the installed package. Its subpackages:

    fmu_ehd     lubrication: films, without bodies and coupling
    fmu_mfbd    flexible bodies, without films and coupling
    master      coupling: participants and signals, without films and bodies
    models      cases and data

The three parts share only `master.fmi`. All imports inside the project are relative, so that an FMU
can contain the same tree under another name.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .fmu_ehd.alone import Film
    from .fmu_ehd.bearing import bearing
    from .master.api.bodies import reduce_bodies
    from .master.api.cases import Case, open_case, sweep
    from .master.api.cite import cite
    from .master.api.coupled import couple
    from .master.api.design import sensitivities
    from .master.api.fmus import build_fmu, open_fmu
    from .master.coupling.stepping import StepFailed
    from .master.fmi import variables
    from .master.fmi.errors import BadInput, Discard
    from .master.fmi.slave import FieldSlave as Slave
    from .master.results.file import Results, open_results

    __version__: str

__all__ = [
    "BadInput",
    "Case",
    "Discard",
    "Film",
    "Results",
    "Slave",
    "StepFailed",
    "bearing",
    "build_fmu",
    "cite",
    "couple",
    "measures",
    "open_case",
    "open_fmu",
    "open_results",
    "reduce_bodies",
    "sensitivities",
    "sweep",
    "variables",
]

_PLACES = {
    "BadInput": "master.fmi.errors",
    "Case": "master.api.cases",
    "Discard": "master.fmi.errors",
    "Film": "fmu_ehd.alone",
    "Results": "master.results.file",
    "Slave": "master.fmi.slave:FieldSlave",
    "StepFailed": "master.coupling.stepping",
    "bearing": "fmu_ehd.bearing",
    "build_fmu": "master.api.fmus",
    "cite": "master.api.cite",
    "couple": "master.api.coupled",
    "measures": "master.api.measures",
    "open_case": "master.api.cases",
    "open_fmu": "master.api.fmus",
    "open_results": "master.results.file",
    "reduce_bodies": "master.api.bodies",
    "sensitivities": "master.api.design",
    "sweep": "master.api.cases",
    "variables": "master.fmi.variables:",
}
"""Public name -> module, or module:name in it; module: for the module itself."""


def __getattr__(name: str) -> Any:
    """Import a public name at its first use; `__version__` is that of the installation."""
    if name == "__version__":
        from importlib.metadata import version

        return version("piston-cosim")
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import gc
    from importlib import import_module

    place, colon, inside = _PLACES[name].partition(":")
    collects = gc.isenabled()
    gc.disable()  # modules are permanent: scanning them takes a tenth of an import
    try:
        module = import_module(f"{__name__}.{place}")
    finally:
        if collects:
            gc.enable()
    value = module if colon and not inside else getattr(module, inside or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
