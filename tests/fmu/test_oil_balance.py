"""Oil that passes the edges of a film closes with the change in the film."""

import pytest

from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.engine.oil_balance import oil_balance

from .runs import run_tree


@pytest.mark.parametrize("supply", ["edges", "bore_and_ring"])
def test_net_flow_is_the_growth_of_the_film(supply, tmp_path):
    """The limit is 1 % of the throughput. A period of the fired engine is 720 deg."""
    path = find_case("data_sheet")
    tree = read_tree(
        path,
        [
            ("time.step", "5 deg"),
            ("record.fields", []),
            ("participants.ehd.parameters.oil_supply", supply),
            ("participants.ehd.parameters.stroke", "160 mm"),
            *((f"participants.{name}.build.grid", [16, 12]) for name in ("bodies", "ehd")),
        ],
    )
    with run_tree(path, tree, tmp_path / "run.h5") as results:
        oil = oil_balance(results, "ehd")
    assert oil is not None and oil.throughput > 0.0
    apart = oil.lower + oil.upper + oil.openings - oil.growth
    assert abs(apart) <= 0.01 * oil.throughput
