"""Oil on the bore: a layer that stays where it is, which the skirt leaves behind and meets again.

Oil on the bore moves with it, at |V| past the skirt; a film filled to f moves at |V|/2. So a layer
of thickness lambda fills a gap h to f = min(1, 2 lambda / h), and a film that leaves the skirt with
f leaves lambda = f h / 2 behind: half of the gap where it is full. What the gap does not take is
pushed along before the edge, in a reservoir at its chamfer, and goes in later. In terms of volumes,
for each row of the film and each of its two axial edges:

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

With an oil ring the bore above the skirt carries what the ring leaves there, whatever the skirt
left: the difference comes from or goes to the ring. Splash adds to the bore below the skirt. Both
count as supplied, what falls off as the opposite, so that

Eq. (T27):  oil in the film + on the bore + in the reservoirs - supplied

does not change but for round-off. Within a cell of the bore (as long as one of the film) the layer
is even.

Arrays: n_b cells along the bore, from `stroke` below the start of the skirt to `stroke` above it;
sides in the order LOWER, UPPER.

References
----------
[Ma1997] M.-T. Ma, I. Sherrington, E. H. Smith, Analysis of lubrication and friction for a complete
piston-ring pack with an improved oil availability model, part 1, Proc. IMechE J 211 (1997) 1-15
(rings that live on the layer they meet, and oil that gathers before them).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .cavitation import NotConverged
from .grid import LOWER, UPPER, Array, Grid
from .parameters import Parameters
from .storage import EulerStep


class OilLayer(NamedTuple):
    """Oil outside the film.

    bore : ndarray, shape (n_c, n_b)
        Oil on the bore, volume over the area of a cell [m]; 0 under the skirt.
    reservoir : ndarray, shape (2, n_c)
        R [m3].
    reached, height : float
        Y, Z [m].
    velocity, velocity_before : float
        V_n, V_{n-1} [m/s].
    supplied : float
        Volume that came from outside since the start [m3].
    """

    bore: Array
    reservoir: Array
    reached: float
    height: float
    velocity: float
    velocity_before: float
    supplied: float


class Exposed(NamedTuple):
    """Share of each cell of the bore below the skirt and above it [-], ndarray of shape (n_b,)."""

    below: Array
    above: Array


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
        n_c, n_a = grid.shape
        self._length = n_a * grid.cells.dy
        beyond = int(np.ceil(parameters.stroke / grid.cells.dy))
        self._bottom = (np.arange(n_a + 2 * beyond) - beyond) * grid.cells.dy
        self._shape = (n_c, len(self._bottom))

    def start(self, velocity: float) -> OilLayer:
        """An even layer outside the skirt, and nothing at its edges.

        Parameters
        ----------
        velocity : float
            V [m/s].
        """
        below, above = self._exposed(0.0)
        layer = self.parameters.initial_oil_layer * np.broadcast_to(below + above, self._shape)
        return OilLayer(layer, np.zeros((2, self._shape[0])), 0.0, 0.0, velocity, velocity, 0.0)

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
        supply = splash * step * old.below
        if self.parameters.oil_supply == "bore_and_ring":
            supply = supply + np.where(old.above > 0.0, ring * old.above - layer.bore, 0.0)
        supply = np.broadcast_to(supply, self._shape)
        bore = layer.bore + supply
        reservoir = layer.reservoir.copy()
        for side in (LOWER, UPPER):
            taken = bore * _shrinkage(old[side], new[side])
            bore = bore - taken
            reservoir[side] += taken.sum(axis=1) * self.cell_area  # Eq. (T21)
        return layer._replace(
            bore=bore,
            reservoir=reservoir,
            reached=reached,
            supplied=layer.supplied + supply.sum() * self.cell_area,
        )

    @staticmethod
    def limit(covered: OilLayer, carried: Array, begin: EulerStep) -> Array:
        """Most that sliding can drag in over both edges, Eq. (T22).

        Parameters
        ----------
        covered : OilLayer
            From `covered`.
        carried : ndarray, shape (2, n_c)
            beta F_n [m3].
        begin : storage.EulerStep

        Returns
        -------
        ndarray, shape (2, n_c)
            S [m3/s].
        """
        return np.maximum(covered.reservoir - carried, 0.0) / begin.length  # Eq. (T22)

    def left(
        self,
        covered: OilLayer,
        before: OilLayer,
        inflow: Array,
        gap: Array,
        velocity: float,
        step: float,
    ) -> OilLayer:
        """The layer at the end of a step, Eqs. (T23) to (T26).

        Parameters
        ----------
        covered, before : OilLayer
            From `covered`, and at the beginning of the step.
        inflow, gap : ndarray, shape (2, n_c)
            F [m3], and h at the edges [m].
        velocity : float
            V at the end of the step [m/s].
        step : float
            H [s].
        """
        old = self._exposed(before.reached)
        new = self._exposed(covered.reached)
        reservoir = covered.reservoir - inflow  # Eq. (T23)
        bore = covered.bore
        for side in (LOWER, UPPER):
            uncovered = np.maximum(new[side] - old[side], 0.0)
            room = np.maximum(gap[side], 0.0) * uncovered.sum() * self.cell_area
            volume = np.clip(reservoir[side], 0.0, room)  # Eq. (T24)
            reservoir[side] -= volume
            if uncovered.any():
                thickness = volume / (uncovered.sum() * self.cell_area)
                bore = bore + thickness[:, None] * uncovered
        capacity = self.parameters.chamfer_capacity * self.cells.dx
        fallen = np.maximum(reservoir - capacity, 0.0)  # Eq. (T25)
        return OilLayer(
            bore,
            reservoir - fallen,
            covered.reached,
            before.height + 0.5 * step * (before.velocity + velocity),  # Eq. (T26)
            velocity,
            before.velocity,
            covered.supplied - fallen.sum(),
        )

    def _exposed(self, height: float) -> Exposed:
        """What a skirt at `height` [m] leaves uncovered."""
        dy = self.cells.dy
        below = (height - self._bottom) / dy
        above = (self._bottom + dy - height - self._length) / dy
        return Exposed(_share(below), _share(above))


def edge_gaps(film_thickness: Array) -> Array:
    """Gap at both edges [m], shape (2, n_c), from that of the cells, shape (n_c, n_a)."""
    return film_thickness[:, [0, -1]].T


def edge_inflow(passed: Array) -> Array:
    """Volume that came in over both edges [m3], shape (2, n_c), from what passed the axial faces
    with ascending j, shape (n_c, n_a + 1).
    """
    return np.stack([passed[:, 0], -passed[:, -1]])


def _share(cells: NDArray[np.floating]) -> Array:
    """Lengths in cells, bounded to a share of one."""
    return np.minimum(np.maximum(cells, 0.0), 1.0)


def _shrinkage(old: Array, new: Array) -> Array:
    """Share of what was exposed that is covered now [-]."""
    return np.maximum(old - new, 0.0) / np.where(old > 0.0, old, 1.0)
