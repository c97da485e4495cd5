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
MADE = [*((packages, version) for packages in SLAVES for version in FRONTS)]
MADE.append(((ITERATING,), ITERATION))

AHEAD.mkdir(exist_ok=True)
for packages, version in MADE:
    for platform, library in libraries(packages, list(PLATFORMS), version, print).items():
        name = library_name(packages, platform, version)
        (AHEAD / name).write_bytes(library)
        print(f"{name}: {len(library) / 1e3:.0f} kB")
