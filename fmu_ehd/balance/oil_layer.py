"""Oil on the bore: a layer at rest on the bore, which the skirt uncovers and covers again.

Oil on the bore moves with it, at |V| past the skirt. A film with the film fraction f moves at
|V|/2. A layer of thickness lambda therefore fills a gap h to f = min(1, 2 lambda / h). A film that
leaves the skirt with f leaves a layer lambda = f h / 2 behind, half of the gap if it is full. The
edge pushes the oil that the gap does not take, in a reservoir at its chamfer. This oil enters
later. For each row of the film and each of its axial edges, the volumes are:

Eq. (T21):  R_e <- R_e + (oil of the bore that the skirt has covered)
Eq. (T22):  S = max(R_e - beta_t F_n, 0) / H_e
Eq. (T23):  R_e <- R_e - F
Eq. (T24):  (oil of the bore that the skirt has uncovered) = min(R_e, w |X| h),  R_e <- R_e - that
Eq. (T25):  R_e <- min(R_e, a w)

R_e is the oil in the reservoir, and S the most that sliding drags in, Eq. (E12).
F = beta_t F_n + H_e q is the volume that came into the film over the edge in the step, and F_n that
of the step before, `storage`. w is the width of the row, X the travel of the skirt in the step, and
h the gap at the edge. a is the largest cross-section of oil that an edge can push, and more oil
falls off. Where the supply ends, R_e is negative for a step, by at most a third of the inflow of
the last step, because the storage term still admits this oil.

The position of the skirt at the end of a step is known at its beginning, to second order in time:

Eq. (T26):  Y_{n+1} = Z_n + H V_n + H^2 (V_n - V_{n-1}) / (2 H_n)
           Z_{n+1} = Z_n + H (V_n + V_{n+1}) / 2

Y is the height of the lower edge that the layer uses, and Z the same by the trapezoidal rule, both
from the start of the skirt [m]. V is the mean sliding velocity of the skirt. S depends on the past
only. In the tangent of the film, a limited inflow is therefore a constant.

Each row i of the grid around has its own edges. A skirt may end higher or lower there, and every
opening adds two edges. Under an opening the bore is bare, and the following part of the skirt
collects the oil on it. Oil that pressure drives into an opening around the circumference remains on
the bore under it:

Eq. (T28):  W = beta_t W_n + H_e w,   (oil of the bore under the opening) <- that + W

W is the volume that came into the opening in the step, and W_n that of the step before [m3]. w is
the flow at the end of the step [m3/s]. A cell of the opening is above parts of two cells of the
bore.

With an oil ring, the bore above the grid carries the oil that the ring leaves, regardless of the
skirt. The difference comes from or goes to the ring. Splash adds to the bore below the lowest edge
of a row, until the layer is as thick as the wall holds (`largest_oil_layer`). Further splash runs
off. Both count as supplied, and oil that falls off counts as negative supply. A run may set the
layer between two steps, which also counts as supplied. The following sum is constant to round-off:

Eq. (T27):  oil in the film + on the bore + in the reservoirs - supplied

Within a cell of the bore, which is as long as one of the film, the layer is uniform.

Arrays have n_b cells along the bore, from `stroke` below the start of the skirt to `stroke` above
it. They have n_e edges of a row from below, so that lower and upper ones alternate (2 without
openings). If a row has fewer edges, the others are at infinity and have no effect.

A film of thickness lambda on a wall drains by its weight with q = rho g lambda^3 / (3 mu) per width
[Nusselt1916]. Over a length l of wall, q carries off a splash s with the thickness

    lambda = (3 mu s l / (rho g))^(1/3)

The default is 0.30 mm, for 5.6 mPa s, 850 kg/m3 and 0.1 mm/s over 0.14 m. The draining itself is
neglected: in a cycle at 1680 rpm (71 ms) it moves such a film by 3 mm, and one of 10 um by 4 um.

References
----------
[Nusselt1916] W. Nusselt, Z. VDI 60 (1916) 541.
[Ma1997] M.-T. Ma, I. Sherrington, E. H. Smith, Analysis of lubrication and friction for a complete
piston-ring pack with an improved oil availability model, part 1, Proc. IMechE J 211 (1997) 1-15
(rings fed by the layer on the bore, and oil that gathers before them).
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..common.faults import FAULT, refuse
from ..common.grid import (
    Array,
    Cells,
    Field,
    Flags,
    add,
    images,
    put,
    sum_of_products,
    unlimited_supply,
)

NO_EDGE = -1.0
BARE_AT_LEAST = 1e-300  # share of a cell that replaces 0 in a divisor


class OilLayer(NamedTuple):
    """Oil outside the film.

    bore : ndarray, shape (n_c, n_b)
        Oil on the bore, volume over the area of a cell [m]; 0 under the skirt.
    reservoir : ndarray, shape (n_e, n_c)
        R [m3].
    spilled : ndarray, shape (n_c, n_a)
        W of the last step [m3].
    reached, height : float
        Y, Z [m].
    velocity, velocity_before : float
        V_n, V_{n-1} [m/s].
    supplied : float
        Volume that came from outside since the start [m3].
    held : float
        Volume on the bore and in the reservoirs at the end of the step [m3].
    """

    bore: Annotated[Array, "n_c, n_b"]
    reservoir: Annotated[Array, "n_e, n_c"]
    spilled: Field
    reached: float
    height: float
    velocity: float
    velocity_before: float
    supplied: float
    held: float


class LayerVolumes(NamedTuple):
    """Volumes of a step [m3].

    F into the film over the edges, shape (n_e, n_c), and W, shape (n_c, n_a).
    """

    inflow: Array
    spilled: Array


class Supply(NamedTuple):
    """Supply and drain of oil on the bore.

    followed : whether oil outside the film is computed; ring : whether an oil ring leaves some;
    initial_layer : on the bore at the start [m]; stroke [m];
    chamfer_capacity : a of Eq. (T25) [m2]; largest_layer : from which splash runs off [m].
    """

    followed: bool
    ring: bool
    initial_layer: float
    stroke: float
    chamfer_capacity: float
    largest_layer: float


class Bore(NamedTuple):
    """The bore that a skirt slides on.

    supply : Supply; cells : grid.Cells, of the film; length : of the grid along the bore [m];
    beyond : cells of the bore below the grid at the start, and above it;
    faces : ndarray, shape (n_e, n_c), axial face of the grid of each edge, -1 where a row has no
    such edge; edges with even numbers are lower ones;
    heights : ndarray, shape (n_e, n_c, 1), of the edges above the lower end of the grid, inf where
    there is none [m];
    bottom : ndarray, shape (n_b,), lower ends of the cells above that of the grid at the start [m];
    area : ndarray, shape (n_c, n_b), of the cells [m2].
    """

    supply: Supply
    cells: Cells
    length: float
    beyond: int
    faces: Array
    heights: Array
    bottom: Array
    area: Array


class ExposedShares(NamedTuple):
    """Shares of the cells of the bore [-].

    beyond : ndarray, shape (n_e, n_c, n_b), below a lower edge, above an upper one;
    between : ndarray, shape (n_e/2 + 1, n_c, n_b), bare below the first edge, between two parts of
    the skirt, above the last one.
    """

    beyond: Array
    between: Array


def skirt_edges(open_cells: Flags) -> Array:
    """Return `Bore.faces` of a skirt with openings, ndarray of bool of shape (n_c, n_a)."""
    film = np.pad(~open_cells, ((0, 0), (1, 1)))
    row, face = np.nonzero(film[:, 1:] != film[:, :-1])
    order = np.arange(row.size) - np.searchsorted(row, row)
    faces = np.full((2 * int((order // 2).max(initial=0) + 1), len(open_cells)), NO_EDGE)
    faces[order, row] = face
    return faces


@compilable
def bore_of(supply: Supply, faces: Array, cells: Cells, n_a: int) -> Bore:
    """Return the bore of a film with n_a axial cells.

    It has no cells beyond the film if the oil is not followed.
    """
    n_e, n_c = faces.shape
    beyond = int(np.ceil(supply.stroke / cells.dy)) if supply.followed else 0
    heights = np.empty((n_e, n_c, 1))
    for edge in range(n_e):
        for i in range(n_c):
            face = faces[edge, i]
            heights[edge, i, 0] = np.inf if face == NO_EDGE else face * cells.dy
    bottom = np.empty(n_a + 2 * beyond)
    for k in range(bottom.size):
        bottom[k] = (k - beyond) * cells.dy
    area = np.empty((n_c, bottom.size))
    for i in range(n_c):
        for k in range(bottom.size):
            area[i, k] = images(cells.mirrored, i, n_c) * cells.dx * cells.dy
    return Bore(
        supply=supply,
        cells=cells,
        length=n_a * cells.dy,
        beyond=beyond,
        faces=faces,
        heights=heights,
        bottom=bottom,
        area=area,
    )


@compilable
def start(bore: Bore, velocity: Array, open_cells: Flags) -> OilLayer:
    """Return an even layer on the bare bore, with no oil at the edges.

    Parameters
    ----------
    bore : Bore
    velocity, open_cells
        As for `mean_of`.
    """
    layer = bore.supply.initial_layer * _bare(_exposed(bore, 0.0))
    mean = mean_of(velocity, open_cells, bore.cells)
    on_bore = sum_of_products(layer, bore.area)
    nothing = np.zeros(bore.faces.shape)
    return OilLayer(
        bore=layer,
        reservoir=nothing,
        spilled=np.zeros(velocity.shape),
        reached=0.0,
        height=0.0,
        velocity=mean,
        velocity_before=mean,
        supplied=0.0,
        held=on_bore,
    )


@compilable
def none_followed() -> OilLayer:
    """Return the oil layer of a film without oil outside it."""
    nothing = np.zeros((0, 0))
    return OilLayer(
        bore=nothing,
        reservoir=nothing,
        spilled=nothing,
        reached=0.0,
        height=0.0,
        velocity=0.0,
        velocity_before=0.0,
        supplied=0.0,
        held=0.0,
    )


@compiled
def mean_of(velocity: Array, open_cells: Flags, cells: Cells):
    """Return V of the skirt [m/s], the mean over its cells, shape (n_c, n_a), that have a film."""
    total = 0.0
    count = 0.0
    for i in range(velocity.shape[0]):
        alike = images(cells.mirrored, i, velocity.shape[0])
        for j in range(velocity.shape[1]):
            if not open_cells[i, j]:
                total += alike * velocity[i, j]
                count += alike
    return total / max(count, 1.0)


@compilable
def volume(bore: Bore, layer: OilLayer) -> float:
    """Return the oil on the bore and at the edges of the skirt [m3]."""
    return _oil_volume(bore, layer.bore, layer.reservoir)


@compilable
def _oil_volume(bore, oil, reservoir):
    """Return the volume of a layer and of the reservoirs at the edges [m3]."""
    pushed = sum_of_products(reservoir, np.ones(bore.faces.shape))
    return sum_of_products(oil, bore.area) + pushed


@compilable
def covered(
    bore: Bore,
    layer: OilLayer,
    length: float,
    length_before: float,
    ring: float,
    splash: float,
    faults: Array,
) -> OilLayer:
    """Return the layer after the skirt has moved and taken up what it covers.

    The film has not taken any oil yet, Eqs. (T21), (T26). A fault is noted if the skirt moves
    farther than `stroke`.

    Parameters
    ----------
    bore : Bore
    layer : OilLayer
        At the beginning of the step.
    length, length_before : float
        H, H_n [s]; H_n = 0 where there was no step before.
    ring : float
        Layer that the oil ring leaves above the skirt [m].
    splash : float
        Growth of the layer below the skirt [m/s].
    faults : ndarray
        `faults.refuse`.
    """
    change = layer.velocity - layer.velocity_before
    gain = 0.5 * length * change * length / length_before if length_before > 0.0 else 0.0
    reached = layer.height + length * layer.velocity + gain  # Eq. (T26)
    supply = bore.supply
    if abs(reached) > supply.stroke:
        refuse(faults, FAULT.too_far, 0, 0, reached, supply.stroke, 0.0)
        return layer
    old = _exposed(bore, layer.reached)
    new = _exposed(bore, reached)
    whole = np.maximum(_bare(old), BARE_AT_LEAST)
    below = old.between[0]
    room = np.maximum(supply.largest_layer * below - layer.bore, 0.0)
    brought = np.minimum(splash * length * below, room)
    if supply.ring:
        above = _above(bore, layer.reached, np.full((1, 1), bore.length))
        scraped = layer.bore * (above / whole)
        brought = brought + (ring * above - scraped)
    oil = layer.bore + brought
    reservoir = layer.reservoir.copy()
    for edge in range(reservoir.shape[0]):
        swept = np.maximum(old.beyond[edge] - new.beyond[edge], 0.0)
        taken = oil * (np.minimum(swept, old.between[(edge + 1) // 2]) / whole)
        oil = oil - taken
        for i in range(reservoir.shape[1]):
            # Eq. (T21)
            reservoir[edge, i] += sum_of_products(taken[i : i + 1], bore.area[i : i + 1])
    added = sum_of_products(brought, bore.area) + (volume(bore, layer) - layer.held)
    return OilLayer(
        bore=oil,
        reservoir=reservoir,
        spilled=layer.spilled,
        reached=reached,
        height=layer.height,
        velocity=layer.velocity,
        velocity_before=layer.velocity_before,
        supplied=layer.supplied + added,
        held=layer.held,
    )


@compilable
def limit(bore: Bore, covered: OilLayer, carried: Array, length: float) -> Array:
    """Return the largest flow that sliding can drag in over the axial faces, Eq. (T22).

    Parameters
    ----------
    bore : Bore
    covered : OilLayer
        From `covered`.
    carried : ndarray, shape (n_e, n_c)
        beta_t F_n [m3].
    length : float
        H_e [s].

    Returns
    -------
    ndarray, shape (n_c, n_a + 1)
        S [m3/s], inf at faces that are no edge.
    """
    most = np.maximum(covered.reservoir - carried, 0.0) / length  # Eq. (T22)
    entering = unlimited_supply(covered.spilled.shape)
    for edge in range(most.shape[0]):
        for i in range(most.shape[1]):
            face = int(bore.faces[edge, i])
            if face >= 0:
                entering[i, face] = most[edge, i]
    return entering


@compilable
def left(
    bore: Bore,
    covered: OilLayer,
    before: OilLayer,
    passed: LayerVolumes,
    gap: Array,
    velocity: float,
    length: float,
) -> OilLayer:
    """Return the layer at the end of a step, Eqs. (T23) to (T26), (T28).

    Parameters
    ----------
    bore : Bore
    covered, before : OilLayer
        From `covered`, and at the beginning of the step.
    passed : LayerVolumes
    gap : ndarray, shape (n_e, n_c)
        h at the edges [m].
    velocity : float
        V at the end of the step [m/s].
    length : float
        H [s].
    """
    old = _exposed(bore, before.reached)
    new = _exposed(bore, covered.reached)
    reservoir = covered.reservoir - passed.inflow  # Eq. (T23)
    oil = covered.bore.copy()
    _spill(bore, oil, passed.spilled, covered.reached)
    upward = covered.reached - before.reached
    for edge in range(reservoir.shape[0]):
        if upward * (1 - 2 * (edge % 2)) <= 0.0:
            continue  # this edge covers
        swept = np.maximum(new.beyond[edge] - old.beyond[edge], 0.0)
        uncovered = np.minimum(swept, new.between[(edge + 1) // 2])
        thickness = np.zeros((reservoir.shape[1], 1))
        for i in range(reservoir.shape[1]):
            area = bore.area[i : i + 1]
            bare = sum_of_products(uncovered[i : i + 1], area)
            if bare > 0.0:
                room = max(gap[edge, i], 0.0) * sum_of_products(swept[i : i + 1], area)
                stays = min(max(reservoir[edge, i], 0.0), room)  # Eq. (T24)
                reservoir[edge, i] -= stays
                thickness[i, 0] = stays / bare
        oil = oil + thickness * uncovered
    n_c = reservoir.shape[1]
    capacity = np.empty(n_c)
    for i in range(n_c):
        width = images(bore.cells.mirrored, i, n_c) * bore.cells.dx  # Eq. (E19)
        capacity[i] = bore.supply.chamfer_capacity * width
    fallen = np.maximum(reservoir - capacity, 0.0)  # Eq. (T25)
    reservoir = reservoir - fallen
    return OilLayer(
        bore=oil,
        reservoir=reservoir,
        spilled=passed.spilled,
        reached=covered.reached,
        height=before.height + 0.5 * length * (before.velocity + velocity),  # Eq. (T26)
        velocity=velocity,
        velocity_before=before.velocity,
        supplied=covered.supplied - sum_of_products(fallen, np.ones(fallen.shape)),
        held=_oil_volume(bore, oil, reservoir),
    )


@compilable
def inflow(bore: Bore, passed: Array) -> Array:
    """Return the volume that came in over the edges [m3], shape (n_e, n_c).

    `passed`, shape (n_c, n_a + 1), holds what passed the axial faces with ascending j.
    """
    n_e, n_c = bore.faces.shape
    flow = np.zeros((n_e, n_c))
    for edge in range(n_e):
        inward = 1.0 - 2.0 * (edge % 2)
        for i in range(n_c):
            face = int(bore.faces[edge, i])
            if face >= 0:
                flow[edge, i] = inward * passed[i, face]
    return flow


@compilable
def gaps(bore: Bore, film_thickness: Array) -> Array:
    """Return the gap at the edges [m], (n_e, n_c), from that of the cells, (n_c, n_a)."""
    n_e, n_c = bore.faces.shape
    gap = np.zeros((n_e, n_c))
    for edge in range(n_e):
        for i in range(n_c):
            face = int(bore.faces[edge, i])
            if face >= 0:
                gap[edge, i] = film_thickness[i, face - edge % 2]
    return gap


@compilable
def _spill(bore: Bore, oil: Array, spilled: Array, height: float) -> None:
    """Lay what came into openings on the bore under them, Eq. (T28); in place."""
    n_a = spilled.shape[1]
    cells = height / bore.cells.dy
    first = min(int(np.floor(cells)), bore.beyond - 1)
    upper = cells - first
    lowest = first + bore.beyond
    area = bore.area[:, :n_a]
    # Eq. (T28)
    add(oil[:, lowest : lowest + n_a], (1.0 - upper) * spilled / area)
    add(oil[:, lowest + 1 : lowest + 1 + n_a], upper * spilled / area)


@compilable
def _exposed(bore: Bore, height: float) -> ExposedShares:
    """Return the part of the bore that a skirt at `height` [m] leaves bare."""
    heights = bore.heights
    n_e, n_c, _ = heights.shape
    beyond = np.empty((n_e, n_c, bore.bottom.size))
    between = np.empty((n_e // 2 + 1, n_c, bore.bottom.size))
    for edge in range(0, n_e, 2):
        put(beyond[edge], _share((height + heights[edge] - bore.bottom) / bore.cells.dy))
        put(beyond[edge + 1], _above(bore, height, heights[edge + 1]))
    put(between[0], beyond[0])
    put(between[n_e // 2], beyond[n_e - 1])
    for edge in range(1, n_e - 1, 2):
        # an opening is at least a cell long: no cell of the bore meets both of its ends
        put(between[(edge + 1) // 2], np.minimum(beyond[edge], beyond[edge + 1]))
    return ExposedShares(beyond, between)


@compilable
def _bare(exposed: ExposedShares) -> Array:
    """Return the share of each cell of the bore that is bare, shape (n_c, n_b)."""
    bare = exposed.between[0]
    for k in range(1, exposed.between.shape[0]):
        bare = bare + exposed.between[k]
    return bare


@compilable
def _above(bore: Bore, height: float, edge: Array) -> Array:
    """Return the share of each cell of the bore above an edge of a skirt at `height` [-]."""
    dy = bore.cells.dy
    return _share((bore.bottom + dy - height - edge) / dy)


@compilable
def _share(cells: Array) -> Array:
    """Return lengths in cells, limited to 0 and 1."""
    return np.minimum(np.maximum(cells, 0.0), 1.0)
