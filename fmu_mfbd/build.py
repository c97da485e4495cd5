"""Build-time work of the body FMU: reduce both bodies or find them in the cache.

The result is the content of the FMU's resources.
"""

import hashlib
from collections import defaultdict
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ..master.fmi.cache import cache_folder
from ..master.fmi.errors import BadInput, for_all
from ..master.fmi.symmetry import Symmetry, rejection
from ..master.fmi.variables import Variable
from .body_options import Block, Piston
from .dynamics.build_options import (
    BlockOptions,
    BoreGrid,
    BuildOptions,
    CrankBearing,
    FilmGrid,
    FloatingPin,
    InSpace,
    PistonOptions,
    SurfaceOptions,
)
from .dynamics.start_state import StartState, check_start
from .geometry.grid import cell_centres, film_rows
from .geometry.profile import BoreOrder, HotShape
from .input_tables import NO_TABLES, Tables, read_tables, read_temperatures
from .options import BearingShell, Bodies, Build, SmallEnd, read_options
from .reducing import Say, check_bosses, check_own, hot_shapes, reduced_shell, reducing
from .reduction.film_loads import Training, recorded_loads
from .reduction.reduced_body import (
    SMALL_END,
    MeshProperties,
    ReducedBlock,
    ReducedBody,
    ReducedBosses,
    ReducedPiston,
    ShellFilm,
    ShellKind,
    load,
    offset_faults,
    save,
)
from .reduction.rigid import rigid_block, rigid_piston
from .reduction.store import kept_body
from .thrust_symmetry import (
    IMAGES,
    ODD_COMPLIANCE,
    ODD_MODE,
    asymmetries,
    asymmetries_of_bodies,
    asymmetries_of_heat,
    claims,
    kind_of,
)
from .variables import inputs, parameters, signals

NO_HOT_SHAPES: Mapping[str, HotShape] = {}


def options_schema() -> dict[str, Any]:
    """Return the JSON schema of the build table."""
    return Build.model_json_schema()


def declared_variables(options: dict[str, Any] | None, folder: Path) -> list[Variable]:
    """Return the variables of the FMU of a build table, or of none, without a reduction.

    Raises
    ------
    BadInput
        Every fault of the table.
    """
    if options is None:
        return inputs((FilmGrid("", (4, 4)),)) + parameters()
    build = read_options(options, folder)
    modes = build.piston.most_modes() + build.block.most_modes()
    ahead = options_ahead(build, NO_TABLES._replace(temperatures=read_temperatures(build)))
    return signals(replace(ahead, piston=replace(ahead.piston, modes=modes)))


def on_grid(options: dict[str, Any], key: str, grid: tuple[int, int]) -> dict[str, Any]:
    """Return a build table on the grid of a given film, with at most the modes that it resolves.

    The film may be asymmetric, because another model computes it.

    Parameters
    ----------
    options : dict
        Build table of a case.
    key : str
        Its option with the grid.
    grid : (int, int)
    """
    from .reduction.smooth_prior import ALONG, pattern_count  # slow to import

    around, along = grid
    changed: dict[str, Any] = options | {key: [around, along]}
    for name, kind, surface in (("piston", Piston, "skirt"), ("block", Block, "bore")):
        if options.get(name, {}).get("symmetric_film"):
            changed[name] = options[name] | {"symmetric_film": False}
        body = {key: one.default for key, one in kind.model_fields.items()} | changed.get(name, {})
        rows = along if name == "piston" else body["stations"]
        lines = cell_centres(around, rows, 0.0, 1.0)
        patterns = pattern_count(*lines, ALONG[surface])
        most = {"pressure_modes": around * rows - 2, "smooth_pressure_modes": patterns}
        limit = most.get(body["basis"])
        if limit and isinstance(body["modes"], int) and body["modes"] > limit:
            changed[name] = changed.get(name, {}) | {"modes": limit}
    return changed


def options_ahead(
    build: Build, tables: Tables, hot: Mapping[str, HotShape] = NO_HOT_SHAPES
) -> BuildOptions:
    """Return the options of the FMU, as far as they are known before its bodies."""
    pin_offset = build.piston.pin_offset
    orders = tuple(BoreOrder(one.order, one.amplitude, one.phase) for one in build.block.orders)
    return BuildOptions(
        grid=build.grid,
        piston=PistonOptions(
            file="",
            modes=0,
            pin_offset=pin_offset,
            profiles=tables.skirt,
            hot=hot.get("piston"),
            is_hot=build.piston.is_hot,
        ),
        block=BlockOptions(
            file="",
            modes=0,
            orders=orders,
            profiles=tables.bore,
            bore_from_outside=bore_from_outside(build),
            hot=hot.get("block"),
            is_hot=build.block.is_hot,
        ),
        gas=tables.gas,
        speed=tables.speed,
        start=tables.start,
        temperatures=tables.temperatures,
        surfaces=tuple(
            SurfaceOptions(one.name, one.rows[0] - 1, one.rows[1]) for one in build.film_surfaces
        ),
        floating_pin=floating_pin(build),
        crank_bearings=crank_bearings(build),
        mounted=build.mounted,
        slides=tuple(build.slides),
        in_space=InSpace(0.0, np.zeros((3, 3))) if build.motion_in_space else None,
    )


