"""Libraries of native FMUs for all platforms, into the checkout's package: what a wheel brings."""

from piston_cosim.master.fmi.builder_native import (
    AHEAD,
    FRONTS,
    ITERATING,
    ITERATION,
    PLATFORMS,
    libraries,
    library_name,
)

SLAVES = (("fmu_ehd",), ("fmu_mfbd",), ("master.coupling", "fmu_ehd", "fmu_mfbd"))
OF_THE_MASTER = [name for name in PLATFORMS if name != "win64"]  # it runs on POSIX systems
MADE = [(packages, version, list(PLATFORMS)) for packages in SLAVES for version in FRONTS]
MADE.append(((ITERATING,), ITERATION, OF_THE_MASTER))

AHEAD.mkdir(exist_ok=True)
for packages, version, platforms in MADE:
    for platform, library in libraries(packages, platforms, version, print).items():
        name = library_name(packages, platform, version)
        (AHEAD / name).write_bytes(library)
        print(f"{name}: {len(library) / 1e3:.0f} kB")
