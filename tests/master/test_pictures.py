"""Pictures of runs, also of fields that are the same everywhere."""

from types import SimpleNamespace

import numpy as np
import pytest
from piston_cosim.master.results.pictures import draw_maps


@pytest.mark.parametrize(
    "field, lines", [(np.ones((5, 4)), False), (np.arange(20.0).reshape(5, 4), True)]
)
def test_a_map_has_contours_where_there_is_something_to_contour(field, lines):
    results = SimpleNamespace(field=lambda port, instant: (field, 0.0, "1", "film fraction"))
    picture = SimpleNamespace(fields=["ehd.film_fraction"], time="0 s", units={})
    panel = draw_maps(picture, {"flexible": results}).axes[0]
    drawn = [
        len(path.vertices) for collection in panel.collections for path in collection.get_paths()
    ]
    assert len(panel.images) == 1 and (sum(drawn) > 0) == lines