def symmetry(options: dict[str, Any], parameters: dict[str, Any], folder: Path) -> Symmetry:
    """Return the symmetry about the thrust plane, as far as known before a reduction.

    Parameters
    ----------
    options : dict
        The case file's `[participants.X.build]` table.
    parameters : dict
        Given values in SI.
    folder : Path
        Folder of the case.

    Raises
    ------
    BadInput
        Every fault of the table.
    """
    build = read_options(options, folder)
    tables = read_tables(build)
    reasons = asymmetries(build, tables, parameters.get("pin_tilt", 0.0))
    in_plane = not (build.motion_in_space or build.block and build.block.bore_from_outside)
    can_halve = in_plane and build.grid[0] % 2 == 0
    return Symmetry(reasons, claims(build), IMAGES if build.floating_pin else {}, can_halve)


def odd_bodies(options: dict[str, Any], folder: Path) -> list[str]:
    """Return the reasons why reduced bodies and their start are not symmetric to round-off.

    Bodies that are not in the cache are reduced. The arguments are those of `prepare`.
    """
    build = read_options(options, folder)
    files = _reduced(build, lambda text: None)
    return _asymmetries(build, files, ODD_MODE, read_tables(build).start)


def prepare(
    options: dict[str, Any], folder: Path, progress: Say
) -> tuple[dict[str, Any], list[Path]]:
    """Validate the build table and reduce both bodies.

    Parameters
    ----------
    options : dict
        The case file's `[participants.X.build]` table.
    folder : Path
        Folder of the case.
    progress : callable
        Takes a sentence now and then.

    Returns
    -------
    options : dict
        Becomes build.json; `BuildOptions.from_json` reads it.
    files : list of Path
        Piston, block and what else yields, to be copied into the FMU's resources.

    Raises
    ------
    BadInput
        Every fault of the table; then every fault of the meshes.
    """
    build = read_options(options, folder)
    tables = read_tables(build)
    bodies = _bodies(build, progress)
    hot = hot_shapes(build, progress)
    piston = hot_piston(piston_about_pin(build.piston, bodies["piston"]), hot.get("piston"))
    block = load(ReducedBlock, bodies["block"])
    files = bodies | {"piston": _carried("piston", piston), "block": _carried("block", block)}
    if build.floating_pin and len(piston.omega):
        files["bosses"] = _carried("bosses", load(ReducedBosses, bodies["piston"]))
    names = defaultdict(str, {name: path.name for name, path in files.items()})
    ahead = options_ahead(build, tables, hot)
    pin = ahead.floating_pin
    if tables.start:
        try:
            modes = len(piston.omega) + len(block.omega)
            check_start(tables.start, modes, ahead.bearing_coordinates())
        except ValueError as error:
            raise BadInput(str(error)) from None
    prepared = replace(
        ahead,
        piston=replace(ahead.piston, file=names["piston"], modes=len(piston.omega)),
        block=replace(ahead.block, file=names["block"], modes=len(block.omega)),
        skirt=_skirt(bodies["piston"]),
        floating_pin=pin and replace(pin, bosses=names["bosses"], small_end=names["small_end"]),
        crank_bearings=tuple(replace(one, shell=names[one.name]) for one in ahead.crank_bearings),
        in_space=in_space(build, bodies["piston"]) if build.motion_in_space else None,
        symmetric_film=bool(claims(build)),
    )
    return prepared.to_json(), [*files.values()]


def piston_about_pin(options: Piston, path: Path) -> ReducedPiston:
    """Return the reduced piston of an .npz with pin point A at the case's `pin_offset`.

    Raises
    ------
    BadInput
        The pin bores of its mesh are too far from there.
    """
    piston = load(ReducedPiston, path)
    faults = offset_faults(piston.pin_offset, piston.radius, options.pin_offset)
    if faults:
        raise BadInput([f"piston: {fault}" for fault in faults])
    return piston.about(options.pin_offset)


