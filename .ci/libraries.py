"""Build the libraries of native FMUs for all platforms in the package folder of this checkout."""

from piston_cosim.master.fmi.builder_native import FRONTS, PREBUILT, libraries, library_name
from piston_cosim.master.fmi.compiler import PLATFORMS, newer_symbols

# all packages are compiled side by side for the first entry, and cached for the others
MODELS = (("master.coupling", "fmu_ehd", "fmu_mfbd"), ("fmu_ehd",), ("fmu_mfbd",))
BUILDS = [(packages, version) for packages in MODELS for version in FRONTS]

PREBUILT.mkdir(exist_ok=True)
for packages, version in BUILDS:
    for platform, library in libraries(packages, list(PLATFORMS), version, print).items():
        name = library_name(packages, platform, version)
        if newer := newer_symbols(library):
            raise SystemExit(f"{name}: expected symbols up to GLIBC_2.17, got {', '.join(newer)}")
        (PREBUILT / name).write_bytes(library)
        print(f"{name}: {len(library) / 1e3:.0f} kB")
