"""piston_cosim: elastohydrodynamic lubrication of flexible pistons as an FMI co-simulation.

This folder is the installed package. Its rooms:

    fmu_ehd     lubrication: knows films; no bodies, no coupling
    fmu_mfbd    flexible bodies: knows bodies; no films, no coupling
    master      coupling: knows participants and signals, neither films nor bodies
    models      cases and data

The three parts meet in `master.fmi` alone. Inside the project every import is relative, so that an
FMU can carry the same tree under a name of its own.
"""


def __getattr__(name):
    """`__version__`, asked of the installation when it is wanted: a tree inside an FMU has none."""
    if name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib.metadata import version

    return version("piston-cosim")
