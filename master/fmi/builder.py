"""Build an FMU from a participant package: code, data and model description.

Two FMUs in one process share modules of equal name. The embedded package is therefore named
after the hash of its code, and it uses relative imports only. FMUs of the same code share it and
its compiled kernels. An FMU with participants inside also contains their codes.
"""

import hashlib
import importlib
import json
import os
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from importlib.metadata import version as version_of
from importlib.util import find_spec
from inspect import getfile
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, indent, tostring

from .cache import cache_folder
from .compiler import compile_front, compiler, front_sources
from .description import model_description
from .description3 import model_description_3, terminals
from .documentation import ICON, documentation
from .errors import BadInput
from .slave import STARTS, FieldSlave, Fmi2Slave
from .tree import ROOT, import_part, reached

Say = Callable[[str], object]

EMBEDDED = ("errors", "variables", "requirements", "slave", "tree", "compiled", "call_order")
"""Modules of master.fmi that a running FMU needs."""

OF_PYTHONFMU = ("_version", "default_experiment", "enums", "fmi2slave", "logmsg", "variables")
"""Modules of pythonfmu that a running FMU needs; its builder is not among them."""

PYTHONFMU = '''"""The part of pythonfmu, under its own licence, that a running slave needs."""

from ._version import __version__
from .default_experiment import DefaultExperiment
from .enums import Fmi2Causality, Fmi2Initial, Fmi2Variability
from .fmi2slave import Fmi2Slave
from .variables import Boolean, Integer, Real, String
'''
"""`__init__.py` of pythonfmu inside an FMU. FMUs of other tools in the same process share it, so
it has all names except those of the builder."""

PACKING = ("builder.py", "compiler.py", "description.py", "description3.py", "documentation.py")
"""Further files that determine the content of an FMU."""

TOKEN = "resources/token.txt"
"""File from which the front reads the identifier that the importer must pass."""

ENTRY = '''"""Entry script of the FMU; its code is the first of these packages."""

import ctypes
import os
import shutil
import sys
import tempfile
from importlib import import_module
from pathlib import Path

CODES = {codes}

# pythonfmu's library drops one reference too many to this module's dictionary at each run
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


def folder_of(code):
    """Return a permanent folder with the code, so that numba's cache of it remains valid."""
    here = Path(__file__).parent
    named = os.environ.get("PISTON_COSIM_CACHE")
    user = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    if not named and not os.path.isabs(user):
        return here  # no HOME, and a user without an entry
    root = Path(named or Path(user, "piston-cosim")) / "code"
    try:
        if not (root / code).exists():
            root.mkdir(parents=True, exist_ok=True)
            partial = Path(tempfile.mkdtemp(dir=root))
            shutil.copytree(here / code, partial / code)
            os.rename(partial / code, root / code)
            partial.rmdir()
    except OSError:
        pass  # another process was faster, or there is no writable cache
    return root if (root / code).exists() else here


for code in CODES:
    if code in sys.modules:
        continue
    sys.path.insert(0, str(folder_of(code)))
    try:
        if lacking := import_module(f"{{code}}.master.fmi.requirements").missing_in_host():
            raise ImportError(lacking)
        import_module(f"{{code}}.master.fmi.tree")
    finally:
        sys.path.pop(0)
Fmi2Slave = sys.modules[f"{{CODES[0]}}.master.fmi.tree"].slave_class("{slave}")
if not {any_host}:  # the library does not check the order of calls
    Fmi2Slave = import_module(f"{{CODES[0]}}.master.fmi.call_order").in_order(Fmi2Slave)


class Entry(Fmi2Slave):
    """Class that pythonfmu finds by the text of this line."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
'''


class Code(NamedTuple):
    """Code of a model class inside an FMU.

    name : package name, the hash of its content; slave : "module:class" in the package; files :
    content by path in the package.
    """

    name: str
    slave: str
    files: dict[str, bytes]