def hot_piston(piston: ReducedPiston, hot: HotShape | None) -> ReducedPiston:
    """Return the piston with the edges of its hot skirt."""
    if hot is None:
        return piston
    lower, upper = piston.skirt_lower + hot.lower, piston.skirt_upper + hot.upper
    return replace(piston, skirt_lower=lower, skirt_upper=upper)


def bore_from_outside(build: Build) -> BoreGrid | None:
    """Return the grid of a bore whose deflection comes from outside."""
    grid = build.block.bore_from_outside
    return BoreGrid(grid.around, grid.axial) if grid else None


def in_space(build: Build, piston: Path) -> InSpace:
    """Return the inertia of a piston that moves in space, from its data sheet or its mesh.

    Eq. (J22):  S_z = m c_z,   J = J_c + m (|c|^2 1 - c c^T)      c from A, J_c about the centre

    Raises
    ------
    BadInput
        No mesh is known of an .npz.
    """
    sheet = build.piston.rigid
    if sheet is None:
        from .finite_elements.element import mass_properties  # slow to import

        try:
            mass, centre, about_centre = mass_properties(load(MeshProperties, piston).rigid_mass)
        except ValueError as error:
            raise BadInput(f"piston.{error}") from None
        centre[0] += load(ReducedPiston, piston).pin_offset - build.piston.pin_offset
    else:
        assert (space := build.motion_in_space) and space.inertia_x and space.inertia_y
        x, y = sheet.centre
        mass = sheet.mass
        centre = np.array([x - build.piston.pin_offset, y, space.centre_z])
        about_centre = np.diag([space.inertia_x, space.inertia_y, sheet.inertia])
    # Eq. (J22)
    steiner = mass * (float(centre @ centre) * np.eye(3) - np.outer(centre, centre))
    *_, z = centre
    return InSpace(float(mass * z), about_centre + steiner)


def floating_pin(build: Build) -> FloatingPin | None:
    """Return the films of the floating pin of a build table."""
    pin = build.floating_pin
    if pin is None:
        return None
    film = eye_film(build)
    return FloatingPin(
        pin.grid,
        pin.boss_length,
        pin.small_end_length,
        pin_shapes=pin.pin_shapes,
        small_end_modes=film.modes if film else 0,
    )


def eye_film(build: Bodies) -> ShellFilm | None:
    """Return the film in a flexible small end of the rod, else None."""
    pin = build.floating_pin
    if pin is None or pin.small_end is None or not pin.small_end.modes:
        return None
    return ShellFilm(pin.grid, pin.small_end_length, pin.small_end.modes)


def crank_bearings(build: Build) -> tuple[CrankBearing, ...]:
    """Return the films of the crank of a build table."""
    films = build.crank_films().items()
    return tuple(
        CrankBearing(name, one.grid, one.length, modes=one.shell.modes if one.shell else 0)
        for name, one in films
    )


def boss_films(build: Bodies) -> ShellFilm | None:
    """Return the films in the bosses of a flexible piston, else None."""
    pin = build.floating_pin
    if pin is None or not pin.boss_modes:
        return None
    return ShellFilm(pin.grid, pin.boss_length, pin.boss_modes)


def reduced_bodies(
    options: dict[str, Any], folder: Path, progress: Say, shapes: bool = False
) -> dict[str, Path]:
    """Return the reduced bodies of a build table, or of one that has a single body.

    Parameters
    ----------
    options, folder, progress
        As for `prepare`.
    shapes : bool
        Whether mode shapes on the mesh are needed. Shipped bodies do not contain them.

    Returns
    -------
    dict of str to Path
        An .npz for each of piston and block (`reduction.reduced_body`), but none for the eye of
        the rod.

    Raises
    ------
    BadInput
    """
    files = _bodies(read_options(options, folder, Bodies), progress, shapes)
    return {name: path for name, path in files.items() if name in ("piston", "block")}


def _bodies(build: Bodies, progress: Say, shapes: bool = False) -> dict[str, Path]:
    """Return `_reduced`; reject assumptions of a symmetric film with bodies that have none."""
    assumed = claims(build)
    if assumed:
        _reject(assumed, asymmetries(build, read_tables(build)))
    files = _reduced(build, progress, shapes)
    if assumed:
        _reject(assumed, _asymmetries(build, files, ODD_COMPLIANCE))
    return files


