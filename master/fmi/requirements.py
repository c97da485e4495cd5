"""What an FMU needs of the Python it runs in. Standard library alone: this is asked before anything
else is imported.

Run as a script it answers the C front: "library PATH<tab>EXECUTABLE", or a sentence saying what is
missing.
"""

import importlib.util
import os
import sys
import sysconfig

PACKAGES = ("numpy", "scipy", "numba")


def missing():
    """Sentence saying what this Python lacks and how to mend it; empty if nothing."""
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
    """Path of this Python's shared library, or None (an interpreter built without one cannot be
    embedded).
    """
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
