"""Oil that passes the edges of a film in a period, and its change in the film."""

from typing import NamedTuple

import numpy as np

from ..results.file import Results


class OilBalance(NamedTuple):
    """Oil volumes of the last period [m3].

    lower, upper, openings : net inflow through both edges and the cut-outs; throughput : the
    larger one of the volumes that enter and that leave; growth : change of the oil in the film.
    """

    lower: float
    upper: float
    openings: float
    throughput: float
    growth: float


def oil_balance(results: Results, film: str) -> OilBalance | None:
    """Return the oil of the last period; None if the run has no whole period or lacks the outputs.

    Eq. (X24):  V = sum over steps of H q,   q the flow at the end of the step, as the film solves
                lower + upper + openings = growth

    Parameters
    ----------
    results : Results
    film : str
        Participant with the role `lubrication`.
    """
    last = results.last
    names = ("flow_lower_edge", "flow_upper_edge", "flow_openings", "oil_in_film")
    ports = [f"{film}.{name}" for name in names]
    begin, *_, end = last.time
    whole = last.period and end - begin > last.period * (1.0 - 1e-6)
    if not whole or not {*ports} <= {*last.ports}:
        return None
    *flows, content = (last.series(port).values for port in ports)
    volumes = np.diff(last.time) * np.array(flows)[:, 1:]  # Eq. (X24)
    through = max(volumes.clip(min=0.0).sum(), -volumes.clip(max=0.0).sum())
    lower, upper, openings = volumes.sum(axis=1)
    return OilBalance(*map(float, (lower, upper, openings, through, content[-1] - content[0])))