def slave_of(package: str) -> str:
    """Return the model class of a participant package as "module:class".

    fmu_ehd -> fmu_ehd.slave:Ehd, fmu_mfbd.monoblock -> fmu_mfbd.monoblock.slave:Monoblock.
    """
    *_, last = package.split(".")
    return f"{package}.slave:{last.removeprefix('fmu_').capitalize()}"


def code_of(package: str) -> Code:
    """Return the code that the model class of a participant package needs.

    For a part of this project it is the module and all its imports, for others the package.
    """
    own = import_part(package).__name__.startswith(f"{ROOT}.")
    return code_with(slave_of(package), f"{package}.slave" if own else package)


def code_with(slave: str, part: str) -> Code:
    """Return the code that the model class "module:class" needs.

    `part` is a package, or a module by its path in the project ("master.coupling.coupled"). The
    required modules of `master.fmi` are added automatically.
    """
    paths: dict[str, Path] = {}
    for name in (*(f"master.fmi.{module}" for module in EMBEDDED), part):
        paths |= _files(name)
    files = {name: path.read_bytes() for name, path in paths.items()}
    digest = _digest(files | {"entry": (ENTRY + slave).encode()})
    return Code(f"code_{digest}", slave, files)


def build_fmu(
    package: str,
    options: Mapping[str, Any],
    folder: Path | str,
    progress: Say = lambda text: None,
    version: str = "2.0",
    *,
    experiment: Any = None,
    starts: Mapping[str, Any] | None = None,
) -> Path:
    """Return the FMU of a participant package, from the cache if it was built before.

    Parameters
    ----------
    package : str
        Part of the project or importable package, with `build.prepare(options, folder, progress)`
        and a class in `slave` named after it (fmu_ehd: Ehd).
    options : dict
        Build options as in the case file (texts with units).
    folder : Path
        Folder of relative paths in the options.
    progress : callable
        Called with a message before long work.
    version : {"2.0", "3.0"}
        Version of FMI. 3.0 needs a C compiler.
    experiment : Experiment, optional
        Default experiment in the description. Default: that of the model class.
    starts : dict of str to number or str, optional
        Start values in SI by variable. Default: those of the model class.

    Returns
    -------
    Path
        The FMU in the user's cache. Its name contains the hash of its content.

    Raises
    ------
    BadInput
        With every fault of the options.
    """
    resolved, files = import_part(f"{package}.build").prepare(options, Path(folder), progress)
    return pack_fmu(
        package,
        code_of(package),
        resolved,
        {f.name: f.read_bytes() for f in files} | starts_file(starts),
        progress,
        version,
        experiment=experiment,
    )


def starts_file(starts: Mapping[str, Any] | None) -> dict[str, bytes]:
    """Return the resource with the start values, none if there are none."""
    return {STARTS: json.dumps(starts, sort_keys=True).encode()} if starts else {}


def build_fmu_of_file(
    origin: str, options: Mapping[str, Any], progress: Say = lambda text: None, version: str = "2.0"
) -> Path:
    """Return the FMU of a single-file model class, from the cache if it was built before.

    Parameters
    ----------
    origin : str
        "path/to/file.py:Class".
    options : dict
        Content of build.json, the argument of `variables(options)`.

    Raises
    ------
    BadInput
        If the file or the class does not exist.
    """
    file, _, slave = origin.rpartition(":")
    path = Path(file)
    if path.suffix != ".py" or not path.is_file():
        raise BadInput(f"file: expected an existing FILE.py:CLASS, got {origin!r}")
    sys.path.insert(0, str(path.resolve().parent))
    try:
        try:
            module = importlib.import_module(path.stem)
        except Exception as error:  # the user's code raises whatever it likes
            raise BadInput(f"file: expected code that can be imported, got {error}") from error
        model = getattr(module, slave, None)
        if not (isinstance(model, type) and issubclass(model, Fmi2Slave)):
            raise BadInput(f"file: expected a class of {path.name} from Slave, got {slave!r}")
        code = code_with(f"{path.stem}:{slave}", path.stem)
        return pack_fmu(path.stem, code, options, {}, progress, version)
    finally:
        sys.path.pop(0)


