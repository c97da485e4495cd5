"""Reduce the bodies of shipped cases and write them to models/bodies, without shapes on the mesh.

    python .ci/bodies.py [CASE ...]     # default: all cases

It keeps existing files: delete models/bodies to renew it. The repository contains the bodies of
numerical_example, a release those of all cases.
"""

import os
import sys
import tempfile
import zipfile
from dataclasses import fields
from pathlib import Path

import numpy as np

from piston_cosim.fmu_mfbd.reduction.reduced_body import Anatomy
from piston_cosim.fmu_mfbd.reduction.store import SHIPPED
from piston_cosim.master.api.cases import open_case
from piston_cosim.master.case.reading import case_names
from piston_cosim.master.fmi.tree import import_part

BITS = 18
"""Bits of the largest value of the shapes that the modes leave out. They halve the file and change
the estimated errors of the modes by less than 1e-5 of their value."""


def rounded(name: str, values: np.ndarray) -> np.ndarray:
    """Return an array of a body, rounded to BITS if it contains shapes that the modes leave out."""
    if not name.startswith("left_") or not values.any():
        return values
    unit = 2.0 ** (np.ceil(np.log2(np.abs(values).max())) - BITS)
    return (np.round(values / unit) * unit).astype(values.dtype)


def ship(path: Path) -> None:
    """Write a cached body to models/bodies, without mesh and mode shapes."""
    left_out = {one.name for one in fields(Anatomy)}
    target = SHIPPED / f"{path.stem.rpartition('-')[0]}.npz"
    with np.load(path) as arrays, zipfile.ZipFile(target, "w") as file:
        for name in sorted(set(arrays.files) - left_out):
            member = zipfile.ZipInfo(f"{name}.npy")  # with a fixed date
            member.compress_type = zipfile.ZIP_LZMA
            with file.open(member, "w") as stream:
                np.lib.format.write_array(stream, rounded(name, arrays[name]), allow_pickle=False)
    print(f"{target.name}: {target.stat().st_size / 1e6:.2f} MB")


def main(names: list[str]) -> None:
    SHIPPED.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as cache:
        os.environ["PISTON_COSIM_CACHE"] = cache
        for name in names or case_names():
            case = open_case(name)
            for variant in map(case.variant, case.variants):
                for table in variant.tree["participants"].values():
                    package = table.get("package", "")
                    if package.startswith("fmu_mfbd"):
                        build = import_part(f"{package}.build")
                        build.prepare(table.get("build", {}), case.path.parent, print)
        for path in sorted(Path(cache, "bodies").glob("*.npz")):
            ship(path)


if __name__ == "__main__":
    main(sys.argv[1:])
