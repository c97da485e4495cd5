"""Conditions of a run on the first screen of a report."""

from types import SimpleNamespace

from piston_cosim.master.engine.overview import conditions


def test_conditions_name_the_hot_surfaces():
    build = {"piston": {"modes": 0, "hot_shape": {}}, "block": {"temperature_field": {}}}
    tables = {"bodies": {"build": build}, "ehd": {}}
    results = SimpleNamespace(case={"participants": tables}, summary={})
    assert conditions(results, ["ehd"]) == ["hot shape of skirt and bore"]
    del build["block"]["temperature_field"]
    assert conditions(results, ["ehd"]) == ["hot shape of skirt"]
