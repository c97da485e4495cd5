"""Figures without pyplot: they need no display and do not choose a backend."""

import re
from base64 import b64decode, b64encode
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, figure, rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from PIL import Image

from .maps import STYLE

PAPER: dict[Any, Any] = {
    "font.size": 8.0,
    "axes.linewidth": 0.6,
    "pdf.fonttype": 42,
}
"""Settings of pictures in publications."""
PAPER_SCALE = 0.64
"""Size of a picture in a publication, relative to its size on a screen."""
PAPER_RESOLUTION = 300
"""Resolution of a PNG picture in a publication [1/in]."""
RESOLUTION = 130
"""Resolution of a PNG picture for the screen [1/in]."""
VECTOR_RESOLUTION = 72
"""Resolution of maps in PDF and SVG files [1/in]; they are smooth."""


PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Colours of Okabe and Ito (2008), which differ for all kinds of colour vision."""
NO_FILM = "#d5dade"
"""Colour of the cells of a map without a film."""
COLOURS = {
    kind: LinearSegmentedColormap.from_list(kind, ramp).with_extremes(bad=NO_FILM)
    for kind, ramp in STYLE["ramps"].items()
} | {
    "field": colormaps["viridis"].with_extremes(bad=NO_FILM),
    "change": LinearSegmentedColormap.from_list(
        "change", ["#053061", "#4393c3", "#f7f7f7", "#d6604d", "#67001f"]
    ),
}
"""Colours of maps by kind of field."""
RUPTURE = "#0a6b78"
"""Colour of the line at which a film ruptures."""


class Figure(figure.Figure):
    """Figure that a notebook shows when a cell returns it, whatever the backend is."""

    def _repr_png_(self) -> bytes:
        """Return the figure as PNG."""
        data = BytesIO()
        self.savefig(data, format="png")
        return data.getvalue()


def subplots(
    rows: int = 1, columns: int = 1, *, figsize: tuple[float, float], **options: Any
) -> Any:
    """Return a figure with a grid of axes, and the axes, as `pyplot.subplots` does.

    Parameters
    ----------
    rows, columns : int
        Size of the grid.
    figsize : tuple of float
        Width and height [in].
    **options
        Options of `Figure.subplots`.
    """
    figure = Figure(figsize=figsize, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, **options)


def stack(rows: int, height: float = 2.3) -> Any:
    """Return a figure, and its panels above each other, which share the abscissa.

    Parameters
    ----------
    rows : int
        Number of panels.
    height : float
        Height of a panel [in].
    """
    size = (11, 1.2 + height * rows)
    figure, panels = subplots(rows, 1, sharex=True, squeeze=False, figsize=size)
    for panel in panels[:, 0]:
        panel.grid(alpha=0.3)
        panel.margins(x=0)
    return figure, panels[:, 0]


def add_legend(panel: Any, handles: dict[str, Any] | None = None) -> None:
    """Add a legend to the right of a panel, from handles by label; default: all of the panel."""
    own = {} if handles is None else {"handles": handles.values(), "labels": handles.keys()}
    place = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}
    panel.legend(**own, **place, fontsize="small", frameon=False)


def save(drawn: figure.Figure, path: Path, resolution: float = RESOLUTION) -> Path:
    """Save a figure as PNG, PDF or SVG, and return the path.

    The suffix of the path is the type of the file. Images have a palette of 256 colours, and PNG
    files the `resolution` [1/in]. In SVG files, text is text and coordinates have one decimal.
    """
    data = BytesIO()
    with rc_context({"svg.fonttype": "none", "font.sans-serif": ["DejaVu Sans", "Arial"]}):
        if path.suffix == ".png":
            data.write(_as_png(_image_of(drawn, resolution), kinds_of(drawn)))
        else:
            drawn.savefig(data, format=path.suffix[1:], dpi=VECTOR_RESOLUTION)
    if path.suffix == ".svg":
        text = data.getvalue().decode()
        text = re.sub(r' d="[^"]*"', lambda part: re.sub(r"(\.\d)\d+", r"\1", part[0]), text)
        text = re.sub(
            r'(?<=png;base64,)[^"]+',
            lambda part: b64encode(
                _as_png(Image.open(BytesIO(b64decode(part[0]))), kinds_of(drawn))
            ).decode(),
            text,
        )
        data = BytesIO(text.encode())
    path.write_bytes(data.getvalue())
    return path


def kinds_of(drawn: figure.Figure) -> tuple[str, ...]:
    """Return the kinds of fields whose colours a figure has."""
    names = {image.get_cmap().name for panel in drawn.axes for image in panel.images}
    return tuple(kind for kind, colours in COLOURS.items() if colours.name in names)


def _image_of(drawn: figure.Figure, resolution: float) -> Image.Image:
    """Return a figure as an image; `savefig` would draw it twice, and encode all colours."""
    usual, drawn.dpi = drawn.dpi, resolution
    canvas = FigureCanvasAgg(drawn)
    canvas.draw()
    drawn.dpi = usual
    image = Image.fromarray(np.asarray(canvas.buffer_rgba()))
    image.info["dpi"] = resolution, resolution
    return image


def _as_png(image: Image.Image, kinds: tuple[str, ...]) -> bytes:
    """Return a PNG file with a palette."""
    data = BytesIO()
    dpi = image.info.get("dpi", (RESOLUTION, RESOLUTION))
    with_palette(image, kinds).save(data, "png", optimize=True, dpi=dpi)
    return data.getvalue()


def with_palette(image: Image.Image, kinds: tuple[str, ...]) -> Image.Image:
    """Return an image in the nearest of 256 colours: of maps, greys and tints of the curves.

    The search of Pillow takes a colour near white for white.
    """
    palette = _palette(kinds)
    red, green, blue = np.moveaxis(np.asarray(image.convert("RGB"), dtype=np.uint32), 2, 0)
    pixels = red << 16 | green << 8 | blue
    colours = np.unique(pixels)
    known = np.stack([colours >> 16, colours >> 8 & 255, colours & 255], axis=1).astype(np.float32)
    wanted = palette.astype(np.float32)
    nearest = ((wanted**2).sum(axis=1) - 2.0 * known @ wanted.T).argmin(axis=1)
    index = np.empty(1 << 24, np.uint8)  # of every colour
    index[colours] = nearest
    drawn = Image.fromarray(index[pixels])
    drawn.putpalette(palette.ravel().tolist())
    return drawn


@cache
def _palette(kinds: tuple[str, ...]) -> np.ndarray:
    """Return the colours of pictures with maps of these kinds, shape (256, 3)."""
    kinds = kinds or ("field",)
    greys = np.repeat(np.linspace(1.0, 0.0, 33)[:, None], 3, axis=1)
    tints = np.linspace(0.0, 1.0, 9)[1:, None]
    lines = [1.0 + tints * (np.array(to_rgb(colour)) - 1.0) for colour in (*PALETTE[:-1], RUPTURE)]
    fixed = np.vstack([greys, to_rgb(NO_FILM), *lines])
    count = 256 - len(fixed)
    ends = np.linspace(0, count, len(kinds) + 1).astype(int)
    maps = [
        COLOURS[kind](np.linspace(0.0, 1.0, size))[:, :3]
        for kind, size in zip(kinds, np.diff(ends))
    ]
    return (255 * np.vstack([fixed, *maps])).round().astype(np.uint8)
