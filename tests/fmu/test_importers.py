"""The importers that are installed here see the same result, each in a process of its own."""

from piston_cosim.master.verification.importers import (
    NOT_INSTALLED,
    REFERENCE,
    SCRIPTS,
    judged,
    try_importers,
)


def test_importers_see_the_same(bodies_fmu):
    rows = judged(try_importers(bodies_fmu, "lateral_displacement"))
    assert {row[1] for row in rows} == set(SCRIPTS)
    assert [row for row in rows if row[0] == "FAIL"] == []
    verdicts = {importer: verdict for verdict, importer, *_ in rows}
    assert {
        verdicts[name] for name in ("fmpy in process", "fmpy simulate", "fmpy validate", REFERENCE)
    } == {"ok"}


def test_what_differs_or_fails_is_no_success():
    seen = {
        "fmpy in process": "1.5",
        REFERENCE: "1.0",
        "fmpy validate": "['x']",
        "Ecos": "failed (1): no",
        "PyFMI": NOT_INSTALLED,
        "libcosim": "1.00000000000001",
        "fmpy simulate": "refused: run: python -m pip install numpy",
    }
    verdicts = {
        importer: verdict
        for verdict, importer, *_ in judged((name, "1", "3", what) for name, what in seen.items())
    }
    assert {name for name, verdict in verdicts.items() if verdict == "FAIL"} == {
        "fmpy in process",
        "fmpy validate",
        "Ecos",
    }
    assert {name for name, verdict in verdicts.items() if verdict == "-"} == {
        "PyFMI",
        "fmpy simulate",
    }