def pack_fmu(
    name: str,
    code: Code,
    options: Mapping[str, Any],
    files: Mapping[str, bytes],
    progress: Say,
    version: str = "2.0",
    *,
    participants: Iterable[Code] = (),
    experiment: Any = None,
) -> Path:
    """Return the FMU of a model class, from the cache if it was packed before.

    Parameters
    ----------
    name : str
        First part of the file name.
    code : Code
    options : dict
        Content of build.json.
    files : dict of str to bytes
        Further resources.
    participants : iterable of Code
        Codes of the models inside this one. They are the same packages as in their separate FMUs,
        so both share compiled kernels.
    experiment : Experiment, optional
        Default experiment in the description. Default: that of the model class.
    """
    if version == "3.0" and not compiler():
        raise BadInput("fmi: expected a C compiler, cc or $CC, for FMI 3.0, got none")
    codes = {one.name: one for one in (code, *participants)}
    contents = {"build.json": json.dumps(options, sort_keys=True).encode(), **files}
    front = front_sources(version) if compiler() else {"stock": version_of("pythonfmu").encode()}
    packing = {name: (Path(__file__).parent / name).read_bytes() for name in PACKING}
    packing["version"] = version_of("piston-cosim").encode()
    packing["experiment"] = repr(experiment).encode()
    packing["codes"] = repr(list(codes)).encode()
    _remember_python()

    def members() -> dict[str, bytes]:
        any_host = bool(compiler())
        entry = ENTRY.format(codes=tuple(codes), slave=code.slave, any_host=any_host).encode()
        module = "_".join([*codes, "entry"])  # another one in FMUs with other participants
        whole = {
            f"{one.name}/{path}": data for one in codes.values() for path, data in one.files.items()
        }
        whole |= contents | {
            f"{module}.py": entry,
            "slavemodule.txt": module.encode(),
            "requirements.py": code.files["master/fmi/requirements.py"],
            "pythonfmu/__init__.py": PYTHONFMU.encode(),
        }
        whole |= {
            f"pythonfmu/{name}.py": (_pythonfmu() / f"{name}.py").read_bytes()
            for name in OF_PYTHONFMU
        }
        return _members(whole, module, version, experiment)

    return packed_once(name, contents | front | packing, members, progress)


def _remember_python() -> None:
    """Save the path of this Python in the user's cache, for the fronts on this machine."""
    with suppress(OSError):
        (cache_folder("") / "python.txt").write_text(sys.executable)


def _files(name: str) -> dict[str, Path]:
    """Return the files of a package, or of a module and its imports in the project, by path.

    The `__init__.py` of the packages around them are included.
    """
    part = import_part(name)
    home = Path(getfile(part))
    around = Path(getfile(sys.modules[ROOT])).parent.resolve()
    if home.name == "__init__.py":
        top = home.parents[name.count(".") + 1]
        files = {path.relative_to(top).as_posix(): path for path in home.parent.rglob("*.py")}
    elif part.__name__.startswith(f"{ROOT}."):
        files = {path.relative_to(around).as_posix(): path for path in reached(home.resolve())}
    else:
        files = {home.name: home}
    packages = {
        f"{folder.as_posix()}/__init__.py" for file in files for folder in Path(file).parents
    }
    packages.discard("./__init__.py")
    rooms = {package: around / package for package in packages if (around / package).is_file()}
    return rooms | files | {"__init__.py": around / "__init__.py"}


def _pythonfmu() -> Path:
    """Return the folder of pythonfmu, without the import that takes a tenth of a start."""
    spec = find_spec("pythonfmu")
    assert spec is not None and spec.origin is not None, "pythonfmu is not installed"
    return Path(spec.origin).parent


def _digest(contents: Mapping[str, bytes]) -> str:
    digest = hashlib.sha256(version_of("pythonfmu").encode())
    for name in sorted(contents):
        digest.update(name.encode() + b"\0" + hashlib.sha256(contents[name]).digest())
    return digest.hexdigest()[:16]


