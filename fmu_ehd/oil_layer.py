"""Oil on the bore: a layer that stays where it is, which the skirt leaves behind and meets again.

Oil on the bore moves with it, at |V| past the skirt; a film filled to f moves at |V|/2. So a layer
of thickness lambda fills a gap h to f = min(1, 2 lambda / h), and a film that leaves the skirt with
f leaves lambda = f h / 2 behind: half of the gap where it is full. What the gap does not take is
pushed along before the edge, in a reservoir at its chamfer, and goes in later. In terms of volumes,
for each row of the film and each of its axial edges:

Eq. (T21):  R <- R + (oil of the bore that the skirt has come to cover)
Eq. (T22):  S = max(R - beta F_n, 0) / H_e
Eq. (T23):  R <- R - F
Eq. (T24):  (oil of the bore that the skirt has uncovered) = min(R, w |X| h),  R <- R - that
Eq. (T25):  R <- min(R, a w)

R oil in the reservoir, S the most that sliding drags in, Eq. (E12), F = beta F_n + H_e q volume
that came into the film over the edge in the step, and F_n in the step before, `storage`; w width of
the row, X travel of the skirt in the step, h gap at the edge, a the cross-section of oil that an
edge can push along; what is more falls off. Where supply ends R is for a step negative, by at most
a third of the inflow of the last one: what the storage term still lets in.

Where the skirt is at the end of a step is known when the step begins, to second order in time:

Eq. (T26):  Y_{n+1} = Z_n + H V_n + H^2 (V_n - V_{n-1}) / (2 H_n)
           Z_{n+1} = Z_n + H (V_n + V_{n+1}) / 2

Y height of the lower edge that the layer goes by, Z the same by the trapezoidal rule, both from
where the skirt starts [m]; V mean sliding velocity of the skirt. So S is of the past alone, and in
the tangent of the film a limited inflow is a constant.

Each row i of the grid around has edges of its own: a skirt may end higher or lower there, and every
opening gives it two more. Through an opening the bore is bare; the skirt that follows takes up what
lies there, as it does outside. What pressure drives into an opening around the circumference comes
to lie on the bore under it:

Eq. (T28):  W = beta W_n + H_e w,   (oil of the bore under the opening) <- that + W

W volume that came into the opening in the step, W_n in the one before [m3], w the flow at its end
[m3/s]; a cell of the opening stands over parts of two cells of the bore.

With an oil ring the bore above the grid carries what the ring leaves there, whatever the skirt
left: the difference comes from or goes to the ring. Splash adds to the bore below the lowest edge
of a row, until the layer is as thick as the wall holds (`largest_oil_layer`): what is thrown on a
thicker one runs off. Both count as supplied, what falls off as the opposite, and what was put on
the bore between two steps (a run may set the layer to where it would stay), so that

Eq. (T27):  oil in the film + on the bore + in the reservoirs - supplied

does not change but for round-off. Within a cell of the bore (as long as one of the film) the layer
is even.

Arrays: n_b cells along the bore, from `stroke` below the start of the skirt to `stroke` above it;
n_e edges of a row from below, so lower and upper ones in turns (2 without openings). A row with
fewer edges than others has the rest above everything, where nothing happens.

What a wall holds: a film lambda thick drains by its weight with q = rho g lambda^3 / (3 mu) a width
[Nusselt1916]; q carries off a splash s over a length l of wall where

    lambda = (3 mu s l / (rho g))^(1/3)

0.30 mm for 5.6 mPa s, 850 kg/m3 and 0.1 mm/s over 0.14 m, the default. The draining itself is left
out: in a cycle at 1680 rpm (71 ms) it moves such a film by 3 mm, one of 10 um by 4 um.

References
----------
[Nusselt1916] W. Nusselt, Z. VDI 60 (1916) 541.
[Ma1997] M.-T. Ma, I. Sherrington, E. H. Smith, Analysis of lubrication and friction for a complete
piston-ring pack with an improved oil availability model, part 1, Proc. IMechE J 211 (1997) 1-15
(rings that live on the layer they meet, and oil that gathers before them).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .cavitation import NotConverged
from .grid import Array, Flags, Grid, in_plenty
from .parameters import Parameters
from .storage import EulerStep


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

    bore: Array
    reservoir: Array
    spilled: Array
    reached: float
    height: float
    velocity: float
    velocity_before: float
    supplied: float
    held: float


class Passed(NamedTuple):
    """Volumes of a step [m3]: F into the film over the edges, shape (n_e, n_c), and W, shape (n_c,
    n_a).
    """

    inflow: Array
    spilled: Array


class SkirtEdges(NamedTuple):
    """Axial edges of a skirt, one entry each.

    order : which of its row it is, from below; row : i; face : axial face of the grid;
    inward : 1 at a lower edge, -1 at an upper one.
    """

    order: NDArray[np.intp]
    row: NDArray[np.intp]
    face: NDArray[np.intp]
    inward: NDArray[np.intp]


def skirt_edges(open_cells: Flags) -> SkirtEdges:
    """Edges of a skirt with cut-outs, ndarray of bool of shape (n_c, n_a)."""
    film = np.pad(~open_cells, ((0, 0), (1, 1))).astype(int)
    inward = np.diff(film, axis=1)
    row, face = np.nonzero(inward)
    order = np.cumsum(inward != 0, axis=1)[row, face] - 1
    return SkirtEdges(order, row, face, inward[row, face])


class Exposed(NamedTuple):
    """Shares of the cells of the bore [-].

    beyond : ndarray, shape (n_e, n_c, n_b), below a lower edge, above an upper one;
    between : ndarray, shape (n_e/2 + 1, n_c, n_b), bare below the first edge, between two parts of
    the skirt, above the last one.
    """

    beyond: Array
    between: Array

    def beside(self, edge: int) -> Array:
        """What is bare beside an edge of that order, shape (n_c, n_b)."""
        return self.between[(edge + 1) // 2]


class Bore:
    """The bore that a skirt slides on.

    Parameters
    ----------
    parameters : Parameters
    grid : grid.Grid
        Of the film.
    """

    def __init__(self, parameters: Parameters, grid: Grid):
        self.parameters = parameters
        self.cells = grid.cells
        self.cell_area = grid.cell_area
        n_c, n_a = self._film = grid.shape
        self._length = n_a * grid.cells.dy
        self._beyond = int(np.ceil(parameters.stroke / grid.cells.dy))
        self._bottom = (np.arange(n_a + 2 * self._beyond) - self._beyond) * grid.cells.dy
        self._shape = (n_c, len(self._bottom))
        openings = parameters.open_cells
        self.edges = skirt_edges(np.zeros(grid.shape, dtype=bool) if openings is None else openings)
        order, row, face, _ = self.edges
        self._reservoirs = (2 * int((order // 2).max(initial=0) + 1), n_c)
        self._heights = np.full((*self._reservoirs, 1), np.inf)
        self._heights[order, row, 0] = face * grid.cells.dy

    def start(self, velocity: float) -> OilLayer:
        """An even layer where the bore is bare, and nothing at the edges.

        Parameters
        ----------
        velocity : float
            V [m/s].
        """
        layer = self.parameters.initial_oil_layer * self._exposed(0.0).between.sum(axis=0)
        nothing = np.zeros(self._reservoirs)
        held = float(layer.sum() * self.cell_area)
        return OilLayer(
            layer, nothing, np.zeros(self._film), 0.0, 0.0, velocity, velocity, 0.0, held
        )

    def volume(self, layer: OilLayer) -> float:
        """Oil on the bore and at the edges of the skirt [m3]."""
        return float(layer.bore.sum() * self.cell_area + layer.reservoir.sum())

    def covered(
        self, layer: OilLayer, step: float, step_before: float, ring: float, splash: float
    ) -> OilLayer:
        """The layer after the skirt has moved on and taken up what it covers, before the film has
        taken any, Eqs. (T21), (T26).

        Parameters
        ----------
        layer : OilLayer
            At the beginning of the step.
        step, step_before : float
            H, H_n [s]; H_n = 0 where there was no step before.
        ring : float
            Layer that the oil ring leaves above the skirt [m].
        splash : float
            Growth of the layer below the skirt [m/s].

        Raises
        ------
        cavitation.NotConverged
            If the skirt moves farther than `stroke`.
        """
        change = layer.velocity - layer.velocity_before
        gain = 0.5 * step * change * step / step_before if step_before > 0.0 else 0.0
        reached = layer.height + step * layer.velocity + gain  # Eq. (T26)
        if abs(reached) > self.parameters.stroke:
            raise NotConverged(
                f"the skirt comes to {reached:g} m from where it started, farther than stroke = "
                f"{self.parameters.stroke:g} m"
            )
        old = self._exposed(layer.reached)
        new = self._exposed(reached)
        bare = old.between.sum(axis=0)
        whole = np.where(bare > 0.0, bare, 1.0)
        below = old.between[0]
        room = np.maximum(self.parameters.largest_oil_layer * below - layer.bore, 0.0)
        supply = np.minimum(splash * step * below, room)
        if self.parameters.oil_supply == "bore_and_ring":
            above = self._above(layer.reached, self._length)
            scraped = layer.bore * (above / whole)
            supply = supply + np.where(above > 0.0, ring * above - scraped, 0.0)
        bore = layer.bore + supply
        reservoir = layer.reservoir.copy()
        for edge in range(len(reservoir)):
            swept = np.maximum(old.beyond[edge] - new.beyond[edge], 0.0)
            taken = bore * (np.minimum(swept, old.beside(edge)) / whole)
            bore = bore - taken
            reservoir[edge] += taken.sum(axis=1) * self.cell_area  # Eq. (T21)
        return layer._replace(
            bore=bore,
            reservoir=reservoir,
            reached=reached,
            supplied=layer.supplied
            + supply.sum() * self.cell_area
            + (self.volume(layer) - layer.held),
        )

    def limit(self, covered: OilLayer, carried: Array, begin: EulerStep) -> Array:
        """Most that sliding can drag in over the axial faces, Eq. (T22).

        Parameters
        ----------
        covered : OilLayer
            From `covered`.
        carried : ndarray, shape (n_e, n_c)
            beta F_n [m3].
        begin : storage.EulerStep

        Returns
        -------
        ndarray, shape (n_c, n_a + 1)
            S [m3/s], inf at faces that are no edge.
        """
        most = np.maximum(covered.reservoir - carried, 0.0) / begin.length  # Eq. (T22)
        order, row, face, _ = self.edges
        limit = in_plenty(self._film)
        limit[row, face] = most[order, row]
        return limit

    def left(
        self,
        covered: OilLayer,
        before: OilLayer,
        passed: Passed,
        gap: Array,
        velocity: float,
        step: float,
    ) -> OilLayer:
        """The layer at the end of a step, Eqs. (T23) to (T26), (T28).

        Parameters
        ----------
        covered, before : OilLayer
            From `covered`, and at the beginning of the step.
        passed : Passed
        gap : ndarray, shape (n_e, n_c)
            h at the edges [m].
        velocity : float
            V at the end of the step [m/s].
        step : float
            H [s].
        """
        old = self._exposed(before.reached)
        new = self._exposed(covered.reached)
        reservoir = covered.reservoir - passed.inflow  # Eq. (T23)
        bore = covered.bore.copy()
        self._spill(bore, passed.spilled, covered.reached)
        for edge in range(len(reservoir)):
            swept = np.maximum(new.beyond[edge] - old.beyond[edge], 0.0)
            if not swept.any():
                continue
            room = np.maximum(gap[edge], 0.0) * swept.sum(axis=1) * self.cell_area
            uncovered = np.minimum(swept, new.beside(edge))
            length = uncovered.sum(axis=1)
            volume = np.where(length > 0.0, np.clip(reservoir[edge], 0.0, room), 0.0)  # Eq. (T24)
            reservoir[edge] -= volume
            thickness = volume / (np.where(length > 0.0, length, 1.0) * self.cell_area)
            bore += thickness[:, None] * uncovered
        capacity = self.parameters.chamfer_capacity * self.cells.dx
        fallen = np.maximum(reservoir - capacity, 0.0)  # Eq. (T25)
        left = reservoir - fallen
        return OilLayer(
            bore,
            left,
            passed.spilled,
            covered.reached,
            before.height + 0.5 * step * (before.velocity + velocity),  # Eq. (T26)
            velocity,
            before.velocity,
            covered.supplied - fallen.sum(),
            float(bore.sum() * self.cell_area + left.sum()),
        )

    def inflow(self, passed: Array) -> Array:
        """Volume that came in over the edges [m3], shape (n_e, n_c), from what passed the axial
        faces with ascending j, shape (n_c, n_a + 1).
        """
        order, row, face, inward = self.edges
        inflow = np.zeros(self._reservoirs)
        inflow[order, row] = inward * passed[row, face]
        return inflow

    def gaps(self, film_thickness: Array) -> Array:
        """Gap at the edges [m], shape (n_e, n_c), from that of the cells, shape (n_c, n_a)."""
        order, row, face, inward = self.edges
        gaps = np.zeros(self._reservoirs)
        gaps[order, row] = film_thickness[row, np.where(inward > 0, face, face - 1)]
        return gaps

    def _spill(self, bore: Array, spilled: Array, height: float) -> None:
        """Lay what came into openings on the bore under them, Eq. (T28); in place."""
        _, n_a = self._film
        cells = height / self.cells.dy
        first = min(int(np.floor(cells)), self._beyond - 1)
        upper = cells - first
        lowest = first + self._beyond
        # Eq. (T28)
        bore[:, lowest : lowest + n_a] += (1.0 - upper) * spilled / self.cell_area
        bore[:, lowest + 1 : lowest + 1 + n_a] += upper * spilled / self.cell_area

    def _exposed(self, height: float) -> Exposed:
        """What a skirt at `height` [m] leaves bare."""
        lower = self._heights[0::2]
        upper = self._heights[1::2]
        below = _share((height + lower - self._bottom) / self.cells.dy)
        above = self._above(height, upper)
        beyond = np.stack([below, above], axis=1).reshape(-1, *self._shape)
        # an opening is at least a cell long: no cell of the bore meets both of its ends
        windows = np.minimum(above[:-1], below[1:])
        return Exposed(beyond, np.concatenate([below[:1], windows, above[-1:]]))

    def _above(self, height: float, edge: Array | float) -> Array:
        """Share of each cell of the bore above an edge of a skirt at `height` [-]."""
        dy = self.cells.dy
        return _share((self._bottom + dy - height - edge) / dy)


def _share(cells: NDArray[np.floating]) -> Array:
    """Lengths in cells, bounded to a share of one."""
    return np.minimum(np.maximum(cells, 0.0), 1.0)
