"""The results of a run: read, labelled, drawn."""

from pathlib import Path
from typing import TYPE_CHECKING

from ..fmi.errors import BadInput
from .recorded import Recorded

if TYPE_CHECKING:
    import pandas
    import xarray

    from .plots import Plots


class Results(Recorded):
    """What a run has recorded, as arrays in SI with their units; `with` closes the file.

    Of a run that ends once it is periodic the last period alone is shown, or as many as
    `record.periods` says. Time and what turns, such as a crank angle, are then counted as if the
    run had begun with the first one shown. `whole` shows all, `last` the last period.

    Parameters
    ----------
    path : str or Path
        A results file, also one whose run goes on (`.partial`). A port is text,
        "participant.variable".

    Attributes
    ----------
    time : ndarray, shape (rows,)
        End of every macro step, the start first [s].

    Examples
    --------
    >>> results = pc.open_case("two_mass_oscillator", {"time.stop": "0.02 s"}).run()
    >>> results.ports[:2]
    ['coupling.derivative_products', 'coupling.iterations']
    >>> values, unit, meaning = results.series("left.displacement")
    >>> values.shape, unit, meaning
    ((3,), 'm', 'Displacement of the mass')
    >>> results.summary["steps"]
    2
    """

    def to_xarray(self) -> "xarray.Dataset":
        """All that was recorded with named dimensions; needs the extra `xarray`.

        Scalars lie along `time` [s], fields along `instant` [s] and what the case says of their
        indices (of a skirt: `angle` around it [deg], `height` over its length [-]). Of a case with
        a crank, `crank_angle` [rad] stands beside `time`, `instant_crank_angle` beside `instant`.
        All is read into memory.
        """
        from .labelled import to_xarray

        return to_xarray(self, self._checked)

    def to_dataframe(self) -> "pandas.DataFrame":
        """All scalar outputs, a column each, by time [s]; needs pandas, which the extra `xarray`
        brings. `attrs["units"]` holds the units.
        """
        from .labelled import to_dataframe

        return to_dataframe(self)

    @property
    def plot(self) -> "Plots":
        """Pictures in one line: `plot()`, `plot.lines`, `plot.map`, `plot.section`; see `Plots`."""
        from .plots import Plots

        return Plots(self, self._checked)


def open_results(path: str | Path) -> Results:
    """The results file of a run.

    Raises
    ------
    BadInput
        If there is no such file, or it is none of a run.
    """
    path = Path(path)
    if not path.is_file():
        got = "a folder" if path.is_dir() else "no such file"
        raise BadInput(f"{path}: expected a results file, got {got}")
    try:
        results = Results(path)
        results.case  # noqa: B018  every results file has its case inside
    except (OSError, KeyError, ValueError, AttributeError):
        raise BadInput(f"{path}: expected the results file of a run, got another file") from None
    return results