def packed_once(
    name: str,
    made_of: Mapping[str, bytes],
    members: Callable[[], Mapping[str, bytes]],
    progress: Say,
) -> Path:
    """Return an FMU from the cache, written if there is none of this name and content.

    Parameters
    ----------
    name : str
        First part of the file name.
    made_of : dict of str to bytes
        All that determines the content.
    members : callable
        Returns the content by path.
    progress : callable
        Called with a message before the FMU is written.
    """
    fmu = cache_folder("fmus") / f"{name}-{_digest(made_of)}.fmu"
    if not fmu.exists():
        whole = members()
        progress(f"packing {fmu.name}")
        write_archive(whole, fmu)
    return fmu


def _members(
    contents: Mapping[str, bytes], entry: str, version: str, experiment: Any
) -> dict[str, bytes]:
    """Lay out the resources in a scratch folder, describe the model, and return all by path."""
    with tempfile.TemporaryDirectory() as scratch:
        for name, data in contents.items():
            path = Path(scratch) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        slave = _instance(entry, scratch)
        slave.experiment = experiment or slave.experiment
        members = _binaries(slave, version) | texts_of(slave, version, any_host=bool(compiler()))
    return members | {f"resources/{name}": data for name, data in contents.items()}


def write_archive(members: Mapping[str, bytes], fmu: Path) -> None:
    """Write an FMU from `members` (path to bytes), and rename it when it is complete."""
    partial = fmu.with_suffix(f".{os.getpid()}.part")
    with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(members):
            info = zipfile.ZipInfo(name)  # the same date in every build
            info.external_attr = (0o755 if name.endswith((".so", ".dll")) else 0o644) << 16
            archive.writestr(info, members[name], zipfile.ZIP_DEFLATED)
    os.replace(partial, fmu)


def _binaries(slave: FieldSlave, version: str) -> dict[str, bytes]:
    """Return the front, or if there is no compiler, the libraries of pythonfmu for Python hosts."""
    if version == "3.0":
        return {f"binaries/x86_64-linux/{slave.name}.so": compile_front("3.0")}
    if compiler():
        return {f"binaries/linux64/{slave.name}.so": compile_front("2.0")}
    return {
        f"binaries/{path.parent.name}/{slave.name}{path.suffix}": path.read_bytes()
        for path in (_pythonfmu() / "resources" / "binaries").rglob("*.*")
    }


def texts_of(
    slave: FieldSlave,
    version: str,
    any_host: bool,
    platforms: Sequence[str] = (),
    sums: str = "",
) -> dict[str, bytes]:
    """Return description, token, icon and documentation of an FMU, path to bytes.

    The arguments are those of `documentation` and `model_description`.
    """
    pages = documentation(slave, version, any_host, platforms)
    if version == "3.0":
        description = model_description_3(slave, platforms, sums)
        return pages | {
            "modelDescription.xml": _xml(description),
            TOKEN: description.attrib["instantiationToken"].encode(),
            "terminalsAndIcons/terminalsAndIcons.xml": _xml(terminals(slave)),
            "terminalsAndIcons/icon.png": ICON.read_bytes(),
        }
    description = model_description(slave, any_host, platforms, sums)
    return pages | {
        "modelDescription.xml": _xml(description),
        TOKEN: description.attrib["guid"].encode(),
        "model.png": ICON.read_bytes(),
    }


def _xml(root: Element) -> bytes:
    indent(root, "\t")
    return tostring(root, encoding="UTF-8", xml_declaration=True)


def _instance(entry: str, resources: str) -> Any:
    """Return an instance of the packed model class, and remove its modules from this process."""
    before = set(sys.modules)
    sys.path.insert(0, resources)
    try:
        return importlib.import_module(entry).Entry(
            instance_name="description", resources=resources
        )
    finally:
        sys.path.remove(resources)
        for name in set(sys.modules) - before:
            if name.startswith("code_"):
                del sys.modules[name]
