"""Requirements of an FMU on its Python, with the standard library only, before other imports.

As a script it reports to the C front: "library PATH<tab>EXECUTABLE", or the missing requirement.
"""

import importlib.util
import os
import subprocess
import sys
import sysconfig

PACKAGES = ("numpy", "scipy", "numba")
OTHER = "PISTON_COSIM_PYTHON"
REPORT = "import sys; print('%d.%d' % sys.version_info[:2], *sys.path, sep=chr(10))"
"""Script that prints the version and the path of a Python."""


def missing():
    """Return a sentence with the missing requirement and its remedy; empty if there is none."""
    if sys.version_info < (3, 11):
        return "Python 3.11 or newer is needed, this is %d.%d" % sys.version_info[:2]
    absent = _absent()
    if not absent:
        return ""
    return "%s missing; run: %s -m pip install %s" % (
        ", ".join(absent),
        sys.executable or "python3",
        " ".join(absent),
    )


def _absent():
    return [name for name in PACKAGES if importlib.util.find_spec(name) is None]


def missing_in_host():
    """Return `missing` after adding the packages of $PISTON_COSIM_PYTHON to a Python without them.

    Both must have the same version, because compiled packages fit one version only.
    """
    other = os.environ.get(OTHER)
    why = _borrow(other) if other and _absent() else ""
    lacking = missing()
    return "%s%s" % (lacking, why) if lacking else ""


def _borrow(other: str) -> str:
    """Add the packages of another Python to the path; return why that is not possible, or ""."""
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    try:
        answer = subprocess.run(
            [other, "-c", REPORT], capture_output=True, check=True, text=True, env=own
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        return "; %s: expected a Python, got %s" % (OTHER, other)
    version, *path = answer.splitlines()
    here = "%d.%d" % sys.version_info[:2]
    if version != here:
        return "; %s: expected Python %s as in this process, got %s" % (OTHER, here, version)
    sys.path += [folder for folder in path if folder.endswith("-packages")]
    importlib.invalidate_caches()
    return ""


def library():
    """Return the path of this Python's shared library, or None if it was built without one."""
    name = sysconfig.get_config_var("INSTSONAME") or ""
    folders = (sysconfig.get_config_var("LIBDIR") or "", os.path.join(sys.base_prefix, "lib"))
    libraries = [os.path.join(folder, name) for folder in folders]
    present = [path for path in libraries if ".so" in name and os.path.isfile(path)]
    return present[0] if present else None


if __name__ == "__main__":
    if missing():
        print(missing())
    elif not library():
        print("%s has no shared library (libpython3.%d.so)" % (sys.executable, sys.version_info[1]))
    else:
        print("library %s\t%s" % (library(), sys.executable))
