"""One FMU under the master: fields by pointer, one step, saved states, directional derivatives, its log as text.

The only file that knows FMPy. Any object with the same methods can take part (`Participant` is the protocol).
"""

import ctypes
import shutil
import zipfile
from hashlib import sha256
from pathlib import Path
from typing import Protocol
from xml.etree import ElementTree

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

from .fmi.builder import cache_folder
from .fmi.description import VENDOR
from .fmi.errors import BadInput, Discard
from .fmi.fields import gather_fields

REAL = ctypes.POINTER(ctypes.c_double)
FAILED = (fmi2.fmi2Error, fmi2.fmi2Fatal)


class Participant(Protocol):
    """What the master needs of a participant; `fields` maps names to objects with the attributes of `Field`."""

    name: str
    fields: dict
    has_derivatives: bool

    def start(self, parameters, start_time, stop_time): ...
    def set(self, name, value): ...
    def get(self, name): ...
    def get_many(self, names): ...
    def step(self, time, step): ...
    def save(self): ...
    def restore(self, saved): ...
    def serialise(self, saved): ...
    def derivative(self, seeds, products):
        """Directional derivative of the last step.

        Parameters
        ----------
        seeds : dict of str to ndarray
            Change of input fields; inputs left out are zero.
        products : iterable of str
            Output fields whose change is wanted.

        Returns
        -------
        dict of str to ndarray
            Their change.
        """
        if not self._standard_derivative:
            return self._reserved_derivative(seeds)
        known, unknown = self._pair(tuple(seeds)), self._pair(tuple(products))
        for name, value in seeds.items():
            known["buffer"][known["slices"][name]] = np.ravel(value)
        self._fmu.fmi2GetDirectionalDerivative(self._fmu.component, unknown["references"], len(unknown["buffer"]),
                                               known["references"], len(known["buffer"]), known["pointer"], unknown["pointer"])
        return self._cut(unknown)

    def _pair(self, names):
        """References of several fields in one array, with a buffer; made once."""
        if names not in self._pairs:
            self._pairs[names] = _block({name: self.fields[name].references for name in names})
        return self._pairs[names]

    def _cut(self, block):
        return {name: block["buffer"][part].reshape(self.fields[name].shape).copy() for name, part in block["slices"].items()}

    def _reserved_derivative(self, seeds):
        """The same through the reserved references of an FMU without the standard call."""
        write, read = self._derivative["seed"], self._derivative["product"]
        write["buffer"][:] = 0.0
        for name, value in seeds.items():
            write["buffer"][write["slices"][name]] = np.ravel(value)
        self._fmu.fmi2SetReal(self._fmu.component, write["references"], len(write["buffer"]), write["pointer"])
        self._fmu.fmi2GetReal(self._fmu.component, read["references"], len(read["buffer"]), read["pointer"])
        return self._cut(read)

    def _reserved_references(self):
        """Reference arrays and buffers of all seeds and all products, from the FMU's vendor annotation."""
        with zipfile.ZipFile(self.path) as archive:
            root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        found = {}
        for kind in ("seed", "product"):
            nodes = root.findall(f"VendorAnnotations/Tool[@name='{VENDOR}']/DirectionalDerivative/{kind.capitalize()}")
            first = {node.get("name"): int(node.get("valueReference")) for node in nodes}
            if first:
                found[kind] = _block({name: range(k, k + self.fields[name].size) for name, k in first.items()})
        return found

    def close(self):
        """Terminate and free the instance."""
        if self._fmu is not None:
            self._fmu.terminate()
            self._fmu.freeInstance()
            self._fmu = None


def _block(references):
    """References of several fields (name -> sequence) in one C array, their places in it, and a buffer of values."""
    slices, together = {}, []
    for name, own in references.items():
        slices[name] = slice(len(together), len(together) + len(own))
        together += own
    buffer = np.zeros(len(together))
    return {"references": (ctypes.c_uint * len(together))(*together), "slices": slices, "buffer": buffer,
            "pointer": buffer.ctypes.data_as(REAL)}


def unpack(path):
    """Folder with the FMU's content in the user's cache, named by the file's hash."""
    digest = sha256(Path(path).read_bytes()).hexdigest()[:16]
    folder = cache_folder("unpacked") / f"{Path(path).stem}-{digest}"
    if not folder.exists():
        partial = folder.with_name(folder.name + ".part")
        shutil.rmtree(partial, ignore_errors=True)
        with zipfile.ZipFile(path) as archive:
            archive.extractall(partial)
        partial.rename(folder)
    return folder