def _reduced(build: Bodies, progress: Say, shapes: bool = False) -> dict[str, Path]:
    """Return the .npz of each body, by name, an eye that yields among them.

    The bodies are reduced side by side, in threads: SuperLU releases Python's lock. PARDISO uses
    all cores for one body. Rigid bodies have nothing to solve. One after the other takes as long
    and less memory. All faults are raised in one message.
    """
    waiting: dict[str, Future[Path]] = {}
    is_solved = any(body.modes for body in (build.piston, build.block) if body)
    with ThreadPoolExecutor(None if is_solved and not find_spec("pypardiso") else 1) as threads:

        def submit(options: SmallEnd | BearingShell, *of: Any) -> Future[Path]:
            return threads.submit(reduced_shell, options, options.density, *of)

        for name, body in (("piston", build.piston), ("block", build.block)):
            if body:
                waiting[name] = threads.submit(
                    _body, name, body, build, progress, shapes, waiting.get("piston")
                )
        film = eye_film(build)
        if film and build.floating_pin and (eye := build.floating_pin.small_end):
            waiting["small_end"] = submit(eye, film, SMALL_END, progress, "floating_pin.small_end")
        for name, one in build.crank_films().items():
            if one.shell and one.shell.modes:
                film = ShellFilm(one.grid, one.length, one.shell.modes)
                kind = ShellKind(name.replace("_", " "), length=f"{name}.length", upright=True)
                waiting[name] = submit(one.shell, film, kind, progress, f"{name}.shell")
    return dict(zip(waiting, for_all(Future.result, waiting.values()), strict=True))


def _asymmetries(
    build: Bodies, files: dict[str, Path], limit: float, start: StartState | None = None
) -> list[str]:
    """Return `asymmetries_of_bodies` of these files."""
    both = (("piston", build.piston), ("block", build.block))
    bodies = {name: load(kind_of(body), files[name]) for name, body in both if body}
    skirt = _mesh_skirt(files["piston"]) if "piston" in files else None
    reasons = asymmetries_of_bodies(bodies, skirt, build.grid[0], limit, start)
    return reasons + asymmetries_of_heat(hot_shapes(build, lambda text: None))


def _reject(assumed: list[str], reasons: list[str]) -> None:
    """Raise BadInput for options that assume a symmetric film, if there are reasons against it."""
    if reasons:
        raise BadInput([rejection(f"build.{claim}", reasons) for claim in assumed])


def _training(body: Piston | Block, build: Bodies, piston: Future[Path] | None) -> Training | None:
    """Return the film forces that a body is trained on, if it is; a block needs its piston."""
    if not (body.train_on and body.modes):
        return None
    loads = recorded_loads(body.train_on, build.grid)
    if isinstance(body, Piston):
        return Training(loads, np.empty(0))
    if piston is None or piston.exception():
        raise ValueError("train_on: expected a piston with the block, got none")
    skirt = load(ReducedPiston, piston.result())
    return Training(loads, film_rows(skirt.skirt_lower, skirt.skirt_upper, build.grid))


def _body(
    name: str,
    options: Piston | Block,
    build: Bodies,
    progress: Say,
    shapes: bool,
    piston: Future[Path] | None,
) -> Path:
    """Return the path of a reduced body: shipped, cached, reduced now, or the checked own one."""
    grid = build.grid
    with reducing(name, options.mesh, progress, name) as say:
        training = _training(options, build, piston)
        bosses = boss_films(build) if isinstance(options, Piston) else None
        if options.rigid:
            body = (
                rigid_piston(options, grid)
                if isinstance(options, Piston)
                else rigid_block(options, grid)
            )
            return _carried(name, body)
        if options.reduced:
            path = Path(options.reduced)
            check_own(path, options, grid)
            if bosses:
                check_bosses(path, bosses)
            return path
        return kept_body(options, grid, cache_folder("bodies"), say, training, bosses, shapes)


def _mesh_skirt(piston: Path) -> np.ndarray | None:
    """Return the cells of the film grid with the skirt under them, (c, a); None if unknown."""
    try:
        return load(MeshProperties, piston).skirt
    except ValueError:  # a data sheet, or a file without them
        return None


def _skirt(piston: Path) -> list[list[int]] | None:
    """Return the rows of `_mesh_skirt` as numbers; None if all are 1 or unknown."""
    skirt = _mesh_skirt(piston)
    return None if skirt is None or skirt.all() else skirt.astype(int).tolist()


def _carried(name: str, body: ReducedBody | ReducedBosses) -> Path:
    """Return the file for the FMU: the body without its anatomy, named by its content."""
    digest = hashlib.sha256()
    for value in vars(body).values():
        array = np.asarray(value)
        digest.update(str(array.shape).encode() + array.tobytes())
    path = cache_folder("carried") / f"{name}-{digest.hexdigest()[:24]}.npz"
    if not path.exists():
        save(path, body)
    return path
