"""Main results of a run with their uncertainties, in Python."""

from ..case.checked import check_case
from ..engine.measures import Measure
from ..engine.measures import measures as measures_of
from ..results.file import Results


def measures(results: Results) -> dict[str, Measure]:
    """Return the main results of the last period of a run, by name.

    A name has the key and the participant, such as `minimum_film_thickness_m_ehd`. A measure has
    `value` in the SI unit `unit`, `uncertainty.value`, its largest part `uncertainty.contributor`,
    and `text` with both. If the uncertainty is unknown, its value is None and
    `uncertainty.reason` says why.

    Parameters
    ----------
    results : Results

    Returns
    -------
    dict of str to Measure

    Examples
    --------
    >>> results = pc.open_case("two_mass_oscillator").changed({"time.stop": "0.03 s"}).run()
    >>> pc.measures(results)  # it has no film
    {}
    """
    case = check_case(results.case, results.path.parent)
    return {one.name: one for one in measures_of(case, results).all}
