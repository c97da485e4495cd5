"""Results of a run: reading, labels, plots."""

from pathlib import Path
from typing import TYPE_CHECKING

from ..fmi.errors import BadInput
from .recorded import Recorded

if TYPE_CHECKING:
    import pandas
    import xarray

    from .plots import Plots


class Results(Recorded):
    """Recorded data of a run as arrays in SI with their units; `with` closes the file.

    If a run ends once it is periodic, only the last period is shown, or `record.periods` of them.
    Time and crank angle then start with the first one shown. `whole` shows the whole run, `last`
    the last period.

    Parameters
    ----------
    path : str or Path
        A results file, or that of an unfinished run (`.partial`). A port is a string,
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
        """Return all recorded data with named dimensions; needs the extra `xarray`.

        Scalars depend on `time` [s], fields on `instant` [s] and the axes of the case (for a
        skirt: `angle` [deg], `height` in the unit of the case). A case with a crank also has the
        coordinates `crank_angle` [rad] and `instant_crank_angle`. All data is read into memory.
        """
        from .labelled import to_xarray

        return to_xarray(self, self._checked)

    def to_dataframe(self) -> "pandas.DataFrame":
        """Return all scalar outputs by time [s], one column each; needs the extra `xarray`.

        `attrs["units"]` contains the units.
        """
        from .labelled import to_dataframe

        return to_dataframe(self)

    @property
    def plot(self) -> "Plots":
        """Pictures in one line: `plot()`, `plot.lines`, `plot.map`, `plot.section`; see `Plots`."""
        from .plots import Plots

        return Plots(self, self._checked)


def open_results(path: str | Path) -> Results:
    """Open the results file of a run.

    Raises
    ------
    BadInput
        If there is no such file, or it is not that of a run.
    """
    path = Path(path)
    if not path.is_file():
        got = "a folder" if path.is_dir() else "no such file"
        if (checkpoint := Path(f"{path}.checkpoint")).is_file():
            got = f"an interrupted run; piston-cosim resume {checkpoint} continues it"
        raise BadInput(f"{path}: expected a results file, got {got}")
    try:
        results = Results(path)
        results.case  # noqa: B018  every results file has its case inside
    except (OSError, KeyError, ValueError, AttributeError) as error:
        got = "a truncated one" if "truncated" in str(error) else "another file"
        raise BadInput(f"{path}: expected the results file of a run, got {got}") from None
    return results
