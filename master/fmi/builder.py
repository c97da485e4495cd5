"""Build an FMU from a participant package: its code under a content-made name, its data, its model description.

Two FMUs in one process share modules of equal name, so the embedded code lives in a package named after the hash of
everything that went in, and reaches itself by relative imports only.
"""

import hashlib
import importlib
import json
import os
import re
import sys
import tempfile
from pathlib import Path

import pythonfmu
from pythonfmu.builder import FmuBuilder

EMBEDDED = ("__init__", "errors", "variables", "description", "slave")
"""Modules of master.fmi that a running FMU needs."""

ENTRY = '''"""Entry script of the FMU; its code is the package {code}."""

import os
import shutil
import sys
import tempfile
from pathlib import Path


def code_folder():
    """A folder that stays where it is, with the code in it, so that what numba compiles is found again next time."""
    here = Path(__file__).parent
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    root = Path(os.environ.get("PISTON_COSIM_CACHE") or user / "piston-cosim") / "code"
    try:
        if not (root / "{code}").exists():
            root.mkdir(parents=True, exist_ok=True)
            partial = Path(tempfile.mkdtemp(dir=root))
            shutil.copytree(here / "{code}", partial / "{code}")
            os.rename(partial, root / "{code}")
    except OSError:
        pass  # another process was faster, or there is no writable cache
    return root / "{code}" if (root / "{code}").exists() else here


sys.path.insert(0, str(code_folder()))
from {code}.{package}.slave import {slave} as Fmi2Slave  # noqa: E402


class Entry(Fmi2Slave):
    """The class pythonfmu looks for by the text of this line."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
'''


def cache_folder(kind):
    """Folder of the user's cache for `kind` ("fmus", "unpacked", "bodies"), made if missing.

    The root is $PISTON_COSIM_CACHE, else $XDG_CACHE_HOME/piston-cosim, else ~/.cache/piston-cosim.
    """
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = Path(os.environ.get("PISTON_COSIM_CACHE") or user / "piston-cosim") / kind
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def build_fmu(package, options, folder, progress=lambda text: None):
    """FMU of a participant package, from the cache if the same was built before.

    Parameters
    ----------
    package : str
        Importable package with `build.prepare(options, folder, progress)` and a class in `slave` named after it
        (fmu_ehd: Ehd).
    options : dict
        Build options as the case file gives them (texts with units).
    folder : Path
        Folder that relative paths in the options start from.
    progress : callable
        Told a line of text before long work.

    Returns
    -------
    Path
        The FMU in the user's cache; its name holds the hash of its content.

    Raises
    ------
    BadInput
        With every fault of the options.
    """
    resolved, files = importlib.import_module(f"{package}.build").prepare(options, Path(folder), progress)
    sources = _sources(package)
    contents = {"build.json": json.dumps(resolved, sort_keys=True).encode()} | {f.name: f.read_bytes() for f in files}
    digest = _digest(sources | contents)
    fmu = cache_folder("fmus") / f"{package}-{digest}.fmu"
    if not fmu.exists():
        progress(f"packing {fmu.name}")
        _pack(package, f"code_{digest}", sources, contents, fmu)
    return fmu


def _sources(package):
    """Relative path -> bytes of all code the FMU carries, `master.fmi` imports turned into relative ones."""
    here = Path(__file__).parent
    home = Path(importlib.import_module(package).__file__).parent
    found = {f"fmi/{name}.py": here / f"{name}.py" for name in EMBEDDED}
    found |= {f"{package}/{path.relative_to(home).as_posix()}": path for path in sorted(home.rglob("*.py"))}
    return {name: re.sub(rb"(?m)^(\s*from) master\.fmi", rb"\1 ..fmi", path.read_bytes()) for name, path in found.items()}


def _digest(contents):
    digest = hashlib.sha256((pythonfmu.__version__ + ENTRY).encode())
    for name in sorted(contents):
        digest.update(name.encode() + b"\0" + hashlib.sha256(contents[name]).digest())
    return digest.hexdigest()[:16]


def _pack(package, code, sources, contents, fmu):
    """Lay the files out in a scratch folder, let pythonfmu zip them, and move the FMU into place in one go."""
    with tempfile.TemporaryDirectory() as scratch:
        root, entry = Path(scratch), Path(scratch) / f"{code}_entry.py"
        for name, data in ({f"{code}/__init__.py": b""} | {f"{code}/{n}": d for n, d in sources.items()} | contents).items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_bytes(data)
        entry.write_text(ENTRY.format(code=code, package=package, slave=package.removeprefix("fmu_").capitalize()))
        sys.path.insert(0, scratch)
        try:
            FmuBuilder.build_FMU(entry, dest=root / "out.fmu", project_files=[root / code, *(root / n for n in contents)],
                                 needsExecutionTool=False, canGetAndSetFMUstate=True, canSerializeFMUstate=True)
            partial = fmu.with_suffix(f".{os.getpid()}.part")
            partial.write_bytes((root / "out.fmu").read_bytes())
            os.replace(partial, fmu)
        finally:
            sys.path[:] = [p for p in sys.path if str(p) != scratch]
            for name in [n for n in sys.modules if n.startswith(code)]:
                del sys.modules[name]
