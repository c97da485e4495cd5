"""The importers that are installed here see the same result, each in a process of its own."""

from master.importers import try_importers


def test_importers_see_the_same(bodies_fmu):
    rows = {importer: seen for importer, _, _, seen in try_importers(bodies_fmu, "lateral_displacement")}
    assert rows["fmpy validate"] == "no problem"
    assert float(rows["fmpy in process"]) == float(rows["Python alone (ctypes)"])
