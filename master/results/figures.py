"""Figures without pyplot: they need no display and do not choose a backend."""

from io import BytesIO
from typing import Any

from matplotlib import figure
from matplotlib.backends.backend_agg import FigureCanvasAgg


class Figure(figure.Figure):
    """Figure that a notebook shows when a cell returns it, whatever the backend is."""

    def _repr_png_(self) -> bytes:
        """Return the figure as PNG."""
        data = BytesIO()
        self.savefig(data, format="png")
        return data.getvalue()


def subplots(rows: int = 1, columns: int = 1, *, figsize: tuple[float, float], **given: Any) -> Any:
    """Return a figure with a grid of axes, and the axes, as `pyplot.subplots` does.

    Parameters
    ----------
    rows, columns : int
        Size of the grid.
    figsize : tuple of float
        Width and height [in].
    **given
        Options of `Figure.subplots`.
    """
    made = Figure(figsize=figsize, layout="constrained")
    FigureCanvasAgg(made)
    return made, made.subplots(rows, columns, **given)
