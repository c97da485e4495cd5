"""Requirements of an FMU on its Python, with the standard library only, before other imports.

As a script it reports to the C front: "library PATH<tab>EXECUTABLE", or the missing requirement.
"""

import importlib.util
import os
import sys
import sysconfig

PACKAGES = ("numpy", "scipy", "numba")


def missing():
    """Return a sentence with the missing requirement and its remedy; empty if there is none."""
    if sys.version_info < (3, 11):
        return "Python 3.11 or newer is needed, this is %d.%d" % sys.version_info[:2]
    absent = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
    if not absent:
        return ""
    return "%s missing; run: %s -m pip install %s" % (
        ", ".join(absent),
        sys.executable or "python3",
        " ".join(absent),
    )


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
