"""Recorded fields of a run as a moving picture."""

from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.animation import FFMpegWriter, PillowWriter

from ..case.schema import Case
from ..fmi.errors import BadInput, names_of, unknown
from .figures import subplots
from .file import Results
from .instants import told
from .pictures import colour_norm, draw_map, labelled, name_of, scaled, where_there

PER_SECOND = 15
"""Instants shown in a second."""
WRITERS = {".gif": PillowWriter, ".mp4": FFMpegWriter}


def write_movie(
    case: Case, results: Results, ports: list[str], frames: int, path: Path
) -> np.ndarray:
    """Draw fields over their two indices, a panel each, at instants evenly chosen among the
    recorded ones.

    Parameters
    ----------
    case : Case
    results : Results
    ports : list of str
        Recorded fields of two indices; of the case's first picture of maps without any.
    frames : int
        Instants at most.
    path : Path
        Ends with .gif or .mp4.

    Returns
    -------
    ndarray of int
        The recorded instants shown.

    Raises
    ------
    BadInput
        For a file of another kind, mp4 without ffmpeg, fewer than 2 instants, and fields that were
        not recorded.
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
        faults.append(f"--field: expected {names_of(known)}, got nothing")
    if frames < 2:
        faults.append(f"--frames: expected at least 2, got {frames}")
    _use_packaged_ffmpeg()
    writer = WRITERS.get(path.suffix)
    if writer is None:
        endings = names_of([*WRITERS, ".glb", ".pvd"])
        faults.append(f"--output: expected a file that ends with {endings}, got {str(path)!r}")
    elif not writer.isAvailable():
        faults.append(
            f"--output: expected ffmpeg for {path.suffix}, got none; "
            "run pip install 'piston-cosim[movie]' or write .gif"
        )
    if faults or writer is None:
        raise BadInput(faults)
    units = {port: unit for picture in maps for port, unit in picture.units.items()}
    chosen = chosen_instants(results, frames)
    figure, panels = subplots(
        len(ports),
        1,
        squeeze=False,
        figsize=(6.1, 1 + 2.6 * len(ports)),
    )
    drawn = []
    for panel, port in zip(panels[:, 0], ports):
        dataset = results.dataset(port)
        values, unit = scaled(dataset[:][chosen], dataset.attrs["unit"], units.get(port))
        images = [where_there(image, results.there(port)) for image in values]
        norm = colour_norm(images)
        draw_map(panel, images[0], norm, case.axes_of(port))
        figure.colorbar(panel.images[0], ax=panel, label=labelled(name_of(port), unit))
        drawn.append((panel, images, norm, case.axes_of(port)))
    film = writer(fps=PER_SECOND)
    with film.saving(figure, str(path), dpi=90):
        for k, instant in enumerate(chosen):
            for panel, images, norm, axes in drawn:
                panel.clear()
                draw_map(panel, images[k], norm, axes)
            figure.suptitle(told(results, float(results.instants[instant])))
            film.grab_frame()
    return chosen


def chosen_instants(results: Results, frames: int) -> np.ndarray:
    """So many at most of the recorded instants, evenly chosen; raises BadInput for less than 2."""
    if frames < 2:
        raise BadInput(f"--frames: expected at least 2, got {frames}")
    count = len(results.instants)
    return np.unique(np.linspace(0, count - 1, min(frames, count)).round().astype(int))


def _use_packaged_ffmpeg():
    """The ffmpeg that imageio-ffmpeg brings, where it is installed and the system has none."""
    if FFMpegWriter.isAvailable():
        return
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        return
    rcParams["animation.ffmpeg_path"] = get_ffmpeg_exe()
