"""Recorded fields of a run as a movie."""

from itertools import chain
from pathlib import Path

import numpy as np
from PIL import Image

from ..case.schema import Case
from ..fmi.errors import BadInput, names_of, unknown
from .figures import kinds_of, with_palette
from .file import Results
from .instants import instant_text
from .maps import field_map, map_row
from .pictures import draw_values, map_figure

PER_SECOND = 15
"""Number of instants per second of the movie."""
RESOLUTION = 90
"""Resolution of a frame [1/in]."""


def write_movie(
    case: Case, results: Results, ports: list[str], frames: int, path: Path
) -> np.ndarray:
    """Draw fields over their two indices, a panel each, at evenly spaced recorded instants.

    Parameters
    ----------
    case : Case
    results : Results
    ports : list of str
        Recorded fields of two indices. Default: those of the case's first picture of maps.
    frames : int
        Maximum number of instants.
    path : Path
        With suffix .gif.

    Returns
    -------
    ndarray of int
        Indices of the recorded instants shown.

    Raises
    ------
    BadInput
        For another suffix, fewer than 2 instants, and fields that were not recorded.
    """
    maps = [picture for picture in case.pictures if picture.kind == "map"]
    ports = ports or [port for picture in maps[:1] for port in picture.fields]
    known = [port for port in results.recorded if results.dataset(port).ndim == 3]
    faults = [
        f"--field: {unknown('field', port, known, 'name it in record.fields of the case')}"
        for port in ports
        if port not in known
    ]
    if not ports:
        hint = "" if known else "; the file has no fields, name them in record.fields of the case"
        faults.append(f"--field: expected {names_of(known)}, got nothing{hint}")
    if frames < 2:
        faults.append(f"--frames: expected at least 2, got {frames}")
    if path.suffix != ".gif":
        faults.append(f"--output: expected a file *.gif or *.pvd, got {str(path)!r}")
    if faults:
        raise BadInput(faults)
    units = {port: unit for picture in maps for port, unit in picture.units.items()}
    chosen = chosen_instants(results, frames)
    times = [float(time) for time in results.instants[chosen]]
    rows = [
        map_row([field_map(case, results, port, time, units) for time in times]) for port in ports
    ]
    titles = [instant_text(results, time) for time in times]
    first, *others = _frames(rows, titles)
    first.save(path, append_images=others, save_all=True, duration=1000 // PER_SECOND, loop=0)
    return chosen


def _frames(rows, titles):
    """Yield a frame as an image with a palette for each title; axes are drawn once."""
    figure, panels = map_figure(rows, 1)
    kinds = kinds_of(figure)
    figure.set_dpi(RESOLUTION)
    title = figure.suptitle(titles[0])
    figure.canvas.draw()  # arranges the panels
    figure.set_layout_engine("none")
    title.set_text("")
    for panel in panels.flat:
        _clear(panel)
    figure.canvas.draw()
    background = figure.canvas.copy_from_bbox(figure.bbox)
    for k, text in enumerate(titles):
        figure.canvas.restore_region(background)
        for panel, row in zip(panels.flat, rows):
            draw_values(panel, row.maps[k], row)
            drawn = (panel.images, panel.collections, panel.lines, panel.texts)
            for artist in chain(*drawn, panel.spines.values()):
                panel.draw_artist(artist)
            _clear(panel)
        title.set_text(text)
        figure.draw_artist(title)
        frame = np.array(figure.canvas.buffer_rgba())[..., :3]
        yield with_palette(Image.fromarray(frame), kinds)


def _clear(panel):
    """Remove the values of a map."""
    for artist in [*panel.images, *panel.collections, *panel.lines, *panel.texts]:
        artist.remove()


def chosen_instants(results: Results, frames: int) -> np.ndarray:
    """Return evenly spaced indices of recorded instants; raise `BadInput` for fewer than 2."""
    if frames < 2:
        raise BadInput(f"--frames: expected at least 2, got {frames}")
    count = len(results.instants)
    return np.unique(np.linspace(0, count - 1, min(frames, count)).round().astype(int))
